"""Samples that cannot be true are gaps to every orientation method."""

import numpy as np
import pytest

from estimators import orientation, rotation
from estimators.orientation import OrientationFlag
from estimators.orientation._screen import MEMORY, SampleScreen, _judge
from tests.estimators.orientation.orientation_contract import STEP_S, assert_same_bits, joined, moving_network

BRIDGED_OR_INVALID = int(OrientationFlag.BRIDGED | OrientationFlag.INVALID)
METHODS = sorted(orientation.available())


def wild_network(ticks=700):
    chunk, _ = moving_network(ticks=ticks)
    chunk.gyroscope_radps[0, 150, 1] = -35.0  # at rest
    chunk.gyroscope_radps[0, 500:503, 2] = 30.0  # while it turns
    chunk.gyroscope_radps[1, 400, 0] = 1e38
    chunk.accelerometer_mps2[2, 450, 1] = -1e38
    chunk.magnetometer_t[2, 460] = 1e38
    return chunk


@pytest.mark.parametrize("name", METHODS)
def test_wild_samples_are_flagged_and_do_no_harm(name):
    chunk = wild_network()
    result = orientation.create(name, 3, STEP_S).update(chunk)
    for values in (result.q_earth_sensor, result.gyroscope_bias_radps, result.sigma_rad):
        assert np.isfinite(values).all()
    for sensor, ticks in ((0, [150]), (0, [500, 501, 502]), (1, [400]), (2, [450])):
        assert (result.flags[sensor, ticks] & BRIDGED_OR_INVALID).all()
    sound, _ = moving_network(ticks=700)
    plain = orientation.create(name, 3, STEP_S).update(sound)
    apart = rotation.angle_between(result.q_earth_sensor, plain.q_earth_sensor)
    # The worst is a filter that holds still for three samples of a turn at 2 rad/s.
    assert np.rad2deg(apart.max()) < 5.0
    assert not (plain.flags & int(OrientationFlag.BRIDGED)).any()


@pytest.mark.parametrize("name", METHODS)
@pytest.mark.parametrize("cut", [151, 501])
def test_screening_is_the_same_in_pieces_and_restored(name, cut):
    chunk = wild_network(ticks=520)
    whole = orientation.create(name, 3, STEP_S).update(chunk)
    first, second = orientation.create(name, 3, STEP_S), orientation.create(name, 3, STEP_S)
    results = [first.update(chunk.ticks(0, cut))]
    second.restore(first.state())
    results += [second.update(chunk.ticks(k, k + 1)) for k in range(cut, chunk.tick_count)]
    assert_same_bits(joined(results), joined([whole]))


def test_blows_and_fast_swings_are_left_alone():
    chunk, _ = moving_network(ticks=400)
    swing = 25.0 * np.sin(2 * np.pi * 3.0 * STEP_S * np.arange(300))
    chunk.gyroscope_radps[0, 100:, 2] += swing
    chunk.gyroscope_radps[1, 200, 0] += 14.0  # a heel strike: force and rate leap together
    chunk.accelerometer_mps2[1, 200, 2] += 60.0
    assert SampleScreen(3, STEP_S).screened(chunk) is chunk


def test_a_rate_that_stays_is_believed():
    chunk, _ = moving_network(sensors=1, ticks=200)
    chunk.gyroscope_radps[0, 100:] += 20.0
    screened = SampleScreen(1, STEP_S).screened(chunk)
    assert np.flatnonzero(np.isnan(screened.gyroscope_radps[0, :, 0])).tolist() == [100, 101, 102, 103]


def test_kernel_agrees_with_its_python_twin():
    chunk = wild_network(ticks=520)
    given = (
        chunk.gyroscope_radps,
        chunk.accelerometer_mps2,
        chunk.magnetometer_t,
        chunk.quality,
        STEP_S,
        True,
    )
    memory, twin_memory = np.zeros((2, 3, MEMORY))
    wild, twin_wild = np.zeros((2, *chunk.quality.shape), dtype=np.uint8)
    assert _judge(*given, memory, wild) == _judge.py_func(*given, twin_memory, twin_wild) == 7
    np.testing.assert_array_equal(wild, twin_wild)
    np.testing.assert_allclose(memory, twin_memory, rtol=1e-12)
