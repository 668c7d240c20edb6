"""The relative-pose filter in trouble: a dead magnetometer, limits of the source, a wrong moment, sparse bursts."""

from dataclasses import replace

import numpy as np
import pytest

from estimators import rotation
from estimators.magnetic import RelativeFlag, RelativePoseFilter
from estimators.magnetic.relative import layout as at
from estimators.magnetic.relative.parameters import RelativePoseParameters, to_settings
from estimators.magnetic.relative.watch import account, affordable, retreat
from estimators.simulation.coils import (
    burst_motion,
    fire_bursts,
    relative_motion,
    relative_scene,
    run_closed_loop,
)
from tests.estimators.magnetic.relative_scenes import SOURCE


def played(scene, **parameters):
    own = {"mounting_direction": tuple(scene.position_m[0].tolist())} | parameters
    relative = RelativePoseFilter(SOURCE, scene.time_step_s, own)
    result, samples = run_closed_loop(scene, relative, seed=2)
    return result, samples


def scene_of(movement, seconds, seed=2):
    return relative_scene(SOURCE, relative_motion(movement, seconds, seed), seconds, seed=seed)


@pytest.mark.parametrize("is_stuck", [False, True])
def test_a_magnetometer_that_says_nothing_is_left_alone(is_stuck):
    scene = scene_of("shoulder", 14.0)
    gone = (scene.time_s >= 7.0)[:, None]
    held = scene.ambient_t[700] if is_stuck else np.nan
    scene = replace(
        scene,
        ambient_t=np.where(gone, held, scene.ambient_t),
        per_ampere_t=scene.per_ampere_t * ~gone[:, :, None],
    )
    result, samples = played(scene)
    late, before = scene.time_s >= 8.5, (scene.time_s >= 4.0) & (scene.time_s < 7.0)
    assert not (result.flags[before] & int(RelativeFlag.INERTIAL_ONLY)).any()
    assert (result.flags[late] & int(RelativeFlag.INERTIAL_ONLY)).all()
    assert (result.flags[late] & int(RelativeFlag.FAULT)).any()
    on = samples[:, at.COIL] > 0
    assert on[late].mean() < (0.001 if not is_stuck else 0.3) * on[before].mean() + 0.02
    error = np.linalg.norm(result.position_m - scene.position_m, axis=1)[late]
    assert (error < 3.0 * np.linalg.norm(result.position_sigma_m[late], axis=1)).all()


def test_waiting_doubles_up_to_a_limit():
    settings = to_settings(RelativePoseParameters(), 0.01, 3)
    counters = np.zeros(at.COUNTERS, dtype=np.int64)
    waits = []
    for _ in range(6):
        retreat(settings, counters)
        waits.append(int(counters[at.WAIT_UNTIL]))
    assert waits == [200, 400, 800, 1600, 3000, 3000]


def test_the_source_may_do_so_much_in_a_minute():
    parameters = RelativePoseParameters(most_duty=0.1, most_mean_square_a2=0.1)
    settings = to_settings(parameters, 0.01, 3)
    memory, counters, sample = np.zeros(at.MEMORY), np.zeros(at.COUNTERS, dtype=np.int64), np.zeros(at.SAMPLE)
    sample[at.CURRENT] = 1.0
    used = []
    for tick in range(13000):
        counters[at.TICK] = tick
        sample[at.COIL] = float(affordable(settings, memory, 1.0, 1.0))
        used.append(sample[at.COIL])
        account(sample, settings, memory, counters)
    total = np.concatenate([[0.0], np.cumsum(used)])
    minute = total[6000:] - total[:-6000]
    assert minute.max() <= 600.0
    assert minute.max() > 580.0
    assert total[-1] > 1150.0
    # Half the current may be on for longer, as far as its heat goes.
    assert not affordable(settings, memory, 1e4, 0.5)


@pytest.mark.slow
def test_limits_that_cannot_be_met_end_at_the_budget():
    result, samples = played(scene_of("shoulder", 20.0), position_limit_m=1e-4, most_duty=0.05)
    assert np.sum(samples[:, at.COIL] > 0) * 0.01 <= 0.05 * 60.0 + 1e-9
    sound = result.flags[-1] & int(RelativeFlag.INERTIAL_ONLY) == 0
    assert sound


@pytest.mark.slow
@pytest.mark.parametrize(("strength", "is_wrong"), [(0.8, True), (1.0, False)])
def test_a_moment_other_than_stated_is_told_and_covered(strength, is_wrong):
    scene = scene_of("flexion", 30.0)
    scene = replace(scene, per_ampere_t=strength * scene.per_ampere_t)
    result, _ = played(scene, nis_alarm=1e9)
    told = (result.flags & int(RelativeFlag.DISTURBED)) > 0
    assert told[-500:].all() == is_wrong
    late = scene.time_s > 20.0
    error = (result.position_m - scene.position_m)[late]
    solved = np.linalg.solve(result.covariance[late][:, :3, :3], error[..., None])[..., 0]
    assert np.mean(np.sum(error * solved, axis=1) < 7.81) > 0.9
    # Wrong by 7 % of the distance, and not taken for better than that.
    assert (np.linalg.norm(error, axis=1).mean() > 0.02) == is_wrong


@pytest.mark.slow
def test_a_burst_every_two_seconds_and_a_half_is_enough_for_ten_minutes():
    scene = relative_scene(SOURCE, burst_motion("flexion", 600.0, 1), 600.0, 100.0, seed=1)
    field, state = fire_bursts(scene, cycle_s=2.4, slot_s=0.07)
    samples = np.hstack(
        [
            scene.gyroscope_radps,
            scene.accelerometer_mps2,
            field,
            scene.source_gyroscope_radps,
            scene.source_accelerometer_mps2,
            state[:, None],
            np.where(state > 0, 1.5, 0.0)[:, None],
        ]
    )
    parameters = {
        "mounting_direction": tuple(scene.position_m[0].tolist()),
        "calibration_s": 0.9,
        "baseline_samples": 20,
        "start_baseline_samples": 20,
        "pulse_s": 0.06,
        "start_pulse_s": 0.06,
        "position_limit_m": 10.0,
        "attitude_limit_deg": 170.0,
        "response_s": 10.0,
    }
    relative = RelativePoseFilter(SOURCE, 0.01, parameters)
    out = relative.run(np.ascontiguousarray(samples))
    on = scene.time_s > 6.0
    p, q = out[:, at.O_POSITION : at.O_POSITION + 3], out[:, at.O_ATTITUDE : at.O_ATTITUDE + 4]
    turn = rotation.log(rotation.multiply(rotation.conjugate(scene.q_source_sensor), q))
    error = np.hstack([p - scene.position_m, turn])[on]
    covariance = out[on, at.O_COVARIANCE : at.O_COVARIANCE + 36].reshape(-1, 6, 6)
    solved = np.linalg.solve(covariance, error[..., None])[..., 0]
    assert 0.5 < np.mean(np.sum(error * solved, axis=1)) / 6.0 < 1.4
    assert np.median(np.linalg.norm(error[:, :3], axis=1)) < 0.1
    # Bursts correct: few of the 250 begin anew.
    assert relative.arrays()[5][at.RESTARTED] <= 12
