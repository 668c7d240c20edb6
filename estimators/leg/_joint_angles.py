"""ISB angles of hip, knee and ankle from segment orientations, and back.

Wu et al. (2002), J. Biomech. 35:543-548, for hip and ankle, and Grood and Suntay (1983), J. Biomech. Eng. 105:136-144,
for the knee: three turns, the first about the mediolateral axis of the upper segment, the last about the long axis of
the lower one, which is Z-X-Y about the ISB axes. These are in our segment axes (x forward, y left, z up) X = x, Y = z,
Z = -y, for both sides; left rotations are first mirrored in the sagittal plane, so that the same movement has the same
sign on both sides. With elementary rotations about *our* axes::

    pelvis to thigh  R = Ry(-flexion) Rx(-abduction) Rz(internal rotation)
    thigh to shank   R = Ry(flexion)  Rx(-abduction) Rz(internal rotation)
    shank to foot    R = Ry(-flexion) Rx(inversion)  Rz(internal rotation)

All angles are zero in the anatomical position. Flexion of the knee is reported positive (ISB: negative about Z);
flexion of the ankle is dorsiflexion, toes up. First and last angle lie within half a turn, where no joint ends, so they
are not unwrapped; the middle one within a quarter.
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from estimators import rotation
from estimators.arm._angle_kernel import SIGMA_CEILING_RAD
from estimators.conventions import Side
from estimators.leg._names import JOINTS, LegJoint

Float = NDArray[np.float64]

_MIRROR = np.array([1.0, -1.0, 1.0, -1.0])


def from_angles(joint: LegJoint, side: Side, angles_rad: ArrayLike) -> Float:
    """Return the orientation of a joint's lower segment in its upper one, shape (..., 4), of angles, shape (..., 3)."""
    first, second, turn = np.moveaxis(np.asarray(angles_rad, dtype=np.float64), -1, 0)
    forward, across = np.multiply((first, second), np.reshape(JOINTS[joint].signs, (2, *[1] * first.ndim)))
    bent = rotation.multiply(rotation.about_y(forward), rotation.about_x(across))
    q = rotation.multiply(bent, rotation.about_z(turn))
    return q * _MIRROR if side == "left" else q


def joint_angles(joint: LegJoint, side: Side, q_parent_child: ArrayLike) -> Float:
    """Return the three angles of a joint, shape (..., 3), from its lower segment's orientation in its upper one."""
    q = np.asarray(q_parent_child, dtype=np.float64)
    m = rotation.to_matrix(q * _MIRROR if side == "left" else q)
    forward = np.arctan2(m[..., 0, 2], m[..., 2, 2])
    across = np.arctan2(-m[..., 1, 2], np.hypot(m[..., 1, 0], m[..., 1, 1]))
    turn = np.arctan2(m[..., 1, 0], m[..., 1, 1])
    first, second = JOINTS[joint].signs
    return np.stack((first * forward, second * across, turn), axis=-1)


def joint_angle_sigma(
    joint: LegJoint,
    side: Side,
    q_room_parent: Float,
    q_room_child: Float,
    sigma_parent_room_rad: Float,
    sigma_child_room_rad: Float,
) -> Float:
    """Return one-sigma of the three angles of a joint, shape (..., 3), as of the arm's joints (`estimators.arm`).

    Parameters
    ----------
    q_room_parent, q_room_child : ndarray, shape (..., 4)
    sigma_parent_room_rad, sigma_child_room_rad : ndarray, shape (..., 3)
        About the room axes, independent of each other.

    Notes
    -----
    A small turn of the lower segment against the upper one, e in axes of the upper, changes the angles by da with
    e = [u1, R1 u2, R1 R2 u3] da, so that their covariance is that of e through the inverse of that matrix.
    """
    angles = joint_angles(joint, side, rotation.multiply(rotation.conjugate(q_room_parent), q_room_child))
    one, two = JOINTS[joint].signs
    first, second = rotation.about_y(one * angles[..., 0]), rotation.about_x(two * angles[..., 1])
    x, y, z = np.eye(3)
    columns = (
        np.broadcast_to(one * y, (*angles.shape[:-1], 3)),
        rotation.rotate(first, two * x),
        rotation.rotate(rotation.multiply(first, second), z),
    )
    to_parent = np.swapaxes(rotation.to_matrix(q_room_parent), -1, -2)
    if side == "left":
        # A mirrored rotation vector is (-x, y, -z).
        to_parent = to_parent * _MIRROR[1:, None]
    spread = np.linalg.pinv(np.stack(columns, axis=-1), rcond=1e-12) @ to_parent
    variance = np.square(sigma_parent_room_rad) + np.square(sigma_child_room_rad)
    sigma = np.sqrt(np.einsum("...ij,...j->...i", np.square(spread), variance))
    return np.asarray(np.minimum(sigma, SIGMA_CEILING_RAD))


def leg_from_angles(columns: Mapping[str, Float], side: Side, q_thigh: Float) -> dict[str, Float]:
    """Return the orientation of the segments of a leg that named joint angles describe.

    Parameters
    ----------
    columns : mapping of column name to ndarray, shape (K,)
        Joint angles in radians, of which those of other limbs are passed over; of a joint that has one, the others are
        zero.
    q_thigh : ndarray, shape (4,)
        Where the thigh is, in the room, while the hip's angles are not known.

    Returns
    -------
    dict of Placement to ndarray, shape (K, 4)
        `q_room_segment`, from the hip, or the knee where no hip is known, down to the last joint that is known without
        a gap; the pelvis is upright and faces ahead.
    """
    found: dict[str, Float] = {}
    upper = np.asarray(q_thigh, dtype=np.float64)
    for name, joint in JOINTS.items():
        parts = [columns.get(f"{name}_{side}_{part}") for part in joint.parts]
        known = next((part for part in parts if part is not None), None)
        if known is None:
            if found or name == "thigh_shank":
                break
            continue
        angles = np.stack([np.zeros_like(known) if part is None else part for part in parts], axis=-1)
        if name == "pelvis_thigh":
            upper = rotation.identity()
        elif not found:
            found[joint.parent.format(side=side)] = np.broadcast_to(upper, (len(known), 4))
        upper = rotation.multiply(upper, from_angles(name, side, angles))
        found[joint.child.format(side=side)] = upper
    return found
