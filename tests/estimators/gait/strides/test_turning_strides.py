"""Curved walks: temporal figures of turning strides, and feet that point along the curve."""

from dataclasses import replace

import numpy as np
import pytest
from foot_walk import foot_walk

from estimators.gait import find_strides, smooth, steady, summarise
from estimators.gait._stride_flags import StrideFlag
from estimators.gait._summary import turning


@pytest.fixture(scope="module")
def circle():
    return find_strides(smooth(foot_walk(strides=9, turn_rad=0.1, noise=1.0).signals), "left")


def test_a_circle_is_one_turn_of_which_no_stride_is_straight(circle):
    assert not steady(circle).any()
    assert np.flatnonzero(turning(circle)).tolist() == list(range(1, 8))
    found = summarise({"left": circle})
    assert found.turn_count == 1
    assert found.feet["left"]["stride_length"].count == 0
    assert found.turning["left"]["stride_length"].value == pytest.approx(1.2, abs=0.01)
    assert found.turning["left"]["stride_time"].value == pytest.approx(1.1, abs=0.02)
    assert found.turning["left"]["clearance"].count == 7
    said = found.reasons[0]
    assert "every stride turns" in said
    assert "7 strides" in said


def test_half_of_a_turn_is_no_foot_angle(circle):
    # This foot walks straight on and points ever further left: halfway between its stances.
    middle = 0.1 * (np.arange(9) + 0.5)
    np.testing.assert_allclose(circle.toe_out_rad, middle, atol=0.03)


def test_steps_aside_do_not_count():
    walk = find_strides(smooth(foot_walk(strides=6, noise=1.0).signals), "left")
    assert steady(walk).sum() == 4
    # Away from where the foot points by 1.3 rad.
    aside = find_strides(smooth(foot_walk(strides=6, turn_rad=0.5, noise=1.0).signals), "left")
    assert (aside.flags[3:] & StrideFlag.SIDEWAYS).all()
    straight = replace(aside, turn_rad=np.zeros(6))
    assert not steady(straight)[3:].any()
    assert any("sideways" in reason for reason in summarise({"left": straight}).reasons)
