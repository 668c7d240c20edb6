"""Two sensors never agree in their noise: those that do are one sensor under two names."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from estimators.conventions import Placement
from estimators.errors import CalibrationError
from estimators.recording import Float, ImuChunk
from estimators.sentences import say

_SAME: Final = 0.99
"""Correlation from sample to sample. Independent noise stays far below; a vibration that limbs share is not the same in
turning and in force, and has each sensor's noise on it."""
_COPIED: Final = 1.0 - 1e-6
"""The same where sensors move: noise of a thousandth of the movement already makes less of two sensors."""
_REST_S: Final = 2.0
_RESTING_RADPS: Final = 0.05
"""Spread of turning below which a sensor rests; noise stays below a tenth of it."""
_LEAST_CHANGES: Final = 20
"""Changes that must be seen before they are compared: sensors with coarse counts may show none at rest."""


def check_distinct(
    gyroscope_radps: Float, accelerometer_mps2: Float, placements: Sequence[Placement]
) -> None:
    """Refuse sensors whose signals are identical, or nearly so, down to the noise.

    Parameters
    ----------
    gyroscope_radps, accelerometer_mps2 : ndarray, shape (S, K, 3)
        Sensor axes, at rest; NaN where samples are missing.
    placements : sequence of Placement, length S

    Raises
    ------
    CalibrationError
        Names the sensors that are the same one.

    Notes
    -----
    Compared are the changes from sample to sample, not the values: sensors that lie parallel agree in gravity, in how
    they are read and in whole counts, and breathing moves neighbours alike; the noise of two sensors is independent.
    """
    rows = _same_rows(gyroscope_radps, accelerometer_mps2, _SAME)
    if rows.size:
        raise CalibrationError(say("calibration.same_signals", where=[placements[int(row)] for row in rows]))


def same_signals(chunk: ImuChunk) -> list[int]:
    """Return which sensors of a recording send the signal of another one.

    Parameters
    ----------
    chunk : ImuChunk
        Of a recording, or of its beginning.

    Returns
    -------
    list of int
        Rows of the chunk; empty when all sensors are distinct, or when too little was measured to tell.

    Notes
    -----
    Where all sensors rest for two seconds, their noise is compared, as in `check_distinct`. In a recording without a
    rest, sensors on one limb may move alike to within a percent; there only copies to the last digits are reported.
    """
    length = max(2, round(_REST_S / chunk.time_step_s))
    gyroscope, accelerometer = chunk.gyroscope_radps, chunk.accelerometer_mps2
    starts = range(0, chunk.tick_count - length + 1, length)
    restless = [_restlessness(gyroscope[:, start : start + length]) for start in starts]
    if restless and min(restless) < _RESTING_RADPS:
        start = starts[int(np.argmin(restless))]
        quiet = slice(start, start + length)
        return [int(row) for row in _same_rows(gyroscope[:, quiet], accelerometer[:, quiet], _SAME)]
    return [int(row) for row in _same_rows(gyroscope, accelerometer, _COPIED)]


def _restlessness(gyroscope_radps: Float) -> float:
    """Return the spread of the most restless sensor, rad/s; infinite where a sample is missing."""
    spread = float(np.sqrt(gyroscope_radps.var(axis=1).sum(axis=1)).max(initial=0.0))
    return spread if np.isfinite(spread) else np.inf


def _same_rows(gyroscope_radps: Float, accelerometer_mps2: Float, share: float) -> NDArray[np.intp]:
    """Return the sensors of which another one changes alike, with a correlation of at least `share`."""
    turning, is_turning = _alike(np.diff(gyroscope_radps, axis=1), share)
    force, is_force = _alike(np.diff(accelerometer_mps2, axis=1), share)
    # Where nothing changes nothing is reported: the other quantity decides.
    same = (turning | ~is_turning) & (force | ~is_force) & (is_turning | is_force)
    return np.flatnonzero(same.any(axis=1))


def _alike(changes: Float, share: float) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return which pairs of sensors change alike, and of which pairs that can be determined; each shape (S, S)."""
    sensors = len(changes)
    finite = np.isfinite(changes).all(axis=(0, 2))
    flat = changes[:, finite]
    spread = np.sqrt(np.mean(flat**2, axis=1, keepdims=True)) if finite.any() else np.zeros((sensors, 1, 3))
    # Each axis weighs the same, so that one noisy axis does not speak for all.
    unit = np.divide(flat, spread, out=np.zeros_like(flat), where=spread > 0.0).reshape(sensors, -1)
    size = np.linalg.norm(unit, axis=1)
    product = unit @ unit.T
    alike = product >= share * np.outer(size, size)
    moved = np.count_nonzero(unit, axis=1) >= _LEAST_CHANGES
    stated = moved[:, None] | moved[None, :]
    others = ~np.eye(sensors, dtype=np.bool_)
    return alike & stated & others, stated & others
