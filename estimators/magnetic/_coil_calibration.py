"""Finding out what a source really is: moments, places and directions of its coils from known poses."""

from dataclasses import dataclass, replace

import numpy as np
import scipy
from numpy.typing import ArrayLike

from estimators.errors import CalibrationError, ShapeError
from estimators.magnetic._coil import Source
from estimators.magnetic._measurement import predict
from estimators.recording import Float

PER_COIL = 6
"""Unknowns: relative moment, place (3), tilt of the axis (2)."""
GAIN, CENTRE, TILT = 0, slice(1, 4), slice(4, PER_COIL)
_LEAST_POSES = 4
TILT_M = 0.1
"""Lever that brings tilts to the scale of places."""
NEAR_M, FAR_M = 0.25, 0.6
"""Where sensors are worn from a source."""
LEAST_GAIN_SIGMA = 0.002
"""No source is known better: magnetometers have gain errors of that size themselves."""


@dataclass(frozen=True)
class CoilCalibration:
    """What was found.

    Attributes
    ----------
    source : Source
        With corrected turns (they carry the moment), centres and axes.
    moment_sigma : ndarray, shape (C,)
        Relative standard error of each moment.
    place_sigma_m : ndarray, shape (C,)
        Largest standard error of each centre along any axis.
    direction_sigma_rad : ndarray, shape (C,)
    residual_t : float
        Root mean square of what the pulses leave.
    gain_sigma : float
        How wrong the field of the found coils still is between `NEAR_M` and `FAR_M`, one sigma an axis, as a share of
        it: what filters are given as their parameter of that name.
    place_residual_m : float
        Root mean square of how far the sensor was from the places that were typed, as far as the pulses tell; 0 where
        poses were taken as exact.
    """

    source: Source
    moment_sigma: Float
    place_sigma_m: Float
    direction_sigma_rad: Float
    residual_t: float
    gain_sigma: float
    place_residual_m: float = 0.0


def calibrate_moments(source: Source, distance_m: float, strength_t: ArrayLike, current_a: float) -> Source:
    """Set the moments from one coaxial measurement each (Roetenberg eq. 5.18; method page 2.9).

    Parameters
    ----------
    distance_m : float
        From the centre of each coil, on its axis.
    strength_t : array_like, shape (C,)
        Field measured along the axis.
    """
    found = np.asarray(strength_t, dtype=np.float64)
    if found.shape != (len(source.coils),) or not (found > 0.0).all() or not distance_m > 0.0:
        raise ShapeError("one field above zero for each coil is needed, and a distance above zero")
    coils = []
    for number, coil in enumerate(source.coils):
        point = np.asarray(coil.centre_m) + distance_m * coil.unit_axis
        expected = float(source.field(number, current_a, point) @ coil.unit_axis)
        coils.append(replace(coil, turns=coil.turns * float(found[number]) / expected))
    return replace(source, coils=tuple(coils))


def calibrate_coils(
    source: Source,
    position_m: ArrayLike,
    q_source_sensor: ArrayLike,
    pulses_t: ArrayLike,
    current_a: ArrayLike,
    sigma_t: float,
) -> CoilCalibration:
    """Fit moment, place and direction of every coil to pulses at known poses.

    Parameters
    ----------
    source : Source
        As designed.
    position_m, q_source_sensor : array_like, shape (N, 3) and (N, 4)
        Poses from a reference; four or more, spread in direction, some near.
    pulses_t : array_like, shape (N, C, 3)
        Pulse values in sensor axes.
    current_a : array_like, shape (N, C) or scalar
    sigma_t : float
        Noise of a pulse value.

    Raises
    ------
    CalibrationError
        If the poses do not tell all unknowns, or the fit does not explain the pulses.
    """
    position = np.asarray(position_m, dtype=np.float64)
    q = np.asarray(q_source_sensor, dtype=np.float64)
    pulses = np.asarray(pulses_t, dtype=np.float64)
    count, coils = len(position), len(source.coils)
    if pulses.shape != (count, coils, 3) or q.shape != (count, 4):
        raise ShapeError(f"{count} poses of {coils} coils need pulses of shape ({count}, {coils}, 3)")
    if count < _LEAST_POSES:
        raise CalibrationError(f"{count} poses; place the sensor in {_LEAST_POSES} or more, spread around")
    currents = np.broadcast_to(np.asarray(current_a, dtype=np.float64), (count, coils))
    found, covariances = [], []
    total = 0.0
    for number in range(coils):

        def residuals(x: Float, number: int = number) -> Float:
            trial = changed(source, number, x)
            seen = predict(trial, number, currents[:, number], position, q).field_sensor_t
            return np.asarray((seen - pulses[:, number]).reshape(-1) / sigma_t)

        fit = scipy.optimize.least_squares(
            residuals, np.zeros(PER_COIL), x_scale=[0.02, 0.01, 0.01, 0.01, 0.01, 0.01]
        )
        jacobian = np.asarray(fit.jac, dtype=np.float64)
        information = jacobian.T @ jacobian
        scale = np.sqrt(np.diag(information))
        if (scale == 0.0).any() or np.linalg.cond(information / np.outer(scale, scale)) > 1e8:
            raise CalibrationError(
                f"the poses do not tell where coil {number + 1} is; take some nearer and in other directions"
            )
        freedom = 3 * count - PER_COIL
        if 2.0 * fit.cost > freedom + 6.0 * np.sqrt(2.0 * freedom):
            raise CalibrationError(
                f"no coil explains the pulses of coil {number + 1}: check the poses, look for iron, and repeat"
            )
        found.append(changed(source, number, fit.x).coils[number])
        covariances.append(np.asarray(np.linalg.inv(information), dtype=np.float64))
        total += 2.0 * fit.cost
    return stated(
        replace(source, coils=tuple(found)), covariances, sigma_t * float(np.sqrt(total / pulses.size))
    )


def stated(
    source: Source, covariances: list[Float], residual_t: float, place_residual_m: float = 0.0
) -> CoilCalibration:
    """Return what was found, from the coils and the covariance of each one's six unknowns."""
    sigmas = [np.sqrt(np.diag(covariance)) for covariance in covariances]
    return CoilCalibration(
        source,
        np.array([float(sigma[GAIN]) for sigma in sigmas]),
        np.array([float(sigma[CENTRE].max()) for sigma in sigmas]),
        np.array([float(np.hypot(*sigma[TILT]) / TILT_M) for sigma in sigmas]),
        residual_t,
        max(LEAST_GAIN_SIGMA, _field_error(source, covariances)),
        place_residual_m,
    )


def _field_error(source: Source, covariances: list[Float]) -> float:
    """Return the share by which the field is wrong where sensors are worn, root mean square over places, an axis."""
    number = 60
    turns = np.arange(number) * (np.pi * (3.0 - np.sqrt(5.0)))
    height = 1.0 - (2.0 * np.arange(number) + 1.0) / number
    across = np.sqrt(1.0 - height**2)
    directions = np.stack([across * np.cos(turns), across * np.sin(turns), height], axis=1)
    # Distances in an order of their own, so that near and far are in all directions.
    distance = NEAR_M + (FAR_M - NEAR_M) * ((np.arange(number) * 0.618) % 1.0)
    points = directions * distance[:, None]
    shares = []
    for coil, covariance in enumerate(covariances):
        jacobian = np.empty((number, 3, PER_COIL))
        for column in range(PER_COIL):
            step = np.zeros(PER_COIL)
            step[column] = 1e-5
            ahead = changed(source, coil, step).field(coil, 1.0, points)
            behind = changed(source, coil, -step).field(coil, 1.0, points)
            jacobian[:, :, column] = (ahead - behind) / 2e-5
        variance = np.einsum("nip,pq,niq->n", jacobian, covariance, jacobian) / 3.0
        shares.append(variance / np.sum(source.field(coil, 1.0, points) ** 2, axis=1))
    return float(np.sqrt(np.mean(shares)))


def changed(source: Source, number: int, x: Float) -> Source:
    """Return the source with one coil changed by its six unknowns."""
    coil = source.coils[number]
    axis = coil.unit_axis
    first = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    first /= np.linalg.norm(first)
    along_first, along_second = x[TILT]
    turned = axis + (along_first * first + along_second * np.cross(axis, first)) / TILT_M
    other = replace(
        coil,
        turns=coil.turns * (1.0 + float(x[GAIN])),
        centre_m=tuple((np.asarray(coil.centre_m) + x[CENTRE]).tolist()),
        axis=tuple(turned.tolist()),
    )
    return replace(source, coils=(*source.coils[:number], other, *source.coils[number + 1 :]))
