"""Forward kinematics by Denavit-Hartenberg chains: the thesis's arm, its check chain, our own, any other.

Marzouk (2009) section 4.3, A14 of its method page, with errata E-19 and E-20::

    T_i = Rz(joint_i) Tz(offset_i) Tx(length_i) Rx(twist_i)      T_0,n = T_1 T_2 ... T_n      (4.20), (4.21)

The same chains run by dual quaternions and by screw axes in `chains.dual_quaternion`.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from estimators import rotation
from estimators.arm._model import model_lengths
from estimators.arm._two_link import continuous_two_link_joint_angles, two_link_joint_angles
from estimators.arm.chains.chain_kernel import walk_matrices
from estimators.body import BodyDimensions
from estimators.conventions import Side
from estimators.errors import SetupError, ShapeError

Float = NDArray[np.float64]

_QUARTER: Final = 0.5 * np.pi
WRIST_JOINT_RAD: Final = -_QUARTER
"""The sixth joint of the published chain, which does not move (T4.2)."""


@dataclass(frozen=True)
class LinkChain:
    """Links one after another, each with a revolute joint.

    Attributes
    ----------
    offset_m, length_m, twist_rad : tuple of float
        Of each link: along the joint axis, along the common normal, about the common normal.
    joint_names : tuple of str
        For people; empty when the joints have no names.
    joint_sign, joint_zero_rad : tuple of float
        How the joints follow named angles: `joint = sign * angle + zero`. Empty means that they are given
        as joints already.

    Raises
    ------
    SetupError
        If the tuples differ in length or hold what is not a number.
    """

    offset_m: tuple[float, ...]
    length_m: tuple[float, ...]
    twist_rad: tuple[float, ...]
    joint_names: tuple[str, ...] = ()
    joint_sign: tuple[float, ...] = ()
    joint_zero_rad: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        lengths = {len(self.offset_m), len(self.length_m), len(self.twist_rad)}
        named = {len(part) for part in (self.joint_names, self.joint_sign, self.joint_zero_rad) if part}
        if len(lengths) != 1 or 0 in lengths or named - lengths:
            raise SetupError("a chain needs at least one link and one offset, length and twist for each")
        if not np.isfinite([*self.offset_m, *self.length_m, *self.twist_rad]).all():
            raise SetupError("offsets, lengths and twists of a chain must be finite numbers")

    @property
    def link_count(self) -> int:
        """Number of links."""
        return len(self.twist_rad)

    def joints(self, angle_rad: ArrayLike) -> Float:
        """Return the joints, shape (..., n), of named angles, shape (..., n)."""
        angle = np.asarray(angle_rad, dtype=np.float64)
        if not self.joint_sign:
            return angle
        return np.asarray(angle * self.joint_sign + self.joint_zero_rad)


def link_transform(joint_rad: ArrayLike, offset_m: float, length_m: float, twist_rad: float) -> Float:
    """Return the pose of one link in the one before, shape (..., 4, 4); the product (4.20) written out."""
    joint = np.asarray(joint_rad, dtype=np.float64)
    ct, st, ca, sa = np.cos(joint), np.sin(joint), np.cos(twist_rad), np.sin(twist_rad)
    nought, one = np.zeros_like(joint), np.ones_like(joint)
    rows = (
        (ct, -st * ca, st * sa, length_m * ct),
        (st, ct * ca, -ct * sa, length_m * st),
        (nought, one * sa, one * ca, one * offset_m),
        (nought, nought, nought, one),
    )
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def chain_transforms(chain: LinkChain, joint_rad: ArrayLike, ends: Sequence[int] | None = None) -> Float:
    """Return the poses of link ends in the base of the chain, compiled.

    Parameters
    ----------
    joint_rad : array_like, shape (..., n)
    ends : sequence of int, optional
        Which links, counted from 1; all by default.

    Returns
    -------
    ndarray, shape (..., F, 4, 4)

    Raises
    ------
    ShapeError
        If the joints do not fit the chain.
    """
    joints, keep, shape = prepared(chain, joint_rad, ends)
    links = np.column_stack(
        (chain.offset_m, chain.length_m, np.cos(chain.twist_rad), np.sin(chain.twist_rad))
    )
    out = np.empty((joints.shape[0], int(keep.max()) + 1, 4, 4))
    walk_matrices(joints, np.ascontiguousarray(links), keep, out)
    return out.reshape(*shape, -1, 4, 4)


def prepared(
    chain: LinkChain, joint_rad: ArrayLike, ends: Sequence[int] | None
) -> tuple[Float, NDArray[np.int64], tuple[int, ...]]:
    """Check joints, flatten their leading axes and number the ends that are retained."""
    joints = np.asarray(joint_rad, dtype=np.float64)
    count = chain.link_count
    if joints.ndim == 0 or joints.shape[-1] != count:
        raise ShapeError(f"joints have shape {joints.shape}; this chain has {count} links")
    wanted = tuple(range(1, count + 1)) if ends is None else tuple(ends)
    if not wanted or list(wanted) != sorted(set(wanted)) or wanted[0] < 1 or wanted[-1] > count:
        raise ShapeError(f"ends {wanted} must be growing numbers of links from 1 to {count}")
    keep = np.full(count, -1, dtype=np.int64)
    keep[np.array(wanted) - 1] = np.arange(len(wanted))
    return np.ascontiguousarray(joints.reshape(-1, count)), keep, joints.shape[:-1]


def five_joint_chain(upper_arm_m: float, forearm_m: float) -> LinkChain:
    """Return the published chain of five joints with its corrected constants (T4.2, E-20).

    Frame 3 is the elbow, frame 6 the wrist; the sixth joint is fixed at `WRIST_JOINT_RAD`. Frames of the
    thesis: north-east-down at the shoulder, x along the arm in the reference pose.
    """
    return _arm_chain(upper_arm_m, forearm_m, (_QUARTER, -_QUARTER, _QUARTER))


def check_chain(upper_arm_m: float, forearm_m: float) -> LinkChain:
    """Return the chain of six joints that represents every pair of module orientations (A14)."""
    return _arm_chain(upper_arm_m, forearm_m, (-_QUARTER, _QUARTER, -_QUARTER))


def _arm_chain(upper_arm_m: float, forearm_m: float, elbow_twist: tuple[float, float, float]) -> LinkChain:
    return LinkChain(
        offset_m=(0.0,) * 6,
        length_m=(0.0, 0.0, upper_arm_m, 0.0, 0.0, forearm_m),
        twist_rad=(-_QUARTER, _QUARTER, -_QUARTER, *elbow_twist),
    )


def check_joints(q1: ArrayLike, q2: ArrayLike) -> Float:
    """Return the six joints of `check_chain` for module orientations in U, shape (..., 6).

    Notes
    -----
    Joints 1 to 3 are those of the thesis; 4 to 6 the intrinsic Z-Y-Z angles of R_rel Rx(90 degrees).
    """
    q1, q2 = np.asarray(q1, dtype=np.float64), np.asarray(q2, dtype=np.float64)
    shoulder = two_link_joint_angles(q1, q2)[0][..., :3]
    relative = rotation.multiply(rotation.conjugate(q1), q2)
    m = rotation.to_matrix(rotation.multiply(relative, rotation.about_x(_QUARTER)))
    first = np.arctan2(m[..., 1, 2], m[..., 0, 2])
    second = np.arctan2(np.hypot(m[..., 0, 2], m[..., 1, 2]), m[..., 2, 2])
    # The third from what is left after the first, so that it is right at the singularity too.
    c, s = np.cos(first), np.sin(first)
    third = np.arctan2(c * m[..., 1, 0] - s * m[..., 0, 0], c * m[..., 1, 1] - s * m[..., 0, 1])
    return np.concatenate((shoulder, np.stack((first, second, third), axis=-1)), axis=-1)


class FiveJointPose(NamedTuple):
    """The five-joint arm of the thesis and what it leaves out.

    Attributes
    ----------
    T_shoulder_elbow, T_shoulder_wrist : ndarray, shape (..., 4, 4)
        In U.
    joint_rad : ndarray, shape (..., 5)
    residual_rad : ndarray, shape (...)
        theta_r of (4.14): carrying angle plus mounting error, which five joints cannot represent.
    wrist_error_m : ndarray, shape (...)
        How far the wrist is off because of it, ``2 L_F sin(|theta_r| / 2)``.
    singular_distance_rad : ndarray, shape (...)
        Of the shoulder: the second joint from 0 or 180 degrees, whichever is nearer.
    """

    T_shoulder_elbow: Float
    T_shoulder_wrist: Float
    joint_rad: Float
    residual_rad: Float
    wrist_error_m: Float
    singular_distance_rad: Float


def five_joint_pose(
    q1: ArrayLike,
    q2: ArrayLike,
    upper_arm_m: float,
    forearm_m: float,
    previous_rad: ArrayLike | None = None,
    continuous: bool = False,
) -> FiveJointPose:
    """Return the five-joint model of Marzouk (2009) from module orientations in U.

    Parameters
    ----------
    q1, q2 : array_like, shape (..., 4)
        Upper-arm and forearm module, with the axes of the thesis (see `_two_link`).
    previous_rad : array_like, shape (5,), optional
        Joints at the tick before, for `continuous`.
    continuous : bool
        Consecutive ticks, shape (K, 4): joints are unwrapped and the first is held near the singularity.
    """
    q1, q2 = np.asarray(q1, dtype=np.float64), np.asarray(q2, dtype=np.float64)
    if continuous:
        angles, residual = continuous_two_link_joint_angles(q1, q2, previous_rad)
    else:
        angles, residual = two_link_joint_angles(q1, q2)
    fixed = np.full((*angles.shape[:-1], 1), WRIST_JOINT_RAD)
    chain = five_joint_chain(upper_arm_m, forearm_m)
    poses = chain_transforms(chain, np.concatenate((angles, fixed), axis=-1), ends=(3, 6))
    second = np.abs(np.remainder(angles[..., 1] + np.pi, 2.0 * np.pi) - np.pi)
    return FiveJointPose(
        poses[..., 0, :, :],
        poses[..., 1, :, :],
        angles,
        residual,
        2.0 * forearm_m * np.abs(np.sin(0.5 * residual)),
        np.minimum(second, np.pi - second),
    )


ARM_CHAIN_ENDS: Final = {"elbow": 3, "wrist": 6, "hand": 9}
"""Links of `arm_chain` after which these points lie."""


def arm_chain(body: BodyDimensions, side: Side) -> LinkChain:
    """Return our arm as a chain: ISB shoulder, elbow and wrist, from the thorax frame at the shoulder centre.

    Seven of its nine joints move by anatomy; carrying angle and rotation at the wrist are the other two. Its
    joints follow the angles of `MODEL_ANGLES` of that side, in their order: `chain.joints(angles)`.

    Notes
    -----
    With rotations about our axes the arm is Rz Rx Rz, (0, 0, -upper arm), Ry Rx Rz, (0, 0, -forearm), Ry Rx Rz,
    (0, 0, -hand). Each change of axis is a constant turn Rz(b) Rx(+-90 degrees) Rz(c) whose ends merge into the
    neighbouring joints: z to x is (90, 90, 0), x to z (0, -90, -90), z to y (0, -90, 0), y to x (90, 90, 90).
    A left arm is the mirror image: turns about x and z change sign.
    """
    *_, upper_arm, forearm, hand = (float(length) for length in model_lengths(body))
    q = _QUARTER
    mirror = -1.0 if side == "left" else 1.0
    about_x_or_z, about_y = mirror, 1.0
    return LinkChain(
        offset_m=(0.0, 0.0, -upper_arm, 0.0, 0.0, -forearm, 0.0, 0.0, -hand),
        length_m=(0.0,) * 9,
        twist_rad=(q, -q, -q, q, -q, -q, q, -q, 0.0),
        joint_names=(
            "plane_of_elevation", "elevation", "axial_rotation",
            "flexion", "carrying", "pronation",
            "wrist_flexion", "wrist_deviation", "wrist_rotation",
        ),
        joint_sign=(
            about_x_or_z, -about_x_or_z, about_x_or_z,
            -about_y, -about_x_or_z, about_x_or_z,
            -about_y, about_x_or_z, about_x_or_z,
        ),
        joint_zero_rad=(q, 0.0, -q, q, q, -q, q, q, -q),
    )  # fmt: skip
