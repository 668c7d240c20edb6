"""The pooled engine and the general way give the same bits: blocks of frames, final states, what is counted."""

import asyncio
import math
from typing import Any

import numpy as np
import pytest
from sqlalchemy import Engine

from app.limits import Limits
from app.live.bus import MemoryBus, Subscription, topic
from app.live.engine.pools import SessionPool
from app.live.manager import LiveManager
from app.live.session.runner import LiveSession
from app.live.warmup import FIRST, warm_up
from app.network.packet import encode_packet
from app.recordings.signals.group_commit import GroupCommitWriter
from app.settings import Allowance, Settings
from estimators.errors import CalibrationError
from estimators.pipelines import Frames
from tests.app.live.engine.both_ways import MOTION, Faults, Sender, offer, packets_of, worn
from tests.app.live.live_load import connected, remember, swaying

ARM = ("sternum", "upper_arm_right", "forearm_right", "hand_right")
SECONDS = 6.0


@pytest.fixture(autouse=True)
def no_checks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Checks of the first seconds run in a process of their own, whenever it has time."""
    monkeypatch.setattr("app.live.checks.first_seconds.CheckTurns.begin", lambda _: False)


@pytest.fixture(autouse=True)
def by_thread(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Let a pool's thread take turns of several packets, as it does where there is much at once; how many each time."""
    counts: list[int] = []
    ask = SessionPool.ask

    def noted(pool: SessionPool, journal: int) -> None:
        counts.append(pool._count)
        ask(pool, journal)

    monkeypatch.setattr(SessionPool, "ask", noted)
    monkeypatch.setattr("app.live.engine.turns.ASKED", 2)
    monkeypatch.setattr("app.live.engine.pools.CORES", 2)
    return counts


@pytest.fixture(autouse=True)
def shows_all(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where much else runs turns are late, and a view would be shown less."""
    monkeypatch.setattr("app.live.engine.turns.LATE_S", math.inf)


def shown(frames: Subscription) -> bytes:
    """What was published, without its time stamps."""
    return b"".join(item.block[:32] + item.block[40:] for _, item in frames.take())


def stands(session: LiveSession) -> dict[str, Any]:
    """Where a session stands, apart from how long everything took."""
    present = session.health._present
    return {
        "ledger": list(session.ledger.received),
        "clock": (session.clock.highest, session.clock.session_time_us, session.clock.declaration),
        "alignment": (session.aligner.next_tick, session.aligner.next_sequence, session.aligner.waiting),
        "late": (session.aligner.late_packets, session.clock.time_errors, session.duplicates),
        "health": (present.ticks, present.lost.tolist(), present.saturated.tolist()),
        "link": (list(session.skew._minima), session.health._jitter_s, len(session.health.latencies_s)),
        "sensors": [(one.placement, one.status, one.loss_percent) for one in session.health.sensors(True)],
    }


def together(parts: list[Frames]) -> dict[str, Any]:
    """The same whatever the pieces are; every tick once, one behind the other."""
    ticks = [tick for one in parts for tick in range(one.first_tick, one.first_tick + one.tick_count)]
    names = (
        [name for name, values in parts[0].__dict__.items() if isinstance(values, np.ndarray)]
        if parts
        else []
    )
    return {"ticks": ticks} | {
        name: np.concatenate([getattr(one, name) for one in parts]).tobytes() for name in names
    }


def stored(manager: LiveManager, session: LiveSession) -> dict[str, Any]:
    """Frames on their way into the store."""
    return together([frames for _, frames in manager.writer._sessions[session.id].frame_parts])


def seen(listener: Subscription) -> dict[str, Any]:
    """Frames that came at once."""
    return together([item.frames for _, item in listener.take()])


class Pair:
    """Two sessions of the same stream: one is given its packets the general way."""

    def __init__(
        self, general: Sender, pooled: Sender, manager: LiveManager, *, wants_frames: bool = False
    ) -> None:
        self.general, self.pooled, self.manager = general, pooled, manager
        self.sessions = [manager.live(one.intake.session_id) for one in (general, pooled)]
        # Somebody who wants all frames at once makes them come another way.
        self.whole = [manager.bus.subscribe(topic(one.id, "frames"), size=100_000) for one in self.sessions]
        if not wants_frames:
            for listener in self.whole:
                listener.close()
        self.frames = [manager.bus.subscribe(topic(one.id, "blocks"), size=100_000) for one in self.sessions]

    def give(self, packets: list[bytes], random: np.random.Generator) -> None:
        """Give packets, some together in a turn."""
        at_s, left = 100.0, 1
        for data in packets:
            at_s += 0.05
            self.general.take_rare(data, at_s, int(1e9 * at_s))
            offer(self.manager.pooled, self.pooled, data, int(random.integers(1 << 32)), at_s)
            left -= 1
            if left == 0:
                # It ends with whoever looks at the session next.
                self.manager.pooled.finish()
                self.manager.pooled.begin()
                left = int(random.choice([1, 1, 2, 7]))
        self.manager.pooled.turn()

    async def settle(self) -> None:
        for session in self.sessions:
            await session.line.drained()

    def calibrate(self) -> None:
        said = []
        for session in self.sessions:
            last = session.aligner.next_tick
            try:
                session.pipeline.calibrate(session.recent.chunk(max(0, last - 150), last, 0.01), "bias")
                said.append("")
            except CalibrationError as error:
                said.append(error.message)
        assert said[0] == said[1]

    def compare(self) -> None:
        one, other = self.sessions
        assert self.general.refused == self.pooled.refused
        assert stands(one) == stands(other)
        assert shown(self.frames[0]) == shown(self.frames[1])
        assert stored(self.manager, one) == stored(self.manager, other)
        assert seen(self.whole[0]) == seen(self.whole[1])
        assert one.pipeline.setup == other.pipeline.setup
        expected, state = one.pipeline.state(), other.pipeline.state()
        assert expected.keys() == state.keys()
        for name, values in expected.items():
            assert values.tobytes() == state[name].tobytes(), name


async def pair_of(manager: LiveManager, world: Any, stream: Any, *, wants_frames: bool = False) -> Pair:
    made = [await connected(manager, world.subjects["therapist"], world.patient_id, stream) for _ in range(2)]
    senders = [Sender(intake) for intake in made]
    return Pair(senders[0], senders[1], manager, wants_frames=wants_frames)


@pytest.fixture
def manager(engine: Engine, settings: Settings) -> LiveManager:
    # Loading may take longer than a session's gateway waits, where much else runs.
    warm_up(FIRST)
    limits = Limits({"streams": Allowance(1000, 1000, 1000)})
    return LiveManager(engine, GroupCommitWriter(engine), MemoryBus(), lambda _: None, limits=limits)


async def compared(manager: LiveManager, world: Any, engine: Engine, seeds: range) -> tuple[int, int]:
    calibration, whole = swaying(SECONDS)
    remember(engine, world.patient_id, calibration)
    stream = worn(whole, ARM)
    rest = slice(180, 400)
    noise = np.random.default_rng(0).integers(-2, 3, stream.counts[rest].shape, dtype=np.int16)
    stream.counts[rest] = stream.counts[rest.start] + noise
    stream.counts[rest, :, :3] = noise[..., :3]
    for seed in seeds:
        random = np.random.default_rng(seed)
        faults = Faults.draw(random, len(stream.counts), len(ARM))
        pair = await pair_of(manager, world, stream, wants_frames=seed % 3 == 0)
        packets = packets_of(stream, faults, random)
        middle = 13 * len(packets) // 20
        pair.give(packets[:middle], random)
        await pair.settle()
        if seed % 5 == 0:
            # In mid-stream, after a rest: both find the same bias among the ticks they have seen.
            pair.calibrate()
        pair.give(packets[middle:], random)
        await pair.settle()
        try:
            pair.compare()
        except AssertionError as error:
            raise AssertionError(f"seed {seed}: {faults}") from error
        for session in pair.sessions:
            manager._sessions.pop(session.id)
            if session.lane is not None:
                session.lane.leave()
        for frames in (*pair.frames, *pair.whole):
            frames.close()
    return manager.pooled.ordinary, manager.pooled.rare


def test_twenty_streams(manager: LiveManager, world: Any, engine: Engine, by_thread: list[int]) -> None:
    ordinary, rare = asyncio.run(compared(manager, world, engine, range(20)))
    assert ordinary > rare
    assert sum(by_thread) > 0.4 * ordinary


def test_a_long_packet_off_the_grid_harms_nobody(manager: LiveManager, world: Any, engine: Engine) -> None:
    """At the slowest rate that a hello allows, sixty-four ticks of a device are seventy common ones."""

    async def run() -> None:
        calibration, whole = swaying(SECONDS)
        remember(engine, world.patient_id, calibration)
        stream = worn(whole, ARM)
        pair = await pair_of(manager, world, stream)
        packets = []
        for number in range(6):
            counts = np.ascontiguousarray(stream.counts[64 * number : 64 * number + 64])
            time_us = 1_000_000 + 64 * 10_900 * number
            packets.append(
                encode_packet(
                    counts, sequence=number, device_time_us=time_us, tick_interval_us=10_900, channels=MOTION
                )
            )
        pair.give(packets, np.random.default_rng(1))
        await pair.settle()
        pair.compare()
        assert all(session.line.is_running for session in pair.sessions)

    asyncio.run(run())


@pytest.mark.slow("two hundred streams, each with faults of its own")
def test_two_hundred_streams(manager: LiveManager, world: Any, engine: Engine) -> None:
    asyncio.run(compared(manager, world, engine, range(1000, 1200)))


def test_packets_that_share_a_turn_with_the_goodbye_are_not_asked_for(
    manager: LiveManager, world: Any, engine: Engine
) -> None:
    async def leave() -> tuple[int, list[tuple[int, int]]]:
        calibration, whole = swaying(SECONDS)
        remember(engine, world.patient_id, calibration)
        stream = worn(whole, ARM)
        intake = await connected(manager, world.subjects["therapist"], world.patient_id, stream)
        random = np.random.default_rng(0)
        plain = Faults(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, False, (5,), 0.0, (), ())
        sender, packets = Sender(intake), packets_of(stream, plain, random)[:40]
        for number, data in enumerate(packets):
            if number == len(packets) - 2:
                manager.pooled.turn()
            offer(manager.pooled, sender, data, 0, 100.0 + 0.05 * number)
        intake.goodbye(len(packets) - 1)
        manager.pooled.turn()
        waiting = len(manager.live(intake.session_id).lane._taken)  # type: ignore[union-attr]
        asked = []
        for _ in range(3):
            intake._acknowledgements._reviewed_s -= 0.4
            asked += intake.acknowledge().missing
            # What is asked for is cut at the highest that is stored.
            asked += list(manager.live(intake.session_id).now.ledger._asked_s)
        return waiting, asked

    waiting, asked = asyncio.run(leave())
    assert waiting, "the last packets wait in the lane"
    assert asked == []
