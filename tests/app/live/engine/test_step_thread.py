"""What is shown, stored and estimated is the same where a thread takes the packets while the event loop goes on."""

import asyncio
import gc
import os
import threading
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from sqlalchemy import Engine

from app.live.engine import turns
from app.live.engine.lane import Lane
from app.live.engine.pools import SessionPool
from app.live.engine.step_thread import StepThread
from app.live.manager import LiveManager
from tests.app.live.engine.both_ways import offer
from tests.app.live.engine.test_both_ways import Pair, by_thread, manager, no_checks, shows_all
from tests.app.live.engine.test_late_turns import begun as begun_with_first
from tests.patience import PATIENCE_S

__all__ = ["by_thread", "manager", "no_checks", "shows_all"]


@pytest.fixture
def asked(by_thread: list[int], monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Let a thread take every packet; how many it was asked for each time."""
    monkeypatch.setattr(turns, "ASKED", 1)
    return by_thread


@pytest.fixture
def unseen(monkeypatch: pytest.MonkeyPatch) -> Callable[[], None]:
    """See no answer, however fast the threads are, until what is returned is called."""
    seen = SessionPool.has_answered
    monkeypatch.setattr(SessionPool, "has_answered", False)
    return lambda: monkeypatch.setattr(SessionPool, "has_answered", seen)


async def begun(manager: LiveManager, world: Any, engine: Engine) -> tuple[Pair, list[bytes]]:
    """Two sessions of a plain stream that stand in a pool, and what comes next."""
    pair, packets = await begun_with_first(manager, world, engine)
    pair.give(packets[1:2], np.random.default_rng(0))
    return pair, packets[2:]


def offered(pair: Pair, packets: list[bytes], first: int = 0) -> None:
    for number, data in enumerate(packets, first):
        offer(pair.manager.pooled, pair.pooled, data, 0, 200.0 + 0.05 * number)


def general(pair: Pair, packets: list[bytes]) -> None:
    for number, data in enumerate(packets):
        at_s = 200.0 + 0.05 * number
        pair.general.take_rare(data, at_s, int(1e9 * at_s))


def test_the_same_bits_where_answers_come_while_the_loop_goes_on(
    manager: LiveManager, world: Any, engine: Engine, asked: list[int]
) -> None:
    async def run() -> None:
        pair, packets = await begun(manager, world, engine)
        general(pair, packets)
        asked.clear()
        sizes = np.random.default_rng(3).integers(1, 9, len(packets))
        at = 0
        for size in sizes.tolist():
            offered(pair, packets[at : at + size], at)
            at += size
            # Long enough for a turn to begin, and sometimes for its answer.
            await asyncio.sleep(0.002 * size)
        manager.pooled.turn()
        assert sum(asked) == len(packets)
        await pair.settle()
        pair.compare()

    asyncio.run(run())


def test_who_reads_a_session_sees_what_a_thread_was_asked_for(
    manager: LiveManager, world: Any, engine: Engine, asked: list[int]
) -> None:
    async def run() -> None:
        pair, packets = await begun(manager, world, engine)
        session = pair.sessions[1]
        before = session.parts.clock.highest
        offered(pair, packets[:7])
        asked.clear()
        manager.pooled.begin()
        assert asked == [7]
        assert manager.pooled._open
        assert session.parts.clock.highest == before + 7
        assert not manager.pooled._open
        # What comes while a thread works waits in the other journal.
        offered(pair, packets[7:9], 7)
        manager.pooled.begin()
        offered(pair, packets[9:12], 9)
        manager.pooled.turn()
        general(pair, packets[:12])
        await pair.settle()
        pair.compare()

    asyncio.run(run())


def test_more_packets_than_one_call_takes_are_asked_for_one_after_the_other(
    manager: LiveManager, world: Any, engine: Engine, asked: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(turns, "ITEMS", 5)

    async def run() -> None:
        pair, packets = await begun(manager, world, engine)
        general(pair, packets[:12])
        asked.clear()
        offered(pair, packets[:12])
        deadline_s = time.monotonic() + PATIENCE_S
        while sum(asked) < 12 or manager.pooled._open:
            assert time.monotonic() < deadline_s, asked
            await asyncio.sleep(0.001)
        assert asked == [5, 5, 2]
        await pair.settle()
        pair.compare()

    asyncio.run(run())


def test_a_failure_in_the_thread_ends_the_estimation_and_stores_the_packets(
    manager: LiveManager, world: Any, engine: Engine, asked: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    async def run() -> None:
        pair, packets = await begun(manager, world, engine)
        session = pair.sessions[1]
        wait = StepThread.wait

        def fails(thread: StepThread) -> None:
            wait(thread)
            raise FloatingPointError("made for a test")

        stored = session.ledger.received.highest
        monkeypatch.setattr(StepThread, "wait", fails)
        offered(pair, packets[:4])
        manager.pooled.turn()
        monkeypatch.setattr(StepThread, "wait", wait)
        offered(pair, packets[4:6], 4)
        manager.pooled.turn()
        assert not session.line.is_running
        assert session.ledger.received.highest == stored + 6
        assert pair.sessions[0].line.is_running

    asyncio.run(run())


def threads() -> set[threading.Thread]:
    return {thread for thread in threading.enumerate() if thread.name == "pool-step"}


def ended(thread: threading.Thread) -> bool:
    thread.join(10.0)
    return not thread.is_alive()


def test_the_thread_ends_with_its_pool(
    manager: LiveManager, world: Any, engine: Engine, asked: list[int]
) -> None:
    before = threads()

    async def run() -> None:
        pair, _ = await begun(manager, world, engine)
        (own,) = threads() - before
        for session in pair.sessions:
            if session.lane is not None:
                session.lane.leave()
        assert ended(own)

    asyncio.run(run())


def failing(calls: list[int]) -> Callable[[Any, Any], None]:
    """What a compiled step would be that fails at first and then takes its requests."""

    def take(request: Any, byte: Any) -> None:
        while os.read(int(request[3]), 1):
            calls.append(int(request[0]))
            if len(calls) == 1:
                raise ZeroDivisionError
            os.write(int(request[4]), b"\1")

    return take


def test_a_thread_goes_on_after_a_failure_and_ends_when_it_is_forgotten() -> None:
    before, calls = threads(), []
    thread = StepThread(failing(calls))
    (own,) = threads() - before
    thread.ask(3, 0, 1)
    with pytest.raises(ZeroDivisionError):
        thread.wait()
    thread.ask(4, 1, 1)
    thread.wait()
    assert calls == [3, 4]
    del thread
    gc.collect()
    assert ended(own)


def test_a_thread_that_has_ended_is_not_waited_for() -> None:
    before = threads()
    thread = StepThread(lambda request, byte: None)
    for own in threads() - before:
        assert ended(own)
    with pytest.raises(BrokenPipeError):
        thread.ask(1, 0, 1)
    with pytest.raises(BrokenPipeError):
        thread.wait()


def test_who_has_nothing_in_a_turn_does_not_wait_for_it(
    manager: LiveManager, world: Any, engine: Engine, asked: list[int]
) -> None:
    async def run() -> None:
        pair, packets = await begun(manager, world, engine)
        one, other = pair.sessions
        offered(pair, packets[:3])
        manager.pooled.begin()
        one.settle()
        assert manager.pooled._open, "the thread works on another session's packets"
        other.settle()
        assert not manager.pooled._open

    asyncio.run(run())


def test_a_session_that_ends_waits_for_its_own_packets_alone(
    manager: LiveManager, world: Any, engine: Engine, asked: list[int], unseen: Callable[[], None]
) -> None:
    async def run() -> None:
        pair, packets = await begun(manager, world, engine)
        general(pair, packets[:5])
        asked.clear()
        offered(pair, packets[:3])
        manager.pooled.begin()
        offered(pair, packets[3:5], 3)
        manager.pooled.take(Lane(pair.sessions[0], manager.pooled))
        assert asked == [3], "a session without packets ends while a thread works on those of another"
        assert manager.pooled._open
        manager.pooled.take(pair.pooled.lane)
        assert asked == [3, 2]
        assert not manager.pooled._open
        await pair.settle()
        pair.compare()

    asyncio.run(run())


def test_the_loop_waits_for_no_thread_to_begin_a_turn_and_none_is_forgotten(
    manager: LiveManager, world: Any, engine: Engine, asked: list[int], unseen: Callable[[], None]
) -> None:
    async def run() -> None:
        pair, packets = await begun(manager, world, engine)
        general(pair, packets[:9])
        asked.clear()
        offered(pair, packets[:3])
        manager.pooled.begin()
        offered(pair, packets[3:6], 3)
        manager.pooled.begin()
        assert asked == [3], "what came since waits until the thread is done"
        assert manager.pooled.take_longest_s() > 0.0
        unseen()
        await manager.pooled.between_turns()
        assert not manager.pooled._open
        # The next turn begins by itself, without a timer.
        await asyncio.sleep(0)
        assert asked == [3, 3]
        offered(pair, packets[6:9], 6)
        manager.pooled.turn()
        assert asked == [3, 3, 3]
        await pair.settle()
        pair.compare()

    asyncio.run(run())


def test_who_waits_between_turns_waits_a_moment_where_there_is_no_such_time(
    manager: LiveManager, world: Any, engine: Engine, asked: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(turns, "PATIENCE_S", 0.01)

    async def run() -> None:
        monkeypatch.setattr(manager.pooled, "_end_answered", lambda: None)
        pair, packets = await begun(manager, world, engine)
        offered(pair, packets[:3])
        manager.pooled.begin()
        assert manager.pooled._open
        async with asyncio.timeout(PATIENCE_S):
            await manager.pooled.between_turns()
        assert manager.pooled._open, "its answer was not read"
        manager.pooled.finish()

    asyncio.run(run())


def test_a_turn_whose_failure_fails_too_is_followed_by_the_next(
    manager: LiveManager,
    world: Any,
    engine: Engine,
    asked: list[int],
    unseen: Callable[[], None],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async def run() -> None:
        pair, packets = await begun(manager, world, engine)
        engine_of_turns = manager.pooled

        def fails(*_: Any) -> Any:
            raise FloatingPointError("made for a test")

        offered(pair, packets[:3])
        engine_of_turns.begin()
        monkeypatch.setattr(engine_of_turns, "_show", fails)
        monkeypatch.setattr(engine_of_turns, "_failed", fails)
        offered(pair, packets[3:5], 3)
        engine_of_turns.begin()
        with pytest.raises(FloatingPointError):
            engine_of_turns.finish()
        monkeypatch.undo()
        turns_before = engine_of_turns.turns
        await asyncio.sleep(0)
        assert not engine_of_turns._journals[engine_of_turns._filling].received, "the next turn has begun"
        engine_of_turns.finish()
        assert engine_of_turns.turns == turns_before + 1

    asyncio.run(run())


def test_a_pipe_whose_thread_has_ended_is_not_watched(
    manager: LiveManager, world: Any, engine: Engine, asked: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    """It could be read at any time: the event loop would do nothing else."""

    async def run() -> None:
        pair, packets = await begun(manager, world, engine)
        turns_of = manager.pooled

        def ended(*_: Any) -> None:
            raise BrokenPipeError

        offered(pair, packets[:3])
        turns_of.begin()
        turns_of.finish()
        assert turns_of._watched
        monkeypatch.setattr(SessionPool, "ask", ended)
        offered(pair, packets[3:6], 3)
        turns_of.begin()
        assert not turns_of._watched

    asyncio.run(run())


def test_a_thread_that_dies_with_a_request_loses_no_packet_and_is_not_watched(
    manager: LiveManager, world: Any, engine: Engine, asked: list[int], unseen: Callable[[], None]
) -> None:
    """Seen by the end of its pipe alone, which can be read at any time from then on."""

    async def run() -> None:
        pair, packets = await begun(manager, world, engine)
        pool, session, turns_of = pair.pooled.lane.pool, pair.sessions[1], manager.pooled
        stored = session.ledger.received.highest
        turns_of._forget_answers(pool)
        pool.close()
        pool._thread = StepThread(lambda request, byte: os.read(int(request[3]), 1) and None)
        offered(pair, packets[:3])
        turns_of.begin()
        assert turns_of._open
        assert turns_of._watched == {pool.answers}
        unseen()
        deadline_s = time.monotonic() + PATIENCE_S
        while turns_of._open:
            assert time.monotonic() < deadline_s
            await asyncio.sleep(0.001)
        assert not turns_of._watched
        assert session.ledger.received.highest == stored + 3
        assert not session.line.is_running
        assert pair.sessions[0].line.is_running
        offered(pair, packets[3:6], 3)
        turns_of.turn()
        assert session.ledger.received.highest == stored + 6

    asyncio.run(run())
