"""Sessions whose checkpoints a worker cannot read are estimated ahead: it takes them without beginning anew."""

import asyncio
from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from typing import Any

import pytest
from pydantic import SecretStr
from sqlalchemy import Engine, update

from app.accounts.credentials.passwords import Passwords
from app.live.bus import MemoryBus
from app.live.manager import LiveManager
from app.live.repository import unfinished
from app.live.session import rebuild
from app.live.session.checkpoint import LAYOUT
from app.live.warmup import FIRST, Readiness, warm_up
from app.network.declaration import FoundClips
from app.recordings.models import LiveCheckpoint, MotionSession
from app.scaled.fencing import Fence, fenced, take_over
from app.scaled.takeover import read_streamed
from app.scaled.worker import worker as module
from app.scaled.worker.preparing import Preparation
from app.scaled.worker.sessions import OfWorker, PartitionSessions
from app.settings import Settings
from tests.app.conftest import build_world
from tests.app.live.engine.both_ways import worn
from tests.app.live.engine.test_both_ways import ARM
from tests.app.live.live_load import remember, swaying
from tests.benchmarks.service import SECRET
from tests.patience import PATIENCE_S
from tests.scaled.test_takeover import SECONDS, database, goes_on, limits, no_checks, streamed, writer_of

__all__ = ["database", "no_checks"]

pytestmark = [
    pytest.mark.slow("sessions are estimated anew from all their packets, in PostgreSQL"),
    pytest.mark.postgres,
]


def test_what_others_still_hold_is_estimated_ahead_and_taken_with_every_bit(
    database: Engine, cheap_passwords: Passwords, monkeypatch: pytest.MonkeyPatch
) -> None:
    warm_up(FIRST)
    world = build_world(database, cheap_passwords)
    calibration, whole = swaying(SECONDS)
    remember(database, world.patient_id, calibration)
    stream = worn(whole, ARM)
    fed: list[int] = []
    feed = rebuild._Again.feed

    def counted(self: Any, packet: Any, place: Any) -> None:
        fed.append(place.sequence)
        feed(self, packet, place)

    monkeypatch.setattr(rebuild._Again, "feed", counted)

    async def drained(_: str) -> None:
        pass

    async def story() -> None:
        before = fenced(database, Fence(0, take_over(database, 0, "first")[0], lambda: None))
        first = LiveManager(before, writer_of(before), MemoryBus(), lambda _: None, limits=limits())
        stayed = await streamed(first, world, stream, 3)
        with database.begin() as connection:
            connection.execute(update(LiveCheckpoint).values(layout=LAYOUT + 1))

        readiness = Readiness(lambda _: None)
        held: set[str] = set()
        broken_one = stayed[1]
        is_broken = MotionSession.id == broken_one.id
        ahead = Preparation(database, readiness, held.__contains__)
        await ahead.short()
        open_ones, _ = unfinished(database, lambda _: True)
        plain = read_streamed(database, open_ones)
        found = ahead.put_into(plain)
        there = {name: one.checkpoint for name, one in plain.items() if one.checkpoint is not None}
        assert len(there) == 2, "the first has none, and begins anew"
        for name, old in there.items():
            new = found[name].checkpoint
            assert new is not None
            assert (new.layout, new.sequence) == (LAYOUT, old.sequence)
            assert found[name].chunks is None
        assert found[stayed[0].id] is plain[stayed[0].id]
        assert max(fed) < max(one.sequence for one in there.values())

        fed.clear()
        assert await ahead.once() == 2
        assert fed == [], "nothing has come since"
        clipped = replace(broken_one.declaration, found_clips=(FoundClips(10**6, 0, (None,) * 12),))
        for broken in (clipped.to_dict(), {"nothing": "that can be read"}):
            fed.clear()
            with database.begin() as connection:
                connection.execute(update(LiveCheckpoint).values(sequence=LiveCheckpoint.sequence + 1))
                connection.execute(update(MotionSession).where(is_broken).values(hello=broken))
            assert await ahead.once() == 2
            assert len(fed) == 1, "what comes into force behind a checkpoint waits for the next one"
            assert await ahead.once() == 2
            assert len(fed) == 1, "and is not tried again before"
        with database.begin() as connection:
            whole_again = broken_one.declaration.to_dict()
            connection.execute(update(MotionSession).where(is_broken).values(hello=whole_again))

        fed.clear()
        where = {
            name: one.checkpoint.sequence for name, one in ahead.put_into(plain).items() if one.checkpoint
        }
        settings = Settings(secret_key=SecretStr(SECRET))
        shared = OfWorker(settings=settings, limits=limits(), readiness=readiness, ahead=ahead)
        after = fenced(database, Fence(0, take_over(database, 0, "second")[0], lambda: None))
        writer = writer_of(after)
        second = PartitionSessions(after, writer, MemoryBus(), lambda _: None, drained, shared)
        assert await second.begin(0, 1) == []
        for old_one in stayed:
            goes_on(second.live(old_one.id), old_one)
        left = [
            one
            for session in stayed[1:]
            for first_one, stop in session.ledger.durable
            for one in range(first_one, stop)
            if one >= where[session.id]
        ]
        assert len(fed) == len(stayed[0].ledger.durable) + len(left)
        held.update(one.id for one in stayed)
        assert await ahead.once() == 0
        assert ahead.put_into(plain) == plain
        second.leave()
        await asyncio.to_thread(writer.close)
        first.end_checks()
        first._check_process.close()
        shared.check.close()

    asyncio.run(story())


class Asked:
    """A broker's place in the module under test: who answers is written down before."""

    def __init__(self, answers: list[set[str] | Exception]) -> None:
        self.answers = answers

    async def __call__(self, *_: object) -> set[str]:
        found = self.answers.pop(0) if len(self.answers) > 1 else self.answers[0]
        if isinstance(found, Exception):
            raise found
        return found


@pytest.mark.parametrize(
    ("answers", "is_waited"),
    [
        ([set()], False),
        ([{"a", "b"}, TimeoutError(), {"a", "b", "c"}], True),
        ([{"a", "b"}, {"a", "b"}, {"b"}], False),
    ],
    ids=["nobody is there", "all stay", "one goes"],
)
def test_a_worker_waits_for_what_is_estimated_ahead_only_while_others_show_it(
    monkeypatch: pytest.MonkeyPatch, answers: list[set[str] | Exception], is_waited: bool
) -> None:
    asked = Asked(answers)
    monkeypatch.setattr(module, "others_of", asked)
    monkeypatch.setattr(module, "LOOK_S", 0.01)

    async def story() -> None:
        ended = asyncio.Event()

        async def short() -> None:
            await ended.wait()

        ahead = SimpleNamespace(short=short, comes_soon=None)
        worker = SimpleNamespace(
            ahead=ahead, _broker=SimpleNamespace(partitions=8), _name="n", _others=set(), _until_one_goes=None
        )
        worker._until_one_goes = partial(module.Worker._until_one_goes, worker)
        await module.Worker.look_for_others(worker)  # type: ignore[arg-type]
        # Before anything else is asked of it, it says whether it takes sessions yet.
        assert ahead.is_waited_for is bool(answers[0])
        waiting = asyncio.create_task(module.Worker._estimate_ahead(worker))  # type: ignore[arg-type]
        await asyncio.wait([waiting], timeout=0.3)
        assert waiting.done() is not is_waited
        ended.set()
        await asyncio.wait_for(waiting, PATIENCE_S)

    asyncio.run(story())
