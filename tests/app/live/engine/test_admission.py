"""A full machine sends new sessions away with a sentence; who has streamed before comes in all the same."""

import asyncio
import time
from types import SimpleNamespace
from typing import Any

import pytest
from sqlalchemy import Engine

from app.database.unit_of_work import unit_of_work
from app.errors import Unavailable
from app.limits import Limits
from app.live import repository
from app.live.admission import FULL, MOST_BUSY, REMEMBERED_S, USUAL_COST, WINDOW_S, Admission, crowd
from app.live.bus import MemoryBus
from app.live.engine.shared import Shared
from app.live.manager import LiveManager
from app.live.session.intake import Intake
from app.live.warmup import FIRST, warm_up
from app.network.declaration import check_hello
from app.network.packet import decode_packet
from app.recordings import service
from app.recordings.schemas import SessionIn
from app.recordings.signals.group_commit import GroupCommitWriter
from app.settings import Settings
from tests.app.live.live_load import swaying


def measured(busy: float, late_s: float = 0.0, packets_s: float = 0.0) -> Admission:
    admission = Admission()
    for _ in range(12):
        admission.note(0.25, 0.25 * busy, late_s, packets_s)
    return admission


def test_sessions_fit_until_the_thread_has_no_room_for_one_more() -> None:
    admission = measured(0.8)
    admission.require_room(streaming=80, quiet=0)
    admission.require_room(streaming=80, quiet=3)
    with pytest.raises(Unavailable) as refused:
        admission.require_room(streaming=80, quiet=5)
    assert refused.value.details["retry_after_s"] == 10
    assert refused.value.details["reason"] == "full"
    assert admission.refused == 1


def test_the_first_sessions_of_a_machine_count_as_the_usual_ones() -> None:
    admission = Admission()
    fit = int(MOST_BUSY / USUAL_COST)
    admission.require_room(streaming=0, quiet=fit - 1)
    with pytest.raises(Unavailable):
        admission.require_room(streaming=0, quiet=fit)


def test_cheap_sessions_leave_room_for_more_and_a_busy_page_closes_no_door() -> None:
    measured(0.3).require_room(streaming=100, quiet=100)
    # One session beside an export: what the thread uses is not the session's cost.
    measured(0.6).require_room(streaming=1, quiet=1)
    with pytest.raises(Unavailable):
        measured(MOST_BUSY).require_room(streaming=1, quiet=0)


def test_who_streams_and_who_may_at_any_moment_are_counted() -> None:
    now_s = time.monotonic()

    def session(state: str, known_s: float, silent_s: float) -> Any:
        return SimpleNamespace(state=state, opened_s=now_s - known_s, last_arrival_s=now_s - silent_s)

    there = [session("ready", 60.0, 0.1), session("recording", 60.0, 0.1), session("calibrating", 1.0, 0.1)]
    assert crowd(there) == (2, 1)
    # Ten minutes without a packet: it will not stream at any moment.
    there += [session("link_lost", 99.0, 30.0), session("link_lost", 999.0, 600.0)]
    assert crowd(there) == (2, 2)
    # Whoever ends has used what was measured, and will use nothing more.
    assert crowd([*there, session("closing", 60.0, 0.1), session("closing", 60.0, 30.0)]) == (3, 2)


def test_a_thread_that_wakes_late_takes_nobody_however_little_it_uses() -> None:
    with pytest.raises(Unavailable):
        measured(0.1, late_s=0.5).require_room(streaming=1, quiet=0)
    one_hiccup = measured(0.1)
    one_hiccup.note(5.0, 0.1, 4.75)
    one_hiccup.require_room(streaming=1, quiet=0)


def test_a_crowd_that_uses_the_machine_up_closes_the_door_before_frames_are_late() -> None:
    with pytest.raises(Unavailable):
        measured(0.5, late_s=0.04).require_room(streaming=320, quiet=0)
    measured(0.5, late_s=0.02).require_room(streaming=250, quiet=0)
    with pytest.raises(Unavailable):
        # The loop may wake in time while threads are behind.
        measured(0.5, packets_s=0.04).require_room(streaming=320, quiet=0)
    # Few sessions beside something else come in, though a little later.
    measured(0.1, late_s=0.04).require_room(streaming=5, quiet=0)
    # Sometimes late is not crowded.
    hiccups = measured(0.5)
    for _ in range(2):
        hiccups.note(0.35, 0.1, 0.1)
    hiccups.require_room(streaming=250, quiet=0)


def test_so_many_that_packets_came_late_are_not_let_in_again_for_a_while(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    now = [1000.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    admission = measured(0.5, packets_s=0.04)
    with pytest.raises(Unavailable):
        admission.require_room(streaming=100, quiet=0)
    # Those that were let in are still there: that packets come in time again says nothing of one more.
    for _ in range(12):
        admission.note(0.25, 0.1, 0.0)
    with pytest.raises(Unavailable):
        admission.require_room(streaming=90, quiet=0)
    with pytest.raises(Unavailable):
        admission.require_room(streaming=85, quiet=5)
    admission.require_room(streaming=50, quiet=5)
    # Half of them have ended, and what they left is analysed: that is late, too, but says nothing of how many fit.
    for _ in range(12):
        admission.note(0.25, 0.125, 0.0, 0.04)
    with pytest.raises(Unavailable):
        admission.require_room(streaming=50, quiet=0)
    for _ in range(12):
        admission.note(0.25, 0.1, 0.0)
    admission.require_room(streaming=50, quiet=0)
    now[0] += REMEMBERED_S + 1.0
    admission.require_room(streaming=90, quiet=0)


@pytest.mark.parametrize("streaming", [0, 3])
def test_a_few_are_not_remembered_as_too_many(streaming: int) -> None:
    """A large page or an export made the loop late: the next patient of a small clinic comes in right after it."""
    admission = measured(0.5, packets_s=0.04)
    with pytest.raises(Unavailable):
        admission.require_room(streaming, quiet=0)
    for _ in range(12):
        admission.note(0.25, 0.02, 0.0)
    admission.require_room(streaming, quiet=0)


def test_partitions_of_one_worker_count_their_sessions_together(
    engine: Engine, settings: Settings, monkeypatch: pytest.MonkeyPatch
) -> None:
    shared, limits = Shared(), Limits({"streams": settings.limit_streams})
    one, other = (
        LiveManager(
            engine, GroupCommitWriter(engine), MemoryBus(), lambda _: None, limits=limits, shared=shared
        )
        for _ in range(2)
    )
    now_s = time.monotonic()
    for manager, since_s in ((one, 1.0), (one, 30.0), (other, 1.0)):
        session = SimpleNamespace(state="ready", opened_s=now_s - 100.0, last_arrival_s=now_s - since_s)
        manager._sessions[str(len(manager.sessions))] = session  # type: ignore[assignment]
    asked: list[tuple[int, int]] = []
    monkeypatch.setattr(shared.admission, "require_room", lambda *counts: asked.append(counts))
    one._admit("new")
    other._admit("new")
    assert asked == [(2, 1), (2, 1)]


def test_it_recovers_within_its_window() -> None:
    admission = measured(1.0, late_s=1.0)
    for _ in range(round(WINDOW_S / 0.25)):
        admission.note(0.25, 0.05, 0.0)
    admission.require_room(streaming=10, quiet=0)


def test_the_thread_is_measured() -> None:
    async def story() -> Admission:
        admission = Admission()
        task = asyncio.create_task(admission.run(lambda: 0.0))
        for _ in range(3):
            await asyncio.sleep(0.26)
            sum(range(2_000_000))
        task.cancel()
        return admission

    admission = asyncio.run(story())
    assert 0.0 < admission.busy <= 1.05
    assert len(admission.take_lags()) >= 2
    assert admission.take_lags() == []


def test_a_new_session_waits_outside_and_one_that_streamed_comes_back(
    engine: Engine, settings: Settings, world: Any
) -> None:
    # Loading may take longer than a session's gateway waits, where much else runs.
    warm_up(FIRST)
    _, stream = swaying(1.0)
    subject = world.subjects["therapist"]

    def manage(busy: float) -> LiveManager:
        limits = Limits({"streams": settings.limit_streams})
        manager = LiveManager(engine, GroupCommitWriter(engine), MemoryBus(), lambda _: None, limits=limits)
        turn(manager, busy)
        return manager

    def turn(manager: LiveManager, busy: float) -> None:
        for _ in range(12):
            manager.admission.note(0.25, 0.25 * busy, 0.0)

    async def hello(manager: LiveManager, session_id: str) -> Intake:
        ticket, _ = repository.give_ticket(engine, subject, session_id, "ingest")
        message = stream.hello(ticket)
        return await manager.open(message, check_hello(message))

    async def story() -> None:
        with unit_of_work(engine) as session:
            wanted = SessionIn(patient_id=world.patient_id, placements=list(stream.placements))
            made = service.create(session, subject, wanted).id
        manager = manage(1.0)
        with pytest.raises(Unavailable, match="as this machine carries"):
            await hello(manager, made)
        assert "as this machine carries" in (await manager.state(made)).reason
        assert not manager.sessions
        turn(manager, 0.1)
        intake = await hello(manager, made)
        assert (await manager.state(made)).reason != FULL
        intake.receive(decode_packet(stream.packet(0), intake.declaration), time.monotonic(), time.time_ns())
        await manager.live(made).saved()
        # The link breaks, or the service restarts, and the machine is full now.
        turn(manager, 1.0)
        await hello(manager, made)
        await hello(manage(1.0), made)
        # Packets of a new one were acknowledged already.
        with unit_of_work(engine) as session:
            acknowledged = service.create(session, subject, wanted).id
        stored = repository.load(engine, acknowledged)
        with pytest.raises(Unavailable):
            await manager.join(stored, intake.declaration)
        await manager.join(stored, intake.declaration, is_admitted=True)

    asyncio.run(story())
