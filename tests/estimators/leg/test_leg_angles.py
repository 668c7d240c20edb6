"""Angles of hip, knee and ankle: what movements give, closed forms, the numpy twin, sigma, what is worn."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from estimators import rotation
from estimators.conventions import PLACEMENTS, SIDES
from estimators.errors import SetupError, ShapeError
from estimators.leg import LEG_ANGLES, LegModel
from estimators.leg.published import JOINTS, from_angles, joint_angle_sigma, joint_angles
from estimators.orientation import OrientationFlag

WORN = (
    "pelvis",
    *(f"{part}_{side}" for side in SIDES for part in ("thigh", "shank", "foot")),
)
FORWARD, LEFT, UP = np.eye(3)
DISTAL = {
    "thigh": ("thigh", "shank", "foot"),
    "shank": ("shank", "foot"),
    "foot": ("foot",),
}


def about(axis, degrees):
    """Turn about a *room* axis, by scipy: independent of the code under test."""
    return Rotation.from_rotvec(np.radians(degrees) * np.asarray(axis, dtype=float))


def inward(side):
    """Sign about x and z of a turn that goes toward the middle of the body; positive about z on the right."""
    return 1.0 if side == "right" else -1.0


# From anatomy, with no Euler angle in it: which limb turns about which room axis, and by how much.
MOVEMENTS = {
    # The thigh rises in front; the heel goes to the buttock; the toes come up.
    "pelvis_thigh_{side}_zxy_flexion": ("thigh", LEFT, lambda side: -30.0),
    "thigh_shank_{side}_zxy_flexion": ("shank", LEFT, lambda side: 30.0),
    "shank_foot_{side}_zxy_flexion": ("foot", LEFT, lambda side: -15.0),
    # The leg goes away from the body; the sole turns to face the other foot.
    "pelvis_thigh_{side}_zxy_abduction": ("thigh", FORWARD, lambda side: -20.0 * inward(side)),
    "thigh_shank_{side}_zxy_abduction": ("shank", FORWARD, lambda side: -10.0 * inward(side)),
    "shank_foot_{side}_zxy_inversion": ("foot", FORWARD, lambda side: 15.0 * inward(side)),
    # The toes turn toward the other foot.
    "pelvis_thigh_{side}_zxy_internal_rotation": ("thigh", UP, lambda side: 25.0 * inward(side)),
    "thigh_shank_{side}_zxy_internal_rotation": ("shank", UP, lambda side: 10.0 * inward(side)),
    "shank_foot_{side}_zxy_internal_rotation": ("foot", UP, lambda side: 10.0 * inward(side)),
}


def evaluated(placements, q, sigma=None, flags=None):
    """Angles, sigmas and flags of orientations in the order of the placements, shape (K, S, 4)."""
    model = LegModel(placements)
    shape = (len(q), len(model.angles))
    found = np.full(shape, np.nan), np.full(shape, np.nan), np.zeros(shape, dtype=np.uint8)
    sigma = np.zeros((*q.shape[:2], 3)) if sigma is None else sigma
    flags = np.zeros(q.shape[:2], dtype=np.uint8) if flags is None else flags
    model.write(np.ascontiguousarray(q), sigma, flags, *found)
    return model, *found


def random_poses(seed, ticks=300):
    """Smooth random orientations of all worn segments, some beyond the singularity."""
    random = np.random.default_rng(seed)
    start = rotation.normalize(random.normal(size=(1, len(WORN), 4)))
    return rotation.multiply(
        start, rotation.exp(np.cumsum(random.normal(0, 0.08, (ticks, len(WORN), 3)), axis=0))
    )


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("column", MOVEMENTS)
def test_each_movement_moves_its_own_angle_alone_and_upward(column, side):
    limb, axis, degrees = MOVEMENTS[column]
    turn = about(axis, degrees(side))
    held = {name: Rotation.identity() for name in WORN}
    for segment in DISTAL[limb]:
        held[f"{segment}_{side}"] = turn
    # Whichever way the person faces.
    facing = about(UP, 130)
    q = rotation.from_scipy(Rotation.concatenate([facing * held[name] for name in WORN]))[None]
    model, angle, _, _ = evaluated(WORN, q)
    expected = np.zeros(len(model.angles))
    expected[model.angles.index(column.format(side=side))] = abs(degrees(side))
    np.testing.assert_allclose(np.degrees(angle[0]), expected, atol=1e-9)


def test_every_angle_has_its_movement():
    assert {column.format(side=side) for column in MOVEMENTS for side in SIDES} == set(LEG_ANGLES)
    assert LegModel(WORN).angles == LEG_ANGLES
    assert LegModel(PLACEMENTS).angles == LEG_ANGLES


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("joint", JOINTS)
def test_angles_build_the_posture_they_were_read_from(joint, side):
    random = np.random.default_rng(5)
    angles = random.uniform((-3.0, -1.4, -3.0), (3.0, 1.4, 3.0), (500, 3))
    np.testing.assert_allclose(joint_angles(joint, side, from_angles(joint, side, angles)), angles, atol=1e-9)


def test_kernel_equals_its_numpy_twin():
    q, random = random_poses(6), np.random.default_rng(7)
    q[100:130, WORN.index("shank_right")] = np.nan
    sigma = random.uniform(0.005, 0.05, (*q.shape[:2], 3))
    flags = random.integers(0, 8, q.shape[:2]).astype(np.uint8)
    model, angle, one_sigma, angle_flags = evaluated(WORN, q, sigma, flags)
    for j, (name, side) in enumerate((name, side) for side in SIDES for name in JOINTS):
        columns = slice(3 * j, 3 * j + 3)
        assert all(one.startswith(f"{name}_{side}_") for one in model.angles[columns])
        parent, child = (WORN.index(part.format(side=side)) for part in JOINTS[name][:2])
        apart = rotation.multiply(rotation.conjugate(q[:, parent]), q[:, child])
        expected = joint_angles(name, side, apart)
        np.testing.assert_allclose(angle[:, columns], expected, atol=1e-7)
        known = np.isfinite(expected).all(axis=1)
        twin = joint_angle_sigma(
            name, side, *(part[known, s] for part in (q, sigma) for s in (parent, child))
        )
        np.testing.assert_allclose(one_sigma[known, columns], twin, rtol=1e-5)
        assert np.isnan(one_sigma[~known, columns]).all()
        singular = np.abs(np.abs(expected[:, 1]) - np.pi / 2) < np.radians(10.0)
        both = flags[:, parent] | flags[:, child]
        np.testing.assert_array_equal(angle_flags[:, 3 * j + 1], both)
        np.testing.assert_array_equal(
            angle_flags[:, 3 * j], both | np.where(singular, int(OrientationFlag.SINGULAR), 0)
        )


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("joint", JOINTS)
def test_sigma_covers_the_error_over_fresh_seeds(joint, side):
    """Bent by ordinary angles, segments turned by random small errors: how often two sigma hold the error."""
    random = np.random.default_rng([8, *joint.encode(), *side.encode()])
    truth = random.uniform((-0.3, -0.3, -0.3), (1.8, 0.3, 0.3), (4000, 3))
    worn = tuple(part.format(side=side) for part in JOINTS[joint][:2])
    parent = rotation.exp(random.normal(0.0, 0.6, (4000, 3)))
    exact = np.stack([parent, rotation.multiply(parent, from_angles(joint, side, truth))], axis=1)
    sigma = random.uniform(0.005, 0.05, (4000, 2, 3))
    measured = rotation.multiply(rotation.exp(sigma * random.normal(size=(4000, 2, 3))), exact)
    _, angle, one_sigma, _ = evaluated(worn, measured, sigma)
    within = (np.abs(angle - truth) < 2.0 * one_sigma).mean(axis=0)
    np.testing.assert_allclose(within, 0.9545, atol=0.015)


def test_only_joints_with_both_segments_are_told():
    assert LegModel(("thigh_left", "shank_left")).angles == LEG_ANGLES[3:6]
    assert LegModel(("foot_right", "shank_right", "sternum")).angles == LEG_ANGLES[15:]
    assert LegModel(("pelvis", "shank_right", "sternum", "upper_arm_left")).angles == ()
    assert LegModel(("pelvis", "thigh_right", "foot_right")).angles == LEG_ANGLES[9:12]


def test_columns_before_those_of_the_legs_are_left_alone():
    model = LegModel(("thigh_left", "shank_left"))
    q = np.broadcast_to(rotation.identity(), (4, 2, 4)).copy()
    angle, sigma, flags = np.full((4, 5), 7.0), np.full((4, 5), 7.0), np.full((4, 5), 7, dtype=np.uint8)
    model.write(q, np.zeros((4, 2, 3)), np.zeros((4, 2), dtype=np.uint8), angle, sigma, flags)
    for found in (angle, sigma, flags):
        assert (found[:, :2] == 7).all()
        assert (found[:, 2:] == 0).all()


def test_what_does_not_fit_is_refused():
    with pytest.raises(SetupError, match="twice"):
        LegModel(("thigh_left", "thigh_left"))
    model = LegModel(("thigh_left", "shank_left"))
    q, sigma, flags = np.zeros((4, 2, 4)), np.zeros((4, 2, 3)), np.zeros((4, 2), dtype=np.uint8)
    with pytest.raises(ShapeError):
        model.write(q, sigma, flags, np.zeros((4, 2)), np.zeros((4, 2)), np.zeros((4, 2), dtype=np.uint8))
    with pytest.raises(ShapeError):
        model.write(
            q[:, :1], sigma, flags, np.zeros((4, 3)), np.zeros((4, 3)), np.zeros((4, 3), dtype=np.uint8)
        )
