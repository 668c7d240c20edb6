"""Pooled arm sessions give the bits of `ArmPipeline.step`, whichever of the two takes the next ticks."""

from dataclasses import replace

import numpy as np
import pytest

from estimators import pipelines, signals
from estimators.conventions import PLACEMENTS
from estimators.pipelines import ArmPipeline, Frames, SessionSetup
from estimators.pipelines.arm.pool import ArmPool
from estimators.pipelines.pooled import STRETCH
from estimators.recording import ImuChunk, SampleQuality
from estimators.simulation import ArmScenario, Schedule, simulate_arm

TICKS = 1200
ARM = ("sternum", "upper_arm_right", "forearm_right", "hand_right")
LEG = ("sternum", "pelvis", "thigh_left", "shank_left", "foot_left")


def session(placements: tuple[str, ...], seed: int) -> tuple[SessionSetup, ImuChunk]:
    """Return the setup of a calibrated session and its samples, some of them unusable."""
    scenario = ArmScenario(
        both_arms=len(placements) > 4,
        exercise="drinking",
        placements=placements,
        schedule=Schedule(n_pose_s=6.0, repetitions=None, duration_s=TICKS / 100 + 12.0),
        seed=seed,
    )
    simulated = simulate_arm(scenario)
    _, setup = pipelines.run(simulated.recording, simulated.setup, pose_s=(2.0, 5.0))
    chunk = signals.to_common_ticks(simulated.recording, setup.rate_hz)
    return setup, spoilt(chunk, np.random.default_rng(seed))


def spoilt(chunk: ImuChunk, random: np.random.Generator) -> ImuChunk:
    """Leave samples out, saturate some, let a sensor freeze and a rate leap."""
    rate, force, field = (
        np.array(values) for values in (chunk.gyroscope_radps, chunk.accelerometer_mps2, chunk.magnetometer_t)
    )
    quality = np.array(chunk.quality)
    for sensor in range(len(rate)):
        for first in random.integers(100, TICKS - 100, 3):
            gap = slice(first, first + int(random.choice([1, 5, 60])))
            for part in (rate, force, field):
                part[sensor, gap] = np.nan
            quality[sensor, gap] |= np.uint8(SampleQuality.MISSING)
        quality[sensor, random.integers(0, TICKS, 5)] |= np.uint8(SampleQuality.SATURATED)
    rate[0, 700] += 60.0
    field[1, 500:640] = field[1, 500]
    rate[-1, 800:850], force[-1, 800:850] = rate[-1, 800], force[-1, 800]
    return replace(
        chunk, gyroscope_radps=rate, accelerometer_mps2=force, magnetometer_t=field, quality=quality
    )


def pooled(pool: ArmPool, parts: list[tuple[int, ArmPipeline, ImuChunk]]) -> list[Frames]:
    """Take a chunk of each session in one step."""
    stretches = np.zeros(len(parts), dtype=STRETCH)
    values, quality, rows = [], [], 0
    for one, (slot, pipeline, chunk) in zip(stretches, parts, strict=True):
        assert pool.join(slot, pipeline)
        one["slot"], one["first_tick"], one["ticks"] = slot, chunk.first_tick, chunk.tick_count
        one["signals_at"] = sum(map(len, values))
        one["quality_at"], one["tick_at"] = sum(map(len, quality)), rows
        rows += chunk.tick_count
        fields = (chunk.gyroscope_radps, chunk.accelerometer_mps2, chunk.magnetometer_t)
        values.append(np.stack(fields).ravel())
        quality.append(np.ascontiguousarray(chunk.quality).ravel())
    pool.step(stretches, len(parts), np.concatenate(values), np.concatenate(quality), np.empty(0))
    found = []
    for one, (_, pipeline, chunk) in zip(stretches, parts, strict=True):
        pool.stepped(pipeline, chunk.first_tick + chunk.tick_count)
        start = int(one["tick_at"])
        found.append(pool.frames(chunk.first_tick, start, start + chunk.tick_count))
    return found


def assert_same(one: Frames, other: Frames) -> None:
    assert one.first_tick == other.first_tick
    for name, values in one.as_stored_live().__dict__.items():
        if isinstance(values, np.ndarray):
            assert values.tobytes() == getattr(other, name).tobytes(), name


@pytest.mark.parametrize("placements", [ARM, PLACEMENTS, LEG], ids=["arm", "body", "leg"])
def test_bits_of_sessions_that_change_between_both_ways(placements: tuple[str, ...]) -> None:
    random = np.random.default_rng(3)
    sessions = [session(placements, seed) for seed in (1, 2)]
    alone: list[ArmPipeline] = [pipelines.create(setup) for setup, _ in sessions]  # type: ignore[misc]
    mixed: list[ArmPipeline] = [pipelines.create(setup) for setup, _ in sessions]  # type: ignore[misc]
    assert ArmPool.key(mixed[0]) == ArmPool.key(mixed[1]) is not None
    pool = ArmPool(mixed[0], 3, 4, 512, {})
    first = 0
    while first < TICKS:
        ticks = int(random.choice([1, 5, 5, 5, 20, 64]))
        chunks = [chunk.ticks(first, min(first + ticks, TICKS)) for _, chunk in sessions]
        expected = [pipeline.step(chunk) for pipeline, chunk in zip(alone, chunks, strict=True)]
        is_pooled = random.random(2) < 0.8
        parts = [(2 * n + 1, mixed[n], chunks[n]) for n in (0, 1) if is_pooled[n]]
        given = iter(pooled(pool, parts) if parts else ())
        for n in (0, 1):
            assert_same(expected[n], next(given) if is_pooled[n] else mixed[n].step(chunks[n]))
        first += ticks
    for n in (0, 1):
        pool.leave(2 * n + 1, mixed[n])
        expected_state, state = alone[n].state(), mixed[n].state()
        assert all(values.tobytes() == state[name].tobytes() for name, values in expected_state.items())


def test_leaving_gives_arrays_of_its_own() -> None:
    setup, chunk = session(ARM, 4)
    one: ArmPipeline = pipelines.create(setup)  # type: ignore[assignment]
    other: ArmPipeline = pipelines.create(setup)  # type: ignore[assignment]
    pool = ArmPool(one, 3, 1, 64, {})
    assert pool.join(0, one)
    pool.leave(0, one)
    assert pool.join(0, other)
    other.step(chunk.ticks(0, 40))
    one.step(chunk.ticks(0, 40))
    assert all(values.tobytes() == one.state()[name].tobytes() for name, values in other.state().items())


def test_who_cannot_be_pooled() -> None:
    setup, _ = session(ARM, 4)
    for changed in (
        replace(setup, calibration=None),
        replace(setup, orientation="vqf"),
        replace(setup, constrain_joint_headings=True),
    ):
        assert ArmPool.key(pipelines.create(changed)) is None
