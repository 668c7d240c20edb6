"""When turns are late, views go without; what is estimated and stored stays whole."""

import asyncio
from typing import Any

import numpy as np
import pytest
from sqlalchemy import Engine

from app.live.engine import turns
from app.live.engine.pools import FRAME_ROWS
from app.live.engine.turns import PooledEngine
from app.live.manager import ENDINGS, LiveManager
from app.network.packet import PacketFlag, with_flags
from estimators.pipelines import Frames
from tests.app.live.engine.both_ways import Faults, offer, packets_of, worn
from tests.app.live.engine.test_both_ways import (
    ARM,
    SECONDS,
    Pair,
    manager,
    no_checks,
    pair_of,
    stands,
    stored,
)
from tests.app.live.live_load import remember, swaying

__all__ = ["manager", "no_checks"]
"""Fixtures of the test of both ways."""
TOGETHER = 4
PLAIN = Faults(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, False, (5,), 0.0, (), ())


async def begun(manager: LiveManager, world: Any, engine: Engine) -> tuple[Pair, list[bytes]]:
    """Two sessions of a plain stream that have taken its first packet, and all its packets."""
    calibration, whole = swaying(SECONDS)
    remember(engine, world.patient_id, calibration)
    stream = worn(whole, ARM)
    pair = await pair_of(manager, world, stream)
    packets = packets_of(stream, PLAIN, np.random.default_rng(0))
    pair.give(packets[:1], np.random.default_rng(0))
    return pair, packets


def test_a_late_turn_shows_the_newest_and_stores_everything(
    manager: LiveManager,
    world: Any,
    engine: Engine,
) -> None:
    async def run() -> None:
        pair, packets = await begun(manager, world, engine)
        packets = packets[:81]
        before = len(pair.frames[1].take())
        at_s = 200.0
        for number, data in enumerate(packets[1:]):
            at_s += 0.05
            pair.general.take_rare(data, at_s, int(1e9 * at_s))
            offer(manager.pooled, pair.pooled, data, 0, at_s)
            if number % TOGETHER == TOGETHER - 1:
                manager.pooled.is_late = True
                manager.pooled.turn()
        await pair.settle()
        one, other = pair.sessions
        shown = [item.block for _, item in pair.frames[1].take()]
        everything = [item.block for _, item in pair.frames[0].take()]
        assert before == 1
        assert len(shown) == len(packets[1:]) // TOGETHER == manager.pooled.unshown // (TOGETHER - 1)
        assert [block[40:] for block in shown] == [block[40:] for block in everything[TOGETHER::TOGETHER]]
        assert stands(one) == stands(other)
        assert stored(manager, one) == stored(manager, other)

    asyncio.run(run())


def test_a_pause_of_the_link_does_not_leave_the_compiled_way(
    manager: LiveManager,
    world: Any,
    engine: Engine,
) -> None:
    """What has waited comes at once, more than there are rows for its frames."""

    async def run() -> None:
        pair, packets = await begun(manager, world, engine)
        assert 5 * len(packets) > FRAME_ROWS
        rare = manager.pooled.rare
        offered(pair, packets[1:])
        manager.pooled.turn()
        assert manager.pooled.rare == rare
        await pair.settle()
        pair.compare()

    asyncio.run(run())


def offered(pair: Pair, packets: list[bytes], first_s: float = 200.0) -> None:
    """Packets the general way, and for the next turn."""
    for number, data in enumerate(packets):
        at_s = first_s + 0.05 * number
        pair.general.take_rare(data, at_s, int(1e9 * at_s))
        offer(pair.manager.pooled, pair.pooled, data, 0, at_s)


class Watching:
    """A guide that is told everything at once; which ticks were measured when they came."""

    is_following = True

    def __init__(self) -> None:
        self.ticks: list[tuple[int, bool]] = []

    def see(self, frames: Frames, *, is_counting: bool, is_live: bool) -> None:
        stop = frames.first_tick + frames.tick_count
        self.ticks += [(tick, is_live) for tick in range(frames.first_tick, stop)]


@pytest.mark.parametrize("asked", [1, 1000])
def test_what_comes_behind_a_rare_packet_is_taken_together(
    manager: LiveManager, world: Any, engine: Engine, monkeypatch: pytest.MonkeyPatch, asked: int
) -> None:
    """After a lost link: what is filled in, behind it a long backlog, with packets twice in it."""
    monkeypatch.setattr(turns, "ASKED", asked)

    async def run() -> None:
        pair, packets = await begun(manager, world, engine)
        ordinary, rare = manager.pooled.ordinary, manager.pooled.rare
        watching = [Watching(), Watching()]
        for session, guide in zip(pair.sessions, watching, strict=True):
            session.guidance = guide  # type: ignore[assignment]
        filled_in = [with_flags(data, PacketFlag.BACKFILLED) for data in packets[1:8]]
        sent = [*filled_in, *packets[8:40], *packets[30:40], *packets[40:100]]
        assert len(sent) > turns.ITEMS
        offered(pair, sent)
        manager.pooled.turn()
        assert manager.pooled.rare - rare == 10
        assert manager.pooled.ordinary - ordinary == len(sent) - 10
        assert watching[0].ticks == watching[1].ticks
        assert [tick for tick, is_live in watching[1].ticks if not is_live] == list(range(5, 40))
        await pair.settle()
        pair.compare()

    asyncio.run(run())


def test_where_all_are_rare_the_rest_is_taken_to_be_as_rare(
    manager: LiveManager, world: Any, engine: Engine, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each try costs a call: a gateway whose packets all are broken must not cost the others sixty of them."""
    tried = []
    take_part = PooledEngine._take_part

    def noted(self: PooledEngine, pool: Any, items: Any) -> Any:
        tried.append(len(items))
        return take_part(self, pool, items)

    monkeypatch.setattr(turns, "ASKED", 1000)
    monkeypatch.setattr(PooledEngine, "_take_part", noted)

    async def run() -> None:
        pair, packets = await begun(manager, world, engine)
        broken = [data[:40] + bytes([data[40] ^ 1]) + data[41:] for data in packets[1:61]]
        offered(pair, [*broken, *packets[1:4]])
        manager.pooled.turn()
        assert tried == [63, 62, 61, 60]
        offered(pair, packets[4:8], 210.0)
        rare = manager.pooled.rare
        manager.pooled.turn()
        assert manager.pooled.rare == rare
        await pair.settle()
        pair.compare()

    asyncio.run(run())


@pytest.mark.parametrize("asked", [1, 1000])
def test_behind_the_first_packet_of_a_link_that_is_back_packets_are_taken_together(
    manager: LiveManager, world: Any, engine: Engine, monkeypatch: pytest.MonkeyPatch, asked: int
) -> None:
    """Also where others stream: what has waited of a session that is in no pool goes behind theirs."""
    monkeypatch.setattr(turns, "ASKED", asked)

    async def run() -> None:
        pair, packets = await begun(manager, world, engine)
        stream = worn(swaying(SECONDS)[1], ARM)
        other = await pair_of(manager, world, stream)
        others = packets_of(stream, PLAIN, np.random.default_rng(0))
        other.give(others[:2], np.random.default_rng(0))
        for one in pair.sessions:
            one.link_lost("")
        rare, at_s = manager.pooled.rare, 200.0
        for number in range(1, 101):
            at_s += 0.05
            for one, sent in ((other, others[number + 1]), (pair, packets[number])):
                one.general.take_rare(sent, at_s, int(1e9 * at_s))
                offer(manager.pooled, one.pooled, sent, 0, at_s)
        manager.pooled.turn()
        assert manager.pooled.rare - rare == 1
        for one in (pair, other):
            await one.settle()
            one.compare()

    asyncio.run(run())


def test_turns_are_late_until_one_works_half_as_long(
    manager: LiveManager,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    engine, clock = manager.pooled, iter([0.0, 0.11, 1.0, 1.06, 2.0, 2.04])
    monkeypatch.setattr(turns.time, "perf_counter", lambda: next(clock))
    monkeypatch.setattr(engine, "_give", lambda received: None)
    found = []
    for _ in range(3):
        engine._journals[engine._filling].received = [(None, 0, 0, 0, 0.0, 0)]  # type: ignore[list-item]
        engine.turn()
        found.append(engine.is_late)
    assert found == [True, True, False]


def test_behind_is_who_works_long_on_a_turn_and_a_moment_after_it(
    manager: LiveManager, monkeypatch: pytest.MonkeyPatch
) -> None:
    engine, now = manager.pooled, [10.0]
    monkeypatch.setattr(turns.time, "perf_counter", lambda: now[0])
    found = []

    def lasts(received: Any) -> None:
        now[0] += received[0][1]

    monkeypatch.setattr(engine, "_give", lasts)
    for lasted_s, since_s in ((0.5, 0.1), (1.5, 0.1), (1.5, 1.1)):
        engine._journals[engine._filling].received = [(None, lasted_s, 0, 0, 0.0, 0)]  # type: ignore[list-item]
        engine.turn()
        now[0] += since_s
        found.append(manager._housekeeping.is_behind())
    assert found == [False, True, False]


class Ending:
    """A session that ends; counts how many do at the same time."""

    lane = None
    running = most = 0

    async def finish(self) -> None:
        Ending.running += 1
        Ending.most = max(Ending.most, Ending.running)
        await asyncio.sleep(0.01)
        Ending.running -= 1


def test_sessions_that_end_together_end_a_few_at_a_time(manager: LiveManager) -> None:
    """A clinic's evening ends within seconds; who streams on must not wait for it."""
    sessions = [Ending() for _ in range(3 * ENDINGS)]

    async def run() -> None:
        await asyncio.gather(*(manager._finish(str(n), one) for n, one in enumerate(sessions)))  # type: ignore[arg-type]

    asyncio.run(run())
    assert all(one.is_finished for one in sessions)  # type: ignore[attr-defined]
    assert Ending.most == ENDINGS
