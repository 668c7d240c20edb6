"""What a recording says of an accelerometer, gathered stretch by stretch within a bounded memory."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from estimators.calibration.force.errors import ForceErrors, force_errors
from estimators.calibration.force.windows import STILL, Cut, Windows, cut, summed
from estimators.recording import Float

_MOST_WINDOWS: Final = 40
"""Four minutes in which the sensor turned: they say what a recording can say."""
_SAME_REST: Final = 0.997
"""Cosine between rests that are one and the same: it says one thing once."""


class ForceEvidence:
    """Windows of one sensor; feed it stretch by stretch.

    Parameters
    ----------
    keeps_readings : bool
        Whether `refined` will be asked for.
    """

    def __init__(self, *, keeps_readings: bool) -> None:
        self._keeps_readings = keeps_readings
        self._windows = Windows.nothing()
        self._readings: list[Cut] = []
        self._found: ForceErrors | None = None
        self._is_new = False

    def add(self, rate: Float, force: Float, time_step_s: float) -> None:
        """Take a stretch, each shape (N, 3)."""
        pieces = cut(rate, force, time_step_s)
        if pieces is None:
            return
        known = self._windows.turned
        if len(known) == _MOST_WINDOWS:
            pieces = pieces[pieces.turned > known.min()]
        count = len(pieces.rate)
        if not count:
            return
        self._windows += summed(pieces)
        if self._keeps_readings:
            self._readings += [pieces[np.arange(count) == k] for k in range(count)]
        self._keep(_said_once(self._windows))
        if len(self._windows.turned) > _MOST_WINDOWS:
            order = np.argsort(-self._windows.turned, kind="stable")
            self._keep(np.argsort(order) < _MOST_WINDOWS)
        self._is_new = True

    def _keep(self, which: NDArray[np.bool_]) -> None:
        self._windows = self._windows[which]
        self._readings = [one for one, is_kept in zip(self._readings, which, strict=False) if is_kept]

    @property
    def errors(self) -> ForceErrors | None:
        """What was found so far; None without a window."""
        if self._is_new:
            self._found, self._is_new = force_errors(self._windows), False
        return self._found

    @property
    def refined(self) -> ForceErrors | None:
        """The same from readings that are corrected by `errors`: they are too large for what is linear in them."""
        first = self.errors
        if first is None or not self._readings:
            return first
        again = Windows.nothing()
        for one in self._readings:
            true = (one.force - first.offset_mps2) / (1.0 + first.scale)
            again += summed(Cut(one.rate, true, one.step_s))
        return force_errors(again, first)


def _said_once(windows: Windows) -> NDArray[np.bool_]:
    """Return which windows turned, or rest as no earlier one does, shape (W,)."""
    up, still = windows.up[:, 1], windows.turned < STILL
    same = (up @ up.T > _SAME_REST) & still[:, None] & still
    return np.asarray(~np.tril(same, -1).any(axis=1))


__all__ = ["ForceEvidence"]
