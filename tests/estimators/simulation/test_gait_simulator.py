"""The simulated walk obeys Newton and Euler, its paths are their own derivatives, and mirrors mirror."""

from dataclasses import replace

import numpy as np
import pytest

from estimators import rotation
from estimators.conventions import GRAVITY_MPS2, SIDES
from estimators.errors import SetupError
from estimators.simulation import Bout, GaitScenario, Leg, gait_preset, simulate_gait

NAMES = ("ankle", "stroke", "shuffling", "stairs", "turns")
UP = np.array([0.0, 0.0, GRAVITY_MPS2])


@pytest.fixture(scope="module")
def walks():
    return {name: simulate_gait(replace(gait_preset(name, 3), errors="ideal")) for name in NAMES}


def short(**changes):
    return GaitScenario(course=(Bout((Leg(4),), 2.0),), stand_before_s=1.5, **changes)


@pytest.mark.parametrize("name", NAMES)
def test_newton_and_euler_hold_to_rounding(walks, name):
    truth = walks[name].truth
    np.testing.assert_allclose(truth.force_n, truth.mass_kg * (truth.com.acceleration + UP), atol=1e-9)
    moment = np.zeros_like(truth.force_n)
    for side in SIDES:
        foot = truth.feet[side]
        moment += np.cross(np.nan_to_num(foot.cop_m) - truth.com.position, foot.force_n)
        moment[:, 2] += foot.free_moment_nm
    np.testing.assert_allclose(moment, truth.momentum_rate_nm, atol=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_load_cells_add_up_to_the_ground_reaction(walks, name):
    for side in SIDES:
        foot = walks[name].truth.feet[side]
        force, moment = np.zeros_like(foot.force_n), np.zeros_like(foot.force_n)
        for part, turn, path in (
            ("heel", foot.heel, foot.heel_sensor), ("forefoot", foot.forefoot, foot.forefoot_sensor),
        ):  # fmt: skip
            carried = rotation.rotate(turn.q, foot.loads[part][0])
            force += carried
            moment += rotation.rotate(turn.q, foot.loads[part][1]) + np.cross(path.position, carried)
        np.testing.assert_allclose(force, foot.force_n, atol=1e-9)
        point = np.nan_to_num(foot.cop_m)
        vertical = foot.free_moment_nm[:, None] * np.array([0.0, 0.0, 1.0])
        np.testing.assert_allclose(moment, np.cross(point, foot.force_n) + vertical, atol=1e-8)


def test_paths_are_their_own_derivatives_and_stances_do_not_slip(walks):
    truth = simulate_gait(replace(gait_preset("ankle", 1), errors="ideal", rate_hz=1000.0)).truth
    foot = truth.feet["left"]
    for path in (truth.com, foot.heel_sensor, foot.forefoot_sensor, foot.ankle):
        # Central differences over 1 ms: h^2/6 of the third derivative, which stays below 1e4 m/s^3.
        slope = (path.position[2:] - path.position[:-2]) / 0.002
        np.testing.assert_allclose(slope, path.velocity[1:-1], atol=2e-3)
        # Where pieces join the jerk steps by at most 2000 m/s^3, which is a quarter of that times 1 ms here.
        slope = (path.velocity[2:] - path.velocity[:-2]) / 0.002
        np.testing.assert_allclose(slope, path.acceleration[1:-1], atol=0.5)
    for name in NAMES:
        for side in SIDES:
            foot = walks[name].truth.feet[side]
            assert np.abs(foot.heel_sensor.velocity[foot.is_flat]).max() < 1e-9
            # The ground does no work on a foot that neither slips nor sinks.
            power = np.zeros(foot.is_flat.size)
            for part, turn, path in (
                ("heel", foot.heel, foot.heel_sensor), ("forefoot", foot.forefoot, foot.forefoot_sensor),
            ):  # fmt: skip
                power += np.sum(rotation.rotate(turn.q, foot.loads[part][0]) * path.velocity, axis=1)
                power += np.sum(rotation.rotate(turn.q, foot.loads[part][1]) * turn.rate, axis=1)
            assert np.abs(power).max() < 1e-6
            assert foot.hinge.position[:, 2].min() > 0.029 - 0.34 * (name == "stairs")


def test_force_is_mean_weight_over_whole_steps_and_impulse_closes(walks):
    truth = walks["ankle"].truth
    weight = truth.mass_kg * GRAVITY_MPS2
    left = truth.feet["left"].land_s[1:-1]
    whole = (truth.time_s >= left[0]) & (truth.time_s < left[-1])
    assert truth.force_n[whole, 2].mean() == pytest.approx(weight, rel=0.01)
    assert np.abs(truth.force_n[whole, :2].mean(axis=0)).max() < 0.01 * weight
    assert np.abs(truth.com.velocity[[0, -1]]).max() < 1e-6
    # The published scale: peak force 1.09 and ankle moment 0.174 of body weight.
    assert 1.0 < np.linalg.norm(truth.force_n, axis=1).max() / weight < 1.25
    moment = np.abs(truth.feet["left"].ankle_moment_nm[:, 1]).max() / weight
    assert 0.14 < moment < 0.22


def test_mirrored_walk_mirrors_truth_and_signals():
    scenario = replace(gait_preset("stroke", 5), course=(Bout((Leg(4), Leg(3, turn_rad=1.0)), 2.0),))
    one, two = simulate_gait(scenario), simulate_gait(scenario.mirrored())
    flip = np.array([1.0, -1.0, 1.0])
    np.testing.assert_allclose(one.truth.com.position * flip, two.truth.com.position, atol=1e-12)
    np.testing.assert_allclose(
        one.truth.feet["left"].force_n * flip, two.truth.feet["right"].force_n, atol=1e-9
    )


def test_facing_turns_the_magnetic_field_only():
    scenario = short(errors="ideal", has_magnetometer=True)
    north, east = simulate_gait(scenario), simulate_gait(replace(scenario, facing_rad=1.2))
    for name, sensor in north.recording.sensors.items():
        other = east.recording.sensors[name]
        np.testing.assert_array_equal(sensor.gyroscope_radps, other.gyroscope_radps)
        np.testing.assert_array_equal(sensor.accelerometer_mps2, other.accelerometer_mps2)
        assert np.abs(sensor.magnetometer_t - other.magnetometer_t).max() > 1e-6


def test_same_scenario_same_bits_and_ideal_sensors_read_the_truth():
    scenario = short(errors="shoe_stress", seed=4)
    one, two = simulate_gait(scenario), simulate_gait(scenario)
    for name, sensor in one.recording.sensors.items():
        np.testing.assert_array_equal(sensor.gyroscope_radps, two.recording.sensors[name].gyroscope_radps)
    clean = simulate_gait(short(errors="ideal", anti_alias=False, seed=4))
    foot, sensor = clean.truth.feet["right"], clean.recording.sensors["heel_right"]
    back = rotation.conjugate(foot.heel.q)
    np.testing.assert_allclose(sensor.gyroscope_radps, rotation.rotate(back, foot.heel.rate), atol=1e-12)
    specific = rotation.rotate(back, foot.heel_sensor.acceleration + UP)
    np.testing.assert_allclose(sensor.accelerometer_mps2, specific, atol=1e-9)
    np.testing.assert_allclose(sensor.force_n, foot.loads["heel"][0], atol=1e-9)
    assert np.std(one.recording.sensors["heel_right"].gyroscope_radps[:100, 0]) == pytest.approx(
        0.01 * np.sqrt(2.0), rel=0.3
    )


def test_impossible_walks_are_refused_in_words():
    with pytest.raises(SetupError, match="no walk is named"):
        gait_preset("moonwalk")
    with pytest.raises(SetupError, match="two steps"):
        simulate_gait(GaitScenario(course=(Bout((Leg(1),)),)))
    with pytest.raises(SetupError, match="rate_hz"):
        simulate_gait(GaitScenario(rate_hz=5.0))
    with pytest.raises(SetupError, match="standing"):
        simulate_gait(GaitScenario(stand_before_s=0.2))
    with pytest.raises(SetupError, match="sensor error model"):
        simulate_gait(short(errors="perfect"))
