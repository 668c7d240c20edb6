"""Samples that were lost: filled in with noise that says so, off-line."""

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from estimators.conventions import GRAVITY_MPS2
from estimators.errors import ShapeError
from estimators.recording import Float, SensorSignals
from estimators.sentences import say
from estimators.signals import BRIDGE_S

Bool = NDArray[np.bool_]

_GAP_STEPS = 1.8
_SLOW_HZ, _FINE_HZ = 75.0, 200.0
"""A foot turns by ten degrees between the samples of a slow sensor: the filter takes it in steps of a fast one's."""
_SHORTEST_S = 0.5
_LONGEST_FILL_S = 3600.0
_GYROSCOPE, _ACCELEROMETER = slice(0, 3), slice(3, 6)


@dataclass(frozen=True)
class FilledSignals:
    """Signals without holes.

    Attributes
    ----------
    signals : SensorSignals
        The samples and, between them, those filled in.
    gap_s : ndarray, shape (N,)
        Length of the hole that a sample fills; zero where it was measured.
    is_missing : ndarray of bool, shape (N,)
        In holes too long to interpolate: the foot is taken to rest there, and nothing else is known.
    rate_hz : float
        Of the filled samples: that of the device, or a multiple of it where that is slow.
    lag : int
        Which multiple.
    """

    signals: SensorSignals
    gap_s: Float
    is_missing: Bool
    rate_hz: float
    lag: int


def fill_gaps(signals: SensorSignals, rate_hz: float) -> FilledSignals:
    """Fill the holes between samples; samples that are not finite are holes.

    Raises
    ------
    ShapeError
        When there is less than half a second of finite samples, or a hole of more than an hour.

    Notes
    -----
    Section 7 of the page on foot tracking: monotone cubic interpolation, and only of real holes. Jitter and single
    lost samples are left to the filter, which takes steps of any length: resampling did more harm.
    """
    finite = np.isfinite(signals.gyroscope_radps).all(axis=1) & np.isfinite(signals.accelerometer_mps2).all(
        axis=1
    )
    time_s, gyroscope = signals.time_s[finite], signals.gyroscope_radps[finite]
    accelerometer = signals.accelerometer_mps2[finite]
    field = None if signals.magnetometer_t is None else signals.magnetometer_t[finite]
    if len(time_s) < 3 or len(time_s) < _SHORTEST_S * rate_hz:
        raise ShapeError(say("walk.too_short", least_s=_SHORTEST_S))
    steps = np.diff(time_s)
    if steps.max() > _LONGEST_FILL_S:
        raise ShapeError(say("walk.hole", hole_s=steps.max()))
    is_hole = steps > _GAP_STEPS / rate_hz
    lag = round(_FINE_HZ / rate_hz) if rate_hz < _SLOW_HZ else 1
    fine_hz = lag * rate_hz
    counts = np.where(is_hole, np.maximum(np.rint(steps * fine_hz), 2), lag).astype(np.int64)
    if counts.max() == 1:
        retained = SensorSignals(time_s, gyroscope, accelerometer, field)
        return FilledSignals(
            retained, np.zeros(len(time_s)), np.zeros(len(time_s), dtype=np.bool_), fine_hz, lag
        )
    places = np.flatnonzero(counts > 1)
    new_s = np.concatenate([time_s[i] + steps[i] * np.arange(1, counts[i]) / counts[i] for i in places])
    length = np.repeat(np.where(is_hole, steps, 0.0), counts - 1)
    curve = scipy.interpolate.PchipInterpolator(
        time_s, np.concatenate([gyroscope, accelerometer], axis=1), axis=0
    )
    values = curve(new_s)
    is_long = length > BRIDGE_S
    values[is_long, _GYROSCOPE] = 0.0
    force = values[is_long, _ACCELEROMETER]
    values[is_long, _ACCELEROMETER] = force * (
        GRAVITY_MPS2 / np.maximum(np.linalg.norm(force, axis=1, keepdims=True), 1.0)
    )
    order = np.argsort(np.concatenate([time_s, new_s]), kind="stable")
    measured = np.zeros(len(time_s))

    def merged(old: Float, new: Float) -> Float:
        return np.asarray(np.concatenate([old, new])[order])

    filled = SensorSignals(
        merged(time_s, new_s),
        merged(gyroscope, values[:, _GYROSCOPE]),
        merged(accelerometer, values[:, _ACCELEROMETER]),
        None if field is None else merged(field, np.full((len(new_s), 3), np.nan)),
    )
    is_missing = merged(measured, is_long.astype(np.float64)) > 0.0
    return FilledSignals(filled, merged(measured, length), is_missing, fine_hz, lag)
