"""Declination turns toward true north, and a known delay is found between samples."""

import numpy as np
import pytest

from estimators import rotation
from estimators.errors import ShapeError
from estimators.orientation.published import estimate_lag, to_true_north


def test_east_declination_adds_to_the_heading():
    # The sensor's y axis points to magnetic north, ten degrees east of true north.
    q = to_true_north(rotation.identity((3,)), np.radians(10.0))
    north = rotation.rotate(q, np.array([0.0, 1.0, 0.0]))
    np.testing.assert_allclose(np.degrees(np.arctan2(north[:, 0], north[:, 1])), 10.0, atol=1e-9)


@pytest.mark.parametrize("lag_s", [-0.213, -0.01, 0.0, 0.037, 0.3])
def test_a_known_delay_is_found(lag_s):
    time_s = np.arange(0.0, 30.0, 0.02)

    def speed(t):
        return 1.0 + np.sin(2 * np.pi * 0.7 * t) + 0.5 * np.sin(2 * np.pi * 0.31 * t + 1.0)

    noise = 0.02 * np.random.default_rng(1).normal(size=(2, len(time_s)))
    # The parabola through three samples of a cosine of 0.7 Hz is right to a tenth of a sample.
    assert estimate_lag(speed(time_s) + noise[0], speed(time_s - lag_s) + noise[1], 0.02) == pytest.approx(
        lag_s, abs=2e-3
    )


def test_a_lag_needs_movement_and_length():
    with pytest.raises(ShapeError, match="does not move"):
        estimate_lag(np.zeros(500), np.zeros(500), 0.02)
    with pytest.raises(ShapeError, match="at least"):
        estimate_lag(np.arange(20.0), np.arange(20.0), 0.02)
