"""Dynamic time warping against its definition, its twin, and known warps."""

import itertools

import numpy as np
import pytest

from estimators.comparison._alignment import (
    STRAY_PENALTY,
    accumulate,
    accumulate_numpy,
    align,
    apply,
    local_cost,
    local_cost_numpy,
    resample,
)
from estimators.errors import ShapeError

ONE = np.ones(1)


def bell(phase):
    return np.sin(np.pi * phase) ** 2


def test_kernels_equal_their_twins():
    generator = np.random.default_rng(5)
    for rows, columns, channels in ((7, 7, 1), (23, 31, 4), (101, 101, 9)):
        first, second = generator.normal(size=(rows, channels)), generator.normal(size=(columns, channels))
        first[generator.random(first.shape) < 0.1] = np.nan
        cost = local_cost(first, second)
        assert np.allclose(cost, local_cost_numpy(first, second), rtol=1e-13, atol=0)
        band = max(2, columns // 4)
        assert np.allclose(
            accumulate(cost, band, STRAY_PENALTY), accumulate_numpy(cost, band, STRAY_PENALTY), rtol=1e-13
        )


def test_accumulated_cost_is_the_cheapest_of_all_paths():
    """Against brute force over every monotone path of a small table."""
    cost = np.random.default_rng(2).random((5, 5))

    def cheapest(i, j):
        if (i, j) == (0, 0):
            return 2 * cost[0, 0]
        options = []
        for di, dj in itertools.product((0, 1), (0, 1)):
            if (di or dj) and i >= di and j >= dj:
                options.append(cheapest(i - di, j - dj) + (di + dj) * cost[i, j])
        return min(options)

    assert accumulate(cost, 5, 0.0)[-1, -1] == pytest.approx(cheapest(4, 4), rel=1e-14)


def test_identity_is_zero_and_straight():
    series = np.random.default_rng(0).normal(size=(101, 3))
    found = align(series, series, np.ones(3))
    assert found.rms == 0.0
    assert np.array_equal(found.warp, np.arange(101.0))
    assert found.timing_deviation == 0.0


def test_symmetric_in_its_arguments():
    generator = np.random.default_rng(1)
    first, second = (
        generator.normal(size=(101, 2)).cumsum(axis=0),
        generator.normal(size=(101, 2)).cumsum(axis=0),
    )
    assert align(first, second, np.ones(2)).rms == pytest.approx(
        align(second, first, np.ones(2)).rms, rel=1e-9
    )


def test_known_warp_is_recovered_and_removed():
    phase = np.linspace(0, 1, 101)
    pace = phase + 0.10 * np.sin(np.pi * phase) * np.sin(2 * np.pi * phase)
    first = np.stack([bell(pace), np.cos(3 * pace)], axis=1)
    second = np.stack([bell(phase), np.cos(3 * phase)], axis=1)
    found = align(first, second, np.ones(2) * 0.1)
    assert (np.diff(found.warp) >= 0).all()
    # One phase is the grid; the flat tops of the bell cannot say more.
    assert np.abs(found.warp - 100 * pace).max() < 3.0
    assert found.rms < 0.1
    assert np.abs(apply(found, first, 101) - second).max() < 0.05
    assert found.timing_deviation == pytest.approx(np.abs(pace - phase).mean(), abs=0.01)


def test_band_limits_the_warp():
    phase = np.linspace(0, 1, 101)
    early, late = bell(np.clip(phase * 2, 0, 1))[:, None], bell(np.clip(phase * 2 - 1, 0, 1))[:, None]
    narrow = align(early, late, ONE, band=0.1)
    wide = align(early, late, ONE, band=0.6)
    assert np.abs(narrow.warp - np.arange(101)).max() <= 11
    assert wide.rms < 0.05 < narrow.rms


def test_unknown_channels_do_not_count():
    series = np.random.default_rng(0).normal(size=(50, 2))
    other = series.copy()
    other[:, 1] = np.nan
    assert align(series, other, np.ones(2)).rms == 0.0
    other[:, 1] = 99.0
    assert align(series, other, np.array([1.0, np.nan])).rms == 0.0


def test_resample_keeps_gaps_and_ends():
    time_s = np.arange(5.0)
    values = np.array([[0.0], [1.0], [np.nan], [3.0], [4.0]])
    found = resample(time_s, values, 9)[:, 0]
    assert found[0] == 0.0
    assert found[-1] == 4.0
    assert np.isnan(found[3:6]).all()
    assert np.isfinite(found[[0, 1, 2, 6, 7, 8]]).all()


def test_bad_shapes_are_refused():
    with pytest.raises(ShapeError, match="channels differ"):
        align(np.zeros((5, 2)), np.zeros((5, 3)), np.ones(2))
    with pytest.raises(ShapeError, match="two samples"):
        align(np.zeros((1, 2)), np.zeros((5, 2)), np.ones(2))
