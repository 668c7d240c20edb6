"""The stochastic measurement model of a source coil (Schepers and Veltink 2010), over any leading axes.

State: position of the sensor in the source frame and the rotation `q_source_sensor`. Errors are estimate minus
truth, position first, then a rotation vector in sensor axes: `R_estimated = R Exp(error)`. Innovations are predicted
minus measured (eq. 4), corrections are subtracted.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from estimators import rotation
from estimators.errors import SetupError, ShapeError
from estimators.magnetic._coil import Source
from estimators.recording import Float

MAGNETOMETER_SIGMA_T = 3e-8
"""0.3 mG a sample and axis: the thin-film magnetometer of the source."""


@dataclass(frozen=True)
class Prediction:
    """Predicted pulse.

    Attributes
    ----------
    field_sensor_t : ndarray, shape (..., 3)
        In sensor axes.
    jacobian : ndarray, shape (..., 3, 6)
        T/m and T/rad: derivative with respect to the errors of position and orientation.
    """

    field_sensor_t: Float
    jacobian: Float

    def covariance(self, state_covariance: ArrayLike, noise_covariance: ArrayLike) -> Float:
        """Return the full covariance of the predicted measurement, H P H^T + R, shape (..., 3, 3)."""
        p = np.asarray(state_covariance, dtype=np.float64)
        return np.asarray(self.jacobian @ p @ _turned(self.jacobian) + np.asarray(noise_covariance))


@dataclass(frozen=True)
class Updated:
    """State after a pulse.

    Attributes
    ----------
    position_m : ndarray, shape (..., 3)
    q_source_sensor : ndarray, shape (..., 4)
    covariance : ndarray, shape (..., 6, 6)
    nis : ndarray, shape (...)
        Normalised innovation squared before the update; chi-square with 3 degrees of freedom when all is well.
    """

    position_m: Float
    q_source_sensor: Float
    covariance: Float
    nis: Float


def predict(
    source: Source,
    coil: ArrayLike,
    current_a: ArrayLike,
    position_m: ArrayLike,
    q_source_sensor: ArrayLike,
) -> Prediction:
    """Predict the field of a pulse in sensor axes with its derivatives (eq. 5, 9, 11; method page 4.4).

    Parameters
    ----------
    coil : array_like of int, shape (...)
    current_a : array_like, shape (...)
    position_m : array_like, shape (..., 3)
    q_source_sensor : array_like, shape (..., 4)
    """
    field, gradient = source.field_and_gradient(coil, current_a, position_m)
    back = _turned(rotation.to_matrix(q_source_sensor))
    seen = (back @ field[..., None])[..., 0]
    lateral = np.broadcast_to(back @ gradient, (*seen.shape[:-1], 3, 3))
    return Prediction(seen, np.concatenate([lateral, skew(seen)], axis=-1))


def noise_covariance(
    field_sensor_t: ArrayLike,
    on_samples: int,
    off_samples: int,
    magnetometer_sigma_t: float = MAGNETOMETER_SIGMA_T,
    gain_sigma: float = 0.002,
) -> Float:
    """Return the covariance of a pulse value, shape (..., 3, 3): both means (erratum E8) and a floor of the gain.

    Parameters
    ----------
    field_sensor_t : array_like, shape (..., 3)
        Predicted pulse, for the part that grows with it; zeros leave that out.
    on_samples, off_samples : int
        Samples in the two means; no off samples: the baseline is known without error.
    """
    if on_samples < 1 or off_samples < 0 or magnetometer_sigma_t <= 0.0 or gain_sigma < 0.0:
        raise SetupError("a pulse needs one sample or more and a magnetometer noise above zero")
    white = magnetometer_sigma_t**2 * (1.0 / on_samples + (1.0 / off_samples if off_samples else 0.0))
    size = np.sum(np.asarray(field_sensor_t, dtype=np.float64) ** 2, axis=-1)[..., None, None]
    return np.asarray((white + gain_sigma**2 * size) * np.eye(3))


def posterior_covariance(covariance: ArrayLike, jacobian: ArrayLike, noise: ArrayLike) -> Float:
    """Return what a pulse not yet fired would leave of the uncertainty (M-09); Joseph form, shape (..., n, n)."""
    p, h = np.asarray(covariance, dtype=np.float64), np.asarray(jacobian, dtype=np.float64)
    return _joseph(p, h, np.asarray(noise, dtype=np.float64))[1]


def update(
    source: Source,
    coil: ArrayLike,
    current_a: ArrayLike,
    position_m: ArrayLike,
    q_source_sensor: ArrayLike,
    covariance: ArrayLike,
    measured_sensor_t: ArrayLike,
    noise: ArrayLike,
    passes: int = 5,
) -> Updated:
    """Correct a pose by one pulse: extended (one pass) or iterated Kalman update (method page 4.5).

    Parameters
    ----------
    source, coil, current_a, position_m, q_source_sensor
        As for `predict`; broadcast against each other.
    covariance : array_like, shape (..., 6, 6)
    measured_sensor_t : array_like, shape (..., 3)
    noise : array_like, shape (..., 3, 3)
        Covariance of the pulse value.
    passes : int
        1 is the published update; more relinearise at the corrected state.
    """
    if passes < 1:
        raise SetupError("passes must be 1 or more")
    measured = np.asarray(measured_sensor_t, dtype=np.float64)
    if measured.shape[-1:] != (3,):
        raise ShapeError(f"a pulse has three components, not shape {measured.shape}")
    p, r = np.asarray(covariance, dtype=np.float64), np.asarray(noise, dtype=np.float64)
    position0 = np.asarray(position_m, dtype=np.float64)
    q0 = np.asarray(q_source_sensor, dtype=np.float64)
    position, q = position0, q0
    correction = np.zeros(6)
    nis: Float = np.zeros(())
    for number in range(passes):
        seen = predict(source, coil, current_a, position, q)
        innovation = seen.field_sensor_t - measured
        if number == 0:
            spread = seen.covariance(p, r)
            nis = np.sum(innovation * np.linalg.solve(spread, innovation[..., None])[..., 0], axis=-1)
        gain, after = _joseph(p, seen.jacobian, r)
        relinearised = (
            innovation[..., None]
            + seen.jacobian @ np.broadcast_to(correction, (*innovation.shape[:-1], 6))[..., None]
        )
        correction = (gain @ relinearised)[..., 0]
        position = position0 - correction[..., :3]
        q = rotation.multiply(q0, rotation.exp(-correction[..., 3:]))
    return Updated(position, rotation.normalize(q), after, np.asarray(nis))


def choose_coil(
    source: Source,
    current_a: float,
    position_m: ArrayLike,
    q_source_sensor: ArrayLike,
    covariance: ArrayLike,
    on_samples: int = 8,
    off_samples: int = 8,
    limits: tuple[float, float] = (0.02, 0.0436),
    magnetometer_sigma_t: float = MAGNETOMETER_SIGMA_T,
) -> tuple[NDArray[np.int64], Float]:
    """Find the coil whose pulse would leave the least uncertainty (M-11, method page 4.5 step 4).

    Parameters
    ----------
    limits : (float, float)
        Position (m) and orientation (rad) sigmas that make the two parts of the score comparable (E11).

    Returns
    -------
    coil : ndarray of int, shape (...)
        The lowest number where scores tie.
    scores : ndarray, shape (..., C)
        Trace of the posterior position covariance over the limit squared, plus that of orientation.
    """
    if min(limits) <= 0.0:
        raise SetupError("limits must be above zero")
    scores = []
    for coil in range(len(source.coils)):
        seen = predict(source, coil, current_a, position_m, q_source_sensor)
        noise = noise_covariance(seen.field_sensor_t, on_samples, off_samples, magnetometer_sigma_t)
        after = posterior_covariance(covariance, seen.jacobian, noise)
        diagonal = np.diagonal(after, axis1=-2, axis2=-1)
        scores.append(
            diagonal[..., :3].sum(axis=-1) / limits[0] ** 2 + diagonal[..., 3:6].sum(axis=-1) / limits[1] ** 2
        )
    table = np.stack(scores, axis=-1)
    return np.argmin(table, axis=-1), table


def choose_current(
    source: Source,
    coil: int,
    position_m: ArrayLike,
    q_source_sensor: ArrayLike,
    covariance: ArrayLike,
    target_sigma_m: float,
    noise: ArrayLike,
    signal_to_noise: float = 0.0,
    least_a: float = 0.01,
) -> tuple[float, str]:
    """Find the least current that brings every position sigma to a target (M-12) with enough signal (M-13).

    Returns
    -------
    current_a : float
        Between `least_a` and the limit of the source.
    reason : str
        What fixed it: `target`, `signal`, `least` or `limit`.

    Notes
    -----
    Bisection: the posterior variances fall monotonically with the current (page 4.5 step 5).
    """
    if not (target_sigma_m > 0.0 and least_a > 0.0 and signal_to_noise >= 0.0):
        raise SetupError("the target sigma and the least current must be above zero")
    p, r = np.asarray(covariance, dtype=np.float64), np.asarray(noise, dtype=np.float64)
    unit = predict(source, coil, 1.0, position_m, q_source_sensor)
    sigma_t = float(np.sqrt(np.trace(r) / 3.0))

    def worst(current: float) -> float:
        after = posterior_covariance(p, unit.jacobian * current, r)
        return float(np.sqrt(np.diagonal(after)[:3].max()))

    limit = source.current_limit_a
    needed = signal_to_noise * sigma_t / float(np.linalg.norm(unit.field_sensor_t))
    if worst(limit) > target_sigma_m or needed > limit:
        return limit, "limit"
    low, high = least_a, limit
    if worst(low) <= target_sigma_m:
        return (low, "least") if needed <= low else (needed, "signal")
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if worst(middle) <= target_sigma_m else (middle, high)
    return (high, "target") if needed <= high else (needed, "signal")


def skew(vector: ArrayLike) -> Float:
    """Return cross-product matrices, shape (..., 3, 3)."""
    v = np.asarray(vector, dtype=np.float64)
    matrix = np.zeros((*v.shape[:-1], 3, 3))
    matrix[..., 0, 1], matrix[..., 0, 2], matrix[..., 1, 2] = -v[..., 2], v[..., 1], -v[..., 0]
    return np.asarray(matrix - _turned(matrix))


def _joseph(p: Float, h: Float, r: Float) -> tuple[Float, Float]:
    spread = h @ p @ _turned(h) + r
    gain = _turned(np.asarray(np.linalg.solve(spread, h @ p), dtype=np.float64))
    keep: Float = np.asarray(np.eye(p.shape[-1]) - gain @ h)
    after: Float = keep @ p @ _turned(keep) + gain @ r @ _turned(gain)
    return gain, np.asarray(0.5 * (after + _turned(after)))


def _turned(matrix: Float) -> Float:
    return np.swapaxes(matrix, -1, -2)
