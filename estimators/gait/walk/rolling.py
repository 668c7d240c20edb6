"""Feet that are moved without stepping: in a wheelchair, on a vehicle or on an escalator."""

from itertools import pairwise
from typing import Final

import numpy as np
import scipy
from numpy.typing import NDArray

from estimators import rotation
from estimators.gait._stance import runs
from estimators.gait._strides import Strides
from estimators.recording import Float, SensorSignals

_LEAST_S, _PIECE_S, _BESIDE_S = 1.5, 10.0, 0.4
_TURNS_RADPS: Final = 0.2
_SMOOTH_S, _SLOW_S = 0.12, 1.5
_PUSH_MPS2, _PUSH_S = 0.2, 0.25


def rolled_s(signals: SensorSignals, strides: Strides) -> float:
    """Return for how long a foot was pushed or braked while it neither stepped nor turned, s.

    Parameters
    ----------
    signals : SensorSignals
        Of the foot.
    strides : Strides
        Found in them.

    Notes
    -----
    Own. A foot that rests on something that rolls evenly is at rest for every inertial sensor, and nothing of it is
    walking. It shows when it is pushed or braked: then the specific force changes its direction against a foot that
    does not turn, for longer and more than 0.2 m/s^2. A foot on the floor does not.
    """
    time = signals.time_s
    step_s = float(np.median(np.diff(time)))
    both = np.concatenate([signals.gyroscope_radps, signals.accelerometer_mps2], axis=1)
    known = np.asarray(np.isfinite(both).all(axis=1))
    turning = scipy.ndimage.gaussian_filter1d(
        np.where(known[:, None], signals.gyroscope_radps, 0.0), _SMOOTH_S / step_s, axis=0
    )
    still = np.asarray(known & (np.linalg.norm(turning, axis=1) < _TURNS_RADPS))
    for off_s, contact_s in zip(strides.toe_off_s, strides.contact_s, strict=True):
        first, stop = np.searchsorted(time, (off_s - _BESIDE_S, contact_s + _BESIDE_S))
        still[first:stop] = False
    total = 0.0
    for first, stop in runs(still):
        pieces = max(1, round((time[stop - 1] - time[first]) / _PIECE_S))
        edges = np.linspace(first, stop, pieces + 1).astype(int)
        pushed = [_pushes(signals, a, b, step_s) for a, b in pairwise(edges.tolist())]
        at = np.flatnonzero(np.concatenate(pushed))
        if len(at):
            total += float(time[first + at[-1]] - time[first + at[0]])
    return total


def _pushes(signals: SensorSignals, first: int, stop: int, step_s: float) -> NDArray[np.bool_]:
    """Return in which samples of a stretch without turning the foot is pushed or braked."""
    found = np.zeros(stop - first, dtype=np.bool_)
    if len(found) * step_s < _LEAST_S:
        return found
    rate, force = signals.gyroscope_radps[first:stop], signals.accelerometer_mps2[first:stop]
    # What little the foot tilts is taken out; its bias is the mean of a foot that does not turn.
    turned = rotation.exp(step_s * np.cumsum(rate - rate.mean(axis=0), axis=0))
    level = rotation.rotate(turned, force)
    pushed = _smooth(level, _SMOOTH_S / step_s) - _smooth(level, _SLOW_S / step_s)
    for a, b in runs(np.asarray(np.linalg.norm(pushed, axis=1) > _PUSH_MPS2)):
        if (b - a) * step_s >= _PUSH_S:
            found[a:b] = True
    return found


def _smooth(values: Float, width: float) -> Float:
    return np.asarray(scipy.ndimage.gaussian_filter1d(values, width, axis=0))
