"""How a session ends when its end meets something else: a broken link, a hello, a failing store."""

import json
import threading
import time
from collections.abc import Callable
from typing import Any

import pytest
from sqlalchemy import Engine

from app.gateway import DeviceStream, stream_of
from app.live import manager as live_manager
from app.live import repository
from app.live.manager import LiveManager
from app.network.packet import PacketFlag, with_flags
from app.recordings.signals.store import read_packets
from estimators.simulation import ArmScenario, Schedule, simulate_arm
from tests.patience import PATIENCE_S

ENDED = {"closing", "analysed"}


@pytest.fixture(scope="module")
def stream() -> DeviceStream:
    scenario = ArmScenario(schedule=Schedule(n_pose_s=4.0, repetitions=1), seed=7)
    return stream_of(simulate_arm(scenario).recording)


def new_session(client: Any, patient_id: str, stream: DeviceStream) -> str:
    answer = client.post(
        "/api/sessions", json={"patient_id": patient_id, "placements": list(stream.placements)}
    )
    return str(answer.json()["id"])


def hello(client: Any, session_id: str, stream: DeviceStream) -> str:
    ticket = client.post(f"/api/sessions/{session_id}/ticket", json={"purpose": "ingest"}).json()["ticket"]
    return stream.hello(ticket).model_dump_json(exclude_none=True)


def receive_until(socket: Any, wanted: Callable[[dict[str, Any]], bool]) -> None:
    deadline = time.monotonic() + PATIENCE_S
    while time.monotonic() < deadline:
        if wanted(json.loads(socket.receive_text())):
            return
    raise TimeoutError


def state_of(client: Any, session_id: str) -> str:
    return str(client.get(f"/api/sessions/{session_id}/state").json()["state"])


def wait_for_state(client: Any, session_id: str, wanted: set[str]) -> str:
    deadline = time.monotonic() + PATIENCE_S
    while (state := state_of(client, session_id)) not in wanted:
        if time.monotonic() > deadline:
            raise TimeoutError(f"{state} instead of {wanted}")
        time.sleep(0.1)
    return state


def test_a_link_that_breaks_after_the_goodbye_may_come_back_with_the_rest(
    therapist: Any, world: Any, stream: DeviceStream, engine: Engine
) -> None:
    session_id = new_session(therapist, world.patient_id, stream)
    with therapist.websocket_connect("/ws/ingest") as socket:
        socket.send_text(hello(therapist, session_id, stream))
        for number in (0, 1, 2, 5):
            socket.send_bytes(stream.packet(number))
        receive_until(socket, lambda message: message.get("highest") == 5)
        socket.send_text('{"type": "goodbye", "last_sequence": 7}')
    time.sleep(1.0)
    assert state_of(therapist, session_id) == "link_lost"
    with therapist.websocket_connect("/ws/ingest") as socket:
        socket.send_text(hello(therapist, session_id, stream))
        for number in (3, 4, 6, 7):
            socket.send_bytes(with_flags(stream.packet(number), PacketFlag.BACKFILLED))
        socket.send_text('{"type": "goodbye", "last_sequence": 7}')
        receive_until(socket, lambda message: message.get("state") == "closing")
    wait_for_state(therapist, session_id, ENDED)
    assert sorted(packet.sequence for packet in read_packets(engine, session_id)) == list(range(8))


def test_closing_waits_for_a_hello_that_is_opening_the_session(
    therapist: Any, world: Any, stream: DeviceStream, monkeypatch: pytest.MonkeyPatch, new_client: Any
) -> None:
    session_id = new_session(therapist, world.patient_id, stream)
    begin = repository.begin_stream
    is_opening, may_open = threading.Event(), threading.Event()

    def slow_begin(*arguments: Any) -> Any:
        is_opening.set()
        may_open.wait(PATIENCE_S)
        return begin(*arguments)

    monkeypatch.setattr(live_manager.repository, "begin_stream", slow_begin)
    with therapist.websocket_connect("/ws/ingest") as socket:
        socket.send_text(hello(therapist, session_id, stream))
        assert is_opening.wait(PATIENCE_S)
        answers: list[str] = []
        closing = threading.Thread(
            target=lambda: answers.append(therapist.post(f"/api/sessions/{session_id}/close").json()["state"])
        )
        closing.start()
        time.sleep(0.3)
        assert not answers, "the close must wait until the hello has opened the session"
        may_open.set()
        closing.join(30)
    assert answers[0] in ENDED
    wait_for_state(therapist, session_id, ENDED)
    with therapist.websocket_connect("/ws/ingest") as socket:
        socket.send_text(hello(therapist, session_id, stream))
        receive_until(socket, lambda message: message["type"] == "error" and message["closing"])


def test_a_session_whose_end_fails_is_told_so_and_keeps_what_came(
    therapist: Any, world: Any, stream: DeviceStream, engine: Engine, monkeypatch: pytest.MonkeyPatch
) -> None:
    session_id = new_session(therapist, world.patient_id, stream)

    def broken(*arguments: Any) -> None:
        raise OSError("made to fail")

    monkeypatch.setattr(live_manager.repository, "finish_stream", broken)
    with therapist.websocket_connect("/ws/ingest") as socket:
        socket.send_text(hello(therapist, session_id, stream))
        for number in range(4):
            socket.send_bytes(stream.packet(number))
        receive_until(socket, lambda message: message.get("acknowledged") == 3)
        therapist.post(f"/api/sessions/{session_id}/close")
        assert wait_for_state(therapist, session_id, {"failed"}) == "failed"
    found = therapist.get(f"/api/sessions/{session_id}/state").json()
    assert "what is stored is safe" in found["reason"]
    assert len(list(read_packets(engine, session_id))) == 4


def test_a_goodbye_that_no_sequence_can_have_is_refused_and_harms_nothing(
    therapist: Any, world: Any, stream: DeviceStream, engine: Engine
) -> None:
    session_id = new_session(therapist, world.patient_id, stream)
    with therapist.websocket_connect("/ws/ingest") as socket:
        socket.send_text(hello(therapist, session_id, stream))
        for number in range(4):
            socket.send_bytes(stream.packet(number))
        for wrong in (10**30, 1 << 62, -2, 1.5, "seven"):
            socket.send_text(json.dumps({"type": "goodbye", "last_sequence": wrong}))
            receive_until(
                socket,
                lambda message: message["type"] == "error" and "last_sequence" in message["message"],
            )
        for number in range(4, 8):
            socket.send_bytes(stream.packet(number))
        receive_until(socket, lambda message: message.get("acknowledged") == 7)
        socket.send_text('{"type": "goodbye", "last_sequence": 7}')
        receive_until(socket, lambda message: message.get("state") == "closing")
    assert wait_for_state(therapist, session_id, {*ENDED, "failed"}) in ENDED
    assert sorted(packet.sequence for packet in read_packets(engine, session_id)) == list(range(8))


@pytest.mark.slow
def test_a_goodbye_far_beyond_what_came_still_ends(
    therapist: Any, world: Any, stream: DeviceStream, engine: Engine
) -> None:
    """As large as a sequence may be: what is missing is a range and a number, not a list of packets."""
    session_id = new_session(therapist, world.patient_id, stream)
    with therapist.websocket_connect("/ws/ingest") as socket:
        socket.send_text(hello(therapist, session_id, stream))
        for number in range(4):
            socket.send_bytes(stream.packet(number))
        receive_until(socket, lambda message: message.get("acknowledged") == 3)
        socket.send_text(json.dumps({"type": "goodbye", "last_sequence": (1 << 62) - 1}))
        assert therapist.post(f"/api/sessions/{session_id}/close").status_code < 300
    assert wait_for_state(therapist, session_id, {"analysed", "failed"}) == "analysed"
    found = therapist.get(f"/api/sessions/{session_id}")
    assert (found.status_code, found.json()["packets_stored"]) == (200, 4)


def test_a_session_beyond_the_longest_is_closed_with_the_reason(
    therapist: Any, world: Any, stream: DeviceStream, services: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    long, short = (new_session(therapist, one, stream) for one in (world.patient_id, world.other_patient_id))
    packets = [stream.packet(number) for number in range(30)]
    with (
        therapist.websocket_connect("/ws/ingest") as socket,
        therapist.websocket_connect("/ws/ingest") as other,
    ):
        socket.send_text(hello(therapist, long, stream))
        other.send_text(hello(therapist, short, stream))
        for packet in packets:
            socket.send_bytes(packet)
        other.send_bytes(packets[0])
        receive_until(socket, lambda message: message.get("acknowledged") == 29)
        receive_until(other, lambda message: message.get("acknowledged") == 0)
        # Between the length of the two.
        monkeypatch.setattr(services.get(LiveManager)._housekeeping, "_longest_s", 1.0)
        receive_until(socket, lambda message: message.get("state") == "closing")
        found = therapist.get(f"/api/sessions/{long}/state").json()
        assert found["state"] in ENDED
        assert found["reason"].startswith("Ended automatically: the session reached the longest time allowed")
        assert state_of(therapist, short) not in ENDED


def test_the_longest_time_is_the_setting(services: Any) -> None:
    limit_s = 3600.0 * services.settings.session_limit_hours
    assert services.get(LiveManager)._housekeeping._longest_s == limit_s
