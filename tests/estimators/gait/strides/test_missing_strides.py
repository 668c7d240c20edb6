"""Strides in which samples were lost, of a walk whose every stride is 1.2 m in 1.1 s."""

import numpy as np
import pytest
from foot_walk import foot_walk

from estimators.gait import find_strides, guided_test, smooth, steady, summarise, turns
from estimators.gait._stride_flags import StrideFlag
from estimators.recording import SensorSignals
from tests.said import codes, sentence

LENGTH_M, PERIOD_S, COUNT = 1.2, 1.1, 12


def walked(side, *gaps_s, seed=0):
    s = foot_walk(strides=COUNT, length_m=LENGTH_M, period_s=PERIOD_S, noise=1.0, seed=seed).signals
    lost = np.any([(s.time_s > a) & (s.time_s < b) for a, b in gaps_s], axis=0) if gaps_s else s.time_s < -1.0
    kept = SensorSignals(s.time_s[~lost], s.gyroscope_radps[~lost], s.accelerometer_mps2[~lost])
    return find_strides(smooth(kept), side)


@pytest.mark.parametrize("gap", [(5.0, 6.0), (5.6, 6.2), (5.3, 7.4), (4.9, 9.9)])
def test_a_gap_becomes_no_stride_that_counts(gap):
    strides = walked("left", gap)
    lost = (strides.flags & StrideFlag.MISSING) != 0
    assert 1 <= lost.sum() <= 3
    counted = steady(strides)
    assert counted.sum() >= 3
    assert not (counted & lost).any()
    np.testing.assert_allclose(strides.length_m[counted], LENGTH_M, atol=0.03)
    assert np.isnan(strides.duration_s[lost]).all()
    np.testing.assert_allclose(
        strides.duration_s[counted & np.isfinite(strides.duration_s)], PERIOD_S, atol=0.03
    )
    assert strides.missing_s.sum() == pytest.approx(gap[1] - gap[0], abs=0.03)
    # Nobody halted or turned.
    assert strides.bout.max() == 0
    assert turns(strides) == []
    (said, _) = summarise({"left": strides}).reasons
    assert (said.code, said.parameters["side"]) == ("walk.missing", "left")
    assert said.parameters["missing_s"] == strides.missing_s.sum()


def test_short_holes_are_bridged_and_nothing_is_left_out():
    strides = walked("left", (5.0, 5.1), (7.33, 7.4))
    assert not strides.flags.any()
    assert not strides.missing_s.any()


def test_the_other_foot_tells_the_way_of_one_whose_samples_are_lost():
    feet = {"left": walked("left", (5.0, 9.0)), "right": walked("right", seed=1)}
    found = guided_test(feet)
    assert found.distance_m == pytest.approx(COUNT * LENGTH_M, abs=0.1)
    assert (found.step_count, found.pause_count, found.turn_count) == (2 * COUNT, 0, 0)
    assert found.minutes_m.sum() == pytest.approx(found.distance_m)
    assert sentence(found.reasons, "walk.other_foot").parameters["side"] == "left"
    feet["right"] = walked("right", (5.0, 9.0), seed=1)
    short = guided_test(feet)
    assert short.distance_m < COUNT * LENGTH_M
    assert "walk.count_short" in codes(short.reasons)


def test_where_feet_stand_to_each_other_is_known_up_to_the_gap():
    strides = walked("left", (5.0, 6.0))
    known = strides.footholds.before(strides.whole_until_s)
    assert 3 <= len(known.start_s) <= 6
    assert known.stop_s.max() < 5.0
    assert walked("left").whole_until_s == np.inf
