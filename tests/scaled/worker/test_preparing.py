"""Sessions whose checkpoints a worker cannot read are estimated ahead: it takes them without beginning anew."""

import asyncio
from dataclasses import replace
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
from app.scaled.taking_up import read_streamed
from app.scaled.worker.preparing import Preparation
from app.scaled.worker.sessions import OfWorker, PartitionSessions
from app.settings import Settings
from tests.app.conftest import build_world
from tests.app.live.engine.both_ways import worn
from tests.app.live.engine.test_both_ways import ARM
from tests.app.live.live_load import remember, swaying
from tests.benchmarks.service import SECRET
from tests.scaled.test_taking_up import SECONDS, database, goes_on, limits, no_checks, streamed, writer_of

__all__ = ["database", "no_checks"]

pytestmark = [pytest.mark.slow, pytest.mark.postgres]


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
        ahead = Preparation(database, readiness, held.__contains__)
        assert ahead.trouble() is None
        await ahead.short()
        assert ahead.trouble() is None
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
        clipped = replace(
            stayed[1].declaration, found_clips=(FoundClips(max(fed, default=10**6), 0, (None,) * 12),)
        )
        with database.begin() as connection:
            connection.execute(update(LiveCheckpoint).values(sequence=LiveCheckpoint.sequence + 1))
            connection.execute(
                update(MotionSession).where(MotionSession.id == stayed[1].id).values(hello=clipped.to_dict())
            )
        await ahead.once()
        assert len(fed) == 1, "what came into force behind a checkpoint waits for the next one"
        with database.begin() as connection:
            connection.execute(
                update(MotionSession)
                .where(MotionSession.id == stayed[1].id)
                .values(hello=stayed[1].declaration.to_dict())
            )

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
