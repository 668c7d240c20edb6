"""Denavit-Hartenberg chains, dual quaternions and homogeneous transforms: one arm, three ways (V8, 4.3, E-25)."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from estimators import rotation
from estimators.arm import MODEL_ANGLES, BodyDimensions, segments_from_angles
from estimators.arm.chains import chain_kernel as kernels
from estimators.arm.published import (
    ARM_CHAIN_ENDS,
    KINEMATIC_METHODS,
    WRIST_JOINT_RAD,
    LinkChain,
    arm_chain,
    arm_dual_quaternions,
    chain_dual_quaternions,
    chain_screw_axes,
    chain_transforms,
    check_chain,
    check_joints,
    continuous_two_link_joint_angles,
    dual_inverse,
    dual_multiply,
    dual_normalize,
    dual_position,
    dual_quaternion,
    dual_transform_point,
    five_joint_chain,
    five_joint_pose,
    inverse_transform,
    joint_centres,
    link_transform,
    operation_count,
    screw,
    segment_transforms,
    transform,
    transform_point,
    two_link_joint_angles,
    two_link_pose,
)
from estimators.errors import SetupError, ShapeError

L_U, L_F = 0.30, 0.25
ENDS = (3, 6)
TIGHT = 1e-12
"""The issue's figure. Rounding of a dozen products of numbers near one is some 1e-15."""


@pytest.fixture
def pair():
    rng = np.random.default_rng(50)
    return rotation.normalize(rng.normal(size=(2, 10_000, 4)))


def without_carrying_angle(q1, rng):
    flexion, turn = rng.uniform(-np.pi, np.pi, (2, len(q1)))
    return rotation.multiply(q1, rotation.multiply(rotation.about_z(flexion), rotation.about_x(turn)))


def all_three(chain, joints, ends=None):
    """Poses by matrices, by screw axes, by dual quaternions, all as (..., F, 4, 4)."""
    dual = chain_dual_quaternions(chain, joints, ends)
    return (
        chain_transforms(chain, joints, ends),
        chain_screw_axes(chain, joints, ends),
        transform(dual[..., :4], dual_position(dual)),
    )


def test_every_pair_of_modules_is_the_same_by_all_kinematics(pair):
    truth = two_link_pose(*pair, L_U, L_F)
    joints = check_joints(*pair)
    for poses in all_three(check_chain(L_U, L_F), joints, ENDS):
        np.testing.assert_allclose(poses[:, 1], truth.T_shoulder_wrist, atol=TIGHT)
        np.testing.assert_allclose(poses[:, 0, :3, 3], truth.T_shoulder_elbow[:, :3, 3], atol=TIGHT)
        np.testing.assert_allclose(poses[:, 0, :3, :3], truth.T_shoulder_elbow[:, :3, :3], atol=TIGHT)


def test_two_link_pose_is_the_product_of_homogeneous_transforms(pair):
    """(4.4) to (4.8) as they stand, corrected by E-18, against the compiled form."""
    q1, q2 = pair
    relative = rotation.multiply(rotation.conjugate(q1), q2)
    elbow = transform(q1, rotation.rotate(q1, (L_U, 0, 0)))
    wrist = elbow @ transform(relative, rotation.rotate(relative, (L_F, 0, 0)))
    pose = two_link_pose(q1, q2, L_U, L_F)
    np.testing.assert_allclose(pose.T_shoulder_elbow, elbow, atol=TIGHT)
    np.testing.assert_allclose(pose.T_shoulder_wrist, wrist, atol=TIGHT)


def test_published_chain_is_exact_without_a_carrying_angle(pair):
    q1 = pair[0]
    q2 = without_carrying_angle(q1, np.random.default_rng(51))
    truth = two_link_pose(q1, q2, L_U, L_F)
    found = five_joint_pose(q1, q2, L_U, L_F)
    np.testing.assert_allclose(found.T_shoulder_elbow, truth.T_shoulder_elbow, atol=TIGHT)
    np.testing.assert_allclose(found.T_shoulder_wrist, truth.T_shoulder_wrist, atol=TIGHT)
    np.testing.assert_allclose(found.residual_rad, 0.0, atol=TIGHT)
    np.testing.assert_allclose(found.wrist_error_m, 0.0, atol=TIGHT)
    joints = np.concatenate((found.joint_rad, np.full((len(q1), 1), WRIST_JOINT_RAD)), axis=1)
    for poses in all_three(five_joint_chain(L_U, L_F), joints, ENDS):
        np.testing.assert_allclose(poses[:, 1], truth.T_shoulder_wrist, atol=TIGHT)


def test_the_residual_says_how_far_off_the_five_joint_wrist_is(pair):
    truth = two_link_pose(*pair, L_U, L_F)
    found = five_joint_pose(*pair, L_U, L_F)
    off = np.linalg.norm((found.T_shoulder_wrist - truth.T_shoulder_wrist)[:, :3, 3], axis=-1)
    np.testing.assert_allclose(off, found.wrist_error_m, atol=TIGHT)
    # Published: 2.2 cm at 5 degrees, 4.4 cm at 10.
    for carrying_deg, centimetres in ((5.0, 2.2), (10.0, 4.4)):
        q2 = rotation.about_y(-np.radians(carrying_deg))
        error = five_joint_pose(rotation.identity(), q2, L_U, L_F).wrist_error_m
        assert 100 * float(error) == pytest.approx(centimetres, abs=0.05)


def test_closed_form_of_the_five_joint_wrist_does_not_depend_on_pronation():
    rng = np.random.default_rng(52)
    joints = rng.uniform(-np.pi, np.pi, (500, 6))
    joints[:, 5] = WRIST_JOINT_RAD
    poses = chain_transforms(five_joint_chain(L_U, L_F), joints, ENDS)
    in_elbow = transform_point(inverse_transform(poses[:, 0]), poses[:, 1, :3, 3])
    fourth = joints[:, 3]
    expected = L_F * np.stack((np.sin(fourth), -np.cos(fourth), np.zeros(500)), axis=-1)
    np.testing.assert_allclose(in_elbow, expected, atol=TIGHT)


def test_reference_pose_of_the_thesis():
    q = rotation.identity()
    found = five_joint_pose(q, q, L_U, L_F)
    np.testing.assert_allclose(np.degrees(found.joint_rad), [-90, 90, 90, 90, -90], atol=1e-12)
    np.testing.assert_allclose(found.T_shoulder_elbow[:3, 3], [L_U, 0, 0], atol=1e-15)
    np.testing.assert_allclose(found.T_shoulder_wrist[:3, 3], [L_U + L_F, 0, 0], atol=1e-15)
    assert found.singular_distance_rad == pytest.approx(np.pi / 2)


@pytest.mark.parametrize("links", range(2, 9))
def test_general_chains_agree(links):
    rng = np.random.default_rng(53 + links)
    chain = LinkChain(*(tuple(rng.uniform(-1, 1, links)) for _ in range(2)), tuple(rng.uniform(-3, 3, links)))
    joints = rng.uniform(-7, 7, (300, links))
    matrices, axes, dual = all_three(chain, joints)
    assert matrices.shape == (300, links, 4, 4)
    # The method page asks for 1e-11 here: positions grow to metres.
    np.testing.assert_allclose(axes, matrices, atol=1e-11)
    np.testing.assert_allclose(dual, matrices, atol=1e-11)
    twin = np.broadcast_to(np.eye(4), (300, 4, 4))
    for n in range(links):
        link = link_transform(joints[:, n], chain.offset_m[n], chain.length_m[n], chain.twist_rad[n])
        twin = twin @ link
        np.testing.assert_allclose(matrices[:, n], twin, atol=1e-11)
        turn = Rotation.from_euler("ZX", np.column_stack((joints[:, n], np.full(300, chain.twist_rad[n]))))
        np.testing.assert_allclose(link[:, :3, :3], turn.as_matrix(), atol=TIGHT)


def test_one_pose_is_the_batch(pair):
    chain = check_chain(L_U, L_F)
    joints = check_joints(pair[0][:40], pair[1][:40])
    for walk in (chain_transforms, chain_screw_axes, chain_dual_quaternions):
        batch = walk(chain, joints.reshape(4, 10, 6), ENDS)
        single = np.array([walk(chain, one, ENDS) for one in joints])
        np.testing.assert_array_equal(batch.reshape(single.shape), single)
        np.testing.assert_array_equal(walk(chain, joints)[:, [2, 5]], single)
    single = np.array(
        [five_joint_pose(a, b, L_U, L_F).T_shoulder_wrist for a, b in zip(*pair[:, :40], strict=True)]
    )
    np.testing.assert_array_equal(five_joint_pose(*pair[:, :40], L_U, L_F).T_shoulder_wrist, single)


@pytest.mark.parametrize("side", ["left", "right"])
def test_our_arm_is_the_same_by_transforms_chain_and_dual_quaternions(side):
    rng = np.random.default_rng(54)
    body = BodyDimensions(upper_arm_m=0.31, forearm_m=0.26, hand_m=0.19)
    names = [name for name in MODEL_ANGLES if f"_{side}_" in name]
    angles = rng.uniform(-np.pi, np.pi, (2000, 9))
    posture = dict(zip(names, angles.T, strict=True)) | {
        "trunk_lean_forward_rad": rng.uniform(-1, 1, 2000),
        "trunk_lean_lateral_rad": rng.uniform(-1, 1, 2000),
        "trunk_axial_rotation_rad": rng.uniform(-1, 1, 2000),
    }
    segments = segments_from_angles(posture, (side,))
    truth = joint_centres(segments, body)
    frames = segment_transforms(segments, body)
    base = frames[f"shoulder_{side}"].copy()
    base[:, :3, 3] = truth[f"shoulder_{side}"]
    chain = arm_chain(body, side)
    for poses in all_three(chain, chain.joints(angles), tuple(ARM_CHAIN_ENDS.values())):
        in_room = base[:, None] @ poses
        for f, point in enumerate(ARM_CHAIN_ENDS):
            np.testing.assert_allclose(in_room[:, f, :3, 3], truth[f"{point}_{side}"], atol=TIGHT)
        np.testing.assert_allclose(
            in_room[:, 2, :3, :3], rotation.to_matrix(segments[f"hand_{side}"]), atol=TIGHT
        )
    dual = arm_dual_quaternions(segments, body)
    for name, poses in dual.items():
        if name in segments or name.startswith("shoulder"):
            np.testing.assert_allclose(
                transform(poses[..., :4], dual_position(poses)), frames[name], atol=TIGHT, err_msg=name
            )


def test_dual_quaternions_without_some_sensors_follow_the_transforms():
    rng = np.random.default_rng(55)
    worn = {
        n: rotation.normalize(rng.normal(size=(7, 4)))
        for n in ("shoulder_left", "upper_arm_left", "forearm_left")
    }
    frames, dual = segment_transforms(worn, BodyDimensions()), arm_dual_quaternions(worn, BodyDimensions())
    assert set(dual) == set(frames) - {"head"}
    for name, poses in dual.items():
        np.testing.assert_allclose(dual_position(poses), frames[name][..., :3, 3], atol=TIGHT)


def test_dual_quaternions_are_a_group_of_unit_elements():
    rng = np.random.default_rng(56)
    q, t = rotation.normalize(rng.normal(size=(2, 200, 4))), rng.normal(size=(2, 200, 3))
    a, b = dual_quaternion(q[0], t[0]), dual_quaternion(q[1], t[1])
    product = dual_multiply(a, b)
    np.testing.assert_allclose(np.linalg.norm(product[:, :4], axis=-1), 1.0, atol=1e-14)
    np.testing.assert_allclose(np.sum(product[:, :4] * product[:, 4:], axis=-1), 0.0, atol=1e-14)
    np.testing.assert_allclose(
        transform(product[:, :4], dual_position(product)),
        transform(q[0], t[0]) @ transform(q[1], t[1]),
        atol=1e-13,
    )
    unit = np.zeros((200, 8))
    unit[:, 0] = 1.0
    np.testing.assert_allclose(dual_multiply(a, dual_inverse(a)), unit, atol=1e-14)
    point = rng.normal(size=(200, 3))
    np.testing.assert_allclose(
        dual_transform_point(a, point), transform_point(transform(q[0], t[0]), point), atol=1e-14
    )
    spoilt = a * 1.3 + 0.01 * np.concatenate((np.zeros((200, 4)), a[:, :4]), axis=-1)
    np.testing.assert_allclose(dual_normalize(spoilt), a, atol=1e-13)
    turned = screw((0, 0, 1), np.pi / 2, 0.5)
    np.testing.assert_allclose(dual_transform_point(turned, (1, 0, 0)), [0, 1, 0.5], atol=1e-15)


def test_the_singular_shoulder_is_reconstructed_and_held():
    """S1's y axis vertical: the first joint keeps its value, the third is solved, the pose stays right."""
    toward = np.radians(np.concatenate((np.linspace(40, 90, 51), np.full(20, 90.0))))
    spin = np.linspace(0.0, 1.0, 71)
    q1 = rotation.multiply(
        rotation.multiply(rotation.about_z(0.4), rotation.about_x(toward)), rotation.about_y(spin)
    )
    q2 = rotation.multiply(q1, rotation.about_z(0.7))
    truth = two_link_pose(q1, q2, L_U, L_F)
    np.testing.assert_allclose(five_joint_pose(q1, q2, L_U, L_F).T_shoulder_wrist, truth[1], atol=TIGHT)
    held = five_joint_pose(q1, q2, L_U, L_F, continuous=True)
    np.testing.assert_allclose(held.T_shoulder_wrist, truth[1], atol=1e-7)
    assert np.abs(np.diff(held.joint_rad, axis=0)).max() < 0.05
    np.testing.assert_allclose(held.singular_distance_rad, np.pi / 2 - toward, atol=1e-7)
    # Chunks carry on from the last tick.
    first, _ = continuous_two_link_joint_angles(q1[:30], q2[:30])
    rest, _ = continuous_two_link_joint_angles(q1[30:], q2[30:], first[-1])
    np.testing.assert_array_equal(np.concatenate((first, rest)), held.joint_rad)


def test_continuous_joints_are_the_single_ones_up_to_turns(pair):
    walk = np.cumsum(np.random.default_rng(57).normal(0, 0.05, (2, 800, 3)), axis=1)
    q1, q2 = rotation.exp(walk[0]), rotation.exp(walk[1])
    q1[100] = np.nan
    single, _ = two_link_joint_angles(q1, q2)
    found, _ = continuous_two_link_joint_angles(q1, q2)
    far = np.abs(np.sin(single[:, 1])) > 0.2
    np.testing.assert_allclose(np.sin(found - single)[far & np.isfinite(found[:, 0])], 0.0, atol=1e-9)
    for a, b in pairwise(range(0, 800, 100)):
        part = found[a:b][np.isfinite(found[a:b, 0]) & far[a:b]]
        assert np.abs(np.diff(part, axis=0)).max() < 4.0


class Counted:
    """A number that counts the multiplications and additions done with it."""

    done = [0, 0]  # noqa: RUF012

    def __init__(self, value):
        self.value = float(value)

    def _with(self, other, which, result):
        Counted.done[which] += 1
        return Counted(result(self.value, float(getattr(other, "value", other))))

    def __mul__(self, other):
        return self._with(other, 0, lambda a, b: a * b)

    def __add__(self, other):
        return self._with(other, 1, lambda a, b: a + b)

    def __sub__(self, other):
        return self._with(other, 1, lambda a, b: a - b)

    def __neg__(self):
        return Counted(-self.value)

    __rmul__ = __mul__
    __radd__ = __add__


def counted(values):
    return np.array([Counted(v) for v in np.ravel(values)], dtype=object).reshape(np.shape(values))


def count(work):
    Counted.done[:] = [0, 0]
    work()
    return tuple(Counted.done)


def test_operation_counts_are_those_of_the_functions_that_run():
    """Erratum E-25, counted: the functions of the compiled chains run on counting numbers."""
    rng = np.random.default_rng(58)
    numbers = counted(rng.normal(size=6))
    link = counted(np.zeros((3, 4)))
    build = count(lambda: kernels.link_matrix.py_func(*numbers, link))
    assert build == (6, 0)
    a, b = counted(rng.normal(size=(3, 4))), counted(rng.normal(size=(3, 4)))
    affine = count(lambda: kernels.affine_product.py_func(a, b, counted(np.zeros((3, 4)))))
    assert affine == (36, 27)
    a, b = counted(rng.normal(size=(4, 4))), counted(rng.normal(size=(4, 4)))
    full = count(lambda: a @ b)
    assert full == (64, 48)
    a, b = counted(rng.normal(size=8)), counted(rng.normal(size=8))
    dual = count(lambda: kernels.dual_product.py_func(a, b, counted(np.zeros(8))))
    assert dual == (48, 40)
    vectors = counted(rng.normal(size=(3, 3)))
    axes = count(lambda: kernels.axes_step.py_func(*numbers, *vectors))
    assert axes == (30, 18)

    def total(method):
        return tuple(operation_count(method, 1))

    assert total("homogeneous_affine") == tuple(np.add(build, affine))
    assert total("homogeneous_4x4") == tuple(np.add(build, full))
    # Two screws of two products each, then two products of dual quaternions.
    assert total("dual_quaternion") == (4 + 2 * dual[0], 2 * dual[1])
    assert total("screw_axes") == axes


def test_only_the_vector_form_is_cheaper_than_matrices():
    for links in (1, 5, 9):
        cost = {method: sum(operation_count(method, links)) for method in KINEMATIC_METHODS}
        assert min(cost, key=cost.get) == "screw_axes"
        assert cost["dual_quaternion"] > cost["homogeneous_4x4"] > cost["homogeneous_affine"]
        assert cost["screw_axes"] == links * 48
    with pytest.raises(SetupError, match="known are"):
        operation_count("abacus", 3)
    with pytest.raises(SetupError, match="at least one"):
        operation_count("screw_axes", 0)


def test_impossible_chains_and_joints_are_refused_in_words():
    with pytest.raises(SetupError, match="one offset, length and twist"):
        LinkChain((0.0,), (0.0, 1.0), (0.0,))
    with pytest.raises(SetupError, match="finite"):
        LinkChain((0.0,), (np.nan,), (0.0,))
    chain = check_chain(L_U, L_F)
    with pytest.raises(ShapeError, match="6 links"):
        chain_transforms(chain, np.zeros((4, 5)))
    with pytest.raises(ShapeError, match="growing"):
        chain_transforms(chain, np.zeros(6), ends=(6, 3))
