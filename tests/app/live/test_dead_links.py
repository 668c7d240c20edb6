"""A link that was dead for long stays a worry, whatever comes back; a hiccup of a network is none."""

from typing import Any

import pytest

from app.gateway import DeviceStream
from app.live import housekeeping
from tests.app.live.streams.test_closing import (
    ENDED,
    hello,
    new_session,
    receive_until,
    stream,
    wait_for_state,
)

__all__ = ["stream"]


def worry(client: Any, patient_id: str) -> Any:
    rows = client.get("/api/caseload").json()
    return next(one for one in rows if one["patient_id"] == patient_id)["worry"]


def send(
    client: Any, session_id: str, stream: DeviceStream, numbers: range, *, is_last: bool = False
) -> None:
    """Send packets; the connection then ends, without a goodbye unless these are the last ones."""
    with client.websocket_connect("/ws/ingest") as socket:
        socket.send_text(hello(client, session_id, stream))
        for number in numbers:
            socket.send_bytes(stream.packet(number))
        receive_until(socket, lambda message: message.get("highest") == numbers[-1])
        if is_last:
            socket.send_text(f'{{"type": "goodbye", "last_sequence": {numbers[-1]}}}')
            receive_until(socket, lambda message: message.get("state") == "closing")


@pytest.mark.parametrize(("dead_after_s", "is_worry"), [(0.1, True), (600.0, False)])
def test_a_dead_link_is_a_worry_and_a_hiccup_is_none(
    therapist: Any,
    world: Any,
    stream: DeviceStream,
    monkeypatch: pytest.MonkeyPatch,
    dead_after_s: float,
    is_worry: bool,
) -> None:
    monkeypatch.setattr(housekeeping, "DEAD_LINK_AFTER_S", dead_after_s)
    looked = housekeeping.Housekeeping._look_after
    lost: list[str] = []

    def look_after(self: Any, session: Any, is_thorough: bool) -> None:
        looked(self, session, is_thorough)
        lost.append(session.state)

    monkeypatch.setattr(housekeeping.Housekeeping, "_look_after", look_after)
    session_id = new_session(therapist, world.patient_id, stream)
    send(therapist, session_id, stream, range(3))
    lost.clear()
    wait_for_state(therapist, session_id, {"link_lost"})
    while lost.count("link_lost") < 3:
        wait_for_state(therapist, session_id, {"link_lost"})
    send(therapist, session_id, stream, range(3, 6), is_last=True)
    wait_for_state(therapist, session_id, ENDED)
    found = worry(therapist, world.patient_id)
    assert (found is not None) is is_worry
    if is_worry:
        assert (found["kind"], found["session_id"]) == ("link_lost", session_id)
        assert found["sentences"]["text"]["code"] == "caseload.dead_link"
        events = therapist.get(f"/api/sessions/{session_id}").json()["events"]
        assert [one["kind"] for one in events].count("link_lost") == 1
