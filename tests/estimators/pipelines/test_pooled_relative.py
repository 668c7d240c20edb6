"""Pooled relative-pose sessions give the bits of `RelativePosePipeline.step`, whichever of the two goes on."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from estimators import pipelines
from estimators.errors import ShapeError
from estimators.magnetic import RelativeFlag, RelativePoseFilter, coil_state, perpendicular_source
from estimators.magnetic.relative import layout as at
from estimators.pipelines import Frames, RelativePosePipeline, SessionSetup
from estimators.pipelines._worn_filter import WornPoseFilter
from estimators.pipelines.pooled import STRETCH, Pool, StepPool
from estimators.pipelines.relative.pool import RelativePool
from estimators.recording import Float, ImuChunk, SampleQuality
from estimators.simulation.coils import SourceFaults, relative_motion, relative_scene, run_closed_loop

SOURCE, SECONDS = perpendicular_source(0.06), 20.0
TICKS = int(100 * SECONDS)
SETUP = SessionSetup(
    "relative_pose", ("pelvis", "sternum"), 100.0, orientation_parameters={"gain_sigma": 0.002}
)
MIDDLE = SessionSetup("relative_pose", ("sternum", "pelvis", "head"), 100.0)
"""The source is the second module of three."""
WOUND = replace(
    SETUP, orientation_parameters={"coil_layers": (2, 1), "coil_length_m": 0.01, "full_scale_t": 4.75e-5}
)
COILS: Mapping[str, slice] = {"coil_state": slice(0, 1)}
MORE: Mapping[str, slice] = {"temperature_degc": slice(0, 1), "coil_state": slice(1, 2)}
ROWS = 1024
FAULTS = {
    "sound": SourceFaults(),
    "off": SourceFaults(silent_from_s=9.0),
    "dead": SourceFaults(dead_from_s=8.0),
    "lossy": SourceFaults(lost_share=0.3),
    "miswired": SourceFaults(wired_as=(1, 2, 0), wired_from_s=10.0),
    "clipped": SourceFaults(full_scale_t=4.75e-5),
}


@cache
def played(faults: str, seed: int = 1) -> ImuChunk:
    """Return a source that fires when a filter asks for it, and a sensor beside it."""
    scene = relative_scene(SOURCE, relative_motion("flexion", SECONDS, seed), SECONDS, seed=seed)
    one = RelativePoseFilter(SOURCE, 0.01, {"mounting_direction": (0.05, 0.0, 1.0), "response_s": 0.5})
    _, samples = run_closed_loop(scene, one, FAULTS[faults], seed)

    def both(*first: int) -> Float:
        return np.stack([samples[:, c : c + 3] for c in first])

    state = np.zeros((2, len(samples)))
    state[0] = coil_state(samples[:, at.COIL].astype(int), samples[:, at.CURRENT])
    return ImuChunk(
        0,
        0.01,
        both(at.SOURCE_GYROSCOPE, at.GYROSCOPE),
        both(at.SOURCE_ACCELEROMETER, at.ACCELEROMETER),
        np.stack([scene.source_ambient_t, samples[:, at.FIELD : at.FIELD + 3]]),
        np.zeros(state.shape, dtype=np.uint8),
        coil_state=state,
        temperature_degc=np.full(state.shape, 31.0),
    )


def spoilt(chunk: ImuChunk, random: np.random.Generator) -> ImuChunk:
    """Lose samples and a sensor for seconds, saturate, bridge, freeze, leap, and say what no source can do."""
    rate, force, field, state, quality = (
        np.array(values)
        for values in (
            chunk.gyroscope_radps,
            chunk.accelerometer_mps2,
            chunk.magnetometer_t,
            chunk.coil_state,
            chunk.quality,
        )
    )
    for module in range(2):
        for length in (1, 3, 40, 200):
            first = int(random.integers(300, TICKS - 210))
            for values in (rate, force, field):
                values[module, first : first + length] = np.nan
            state[module, first : first + length] = np.nan
            quality[module, first : first + length] |= np.uint8(SampleQuality.MISSING)
        quality[module, random.integers(0, TICKS, 5)] |= np.uint8(SampleQuality.SATURATED)
        quality[module, random.integers(0, TICKS, 9)] |= np.uint8(SampleQuality.BRIDGED)
    rate[0, random.integers(300, TICKS, 3)] += 60.0
    first = int(random.integers(300, TICKS - 80))
    rate[0, first : first + 70], force[0, first : first + 70] = rate[0, first], force[0, first]
    state[0, random.integers(300, TICKS, 4)] = [7.13, 0.4, np.inf, -1.2]
    state[1, random.integers(300, TICKS, 2)] = 1.13
    return replace(
        chunk,
        gyroscope_radps=rate,
        accelerometer_mps2=force,
        magnetometer_t=field,
        coil_state=state,
        quality=quality,
    )


def of_modules(chunk: ImuChunk, rows: Sequence[int]) -> ImuChunk:
    """Return a session of these modules."""
    fields = {name: values for name, values in chunk.__dict__.items() if isinstance(values, np.ndarray)}
    return replace(chunk, **{name: values[list(rows)] for name, values in fields.items()})


def given(pool: Pool, parts: list[tuple[int, ImuChunk]], carried: Mapping[str, slice]) -> list[int]:
    """Take chunks of some sessions in one step; return the first row of each."""
    stretches = np.zeros(len(parts), dtype=STRETCH)
    values, quality, beside = [], [], []
    used: dict[int, int] = {}
    for one, (slot, chunk) in zip(stretches, parts, strict=True):
        one["slot"], one["first_tick"], one["ticks"] = slot, chunk.first_tick, chunk.tick_count
        one["signals_at"], one["quality_at"] = sum(map(len, values)), sum(map(len, quality))
        one["tick_at"] = slot * (ROWS // pool.sessions) + used.get(slot, 0)
        used[slot] = used.get(slot, 0) + chunk.tick_count
        fields = [chunk.gyroscope_radps, chunk.accelerometer_mps2]
        if chunk.magnetometer_t is not None:
            fields.append(chunk.magnetometer_t)
        values.append(np.stack(fields).ravel())
        quality.append(np.ascontiguousarray(chunk.quality).ravel())
        if carried:
            beside.append(np.stack([getattr(chunk, name) for name in carried], axis=2).ravel())
    found = np.concatenate(beside) if carried else np.empty(0)
    pool.step(stretches, len(parts), np.concatenate(values), np.concatenate(quality), found)
    rows: list[int] = stretches["tick_at"].tolist()
    return rows


def assert_same(one: Frames, other: Frames) -> None:
    for name, values in one.as_stored_live().__dict__.items():
        given_instead = getattr(other, name)
        if isinstance(values, np.ndarray):
            assert values.dtype == given_instead.dtype, name
            assert values.tobytes() == given_instead.tobytes(), name
        else:
            assert values == given_instead, name


def assert_same_state(one: RelativePosePipeline, other: RelativePosePipeline) -> None:
    expected, state = one.state(), other.state()
    assert expected.keys() == state.keys()
    for name, values in expected.items():
        assert values.tobytes() == state[name].tobytes(), name


def created(setup: SessionSetup) -> RelativePosePipeline:
    pipeline = pipelines.create(setup)
    assert isinstance(pipeline, RelativePosePipeline)
    return pipeline


@pytest.fixture
def bursts(monkeypatch: pytest.MonkeyPatch) -> list[object]:
    """Filters that had a burst solved."""
    solved: list[object] = []
    handle = WornPoseFilter.handle_event

    def noted(one: WornPoseFilter) -> None:
        solved.append(one)
        handle(one)

    monkeypatch.setattr(WornPoseFilter, "handle_event", noted)
    return solved


STREAMS = {
    "sound": (SETUP, [("sound", 1, False), ("off", 1, False)], COILS),
    "spoilt": (SETUP, [("sound", 2, True), ("lossy", 1, True)], COILS),
    "faulty": (SETUP, [("dead", 1, False), ("miswired", 1, True)], MORE),
    "clipped": (WOUND, [("clipped", 1, False), ("clipped", 1, True)], COILS),
    "three modules": (MIDDLE, [("sound", 1, True), ("lossy", 1, False)], MORE),
    "no states": (SETUP, [("sound", 1, False), ("sound", 2, True)], {}),
    "no field": (SETUP, [("sound", 1, False), ("sound", 1, True)], COILS),
}


@pytest.mark.parametrize("stream", STREAMS)
def test_bits_of_sessions_that_change_between_both_ways(stream: str, bursts: list[object]) -> None:
    setup, drawn, carried = STREAMS[stream]
    random = np.random.default_rng(3)
    chunks = []
    for faults, seed, is_spoilt in drawn:
        whole = played(faults, seed)
        if is_spoilt:
            whole = spoilt(whole, random)
        if setup is MIDDLE:
            whole = of_modules(whole, (1, 0, 1))
        if not carried:
            whole = replace(whole, coil_state=None)
        if stream == "no field":
            whole = replace(whole, magnetometer_t=None)
        chunks.append(whole)
    others = replace(setup, orientation_parameters={**setup.orientation_parameters, "current_a": 1.1})
    setups = [setup, others]
    alone, mixed = [created(one) for one in setups], [created(one) for one in setups]
    assert RelativePool.key(mixed[0]) == RelativePool.key(mixed[1]) is not None
    channels = 2 if chunks[0].magnetometer_t is None else 3
    pool = RelativePool(mixed[0], channels, 4, ROWS, carried)
    first, slots, seen = [0, 0], [1, 3], []
    while min(first) < TICKS:
        parts: list[tuple[int, ImuChunk]] = []
        expected: list[Frames] = []
        # What is not pooled goes first: the engine does not mix both in a turn either.
        is_pooled = random.random(2) < 0.8
        for n in random.permutation([0, 1, 0, 1, 1, 0]).tolist():
            ticks = min(int(random.choice([1, 5, 5, 5, 20, 64])), TICKS - first[n])
            if not ticks:
                continue
            chunk = chunks[n].ticks(first[n], first[n] + ticks)
            first[n] += ticks
            frames = alone[n].step(chunk)
            seen.append(frames)
            if is_pooled[n]:
                assert pool.join(slots[n], mixed[n])
                parts.append((slots[n], chunk))
                expected.append(frames)
            else:
                assert_same(frames, mixed[n].step(chunk).as_stored_live())
        if parts:
            rows = given(pool, parts, carried)
            assert not pool.errors
            for frames, (slot, chunk), row in zip(expected, parts, rows, strict=True):
                pool.stepped(mixed[slots.index(slot)], chunk.first_tick + chunk.tick_count)
                assert_same(frames, pool.frames(chunk.first_tick, row, row + chunk.tick_count))
        if random.random() < 0.1:
            # Away from the pool and to another slot, as after a restart.
            n = int(random.integers(2))
            pool.leave(slots[n], mixed[n])
            slots[n] ^= 1
        if random.random() < 0.1:
            mixed[1].restore(mixed[1].state())
    for n in (0, 1):
        assert_same_state(alone[n], mixed[n])
        pool.leave(slots[n], mixed[n])
        assert_same_state(alone[n], mixed[n])
    names = seen[0].layout.scalars
    said = np.bitwise_or.reduce(
        np.concatenate([one.scalar[:, names.index("sternum_state")] for one in seen]).astype(int)
    )
    wanted = {
        "sound": RelativeFlag.INERTIAL_ONLY | RelativeFlag.MISSING_PULSE,
        "spoilt": RelativeFlag.GAP | RelativeFlag.FAULT,
        "faulty": RelativeFlag.FAULT | RelativeFlag.DISTURBED,
        "clipped": RelativeFlag.SATURATED,
    }.get(stream, RelativeFlag.SOUND)
    assert said & wanted == wanted
    assert len(bursts) > 0 or stream.startswith("no")


def test_an_ordinary_session_is_left_for_python_at_its_start_alone(
    bursts: list[object], monkeypatch: pytest.MonkeyPatch
) -> None:
    one, chunk = created(SETUP), played("sound")
    monkeypatch.setattr(one, "step", lambda _: pytest.fail("one by one"))
    pool = RelativePool(one, 3, 4, ROWS, COILS)
    assert pool.join(2, one)
    known = 0
    for first in range(0, TICKS, 5):
        part = chunk.ticks(first, first + 5)
        row = given(pool, [(2, part)], COILS)[0]
        scalar = pool.frames(first, row, row + 5).scalar
        known += int(np.isfinite(scalar[:, one.layout.scalars.index("sternum_distance_m")]).sum())
        pool.stepped(one, first + 5)
    assert known > 0.7 * TICKS
    assert len(bursts) <= 2, "of 400 stretches"


def test_frames_are_those_of_a_pool_that_calls_pipelines(bursts: list[object]) -> None:
    pools = [kind(created(MIDDLE), 3, 4, ROWS, MORE) for kind in (RelativePool, StepPool)]
    chunk = of_modules(played("lossy"), (1, 0, 1))
    for pool in pools:
        assert pool.join(0, created(MIDDLE))
    for first in range(0, TICKS, 100):
        frames = []
        for pool in pools:
            parts = [(0, chunk.ticks(k, k + 20)) for k in range(first, first + 100, 20)]
            row = given(pool, parts, MORE)[0]
            frames.append(pool.frames(first, row, row + 100))
        assert_same(frames[1], frames[0])
    assert bursts


def test_a_session_that_fails_leaves_its_neighbours_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    alone, broken, sound = (created(SETUP) for _ in range(3))

    def fail() -> None:
        raise ShapeError("no solution")

    monkeypatch.setattr(broken.filters["sternum"], "handle_event", fail)
    pool = RelativePool(sound, 3, 4, ROWS, COILS)
    assert pool.join(0, broken)
    assert pool.join(1, sound)
    chunk, raised = played("sound"), []
    for first in range(0, 600, 30):
        slots = (1,) if raised else (0, 1)
        parts = [(slot, chunk.ticks(k, k + 10)) for k in range(first, first + 30, 10) for slot in slots]
        rows = given(pool, parts, COILS)
        for (slot, part), row in zip(parts, rows, strict=True):
            if slot == 1:
                assert_same(alone.step(part), pool.frames(part.first_tick, row, row + 10))
        if pool.errors:
            assert pool.errors.keys() == {0}
            number, error = pool.errors[0]
            assert parts[number][0] == 0
            assert isinstance(error, ShapeError)
            raised.append(number)
            pool.leave(0, broken)
        pool.stepped(sound, first + 30)
    assert len(raised) == 1
    assert_same_state(alone, sound)


def test_leaving_gives_arrays_of_its_own() -> None:
    one, other = created(SETUP), created(SETUP)
    chunk = played("sound")
    pool = RelativePool(one, 3, 1, ROWS, COILS)
    assert pool.join(0, one)
    pool.leave(0, one)
    assert pool.join(0, other)
    other.step(chunk.ticks(0, 40))
    one.step(chunk.ticks(0, 40))
    assert_same_state(other, one)


def test_who_shares_a_pool() -> None:
    key = RelativePool.key(created(SETUP))
    measured = replace(SETUP, orientation_parameters={"coil_radius_m": 0.05})
    assert RelativePool.key(created(measured)) == key
    for changed in (WOUND, MIDDLE, replace(SETUP, rate_hz=120.0)):
        assert RelativePool.key(created(changed)) not in (key, None)
    arm = SessionSetup("arm", ("sternum", "upper_arm_right"), 100.0)
    assert RelativePool.key(pipelines.create(arm)) is None
