"""Slow gaits: behind a walking frame, with a foot that is dragged forward for long; and what is a halt all the same."""

import numpy as np
import pytest
from two_feet import SIDES, analysed, even_walk

from estimators.gait._rests import pauses
from tests.said import codes

FRAIL = {"push_rad": 0.35, "land_rad": 0.05, "lift_m": 0.03}


@pytest.mark.parametrize(("stride_s", "swing_s"), [(2.0, 0.8), (3.0, 0.6), (4.0, 1.2), (5.0, 0.75)])
def test_a_slow_walk_is_one_walk_and_all_its_strides_count(stride_s, swing_s):
    walk, test = analysed(even_walk(stride_s=stride_s, swing_s=swing_s, length_m=0.5, **FRAIL))
    for side in SIDES:
        found = walk.summary.feet[side]
        assert found["stride_length"].count == 5
        assert found["stride_length"].value == pytest.approx(0.5, abs=0.02)
        assert found["stride_time"].value == pytest.approx(stride_s, abs=0.05)
    assert walk.summary.bout_count == 1
    assert test.pause_count == 0
    assert codes(walk.summary.reasons) == []


@pytest.mark.parametrize(("swing_s", "length_m"), [(1.5, 0.3), (1.5, 0.5), (2.0, 0.3)])
def test_the_slow_middle_of_a_long_swing_is_no_stance(swing_s, length_m):
    feet = even_walk(stride_s=swing_s / 0.44, swing_s=swing_s, length_m=length_m, **FRAIL)
    walk, test = analysed(feet)
    for side in SIDES:
        lengths = walk.strides[side].length_m
        whole = lengths[1:] if side == "right" else lengths[:-1]
        np.testing.assert_allclose(whole, length_m, atol=0.03)
    assert abs(test.distance_m - 6.5 * length_m) < max(2.0 * test.distance_sigma_m, 0.02)


@pytest.mark.parametrize(
    ("stood_s", "halts"),
    [
        ([0.7, 0.7, 2.4, 0.7, 0.7], [2]),
        ([2.4, 2.3, 2.5, 2.4, 2.6, 2.4], []),
        ([2.4, 2.3, 5.5, 2.4, 2.6, 2.4], [2]),
        ([4.2, 4.4, 4.3, 4.1], []),
        ([0.7, 4.0, 0.7, 4.0, 0.7, 4.0, 0.7], [1, 3, 5]),
        ([10.0], [0]),
        ([10.0, 12.0], [0, 1]),
    ],
)
def test_a_halt_is_longer_than_the_stances_around_it(stood_s, halts):
    assert np.flatnonzero(pauses(np.array(stood_s))).tolist() == halts
