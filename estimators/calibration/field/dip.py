"""Does the field point down where gravity says it should? Also with iron on the sensor."""

from typing import Final

import numpy as np

from estimators import rotation
from estimators.calibration.plausibility.contradiction import (
    WINDOW_S,
    resting_rate,
    slowed,
    turning,
)
from estimators.gravity import calm_size
from estimators.recording import Float

_LEAST_TURNED: Final = 0.03
"""Share of a turn about the axis that was turned about least: less says nothing about iron along it."""
_LEAST_WINDOWS: Final = 3
_MANY_WINDOWS: Final = 8
"""So many that all point one way leave no doubt of it."""
_MOST_WINDOWS: Final = 100
"""With so many it is known; a session goes on for hours."""
_MOST: Final = 0.8
_SURE: Final = 2.0
"""The field must point up or down by so many times the distance of most windows from the middle one.

These are 2.6 standard deviations of a window. Windows beside one iron err together: a mean of many is no surer.
"""
_IRON_PRICE: Final = 0.02
"""Of a window: what is known of iron where nothing turned, over what a window tells that turned about all axes."""


class Dip:
    """How steeply the field points down, from movements of one sensor; feed it stretch by stretch.

    Notes
    -----
    In a window of four seconds the gyroscope turns the field m back by R; m = h + R'c with the field c of the room
    and one hard iron h for all windows: `sum(1 - A'A) h = sum(mean(m) - A' mean(R m))`, A being the mean of R. A magnet
    on the sensor bends h alone.
    """

    def __init__(self) -> None:
        self._normal, self._right = np.zeros((3, 3)), np.zeros(3)
        self._windows = np.zeros((0, 5, 3), np.float32)
        """Of each A, and the means of R m and of R f with the specific force f; a live session hands them on."""

    def add(self, rate: Float, force: Float, field: Float, time_step_s: float) -> None:
        """Take a stretch of a gyroscope in rad/s, specific force and field, each shape (N, 3)."""
        if len(self._windows) >= _MOST_WINDOWS:
            return
        rate, step_s = slowed(rate, time_step_s)
        force, field = slowed(force, time_step_s)[0], slowed(field, time_step_s)[0]
        size, length = calm_size(force, step_s), round(WINDOW_S / step_s)
        if not (size > 0.0 and np.isfinite(field).any()):
            return
        strength = float(np.nanmedian(np.linalg.norm(field, axis=1)))
        rate = rate - resting_rate(rate, force, size, step_s)
        known = np.asarray(np.isfinite(rate).all(axis=1))
        for start in turning(field, known, strength, length, step_s):
            span = slice(int(start), int(start) + length)
            if not np.isfinite(force[span]).all():
                continue
            attitude = rotation.to_matrix(rotation.running_product(rotation.exp(step_s * rate[None, span])))[
                0
            ]
            middle = attitude.mean(axis=0)
            turned = np.einsum("nij,nj->i", attitude, field[span]) / length
            self._normal += np.eye(3) - middle.T @ middle
            self._right += field[span].mean(axis=0) - middle.T @ turned
            up = np.einsum("nij,nj->i", attitude, force[span]) / length
            window = np.concatenate((middle, turned[None], up[None])).astype(np.float32)
            self._windows = np.concatenate((self._windows, window[None]))

    def iron(self) -> Float:
        """Return the hard iron that the turning shows, shape (3,), in the unit of the field; zero where none turned."""
        price = _IRON_PRICE * max(len(self._windows), 1)
        return np.asarray(np.linalg.solve(self._normal + price * np.eye(3), self._right))

    def sine(self) -> float:
        """Return the sine of the angle by which the field points down; NaN while movement does not say it.

        Notes
        -----
        Said only when the sensor turned about every axis, and not when `is_bent`.
        """
        sines = self._sines()
        return float("nan") if sines is None or _differ(sines) else float(np.median(sines))

    @property
    def is_bent(self) -> bool:
        """Whether movement finds the field here steep and there flat: iron in the room, which may turn it over."""
        sines = self._sines()
        return sines is not None and _differ(sines)

    def _sines(self) -> Float | None:
        """Return the sine of each window, less the iron on the sensor; None while that is not known."""
        if len(self._windows) < _LEAST_WINDOWS:
            return None
        if np.linalg.eigvalsh(self._normal)[0] < _LEAST_TURNED * len(self._windows):
            return None
        iron = np.linalg.solve(self._normal, self._right)
        middle, turned, up = (self._windows[:, rows].astype(np.float64) for rows in (slice(0, 3), 3, 4))
        field = turned - middle @ iron
        lengths = np.linalg.norm(up, axis=1) * np.linalg.norm(field, axis=1)
        return np.asarray(-(up * field).sum(axis=1) / lengths)


def _differ(sines: Float) -> bool:
    """Return whether another window might point the other way: they scatter, and are few or of both signs."""
    found = np.median(sines)
    if len(sines) >= _MANY_WINDOWS and (np.sign(sines) == np.sign(found)).all():
        # Two places with a field each, both pointing one way.
        return False
    return bool(abs(found) <= _SURE * np.quantile(np.abs(sines - found), _MOST))
