"""Centre of mass from ground reaction and pressure centre: the published fusion and its least-squares form."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy

from estimators.conventions import GRAVITY_MPS2
from estimators.errors import SetupError, ShapeError
from estimators.recording import Float

PUBLISHED_CUTOFF_HZ = (0.2, 0.2, 0.5)
"""Found best in x, y and z against motion capture (Schepers 2009, section 4.3)."""


@dataclass(frozen=True)
class MassCentre:
    """Centre of mass over N samples, room frame.

    Attributes
    ----------
    position_m, velocity_mps, acceleration_mps2 : ndarray, shape (N, 3)
    position_sigma_m : ndarray, shape (N, 3), or None
        One sigma where the method yields it.
    """

    position_m: Float
    velocity_mps: Float
    acceleration_mps2: Float
    position_sigma_m: Float | None = None


def acceleration(force_n: Float, mass_kg: float) -> Float:
    """Return the acceleration of the centre of mass, `F / m + g`, shape (N, 3) (equation 4.5)."""
    if not mass_kg > 0.0:
        raise SetupError(f"a mass of {mass_kg} kg; weigh the person with the shoes, see body_mass")
    return np.asarray(force_n / mass_kg - [0.0, 0.0, GRAVITY_MPS2])


def integrate_twice(
    acceleration_mps2: Float, rate_hz: float, *, ends_at_rest: bool = True
) -> tuple[Float, Float]:
    """Return velocity and displacement from rest at the start, each shape (N, 3) (equation 4.6).

    Parameters
    ----------
    acceleration_mps2 : ndarray, shape (N, 3)
    ends_at_rest : bool
        Whether the record ends standing: then the velocity left over is taken out linearly.
    """
    velocity = _integral(acceleration_mps2, rate_hz)
    if ends_at_rest:
        velocity = velocity - np.linspace(0.0, 1.0, velocity.shape[0])[:, None] * velocity[-1]
    return velocity, _integral(velocity, rate_hz)


def published_mass_centre(
    force_n: Float,
    cop_m: Float,
    rate_hz: float,
    mass_kg: float,
    mean_height_m: float,
    *,
    cutoff_hz: tuple[float, float, float] = PUBLISHED_CUTOFF_HZ,
    ends_at_rest: bool = True,
    zero_phase: bool = True,
) -> MassCentre:
    """Fuse low-passed pressure centre and high-passed double integral of the force.

    Parameters
    ----------
    force_n : ndarray, shape (N, 3)
        Of the ground on the person.
    cop_m : ndarray, shape (N, 3)
        Of both feet, or any other anchor, see `momentum_anchor`.
    rate_hz, mass_kg : float
        The mass that the shoes feel, `body_mass`.
    mean_height_m : float
        Of the sacrum or the centre of mass above the floor: the vertical has no other mean.
    cutoff_hz : tuple of 3 floats
        Of the filters of order 1, along x, y and z.
    zero_phase : bool
        There and back; a single pass leaves a ramp of every constant acceleration error and is only here to
        show it (E4).

    Raises
    ------
    ShapeError
        For values that are not finite or too few samples.
    SetupError
        For a cut-off or mass that cannot be used.

    Notes
    -----
    Schepers (2009) section 4.2.1: `c = LP(p) + HP(X)`; vertically `HP(X) + mean height`. The squared
    magnitudes of a Butterworth low- and high-pass add up to one, so there and back they sum to one exactly.
    """
    _check(force_n, cop_m, rate_hz)
    rate = acceleration(force_n, mass_kg)
    velocity, displacement = integrate_twice(rate, rate_hz, ends_at_rest=ends_at_rest)
    position, speed = np.empty_like(cop_m), np.empty_like(cop_m)
    for axis in range(3):
        high = _filtered(displacement[:, axis], rate_hz, cutoff_hz[axis], "high", zero_phase)
        fast = _filtered(velocity[:, axis], rate_hz, cutoff_hz[axis], "high", zero_phase)
        if axis == 2:
            position[:, 2], speed[:, 2] = high + mean_height_m, fast
        else:
            low = _filtered(cop_m[:, axis], rate_hz, cutoff_hz[axis], "low", zero_phase)
            position[:, axis], speed[:, axis] = low + high, np.gradient(low, 1.0 / rate_hz) + fast
    return MassCentre(position, speed, rate)


def least_squares_mass_centre(
    force_n: Float,
    cop_m: Float,
    rate_hz: float,
    mass_kg: float,
    mean_height_m: float,
    *,
    cutoff_hz: tuple[float, float, float] = PUBLISHED_CUTOFF_HZ,
) -> MassCentre:
    """Fuse the same two sources as the minimum of one sum of squares; the record must end at rest.

    Parameters as `published_mass_centre`.

    Notes
    -----
    The zero-phase fusion of order 1 minimises `integral of w^2 (c - p)^2 + (c' - v)^2`, whose condition is
    `c'' = w^2 (c - p) + a`: a tridiagonal system without any choice of padding. The end condition `c' = v`
    is why v must not drift.
    """
    _check(force_n, cop_m, rate_hz)
    rate = acceleration(force_n, mass_kg)
    velocity, _ = integrate_twice(rate, rate_hz)
    step_s, samples = 1.0 / rate_hz, cop_m.shape[0]
    anchor = cop_m.copy()
    anchor[:, 2] = mean_height_m
    position = np.empty_like(cop_m)
    between = 0.5 * (velocity[1:] + velocity[:-1])
    for axis in range(3):
        pull = (2.0 * np.pi * cutoff_hz[axis]) ** 2 * step_s
        bands = np.empty((2, samples))
        bands[0] = -1.0 / step_s
        bands[1] = 2.0 / step_s + pull
        bands[1, [0, -1]] = 1.0 / step_s + 0.5 * pull
        right = pull * anchor[:, axis]
        right[[0, -1]] *= 0.5
        right[:-1] -= between[:, axis]
        right[1:] += between[:, axis]
        position[:, axis] = scipy.linalg.solveh_banded(bands, right)
    return MassCentre(position, np.gradient(position, step_s, axis=0), rate)


def pressure_only(cop_m: Float, rate_hz: float, cutoff_hz: tuple[float, float] = (0.2, 0.4)) -> Float:
    """Return the low-passed pressure centre as the simplest estimate of x and y, shape (N, 2) (for comparison)."""
    columns = [_filtered(cop_m[:, axis], rate_hz, cutoff_hz[axis], "low", True) for axis in range(2)]
    return np.column_stack(columns)


def momentum_anchor(force_n: Float, cop_m: Float, height_m: Float, least_n: float = 100.0) -> Float:
    """Return where the line of the ground reaction passes the height of the centre of mass, shape (N, 3).

    Parameters
    ----------
    force_n, cop_m : ndarray, shape (N, 3)
    height_m : ndarray, shape (N,)
        Of the centre of mass above the pressure centre.
    least_n : float
        Below this vertical force the pressure centre itself is returned.

    Notes
    -----
    `p + z F_xy / F_z`: exact as long as the angular momentum about the centre of mass does not change. The
    pressure centre alone, as published, is off by 15 % of the excursion at 0.2 Hz.
    """
    vertical = np.where(force_n[:, 2] > least_n, force_n[:, 2], np.inf)
    lean = force_n[:, :2] * (height_m / vertical)[:, None]
    return np.column_stack((cop_m[:, :2] + lean, cop_m[:, 2]))


def vertical_mass_centre(
    force_n: Float, rate_hz: float, mass_kg: float, mean_height_m: float, cutoff_hz: float = 0.5
) -> Float:
    """Return the height of the centre of mass, shape (N,): high-passed double integral plus the mean."""
    _, displacement = integrate_twice(acceleration(force_n, mass_kg), rate_hz)
    return _filtered(displacement[:, 2], rate_hz, cutoff_hz, "high", True) + mean_height_m


def _filtered(
    values: Float, rate_hz: float, cutoff_hz: float, kind: Literal["low", "high"], zero_phase: bool
) -> Float:
    if not 0.0 < cutoff_hz < 0.25 * rate_hz:
        raise SetupError(f"cut-off {cutoff_hz} Hz; it must lie between 0 and a quarter of {rate_hz} Hz")
    numerator, denominator = scipy.signal.butter(1, cutoff_hz, kind, fs=rate_hz)
    if not zero_phase:
        state = scipy.signal.lfilter_zi(numerator, denominator) * values[0]
        return np.asarray(scipy.signal.lfilter(numerator, denominator, values, zi=state)[0])
    padding = min(values.size - 1, round(3.0 * rate_hz / cutoff_hz))
    return np.asarray(scipy.signal.filtfilt(numerator, denominator, values, padlen=padding))


def _integral(values: Float, rate_hz: float) -> Float:
    total = np.zeros_like(values)
    np.cumsum(0.5 * (values[1:] + values[:-1]) / rate_hz, axis=0, out=total[1:])
    return total


def _check(force_n: Float, cop_m: Float, rate_hz: float) -> None:
    if force_n.shape != cop_m.shape or force_n.ndim != 2 or force_n.shape[1] != 3:
        raise ShapeError(f"force {force_n.shape} and pressure centre {cop_m.shape} must both be (N, 3)")
    if force_n.shape[0] < rate_hz:
        raise ShapeError("less than a second of force; a centre of mass needs some steps")
    if not (np.isfinite(force_n).all() and np.isfinite(cop_m).all()):
        raise ShapeError("force and pressure centre must be finite; bridge gaps first (total_reaction does)")
