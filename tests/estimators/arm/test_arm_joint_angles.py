"""ISB angles: the sign table played movement by movement, inverses, mirror, singularity."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from estimators import rotation
from estimators.arm import ArmModel, BodyDimensions, segments_from_angles
from estimators.arm.published import (
    SIGN_TABLE,
    SINGULAR_MARGIN_RAD,
    continuous_shoulder_angles,
    elbow_angles,
    elbow_from_angles,
    mirrored,
    shoulder_angles,
    shoulder_from_angles,
    trunk_angles,
    trunk_from_angles,
    wrist_angles,
    wrist_from_angles,
)
from estimators.conventions import SIDES

PLACEMENTS = (
    "sternum",
    "upper_arm_left",
    "forearm_left",
    "hand_left",
    "upper_arm_right",
    "forearm_right",
    "hand_right",
)


def about(axis, degrees):
    """Turn about a *room* axis, by scipy: independent of the code under test."""
    return Rotation.from_rotvec(np.radians(degrees) * np.asarray(axis, dtype=float))


FORWARD, LEFT, UP = np.eye(3)


def movements(side):
    """Name of the column to what is turned, as rotations of whole limbs about room axes.

    Each entry: start posture and movement, as dict of segment to room rotation, applied to everything
    distal. Written from anatomy, with no Euler angle in it. `out` is away from the body.
    """
    sign = 1.0 if side == "right" else -1.0  # a turn that is inward on the right is +z, +x ... mirrored
    raise_side = about(FORWARD, -sign * 80)
    raise_front = about(LEFT, -80)
    return {
        "thorax_humerus_{side}_yxy_plane_of_elevation": ({"arm": raise_side}, {"arm": about(UP, sign * 30)}),
        "thorax_humerus_{side}_yxy_elevation": (
            {"arm": about(FORWARD, -sign * 20)},
            {"arm": about(FORWARD, -sign * 30)},
        ),
        # Upper arm forward, then turned inward about its own long axis, which now points forward: the raised
        # right forearm would go left.
        "thorax_humerus_{side}_yxy_axial_rotation": (
            {"arm": raise_front},
            {"arm": about(FORWARD, -sign * 30)},
        ),
        "humerus_forearm_{side}_zxy_flexion": ({}, {"forearm": about(LEFT, -30)}),
        "humerus_forearm_{side}_zxy_carrying": ({}, {"forearm": about(FORWARD, -sign * 15)}),
        "humerus_forearm_{side}_zxy_pronation": ({}, {"forearm": about(UP, sign * 30)}),
        "forearm_hand_{side}_zxy_flexion": ({}, {"hand": about(LEFT, -30)}),
        # Anatomical position: the little finger is on the inner side.
        "forearm_hand_{side}_zxy_deviation": ({}, {"hand": about(FORWARD, sign * 15)}),
        "forearm_hand_{side}_zxy_rotation": ({}, {"hand": about(UP, sign * 10)}),
        "trunk_lean_forward_rad": ({}, {"trunk": about(LEFT, 20)}),
        "trunk_lean_lateral_rad": ({}, {"trunk": about(FORWARD, 20)}),
        "trunk_axial_rotation_rad": ({}, {"trunk": about(UP, 20)}),
    }


DISTAL = {
    "trunk": ("sternum", "upper_arm", "forearm", "hand"),
    "arm": ("upper_arm", "forearm", "hand"),
    "forearm": ("forearm", "hand"),
    "hand": ("hand",),
}


def play(side, *stages):
    """Room orientations of all placements after turning limbs about room axes, stage after stage."""
    held = {name: Rotation.identity() for name in PLACEMENTS}
    for stage in stages:
        for limb, turn in stage.items():
            for segment in DISTAL[limb]:
                name = segment if segment == "sternum" else f"{segment}_{side}"
                held[name] = turn * held[name]
    return rotation.from_scipy(Rotation.concatenate([held[name] for name in PLACEMENTS]))


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("row", SIGN_TABLE, ids=lambda row: row.column)
def test_sign_table_is_what_the_movements_give(side, row):
    model = ArmModel(BodyDimensions(), PLACEMENTS, 0.01)
    start, movement = movements(side)[row.column]
    before = model.evaluate(play(side, start)[None])
    after = model.evaluate(play(side, start, movement)[None])
    column = row.column.format(side=side)
    if column in model.angles:
        at = model.angles.index(column)
        moved = after.angle_rad[0] - before.angle_rad[0]
    else:
        at = model.scalars.index(column)
        moved = after.scalar[0] - before.scalar[0]
    assert np.degrees(moved[at]) > 9.0
    # The other columns of the same joint stay: the movement is pure.
    if column in model.angles and "axial" not in column:
        same = [
            i
            for i, name in enumerate(model.angles)
            if name.startswith(column[: column.index(side)]) and side in name
        ]
        others = [i for i in same if i != at]
        assert np.abs(moved[others]).max() < 1e-9


def test_every_row_of_the_sign_table_has_a_movement():
    assert {row.column for row in SIGN_TABLE} == set(movements("right"))


@pytest.mark.parametrize("side", SIDES)
def test_flexion_to_the_front_has_plane_90_and_n_pose_has_pronation_90(side):
    model = ArmModel(BodyDimensions(), PLACEMENTS, 0.01)
    raised = model.evaluate(play(side, {"arm": about(LEFT, -70)})[None]).angle_rad[0]
    at = model.angles.index(f"thorax_humerus_{side}_yxy_plane_of_elevation")
    np.testing.assert_allclose(np.degrees(raised[at : at + 3]), [90, 70, -90], atol=1e-9)
    sign = 1 if side == "right" else -1
    n_pose = model.evaluate(play(side, {"forearm": about(UP, sign * 90)})[None])
    at = model.angles.index(f"humerus_forearm_{side}_zxy_pronation")
    assert np.degrees(n_pose.angle_rad[0, at]) == pytest.approx(90)
    assert n_pose.point_room_m[0, model.points.index(f"hand_{side}"), 1] * sign < 0


@pytest.mark.parametrize("side", SIDES)
def test_angles_and_orientations_are_inverse(side):
    rng = np.random.default_rng(20)
    shoulder = rng.uniform([-2.0, 0.01, -2.0], [2.0, 3.13, 2.0], (2000, 3))
    hinge = rng.uniform([-3.0, -1.5, -3.0], [3.0, 1.5, 3.0], (2000, 3))
    # Near elevation 0.01 the angle itself is the ratio of numbers of size 0.01: 1e-16 / 0.01^2.
    np.testing.assert_allclose(
        shoulder_angles(shoulder_from_angles(*shoulder.T, side), side), shoulder, atol=1e-11
    )
    np.testing.assert_allclose(elbow_angles(elbow_from_angles(*hinge.T, side), side), hinge, atol=1e-11)
    np.testing.assert_allclose(wrist_angles(wrist_from_angles(*hinge.T, side), side), hinge, atol=1e-11)
    np.testing.assert_allclose(trunk_angles(trunk_from_angles(*hinge.T)), hinge, atol=1e-11)


def test_angles_equal_scipy_intrinsic_sequences_in_isb_axes():
    """ISB axes X forward, Y up, Z right; scipy's own Euler code as the judge."""
    rng = np.random.default_rng(21)
    q = rotation.normalize(rng.normal(size=(500, 4)))
    isb = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]], dtype=float)
    r = Rotation.from_matrix(isb @ rotation.to_matrix(q) @ isb.T)
    yxy = r.as_euler("YXY")
    # scipy keeps the middle angle in [0, pi]; ISB elevation is negative: the other branch of the same pose.
    found = shoulder_angles(q, "right")
    np.testing.assert_allclose(found[:, 1], yxy[:, 1], atol=1e-9)
    for column in (0, 2):
        turn = found[:, column] - yxy[:, column] - np.pi
        np.testing.assert_allclose(np.cos(turn), 1.0, atol=1e-12)
    zxy = r.as_euler("ZXY")
    np.testing.assert_allclose(elbow_angles(q, "right"), zxy * [1, -1, 1], atol=1e-9)
    np.testing.assert_allclose(wrist_angles(q, "right"), zxy, atol=1e-9)


def test_mirrored_pose_gives_the_same_angles_on_the_other_side():
    rng = np.random.default_rng(22)
    q = rotation.normalize(rng.normal(size=(100, 4)))
    reflection = np.diag([1.0, -1.0, 1.0])
    np.testing.assert_allclose(
        rotation.to_matrix(mirrored(q)), reflection @ rotation.to_matrix(q) @ reflection, atol=1e-12
    )
    for angles in (shoulder_angles, elbow_angles, wrist_angles):
        np.testing.assert_allclose(angles(mirrored(q), "left"), angles(q, "right"), atol=1e-12)


def test_segments_from_angles_round_trip_through_the_model():
    rng = np.random.default_rng(23)
    model = ArmModel(BodyDimensions(), PLACEMENTS, 0.01)
    columns = {name: rng.uniform(0.3, 1.2, 50) for name in model.angles}
    columns |= {name: rng.uniform(-0.3, 0.3, 50) for name in model.scalars if name.startswith("trunk")}
    segments = segments_from_angles(columns)
    result = model.evaluate(np.stack([segments[name] for name in PLACEMENTS], axis=1))
    for i, name in enumerate(model.angles):
        np.testing.assert_allclose(result.angle_rad[:, i], columns[name], atol=1e-10)
    for i, name in enumerate(model.scalars):
        if name.startswith("trunk"):
            np.testing.assert_allclose(result.scalar[:, i], columns[name], atol=1e-10)


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("pole", [0.0, np.pi])
def test_angles_do_not_jump_through_the_singularity(side, pole):
    """Down (or up) in one plane, through the pole, away in another: 3 s at 100 Hz, and noisy."""
    ticks = 300
    rng = np.random.default_rng(24)
    away = np.radians(50) * np.abs(np.linspace(1, -1, ticks))
    plane = np.where(np.arange(ticks) < ticks // 2, 0.2, 1.5)
    elevation = away if pole == 0.0 else np.pi - away
    # At the lower pole plane + axial is what the pose shows, at the upper plane - axial: keep that steady.
    axial = 0.1 - plane if pole == 0.0 else plane - 0.1
    q = shoulder_from_angles(plane, elevation, axial, side)
    q = rotation.multiply(q, rotation.exp(rng.normal(0, np.radians(0.3), (ticks, 3))))
    found = continuous_shoulder_angles(q, side, 0.01)
    steps = np.abs(np.diff(found, axis=0))
    # The plane changes by 75 degrees within the 60 ticks in the zone; tick by tick it would jump.
    assert np.degrees(steps[:, [0, 2]].max()) < 15.0
    raw_steps = np.abs(np.diff(shoulder_angles(q, side), axis=0))
    assert np.degrees(raw_steps[:, [0, 2]].max()) > 40.0
    outside = np.minimum(found[:, 1], np.pi - found[:, 1]) > SINGULAR_MARGIN_RAD
    turns = (found[outside] - shoulder_angles(q, side)[outside]) / (2 * np.pi)
    np.testing.assert_allclose(turns, np.round(turns), atol=1e-9)
    # Inside, the pose is kept but for the direction of a small lean.
    error = rotation.angle_between(shoulder_from_angles(*found.T, side), q)
    assert error.max() < 2 * SINGULAR_MARGIN_RAD
    exact = np.minimum(away, 1.0) < 1e-2
    assert error[exact].max() < 0.05


@pytest.mark.parametrize("elevation", [0.6, 0.2])
def test_windings_heal_instead_of_piling_up(elevation):
    """Ten circles of the hanging arm leave each angle within 30 degrees more than half a turn of its middle."""
    ticks = 2000
    plane = np.linspace(0, 20 * np.pi, ticks)
    q = shoulder_from_angles(plane, np.full(ticks, elevation), -plane, "right")
    found = continuous_shoulder_angles(q, "right", 0.01)
    assert np.abs(np.degrees(found[:, [0, 2]]) - [45.0, -30.0]).max() <= 210.0
    assert rotation.angle_between(shoulder_from_angles(*found.T, "right"), q).max() < 1e-6
