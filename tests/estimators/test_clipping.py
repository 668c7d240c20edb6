"""Levels at which devices cut off are found by how values pile up; rests, repeated rows and soft peaks are none."""

import numpy as np
import pytest

from estimators._clipping import ClipWatch, at_levels

STEP_S = 0.01
LEAST = np.radians(30.0)


def swinging(seconds: float = 60.0) -> np.ndarray:
    time_s = STEP_S * np.arange(round(seconds / STEP_S))
    swell = 1.0 + 0.3 * np.sin(0.37 * time_s)
    turning = [6.0 * np.sin(7.9 * time_s), 4.0 * np.cos(5.3 * time_s), np.sin(time_s)]
    return np.stack(turning, axis=-1) * swell[:, None]


def watched(values: np.ndarray, *, is_rate: bool = True, step_s: float = STEP_S) -> ClipWatch:
    watch = ClipWatch(LEAST, is_rate=is_rate)
    for stretch in np.array_split(values, 5):
        watch.add(stretch, step_s)
    return watch


def test_a_cut_off_axis_is_found_however_calibration_turned_and_scaled_it():
    values = swinging()
    assert watched(values).level is None
    skew = np.eye(3) + 0.003 * np.random.default_rng(1).normal(size=(3, 3))
    cut = np.clip(values, -5.0, 5.0) @ skew.T
    level = watched(cut).level
    assert level == pytest.approx(5.0, rel=0.03)
    hit, true = at_levels(cut, watched(cut).levels), (np.abs(values) > 5.0).any(axis=1)
    assert hit[true].mean() > 0.9
    assert not hit[(np.abs(cut) < 4.7).all(axis=1)].any()


def test_short_peaks_are_known_by_how_often_they_reach_the_same_level():
    """At 50 Hz a swing cut off at 400 degrees/s: a sample or two at every turn."""
    time_s = np.arange(500) / 50.0
    soft = np.stack([np.sin(7.9 * time_s), np.cos(5.3 * time_s), 0.2 * np.sin(time_s)], axis=-1)
    level = np.radians(400.0)
    spiky = 1.03 * level * np.sign(soft) * np.abs(soft) ** 8
    assert watched(spiky, step_s=0.02).level is None
    assert watched(np.clip(spiky, -level, level), step_s=0.02).level == pytest.approx(level, rel=0.01)


def test_rows_that_repeat_and_equal_swings_are_no_levels():
    assert watched(np.repeat(swinging()[::5], 5, axis=0)).level is None
    time_s = STEP_S * np.arange(6000)
    pendulum = np.stack([5.0 * np.sin(3.0 * time_s), 0.1 * np.cos(3.0 * time_s), 0.0 * time_s], axis=-1)
    assert watched(pendulum).level is None


def test_a_steady_turn_and_a_sensor_at_rest_are_no_levels():
    noise = 1e-3 * np.random.default_rng(2).normal(size=(6000, 3))
    assert watched(np.array([0.0, 0.0, 3.5]) + noise).level is None
    assert watched(np.array([0.0, 0.0, 9.81]) + noise, is_rate=False).level is None
    assert watched(np.full((6000, 3), 5.0)).level is None


def test_a_level_known_from_before_holds_until_a_larger_value_shows_that_it_was_none():
    cut = np.clip(swinging(), -5.0, 5.0)
    known = watched(cut).levels
    assert np.isfinite(known[:, 0]).all()
    later = ClipWatch(LEAST, is_rate=True, known=known)
    np.testing.assert_array_equal(later.levels, known)
    later.add(0.3 * cut[:500], STEP_S)
    np.testing.assert_array_equal(later.levels, known)
    later.add(0.999 * cut, STEP_S)
    np.testing.assert_array_equal(later.levels, known)
    later.add(swinging(), STEP_S)
    assert np.isinf(later.levels).all()


def machine(samples: int, sharp: float, *, cycles: int = 120) -> np.ndarray:
    """A machine that swings to and fro about one axis, each time in the same number of samples."""
    angle = 2.0 * np.pi * np.arange(samples * cycles) / samples
    turning = 5.0 * np.sign(np.cos(angle)) * np.abs(np.cos(angle)) ** sharp
    return np.stack([turning, 0.1 * np.sin(angle), 0.0 * angle], axis=-1)


@pytest.mark.parametrize(("samples", "sharp"), [(40, 8), (50, 10), (42, 6), (100, 30), (64, 3)])
@pytest.mark.parametrize("noise", [0.0, 0.004])
def test_the_peaks_of_a_machine_that_repeats_exactly_are_no_level(samples, sharp, noise):
    turning = machine(samples, sharp)
    turning += noise * np.random.default_rng(3).normal(size=turning.shape)
    assert watched(turning).level is None


@pytest.mark.parametrize("share", [0.6, 0.8])
def test_a_machine_whose_peaks_are_cut_off_has_a_level(share):
    cut = np.clip(machine(40, 3), -5.0 * share, 5.0 * share)
    assert watched(cut).level == pytest.approx(5.0 * share, rel=0.01)


@pytest.mark.parametrize("number", [0.02, 0.1, 0.3])
def test_a_device_with_few_numbers_is_cut_off_only_where_it_stands_at_the_last_of_them(number):
    """Eight bits, or a table in whole units: each number is a pile of its own."""
    time_s = STEP_S * np.arange(12_000)
    swell = 1.0 + 0.25 * np.sin(0.61 * time_s)
    swings = np.stack([5.0 * np.sin(7.9 * time_s), 4.0 * np.cos(5.3 * time_s), np.sin(time_s)], axis=-1)
    for values in (swings, swings * swell[:, None]):
        assert watched(number * np.rint(values / number)).level is None
    if number > 0.2:
        # With fifteen numbers a swing stands long at each.
        return
    last = number * np.floor(4.6 / number)
    cut = np.clip(number * np.rint(swings * swell[:, None] / number), -last, last)
    assert watched(cut).level == pytest.approx(last, rel=0.01)
