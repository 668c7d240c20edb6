"""Filters over sensors side by side: a lane is one sensor alone, whatever lies beside it."""

import math

import numpy as np
import pytest
from numba import types

from estimators import orientation
from estimators._kernels import kernel
from estimators._lanes import (
    LANES,
    anywhere,
    at_least,
    at_most,
    chosen,
    column,
    of_one,
    put_column,
    spread,
)
from estimators.orientation._lane_steps import arcsine, direction_lanes, turn_lanes
from estimators.recording import ImuChunk
from tests.estimators.orientation.orientation_contract import (
    STEP_S,
    assert_same_bits,
    joined,
    moving_network,
    with_trouble,
)

RESULTS = 8


@kernel(types.void(types.float64[:, :, ::1], types.float64[:, ::1], types.int64, types.int64))
def every_operation(given, found, row, last):
    a, b = column(given, (row, last, 1, 0)), column(given, (row, last, 1, 1))
    total = spread(0.5)
    total += 2.0 * a - b / 3.0
    total -= a * (1.0 - b)
    total *= -a
    w, x, y, z = turn_lanes(a, b, total)
    inside = ((a < b) | (a >= 0.3)) & ~((b <= 0.1) | (b > 0.8))
    put_column(found, (row, last, 0), total)
    put_column(found, (row, last, 1), math.sqrt(abs(total)) + math.sin(a) * math.cos(b))
    put_column(found, (row, last, 2), chosen(inside, a, -1.0))
    put_column(found, (row, last, 3), at_least(at_most(total, 0.4), -0.4))
    put_column(found, (row, last, 4), w)
    put_column(found, (row, last, 5), x + y * z)
    put_column(found, (row, last, 6), direction_lanes(a - 0.5, b - 0.5))
    put_column(found, (row, last, 7), spread(1.0 if anywhere(a > 0.9) else 0.0))


def test_every_operation_is_that_of_numbers():
    given = np.random.default_rng(2).uniform(0.0, 1.0, (4 * LANES + 1, 2, 2))
    given[:LANES] *= 0.85
    given[LANES, 1, 0] = 0.95
    found = np.full((len(given) + LANES, RESULTS), np.nan)
    for row in range(0, len(given), LANES):
        every_operation(given, found, row, min(row + LANES, len(given)) - 1)
    assert np.isnan(found[len(given) :]).all()  # nothing beyond the last row
    (a, b), found = given[:, 1].T, found[: len(given)]
    total = (0.5 + (2.0 * a - b / 3.0) - a * (1.0 - b)) * -a
    inside = ((a < b) | (a >= 0.3)) & ~((b <= 0.1) | (b > 0.8))
    np.testing.assert_array_equal(found[:, 0], total)
    np.testing.assert_allclose(found[:, 1], np.sqrt(np.abs(total)) + np.sin(a) * np.cos(b), rtol=1e-15)
    np.testing.assert_array_equal(found[:, 2], np.where(inside, a, -1.0))
    np.testing.assert_array_equal(found[:, 3], np.clip(total, -0.4, 0.4))
    half = 0.5 * np.sqrt(a * a + b * b + total * total)
    np.testing.assert_allclose(found[:, 4], np.cos(half), rtol=1e-15)
    share = np.sin(half) / (2.0 * half)
    np.testing.assert_allclose(found[:, 5], share * (a + b * share * total), rtol=1e-14)
    np.testing.assert_allclose(found[:, 6], np.arctan2(a - 0.5, b - 0.5), rtol=1e-15)
    groups = np.add.reduceat(a > 0.9, np.arange(0, len(given), LANES)) > 0
    np.testing.assert_array_equal(found[:, 7], np.repeat(groups, LANES)[: len(given)])
    assert groups.any()
    assert not groups.all()


def test_arcsine_is_that_of_the_library():
    sines = np.concatenate((np.linspace(-1.0, 1.0, 2001), [0.5, np.nextafter(0.5, 1.0), 1e-9, -1e-300, 0.0]))
    found = [of_one(arcsine)(float(sine)) for sine in sines]
    np.testing.assert_allclose(found, np.arcsin(sines), rtol=4e-16, atol=4e-16)


@pytest.mark.parametrize("name", ["marzouk_quaternion_ekf", "roetenberg_disturbance"])
def test_sensor_beside_others_is_the_sensor_alone(name):
    """Gaps, starts and clipping of the first three, a group that is not full, and its last sensor without a field."""
    chunk = with_trouble(moving_network(LANES + 3)[0])
    chunk.magnetometer_t[-1, 450:] = np.nan
    columns = chunk.gyroscope_radps, chunk.accelerometer_mps2, chunk.magnetometer_t, chunk.quality
    whole = joined([orientation.create(name, LANES + 3, STEP_S).update(chunk)])
    for s in range(LANES + 3):
        alone = ImuChunk(0, STEP_S, *(values[s : s + 1] for values in columns))
        found = joined([orientation.create(name, 1, STEP_S).update(alone)])
        assert_same_bits(found, [values[s : s + 1] for values in whole])
