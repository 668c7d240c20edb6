"""The two-module arm of Marzouk (2009): kinematics A12, joint angles A13, velocities A19 (corrected).

Frames of the thesis, not ours: U is north-east-down at the shoulder, each module has x along its segment
distally, and in the reference pose the arm points along x of U. R1 and R2 rotate upper-arm and forearm
vectors into U. For parity with the published system; the product uses `ArmModel`.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from estimators import rotation
from estimators.arm._angle_kernel import SINGULAR_MARGIN_RAD
from estimators.arm.chains.chain_kernel import walk_two_links

Float = NDArray[np.float64]


class TwoLinkPose(NamedTuple):
    """Poses of the two links in U, `T_shoulder_elbow` and `T_shoulder_wrist`, each shape (..., 4, 4)."""

    T_shoulder_elbow: Float
    T_shoulder_wrist: Float


def two_link_pose(q1: ArrayLike, q2: ArrayLike, upper_arm_m: float, forearm_m: float) -> TwoLinkPose:
    """Return elbow and wrist pose from the module orientations in U, shape (..., 4); compiled.

    Notes
    -----
    Marzouk section 4.2, (4.4)-(4.8), with erratum E-18: the forearm vector must be turned by R_rel. Written
    out, T_U,w = T_U,1 T_1,2 has the orientation R2 and the origin R1 e_x L_u + R2 e_x L_F.
    """
    q1, q2 = np.broadcast_arrays(np.asarray(q1, dtype=np.float64), np.asarray(q2, dtype=np.float64))
    out = np.empty((q1.size // 4, 2, 4, 4))
    flat1, flat2 = (np.ascontiguousarray(q.reshape(-1, 4)) for q in (q1, q2))
    walk_two_links(flat1, flat2, float(upper_arm_m), float(forearm_m), out)
    both = out.reshape(*q1.shape[:-1], 2, 4, 4)
    return TwoLinkPose(both[..., 0, :, :], both[..., 1, :, :])


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
    Theta = (psi - pi/2, phi + pi/2, pi/2 - theta). At phi = +-90 degrees psi is arbitrary; theta is found
    from what psi leaves, so that the three together are right there too.
    """
    q1, q2 = np.asarray(q1, dtype=np.float64), np.asarray(q2, dtype=np.float64)
    m = rotation.to_matrix(q1)
    return _joints(m, np.arctan2(-m[..., 0, 1], m[..., 1, 1]), q1, q2)


def _joints(m: Float, psi: Float, q1: Float, q2: Float) -> tuple[Float, Float]:
    """Return joints and residual for a psi: R1 = Rz(psi) Rx(phi) Ry(theta)."""
    phi = np.arctan2(m[..., 2, 1], np.hypot(m[..., 0, 1], m[..., 1, 1]))
    c, s = np.cos(psi), np.sin(psi)
    theta = np.arctan2(c * m[..., 0, 2] + s * m[..., 1, 2], c * m[..., 0, 0] + s * m[..., 1, 0])
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


def continuous_two_link_joint_angles(
    q1: ArrayLike, q2: ArrayLike, previous_rad: ArrayLike | None = None
) -> tuple[Float, Float]:
    """Return the five angles of consecutive ticks, shape (K, 5), without jumps, and the residual, shape (K,).

    Near the singularity (S1 y axis vertical) the first angle keeps its value and the third is solved for it, as
    A13 asks; the rest is unwrapped. `previous_rad`, shape (5,), is the tick before: any chunking gives the same.
    """
    q1, q2 = np.asarray(q1, dtype=np.float64), np.asarray(q2, dtype=np.float64)
    angles, residual = two_link_joint_angles(q1, q2)
    m = rotation.to_matrix(q1)
    known = previous_rad is not None
    memory = np.asarray(previous_rad, dtype=np.float64) if known else np.full(5, np.nan)
    turn = 2.0 * np.pi
    for k in range(angles.shape[0]):
        if np.isnan(angles[k]).any():
            continue
        is_singular = np.hypot(m[k, 0, 1], m[k, 1, 1]) < np.sin(SINGULAR_MARGIN_RAD)
        if is_singular and np.isfinite(memory[0]):
            angles[k] = _joints(m[k], np.asarray(memory[0] + 0.5 * np.pi), q1[k], q2[k])[0]
        if np.isfinite(memory[0]):
            angles[k] += turn * np.floor((memory - angles[k]) / turn + 0.5)
        memory = angles[k]
    return angles, residual


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
