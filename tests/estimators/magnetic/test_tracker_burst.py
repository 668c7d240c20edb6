"""Fixes of a moving sensor: carried by inertial signals, with the covariance and the derivative that they claim."""

import functools
from dataclasses import replace

import numpy as np
import pytest

from estimators import rotation
from estimators.errors import ShapeError
from estimators.magnetic import (
    BurstNoise,
    ModuleSignals,
    TrackerFlag,
    TrackerFusionChunk,
    TrackerLimits,
    bursts,
    extract_pulses,
    follow_bursts,
    integrate_gyroscope,
    locate,
    perpendicular_source,
)
from estimators.magnetic.published import locate_moving, middle_tick, pulse_covariance
from estimators.simulation.coils import ModuleErrors, burst_motion, fire_bursts, relative_scene

EXACT = perpendicular_source()
LIMITS = TrackerLimits(gain_sigma=0.0)


@functools.cache
def moving():
    """Six seconds of a walking leg without any noise: scene, signals, bursts; shared, do not write to it."""
    errors = ModuleErrors(0.0, 0.0, 0.0, 0.0, 0.0)
    scene = relative_scene(EXACT, burst_motion("walk_leg", 6.0, 2), 6.0, 120.0, errors, 2)
    signals = ModuleSignals(
        scene.time_step_s,
        scene.gyroscope_radps,
        scene.accelerometer_mps2,
        scene.source_gyroscope_radps,
        scene.source_accelerometer_mps2,
    )
    field, state = fire_bursts(scene)
    attitude = integrate_gyroscope(scene.gyroscope_radps, scene.time_step_s)
    return scene, signals, bursts(extract_pulses(field, state, 1.5, attitude))


def solve(burst, velocity_error=(0.0, 0.0, 0.0)):
    scene, signals, _ = moving()
    k = middle_tick(burst)
    return locate_moving(
        EXACT,
        burst,
        signals,
        k,
        scene.position_m[k],
        scene.q_source_sensor[k],
        scene.velocity_mps[k] + np.asarray(velocity_error),
        limits=LIMITS,
    )


def test_a_moving_sensor_is_found_where_it_is():
    scene, _, gathered = moving()
    off, alone, turns = [], [], []
    for burst in gathered[4:]:
        k = middle_tick(burst)
        fix = solve(burst).fix
        assert fix.usable
        off.append(np.linalg.norm(fix.position_m - scene.position_m[k]))
        turns.append(rotation.angle_between(fix.q_source_sensor, scene.q_source_sensor[k]))
        pulses = np.stack([pulse.field_sensor_t for pulse in burst])
        still = locate(EXACT, np.arange(3), 1.5, pulses, 1.6e-8, last_position_m=scene.position_m[k])
        alone.append(np.linalg.norm(still.position_m - scene.position_m[k]))
    # What is left: the field of a pulse is averaged over 40 ms.
    assert np.sqrt(np.mean(np.square(off))) < 5e-3 < 15e-3 < np.sqrt(np.mean(np.square(alone)))
    assert np.degrees(np.sqrt(np.mean(np.square(turns)))) < 0.7


def test_what_a_wrong_velocity_does_is_what_the_fix_says():
    _, _, gathered = moving()
    for burst in gathered[4:7]:
        found = solve(burst)
        numeric = np.empty((6, 3))
        for axis in range(3):
            ends = []
            for sign in (1.0, -1.0):
                wrong = solve(burst, sign * 0.01 * np.eye(3)[axis]).fix
                turn = rotation.multiply(rotation.conjugate(found.fix.q_source_sensor), wrong.q_source_sensor)
                ends.append(np.concatenate([wrong.position_m, rotation.log(turn)]))
            # Solved too fast is as if the truth were too slow.
            numeric[:, axis] = -(ends[0] - ends[1]) / 0.02
        scale = np.array([[1.0]] * 3 + [[0.45]] * 3)
        assert np.abs((numeric - found.velocity_effect) * scale).max() < 0.006
        assert np.abs(found.velocity_effect * scale).max() > 0.03


@pytest.mark.slow
def test_the_noise_of_a_burst_is_the_claimed_one():
    """Still sensor in the earth's field: magnetometer and gyroscope noise through the extraction, all nine values."""
    rng, dt = np.random.default_rng(4), 1 / 120.0
    state = np.zeros(70, dtype=np.int64)
    state[20:27], state[28:35], state[35:42] = 1, 2, 3
    earth = np.array([2e-5, 0.0, -4.5e-5])
    draws = []
    for _ in range(300):
        attitude = integrate_gyroscope(rng.normal(0.0, 0.02, (70, 3)), dt)
        burst = bursts(extract_pulses(earth + rng.normal(0.0, 3e-8, (70, 3)), state, 1.5, attitude))[0]
        draws.append(np.concatenate([pulse.field_sensor_t for pulse in burst]))
    claimed = pulse_covariance(burst, dt, BurstNoise(3e-8, 0.02))
    root = np.linalg.cholesky(claimed)
    whitened = np.linalg.solve(root, np.array(draws).T)
    # 300 draws: the largest of 81 entries is off by 0.2 or so.
    assert np.abs(whitened @ whitened.T / len(draws) - np.eye(9)).max() < 0.35
    magnetometer = pulse_covariance(burst, dt, BurstNoise(3e-8, 1e-9))
    assert np.trace(claimed) > 1.5 * np.trace(magnetometer)
    np.testing.assert_allclose(np.diag(magnetometer)[:3], burst[0].covariance.diagonal(), rtol=1e-3)


@pytest.mark.slow
def test_covariance_of_a_fix_is_that_of_its_draws():
    rng = np.random.default_rng(6)
    _, _, gathered = moving()
    burst, errors = gathered[0], []
    base = solve(burst).fix
    spread = pulse_covariance(burst, 1 / 120.0)
    noise = rng.multivariate_normal(np.zeros(9), spread, 200).reshape(-1, 3, 3)
    for draw in noise:
        noisy = [replace(p, field_sensor_t=p.field_sensor_t + d) for p, d in zip(burst, draw, strict=True)]
        fix = solve(noisy).fix
        turn = rotation.multiply(rotation.conjugate(base.q_source_sensor), fix.q_source_sensor)
        errors.append(np.concatenate([fix.position_m - base.position_m, rotation.log(turn)]))
    whitened = np.linalg.solve(np.linalg.cholesky(base.covariance), np.array(errors).T)
    assert np.mean(whitened**2) == pytest.approx(1.0, abs=0.15)


def test_bursts_are_followed_and_wrong_ones_left_out():
    scene, signals, gathered = moving()
    count = len(scene.time_s)
    chunk = TrackerFusionChunk(
        0,
        scene.time_step_s,
        scene.gyroscope_radps,
        scene.accelerometer_mps2,
        scene.source_accelerometer_mps2,
        scene.q_world_source,
        np.full((count, 4), np.nan),
        np.full((count, 3), np.nan),
        np.full((count, 4), np.nan),
        np.full((count, 6, 6), np.nan),
    )
    exchanged = list(gathered)
    exchanged[3] = [
        replace(gathered[3][k], field_sensor_t=gathered[3][{0: 1, 1: 0, 2: 2}[k]].field_sensor_t)
        for k in range(3)
    ]
    filled, followed = follow_bursts(
        EXACT, exchanged, signals, chunk, direction=scene.position_m[0], limits=LIMITS
    )
    assert [b.used for b in followed] == [k != 3 for k in range(len(followed))]
    assert followed[3].alone.flags & TrackerFlag.WRONG_ORDER
    ticks = np.flatnonzero(np.isfinite(filled.fix_position_m[:, 0]))
    assert ticks.tolist() == [b.tick for b in followed if b.used]
    off = np.linalg.norm(filled.fix_position_m[ticks] - scene.position_m[ticks], axis=1)
    assert off.max() < 0.03
    with pytest.raises(ShapeError, match="one shape"):
        ModuleSignals(0.01, np.zeros((5, 3)), np.zeros((5, 3)), np.zeros((4, 3)), np.zeros((5, 3)))
