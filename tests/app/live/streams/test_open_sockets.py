"""What becomes of a socket that is open: it ends with the browser session, and a slow check holds up nothing."""

import asyncio
import json
from collections.abc import Callable
from typing import Any

import pytest

from app.gateway import DeviceStream, stream_of
from app.live.manager import LiveManager
from app.live.service import CHECK_AT_LEAST_EVERY_S, CHECK_EVERY_S
from app.services import Services
from estimators.simulation import ArmScenario, Schedule, simulate_arm

from ...conftest import PASSWORD
from .test_live_failures import hello, new_session, receive_until


@pytest.fixture(scope="module")
def stream() -> DeviceStream:
    return stream_of(simulate_arm(ArmScenario(schedule=Schedule(n_pose_s=5.0, repetitions=1))).recording)


@pytest.mark.parametrize(
    "headers", [{}, {"Authorization": "Bearer"}], ids=["a browser", "a header without a token"]
)
def test_a_view_that_the_cookie_opened_ends_with_the_browser_session(
    headers: dict[str, str],
    therapist: Any,
    world: Any,
    stream: DeviceStream,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("app.live.service.CHECK_EVERY_S", 0.1)
    session_id = new_session(therapist, world.patient_id, stream)
    with therapist.websocket_connect(f"/ws/live/{session_id}", headers=headers) as page:
        receive_until(page, lambda message: message["type"] == "state")
        assert therapist.post("/api/sign-out").status_code == 204
        told = receive_until(page, lambda message: message["type"] == "error")
        assert (told["code"], told["closing"]) == ("sign_in_required", True)


def end_by_sign_out(browser: Any, other: Any) -> None:
    assert browser.post("/api/sign-out").status_code == 204


def end_by_a_new_password(browser: Any, other: Any) -> None:
    body = {"old_password": PASSWORD, "new_password": "quite another one, 77"}
    assert other.post("/api/me/password", json=body).status_code == 204


@pytest.mark.parametrize("end", [end_by_sign_out, end_by_a_new_password])
@pytest.mark.parametrize("what", ["view", "gateway"])
def test_what_a_ticket_opened_ends_with_the_browser_session_that_asked_for_it(
    what: str,
    end: Callable[[Any, Any], None],
    sign_in: Callable[[str], Any],
    nobody: Any,
    world: Any,
    stream: DeviceStream,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("app.live.service.CHECK_EVERY_S", 0.1)
    stolen, own = sign_in("therapist"), sign_in("therapist")
    session_id = new_session(own, world.patient_id, stream)
    for browser, ends in ((own, False), (stolen, True)):
        if what == "view":
            ticket = browser.post(f"/api/sessions/{session_id}/ticket", json={"purpose": "live"}).json()[
                "ticket"
            ]
            address, first = f"/ws/live/{session_id}", json.dumps({"ticket": ticket})
        else:
            address, first = "/ws/ingest", hello(browser, session_id, stream)
        with nobody.websocket_connect(address) as socket:
            socket.send_text(first)
            receive_until(socket, lambda message: message["type"] in {"state", "acknowledge"})
            if ends:
                end(browser, own)
                told = receive_until(socket, lambda message: message["type"] == "error")
                assert (told["code"], told["closing"]) == ("sign_in_required", True)


def test_a_session_without_a_gateway_has_a_pulse(therapist: Any, world: Any, stream: DeviceStream) -> None:
    """Nothing else is said of it: without a pulse a page could not tell silence from a network that went away."""
    session_id = new_session(therapist, world.patient_id, stream)
    with therapist.websocket_connect(f"/ws/live/{session_id}") as page:
        assert [page.receive_json()["type"] for _ in range(4)] == ["layout", "state", "pulse", "pulse"]


def test_a_check_that_takes_its_time_holds_up_no_acknowledgement(
    therapist: Any, world: Any, stream: DeviceStream, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = []

    async def never(_side: LiveManager, question: Any) -> None:
        asked.append(question)
        await asyncio.Event().wait()

    monkeypatch.setattr("app.live.service.CHECK_EVERY_S", 0.0)
    monkeypatch.setattr(LiveManager, "check_right", never)
    session_id = new_session(therapist, world.patient_id, stream)
    with therapist.websocket_connect("/ws/ingest") as gateway:
        gateway.send_text(hello(therapist, session_id, stream))
        receive_until(gateway, lambda message: message["type"] == "acknowledge")
        for number in range(10):
            gateway.send_bytes(stream.packet(number))
        receive_until(gateway, lambda message: message.get("acknowledged") == 9)
    assert asked


def test_rights_are_checked_less_often_where_their_checks_would_take_too_much(
    therapist: Any, services: Services, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Many that are asked together count as many as those that are asked alone."""
    live = services.get(LiveManager)

    def every_s(sessions: int) -> float:
        monkeypatch.setattr(LiveManager, "session_count", property(lambda _: sessions))
        return live.check_every_s + live._gather_s

    for _ in range(5):
        live._note_cost(0.002, 1)
        live._note_cost(100 * 0.0001, 100)
    assert live._check_cost_s == pytest.approx(0.0001, rel=1e-3)
    assert every_s(10) == CHECK_EVERY_S
    assert every_s(1000) == pytest.approx(2 * 1000 * 0.0001 / 0.02, rel=1e-3)
    assert every_s(100_000) == CHECK_AT_LEAST_EVERY_S
