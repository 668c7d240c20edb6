"""Counters of samples as a clock: unwrapped, in steps of the rate, a hole in the counter a hole in time."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from app.sentences import Sentence, say
from estimators.recording import Float

COUNT: Final = "count"
"""Stands for a unit of time in a mapping whose time column counts samples at its rate."""
_WRAPS: Final = (2.0**8, 2.0**16, 2.0**32)
_NEAR, _NEAR_SHARE = 20.0, 0.02
"""In steps, and of its length: so near to its ends is a counter seen that lost a few samples there."""
_BACK: Final = 0.9
"""Of a wrap: so far ahead is a row that came late and not one that follows."""


def unwrapped(counter: Float) -> tuple[Float, float | None]:
    """Let a counter that starts again at zero go on.

    Parameters
    ----------
    counter : ndarray, shape (N,)
        Whole numbers.

    Returns
    -------
    counter : ndarray, shape (N,)
    wrap : float or None
        After how many counts it starts again; None where it does not.
    """
    steps = np.diff(counter)
    falls = np.flatnonzero(steps < 0)
    wrap = _wrap(counter, steps, falls) if falls.size else None
    if wrap is None:
        return counter, None
    ahead = np.mod(steps, wrap)
    ahead = np.where(ahead > _BACK * wrap, ahead - wrap, ahead)
    return np.asarray(counter[0] + np.concatenate([[0.0], np.cumsum(ahead)])), wrap


def _wrap(counter: Float, steps: Float, falls: NDArray[np.intp]) -> float | None:
    """Return after how many counts a counter begins again; None where it was started anew, or a row came late.

    Of two, eight or any number of bytes, or of any length that it was seen to have twice.
    """
    rising = steps[steps > 0]
    usual = float(np.median(rising)) if rising.size else 1.0
    low, high = float(counter.min()), float(counter.max())
    for wrap in _WRAPS:
        near = max(_NEAR * usual, _NEAR_SHARE * wrap)
        if high < wrap and high >= wrap - near and low <= near:
            return wrap
    before, after = counter[falls], counter[falls + 1]
    near = max(_NEAR * usual, _NEAR_SHARE * (high - low)) if high - low > 4.0 * _NEAR * usual else usual
    is_end = (high - before <= near) & (after - low <= near)
    return high - low + usual if int(is_end.sum()) >= 2 and is_end.mean() > 0.8 else None


def seconds_of_counter(column: Float, rate_hz: float) -> tuple[Float, list[Sentence]]:
    """Return the time of rows that a counter numbers.

    Parameters
    ----------
    column : ndarray, shape (N,)
        As written; NaN where a row has none.
    rate_hz : float
        Of the samples: how often the counter takes its usual step in a second.

    Returns
    -------
    time_s : ndarray, shape (N,)
        NaN where a row has no number.
    notes : list of Sentence
        How many samples the counter misses.
    """
    seconds = np.full(column.shape, np.nan)
    rows = np.flatnonzero(np.isfinite(column))
    if rows.size < 2:
        return seconds, []
    counted = unwrapped(column[rows])[0]
    steps = np.diff(counted)
    usual = float(np.median(steps[steps > 0])) if (steps > 0).any() else 1.0
    seconds[rows] = (counted - counted[0]) / (usual * rate_hz)
    holes = int((np.rint(steps[steps > 1.5 * usual] / usual) - 1).sum())
    return seconds, [say("time.counter_holes", count=holes)] if holes else []


__all__ = ["COUNT", "seconds_of_counter", "unwrapped"]
