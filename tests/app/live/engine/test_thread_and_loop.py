"""Threads that estimate and the event loop share few cores: neither waits for the other where it need not."""

import asyncio
import os
import sys
import time
from typing import Any

import numpy as np
import pytest
from sqlalchemy import Engine

from app.live.engine import turns
from app.live.engine.pools import SessionPool
from app.live.engine.step_thread import GIVES_WAY, StepThread
from app.live.manager import LiveManager
from tests.app.live.engine.both_ways import packets_of, worn
from tests.app.live.engine.test_both_ways import (
    ARM,
    SECONDS,
    by_thread,
    manager,
    no_checks,
    pair_of,
    shows_all,
)
from tests.app.live.engine.test_late_turns import PLAIN
from tests.app.live.engine.test_step_thread import asked, begun, general, offered, threads
from tests.app.live.live_load import swaying
from tests.patience import PATIENCE_S

__all__ = ["asked", "by_thread", "manager", "no_checks", "shows_all"]
"""Fixtures."""


def answered(manager: LiveManager) -> None:
    """Wait until every thread is done, without the event loop."""
    deadline_s = time.monotonic() + PATIENCE_S
    while not all(part[0].has_answered for part in manager.pooled._open):
        assert time.monotonic() < deadline_s
        time.sleep(0.001)


def test_a_packet_that_comes_behind_an_answer_lets_the_thread_go_on(
    manager: LiveManager, world: Any, engine: Engine, asked: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Between two reads of many sockets the event loop does not look at the pipes."""
    monkeypatch.setattr(turns, "ITEMS", 3)

    async def run() -> None:
        pair, packets = await begun(manager, world, engine)
        general(pair, packets[:9])
        offered(pair, packets[:6])
        asked.clear()
        manager.pooled.begin()
        assert asked == [3]
        answered(manager)
        offered(pair, packets[6:7], 6)
        assert asked == [3, 3]
        answered(manager)
        offered(pair, packets[7:8], 7)
        assert not manager.pooled._open
        offered(pair, packets[8:9], 8)
        manager.pooled.turn()
        await pair.settle()
        pair.compare()

    asyncio.run(run())


def test_whoever_sends_is_not_harmed_by_a_part_that_cannot_be_ended(
    manager: LiveManager, world: Any, engine: Engine, asked: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    async def run() -> None:
        pair, packets = await begun(manager, world, engine)

        def fails(*_: Any) -> Any:
            raise FloatingPointError("made for a test")

        offered(pair, packets[:3])
        manager.pooled.begin()
        answered(manager)
        monkeypatch.setattr(manager.pooled, "_show", fails)
        monkeypatch.setattr(manager.pooled, "_failed", fails)
        offered(pair, packets[3:4], 3)
        monkeypatch.undo()
        assert not manager.pooled._open
        manager.pooled.turn()

    asyncio.run(run())


def test_packets_of_a_session_are_taken_one_after_the_other_where_a_call_does_not_take_all(
    manager: LiveManager, world: Any, engine: Engine, asked: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(turns, "ITEMS", 6)
    filled: list[list[int]] = []
    fill = SessionPool.fill

    def note(pool: SessionPool, slots: Any, offsets: Any, lengths: Any) -> None:
        filled.append(list(slots))
        fill(pool, slots, offsets, lengths)

    async def run() -> None:
        pair, packets = await begun(manager, world, engine)
        stream = worn(swaying(SECONDS)[1], ARM)
        other = await pair_of(manager, world, stream)
        other.give(packets_of(stream, PLAIN, np.random.default_rng(0))[:2], np.random.default_rng(0))
        monkeypatch.setattr(SessionPool, "fill", note)
        general(pair, packets[:4])
        general(other, packets[:5])
        for number in range(5):
            offered(other, packets[number : number + 1], number)
            if number < 4:
                offered(pair, packets[number : number + 1], number)
        manager.pooled.turn()
        slots = [slot for part in filled for slot in part]
        assert [len(part) for part in filled] == [6, 3]
        assert slots == [pair.pooled.lane.slot] * 4 + [other.pooled.lane.slot] * 5, (
            "who brings the most comes last"
        )
        await pair.settle()
        pair.compare()
        await other.settle()
        other.compare()

    asyncio.run(run())


@pytest.mark.skipif(sys.platform != "linux", reason="ranks single threads")
def test_the_thread_gives_way_to_the_event_loop() -> None:
    before = threads()
    thread = StepThread(lambda request, byte: os.read(int(request[3]), 1) and None)
    (own,) = threads() - before
    deadline_s = time.monotonic() + PATIENCE_S
    wanted = min(os.getpriority(os.PRIO_PROCESS, 0) + GIVES_WAY, 19)
    while os.getpriority(os.PRIO_PROCESS, own.native_id or 0) != wanted:
        assert time.monotonic() < deadline_s
        time.sleep(0.001)
    thread.close()


def test_packets_take_the_general_way_until_the_engine_is_there(
    manager: LiveManager, world: Any, engine: Engine, asked: list[int]
) -> None:
    """In the first start after an installation: what has come so far moves on in a pool, bit for bit."""

    async def run() -> None:
        is_prepared = False
        manager.pooled.is_being_prepared = lambda: not is_prepared
        pair, packets = await begun(manager, world, engine)
        general(pair, packets[:12])
        offered(pair, packets[:6])
        manager.pooled.turn()
        assert manager.pooled.ordinary == 0
        assert pair.pooled.lane.pool is None
        is_prepared = True
        offered(pair, packets[6:12], 6)
        manager.pooled.turn()
        assert manager.pooled.ordinary == 6
        await pair.settle()
        pair.compare()

    asyncio.run(run())
