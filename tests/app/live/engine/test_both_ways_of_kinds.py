"""Walks with and without forces, and magnetic sources: the pooled engine and the general way give the same bits."""

import asyncio
import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import count
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from sqlalchemy import Engine

from app.accounts.subject import Subject
from app.database.unit_of_work import unit_of_work
from app.kinds.magnetic.safety import confirm
from app.kinds.magnetic.schemas import MagneticSafetyIn
from app.limits import Limits
from app.live import repository
from app.live.bus import MemoryBus
from app.live.manager import LiveManager
from app.live.session.intake import Intake
from app.live.warmup import warm_up
from app.network.declaration import check_hello
from app.network.messages import HelloMessage
from app.network.packet import PacketFlag, decode_packet, encode_packet, with_flags
from app.recordings import service
from app.recordings.signals.group_commit import GroupCommitWriter
from app.settings import Allowance, Settings
from estimators.channels import CHANNELS
from estimators.gait import FootTracker
from estimators.magnetic.relative import layout as at
from estimators.orientation import DEFAULT
from estimators.pipelines.relative.pool import RelativePool
from estimators.pipelines.walk.pool import WalkPool
from tests.app.live.engine.both_ways import Sender
from tests.app.live.engine.test_both_ways import Pair, stored
from tests.benchmarks.live.parts import Part, magnetic, walks

SECONDS = 14.0


@pytest.fixture(autouse=True)
def no_checks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Checks of the first seconds run in a process of their own, whenever it has time."""
    monkeypatch.setattr("app.live.checks.first_seconds.CheckTurns.begin", lambda _: False)


@pytest.fixture(autouse=True)
def shows_all(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where much else runs turns are late, and a view would be shown less."""
    monkeypatch.setattr("app.live.engine.turns.LATE_S", math.inf)


@pytest.fixture
def manager(engine: Engine, settings: Settings) -> LiveManager:
    # Loading may take longer than a session's gateway waits, where much else runs.
    for pipeline in ("gait", "relative_pose"):
        warm_up((pipeline, DEFAULT))
    limits = Limits({"streams": Allowance(1000, 1000, 1000)})
    return LiveManager(engine, GroupCommitWriter(engine), MemoryBus(), lambda _: None, limits=limits)


async def opened(manager: LiveManager, subject: Subject, patient_id: str, part: Part) -> Intake:
    wanted = part.wanted.model_copy(update={"patient_id": patient_id})
    with unit_of_work(manager.engine) as session:
        made = service.create(session, subject, wanted)
    if wanted.pipeline == "relative_pose":
        safe = MagneticSafetyIn(patient_has_no_implant=True, people_nearby_have_none=True)
        with unit_of_work(manager.engine) as session:
            confirm(session, subject, made.id, safe)
    ticket, _ = repository.give_ticket(manager.engine, subject, made.id, "ingest")
    hello = part.hello(ticket)
    return await manager.open(hello, check_hello(hello))


def shaken(packets: list[bytes], random: np.random.Generator) -> Iterator[bytes]:
    """Packets as a bad link brings them: some lost, some late, some twice, some broken."""
    sent: list[tuple[float, bytes]] = []
    for number, data in enumerate(packets):
        if random.random() < 0.01:
            continue
        if random.random() < 0.005:
            data = data[:40] + bytes([data[40] ^ 1]) + data[41:]
        late = int(random.integers(1, 6)) if random.random() < 0.02 else 0
        sent.append((number + late, data))
        if random.random() < 0.01:
            sent.append((number + int(random.integers(0, 30)), data))
    yield from (data for _, data in sorted(sent, key=lambda one: one[0]))


def listened(pair: Pair, monkeypatch: pytest.MonkeyPatch) -> list[list[Any]]:
    """Events of both sessions from now on."""
    heard: list[list[Any]] = [[], []]
    for session, events in zip(pair.sessions, heard, strict=True):

        def add(kind: str, at_s: float, *rest: Any, to: list[Any] = events, **more: Any) -> None:
            to.append((kind, round(at_s, 6), rest, sorted(more.items())))

        monkeypatch.setattr(session, "add_event", add)
    return heard


@pytest.mark.slow
@pytest.mark.parametrize("make", [walks, magnetic], ids=["walk", "magnetic"])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_the_same_bits_on_a_bad_link(
    manager: LiveManager,
    world: Any,
    monkeypatch: pytest.MonkeyPatch,
    make: Callable[[float], Part],
    seed: int,
) -> None:
    async def run() -> tuple[int, int]:
        part, random = make(SECONDS), np.random.default_rng(seed)
        made = [await opened(manager, world.subjects["therapist"], world.patient_id, part) for _ in range(2)]
        pair = Pair(Sender(made[0]), Sender(made[1]), manager, wants_frames=seed == 1)
        heard = listened(pair, monkeypatch)
        packets = list(part.packets)
        if seed:
            # A stretch of it comes after a lost link.
            for n in range(len(packets) // 3, len(packets) // 2):
                packets[n] = with_flags(packets[n], packets[n][9] | PacketFlag.BACKFILLED)
            packets = list(shaken(packets, random))
        pair.give(packets, random)
        if make is magnetic:
            pool = pair.sessions[1].lane.pool  # type: ignore[union-attr]
            assert pool is not None
            assert isinstance(pool.kind, RelativePool)
        await pair.settle()
        pair.compare()
        if make is walks and seed == 0:
            lane = pair.sessions[1].lane
            assert lane is not None
            assert lane.pool is not None
            assert isinstance(lane.pool.kind, WalkPool)
            assert lane.pool.kind.ordinary > 5 * lane.pool.kind.general
        assert heard[0] == heard[1]
        orders = [one._orders for one in made]
        assert (orders[0] is None) == (make is walks)
        if orders[0] is not None and orders[1] is not None:
            asked = [[queue.get_nowait() for _ in range(queue.qsize())] for queue in (orders[0], orders[1])]
            assert asked[0] == asked[1]
        return manager.pooled.ordinary, manager.pooled.rare

    ordinary, rare = asyncio.run(run())
    assert ordinary > 5 * rare


def as_floats(data: bytes, hello: HelloMessage) -> bytes:
    """A packet of counts with the same values as float32."""
    packet = decode_packet(data)
    scales = [getattr(hello, f"{spec.name}_scale") for spec in CHANNELS if packet.channels & spec.bit]
    widths = [spec.width for spec in CHANNELS if packet.channels & spec.bit]
    return encode_packet(
        (packet.values * np.repeat(scales, widths)).astype("<f4"),
        sequence=packet.sequence,
        device_time_us=packet.device_time_us,
        tick_interval_us=packet.tick_interval_us,
        channels=packet.channels,
    )


def test_counts_of_forces_that_nobody_scaled_are_refused(manager: LiveManager, world: Any) -> None:
    async def run() -> None:
        part = walks(4.0)
        whole = part.hello("")

        def hello(ticket: str) -> HelloMessage:
            return part.hello(ticket).model_copy(update={"force_scale": None})

        unscaled = replace(part, hello=hello)
        made = [
            await opened(manager, world.subjects["therapist"], world.patient_id, unscaled) for _ in range(2)
        ]
        pair = Pair(Sender(made[0]), Sender(made[1]), manager)
        pair.give([as_floats(data, whole) for data in part.packets[:40]], np.random.default_rng(0))
        pair.give(list(part.packets[40:60]), np.random.default_rng(1))
        await pair.settle()
        assert pair.general.refused == ["undeclared_scale"] * 20
        pair.compare()

    asyncio.run(run())


def test_one_that_fails_leaves_its_neighbours_alone(
    manager: LiveManager, world: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Their own step takes every packet, as where samples are missing.
    monkeypatch.setattr(FootTracker, "is_plain", False)

    async def run() -> None:
        part = walks(5.0)
        made = [await opened(manager, world.subjects["therapist"], world.patient_id, part) for _ in range(2)]
        pair = Pair(Sender(made[0]), Sender(made[1]), manager)
        senders = [pair.general, pair.pooled]
        broken, sound = pair.sessions

        def give(packets: list[bytes]) -> None:
            for number, data in enumerate(packets):
                for sender in senders:
                    manager.pooled.offer(sender, memoryview(data), 0, 100.0 + 0.05 * number, 0)
                if number % 3 == 2:
                    manager.pooled.turn()
            manager.pooled.turn()

        give(list(part.packets[:40]))
        assert sound.lane is not None
        assert sound.lane.pool is broken.lane.pool  # type: ignore[union-attr]

        sound_step, steps, shown = broken.pipeline.step, count(), []

        def fail(chunk: Any) -> Any:
            if next(steps):
                raise FloatingPointError("a filter lost its way")
            return sound_step(chunk)

        broken.pipeline.step = fail  # type: ignore[method-assign]
        listener = SimpleNamespace(put=lambda _, block: shown.append(block) or True)
        broken.channels["blocks"].listeners.append(listener)
        give(list(part.packets[40:80]))
        assert len(shown) == 1, "what was estimated before, in the same turn, is shown"
        assert not broken.line.is_running
        assert broken.state == "failed"
        assert sound.line.is_running
        assert [len(one.ledger.received) for one in (broken, sound)] == [80, 80], "stored all the same"
        assert sound.aligner.next_tick > broken.aligner.next_tick
        kept, whole = stored(manager, broken), stored(manager, sound)
        assert kept["ticks"] == whole["ticks"][: len(kept["ticks"])], "stored where they were found"

    asyncio.run(run())


def test_a_burst_that_cannot_be_solved_ends_its_own_session_alone(manager: LiveManager, world: Any) -> None:
    async def run() -> None:
        part = magnetic(6.0)
        made = [await opened(manager, world.subjects["therapist"], world.patient_id, part) for _ in range(2)]
        pair = Pair(Sender(made[0]), Sender(made[1]), manager)
        broken, sound = pair.sessions

        def fail() -> None:
            raise FloatingPointError("no solution")

        broken.pipeline.filters["thigh_right"].handle_event = fail  # type: ignore[attr-defined]
        for number, data in enumerate(part.packets):
            for sender in (pair.general, pair.pooled):
                manager.pooled.offer(sender, memoryview(data), 0, 100.0 + 0.04 * number, 0)
            if number % 3 == 2:
                manager.pooled.turn()
        manager.pooled.turn()
        assert broken.state == "failed"
        assert 0 < broken.aligner.next_tick < sound.aligner.next_tick
        assert sound.line.is_running
        names = sound.pipeline.layout.scalars
        frames = stored(manager, sound)
        assert len(frames["ticks"]) == sound.aligner.next_tick
        scalar = np.frombuffer(frames["scalar"]).reshape(-1, len(names))
        assert np.isfinite(scalar[-1, names.index("thigh_right_distance_m")]), "its own burst was solved"
        assert [len(one.ledger.received) for one in (broken, sound)] == [len(part.packets)] * 2, "all stored"

    asyncio.run(run())


def test_a_session_that_failed_is_not_estimated_further_in_the_same_turn(
    manager: LiveManager, world: Any
) -> None:
    async def run() -> None:
        part = magnetic(6.0)
        made = [await opened(manager, world.subjects["therapist"], world.patient_id, part) for _ in range(2)]
        pair = Pair(Sender(made[0]), Sender(made[1]), manager)
        broken, sound = pair.sessions
        one, calls = broken.pipeline.filters["thigh_right"], count()  # type: ignore[attr-defined]

        def fail() -> None:
            next(calls)
            one.arrays()[5][at.EVENT] = 0
            raise FloatingPointError("no solution")

        one.handle_event = fail
        # All that comes behind the standstill waits for one turn, in which the pool is called several times.
        for number, data in enumerate(part.packets):
            for sender in (pair.general, pair.pooled):
                manager.pooled.offer(sender, memoryview(data), 0, 100.0 + 0.04 * number, 0)
            if number < 50:
                manager.pooled.turn()
        manager.pooled.turn()
        assert (broken.state, sound.line.is_running) == ("failed", True)
        kept, whole = stored(manager, broken), stored(manager, sound)
        failed_at = len(kept["ticks"])
        assert 0 < failed_at < len(whole["ticks"])
        assert kept["ticks"] == whole["ticks"][:failed_at]
        assert next(calls) == 1
        assert [len(one.ledger.received) for one in (broken, sound)] == [len(part.packets)] * 2, "all stored"

    asyncio.run(run())
