"""Coils from places on a bench: the sensor was laid at measured places, its orientation is whatever it was.

A ruler tells a place to a millimetre; nobody can type an orientation to half a degree. So every place brings six
unknowns of its own, three of them orientation, three how far the sensor was from the place that was typed, held by
`place_sigma_m`; the coils bring six each (method pages 2.9 and, for the field, 4.1).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from estimators import rotation
from estimators.errors import CalibrationError, ShapeError
from estimators.magnetic._coil import Source
from estimators.magnetic._coil_calibration import PER_COIL, CoilCalibration, changed, stated
from estimators.recording import Float

_LEAST_PLACES = 6
_FIELD_GAIN = 0.002
"""Gain error of a magnetometer that has been calibrated."""
_TURN_SCALE, _PLACE_SCALE = 0.02, 0.002
_MOST_STEPS = 60
_STEP = 1e-6


def calibrate_at_places(
    source: Source,
    position_m: ArrayLike,
    pulses_t: ArrayLike,
    current_a: ArrayLike,
    sigma_t: ArrayLike,
    place_sigma_m: float = 0.001,
) -> CoilCalibration:
    """Fit moment, place and direction of every coil to pulses at measured places.

    Parameters
    ----------
    source : Source
        As designed.
    position_m : array_like, shape (N, 3)
        Of the sensor in the source frame: from the middle of the module, along its axes. Six places or more, around
        the source and some near; a place on each side of every axis is a good choice.
    pulses_t : array_like, shape (N, C, 3)
        Pulse values in sensor axes.
    current_a : array_like, shape (N, C) or scalar
    sigma_t : array_like, shape (N,) or scalar
        Noise of the pulse values.
    place_sigma_m : float
        How well the places were measured, an axis.

    Raises
    ------
    CalibrationError
        If there are too few places or they do not tell all unknowns, or no coils explain the pulses.
    """
    position, pulses = _checked(source, position_m, pulses_t, place_sigma_m)
    coils, count = len(source.coils), len(position)
    current = np.broadcast_to(np.asarray(current_a, dtype=np.float64), (count, coils))
    noise = np.sqrt(
        np.broadcast_to(np.asarray(sigma_t, dtype=np.float64), (count,))[:, None] ** 2
        + _FIELD_GAIN**2 * np.sum(pulses**2, axis=2) / 3.0
    )
    q = np.stack([_orientation(source, *one) for one in zip(position, current, pulses, strict=True)])
    unknowns = _Unknowns(source, position, q, current, pulses, noise, place_sigma_m)
    scale = unknowns.scale
    fit = scipy.optimize.least_squares(
        unknowns.residuals, np.zeros(len(scale)), jac=unknowns.slopes, x_scale=scale, max_nfev=_MOST_STEPS
    )
    freedom = 3 * count * coils + 3 * count - len(scale)
    covariance = _credible_covariance(np.asarray(fit.jac, dtype=np.float64), scale, float(fit.cost), freedom)
    found = source
    blocks = []
    for number in range(coils):
        block = slice(PER_COIL * number, PER_COIL * (number + 1))
        found = changed(found, number, fit.x[block])
        blocks.append(covariance[block, block])
    if any(coil.turns * made.turns <= 0.0 for coil, made in zip(found.coils, source.coils, strict=True)):
        raise CalibrationError(
            "a coil is connected the other way round; exchange its wires or the sign of its turns"
        )
    left = fit.fun[: 3 * count * coils].reshape(count, coils, 3) * noise[:, :, None]
    off = fit.x[PER_COIL * coils + 3 * count :].reshape(count, 3)
    return stated(
        replace(found, model=source.model),
        blocks,
        float(np.sqrt(np.mean(left**2))),
        float(np.sqrt(np.mean(np.sum(off**2, axis=1)))),
    )


@dataclass(frozen=True)
class _Unknowns:
    """The coils, and turn and place of the sensor at every place, against the pulses that were measured there."""

    source: Source
    position_m: Float
    q_source_sensor: Float
    current_a: Float
    pulses_t: Float
    sigma_t: Float
    place_sigma_m: float

    @property
    def shape(self) -> tuple[int, int]:
        """Number of places and of coils."""
        return len(self.position_m), len(self.source.coils)

    @property
    def scale(self) -> Float:
        """Return how large each unknown may be expected to be: those of the coils, turns, places."""
        count, coils = self.shape
        return np.concatenate(
            [
                np.tile([0.02, 0.01, 0.01, 0.01, 0.01, 0.01], coils),
                np.full(3 * count, _TURN_SCALE),
                np.full(3 * count, _PLACE_SCALE),
            ]
        )

    def residuals(self, x: Float) -> Float:
        """Return what the unknowns leave of the pulses, then of the places, in sigmas."""
        count, coils = self.shape
        trial = self.source
        for number in range(coils):
            trial = changed(trial, number, x[PER_COIL * number : PER_COIL * (number + 1)])
        turn, off = x[PER_COIL * coils :].reshape(2, count, 3)
        numbers: NDArray[np.int64] = np.broadcast_to(np.arange(coils), (count, coils))
        there = np.broadcast_to((self.position_m + off)[:, None], (count, coils, 3))
        seen = rotation.rotate(
            rotation.conjugate(rotation.multiply(self.q_source_sensor, rotation.exp(turn)))[:, None],
            trial.field(numbers, self.current_a, there),
        )
        left = (seen - self.pulses_t) / self.sigma_t[:, :, None]
        return np.concatenate([left.reshape(-1), off.reshape(-1) / self.place_sigma_m])

    def slopes(self, x: Float) -> Float:
        """Differentiate in twelve steps: a residual knows one coil and one place only."""
        count, coils = self.shape
        table = np.zeros((3 * count * coils + 3 * count, len(x)))
        rows = np.arange(3 * count * coils).reshape(count, coils, 3)
        typed = 3 * count * coils + np.arange(3 * count).reshape(count, 3)
        for p in range(PER_COIL):
            columns = PER_COIL * np.arange(coils) + p
            slope = _difference(self.residuals, x, columns)
            table[rows, columns[:, None]] = slope[: rows.size].reshape(rows.shape)
        for p in range(6):
            columns = PER_COIL * coils + 3 * count * (p // 3) + 3 * np.arange(count) + p % 3
            slope = _difference(self.residuals, x, columns)
            table[rows, columns[:, None, None]] = slope[: rows.size].reshape(rows.shape)
            if p >= 3:
                table[typed[:, p - 3], columns] = slope[typed[:, p - 3]]
        return table


def _checked(
    source: Source, position_m: ArrayLike, pulses_t: ArrayLike, place_sigma_m: float
) -> tuple[Float, Float]:
    """Return places (N, 3) and pulses (N, C, 3) that can be fitted."""
    position = np.asarray(position_m, dtype=np.float64)
    pulses = np.asarray(pulses_t, dtype=np.float64)
    coils, count = len(source.coils), len(position)
    if position.shape != (count, 3) or pulses.shape != (count, coils, 3):
        raise ShapeError(f"{count} places of {coils} coils need pulses of shape ({count}, {coils}, 3)")
    if not (np.isfinite(position).all() and np.isfinite(pulses).all()):
        raise ShapeError("places and pulses must be finite")
    if count < _LEAST_PLACES:
        raise CalibrationError(
            f"{count} places; lay the sensor at {_LEAST_PLACES} or more, around the source"
        )
    if not place_sigma_m > 0.0:
        raise ShapeError("place_sigma_m must be above zero")
    return position, pulses


def _credible_covariance(slopes: Float, scale: Float, cost: float, freedom: int) -> Float:
    """Return the covariance of the unknowns of a fit that found all of them and explains the pulses."""
    jacobian = slopes * scale
    information = jacobian.T @ jacobian
    size = np.sqrt(np.diag(information))
    if (size == 0.0).any() or np.linalg.cond(information / np.outer(size, size)) > 1e9:
        raise CalibrationError(
            "the places do not tell where the coils are; take some nearer and on other sides of the source"
        )
    if 2.0 * cost > freedom + 6.0 * np.sqrt(2.0 * freedom):
        raise CalibrationError(
            "no coils explain the pulses at these places: check the places and their order, look for iron near the"
            f" bench, and repeat (residuals {np.sqrt(2.0 * cost / freedom):.1f} times what is expected)"
        )
    return np.asarray(np.linalg.inv(information) * np.outer(scale, scale))


def _difference(function: Callable[[Float], Float], x: Float, columns: NDArray[np.int64]) -> Float:
    """Return the slope where several unknowns change at once."""
    ahead, behind = x.copy(), x.copy()
    ahead[columns] += _STEP
    behind[columns] -= _STEP
    return np.asarray((function(ahead) - function(behind)) / (2.0 * _STEP))


def _orientation(source: Source, place: Float, current: Float, pulses: Float) -> Float:
    """Return the orientation that turns the pulses into the field of the source as designed (Wahba's problem)."""
    coils = np.arange(len(source.coils))
    field = source.field(coils, current, np.broadcast_to(place, (len(coils), 3)))
    # Weak pulses count as much as strong ones.
    weight = 1.0 / np.maximum(np.linalg.norm(field, axis=1), 1e-12) ** 2
    u, _, vt = np.linalg.svd((field * weight[:, None]).T @ pulses)
    flip = np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])
    return rotation.from_matrix(u @ flip @ vt)
