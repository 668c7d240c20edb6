"""Measures of one stroke: smoothness by jerk, movement units a metre, when the speed peaks."""

from typing import Final

import numpy as np
import scipy

from estimators.comparison._smoothness import movement_units
from estimators.recording import Float

SHORTEST_S: Final = 0.3
CUT_OFF_HZ: Final = 6.0
LEAST_PATH: Final = 0.10
"""Share of the reach below which a path is too short for a number a metre."""
_BEGINS: Final = 0.05
_ARRIVES: Final = 0.98


def outward_stroke(path_m: Float, rate_hz: float) -> slice:
    """Return the samples of a repetition from leaving the start to arriving at the farthest place.

    Parameters
    ----------
    path_m : ndarray, shape (N, D)

    Returns
    -------
    slice
        From 5 % of the largest speed on the way out to 98 % of the largest distance; empty where nothing moves.
    """
    away = np.linalg.norm(path_m - path_m[0], axis=1)
    if len(away) < 3 or not away.max() > 0:
        return slice(0, 0)
    arrives = int(np.flatnonzero(away >= _ARRIVES * away.max())[0])
    speed = np.linalg.norm(np.gradient(path_m, 1.0 / rate_hz, axis=0), axis=1)[: arrives + 1]
    begins = int(np.flatnonzero(speed >= _BEGINS * speed.max())[0])
    return slice(begins, arrives + 1)


def log_dimensionless_jerk(velocity: Float, rate_hz: float, cut_off_hz: float | None = CUT_OFF_HZ) -> float:
    """Return the smoothness of one stroke: ``-ln(D^3 / v_p^2 integral |v''|^2 dt)``.

    Parameters
    ----------
    velocity : ndarray, shape (N,) or (N, D)
        Of one stroke, any unit; v_p is the largest speed, D the duration.
    cut_off_hz : float, optional
        Of a low pass of second order, forwards and backwards; None leaves the stroke as it is.

    Returns
    -------
    float
        Dimensionless; nearer to zero is smoother. A minimum-jerk stroke gives -5.322, two equal ones that abut -8.095.
        NaN for less than 0.3 s, gaps, or where nothing moves.

    Notes
    -----
    Balasubramanian, Melendez-Calderon, Roby-Brami and Burdet 2015, J NeuroEng Rehabil 12:112.
    """
    v = velocity[:, None] if velocity.ndim == 1 else velocity
    duration_s = (len(v) - 1) / rate_hz
    if duration_s < SHORTEST_S or not np.isfinite(v).all():
        return float("nan")
    if cut_off_hz is not None and cut_off_hz < 0.45 * rate_hz:
        sections = scipy.signal.butter(2, cut_off_hz, fs=rate_hz, output="sos")
        v = scipy.signal.sosfiltfilt(
            sections, v, axis=0, padlen=min(3 * round(rate_hz / cut_off_hz), len(v) - 1)
        )
    return float(log_dimensionless_jerks(v[None], rate_hz)[0])


def log_dimensionless_jerks(velocities: Float, rate_hz: float) -> Float:
    """Return `log_dimensionless_jerk` of several strokes of the same ticks, as they are.

    Parameters
    ----------
    velocities : ndarray, shape (S, N, D)

    Returns
    -------
    ndarray, shape (S,)
    """
    duration_s, step_s = (velocities.shape[1] - 1) / rate_hz, 1.0 / rate_hz
    if duration_s < SHORTEST_S or velocities.shape[1] < 3:
        return np.full(len(velocities), np.nan)
    peak = np.linalg.norm(velocities, axis=2).max(axis=1)
    bend = np.gradient(np.gradient(velocities, step_s, axis=1, edge_order=2), step_s, axis=1, edge_order=2)
    total = scipy.integrate.trapezoid(np.sum(bend**2, axis=2), dx=step_s, axis=1)
    # A gap makes both NaN, which is not above zero.
    moves = (peak > 0) & (total > 0) & np.isfinite(velocities).all(axis=(1, 2))
    peak, total = np.where(moves, peak, 1.0), np.where(moves, total, 1.0)
    return np.where(moves, -np.log(duration_s**3 / peak**2 * total), np.nan)


def units_per_metre(path_m: Float, rate_hz: float, reach_m: float) -> float:
    """Return the movement units of a path a metre of its length, 1/m.

    Parameters
    ----------
    path_m : ndarray, shape (N, D)
    reach_m : float
        Upper arm plus forearm.

    Returns
    -------
    float
        Peaks that rise more than 20 mm/s, at least 0.15 s apart, over the path; NaN for a path below a tenth of the
        reach.

    Notes
    -----
    Alt Murphy, Willen and Sunnerhagen 2011, Neurorehabil Neural Repair 25:71.
    """
    way_m = float(np.linalg.norm(np.diff(path_m, axis=0), axis=1).sum())
    if not way_m >= LEAST_PATH * reach_m:
        return float("nan")
    speed = np.linalg.norm(np.gradient(path_m, 1.0 / rate_hz, axis=0), axis=1)
    return movement_units(speed, rate_hz) / way_m


def time_to_peak_speed(speed: Float) -> float:
    """Return when a stroke is fastest, as a share of its duration: 0.5 of a minimum-jerk stroke.

    Parameters
    ----------
    speed : ndarray, shape (N,)
        Of the first stroke, from its beginning to its end.

    Returns
    -------
    float
        NaN where the speed has no peak inside, or gaps.

    Notes
    -----
    Flash and Hogan 1985, Journal of Neuroscience 5:1688.
    """
    if len(speed) < 3 or not np.isfinite(speed).all():
        return float("nan")
    peak = int(np.argmax(speed))
    if peak in (0, len(speed) - 1) or not speed[peak] > 0:
        return float("nan")
    # The top of the parabola through three samples, so that the rate does not show.
    before, here, after = speed[peak - 1 : peak + 2]
    bend = before - 2.0 * here + after
    shift = 0.5 * (before - after) / bend if bend < 0 else 0.0
    return float((peak + shift) / (len(speed) - 1))
