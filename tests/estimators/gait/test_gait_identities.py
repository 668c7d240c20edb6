"""A stroke-like walk mirrored, walked toward another point of the compass, and walked backward in time."""

from dataclasses import replace

import numpy as np
import pytest

from estimators.conventions import SIDES
from estimators.gait import find_strides, smooth, summarise
from estimators.recording import SensorSignals
from estimators.simulation import Bout, Leg, gait_preset, simulate_gait

_OF_A_STRIDE = (
    "toe_off_s",
    "contact_s",
    "duration_s",
    "stance_s",
    "swing_s",
    "length_m",
    "length_sigma_m",
    "rise_m",
    "clearance_m",
    "circumduction_m",
    "contact_pitch_rad",
    "toe_off_pitch_rad",
    "toe_out_rad",
    "peak_speed_mps",
)


def scenario(**changes):
    course = (Bout((Leg(10), Leg(4, turn_rad=0.5))),)
    return replace(gait_preset("stroke", 3), course=course, rate_hz=100.0, **changes)


@pytest.fixture(scope="module")
def heels():
    sensors = simulate_gait(scenario()).recording.sensors
    return {side: sensors[f"heel_{side}"] for side in SIDES}


def changed(signals, gyroscope, accelerometer):
    return SensorSignals(
        signals.time_s, signals.gyroscope_radps * gyroscope, signals.accelerometer_mps2 * accelerometer
    )


def agree(one, other, name, **tolerance):
    np.testing.assert_allclose(getattr(other, name), getattr(one, name), err_msg=name, **tolerance)


def test_mirroring_the_patient_mirrors_every_result(heels):
    mirrored = {
        "left": changed(heels["right"], [-1, 1, -1], [1, -1, 1]),
        "right": changed(heels["left"], [-1, 1, -1], [1, -1, 1]),
    }
    one = {side: find_strides(smooth(signals), side) for side, signals in heels.items()}
    two = {side: find_strides(smooth(signals), side) for side, signals in mirrored.items()}
    for side, swapped in (("left", "right"), ("right", "left")):
        assert one[side].count >= 3
        for name in _OF_A_STRIDE:
            agree(one[side], two[swapped], name, atol=1e-7)
        np.testing.assert_allclose(two[swapped].turn_rad, -one[side].turn_rad, atol=1e-9)
        flip = [1, -1, 1]
        holds = one[side].footholds.position_m * flip
        np.testing.assert_allclose(two[swapped].footholds.position_m, holds, atol=1e-9)
    first, second = summarise(one), summarise(two)
    for side, swapped in (("left", "right"), ("right", "left")):
        assert first.feet[side].keys() == second.feet[swapped].keys()
        for name, measure in first.feet[side].items():
            other = second.feet[swapped][name]
            # Everything is outward, a size or a spread: nothing keeps the room's sign.
            np.testing.assert_allclose(other.value, measure.value, atol=1e-6, err_msg=name)
            assert other.count == measure.count > 0, name
    for name, measure in first.asymmetry.items():
        np.testing.assert_allclose(second.asymmetry[name].value, -measure.value, atol=1e-6, err_msg=name)
        np.testing.assert_allclose(second.asymmetry[name].sigma, measure.sigma, atol=1e-6, err_msg=name)


def test_any_compass_direction_gives_the_same_strides():
    def strides(facing_rad):
        walked = scenario(facing_rad=facing_rad, has_magnetometer=True, errors="ideal")
        sensors = simulate_gait(walked).recording.sensors
        return find_strides(smooth(sensors["heel_left"]), "left"), sensors["heel_left"].magnetometer_t

    (north, field), (elsewhere, other_field) = strides(0.0), strides(2.2)
    assert np.abs(field - other_field).max() > 10e-6
    assert north.count >= 3
    for name in (*_OF_A_STRIDE, "turn_rad"):
        # Micrometres and microradians: the tilt's share in a magnetic heading is left out of the filter's measurement.
        agree(north, elsewhere, name, atol=3e-5)


def test_the_smoother_agrees_with_itself_backward_in_time(heels):
    for side, signals in heels.items():
        backward = SensorSignals(
            (signals.time_s[-1] - signals.time_s)[::-1].copy(),
            -signals.gyroscope_radps[::-1],
            signals.accelerometer_mps2[::-1].copy(),
        )
        one, two = smooth(signals), smooth(backward)
        np.testing.assert_array_equal(two.stance.is_stance[::-1], one.stance.is_stance)
        there = find_strides(one, side)
        at = np.searchsorted(one.time_s, there.footholds.quietest_s)
        length = np.linalg.norm(np.diff(two.position_m[::-1][at, :2], axis=0), axis=1)
        # A tenth of what noise does to a stride: only the start and the floor's first level are not symmetric.
        np.testing.assert_allclose(length, there.length_m, atol=5e-4)
        speed = [np.linalg.norm(path.velocity_mps, axis=1) for path in (one, two)]
        np.testing.assert_allclose(speed[1][::-1], speed[0], atol=3e-3)
