"""First-order uncertainty of joint angles from the uncertainty of two segment orientations.

With small orientation errors d_p, d_c (rotation vectors in the room, true = Exp(d) * estimate) of parent and
child, the relative rotation errs by e = R_parent^T (d_c - d_p) in parent axes. The angles of
R = R1(a1) R2(a2) R3(a3) follow from e = [u1, R1 u2, R1 R2 u3] da, hence da = J^-1 e and

    covariance = J^-1 R_parent^T diag(s_c^2 + s_p^2) R_parent J^-T.

J loses rank at the singularity, so the sigma grows like 1/sin(elevation); it is cut off where nothing is
known. Errors of the two sensors are taken as independent: a heading error that both share (the same
bent field) cancels in truth, so the figure is on the safe side. The sigma of an upright trunk that was only
assumed is not in it, nor how far a person's pose was from the one asked for.
"""

import numpy as np
from numpy.typing import NDArray

from estimators import rotation
from estimators.arm._angle_kernel import SIGMA_CEILING_RAD
from estimators.arm._joint_angles import elbow_angles, mirrored, shoulder_angles, wrist_angles
from estimators.arm._names import Joint
from estimators.conventions import Side

Float = NDArray[np.float64]

_X, _Y, _Z = np.eye(3)


def joint_angle_sigma(
    joint: Joint,
    side: Side,
    q_room_parent: Float,
    q_room_child: Float,
    sigma_parent_room_rad: Float,
    sigma_child_room_rad: Float,
    plane_of_elevation_rad: Float | None = None,
) -> Float:
    """Return one-sigma of the three angles of a joint.

    Parameters
    ----------
    q_room_parent, q_room_child : ndarray, shape (..., 4)
    sigma_parent_room_rad, sigma_child_room_rad : ndarray, shape (..., 3)
        About the room axes.
    plane_of_elevation_rad : ndarray, shape (...), optional
        The held plane of elevation of a shoulder near its singularity, in place of the instantaneous one.

    Returns
    -------
    ndarray, shape (..., 3)
        Radians, at most pi/sqrt(3); NaN where a sigma is NaN.
    """
    relative = rotation.multiply(rotation.conjugate(q_room_parent), q_room_child)
    if joint == "thorax_humerus":
        first, second, _ = np.moveaxis(shoulder_angles(relative, side), -1, 0)
        if plane_of_elevation_rad is not None:
            first = np.asarray(plane_of_elevation_rad)
        axes, signs = (_Z, _X, _Z), (1.0, -1.0, 1.0)
        turns = rotation.about_z(first), rotation.about_x(-second)
    else:
        is_elbow = joint == "humerus_forearm"
        angles = elbow_angles(relative, side) if is_elbow else wrist_angles(relative, side)
        first, second, _ = np.moveaxis(angles, -1, 0)
        axes, signs = (_Y, _X, _Z), (-1.0, -1.0 if is_elbow else 1.0, 1.0)
        turns = rotation.about_y(-first), rotation.about_x(signs[1] * second)
    jacobian = np.stack(
        (
            np.broadcast_to(axes[0], (*first.shape, 3)),
            rotation.rotate(turns[0], axes[1]),
            rotation.rotate(rotation.multiply(*turns), axes[2]),
        ),
        axis=-1,
    ) * np.asarray(signs)
    variance = np.square(sigma_parent_room_rad) + np.square(sigma_child_room_rad)
    to_parent = np.swapaxes(rotation.to_matrix(q_room_parent), -1, -2)
    if side == "left":
        # A mirrored rotation vector is (-x, y, -z), as in `mirrored`.
        to_parent = to_parent * mirrored(np.ones(4))[1:, None]
    spread = np.linalg.pinv(jacobian, rcond=1e-12) @ to_parent
    sigma = np.sqrt(np.einsum("...ij,...j->...i", np.square(spread), variance))
    return np.asarray(np.minimum(sigma, SIGMA_CEILING_RAD))
