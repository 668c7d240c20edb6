"""Counters of samples as a clock: unwrapped, in steps of the rate, a hole in the counter a hole in time."""

from typing import Final

import numpy as np

from app.sentences import Sentence, say
from estimators.recording import Float

COUNT: Final = "count"
"""Stands for a unit of time in a mapping whose time column counts samples at its rate."""
_WRAPS: Final = (2.0**8, 2.0**16, 2.0**32)
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
        At what it starts again, 2^8, 2^16 or 2^32; None where it does not.
    """
    steps = np.diff(counter)
    falls = np.flatnonzero(steps < 0)
    largest = float(counter.max()) if counter.size else 0.0
    wrap = next((one for one in _WRAPS if largest < one), None)
    if not falls.size or wrap is None or not (-steps[falls] > 0.5 * wrap).any():
        return counter, None
    ahead = np.mod(steps, wrap)
    ahead = np.where(ahead > _BACK * wrap, ahead - wrap, ahead)
    return np.asarray(counter[0] + np.concatenate([[0.0], np.cumsum(ahead)])), wrap


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
