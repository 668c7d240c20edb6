"""A sensor that repeats itself where it should move gives nothing; one that only holds its samples does."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from estimators import orientation, rotation
from estimators.orientation import OrientationFlag
from estimators.orientation._screen import SampleScreen
from tests.estimators.orientation.orientation_contract import STEP_S, assert_same_bits, joined, moving_network

LOST = int(OrientationFlag.BRIDGED | OrientationFlag.INVALID)
FREEZE = slice(600, 800)
TRIADS = ("gyroscope_radps", "accelerometer_mps2", "magnetometer_t")


def frozen_network(names=TRIADS, length=1, ticks=1100):
    chunk, _ = moving_network(sensors=2, ticks=ticks)
    changed = {}
    for name in names:
        values = getattr(chunk, name).copy()
        count = FREEZE.stop - FREEZE.start
        values[0, FREEZE] = values[0, FREEZE.start - length + np.arange(count) % length]
        changed[name] = values
    return replace(chunk, **changed)


def lost(chunk, *, is_whole):
    screened = SampleScreen(2, STEP_S, is_whole=is_whole).screened(chunk)
    return np.isnan(screened.gyroscope_radps).any(-1), np.isnan(screened.magnetometer_t).any(-1)


@pytest.mark.parametrize(
    ("names", "length"),
    [(TRIADS[:1], 1), (TRIADS[1:2], 1), (TRIADS, 1), (TRIADS, 10), (TRIADS[:2], 10)],
)
def test_a_freeze_is_no_sample(names, length):
    chunk = frozen_network(names, length)
    live, _ = lost(chunk, is_whole=False)
    assert live[0, FREEZE.start + 60 : FREEZE.stop].all()
    whole, _ = lost(chunk, is_whole=True)
    assert whole[0, FREEZE.start : FREEZE.stop].all()
    for marked in (live, whole):
        assert not marked[1].any()
        assert not marked[0, : FREEZE.start].any()
        assert not marked[0, FREEZE.stop :].any()


def test_a_frozen_magnetometer_leaves_the_rest_of_the_sensor_alone():
    chunk = frozen_network(TRIADS[2:])
    sensor, field = lost(chunk, is_whole=True)
    assert not sensor.any()
    assert np.flatnonzero(field[0]).tolist() == list(range(FREEZE.start, FREEZE.stop))


@pytest.mark.parametrize("is_offline", [False, True])
def test_a_frozen_magnetometer_is_flagged(is_offline):
    chunk, sound = frozen_network(TRIADS[2:]), moving_network(sensors=2, ticks=1100)[0]
    flags, before = (
        orientation.smooth("telemotion_smoother", given).orientation.flags
        if is_offline
        else orientation.create("telemotion", 2, STEP_S).update(given).flags
        for given in (chunk, sound)
    )
    disturbed = (flags & int(OrientationFlag.MAGNETIC_DISTURBANCE)) != 0
    assert disturbed[0, FREEZE.start + (0 if is_offline else 60) : FREEZE.stop].all()
    assert not disturbed[0, : FREEZE.start].any()
    assert not disturbed[1].any()
    assert not (flags[0, FREEZE] & LOST).any()
    assert not (before & int(OrientationFlag.MAGNETIC_DISTURBANCE)).any()


def test_held_and_coarse_samples_are_sound():
    chunk, _ = moving_network(sensors=2, ticks=1100)
    held, coarse = np.arange(1100) // 2 * 2, np.arange(1100) // 6 * 6
    rows_repeat = {name: getattr(chunk, name)[:, held] for name in TRIADS[:2]}
    chunk = replace(chunk, **rows_repeat, magnetometer_t=chunk.magnetometer_t[:, coarse])
    assert SampleScreen(2, STEP_S).screened(chunk) is chunk
    counts = {
        name: np.rint(getattr(chunk, name) / count) * count
        for name, count in zip(TRIADS, (0.05, 0.4, 2e-6), strict=True)
    }
    chunk = replace(chunk, **counts)
    assert SampleScreen(2, STEP_S, is_whole=True).screened(chunk) is chunk


def test_simulated_sensors_without_noise_are_sound():
    chunk, _ = moving_network(sensors=2, ticks=1100, noise=0.0)
    still = {name: getattr(chunk, name).copy() for name in TRIADS}
    for values in still.values():
        values[:, FREEZE] = values[:, FREEZE.start : FREEZE.start + 1]
    still["gyroscope_radps"][:, FREEZE] = 0.0
    chunk = replace(chunk, **still)
    assert SampleScreen(2, STEP_S).screened(chunk) is chunk


@pytest.mark.parametrize("length", [1, 10])
def test_the_cut_of_a_stream_does_not_matter(length):
    chunk = frozen_network(length=length)
    whole = orientation.create("telemotion", 2, STEP_S).update(chunk)
    first, second = (orientation.create("telemotion", 2, STEP_S) for _ in range(2))
    results = [first.update(chunk.ticks(0, 603))]
    second.restore(first.state())
    edges = [603, 604, 605, 611, 640, 799, 800, 1100]
    results += [second.update(chunk.ticks(a, b)) for a, b in itertools.pairwise(edges)]
    assert_same_bits(joined(results), joined([whole]))


@pytest.mark.parametrize("is_offline", [False, True])
def test_sigma_covers_what_a_freeze_hides(is_offline):
    _, truth = moving_network(sensors=2, ticks=1100)
    chunk = frozen_network()
    found = (
        orientation.smooth("telemotion_smoother", chunk).orientation
        if is_offline
        else orientation.create("telemotion", 2, STEP_S).update(chunk)
    )
    assert (found.flags[0, FREEZE.start + 30 : FREEZE.stop] & LOST).all()
    after = slice(FREEZE.stop + 200, None)
    error = rotation.log(rotation.multiply(found.q_earth_sensor, rotation.conjugate(truth)))
    squares = ((error / found.sigma_rad) ** 2).sum(axis=-1)
    assert np.degrees(np.linalg.norm(error[0, after], axis=-1)).max() < 4.0
    assert (squares[0, FREEZE.stop :] < 7.8).mean() > 0.9
