"""Two sensors never agree in their noise: those that do are one sensor under two names."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from estimators.conventions import Placement
from estimators.errors import CalibrationError
from estimators.recording import Float
from estimators.sentences import say

_SAME: Final = 0.99
"""Correlation from sample to sample. Independent noise stays far below; a vibration that limbs share is not the same in
turning and in force, and has each sensor's noise on it."""
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
    turning, is_turning = _alike(np.diff(gyroscope_radps, axis=1))
    force, is_force = _alike(np.diff(accelerometer_mps2, axis=1))
    # Where nothing changes nothing is told: the other quantity decides.
    same = (turning | ~is_turning) & (force | ~is_force) & (is_turning | is_force)
    rows = np.flatnonzero(same.any(axis=1))
    if rows.size:
        raise CalibrationError(say("calibration.same_signals", where=[placements[int(row)] for row in rows]))


def _alike(changes: Float) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return which pairs of sensors change alike, and of which pairs that can be told; each shape (S, S)."""
    sensors = len(changes)
    finite = np.isfinite(changes).all(axis=(0, 2))
    flat = changes[:, finite]
    spread = np.sqrt(np.mean(flat**2, axis=1, keepdims=True)) if finite.any() else np.zeros((sensors, 1, 3))
    # Each axis weighs the same, so that one noisy axis does not speak for all.
    unit = np.divide(flat, spread, out=np.zeros_like(flat), where=spread > 0.0).reshape(sensors, -1)
    size = np.linalg.norm(unit, axis=1)
    product = unit @ unit.T
    alike = product >= _SAME * np.outer(size, size)
    moved = np.count_nonzero(unit, axis=1) >= _LEAST_CHANGES
    told = moved[:, None] | moved[None, :]
    others = ~np.eye(sensors, dtype=np.bool_)
    return alike & told & others, told & others


__all__ = ["check_distinct"]
