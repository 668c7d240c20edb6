"""Sensors that turn in their strap are named with the moment, and nobody who only moves is accused of it."""

from dataclasses import replace

import numpy as np
import pytest

from estimators import rotation, signals
from estimators.comparison import build_template, compare, find_repetitions, trajectory
from estimators.pipelines import SlipSearch, in_doubt, run, with_slips
from estimators.pipelines.arm.slips import find_slips
from estimators.pipelines.arm.slips.flagged import FLAG
from estimators.simulation import ArmScenario, MovementStyle, Schedule, simulate_arm
from estimators.simulation._sensors import Mounting
from estimators.simulation.arm.exercises import EXERCISES, Exercise, Stop
from estimators.simulation.faults import kill_sensor, saturate, turn_in_strap
from tests.estimators.snapshots import cases
from tests.said import codes

ONE_ARM = ("sternum", "upper_arm_right", "forearm_right", "hand_right")
NO_HAND = ONE_ARM[:3]
POSE_S = (2.0, 8.0)
LONG, ACROSS, AHEAD = (0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)


def session(exercise="reaching", seed=6, repetitions=6, placements=ONE_ARM, soft_deg=0.0, **scenario):
    return simulate_arm(
        ArmScenario(
            exercise=exercise,
            schedule=Schedule(repetitions=repetitions),
            placements=placements,
            mounting=Mounting(soft_tissue_rad=np.radians(soft_deg)),
            seed=seed,
            **scenario,
        )
    )


def turned(made, placement, at_s, lasts_s, axis, angle_deg):
    """Turn one sensor about an axis of its segment."""
    turn = np.radians(angle_deg) * np.array(axis) / np.linalg.norm(axis)
    turn_rad = rotation.rotate(made.truth.q_sensor_segment[placement], turn)
    return turn_in_strap(made.recording, placement, at_s, tuple(turn_rad), lasts_s)


def resting_s(made, after=2):
    """Return the middle of the rest after a repetition."""
    times = made.truth.repetitions_s
    return 0.5 * (times[after, 1] + times[after + 1, 0])


def slips_of(recording, setup, pose_s=POSE_S):
    frames, used = run(recording, setup, pose_s)
    worn = replace(recording, sensors={name: recording.sensors[name] for name in setup.placements})
    chunk = signals.to_common_ticks(worn, setup.rate_hz)
    return find_slips([frames], [chunk], used, pose_s[1]), frames, chunk, used


@pytest.mark.parametrize("axis", [LONG, ACROSS, AHEAD])
@pytest.mark.parametrize("placement", ONE_ARM)
def test_a_turn_at_rest_is_told_with_sensor_moment_and_angle(placement, axis):
    made = session("reaching", seed=12)
    at_s = resting_s(made)
    (slip,), *_ = slips_of(turned(made, placement, at_s, 0.3, axis, 30.0), made.setup)
    assert slip.placement == placement
    assert slip.time_s == pytest.approx(at_s, abs=0.5)
    assert np.degrees(slip.turn_rad) == pytest.approx(30.0 * np.array(axis), abs=5.0)


@pytest.mark.parametrize(
    ("exercise", "placement", "axis", "angle_deg", "lasts_s"),
    [
        ("drinking", "forearm_right", LONG, -15.0, 0.2),
        ("abduction", "forearm_right", (0.2, 0.1, 1.0), 60.0, 0.6),
        ("flexion", "hand_right", LONG, 45.0, 0.1),
        ("abduction", "sternum", (1.0, 1.0, 0.0), -20.0, 0.3),
        ("drinking", "upper_arm_right", LONG, 20.0, 0.3),
        ("pronation", "upper_arm_right", (0.7, 0.7, 0.3), -45.0, 0.2),
    ],
)
def test_it_is_told_during_movement_too_and_on_soft_skin(exercise, placement, axis, angle_deg, lasts_s):
    made = session(exercise, seed=21, soft_deg=4.0)
    start_s, end_s = made.truth.repetitions_s[3]
    at_s = start_s + 0.3 * (end_s - start_s)
    (slip,), *_ = slips_of(turned(made, placement, at_s, lasts_s, axis, angle_deg), made.setup)
    assert slip.placement == placement
    assert slip.time_s == pytest.approx(at_s, abs=1.0)
    assert np.degrees(slip.angle_rad) == pytest.approx(abs(angle_deg), abs=6.0)


def test_frames_are_honest_from_the_slip_on_and_untouched_before():
    made = session("reaching", seed=6)
    at_s = resting_s(made)
    sound, _ = run(made.recording, made.setup, POSE_S)
    frames, _ = run(turned(made, "forearm_right", at_s, 0.4, LONG, 30.0), made.setup, POSE_S)
    before, after = frames.time_s < at_s - 1.0, frames.time_s > at_s + 0.5
    after &= frames.time_s < made.truth.repetitions_s[-1, 1]
    for name, is_concerned in (
        ("humerus_forearm_right_zxy_pronation", True),
        ("forearm_hand_right_zxy_rotation", True),
        ("humerus_forearm_right_zxy_flexion", False),
        ("thorax_humerus_right_yxy_elevation", False),
    ):
        a = frames.layout.angles.index(name)
        error = frames.angle_rad[:, a] - made.truth.angle_rad(name)
        flagged = frames.angle_flags[:, a] & FLAG == FLAG
        assert flagged[after].all() == is_concerned, name
        if is_concerned:
            assert np.degrees(np.abs(error[after]).mean()) > 20.0, "the slip is there"
        assert (np.abs(error[after]) < 3.0 * frames.angle_sigma_rad[after, a]).mean() > 0.95, name
    s = frames.layout.segments.index("forearm_right")
    assert (frames.segment_flags[after, s] & FLAG == FLAG).all()
    np.testing.assert_array_equal(frames.angle_sigma_rad[before], sound.angle_sigma_rad[before])
    np.testing.assert_array_equal(frames.angle_flags[before], sound.angle_flags[before])


def test_what_is_compared_leaves_out_what_slipped_and_still_has_the_rest():
    made = session("reaching", seed=6)
    at_s = resting_s(made)
    frames, _ = run(turned(made, "sternum", at_s, 0.4, AHEAD, 30.0), made.setup, POSE_S)
    seen = trajectory(frames)
    before = (seen.time_s > made.truth.repetitions_s[0, 0]) & (seen.time_s < at_s - 1.0)
    after = seen.time_s > at_s + 0.5
    for name, is_left_out in (
        ("trunk_lean_forward_rad", True),
        ("thorax_humerus_right_yxy_elevation", True),
        ("humerus_forearm_right_zxy_flexion", False),
        ("hand_speed_right_mps", True),
        ("wrist_right.x", False),
    ):
        measured = np.isfinite(seen.measured[:, seen.channels.index(name)])
        assert measured[before].mean() > 0.95, name
        assert measured[after].any() != is_left_out, name


def test_repetitions_go_on_being_found_and_nobody_is_blamed_for_the_sensor():
    """A trunk sensor that tilts by 30 degrees read as a trunk that leans in every repetition after it."""
    made = session("reaching", seed=6)
    start_s = made.truth.repetitions_s[0, 0] - 1.5
    sound = trajectory(run(made.recording, made.setup, POSE_S)[0])
    main = "humerus_forearm_right_zxy_flexion"
    template = build_template(sound, find_repetitions(sound, "right", start_s), "right", 0.55, main)

    def said(placement, axis):
        recording = turned(made, placement, resting_s(made, after=1), 0.4, axis, 30.0)
        found = compare(
            trajectory(run(recording, made.setup, POSE_S)[0]), template, "right", 0.55, start_s=start_s
        )
        return len(found.repetitions), codes(found.findings)

    assert said("sternum", AHEAD)[1] == ["findings.matched"]
    count, findings = said("forearm_right", AHEAD)
    assert count >= 6
    assert findings[0] in ("findings.main_not_measured", "findings.main_mostly_not_measured"), (
        "it bends the elbow by 30 degrees"
    )


def test_pieces_of_a_session_give_the_same_slips_and_frames():
    made = session("drinking", seed=3, repetitions=8)
    recording = turned(made, "hand_right", resting_s(made), 0.3, LONG, 40.0)
    slips, frames, chunk, setup = slips_of(recording, made.setup)
    search, pieces = SlipSearch(setup, POSE_S[1]), [(k, k + 777) for k in range(0, frames.tick_count, 777)]
    for first, stop in pieces:
        search.add(frames.ticks(first, stop), chunk.ticks(first, stop))
    assert search.finish() == slips
    assert [slip.placement for slip in slips] == ["hand_right"]
    for first, stop in pieces:
        part = with_slips(frames.ticks(first, stop), setup, slips)
        whole = with_slips(frames, setup, slips).ticks(first, stop)
        np.testing.assert_array_equal(part.angle_flags, whole.angle_flags)
        np.testing.assert_allclose(part.angle_sigma_rad, whole.angle_sigma_rad)


def test_two_sides_of_a_joint_at_once_are_one_doubt():
    made = session("reaching", seed=12)
    (slip,), *_ = slips_of(turned(made, "hand_right", resting_s(made), 0.3, LONG, 30.0), made.setup)
    other, later = replace(slip, placement="forearm_right"), replace(slip, time_s=slip.time_s + 9.0)
    assert in_doubt([slip, other, later]) == [(slip, other), (later,)]
    assert in_doubt([slip, replace(slip, placement="forearm_left")]) == [
        (slip,),
        (replace(slip, placement="forearm_left"),),
    ]


def changing(coordinate, by_deg, move_s, also=None):
    """Reach three times, change one coordinate of the posture for good in one quick movement, reach three times."""
    rest, far = EXERCISES["reaching"].rest_deg, EXERCISES["reaching"].stops[0].posture_deg
    changed = {coordinate: by_deg, **(also or {})}

    def moved(posture):
        return posture | {name: posture.get(name, 0.0) + by for name, by in changed.items()}

    before = (Stop(far, 1.0, 0.4), Stop(rest, 1.0, 1.0)) * 3
    after = (Stop(moved(far), 1.0, 0.4), Stop(moved(rest), 1.0, 1.0)) * 3
    return Exercise(
        "own",
        "Own",
        rest,
        (*before, Stop(moved(rest), move_s, 4.0), *after),
        1.0,
        EXERCISES["reaching"].primary_channel,
    )


@pytest.mark.parametrize(
    ("coordinate", "by_deg", "also"),
    [
        ("pronation", -40.0, None),
        ("axial", 25.0, None),
        ("wrist_flexion", 40.0, None),
        ("wrist_deviation", -20.0, None),
        ("lean_forward", 25.0, {"elevation": -8.0}),
        ("turn_left", 25.0, None),
        ("flexion", -25.0, {"wrist_flexion": 25.0}),
        ("elevation", 25.0, {"flexion": 25.0}),
    ],
)
@pytest.mark.parametrize("placements", [ONE_ARM, NO_HAND])
def test_a_posture_that_is_changed_quickly_and_held_is_no_slip(coordinate, by_deg, also, placements):
    """A held pronation, a level hand on a forearm that rises, a forearm pushed along: joints and levers say so."""
    made = session(
        changing(coordinate, by_deg, 0.3, also), seed=4, repetitions=1, soft_deg=5.0, placements=placements
    )
    assert slips_of(made.recording, made.setup)[0] == ()


@pytest.mark.parametrize("seed", range(31, 37))
def test_tremor_haste_soft_skin_and_compensation_are_no_slips(seed):
    rng = np.random.default_rng(seed)
    style = MovementStyle(
        tremor_rad=float(np.radians(rng.choice([0.0, 3.0, 6.0]))),
        tremor_hz=float(rng.uniform(4.0, 7.0)),
        speed=float(rng.choice([0.6, 1.0, 2.5])),
        posture_sd_rad=float(np.radians(rng.choice([2.0, 6.0]))),
        trunk_lean_rad=float(np.radians(rng.choice([0.0, 30.0]))),
        trunk_rotation_rad=float(np.radians(rng.choice([0.0, 15.0]))),
        submovements=int(rng.choice([1, 3])),
    )
    exercise = ("reaching", "drinking", "pronation")[seed % 3]
    made = session(
        exercise,
        seed,
        8,
        soft_deg=float(rng.choice([6.0, 12.0])),
        style=style,
        has_magnetometer=seed % 2 == 0,
    )
    assert slips_of(made.recording, made.setup)[0] == ()


def test_a_real_recording_of_both_arms_has_none():
    recording = cases.arms()
    setup = replace(session(repetitions=1).setup, placements=recording.placements)
    assert slips_of(recording, setup, (0.95, 2.0))[0] == ()


def test_what_cannot_be_told_from_movement_is_not_told():
    """Without a sensor on the hand, a forearm's sensor that turns about the forearm reads as pronation does."""
    made = session("reaching", seed=12, placements=NO_HAND)
    assert slips_of(turned(made, "forearm_right", resting_s(made), 0.3, LONG, 30.0), made.setup)[0] == ()


def test_across_the_limb_the_last_sensor_of_an_arm_is_judged_by_what_it_did_not_feel():
    made = session("reaching", seed=12, placements=NO_HAND)
    (slip,), *_ = slips_of(turned(made, "forearm_right", resting_s(made), 0.3, ACROSS, 30.0), made.setup)
    assert slip.placement == "forearm_right"
    assert np.degrees(slip.turn_rad) == pytest.approx([30.0, 0.0, 0.0], abs=5.0)


@pytest.mark.parametrize("fault", ["lost", "at its end", "pressed"])
def test_lost_clipped_and_pressed_sensors_have_not_slipped(fault):
    """Pressed: turned and back within a second, as by a hand that scratches beside it."""
    made = session("drinking", seed=17, soft_deg=5.0, style=MovementStyle(speed=1.6))
    recording, at_s = made.recording, resting_s(made)
    if fault == "lost":
        recording = kill_sensor(recording, "forearm_right", at_s - 2.0, at_s + 1.0)
    elif fault == "at its end":
        recording = saturate(recording, "forearm_right", gyroscope_radps=2.2)
    else:
        recording = turned(made, "forearm_right", at_s - 0.5, 0.1, LONG, 30.0)
        turn = rotation.rotate(made.truth.q_sensor_segment["forearm_right"], np.radians([0.0, 0.0, -30.0]))
        recording = turn_in_strap(recording, "forearm_right", at_s + 0.5, tuple(turn), 0.1)
    assert slips_of(recording, made.setup)[0] == ()


def test_a_sensor_put_right_before_the_pose_is_none():
    made = session("reaching", seed=12)
    recording = turned(made, "forearm_right", 1.0, 0.3, LONG, 30.0)
    assert slips_of(recording, made.setup)[0] == ()
