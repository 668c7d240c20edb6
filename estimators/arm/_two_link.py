"""The two-module arm of Marzouk (2009): kinematics A12, joint angles A13, velocities A19 (corrected).

Frames of the thesis, not ours: U is north-east-down at the shoulder, each module has x along its segment
distally, and in the reference pose the arm points along x of U. R1 and R2 rotate upper-arm and forearm
vectors into U. Kept for parity with the published system; the product uses `ArmModel`.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from estimators import rotation
from estimators.arm._homogeneous import transform

Float = NDArray[np.float64]


class TwoLinkPose(NamedTuple):
    """Poses of the two links in U, `T_shoulder_elbow` and `T_shoulder_wrist`, each shape (..., 4, 4)."""

    T_shoulder_elbow: Float
    T_shoulder_wrist: Float


def two_link_pose(q1: ArrayLike, q2: ArrayLike, upper_arm_m: float, forearm_m: float) -> TwoLinkPose:
    """Return elbow and wrist pose from the module orientations in U, shape (..., 4).

    Notes
    -----
    Marzouk section 4.2, (4.4)-(4.8), with erratum E-18: the forearm vector must be turned by R_rel.
    """
    q1, q2 = np.asarray(q1, dtype=np.float64), np.asarray(q2, dtype=np.float64)
    q_relative = rotation.multiply(rotation.conjugate(q1), q2)
    elbow = transform(q1, rotation.rotate(q1, (upper_arm_m, 0.0, 0.0)))
    step = transform(q_relative, rotation.rotate(q_relative, (forearm_m, 0.0, 0.0)))
    return TwoLinkPose(elbow, elbow @ step)


def two_link_joint_angles(q1: ArrayLike, q2: ArrayLike) -> tuple[Float, Float]:
    """Return the five angles of the thesis and what its chain cannot represent.

    Returns
    -------
    angles_rad : ndarray, shape (..., 5)
        Theta 1 to 3 (shoulder), 4 (elbow flexion about S1 z) and 5 (pronation), each within one turn;
        (-90, 90, 90, 90, -90) degrees in the reference pose.
    residual_rad : ndarray, shape (...)
        Carrying angle plus mounting error, theta_r of (4.14).

    Notes
    -----
    A13 with errata E-19 and E-20: intrinsic Z-X-Y angles (psi, phi, theta) of R1 give
    Theta = (psi - pi/2, phi + pi/2, pi/2 - theta).
    """
    q1, q2 = np.asarray(q1, dtype=np.float64), np.asarray(q2, dtype=np.float64)
    m = rotation.to_matrix(q1)
    # R1 = Rz(psi) Rx(phi) Ry(theta)
    psi = np.arctan2(-m[..., 0, 1], m[..., 1, 1])
    phi = np.arctan2(m[..., 2, 1], np.hypot(m[..., 0, 1], m[..., 1, 1]))
    theta = np.arctan2(-m[..., 2, 0], m[..., 2, 2])
    r = rotation.to_matrix(rotation.multiply(rotation.conjugate(q1), q2))
    residual = np.arctan2(-r[..., 2, 0], np.hypot(r[..., 0, 0], r[..., 1, 0]))
    quarter = 0.5 * np.pi
    angles = (
        psi - quarter,
        phi + quarter,
        quarter - theta,
        np.arctan2(r[..., 1, 0], r[..., 0, 0]) + quarter,
        np.arctan2(r[..., 2, 1], r[..., 2, 2]) - quarter,
    )
    return np.stack(angles, axis=-1), np.asarray(residual)


def two_link_velocity(
    q1: ArrayLike,
    q2: ArrayLike,
    rate1_radps: ArrayLike,
    rate2_radps: ArrayLike,
    upper_arm_m: float,
    forearm_m: float,
) -> tuple[Float, Float]:
    """Return elbow and wrist velocity in U, shape (..., 3), from module rates in module axes (A19)."""
    along = np.array([1.0, 0.0, 0.0])
    rate1, rate2 = np.asarray(rate1_radps, dtype=np.float64), np.asarray(rate2_radps, dtype=np.float64)
    elbow = rotation.rotate(q1, np.cross(rate1, upper_arm_m * along))
    return elbow, np.asarray(elbow + rotation.rotate(q2, np.cross(rate2, forearm_m * along)))
