"""Record and Stop: the feet are followed all the way, numbers and tests are of what lies between."""

import numpy as np
import pytest
from two_feet import SIDES, analysed, even_walk

from estimators.gait import StrideFlag, steady
from estimators.recording import SensorSignals
from tests.said import codes


def joined(one, two):
    """Return a walk after another one."""
    return {
        side: SensorSignals(
            np.arange(len(one[side].time_s) + len(two[side].time_s)) / 100.0,
            np.concatenate([one[side].gyroscope_radps, two[side].gyroscope_radps]),
            np.concatenate([one[side].accelerometer_mps2, two[side].accelerometer_mps2]),
        )
        for side in SIDES
    }


@pytest.fixture(scope="module")
def feet():
    """Five strides of 0.9 m a foot to the line, then a test of eight of 1.2 m; 16 s and more."""
    return joined(even_walk(count=5, length_m=0.9), even_walk(count=8, seed=1))


LINE_S = 3.0 + 1.2 * 5.5 + 3.0


@pytest.mark.parametrize("kind", ["walk", "timed_up_and_go", "six_minute_walk"])
def test_a_test_begins_with_record(feet, kind):
    walk, test = analysed(feet, kind=kind, recorded_s=(LINE_S, np.inf))
    # The first foot leaves the ground 3 s after the line, the other lands last: seven strides and a half later.
    assert test.start_s == pytest.approx(LINE_S + 3.0, abs=0.15)
    assert test.time_s == pytest.approx(7.5 * 1.2 + 0.5, abs=0.3)
    assert test.distance_m == pytest.approx(7.5 * 1.2, abs=0.1)
    assert (test.step_count, test.pause_count) == (16, 0)
    assert walk.summary.bout_count == 1
    for side in SIDES:
        strides = walk.strides[side]
        outside = (strides.flags & StrideFlag.OUTSIDE) != 0
        assert outside.tolist() == [True] * 5 + [False] * 8
        assert not steady(strides)[outside].any()
        assert walk.summary.feet[side]["stride_length"].value == pytest.approx(1.2, abs=0.01)


def test_stop_ends_it_and_the_way_stays(feet):
    walk, test = analysed(feet, recorded_s=(0.0, LINE_S))
    assert test.distance_m == pytest.approx(4.5 * 0.9, abs=0.1)
    assert walk.summary.feet["left"]["stride_length"].value == pytest.approx(0.9, abs=0.01)
    assert walk.strides["left"].count == 13


def test_who_never_pressed_record_has_the_whole_walk(feet):
    _, test = analysed(feet)
    assert test.distance_m == pytest.approx(4.5 * 0.9 + 7.5 * 1.2, abs=0.1)
    assert test.pause_count == 1


def test_a_recording_without_a_stride_says_so(feet):
    walk, test = analysed(feet, recorded_s=(0.0, 2.0))
    assert test is None
    assert codes(walk.summary.reasons) == ["walk.no_stride", "walk.no_stride"]
