"""Our own filter and smoother begun anywhere: in movement, upside down, falling, beside magnets, after gaps."""

import numpy as np
import pytest

from estimators import orientation, rotation
from estimators.conventions import GRAVITY_MPS2
from estimators.orientation import OrientationFlag
from estimators.recording import ImuChunk, SampleQuality

STEP_S = 0.01
FIELD_UT = np.array([0.0, 19.0, -45.0])
UP = np.array([0.0, 0.0, GRAVITY_MPS2])
SENSORS = 8
CONVERGING, INVALID = int(OrientationFlag.CONVERGING), int(OrientationFlag.INVALID)


def moved(
    seconds, seed=1, *, turning=4.0, shaking=15.0, still_s=0.0, falling_s=0.0, field_ut=None, sensors=SENSORS
):
    """Sensors that turn and are shaken from the first sample on; or rest, or fall, first. Chunk and true q.

    Parameters
    ----------
    turning, shaking : float
        Largest rate of an axis, rad/s, and acceleration, m/s^2, of about that size.
    field_ut : callable, optional
        Disturbance in the earth frame at each time, (K,) to (K, 3).
    """
    rng = np.random.default_rng(seed)
    ticks = round(seconds / STEP_S)
    time_s = STEP_S * np.arange(ticks)
    moves = np.where(time_s < still_s, 0.0, 1.0)[:, None]
    rate = np.zeros((sensors, ticks, 3))
    acceleration = np.zeros((sensors, ticks, 3))
    for _ in range(3):
        for values, size, low, high in ((rate, turning, 0.2, 1.2), (acceleration, shaking, 1.0, 2.5)):
            wave = 2 * np.pi * rng.uniform(low, high, (sensors, 1, 3)) * time_s[:, None]
            values += size / 3 * np.sin(wave + rng.uniform(0, 2 * np.pi, (sensors, 1, 3)))
    rate, acceleration = rate * moves, acceleration * moves
    acceleration[:, time_s < falling_s] = -UP
    q = np.empty((sensors, ticks, 4))
    q[:, 0] = rotation.normalize(rng.standard_normal((sensors, 4)))
    steps = rotation.exp(STEP_S * rate)
    for k in range(1, ticks):
        q[:, k] = rotation.normalize(rotation.multiply(q[:, k - 1], steps[:, k]))
    middle = rotation.multiply(q, rotation.exp(-0.5 * STEP_S * rate))
    field = FIELD_UT + (0.0 if field_ut is None else field_ut(time_s))
    shape = rate.shape
    chunk = ImuChunk(
        0,
        STEP_S,
        rate * (1.0 + 0.002 * rng.standard_normal((sensors, 1, 3)))
        + np.deg2rad(0.3) * rng.standard_normal((sensors, 1, 3))
        + 0.004 * rng.standard_normal(shape),
        rotation.rotate(rotation.conjugate(middle), UP + acceleration) + 0.05 * rng.standard_normal(shape),
        1e-6 * (rotation.rotate(rotation.conjugate(q), field) + 0.3 * rng.standard_normal(shape)),
        np.zeros(shape[:2], dtype=np.uint8),
    )
    return chunk, q


def online(chunk, parameters=None):
    return orientation.create("telemotion", chunk.sensor_count, STEP_S, parameters).update(chunk)


def offline(chunk):
    return orientation.smooth("telemotion_smoother", chunk).orientation


def errors(result, truth):
    return rotation.log(rotation.multiply(result.q_earth_sensor, rotation.conjugate(truth)))


def degrees(result, truth):
    return np.rad2deg(np.linalg.norm(errors(result, truth), axis=-1))


def contradicted(result, truth):
    """Where the error leaves the region of four sigma although the filter says that it has converged."""
    off = np.abs(errors(result, truth)) > 4.0 * result.sigma_rad
    return off.any(axis=-1) & ((result.flags & (CONVERGING | INVALID)) == 0)


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize(("turning", "shaking"), [(4.0, 15.0), (0.05, 25.0), (8.0, 5.0)])
def test_a_start_in_fast_movement_is_found_within_seconds(seed, turning, shaking):
    chunk, truth = moved(40.0, seed, turning=turning, shaking=shaking)
    result = online(chunk)
    assert (result.flags[:, :100] & CONVERGING).all()
    assert not (result.flags[:, 800:] & CONVERGING).any()
    assert degrees(result, truth)[:, 800:].max() < 10.0
    assert degrees(result, truth)[:, 2000:].max() < 6.0
    assert contradicted(result, truth).mean() < 0.01


@pytest.mark.parametrize("shaking", [15.0, 25.0])
def test_before_it_has_converged_the_stated_sigma_is_wide_enough(shaking):
    squares = []
    for seed in range(6):
        chunk, truth = moved(6.0, seed, shaking=shaking)
        result = online(chunk)
        squares.append(((errors(result, truth) / result.sigma_rad) ** 2).sum(axis=-1)[:, :500])
    assert np.mean(np.array(squares) < 7.815) > 0.9


def test_the_head_of_a_recording_begun_in_movement_is_right_when_looking_back():
    for seed in (1, 2):
        chunk, truth = moved(40.0, seed)
        result = offline(chunk)
        assert degrees(result, truth).max() < 3.0
        assert not (result.flags & CONVERGING).any()


@pytest.mark.parametrize("turn", [(np.pi, 0.0, 0.0), (0.0, np.pi, 0.0), (np.pi - 1e-9, 1e-9, 0.0)])
@pytest.mark.parametrize("shaking", [0.0, 15.0])
def test_upside_down_is_an_attitude_like_any_other(turn, shaking):
    chunk, truth = moved(30.0, turning=1e-6, shaking=shaking)
    over = rotation.multiply(rotation.conjugate(truth[:, :1]), rotation.exp(np.array(turn)))
    turned = ImuChunk(
        0,
        STEP_S,
        chunk.gyroscope_radps,
        rotation.rotate(rotation.conjugate(over), chunk.accelerometer_mps2),
        rotation.rotate(rotation.conjugate(over), chunk.magnetometer_t),
        chunk.quality,
    )
    for result in (online(turned), offline(turned)):
        assert degrees(result, rotation.multiply(truth, over))[:, 800:].max() < 6.0


@pytest.mark.parametrize("falling_s", [0.3, 1.0, 2.0])
def test_a_start_in_free_fall_waits_for_force(falling_s):
    chunk, truth = moved(30.0, falling_s=falling_s, shaking=8.0)
    result = online(chunk)
    fallen = round(falling_s / STEP_S)
    assert (result.flags[:, : fallen + 200] & CONVERGING).all()
    assert (result.sigma_rad[:, 10 : fallen - 5, :2] > np.deg2rad(20.0)).all()
    assert degrees(result, truth)[:, fallen + 800 :].max() < 8.0
    assert contradicted(result, truth).mean() < 0.01
    assert degrees(offline(chunk), truth).max() < 8.0


@pytest.mark.parametrize("still_s", [0.0, 6.0])
def test_a_start_beside_a_magnet_is_right_once_it_is_gone(still_s):
    def passing(time_s):
        return np.where(time_s < 6.0, 1.0, 0.0)[:, None] * np.array([25.0, -10.0, 10.0])

    chunk, truth = moved(90.0, field_ut=passing, shaking=8.0, still_s=still_s)
    result = online(chunk)
    assert np.sqrt(np.mean(degrees(result, truth)[:, -2000:] ** 2)) < 8.0
    # Once the field has changed, half a minute at most goes by until the heading is right or stated as lost.
    assert not contradicted(result, truth)[:, 3600:].any()
    assert np.sqrt(np.mean(degrees(offline(chunk), truth)[:, -2000:] ** 2)) < 8.0


def test_a_magnet_in_passing_is_not_taken_for_the_field_after_a_start_in_movement():
    def passing(time_s):
        return (np.abs(time_s - 45.0) < 12.0)[:, None] * np.array([25.0, -10.0, 10.0])

    chunk, truth = moved(70.0, field_ut=passing, shaking=8.0)
    assert degrees(online(chunk), truth)[:, 2500:].max() < 8.0


@pytest.mark.parametrize("gap_s", [0.25, 1.0, 7.0, 20.0])
@pytest.mark.parametrize("still_s", [0.0, 6.0])
def test_after_a_gap_in_movement_it_is_found_again_whatever_its_length(gap_s, still_s):
    chunk, truth = moved(30.0 + gap_s, still_s=still_s)
    start, stop = 1000, 1000 + round(gap_s / STEP_S)
    for values in (chunk.gyroscope_radps, chunk.accelerometer_mps2, chunk.magnetometer_t):
        values[:, start:stop] = np.nan
    chunk.quality[:, start:stop] = int(SampleQuality.MISSING)
    result = online(chunk)
    assert (result.flags[:, start + 21 : stop] & INVALID).all()
    assert (result.flags[:, stop : stop + 100] & CONVERGING).all()
    assert contradicted(result, truth).mean() < 0.01
    assert degrees(result, truth)[:, stop + 800 :].max() < 10.0
    smoothed = offline(chunk)
    seen = np.ones(chunk.tick_count, dtype=bool)
    seen[start - 20 : stop + 20] = False
    assert (
        degrees(smoothed, truth)[:, seen].max() < 6.0
    )  # a few seconds before the gap are all the first part has


def test_a_filter_that_was_turned_over_starts_over_and_says_so():
    """While its gyroscope is silent the sensor is laid on its side: force says so, and the tilt is found again."""
    chunk, truth = moved(40.0, turning=1e-6, shaking=0.0, still_s=40.0)
    aside = rotation.exp(np.array([1.2, 0.3, 0.0]))
    later = np.arange(chunk.tick_count) >= 1500
    turned = np.where(later[:, None], rotation.multiply(truth, aside), truth)
    relative = rotation.multiply(rotation.conjugate(turned), truth)
    chunk = ImuChunk(
        0,
        STEP_S,
        chunk.gyroscope_radps,
        rotation.rotate(relative, chunk.accelerometer_mps2),
        rotation.rotate(relative, chunk.magnetometer_t),
        chunk.quality,
    )
    result = online(chunk)
    began = (result.flags & CONVERGING)[:, 1500:] != 0
    assert began.any(axis=1).all()
    assert (began.argmax(axis=1) < 650).all()
    assert degrees(result, turned)[:, -1000:].max() < 6.0


def test_a_start_at_rest_takes_no_longer_than_before():
    chunk, truth = moved(10.0, still_s=10.0)
    result = online(chunk)
    assert not (result.flags[:, 100:] & CONVERGING).any()
    assert degrees(result, truth)[:, 5:].max() < 4.0
