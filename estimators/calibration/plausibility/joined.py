"""Readings of one stretch after the other, joined for windows that begin in the one before, in little room."""

import numpy as np
from numpy.typing import NDArray

from estimators.calibration.plausibility.contradiction import HOP, WINDOW_S, slowed, slowed_by
from estimators.recording import Float


class Joined:
    """Gyroscope, accelerometer and magnetometer, slowed to what windows are judged by.

    A live session hands this to another process and back with each look, so its numbers are held in single precision:
    they are exact to a ten-millionth, and no device is to a thousandth.
    """

    def __init__(self) -> None:
        self._slow: NDArray[np.float32] | None = None
        """What windows that begin here may still need, shape (3, M, 3)."""
        self._over: NDArray[np.float32] | None = None
        """Samples at the end that make no whole mean yet."""

    def add(self, stretch: Float, time_step_s: float) -> tuple[Float, float]:
        """Take the next samples, shape (3, N, 3), NaN where one is missing.

        Returns
        -------
        joined : ndarray, shape (3, M, 3)
            Means of some samples each, with those of the stretch before that windows may begin in.
        step_s : float
            Between two of them.
        """
        if self._over is not None:
            stretch = np.concatenate((self._over, stretch), axis=1)
        width = slowed_by(time_step_s)
        used = stretch.shape[1] // width * width
        slow, step_s = np.stack([slowed(one, time_step_s)[0] for one in stretch]), width * time_step_s
        if self._slow is not None:
            slow = np.concatenate((self._slow, slow), axis=1)
        length = round((1.0 - HOP) * WINDOW_S / step_s)
        self._slow = slow[:, -length:].astype(np.float32)
        self._over = stretch[:, used:].astype(np.float32)
        return slow, step_s

    def forget(self) -> None:
        """Begin again: what comes next does not adjoin what came."""
        self._slow = self._over = None
