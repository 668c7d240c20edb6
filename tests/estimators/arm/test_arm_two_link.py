"""Marzouk (2009): two-link kinematics A12 and the invariances 4.3.1 to 4.3.5 of its method page."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from estimators import rotation
from estimators.arm.published import (
    inverse_transform,
    transform,
    transform_point,
    two_link_joint_angles,
    two_link_pose,
    two_link_velocity,
)

L_U, L_F = 0.30, 0.25


def positions(q1, q2):
    pose = two_link_pose(q1, q2, L_U, L_F)
    return pose.T_shoulder_elbow[..., :3, 3], pose.T_shoulder_wrist[..., :3, 3]


@pytest.fixture
def pair():
    rng = np.random.default_rng(40)
    return rotation.normalize(rng.normal(size=(10_000, 4))), rotation.normalize(rng.normal(size=(10_000, 4)))


def test_link_lengths_are_kept(pair):
    elbow, wrist = positions(*pair)
    np.testing.assert_allclose(np.linalg.norm(elbow, axis=-1), L_U, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(wrist - elbow, axis=-1), L_F, atol=1e-12)


def test_positions_equal_the_vector_form_and_the_end_has_the_forearm_orientation(pair):
    elbow, wrist = positions(*pair)
    along = np.array([1.0, 0.0, 0.0])
    np.testing.assert_allclose(wrist, elbow + L_F * rotation.rotate(pair[1], along), atol=1e-12)
    end = two_link_pose(*pair, L_U, L_F).T_shoulder_wrist[..., :3, :3]
    np.testing.assert_allclose(end, rotation.to_matrix(pair[1]), atol=1e-12)


def test_a_common_heading_turns_positions_and_moves_only_the_first_angle(pair):
    heading = 0.9
    turn = rotation.about_z(heading)
    turned = rotation.multiply(turn, pair[0]), rotation.multiply(turn, pair[1])
    for before, after in zip(positions(*pair), positions(*turned), strict=True):
        np.testing.assert_allclose(after, rotation.rotate(turn, before), atol=1e-12)
    before, _ = two_link_joint_angles(*pair)
    after, _ = two_link_joint_angles(*turned)
    difference = np.angle(np.exp(1j * (after - before)))
    np.testing.assert_allclose(difference[:, 0], heading, atol=1e-9)
    np.testing.assert_allclose(difference[:, 1:], 0.0, atol=1e-9)


def test_reference_pose():
    q = rotation.identity()
    elbow, wrist = positions(q, q)
    np.testing.assert_allclose(elbow, [L_U, 0, 0], atol=1e-15)
    np.testing.assert_allclose(wrist, [L_U + L_F, 0, 0], atol=1e-15)
    angles, residual = two_link_joint_angles(q, q)
    np.testing.assert_allclose(np.degrees(angles), [-90, 90, 90, 90, -90], atol=1e-12)
    assert residual == 0.0


def test_elbow_flexion_moves_the_wrist_on_a_circle():
    q1 = rotation.normalize(np.array([0.3, 0.2, -0.5, 0.7]))
    bend = np.linspace(0, 2, 50)
    elbow, wrist = positions(np.broadcast_to(q1, (50, 4)), rotation.multiply(q1, rotation.about_z(bend)))
    np.testing.assert_allclose(elbow, elbow[:1].repeat(50, 0), atol=1e-15)
    np.testing.assert_allclose(np.linalg.norm(wrist - elbow, axis=-1), L_F, atol=1e-12)
    normal = rotation.rotate(q1, (0.0, 0.0, 1.0))
    np.testing.assert_allclose((wrist - elbow) @ normal, 0.0, atol=1e-12)


def test_erratum_18_the_elbow_angle_moves_the_wrist():
    _, wrist = positions(rotation.identity(), rotation.about_z(np.pi / 2))
    np.testing.assert_allclose(wrist, [0.30, 0.25, 0.0], atol=1e-15)


def test_sign_of_quaternions_does_not_matter(pair):
    for one, other in zip(positions(*pair), positions(-pair[0], -pair[1]), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-14)
    np.testing.assert_allclose(
        two_link_joint_angles(*pair)[0], two_link_joint_angles(-pair[0], -pair[1])[0], atol=1e-9
    )


def test_relabelled_axes_are_undone_without_a_trace(pair):
    """R_US to R_US M^T by a proper rotation, then back."""
    m = rotation.from_scipy(Rotation.from_euler("XYZ", [90, 0, 180], degrees=True))
    relabelled = [rotation.multiply(q, rotation.conjugate(m)) for q in pair]
    restored = [rotation.multiply(q, m) for q in relabelled]
    for one, other in zip(positions(*pair), positions(*restored), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-9)


def test_shoulder_angles_equal_the_zyz_definition(pair):
    """A13.1 defines Theta 1 to 3 by R1 Rx(90 deg) in intrinsic ZYZ."""
    angles, _ = two_link_joint_angles(*pair)
    r1 = rotation.to_scipy(pair[0]) * Rotation.from_euler("X", np.pi / 2)
    rebuilt = Rotation.from_euler("ZYZ", angles[:, :3])
    assert (r1.inv() * rebuilt).magnitude().max() < 1e-9


def test_velocities_are_derivatives_of_positions(pair):
    rng = np.random.default_rng(41)
    q1, q2 = pair[0][:100], pair[1][:100]
    w1, w2 = rng.normal(size=(2, 100, 3))
    h = 1e-5
    ahead = positions(
        rotation.multiply(q1, rotation.exp(w1 * h)), rotation.multiply(q2, rotation.exp(w2 * h))
    )
    behind = positions(
        rotation.multiply(q1, rotation.exp(-w1 * h)), rotation.multiply(q2, rotation.exp(-w2 * h))
    )
    for a, b, velocity in zip(ahead, behind, two_link_velocity(q1, q2, w1, w2, L_U, L_F), strict=True):
        np.testing.assert_allclose((a - b) / (2 * h), velocity, atol=1e-8)


def test_transforms_form_a_group():
    rng = np.random.default_rng(42)
    pose = transform(rotation.normalize(rng.normal(size=(20, 4))), rng.normal(size=(20, 3)))
    np.testing.assert_allclose(
        inverse_transform(pose) @ pose, np.broadcast_to(np.eye(4), (20, 4, 4)), atol=1e-14
    )
    point = rng.normal(size=(20, 3))
    np.testing.assert_allclose(
        transform_point(inverse_transform(pose), transform_point(pose, point)), point, atol=1e-14
    )
