"""What a minute of ten live sessions leaves to the garbage collector, which hardly ever runs in a service.

`app.live.warmup` makes collections rare because they hold the event loop up. That is right only while the live path
leaves no cycles of objects behind: statements that were built for each question to the database left 80 objects a
second, and memory grew by more than a megabyte a minute.
"""

import asyncio
import gc
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import pytest
from sqlalchemy import Engine

from app.accounts.credentials.sign_in import create_sign_in
from app.database.unit_of_work import read_only, unit_of_work
from app.kinds.magnetic.safety import CONFIRMATION_HOURS
from app.limits import Allowance, Limits
from app.live.bus import MemoryBus, topic
from app.live.manager import LiveManager
from app.live.repository import source_refusal
from app.live.rights.authorization_checks import AuthorizationCheck, answers
from app.live.warmup import FIRST, warm_up
from app.recordings.analysis.queue import FairQueue
from app.recordings.signals.group_commit import GroupCommitWriter
from app.settings import Settings
from tests.app.live.engine.both_ways import Sender, offer
from tests.app.live.live_load import connected, remember, swaying

SESSIONS, SECONDS, PACKET_S = 10, 60.0, 0.05
WARM_S = 10.0
"""Before counting: what is made once, at a session's beginning, is left aside."""
RIGHTS_S, POLL_S, MARK_S = 5.0, 0.5, 10.0
"""How often open sockets are asked for, tasks are looked for and checkpoints are made."""
MOST = 100
"""Objects; 2,670 when each look built its statements."""


@pytest.fixture(autouse=True)
def no_checks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Checks of the first seconds run in a process of their own."""
    monkeypatch.setattr("app.live.checks.first_seconds.CheckTurns.begin", lambda _: False)


@pytest.fixture
def collector() -> Iterator[None]:
    """Collects only when it is asked to."""
    gc.disable()
    try:
        yield
    finally:
        gc.set_debug(0)
        gc.garbage.clear()
        gc.enable()


def found() -> Counter[str]:
    """Return the types of what only the collector can free."""
    gc.set_debug(gc.DEBUG_SAVEALL)
    gc.collect()
    gc.set_debug(0)
    types = Counter(type(one).__name__ for one in gc.garbage)
    gc.garbage.clear()
    return types


@pytest.mark.slow
@pytest.mark.usefixtures("collector")
def test_a_minute_of_ten_sessions_leaves_nothing_to_collect(
    engine: Engine, settings: Settings, world: Any
) -> None:
    warm_up(FIRST)
    calibration, stream = swaying(SECONDS)
    remember(engine, world.patient_id, calibration)
    subject = world.subjects["therapist"]
    with unit_of_work(engine) as session:
        subject = replace(
            subject, sign_in_id=create_sign_in(session, settings, subject.id, "a browser")[1].id
        )
    queue = FairQueue(2)

    async def run() -> Counter[str]:
        limits = Limits({"streams": Allowance(100, 100, 100)})
        writer, bus = GroupCommitWriter(engine), MemoryBus()
        writer.start()
        manager = LiveManager(engine, writer, bus, lambda _: None, limits=limits)
        made = [await connected(manager, subject, world.patient_id, stream) for _ in range(SESSIONS)]
        senders = [Sender(intake) for intake in made]
        views = [bus.subscribe(topic(one.session_id, "blocks"), size=16) for one in made]
        sockets = [
            AuthorizationCheck(subject, one.session_id, level, shown)
            for one in made
            for level, shown in (("read", settings), ("record", None))
        ]
        device = AuthorizationCheck(replace(subject, kind="device"), made[0].session_id, "record")
        for number in range(round(SECONDS / PACKET_S)):
            now_s = number * PACKET_S
            if now_s == WARM_S:
                gc.collect()
            for sender in senders:
                offer(manager.pooled, sender, stream.packet(number), 0, 100.0 + now_s)
            manager.pooled.turn()
            for frames in views:
                frames.take()
            if number % round(RIGHTS_S / PACKET_S) == 0:
                refused = await asyncio.to_thread(answers, engine, [*sockets, device])
                assert refused[:-1] == [None] * len(sockets)
                assert refused[-1] is not None
            if number % round(POLL_S / PACKET_S) == 0:
                with read_only(engine) as reading:
                    assert queue.take(reading) is None
            if number % round(MARK_S / PACKET_S) == 0:
                for live in manager.sessions:
                    live.settle()
                    manager._note_where(live, is_last=True)
                await asyncio.wrap_future(writer.flush(made[0].session_id))
        left = found()
        await manager.stop()
        writer.close()
        return left

    left = asyncio.run(run())
    assert left.total() < MOST, left.most_common(12)


@pytest.mark.usefixtures("collector")
def test_asking_whether_a_source_may_fire_leaves_nothing_to_collect(
    engine: Engine, therapist: Any, world: Any
) -> None:
    wanted = {
        "patient_id": world.patient_id,
        "pipeline": "relative_pose",
        "placements": ["pelvis", "sternum"],
        "rate_hz": 120.0,
    }
    session_id = therapist.post("/api/sessions", json=wanted).json()["id"]
    source_refusal(engine, session_id, CONFIRMATION_HOURS)
    gc.collect()
    for _ in range(20):
        assert source_refusal(engine, session_id, CONFIRMATION_HOURS)
    left = found()
    assert left.total() < 20, left.most_common(12)
