"""Strides and walks that cannot be: two strides taken for one, feet that part in height, metres nobody steps."""

from dataclasses import replace

import numpy as np
import pytest
from foot_walk import foot_walk

from estimators.gait import find_strides, smooth, steady, summarise
from estimators.gait._stride_flags import StrideFlag, long_strides


@pytest.fixture(scope="module")
def trajectory():
    return smooth(foot_walk(strides=9, noise=1.0).signals)


def test_two_strides_taken_for_one_do_not_count(trajectory):
    # Blind to the stance in the middle of the walk.
    hidden = (trajectory.time_s > 5.0) & (trajectory.time_s < 5.6)
    seen = replace(trajectory.stance, is_stance=trajectory.stance.is_stance & ~hidden)
    strides = find_strides(replace(trajectory, stance=seen), "left")
    whole = find_strides(trajectory, "left")
    assert strides.count == whole.count - 1
    (merged,) = np.flatnonzero(strides.length_m > 2.0)
    assert strides.flags[merged] & StrideFlag.LONG
    np.testing.assert_allclose(strides.length_m[steady(strides)], 1.2, atol=0.02)
    assert any("two strides taken for one" in reason for reason in summarise({"left": strides}).reasons)
    assert not whole.flags.any()


def test_long_is_against_the_strides_around_and_needs_two_of_them():
    duration = np.array([np.nan, 1.0, 1.1, 2.0, 1.0, 1.5, np.nan])
    assert np.flatnonzero(long_strides(duration, np.ones(7, dtype=bool))).tolist() == [3]
    assert not long_strides(duration[2:4], np.ones(2, dtype=bool)).any()


def test_feet_of_one_person_end_at_one_height(trajectory):
    feet = {side: find_strides(trajectory, side) for side in ("left", "right")}
    assert summarise(feet).reasons == ()
    holds = feet["right"].footholds
    drift = np.linspace(0.0, 1.0, len(holds.start_s))[:, None] * [0.0, 0.0, 0.5]
    feet["right"] = replace(feet["right"], footholds=replace(holds, position_m=holds.position_m + drift))
    (said,) = summarise(feet).reasons
    assert "one person cannot" in said


def test_strides_that_nobody_makes_are_doubted(trajectory):
    strides = find_strides(trajectory, "left")
    long = summarise({"left": replace(strides, length_m=3.0 * strides.length_m)})
    assert any("longer than anybody's" in reason and "sampling rate" in reason for reason in long.reasons)
    fast = summarise({"left": replace(strides, duration_s=strides.duration_s / 5.0)})
    assert any("faster than anybody walks" in reason for reason in fast.reasons)
