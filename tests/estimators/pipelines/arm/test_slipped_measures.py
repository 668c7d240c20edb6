"""What is measured after a sensor turned in its strap is right or left out, and a sound recording loses nothing."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from estimators.comparison import build_template, compare, find_repetitions, trajectory
from estimators.pipelines import Slip, concatenate, run, with_slips
from estimators.pipelines.arm.slips.flagged import FLAG
from estimators.simulation.faults import drop_samples
from tests.estimators.pipelines.arm.test_slips import ACROSS, AHEAD, LONG, POSE_S, resting_s, session, turned

MAIN = "humerus_forearm_right_zxy_flexion"
SIDE, REACH_M = "right", 0.55
SLIPPED_IN = 3


@cache
def made():
    return session(repetitions=6)


@cache
def sound():
    return trajectory(run(made().recording, made().setup, POSE_S)[0])


@cache
def repetitions():
    return tuple(find_repetitions(sound(), SIDE, made().truth.repetitions_s[0, 0] - 1.5))


@cache
def template():
    return build_template(sound(), list(repetitions()), SIDE, REACH_M, MAIN)


def measures(moved):
    found = compare(moved, template(), SIDE, REACH_M, repetitions=list(repetitions()))
    return [{one.name: one for one in repetition.measures} for repetition in found.repetitions]


def moved_by(recording):
    return trajectory(run(recording, made().setup, POSE_S)[0])


def without_compass(recording):
    return replace(
        recording,
        sensors={name: replace(one, magnetometer_t=None) for name, one in recording.sensors.items()},
    )


@pytest.mark.parametrize("has_compass", [True, False])
@pytest.mark.parametrize("placement", ["upper_arm_right", "forearm_right"])
def test_a_gap_is_no_slip_and_leaves_out_nothing(placement, has_compass):
    """A filter that starts anew beside a sensor without a heading raises the flags that a turned sensor raises."""
    recording = made().recording if has_compass else without_compass(made().recording)
    start_s = made().truth.repetitions_s[SLIPPED_IN, 0] + 1.0
    times = recording.sensors[placement].time_s
    gap = drop_samples(recording, placement, (times >= start_s) & (times < start_s + 0.3))
    frames, _ = run(gap, made().setup, POSE_S)
    walked = (frames.time_s > start_s) & (frames.time_s < start_s + 3.0)
    angle = frames.layout.angles.index(MAIN)
    assert (frames.angle_flags[walked, angle] & FLAG == FLAG).any(), "the flags arise together"
    assert frames.slipped is None
    seen = trajectory(frames)
    np.testing.assert_array_equal(seen.measured, np.where(seen.valid, seen.values, np.nan))
    for given, found in zip(measures(moved_by(recording)), measures(seen), strict=True):
        assert list(found) == list(given)
        assert all(np.isfinite(one.value) for name, one in found.items() if np.isfinite(given[name].value))


@pytest.mark.parametrize(
    ("placement", "axis"),
    [("upper_arm_right", ACROSS), ("forearm_right", ACROSS), ("forearm_right", LONG), ("sternum", AHEAD)],
)
@pytest.mark.parametrize("share", [0.2, 0.6])
def test_what_is_measured_of_the_repetition_of_a_slip_and_later_is_true(placement, axis, share):
    """The upper arm's sensor turned across told a peak speed of 0.98 m/s where 0.49 was true, known to 0.01."""
    start_s, end_s = made().truth.repetitions_s[SLIPPED_IN]
    moved = moved_by(turned(made(), placement, start_s + share * (end_s - start_s), 0.3, axis, 30.0))
    truth = measures(sound())
    for number, found in enumerate(measures(moved)):
        wrong = [
            (number, name, one.value, truth[number][name].value)
            for name, one in found.items()
            if np.isfinite(one.value)
            and abs(one.value - truth[number][name].value)
            > max(3.0 * one.uncertainty, 0.05 * abs(truth[number][name].value), 0.02)
        ]
        assert not wrong
        is_before = number < SLIPPED_IN
        assert ("peak_speed" in found) == (is_before or axis == LONG)
        assert ("hand_path_ratio" in found) == (is_before or axis == LONG or placement == "sternum")


def test_a_sensor_twisted_about_the_limb_leaves_the_hand_where_it_is():
    moved = moved_by(turned(made(), "upper_arm_right", resting_s(made()), 0.3, LONG, 30.0))
    assert moved.unseated is not None
    last, truth = measures(moved)[-1], measures(sound())[-1]
    assert not np.isfinite(last["range:thorax_humerus_right_yxy_axial_rotation"].value)
    for name in ("peak_speed", "mean_speed", "hand_path_ratio", "spectral_arc_length"):
        assert last[name].value == pytest.approx(truth[name].value, rel=0.02), name


def test_two_turns_of_one_sensor_the_same_way_add_up():
    frames, setup = run(made().recording, made().setup, POSE_S)
    one, two = (
        Slip("upper_arm_right", time_s, (0.0, np.radians(20.0), 0.0), 0.02) for time_s in (20.0, 30.0)
    )
    column = frames.layout.angles.index("thorax_humerus_right_yxy_elevation")
    after = slice(frames.tick_count - 200, None)

    def sigma_deg(*slips):
        return np.degrees(with_slips(frames, setup, slips).angle_sigma_rad[after, column]).mean()

    assert sigma_deg(one, two) == pytest.approx(2.0 * sigma_deg(two), rel=0.1)
    back = replace(two, turn_rad=(0.0, -np.radians(20.0), 0.0))
    assert sigma_deg(one, back) < 6.0


def test_pieces_before_and_after_a_slip_are_one():
    frames, setup = run(made().recording, made().setup, POSE_S)
    slip = Slip("forearm_right", 20.0, (0.0, 0.0, 0.5), 0.02)
    whole = with_slips(frames, setup, [slip])
    parts = [
        with_slips(frames.ticks(first, first + 700), setup, [slip])
        for first in range(0, frames.tick_count, 700)
    ]
    assert parts[0].slipped is None
    for joined in (concatenate(parts), type(frames).join(parts)):
        np.testing.assert_array_equal(joined.slipped, whole.slipped)
