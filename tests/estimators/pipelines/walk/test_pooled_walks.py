"""Pooled walks give the bits of `GaitPipeline.step`, whichever of the two takes the next ticks."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from estimators import pipelines
from estimators.body import BodyDimensions
from estimators.calibration import DeviceCalibration, TriadCalibration
from estimators.conventions import SHOE_PLACEMENTS, Placement
from estimators.pipelines import FEET, Frames, GaitPipeline, SessionSetup
from estimators.pipelines.pooled import STRETCH
from estimators.pipelines.walk.pool import WalkPool
from estimators.recording import ImuChunk, SampleQuality
from estimators.simulation import Bout, Leg, gait_preset, simulate_gait

MISSING, BRIDGED, SATURATED = (
    np.uint8(getattr(SampleQuality, n)) for n in ("MISSING", "BRIDGED", "SATURATED")
)
CELLS = {"force_n": slice(0, 3), "moment_nm": slice(3, 6)}
SLOT_ROWS = 64 * 64
"""Rows of a slot of the pools here."""


@cache
def walk(seed: int, with_forces: bool) -> ImuChunk:
    """Half a minute of a walk: four sensors in two shoes with their loads, or one on each foot; with a field."""
    scenario = replace(
        gait_preset("centre_of_mass"), rate_hz=100.0, course=(Bout((Leg(14), Leg(6))),), seed=seed
    )
    sensors = simulate_gait(scenario).recording.sensors
    worn = [sensors[name] for name in (SHOE_PLACEMENTS if with_forces else SHOE_PLACEMENTS[::2])]
    gyroscope, force = (
        np.stack([getattr(one, name) for one in worn]) for name in ("gyroscope_radps", "accelerometer_mps2")
    )
    random = np.random.default_rng(seed)
    field = np.array([2e-5, 0.0, -4e-5]) + 1e-7 * random.normal(size=gyroscope.shape)
    cells = [
        np.stack([getattr(one, name) for one in worn]) if with_forces else None
        for name in ("force_n", "moment_nm")
    ]
    quality = np.zeros(gyroscope.shape[:2], dtype=np.uint8)
    return ImuChunk(0, 0.01, gyroscope, force, field, quality, force_n=cells[0], moment_nm=cells[1])


def spoilt(chunk: ImuChunk, random: np.random.Generator) -> ImuChunk:
    """Leave samples out and bridge some, cut some off, let a sensor freeze, go away and come back, a rate leap."""
    assert chunk.magnetometer_t is not None
    rate, force, field, quality = (
        np.array(values)
        for values in (
            chunk.gyroscope_radps,
            chunk.accelerometer_mps2,
            chunk.magnetometer_t,
            chunk.quality,
        )
    )
    ticks, loads = chunk.tick_count, None if chunk.force_n is None else np.array(chunk.force_n)

    def somewhere(length: int) -> slice:
        first = int(random.integers(50, ticks - length))
        return slice(first, first + length)

    for _ in range(4):
        sensor, gap = random.integers(len(rate)), somewhere(int(random.choice([1, 5, 30])))
        if random.random() < 0.5:
            quality[sensor, gap] |= BRIDGED
        else:
            rate[sensor, gap] = force[sensor, gap] = field[sensor, gap] = np.nan
            quality[sensor, gap] |= MISSING
    # A packet of all sensors, and one sensor for so long that the foot's place is lost.
    quality[:, somewhere(5)] |= MISSING
    quality[random.integers(len(rate)), somewhere(250)] |= MISSING
    quality[random.integers(len(rate)), somewhere(2)] |= SATURATED
    rate[0, somewhere(1)] += 60.0
    still = somewhere(40)
    rate[1, still], force[1, still] = rate[1, still.start], force[1, still.start]
    field[0, somewhere(20)] = np.nan
    if loads is not None:
        loads[random.integers(4), somewhere(20)] = np.nan
    return replace(
        chunk,
        gyroscope_radps=rate,
        accelerometer_mps2=force,
        magnetometer_t=field,
        quality=quality,
        force_n=loads,
    )


def session(seed: int, chunk: ImuChunk) -> GaitPipeline:
    made = pipelines.create(
        SessionSetup(
            pipeline="gait",
            placements=SHOE_PLACEMENTS if chunk.force_n is not None else FEET,
            rate_hz=100.0,
            body=BodyDimensions(stature_m=1.6 + 0.1 * seed),
            feet_apart_m=0.18 if seed else None,
        )
    )
    assert isinstance(made, GaitPipeline)
    return made


def pool_of(like: GaitPipeline, chunk: ImuChunk, sessions: int = 4) -> WalkPool:
    channels = 2 if chunk.magnetometer_t is None else 3
    return WalkPool(like, channels, sessions, sessions * SLOT_ROWS, {} if chunk.force_n is None else CELLS)


def pooled(pool: WalkPool, parts: list[tuple[int, ImuChunk]]) -> list[Frames]:
    """Take a chunk of each slot, or several, in one step; frames of the stretches without an error."""
    stretches = np.zeros(len(parts), dtype=STRETCH)
    values, quality, carried, rows = [np.empty(0)], [np.empty(0, dtype=np.uint8)], [np.empty(0)], 0
    for one, (slot, chunk) in zip(stretches, parts, strict=True):
        one["slot"], one["first_tick"], one["ticks"] = slot, chunk.first_tick, chunk.tick_count
        one["signals_at"], one["quality_at"] = sum(map(len, values)), sum(map(len, quality))
        one["tick_at"] = slot * SLOT_ROWS + rows
        rows += chunk.tick_count
        fields = [chunk.gyroscope_radps, chunk.accelerometer_mps2]
        if chunk.magnetometer_t is not None:
            fields.append(chunk.magnetometer_t)
        values.append(np.stack(fields).ravel())
        quality.append(np.ascontiguousarray(chunk.quality).ravel())
        if chunk.force_n is not None and chunk.moment_nm is not None:
            carried.append(np.concatenate([chunk.force_n, chunk.moment_nm], axis=2).ravel())
    pool.step(stretches, len(parts), *(np.concatenate(part) for part in (values, quality, carried)))
    return [
        pool.frames(chunk.first_tick, int(one["tick_at"]), int(one["tick_at"]) + chunk.tick_count)
        for number, (one, (slot, chunk)) in enumerate(zip(stretches, parts, strict=True))
        if slot not in pool.errors or number < pool.errors[slot][0]
    ]


def assert_same(one: Frames, other: Frames) -> None:
    assert (one.first_tick, one.time_step_s) == (other.first_tick, other.time_step_s)
    for name, values in one.as_stored_live().__dict__.items():
        if isinstance(values, np.ndarray):
            assert values.dtype == getattr(other, name).dtype, name
            assert values.tobytes() == getattr(other, name).tobytes(), (name, one.first_tick)


def assert_same_state(one: GaitPipeline, other: GaitPipeline) -> None:
    expected, found = one.state(), other.state()
    assert expected.keys() == found.keys()
    for name, values in expected.items():
        assert values.tobytes() == found[name].tobytes(), name


def compare(with_forces: bool, with_field: bool, seed: int) -> WalkPool:
    """Give three sessions, one of them sound, to pipelines alone and to such as are pooled most of the time."""
    random = np.random.default_rng(seed)
    chunks = [walk(n, with_forces) for n in range(3)]
    chunks = [chunks[0], *(spoilt(chunk, random) for chunk in chunks[1:])]
    if not with_field:
        chunks = [replace(chunk, magnetometer_t=None) for chunk in chunks]
    alone, mixed = ([session(n, chunk) for n, chunk in enumerate(chunks)] for _ in range(2))
    assert len({WalkPool.key(one) for one in mixed}) == 1
    pool, slots, next_tick = pool_of(mixed[0], chunks[0]), [0, 2, 3], [0, 0, 0]
    free = 1
    joined = [False] * 3
    stops = [chunk.tick_count for chunk in chunks]

    def taken(n: int) -> ImuChunk:
        first = next_tick[n]
        ticks = min(int(random.choice([1, 5, 5, 5, 5, 20, 64, 65])), stops[n] - first)
        next_tick[n] += ticks
        return chunks[n].ticks(first, first + ticks)

    while next_tick != stops:
        parts: list[tuple[int, ImuChunk]] = []
        for n in random.permutation(3).repeat(2).tolist():
            if next_tick[n] == stops[n] or random.random() < 0.3:
                continue
            chunk = taken(n)
            chance = random.random()
            if n in [slots.index(slot) for slot, _ in parts] or chance < 0.95:
                if not joined[n] or chance < 0.1:
                    assert pool.join(slots[n], mixed[n])
                    joined[n] = True
                parts.append((slots[n], chunk))
                continue
            if joined[n] and chance < 0.97:
                pool.leave(slots[n], mixed[n])
                slots[n], free = free, slots[n]
            # By its own step, over the rows or in arrays of its own; it joins again before the next pooled one.
            assert_same(alone[n].step(chunk), mixed[n].step(chunk))
            joined[n] = False
        for (slot, chunk), frames in zip(parts, pooled(pool, parts), strict=True):
            assert_same(alone[slots.index(slot)].step(chunk), frames)
        assert not pool.errors
        for slot, chunk in parts:
            pool.stepped(mixed[slots.index(slot)], chunk.first_tick + chunk.tick_count)
        if random.random() < 0.05:
            for n in range(3):
                assert_same_state(alone[n], mixed[n])
    for n in range(3):
        assert_same_state(alone[n], mixed[n])
        pool.leave(slots[n], mixed[n])
        assert_same_state(alone[n], mixed[n])
    return pool


@pytest.mark.parametrize("with_forces", [False, True], ids=["one sensor", "shoes"])
def test_bits_of_sessions_that_change_between_both_ways(with_forces: bool) -> None:
    pool = compare(with_forces, with_field=not with_forces, seed=0)
    assert min(pool.ordinary, pool.general) > 50, "both ways"


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(1, 21))
def test_bits_of_many_streams(seed: int) -> None:
    compare(with_forces=seed % 2 == 0, with_field=seed % 4 < 2, seed=seed)


@pytest.mark.parametrize("with_forces", [False, True], ids=["one sensor", "shoes"])
def test_nearly_all_of_a_sound_walk_is_taken_by_compiled_code(with_forces: bool) -> None:
    chunk = walk(0, with_forces)
    one = session(0, chunk)
    pool = pool_of(one, chunk, 1)
    assert pool.join(0, one)
    for first in range(0, chunk.tick_count, 5):
        pooled(pool, [(0, chunk.ticks(first, min(first + 5, chunk.tick_count)))])
    share = pool.ordinary / (pool.ordinary + pool.general)
    print(f"{100 * share:.1f} % of {pool.ordinary + pool.general} stretches")
    # Its own step takes the first second, until the first ticks are released.
    assert pool.general <= 1.2 / 0.05


def test_compiled_code_goes_on_soon_after_a_long_gap() -> None:
    chunk = walk(0, False)
    quality = chunk.quality.copy()
    quality[0, 800:1100] |= MISSING
    chunk = replace(chunk, quality=quality)
    one, alone = session(0, chunk), session(0, chunk)
    pool = pool_of(one, chunk, 1)
    assert pool.join(0, one)
    for first in range(0, 1400, 5):
        pooled(pool, [(0, chunk.ticks(first, first + 5))])
        alone.step(chunk.ticks(first, first + 5))
    before = pool.general
    for first in range(1400, chunk.tick_count - 5, 5):
        (frames,) = pooled(pool, [(0, chunk.ticks(first, first + 5))])
        assert_same(alone.step(chunk.ticks(first, first + 5)), frames)
    assert pool.general == before
    assert frames.segment_flags[:, 0].any(), "the foot's place stays lost"


def test_one_that_fails_leaves_its_neighbours_alone() -> None:
    chunk = walk(0, False)
    ones, alone = [session(n, chunk) for n in range(2)], session(1, chunk)
    pool = pool_of(ones[0], chunk)
    for slot, one in enumerate(ones):
        assert pool.join(slot, one)
    pooled(pool, [(0, chunk.ticks(0, 40)), (1, chunk.ticks(0, 40))])
    alone.step(chunk.ticks(0, 40))
    # Ticks of the first are left out.
    parts = [(0, 40, 45), (0, 50, 55), (1, 40, 45), (0, 55, 60), (1, 45, 50)]
    found = pooled(pool, [(slot, chunk.ticks(a, b)) for slot, a, b in parts])
    (number, error), *others = pool.errors.values()
    assert (number, str(error), others) == (1, "chunk starts at tick 50; tick 45 is next", [])
    assert [frames.first_tick for frames in found] == [40, 40, 45]
    for frames in found[1:]:
        assert_same(alone.step(chunk.ticks(frames.first_tick, frames.first_tick + 5)), frames)
    found = pooled(pool, [(1, chunk.ticks(50, 55))])
    assert not pool.errors
    assert_same(alone.step(chunk.ticks(50, 55)), found[0])


def test_a_session_with_a_calibrated_device_takes_its_ticks_itself() -> None:
    chunk = walk(0, False)
    device = DeviceCalibration(accelerometer=TriadCalibration(bias=(0.3, 0.0, -0.2)))
    setup = replace(session(0, chunk).setup, devices={"foot_left": device})
    one, alone = pipelines.create(setup), pipelines.create(setup)
    assert isinstance(one, GaitPipeline)
    pool = pool_of(one, chunk)
    assert pool.join(0, one)
    for first in range(0, 500, 5):
        (frames,) = pooled(pool, [(0, chunk.ticks(first, first + 5))])
        assert_same(alone.step(chunk.ticks(first, first + 5)), frames)
    assert (pool.ordinary, pool.general) == (0, 100)


def test_a_restored_session_joins() -> None:
    chunk = walk(0, True)
    one, alone = session(0, chunk), session(0, chunk)
    pool = pool_of(one, chunk)
    assert pool.join(2, one)
    pooled(pool, [(2, chunk.ticks(first, first + 50)) for first in range(0, 1000, 50)])
    for first in range(0, 1000, 50):
        alone.step(chunk.ticks(first, first + 50))
    pool.stepped(one, 1000)
    restored = session(0, chunk)
    restored.restore(one.state())
    pool.leave(2, one)
    assert pool.join(1, restored)
    (frames,) = pooled(pool, [(1, chunk.ticks(1000, 1050))])
    assert_same(alone.step(chunk.ticks(1000, 1050)), frames)


def test_who_shares_a_pool() -> None:
    setup = session(0, walk(0, True)).setup
    key = WalkPool.key(pipelines.create(setup))
    assert key is not None
    assert key == WalkPool.key(pipelines.create(replace(setup, feet_apart_m=0.3)))
    others: list[SessionSetup] = [
        replace(setup, rate_hz=200.0),
        replace(setup, placements=FEET),
        replace(setup, orientation_parameters={"lag_s": 0.4}),
    ]
    assert key not in [WalkPool.key(pipelines.create(other)) for other in others]
    worn: tuple[Placement, ...] = ("sternum", "upper_arm_right")
    assert WalkPool.key(pipelines.create(SessionSetup("arm", worn, 100.0))) is None
