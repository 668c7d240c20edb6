"""Spectral arc length against its closed form, and counts of known pushes."""

import numpy as np
import pytest

from estimators.comparison._smoothness import (
    movement_units,
    noise_level,
    spectral_arc_length,
    spectral_arc_length_uncertainty,
)


def bell(time_s, duration_s):
    share = np.clip(time_s / duration_s, 0, 1)
    return 30 * share**2 * (1 - share) ** 2 / duration_s


def closed_form():
    """Arc length of the spectrum of 30 u^2 (1 - u)^2 up to where it last exceeds 5 percent.

    The transform about the middle is 30 times the integral of (1/4 - x^2)^2 cos(w x) over [-1/2, 1/2],
    by parts 120 ((12 - w^2) sin(w/2) - 6 w cos(w/2)) / w^5; its limit at zero is 1.
    """
    w = np.linspace(0.0, 80.0, 800_001)
    magnitude = np.ones_like(w)
    far = w > 0.1
    x = w[far]
    magnitude[far] = np.abs(120 * ((12 - x**2) * np.sin(x / 2) - 6 * x * np.cos(x / 2)) / x**5)
    magnitude[~far] = 1 - w[~far] ** 2 / 56  # the bell's variance is 1/28
    band = slice(0, np.flatnonzero(magnitude >= 0.05)[-1] + 1)
    return -np.hypot(np.diff(w[band]) / w[band][-1], np.diff(magnitude[band])).sum()


def test_minimum_jerk_has_its_closed_form_value():
    expected = closed_form()
    assert expected == pytest.approx(-1.41, abs=0.01)
    for duration_s in (0.6, 1.0, 2.5):
        time_s = np.arange(0, duration_s + 0.005, 0.01)
        found = spectral_arc_length(bell(time_s, duration_s), 100.0)
        # The transform is sampled 16 to 32 times finer than the signal is long: at 0.6 s it has 35
        # points up to the cut-off, which shortens the curved line by half a percent.
        assert found == pytest.approx(expected, abs=1e-2), duration_s


def test_size_does_not_matter_and_more_pushes_are_less_smooth():
    time_s = np.arange(0, 4, 0.01)
    one = bell(time_s, 4.0)
    assert spectral_arc_length(7.0 * one, 100.0) == pytest.approx(spectral_arc_length(one, 100.0), rel=1e-12)
    two = bell(time_s, 2.0) + bell(time_s - 2.0, 2.0)
    four = sum(bell(time_s - k, 1.0) for k in range(4))
    values = [spectral_arc_length(x, 100.0) for x in (one, two, four)]
    assert values[0] > values[1] > values[2]
    tremor = one + 0.1 * one.max() * np.sin(2 * np.pi * 5 * time_s)
    assert spectral_arc_length(tremor, 100.0) < values[0] - 0.2


def test_nothing_to_measure_is_nan():
    assert np.isnan(spectral_arc_length(np.zeros(100), 100.0))
    assert np.isnan(spectral_arc_length(np.ones(4), 100.0))
    assert np.isnan(spectral_arc_length(np.full(100, np.nan), 100.0))


def test_uncertainty_is_that_of_the_noise():
    time_s = np.arange(0, 2, 0.01)
    generator = np.random.default_rng(3)
    level = 0.02
    values, told = [], []
    for _ in range(200):
        noisy = bell(time_s, 2.0) + generator.normal(0, level, len(time_s))
        values.append(spectral_arc_length(noisy, 100.0))
        told.append(spectral_arc_length_uncertainty(noisy, 100.0))
        assert noise_level(noisy, 100.0) == pytest.approx(level, rel=0.4)
    # Eight draws know a spread to about 27 percent; their median over 200 does better.
    assert np.median(told) == pytest.approx(np.std(values), rel=0.5)
    assert np.isnan(spectral_arc_length_uncertainty(bell(time_s, 2.0), 17.0))


@pytest.mark.parametrize("count", [1, 2, 5])
def test_pushes_are_counted(count):
    time_s = np.arange(0, count * 0.8, 0.01)
    speed = sum(0.4 * bell(time_s - 0.8 * k, 0.8) for k in range(count))
    assert movement_units(speed, 100.0) == count
    assert movement_units(0.01 * speed, 100.0) == 0
