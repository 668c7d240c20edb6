"""Alignment of markers with a sensor is exact without errors, and refuses what cannot tell."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from estimators import rotation
from estimators.errors import ShapeError
from estimators.orientation.published import (
    align_marker_frame,
    heading_offset,
    stick_angle_errors,
)


def poses(true: Rotation, turns: list[Rotation]):
    force = np.array([(turn * true).inv().apply([0.0, 0.0, 9.81]) for turn in turns])
    return force, np.array([rotation.from_scipy(turn) for turn in turns])


def test_two_still_poses_tell_the_alignment():
    generator = np.random.default_rng(3)
    for _ in range(20):
        true, first = (Rotation.random(rng=generator) for _ in range(2))
        second = Rotation.from_euler("x", 90, degrees=True) * first
        found = align_marker_frame(*poses(true, [first, second]))
        assert (rotation.to_scipy(found) * true.inv()).magnitude() < 1e-12


def test_poses_that_differ_too_little_are_refused():
    turn = Rotation.from_euler("x", 20, degrees=True)
    with pytest.raises(ShapeError, match="45 degrees"):
        align_marker_frame(*poses(Rotation.identity(), [Rotation.identity(), turn]))
    with pytest.raises(ShapeError, match="45 degrees"):
        # A turn about the vertical shows the same vertical again.
        align_marker_frame(
            *poses(Rotation.identity(), [Rotation.identity(), Rotation.from_euler("z", 90, degrees=True)])
        )
    with pytest.raises(ShapeError, match="two at least"):
        align_marker_frame(np.array([[0.0, 0.0, 9.81]]), np.array([[1.0, 0.0, 0.0, 0.0]]))


def test_heading_offset_across_the_seam():
    generator = np.random.default_rng(4)
    q = rotation.normalize(generator.normal(size=(50, 4)))
    for offset in (0.3, -2.0, np.pi - 1e-3):
        turned = rotation.multiply(rotation.about_z(np.full(50, offset)), q)
        turned[::2] *= -1.0
        assert heading_offset(q, turned) == pytest.approx(offset, abs=1e-9)


def test_stick_angles_by_their_derivative():
    # At a right angle of two 100 mm sticks, 1 mm more is 0.81 degrees (page 2.8).
    right = 0.1 * np.sqrt(2.0)
    assert stick_angle_errors(np.array([right]), 0.1, 0.1)[0] == pytest.approx(0.0, abs=1e-12)
    more = np.degrees(stick_angle_errors(np.array([right + 1e-3]), 0.1, 0.1)[0])
    assert abs(more) == pytest.approx(0.81, abs=0.01)
