"""Evidence of an accelerometer's errors in a recording, gathered by stretches within a bounded memory."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from estimators.calibration.force.errors import ForceErrors, force_errors
from estimators.calibration.force.windows import STILL, Cut, Windows, cut, summed
from estimators.recording import Float

_MOST_WINDOWS: Final = 40
"""Four minutes in which the sensor turned: they say what a recording can say."""
_MOST_RESTS: Final = 10
"""Of those windows: a rest says the offset best where the body accelerates much, though nothing turned in it."""
_MOST_LIVE_WINDOWS: Final = 6
_LIVE_SEEN: Final = 10
"""Of a live session, which only warns, once: those of its first minute that turned most; they are let go then."""
_SAME_REST: Final = 0.997
"""Cosine between rests that are one and the same: it says one thing once."""


class ForceEvidence:
    """Windows of one sensor; feed it stretch by stretch.

    Parameters
    ----------
    keeps_readings : bool
        Whether `refined` will be asked for. Else it is weighed once, when a minute was seen, and no more is held then
        than what came of it: each window takes 8 kB.
    """

    def __init__(self, *, keeps_readings: bool) -> None:
        self._keeps_readings = keeps_readings
        self._most = _MOST_WINDOWS if keeps_readings else _MOST_LIVE_WINDOWS
        self._seen = 0
        self._windows = Windows.nothing()
        self._readings: list[Cut] = []
        self._found: ForceErrors | None = None
        self._is_new = False

    def add(
        self, rate: Float, force: Float, time_step_s: float, is_bridged: NDArray[np.bool_] | None = None
    ) -> None:
        """Take a stretch, each shape (N, 3), and which of its samples are interpolated, shape (N,); see `cut`."""
        if self._is_over:
            return
        pieces = cut(rate, force, time_step_s, is_bridged)
        if pieces is None:
            return
        self._seen += len(pieces.rate)
        if len(self._windows.turned) == self._most:
            turned = pieces.turned
            pieces = pieces[(turned < STILL) | (turned > self._worth().min())]
        count = len(pieces.rate)
        if count:
            self._take(pieces, count)
        if self._is_over:
            self._found, self._is_new = force_errors(self._windows), False
            self._windows = Windows.nothing()

    def _take(self, pieces: Cut, count: int) -> None:
        self._windows += summed(pieces)
        if self._keeps_readings:
            self._readings += [pieces[np.arange(count) == k] for k in range(count)]
        self._keep(_said_once(self._windows))
        worth = self._worth()
        if len(worth) > self._most:
            order = np.argsort(-worth, kind="stable")
            self._keep(np.argsort(order) < self._most)
        self._is_new = True

    def _worth(self) -> Float:
        """Return how much each window turned, and of the first rests of a recording, that they stay, shape (W,)."""
        turned = self._windows.turned
        is_rest = turned < STILL
        stays = self._keeps_readings & is_rest & (np.cumsum(is_rest) <= _MOST_RESTS)
        return np.where(stays, np.inf, turned)

    def _keep(self, which: NDArray[np.bool_]) -> None:
        self._windows = self._windows[which]
        self._readings = [one for one, is_kept in zip(self._readings, which, strict=False) if is_kept]

    @property
    def _is_over(self) -> bool:
        return not self._keeps_readings and self._seen >= _LIVE_SEEN

    @property
    def errors(self) -> ForceErrors | None:
        """What was found so far; None without a window, and live before it was weighed."""
        if self._is_new and self._keeps_readings:
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
