"""What one packet and one frame cost, counted: Python calls and memory, which are the same on every machine.

Time is measured by `make bench-live`; a count shows what made it grow, in the commit that did. A count that falls is
written down here, so that it cannot rise again unnoticed.
"""

import asyncio
import sys
import time
import tracemalloc
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from types import FrameType
from typing import Any

import pytest
from sqlalchemy import Engine

from app.limits import Limits
from app.live.bus import MemoryBus, topic
from app.live.manager import LiveManager
from app.live.session.intake import Intake
from app.live.warmup import FIRST, warm_up
from app.network.packet import decode_packet
from app.recordings.signals.group_commit import GroupCommitWriter
from app.settings import Settings
from tests.app.live.engine.both_ways import Sender
from tests.app.live.live_load import connected, remember, swaying

WARM, COUNTED = 220, 60
"""Packets before counting, and counted: windows, memories and second-long sums take part in the mean."""
MARGIN = 1.1

PACKET_CALLS = 228.6
"""Calls of Python and built-in functions for a packet of 17 sensors that nobody watches, the general way; 206.3 before
legs had angles, 180.9 before its state could be shared with the pooled engine."""
POOLED_CALLS = 39.2
"""The same for one taken in a turn with seven others, watched, from the connection to the finished block."""
FRAME_CALLS = 22.0
"""More of them when somebody does, up to the finished block."""
PACKET_BYTES = 18_950
"""Memory that a packet leaves behind until the store has taken it: its bytes and its frames; 16,500 before legs had
angles, eighteen of them."""


@contextmanager
def counted(counts: Counter[str]) -> Iterator[None]:
    """Count calls of this thread by the function called."""

    def note(frame: FrameType, event: str, argument: Any) -> None:
        if event == "call":
            counts[frame.f_code.co_qualname] += 1
        elif event == "c_call":
            counts[f"{frame.f_code.co_qualname} -> {argument.__name__}"] += 1

    sys.setprofile(note)
    try:
        yield
    finally:
        sys.setprofile(None)


def measured(
    engine: Engine, settings: Settings, world: Any, work: Callable[[Callable[..., None]], None]
) -> None:
    """Stream `WARM` packets into a live session, then let `work` give it more."""
    calibration, stream = swaying(20.0)
    remember(engine, world.patient_id, calibration)

    async def run() -> None:
        bus = MemoryBus()
        # The writer does not run: its thread would take part in what is measured of memory.
        writer = GroupCommitWriter(engine)
        manager = LiveManager(
            engine, writer, bus, lambda _: None, limits=Limits({"streams": settings.limit_streams})
        )
        intake = await connected(manager, world.subjects["therapist"], world.patient_id, stream)
        packets = iter([stream.packet(number) for number in range(stream.packet_count)])

        def give(count: int, *, watched: bool) -> None:
            if not watched:
                for _ in range(count):
                    receive(intake, next(packets))
                return
            with bus.subscribe(topic(intake.session_id, "blocks"), size=16) as frames:
                for _ in range(count):
                    receive(intake, next(packets))
                    for _, item in frames.take():
                        assert item.block

        give(WARM, watched=False)
        work(give)
        await manager.stop()

    asyncio.run(run())


@pytest.fixture(scope="module", autouse=True)
def warm() -> None:
    """Loading may take longer than a session's gateway waits, where much else runs."""
    warm_up(FIRST)


@pytest.fixture(autouse=True)
def no_checks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Checks of the first seconds run in a process of their own when it is their turn: here it never is."""
    monkeypatch.setattr("app.live.checks.first_seconds.CheckTurns.begin", lambda _: False)


def receive(intake: Intake, data: bytes) -> None:
    packet = decode_packet(data, intake.declaration)
    assert intake.receive(packet, time.monotonic(), time.time_ns())


def test_calls_of_a_packet_and_of_a_frame(engine: Engine, settings: Settings, world: Any) -> None:
    unwatched, watched = Counter[str](), Counter[str]()

    def work(give: Callable[..., None]) -> None:
        with counted(unwatched):
            give(COUNTED, watched=False)
        with counted(watched):
            give(COUNTED, watched=True)

    measured(engine, settings, world, work)
    packet = unwatched.total() / COUNTED
    frame = (watched.total() - unwatched.total()) / COUNTED
    most = "\n".join(f"{count / COUNTED:6.1f} {name}" for name, count in watched.most_common(40))
    assert packet <= MARGIN * PACKET_CALLS, f"{packet:.1f} calls a packet, {PACKET_CALLS:.1f} before:\n{most}"
    assert frame <= MARGIN * FRAME_CALLS, f"{frame:.1f} calls a frame, {FRAME_CALLS:.1f} before:\n{most}"
    assert packet >= PACKET_CALLS / MARGIN, f"{packet:.1f} calls a packet: write the better figure down"
    assert frame >= FRAME_CALLS / MARGIN, f"{frame:.1f} calls a frame: write the better figure down"


def test_calls_of_a_packet_that_is_taken_in_a_turn(engine: Engine, settings: Settings, world: Any) -> None:
    calibration, stream = swaying(20.0)
    remember(engine, world.patient_id, calibration)
    counts = Counter[str]()
    turns = COUNTED // 2

    async def run() -> None:
        bus = MemoryBus()
        manager = LiveManager(
            engine,
            GroupCommitWriter(engine),
            bus,
            lambda _: None,
            limits=Limits({"streams": settings.limit_streams}),
        )
        made = [
            await connected(manager, world.subjects["therapist"], world.patient_id, stream) for _ in range(8)
        ]
        senders = [Sender(intake) for intake in made]
        views = [bus.subscribe(topic(one.session_id, "blocks"), size=16) for one in made]
        for number in range(WARM + turns):
            data = stream.packet(number)
            with counted(counts) if number >= WARM else nullcontext():
                for sender in senders:
                    arrival_s = 100.0 + 0.05 * number
                    manager.pooled.offer(sender, memoryview(data), 0, arrival_s, int(1e9 * arrival_s))
                manager.pooled.turn()
            for frames in views:
                for _, item in frames.take():
                    assert item.frame
        assert manager.pooled.rare <= len(senders)
        await manager.stop()

    asyncio.run(run())
    packet = counts.total() / turns / 8
    most = "\n".join(f"{count / turns / 8:6.1f} {name}" for name, count in counts.most_common(40))
    print("MOST", packet, most)
    assert packet <= MARGIN * POOLED_CALLS, f"{packet:.1f} calls a packet, {POOLED_CALLS:.1f} before:\n{most}"
    assert packet >= POOLED_CALLS / MARGIN, f"{packet:.1f} calls a packet: write the better figure down"


def test_memory_that_a_packet_leaves_behind(engine: Engine, settings: Settings, world: Any) -> None:
    kept: list[int] = []

    def work(give: Callable[..., None]) -> None:
        tracemalloc.start()
        try:
            before, _ = tracemalloc.get_traced_memory()
            give(COUNTED, watched=False)
            kept.append((tracemalloc.get_traced_memory()[0] - before) // COUNTED)
        finally:
            tracemalloc.stop()

    measured(engine, settings, world, work)
    assert kept[0] <= MARGIN * PACKET_BYTES, f"{kept[0]} bytes a packet, {PACKET_BYTES} before"
