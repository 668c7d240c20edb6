"""Samples of a table by the clock they are on: one for all, or one for each sensor or quantity.

A stream is some rows of a table (all, or those that a column marks) with their time. Where the quantities of a sensor
are on streams of their own they are joined by time, onto the stamps of its gyroscope.
"""

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from app.errors import RecordingFormatError
from app.readers.tables.clocks.counter import COUNT, seconds_of_counter
from app.readers.tables.clocks.mended import mended, usual_interval
from app.readers.tables.clocks.of_day import CLOCK
from app.readers.tables.clocks.stamps import UNIT_FACTORS, check_unit
from estimators.recording import Float
from estimators.sentences import Sentence, say

_LONGEST_BRIDGE: Final = 2.5
"""In usual intervals of what is joined: farther apart are two samples with nothing between them."""
_ROUNDED: Final = 1e-3
"""Of that: so near to a sample is a time that is its own."""
_MOST_APART: Final = 0.5
"""Of a sensor's rows: where fewer hold both of two quantities, each has rows of its own."""


@dataclass(frozen=True)
class Clock:
    """How some rows say their time.

    Attributes
    ----------
    column : str or None
        None: the rows follow each other at the rate.
    unit : str
        Of `CsvMapping.time_unit`.
    """

    column: str | None
    unit: str
    rate_hz: float | None


@dataclass(frozen=True)
class Stream:
    """Some rows of a table and their time.

    Attributes
    ----------
    time_s : ndarray, shape (N,)
        By the clock's own zero.
    rows : ndarray of int, shape (N,)
        Of the table.
    notes : tuple of Sentence
        What of the time was mended.
    """

    time_s: Float
    rows: NDArray[np.intp]
    notes: tuple[Sentence, ...] = ()


def stream_of(
    table: dict[str, NDArray[Any]], rows: NDArray[np.intp], clock: Clock, columns: list[str]
) -> Stream:
    """Return those of some rows that have a place in time.

    Parameters
    ----------
    table : dict of str to ndarray, shape (T,)
    rows : ndarray of int, shape (R,)
    columns : list of str
        Of the signals: tell a row that was written twice from samples that share a stamp.

    Raises
    ------
    RecordingFormatError
        Fewer than two rows, time does not advance, or its unit cannot be right.
    """
    if rows.size < 2:
        raise RecordingFormatError(say("file.too_few_rows"))
    if clock.column is None:
        assert clock.rate_hz is not None
        return Stream(np.arange(rows.size) / clock.rate_hz, rows)
    stamps, unit, notes = table[clock.column][rows], clock.unit, list[Sentence]()
    # Rows that hold nothing of this stream have no place in it.
    there = np.any([np.isfinite(table[name][rows]) for name in columns], axis=0)
    if there.sum() >= 2:
        rows, stamps = rows[there], stamps[there]
    if unit == COUNT:
        assert clock.rate_hz is not None
        stamps, notes = seconds_of_counter(stamps, clock.rate_hz)
    if unit in (COUNT, CLOCK):
        unit = "s"
    found = mended(stamps, UNIT_FACTORS[unit], np.stack([table[name][rows] for name in columns], axis=1))
    if found.time_s.size < 2:
        raise RecordingFormatError(say("file.too_few_rows"))
    check_unit(usual_interval(found.time_s) / UNIT_FACTORS[unit], unit)
    return Stream(found.time_s + found.start_s, rows[found.rows], (*notes, *found.notes))


def share_rows(one: Float, other: Float) -> bool:
    """Return whether two quantities stand in the same rows.

    Parameters
    ----------
    one, other : ndarray, shape (N, 3)
        NaN where a row has none.
    """
    first, second = np.isfinite(one).all(axis=1), np.isfinite(other).all(axis=1)
    fewer = min(int(first.sum()), int(second.sum()))
    return fewer == 0 or int((first & second).sum()) >= _MOST_APART * fewer


def begun(streams: dict[str, Stream], least_s: float) -> dict[str, float]:
    """Return how far counters are to be moved that do not count from one moment, s, by stream; none where they do.

    Parameters
    ----------
    streams : dict of str to Stream
        Of several devices, each numbered by its counter.
    least_s : float
        Nearer than this to where its first row stands among those of another a counter is the same.
    """
    base = min(streams.values(), key=lambda one: int(one.rows[0]))
    moved: dict[str, float] = {}
    for name, one in streams.items():
        place = int(np.searchsorted(base.rows, one.rows[0], side="right")) - 1
        if place + 1 < base.rows.size and abs(by_s := float(base.time_s[place] - one.time_s[0])) > least_s:
            moved[name] = by_s
    return moved


def joined(time_s: Float, values: Float, at_s: Float) -> Float:
    """Return samples of one clock at the times of another, shape (M, 3).

    Parameters
    ----------
    time_s : ndarray, shape (N,)
        Rising.
    values : ndarray, shape (N, 3)
    at_s : ndarray, shape (M,)

    Returns
    -------
    ndarray, shape (M, 3)
        On the line through the two samples around; NaN across a hole and outside.
    """
    there = np.isfinite(values).all(axis=1)
    time_s, values = time_s[there], values[there]
    if time_s.size < 2:
        return np.full((at_s.size, 3), np.nan)
    found = np.stack([np.interp(at_s, time_s, values[:, axis]) for axis in range(3)], axis=1)
    after = np.clip(np.searchsorted(time_s, at_s), 1, time_s.size - 1)
    longest = _LONGEST_BRIDGE * usual_interval(time_s)
    outside = (at_s < time_s[0] - 0.5 * longest) | (at_s > time_s[-1] + 0.5 * longest)
    # A sample beside a hole is there, also where its time was rounded into it.
    nearest_s = np.minimum(np.abs(time_s[after] - at_s), np.abs(at_s - time_s[after - 1]))
    is_hole = (time_s[after] - time_s[after - 1] > longest) & (nearest_s > _ROUNDED * longest)
    found[outside | is_hole] = np.nan
    return found
