"""Who takes a partition reads what is stored of all its sessions in a few statements, and goes on with their bits."""

import asyncio
from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any, Final

import numpy as np
import pytest
from pydantic import SecretStr
from sqlalchemy import Engine, event

from app.accounts.credentials.passwords import Passwords
from app.database import migrate
from app.database.engine import create_from_url
from app.limits import Limits
from app.live.bus import MemoryBus
from app.live.guidance.resume_state import taken_up
from app.live.manager import LiveManager
from app.live.repository import unfinished
from app.live.session.checkpoint import capture, pack
from app.live.session.runner import LiveSession
from app.live.warmup import FIRST, Readiness, warm_up
from app.network.ranges import SequenceRanges
from app.recordings.signals.group_commit import GroupCommitWriter
from app.recordings.signals.store import read_packets_in_order, read_standing
from app.scaled import fencing
from app.scaled.checkpoints import save
from app.scaled.fencing import Fence, fenced, take_over
from app.scaled.takeover import read_streamed
from app.scaled.worker.sessions import OfWorker, PartitionSessions
from app.settings import Allowance, Settings
from tests.app.conftest import build_world
from tests.app.live.engine.both_ways import Faults, Sender, packets_of, worn
from tests.app.live.engine.test_both_ways import ARM
from tests.app.live.engine.test_checkpoint import give, settled
from tests.app.live.live_load import connected, remember, swaying
from tests.benchmarks.service import SECRET

pytestmark = [
    pytest.mark.slow("a service is compiled, streams and is taken over, in PostgreSQL"),
    pytest.mark.postgres,
]

STATEMENTS: Final = 7
"""Two for which sessions there are, five for what is stored of them; however many they are."""
SECONDS = 12.0
LOST = Faults(0.02, 0.0, 0.0, 0.0, 0.0, 0.0, False, (5,), 0.0, (), ())


@pytest.fixture(autouse=True)
def no_checks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Checks of the first seconds run in a process of their own, whenever it has time."""
    monkeypatch.setattr("app.live.checks.first_seconds.CheckTurns.begin", lambda _: False)


@pytest.fixture
def database(postgresql_database: Callable[[], str]) -> Iterator[Engine]:
    url = postgresql_database()
    migrate.upgrade(url)
    engine = create_from_url(url)
    fencing.install(engine)
    yield engine
    engine.dispose()


def writer_of(engine: Engine) -> GroupCommitWriter:
    made = GroupCommitWriter(engine)
    made.start()
    return made


def limits() -> Limits:
    return Limits({"streams": Allowance(1000, 1000, 1000)})


async def streamed(manager: LiveManager, world: Any, stream: Any, count: int) -> list[LiveSession]:
    """Let sessions stream past a checkpoint, one of them past none; return them as they stand."""
    packets = packets_of(stream, LOST, np.random.default_rng(3))
    sessions, states = [], {}
    for number in range(count):
        sender = Sender(await connected(manager, world.subjects["therapist"], world.patient_id, stream))
        session, half = manager.live(sender.intake.session_id), len(packets) // 2
        for part in (packets[:half], packets[half:]):
            give(manager, sender, part, 100.0 if part is packets[:half] else 100.0 + 0.05 * half)
            await settled(session)
            await asyncio.wrap_future(manager.writer.flush(session.id))
            if number and session.id not in states:
                state = capture(session)
                assert state is not None
                states[session.id] = pack(state)
        session.add_event("repetition", 3.0, details={"kind": "valid"})
        await asyncio.wrap_future(manager.writer.flush(session.id))
        await session.saved()
        sessions.append(session)
    save(manager.engine, 0, 1, states)
    return sessions


def counted(engine: Engine) -> SimpleNamespace:
    found = SimpleNamespace(statements=[], commits=0)
    event.listen(engine, "before_cursor_execute", lambda *given: found.statements.append(given[2]))

    def committed(_: Any) -> None:
        found.commits += 1

    event.listen(engine, "commit", committed)
    return found


def test_all_sessions_of_a_partition_are_taken_up_with_a_few_statements_and_every_bit(
    database: Engine, cheap_passwords: Passwords
) -> None:
    warm_up(FIRST)
    world = build_world(database, cheap_passwords)
    calibration, whole = swaying(SECONDS)
    remember(database, world.patient_id, calibration)
    stream = worn(whole, ARM)
    settings = Settings(secret_key=SecretStr(SECRET))
    shared = OfWorker(settings=settings, limits=limits(), readiness=Readiness(lambda _: None))

    async def drained(_: str) -> None:
        pass

    async def story() -> None:
        # As a worker does before it takes partitions.
        await shared.readiness.require_guidance()
        before = fenced(database, Fence(0, take_over(database, 0, "first")[0], lambda: None))
        first = LiveManager(before, writer_of(before), MemoryBus(), lambda _: None, limits=limits())
        stayed = await streamed(first, world, stream, 4)
        counts = []
        for takes in ("second", "third"):
            after = fenced(database, Fence(0, take_over(database, 0, takes)[0], lambda: None))
            writer = writer_of(after)
            second = PartitionSessions(after, writer, MemoryBus(), lambda _: None, drained, shared)
            found = counted(database)
            assert await second.begin(0, 1) == []
            counts.append(len(found.statements))
            assert not found.commits, "somebody wrote"
            assert {one.id for one in second.sessions} == {one.id for one in stayed}
            for old in stayed:
                compare(second.live(old.id), old, database)
            second.leave()
            await asyncio.to_thread(writer.close)
        # Of the session without a checkpoint every chunk is read besides.
        assert counts == [STATEMENTS + 1 + read_standing(database, stayed[0].id).next_chunk] * 2
        first.end_checks()
        first._check_process.close()
        shared.check.close()

    asyncio.run(story())


def goes_on(new: LiveSession, old: LiveSession) -> None:
    """Hold every bit of a session that was taken up against the one that stayed."""
    states = [one.now.pipeline.state() | one.now.aligner.state() for one in (new, old)]
    for name, values in states[1].items():
        assert values.tobytes() == states[0][name].tobytes(), name
    assert new.now.clock.state() == old.now.clock.state()
    assert list(new.ledger.received) == list(old.ledger.received)
    assert new.result_id == old.result_id
    assert new.pipeline.setup == old.pipeline.setup


def compare(new: LiveSession, old: LiveSession, engine: Engine) -> None:
    goes_on(new, old)
    assert new.guidance is not None
    (stored,), _ = unfinished(engine, lambda one: one == new.id)
    found = read_streamed(engine, [stored])[new.id]
    assert found.standing == read_standing(engine, new.id)
    assert found.guided == taken_up(engine, new.id)
    assert found.guided.counts.valid == 1
    if found.checkpoint is None:
        assert not found.chunks
        return
    behind = SequenceRanges()
    for chunk in found.chunks:
        behind.update(tuple(one) for one in chunk.scale["ranges"])
    wanted = [one.sequence for one in read_packets_in_order(engine, new.id, found.checkpoint.sequence)]
    assert wanted
    assert all(one in behind for one in wanted)
    assert len(found.chunks) < found.standing.next_chunk, "what is in the checkpoint is read again"
