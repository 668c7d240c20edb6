"""True north from magnetic north, and the lag between two recordings of one movement."""

import numpy as np

from estimators import rotation
from estimators.errors import ShapeError
from estimators.recording import Float


def to_true_north(q_earth_sensor: Float, declination_rad: float) -> Float:
    """Turn orientations from magnetic to true north.

    Parameters
    ----------
    q_earth_sensor : ndarray, shape (..., 4)
        Earth with y to magnetic north.
    declination_rad : float
        How far magnetic north lies east of true north at the place, from a chart or the World Magnetic Model.

    Returns
    -------
    ndarray, shape (..., 4)
        Earth with y to true north (Marzouk 2009, 2.1.3: true heading is magnetic heading plus declination).
    """
    return rotation.multiply(rotation.about_z(-declination_rad), q_earth_sensor)


def estimate_lag(reference: Float, delayed: Float, time_step_s: float, longest_s: float = 0.5) -> float:
    """Find how much later a signal is than its reference, between samples.

    Parameters
    ----------
    reference, delayed : ndarray, shape (N,)
        The same quantity by two systems on one time base, best the angular speed, which needs no alignment.
    longest_s : float
        Lags are looked for up to this, both ways.

    Returns
    -------
    float
        Seconds; positive where `delayed` is later.

    Raises
    ------
    ShapeError
        Signals of different length, shorter than four times `longest_s`, or without movement.

    Notes
    -----
    Peak of the cross-correlation of the signals without their means, by the parabola through the largest value and
    its neighbours (method page A16 of Marzouk 2009).
    """
    reach = round(longest_s / time_step_s)
    if reference.shape != delayed.shape or reference.ndim != 1 or len(reference) < 4 * reach + 1:
        raise ShapeError(
            f"signals of {reference.shape} and {delayed.shape} samples; give both the same {4 * reach + 1} at least"
        )
    middle = slice(reach, len(reference) - reach)
    first = reference[middle] - reference[middle].mean()
    if not first.any():
        raise ShapeError("the reference does not move, so a lag cannot be determined")
    scores = []
    for shift in range(-reach, reach + 1):
        second = delayed[reach + shift : len(delayed) - reach + shift]
        second = second - second.mean()
        scores.append(float(first @ second) / max(float(np.linalg.norm(second)), 1e-300))
    peak = int(np.clip(np.argmax(scores), 1, 2 * reach - 1))
    left, top, right = scores[peak - 1 : peak + 2]
    bend = left - 2.0 * top + right
    return (peak - reach + (0.5 * (left - right) / bend if bend else 0.0)) * time_step_s
