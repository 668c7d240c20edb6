"""Clocks of a few bytes go on where they run over their end; counters of samples in steps of the rate.

A hole in a counter is a hole in time.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from estimators.recording import Float
from estimators.sentences import Sentence, say

COUNT: Final = "count"
"""Stands for a unit of time in a mapping whose time column counts samples at its rate."""
_OF_COUNTERS: Final = (2.0**8, 2.0**16, 2.0**24, 2.0**32)
_OF_STAMPS: Final = _OF_COUNTERS[1:]
"""Whole seconds go past 256 without anything that wraps."""
_NEAR, _NEAR_SHARE = 20.0, 0.02
"""In steps, and of its length: so near to its ends is a clock seen that lost a few samples there."""
_MOST_NEAR: Final = 0.25
"""Of its length, for clocks of few steps."""
_HOLE, _HOLE_SHARE = 250.0, 0.08
"""In steps, and of its length: samples that are lost where a clock runs over its end."""
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


def gone_on(stamps: Float) -> Float:
    """Let stamps of 16, 24 or 32 bits that ran over their end go on, by what they say.

    Parameters
    ----------
    stamps : ndarray, shape (N,)
        As they are written. A clock that was set back, or another one below, stays as it is.
    """
    steps = np.diff(stamps)
    usual = _usual(steps)
    wraps = (_between(stamps[at], stamps[at + 1], usual, _OF_STAMPS) for at in np.flatnonzero(steps < 0))
    wrap = next((one for one in wraps if one is not None), None)
    if wrap is None:
        return stamps
    # A row that came late there goes over the end twice.
    over = (steps < -_BACK * wrap).astype(np.float64) - (steps > _BACK * wrap)
    return np.asarray(stamps + wrap * np.concatenate([[0.0], np.cumsum(over)]))


def _wrap(counter: Float, steps: Float, falls: NDArray[np.intp]) -> float | None:
    """Return after how many counts a counter begins again; None where it was started again, or a row came late.

    Of one, two, three or four bytes, or of any length that it was seen to have twice.
    """
    usual = _usual(steps)
    low, high = float(counter.min()), float(counter.max())
    if (wrap := _between(high, low, usual, _OF_COUNTERS)) is not None:
        return wrap
    before, after = counter[falls], counter[falls + 1]
    near = max(_NEAR * usual, _NEAR_SHARE * (high - low)) if high - low > 4.0 * _NEAR * usual else usual
    is_end = (high - before <= near) & (after - low <= near)
    if int(is_end.sum()) >= 2 and is_end.mean() > 0.8:
        return high - low + usual
    # Of one byte with many samples lost at its ends: it falls by more than half.
    byte = _OF_COUNTERS[0]
    return byte if high < byte and bool((steps[falls] < -0.5 * byte).all()) else None


def _between(before: float, after: float, usual: float, sizes: tuple[float, ...]) -> float | None:
    """Return at which size a clock ran over its end between two readings; None where it did at none."""
    for size in sizes:
        near = min(max(_NEAR * usual, _NEAR_SHARE * size), _MOST_NEAR * size)
        if size - near <= before < size and after <= near:
            return size
        # Over its end in a hole; a clock that was started again begins at its zero.
        hole = size - before + after
        if before < size and 2.0 * usual < after and hole <= min(_HOLE * usual, _HOLE_SHARE * size):
            return size
    return None


def _usual(steps: Float) -> float:
    rising = steps[steps > 0]
    return float(np.median(rising)) if rising.size else 1.0


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
        By the counter's own zero; NaN where a row has no number.
    notes : list of Sentence
        How many samples the counter misses.
    """
    seconds = np.full(column.shape, np.nan)
    rows = np.flatnonzero(np.isfinite(column))
    if rows.size < 2:
        return seconds, []
    counted = unwrapped(column[rows])[0]
    steps = np.diff(counted)
    usual = _usual(steps)
    seconds[rows] = counted / (usual * rate_hz)
    holes = int((np.rint(steps[steps > 1.5 * usual] / usual) - 1).sum())
    return seconds, [say("time.counter_holes", count=holes)] if holes else []
