"""Pose from the nine field values of three dipoles, in closed form (Roetenberg 2006, appendix 5.A)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from estimators import rotation
from estimators.errors import SetupError, ShapeError
from estimators.magnetic._coil import Source
from estimators.magnetic._loop_kernel import MU0_TM_PER_A
from estimators.recording import Float


@dataclass(frozen=True)
class ClosedForm:
    """Poses of N bursts; leading axes as given.

    Attributes
    ----------
    position_m : ndarray, shape (..., 3)
        In the source frame; the mirror image through the origin fits as well (E11).
    q_source_sensor : ndarray, shape (..., 4)
    strength : ndarray, shape (...)
        k of the sources over mu0 M / (4 pi): the inverse cube of the distance, 1/m^3.
    ratios : ndarray, shape (..., 3)
        Singular values over (2k, k, k): ones for dipoles, else iron, noise or a coil too near.
    determinant : ndarray, shape (...)
        Of the field matrix over 2 k^3: one; negative means exchanged coils or axes or a wrong polarity.
    """

    position_m: Float
    q_source_sensor: Float
    strength: Float
    ratios: Float
    determinant: Float


def normalise_pulses(source: Source, pulses_t: ArrayLike, current_a: ArrayLike) -> Float:
    """Return the field matrix of unit dipoles along the source axes, R_sensor_source (3 u u^T - I)/r^3.

    Any three directions that span space and any moments are reduced to it.

    Parameters
    ----------
    source : Source
        With three coils.
    pulses_t : array_like, shape (..., 3, 3)
        Column j is the pulse of coil j in sensor axes.
    current_a : array_like, shape (..., 3) or scalar
    """
    pulses = np.asarray(pulses_t, dtype=np.float64)
    if pulses.shape[-2:] != (3, 3) or len(source.coils) != 3:
        raise ShapeError("the closed form needs three coils and pulses of shape (..., 3, 3), a column a coil")
    axes = np.stack([coil.unit_axis for coil in source.coils], axis=1)
    if abs(np.linalg.det(axes)) < 0.1:
        raise SetupError("the three coils do not span space; place their axes at larger angles")
    kappa = MU0_TM_PER_A / (4.0 * np.pi) * np.array([coil.moment_m2 for coil in source.coils])
    strengths = np.broadcast_to(kappa * np.asarray(current_a, dtype=np.float64), (*pulses.shape[:-2], 3))
    return np.asarray(pulses / strengths[..., None, :] @ np.linalg.inv(axes))


def closed_form(source: Source, pulses_t: ArrayLike, current_a: ArrayLike) -> ClosedForm:
    """Solve for the pose by least squares over all nine values (method page 2.6).

    Parameters as for `normalise_pulses`.
    """
    field = normalise_pulses(source, pulses_t, current_a)
    _, singular, turned = np.linalg.svd(field)
    direction = turned[..., 0, :]
    coupling = 3.0 * direction[..., :, None] * direction[..., None, :] - np.eye(3)
    together = field @ coupling
    w, _, zt = np.linalg.svd(together)
    proper = np.ones_like(singular)
    proper[..., 2] = np.linalg.det(w @ zt)
    psi = (w * proper[..., None, :]) @ zt
    strength = np.einsum("...ij,...ij->...", psi, together) / 6.0
    safe = np.where(strength > 0.0, strength, np.nan)
    return ClosedForm(
        direction * np.cbrt(1.0 / safe)[..., None],
        rotation.from_matrix(np.swapaxes(psi, -1, -2)),
        strength,
        singular / (safe[..., None] * np.array([2.0, 1.0, 1.0])),
        np.linalg.det(field) / (2.0 * safe**3),
    )


def closed_form_published(source: Source, pulses_t: ArrayLike, current_a: ArrayLike) -> ClosedForm:
    """Solve by the single elements of the source (eq. 5.13-5.34 with errata E1, E2, E10), for comparison.

    Element formulas triple the error of `closed_form` under noise.
    """
    field = normalise_pulses(source, pulses_t, current_a)
    strength = np.sqrt(np.einsum("...ij,...ij->...", field, field) / 6.0)
    unit = field / strength[..., None, None]
    squared = np.swapaxes(unit, -1, -2) @ unit
    x = (squared - np.eye(3)) / 3.0
    # eq. 5.27: the better conditioned of the two quotients; 5.28 with beta = -asin(Z/R)
    alpha = np.where(
        x[..., 0, 0] > x[..., 1, 1],
        np.arctan2(x[..., 0, 1], x[..., 0, 0]),
        np.arctan2(x[..., 1, 1], x[..., 0, 1]),
    )
    size = np.sqrt(np.clip(x[..., 2, 2], 0.0, 1.0))
    across = np.cos(alpha) * x[..., 0, 2] + np.sin(alpha) * x[..., 1, 2]
    sine = np.where(across >= 0.0, size, -size)
    cosine = np.sqrt(1.0 - sine**2)
    direction = np.stack([np.cos(alpha) * cosine, np.sin(alpha) * cosine, sine], axis=-1)
    psi = 0.5 * unit @ (squared - 3.0 * np.eye(3))
    yaw = np.arctan2(psi[..., 0, 1], psi[..., 0, 0])
    pitch = -np.arcsin(np.clip(psi[..., 0, 2], -1.0, 1.0))
    roll = np.arctan2(psi[..., 1, 2], psi[..., 2, 2])
    q = rotation.multiply(
        rotation.about_z(yaw), rotation.multiply(rotation.about_y(pitch), rotation.about_x(roll))
    )
    singular = np.linalg.svd(field, compute_uv=False)
    return ClosedForm(
        direction * np.cbrt(1.0 / strength)[..., None],
        q,
        strength,
        singular / (strength[..., None] * np.array([2.0, 1.0, 1.0])),
        np.linalg.det(field) / (2.0 * strength**3),
    )


def dipole_covariance(
    position_m: ArrayLike, q_source_sensor: ArrayLike, kappa_tm3: float, sigma_t: float
) -> Float:
    """Return the covariance of position (source axes) and orientation (sensor axes) of one burst, shape (6, 6).

    Of equal concentric dipoles in closed form (method page 2.7); `kappa_tm3` is mu0 M / (4 pi). Errors are
    those of the measurement model: estimate minus truth, `R_estimated = R Exp(error)`.
    """
    p = np.asarray(position_m, dtype=np.float64)
    r = float(np.linalg.norm(p))
    u = p / r
    ratio = sigma_t * r**3 / kappa_tm3
    along = np.outer(u, u)
    across = np.eye(3) - along
    cross = np.array([[0.0, -u[2], u[1]], [u[2], 0.0, -u[0]], [-u[1], u[0], 0.0]])
    covariance = np.zeros((6, 6))
    covariance[:3, :3] = (r * ratio) ** 2 * (along / 54.0 + 5.0 / 9.0 * across)
    covariance[3:, 3:] = ratio**2 * (0.5 * along + 2.0 * across)
    covariance[:3, 3:] = -r * ratio**2 * cross
    covariance[3:, :3] = covariance[:3, 3:].T
    # Orientation errors in source axes turn into sensor axes.
    turn = np.eye(6)
    turn[3:, 3:] = rotation.to_matrix(q_source_sensor).T
    return np.asarray(turn @ covariance @ turn.T)
