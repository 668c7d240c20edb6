"""How well a pose tells the mounting of each sensor."""

import numpy as np
import pytest

from estimators.calibration import n_pose
from estimators.calibration.movement.joint_axes import frame_from, sigma_about_axes
from tests.estimators.calibration.test_n_pose import NO_HEADING, SAMPLES, Pose
from tests.said import codes

TILT, HEADING, PUT_ON = 1.0, 2.0, 4.0


def found_deg(pose, **more):
    sensors = len(pose.placements)
    sigma = np.deg2rad(np.tile([TILT, TILT, HEADING], (sensors, SAMPLES, 1)))
    found = n_pose(
        pose.q, pose.gyroscope, pose.accelerometer, pose.placements, pose.flags, sigma_rad=sigma, **more
    )
    return found, {name: np.rad2deg(values) for name, values in found.mounting_sigma_rad.items()}


def test_with_a_compass_heading_and_facing_count():
    found, sigma = found_deg(Pose(noise=0.0))  # put on any way round: the sternum alone tells the facing
    assert set(sigma) == set(found.q_sensor_segment)
    for values in sigma.values():
        np.testing.assert_allclose(values, [TILT, TILT, np.hypot(HEADING, PUT_ON)], rtol=1e-6)
    assert found.score == 1.0
    several = found_deg(Pose(noise=0.0, arbitrary=False))[1]["sternum"]  # all by the rule: an average of them
    assert HEADING < several[2] < np.hypot(HEADING, PUT_ON / 2.0)


def test_without_a_compass_headings_are_assumed_and_this_is_told():
    pose = Pose(noise=0.0, arbitrary=False)
    pose.flags |= NO_HEADING
    found, sigma = found_deg(pose)
    for values in sigma.values():
        np.testing.assert_allclose(values, [TILT, TILT, PUT_ON], rtol=1e-6)
    assert found.score == pytest.approx(0.85)
    assert codes(found.reasons) == ["calibration.put_on"]
    assert "forearm_right" in found.reasons[0].parameters["where"]


def test_of_a_raised_arm_another_axis_is_vertical():
    sigma = found_deg(Pose(noise=0.0), arms="sideways")[1]
    np.testing.assert_allclose(sigma["sternum"], [TILT, TILT, np.hypot(HEADING, PUT_ON)], rtol=1e-6)
    np.testing.assert_allclose(sigma["upper_arm_left"], [TILT, np.hypot(HEADING, PUT_ON), TILT], rtol=1e-6)


def test_without_a_sigma_of_the_filter_that_of_settled_sensors_counts():
    pose = Pose(noise=0.0)
    silent = np.full((len(pose.placements), SAMPLES, 3), np.nan)
    given = (pose.q, pose.gyroscope, pose.accelerometer, pose.placements, pose.flags)
    assert n_pose(*given, sigma_rad=silent).mounting_sigma_rad == n_pose(*given).mounting_sigma_rad
    assert min(min(values) for values in n_pose(*given).mounting_sigma_rad.values()) > np.deg2rad(0.5)


def test_movements_tell_each_axis_by_the_others():
    along_x, along_y = (np.array([1.0, 0.0, 0.0]),) * 2, (np.array([0.0, 1.0, 0.0]),) * 2
    directions = [(*along_x, 0.02), (*along_y, 0.05)]
    found = sigma_about_axes(directions)
    # The turn about x is told by y alone, that about y by x alone, that about z by both.
    np.testing.assert_allclose(found, [0.05, 0.02, 1.0 / np.hypot(1 / 0.02, 1 / 0.05)], rtol=1e-6)
    assert found.max() == pytest.approx(frame_from(directions)[1])
