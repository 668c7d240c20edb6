"""One session's trouble is its own: in the process, with the parts that fail made to fail."""

import asyncio
import json
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from sqlalchemy import Engine, select, update

from app.database.unit_of_work import read_only, unit_of_work
from app.errors import Conflict
from app.gateway import DeviceStream, stream_of
from app.live import manager as live_manager
from app.live import repository, warmup
from app.live.bus import MemoryBus
from app.live.manager import LiveManager
from app.live.session import opening
from app.recordings.models import DEAD_LINK, MotionSession, SessionEvent
from app.recordings.signals.group_commit import GroupCommitWriter
from app.recordings.signals.store import read_packets
from app.services import Services
from estimators import pipelines
from estimators.simulation import ArmScenario, Schedule, simulate_arm
from tests.patience import PATIENCE_S


@pytest.fixture(scope="module")
def stream() -> DeviceStream:
    scenario = ArmScenario(schedule=Schedule(n_pose_s=10.0, repetitions=1), seed=6)
    return stream_of(simulate_arm(scenario).recording)


def new_session(client: Any, patient_id: str, stream: DeviceStream) -> str:
    answer = client.post(
        "/api/sessions", json={"patient_id": patient_id, "placements": list(stream.placements)}
    )
    assert answer.is_success, answer.text
    return str(answer.json()["id"])


def hello(client: Any, session_id: str, stream: DeviceStream) -> str:
    ticket = client.post(f"/api/sessions/{session_id}/ticket", json={"purpose": "ingest"}).json()["ticket"]
    return stream.hello(ticket).model_dump_json(exclude_none=True)


def receive_until(socket: Any, wanted: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
    deadline = time.monotonic() + PATIENCE_S
    while time.monotonic() < deadline:
        message = json.loads(socket.receive_text())
        if wanted(message):
            return message
    raise TimeoutError


@pytest.fixture
def failing_pipelines(monkeypatch: pytest.MonkeyPatch) -> dict[str, int]:
    """Pipelines whose step raises from a tick on, for sessions whose setup has the rate key given here."""
    fail_from: dict[str, int] = {}
    create = pipelines.create

    def create_failing(setup: pipelines.SessionSetup) -> pipelines.Pipeline:
        made = create(setup)
        step = made.step

        def failing(chunk: Any) -> Any:
            if chunk.first_tick >= fail_from.get("tick", 1 << 60):
                raise FloatingPointError("made to fail")
            return step(chunk)

        made.step = failing  # type: ignore[method-assign]
        return made

    monkeypatch.setattr(opening.pipelines, "create", create_failing)
    return fail_from


def test_a_failed_estimation_keeps_storing_and_leaves_the_others_alone(
    therapist: Any, world: Any, stream: DeviceStream, engine: Engine, failing_pipelines: dict[str, int]
) -> None:
    broken = new_session(therapist, world.patient_id, stream)
    sound = new_session(therapist, world.other_patient_id, stream)
    failing_pipelines["tick"] = 20
    with therapist.websocket_connect("/ws/ingest") as socket:
        socket.send_text(hello(therapist, broken, stream))
        receive_until(socket, lambda message: message["type"] == "acknowledge")
        del failing_pipelines["tick"]
        with therapist.websocket_connect("/ws/ingest") as neighbour:
            neighbour.send_text(hello(therapist, sound, stream))
            failing_pipelines["tick"] = 20
            for number in range(10):
                socket.send_bytes(stream.packet(number))
            del failing_pipelines["tick"]
            receive_until(socket, lambda message: message.get("acknowledged") == 9)
            for number in range(10):
                neighbour.send_bytes(stream.packet(number))
            receive_until(neighbour, lambda message: message.get("acknowledged") == 9)
        state = therapist.get(f"/api/sessions/{broken}/state").json()
        assert state["state"] == "failed"
        assert "analysed afterwards" in state["reason"]
        assert therapist.get(f"/api/sessions/{sound}/state").json()["state"] == "link_lost"
        socket.send_text(json.dumps({"type": "goodbye", "last_sequence": 9}))
        receive_until(socket, lambda message: message.get("state") == "closing")
    assert [packet.sequence for packet in read_packets(engine, broken)] == list(range(10))
    found = therapist.get(f"/api/sessions/{broken}").json()
    assert "error" in {event["kind"] for event in found["events"]}


@pytest.mark.parametrize(
    ("check_every_s", "is_told"),
    [
        # The right is checked at a random moment within this time: practically never before the store fails ...
        (1e6, lambda message: message.get("state") == "failed"),
        # ... or at once: then the gateway is told that there is no such session.
        (0.0, lambda message: message["type"] == "error" and message["closing"]),
    ],
    ids=["store", "right"],
)
def test_a_session_that_is_erased_while_it_streams_harms_nobody(
    therapist: Any,
    world: Any,
    stream: DeviceStream,
    engine: Engine,
    monkeypatch: pytest.MonkeyPatch,
    check_every_s: float,
    is_told: Callable[[dict[str, Any]], bool],
) -> None:
    """Whichever notices first, storing or the check of the right, tells the gateway."""
    monkeypatch.setattr("app.live.service.CHECK_EVERY_S", check_every_s)
    erased = new_session(therapist, world.patient_id, stream)
    sound = new_session(therapist, world.other_patient_id, stream)
    with (
        therapist.websocket_connect("/ws/ingest") as socket,
        therapist.websocket_connect("/ws/ingest") as neighbour,
    ):
        socket.send_text(hello(therapist, erased, stream))
        neighbour.send_text(hello(therapist, sound, stream))
        receive_until(socket, lambda message: message["type"] == "acknowledge")
        receive_until(neighbour, lambda message: message["type"] == "acknowledge")
        with engine.begin() as connection:
            connection.exec_driver_sql("DELETE FROM motion_session WHERE id = ?", (erased,))
        for number in range(5):
            socket.send_bytes(stream.packet(number))
            neighbour.send_bytes(stream.packet(number))
        receive_until(neighbour, lambda message: message.get("acknowledged") == 4)
        receive_until(socket, is_told)


def test_an_interrupted_session_is_taken_note_of_and_closed_when_nobody_comes_back(
    therapist: Any,
    world: Any,
    stream: DeviceStream,
    engine: Engine,
    services: Services,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A second live side on the same database stands for the service after a restart."""
    monkeypatch.setattr(warmup, "load_or_compile", lambda kind: None)
    monkeypatch.setattr(live_manager, "prepare_process", lambda: None)
    session_id, closing_id = (new_session(therapist, world.patient_id, stream) for _ in range(2))
    with unit_of_work(engine) as session:
        for one, state in ((session_id, "recording"), (closing_id, "closing")):
            session.execute(update(MotionSession).where(MotionSession.id == one).values(state=state))
    closed: list[str] = []
    analysis_asked_for = threading.Event()

    def on_closed(one: str) -> None:
        closed.append(one)
        if one == session_id:
            analysis_asked_for.set()

    async def run() -> None:
        writer = GroupCommitWriter(engine)
        writer.start()
        live = LiveManager(engine, writer, MemoryBus(), on_closed, limits=services.limits, idle_close_s=0.3)
        await live.start()
        assert closing_id in closed, "what was closing goes on to its analysis at once"
        assert session_id not in closed
        stored = repository.load(engine, session_id)
        assert (stored.state, stored.state_reason) == ("link_lost", "The service was restarted.")
        async with asyncio.timeout(PATIENCE_S):
            await asyncio.to_thread(analysis_asked_for.wait)
        assert repository.load(engine, session_id).state == "closing"
        with read_only(engine) as session:
            dead = select(SessionEvent.text).where(
                SessionEvent.session_id == session_id, SessionEvent.kind == DEAD_LINK
            )
            assert len(session.scalars(dead).all()) == 1, (
                "its gateway never came back, which somebody must see"
            )
        assert (await live.close(session_id, "again")).state == "closing"
        with pytest.raises(Conflict):
            live.live(session_id)
        await live.stop()
        writer.close()

    asyncio.run(run())


def test_the_rate_and_order_of_the_hello_become_those_of_the_setup(
    therapist: Any, world: Any, stream: DeviceStream, engine: Engine
) -> None:
    order = tuple(reversed(stream.placements))
    turned = replace(stream, placements=order, counts=np.ascontiguousarray(stream.counts[:, ::-1]))
    session_id = new_session(therapist, world.patient_id, stream)
    with therapist.websocket_connect("/ws/ingest") as socket:
        socket.send_text(hello(therapist, session_id, turned))
        receive_until(socket, lambda message: message["type"] == "acknowledge")
    stored = repository.load(engine, session_id)
    assert tuple(stored.setup["placements"]) == order
    assert stored.hello is not None
    assert tuple(stored.hello["placements"]) == order
    assert "ticket" not in stored.hello
