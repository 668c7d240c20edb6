"""The N-pose: mountings recovered exactly from exact input, honest about what is wrong with a pose."""

import math

import numpy as np
import pytest

from estimators import rotation
from estimators.calibration import n_pose
from estimators.calibration._mounting import OUTWARD_HEADING_RAD
from estimators.conventions import GRAVITY_MPS2, PLACEMENTS
from estimators.errors import ShapeError
from estimators.orientation import OrientationFlag
from tests.said import codes, refuses, sentence

ARMS = (
    "sternum",
    "upper_arm_right",
    "forearm_right",
    "hand_right",
    "upper_arm_left",
    "forearm_left",
    "hand_left",
)
N_TURN = {"forearm_right": 90, "hand_right": 90, "forearm_left": -90, "hand_left": -90}
SAMPLES = 300
NO_HEADING = int(OrientationFlag.HEADING_NOT_TRUSTED)


def by_the_rule(placement, tilt_rad=0.0, spin_rad=0.7):
    """q_room_sensor of a sensor whose z axis points outward (tilted up by `tilt_rad`), spun about it."""
    outward = rotation.multiply(
        rotation.about_z(OUTWARD_HEADING_RAD[placement]), rotation.about_y(math.pi / 2 - tilt_rad)
    )
    return rotation.multiply(outward, rotation.about_z(spin_rad))


class Pose:
    """An N-pose with known mountings; faults are put on afterwards."""

    def __init__(
        self, placements=ARMS, facing_rad=0.8, seed=3, noise=1.0, arbitrary=True, own_heading_rad=None
    ):
        rng = np.random.default_rng(seed)
        self.placements, self.facing_rad = placements, facing_rad
        self.q_room_sensor = np.stack(
            [
                by_the_rule(p, rng.uniform(-0.3, 0.3), rng.uniform(-3, 3))
                if not arbitrary or p == placements[0]
                else rotation.normalize(rng.standard_normal(4))
                for p in placements
            ]
        )
        headings = facing_rad if own_heading_rad is None else facing_rad + np.asarray(own_heading_rad)
        q = rotation.multiply(rotation.about_z(headings), self.q_room_sensor)
        self.q = np.repeat(q[:, None], SAMPLES, axis=1)
        shape = (len(placements), SAMPLES, 3)
        self.gyroscope = noise * 0.01 * rng.standard_normal(shape)
        up = rotation.rotate(rotation.conjugate(q), [0.0, 0.0, GRAVITY_MPS2])
        self.accelerometer = up[:, None] + noise * 0.15 * rng.standard_normal(shape)
        self.flags = np.zeros(shape[:2], dtype=np.uint8)

    def calibrate(self):
        return n_pose(self.q, self.gyroscope, self.accelerometer, self.placements, self.flags)

    def true_mounting(self, s):
        turn = rotation.about_z(np.deg2rad(N_TURN.get(self.placements[s], 0.0)))
        return rotation.multiply(rotation.conjugate(self.q_room_sensor[s]), turn)

    def mounting_error_deg(self, found):
        return np.rad2deg(
            [
                rotation.angle_between(found.q_sensor_segment[p], self.true_mounting(s))
                for s, p in enumerate(self.placements)
            ]
        )


def test_exact_input_gives_exact_mountings():
    pose = Pose(noise=0.0)
    found = pose.calibrate()
    np.testing.assert_allclose(pose.mounting_error_deg(found), 0.0, atol=1e-6)
    assert math.remainder(found.facing_rad - pose.facing_rad, 2 * math.pi) == pytest.approx(0.0, abs=1e-9)
    assert (found.score, found.reasons, found.heading_offset_rad) == (1.0, (), {})


def test_segments_coincide_with_the_room_afterwards():
    """The composition of the contract, in the pose itself: identity, and quarter turns of the forearms."""
    pose = Pose()
    found = pose.calibrate()
    for s, placement in enumerate(pose.placements):
        q_room_earth = rotation.about_z(-found.facing_rad)
        q = rotation.multiply(
            rotation.multiply(q_room_earth, pose.q[s, 0]), found.q_sensor_segment[placement]
        )
        expected = rotation.about_z(np.deg2rad(N_TURN.get(placement, 0.0)))
        assert rotation.angle_between(q, expected) < 1e-9


@pytest.mark.parametrize(
    "placements", [("upper_arm_right",), ("upper_arm_left",), ("forearm_left",), ("pelvis",)]
)
def test_any_sensor_can_tell_the_facing_by_its_rule(placements):
    pose = Pose(placements, noise=0.0)
    np.testing.assert_allclose(pose.mounting_error_deg(pose.calibrate()), 0.0, atol=1e-6)


def test_both_upper_arms_share_the_facing():
    """One mounted 10 degrees off each way: the mean is right, either alone would be 10 off."""
    pose = Pose(("upper_arm_right", "upper_arm_left"), noise=0.0, arbitrary=False)
    for s, off in enumerate((0.17, -0.17)):
        turn = rotation.about_z(off)
        pose.q_room_sensor[s] = rotation.multiply(turn, pose.q_room_sensor[s])
        heading = rotation.about_z(pose.facing_rad)
        pose.q[s] = rotation.multiply(heading, pose.q_room_sensor[s])
    # The horizontal part of a tilted axis turns with it, so both stay 0.17 off and cancel.
    assert pose.calibrate().facing_rad == pytest.approx(pose.facing_rad, abs=1e-9)


def test_sensors_put_on_by_the_rule_average_the_facing_and_others_have_no_say():
    """Sternum 4 degrees off: the mean is a seventh of it; one sensor put on backwards changes nothing."""
    pose = Pose(ARMS, noise=0.0, arbitrary=False)

    def turned(row, off_rad):
        pose.q_room_sensor[row] = rotation.multiply(rotation.about_z(off_rad), pose.q_room_sensor[row])
        pose.q[row] = rotation.multiply(rotation.about_z(pose.facing_rad), pose.q_room_sensor[row])

    sternum = ARMS.index("sternum")
    turned(sternum, math.radians(4.0))
    away = math.degrees(pose.calibrate().facing_rad - pose.facing_rad)
    assert 0.0 < away < 1.0
    turned((sternum + 1) % len(ARMS), math.pi)
    away = math.degrees(pose.calibrate().facing_rad - pose.facing_rad)
    assert 0.0 < away < 1.0


def test_sensors_without_compass_are_turned_by_their_rule():
    headings = np.linspace(-3, 3, len(ARMS))
    pose = Pose(noise=0.0, arbitrary=False, own_heading_rad=headings)
    pose.flags |= NO_HEADING
    found = pose.calibrate()
    np.testing.assert_allclose(pose.mounting_error_deg(found), 0.0, atol=1e-6)
    for s, placement in enumerate(ARMS):
        turned = math.remainder(found.heading_offset_rad[placement] + headings[s], 2 * math.pi)
        # All relative to the sternum's own heading, whose offset is zero.
        assert turned == pytest.approx(math.remainder(headings[0], 2 * math.pi), abs=1e-9)


def test_one_sensor_without_compass_joins_the_others():
    headings = np.zeros(len(ARMS))
    headings[3] = 1.9
    pose = Pose(noise=0.0, arbitrary=False, own_heading_rad=headings)
    pose.flags[3] |= NO_HEADING
    found = pose.calibrate()
    assert list(found.heading_offset_rad) == ["hand_right"]
    assert found.heading_offset_rad["hand_right"] == pytest.approx(-1.9, abs=1e-9)
    np.testing.assert_allclose(pose.mounting_error_deg(found), 0.0, atol=1e-6)


def test_noise_of_the_thesis_costs_little():
    pose = Pose()
    pose.gyroscope[:] += np.deg2rad(0.5)
    found = pose.calibrate()
    assert found.score > 0.95
    bias = np.array([found.gyroscope_bias_radps[p] for p in ARMS])
    # 0.01 rad/s over 300 samples: 0.0006 rad/s standard error; five of them.
    np.testing.assert_allclose(bias, np.deg2rad(0.5), atol=0.003)


def test_twitches_do_not_move_the_result():
    pose = Pose(noise=0.0)
    pose.q[2, 100:120] = rotation.multiply(pose.q[2, 100:120], rotation.about_x(0.3))
    np.testing.assert_allclose(pose.mounting_error_deg(pose.calibrate()), 0.0, atol=1e-6)


def test_swaying_lowers_the_score_and_moving_is_refused():
    swaying, moving = Pose(), Pose()
    sway = np.sin(np.linspace(0, 20, SAMPLES))
    swaying.q[1] = rotation.multiply(rotation.about_x(np.deg2rad(6.0) * sway), swaying.q[1])
    found = swaying.calibrate()
    assert 0.3 < found.score < 0.8
    assert sentence(found.reasons, "calibration.swayed").parameters["where"] == ["upper_arm_right"]
    moving.q[1] = rotation.multiply(rotation.about_x(np.deg2rad(25.0) * sway), moving.q[1])
    with refuses("calibration.pose_moved", where=["upper_arm_right"]):
        moving.calibrate()


def test_restless_gyroscopes_lower_the_score_or_are_refused():
    pose = Pose()
    pose.gyroscope[4] += np.deg2rad(6.0) * np.random.default_rng(1).standard_normal((SAMPLES, 3))
    assert codes(pose.calibrate().reasons) == ["calibration.not_still"]
    pose.gyroscope[4] *= 10.0
    with refuses("calibration.was_moving", "calibration.turned_steadily", where=["upper_arm_left"]):
        pose.calibrate()


def test_faulty_accelerometers_are_told_or_refused():
    pose = Pose()
    pose.accelerometer[3] *= 1.06
    told = sentence(pose.calibrate().reasons, "calibration.gravity_off")
    assert told.parameters["where"] == ["hand_right"]
    assert told.parameters["error"] == pytest.approx(0.06, abs=0.005)
    pose.accelerometer[3] /= 9.81  # forgot to convert from g
    with refuses("calibration.gravity_fault", where=["hand_right"]):
        pose.calibrate()


def test_orientation_that_has_not_settled_is_told():
    pose = Pose()
    pose.q[5] = rotation.multiply(rotation.about_x(np.deg2rad(10.0)), pose.q[5])
    found = pose.calibrate()
    assert found.score < 0.5
    assert sentence(found.reasons, "calibration.not_settled").parameters["where"] == ["forearm_left"]


@pytest.mark.parametrize(
    ("flag", "code"),
    [
        (OrientationFlag.MAGNETIC_DISTURBANCE, "calibration.iron_near"),
        (OrientationFlag.CONVERGING, "calibration.just_started"),
        (OrientationFlag.SATURATED, "calibration.at_limit"),
    ],
)
def test_flags_of_the_filter_are_told(flag, code):
    pose = Pose()
    pose.flags[2, 50:] |= int(flag)
    found = pose.calibrate()
    assert found.score < 0.9
    assert sentence(found.reasons, code).parameters["where"] == ["forearm_right"]
    pose.flags[2, 120:] = 0  # less than half of the pose
    assert pose.calibrate().score > found.score


def test_sternum_sensor_lying_flat_is_replaced_by_an_arm():
    pose = Pose(noise=0.0, arbitrary=False)
    flat = by_the_rule("sternum", tilt_rad=np.deg2rad(85.0))
    pose.q_room_sensor[0] = flat
    pose.q[0] = rotation.multiply(rotation.about_z(pose.facing_rad), flat)
    pose.accelerometer[0] = rotation.rotate(rotation.conjugate(pose.q[0, 0]), [0, 0, GRAVITY_MPS2])
    found = pose.calibrate()
    np.testing.assert_allclose(pose.mounting_error_deg(found), 0.0, atol=1e-6)
    told = sentence(found.reasons, "calibration.facing_by_other")
    assert told.parameters == {"where": ["sternum"], "by": ["upper_arm_right"]}
    alone = Pose(("sternum",), noise=0.0)
    alone.q[:] = pose.q[:1]
    alone.accelerometer[:] = pose.accelerometer[:1]
    with refuses("calibration.facing_unknown", where=["sternum"]):
        alone.calibrate()


def test_flat_sensor_without_compass_is_refused():
    pose = Pose(noise=0.0, arbitrary=False)
    flat = by_the_rule("hand_left", tilt_rad=np.deg2rad(-85.0))
    pose.q[6] = rotation.multiply(rotation.about_z(pose.facing_rad), flat)
    pose.accelerometer[6] = rotation.rotate(rotation.conjugate(pose.q[6, 0]), [0, 0, GRAVITY_MPS2])
    pose.flags |= NO_HEADING
    with refuses("calibration.flat_no_compass", where=["hand_left"]):
        pose.calibrate()


def test_sternum_turned_against_all_others_is_told():
    pose = Pose(noise=0.0, arbitrary=False)
    pose.q[0] = rotation.multiply(rotation.about_z(2.0), pose.q[0])
    found = pose.calibrate()
    assert found.score == pytest.approx(0.7)
    told = sentence(found.reasons, "calibration.faces_away")
    assert told.parameters["where"] == ["sternum"]
    assert told.parameters["angle_rad"] == pytest.approx(2.0, abs=0.01)


@pytest.mark.parametrize(("off_rad", "is_said"), [(np.pi, True), (0.3, False)])
def test_two_that_agree_closely_are_witnesses_against_the_sternum(off_rad, is_said):
    pose = Pose(("sternum", "upper_arm_right", "forearm_right"), noise=0.0, arbitrary=False)
    headings = np.array([off_rad, 0.05, -0.05])[:, None, None]
    rule = [by_the_rule(p, 0.0, 0.0) for p in pose.placements]
    pose.q = rotation.multiply(
        rotation.about_z(headings[..., 0]), np.repeat(np.stack(rule)[:, None], SAMPLES, axis=1)
    )
    up = rotation.rotate(rotation.conjugate(pose.q[:, 0]), [0.0, 0.0, GRAVITY_MPS2])
    pose.accelerometer = np.repeat(up[:, None], SAMPLES, axis=1)
    said = [one.code for one in pose.calibrate().reasons]
    assert ("calibration.faces_away" in said) == is_said


def test_many_faults_together_are_refused():
    pose = Pose()
    pose.flags |= int(OrientationFlag.MAGNETIC_DISTURBANCE) | int(OrientationFlag.CONVERGING)
    pose.q[5] = rotation.multiply(rotation.about_x(np.deg2rad(11.0)), pose.q[5])
    with refuses("calibration.pose_unusable") as caught:
        pose.calibrate()
    assert {"calibration.iron_near", "calibration.just_started"} <= set(codes(caught.value.message))


def test_missing_data_is_refused():
    pose = Pose()
    pose.flags[1] |= int(OrientationFlag.INVALID)
    with refuses("calibration.no_data", where=["upper_arm_right"]):
        pose.calibrate()
    pose = Pose()
    pose.flags[1, :250] |= int(OrientationFlag.INVALID)
    pose.q[1, :250] = np.nan
    np.testing.assert_allclose(pose.mounting_error_deg(pose.calibrate()), 0.0, atol=1e-4)


def test_shapes_are_checked():
    pose = Pose()
    with pytest.raises(ShapeError, match="q_earth_sensor"):
        n_pose(pose.q[:3], pose.gyroscope, pose.accelerometer, pose.placements)
    with pytest.raises(ShapeError, match="flags"):
        n_pose(pose.q, pose.gyroscope, pose.accelerometer, pose.placements, pose.flags[:, 1:])


def test_every_placement_has_a_rule():
    assert set(OUTWARD_HEADING_RAD) == set(PLACEMENTS)
    pose = Pose(PLACEMENTS, noise=0.0, arbitrary=False)
    np.testing.assert_allclose(pose.mounting_error_deg(pose.calibrate()), 0.0, atol=1e-5)
