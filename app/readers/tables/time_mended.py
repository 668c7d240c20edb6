"""Time columns of real devices: stamps that repeat, miss, step back or start again, mended where that is certain.

Every sample that was measured stays; a row that was written twice, or has no place in time, is left out. What was done
is reported with its count, and where more than a tenth of the rows is concerned nothing is mended: no time column.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from app.errors import RecordingFormatError
from app.sentences import Sentence, say
from estimators.recording import Float

APART_S: Final = 1e-6
"""Samples that arrived together carry one stamp; they are all real and follow each other this closely."""
BREAK_S: Final = 1.0
"""Between two stretches of a clock that started again: how long the pause was is not known, but too long to bridge."""
_MOST_SHARE: Final = 0.1
_OFTEN: Final = 0.02
"""A larger share of repeated stamps is a clock too coarse for the rate: the samples are spread evenly."""
_WRAPS: Final = (2.0**16, 2.0**24, 2.0**32)
_NEAR_WRAP: Final = 20.0
"""In steps: so far from its end may the last stamp of a counter be that starts again at zero."""
_LATE_S: Final = 1.0
"""Rows that lie behind for longer than this are a clock that was set back, not packets that came late."""


@dataclass(frozen=True)
class MendedTime:
    """A time column that rises.

    Attributes
    ----------
    time_s : ndarray, shape (M,)
        Of the rows that stay, from the first of them.
    rows : ndarray of int, shape (M,)
        Which rows stay, rising.
    notes : tuple of Sentence
        What was mended.
    """

    time_s: Float
    rows: NDArray[np.intp]
    notes: tuple[Sentence, ...]


def mended(column: Float, factor: float, values: Float | None = None) -> MendedTime:
    """Return a time column with every stamp later than the one before.

    Parameters
    ----------
    column : ndarray, shape (N,)
        As written, in units of `factor` seconds; NaN where a row has no time.
    factor : float
    values : ndarray, shape (N, C), optional
        What else the rows hold: tells rows that were written twice from samples that share a stamp.

    Raises
    ------
    RecordingFormatError
        Most rows would have to be mended.
    """
    notes: list[Sentence] = []
    rows = np.flatnonzero(np.isfinite(column))
    if rows.size < column.size:
        notes.append(say("time.missing", count=column.size - rows.size))
    time = column[rows] * factor
    backwards = int((np.diff(time) < 0).sum())
    if backwards > _MOST_SHARE * column.size or np.unique(time[:1000]).size < 2:
        raise RecordingFormatError(say("time.does_not_advance"), count=backwards)
    time, breaks = _gone_on(time, _usual_step(time), factor)
    if breaks:
        notes.append(say("time.set_back", count=breaks, pause_s=BREAK_S))
    stays = _in_order(time)
    if not stays.all():
        notes.append(say("time.out_of_order", count=int((~stays).sum())))
        rows, time = rows[stays], time[stays]
    if values is not None:
        twice = np.zeros(rows.size, dtype=np.bool_)
        same = (values[rows[1:]] == values[rows[:-1]]) | (
            np.isnan(values[rows[1:]]) & np.isnan(values[rows[:-1]])
        )
        twice[1:] = (np.diff(time) == 0) & same.all(axis=1)
        if twice.any():
            notes.append(say("time.row_twice", count=int(twice.sum())))
            rows, time = rows[~twice], time[~twice]
    if column.size - rows.size > _MOST_SHARE * column.size:
        raise RecordingFormatError(
            say("time.hopeless", count=column.size - rows.size, rows=column.size),
            count=column.size - rows.size,
        )
    repeated = int((np.diff(time) == 0).sum())
    if repeated:
        notes.append(say("time.repeated", count=repeated))
        time = spread(time) if repeated > _OFTEN * time.size else apart(time)
    return MendedTime(time - time[0] if time.size else time, rows, tuple(notes))


def apart(time_s: Float) -> Float:
    """Set samples with one and the same stamp a microsecond apart.

    Parameters
    ----------
    time_s : ndarray, shape (N,)
        Never falling.
    """
    return np.asarray(time_s + APART_S * _places(time_s)[0])


def spread(time_s: Float) -> Float:
    """Spread samples with one and the same stamp evenly up to the next stamp.

    Parameters
    ----------
    time_s : ndarray, shape (N,)
        Never falling; for stamps that are coarser than the samples.
    """
    place, run = _places(time_s)
    ends = np.append(np.flatnonzero(np.diff(time_s) > 0) + 1, time_s.size)
    following = ends[np.searchsorted(ends, np.arange(time_s.size), side="right")]
    whole = following < time_s.size
    to_next = np.zeros(time_s.size)
    to_next[whole] = time_s[following[whole]] - time_s[whole]
    # A pause after the last of them is no time in which they were measured.
    usual = float(np.median(to_next[whole] / run[whole])) if whole.any() else APART_S
    each = np.minimum(np.where(whole, to_next / run, usual), 2.0 * usual)
    return np.asarray(time_s + place * each)


def _places(time_s: Float) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return for each sample which of those with its stamp it is, and how many there are."""
    starts = np.concatenate([[0], np.flatnonzero(np.diff(time_s) != 0) + 1])
    length = np.diff(np.append(starts, time_s.size))
    return np.arange(time_s.size) - np.repeat(starts, length), np.repeat(length, length)


def _usual_step(time: Float) -> float:
    steps = np.diff(time)
    steps = steps[steps > 0]
    return float(np.median(steps)) if steps.size else 0.0


def _gone_on(time: Float, step: float, factor: float) -> tuple[Float, int]:
    """Let a clock that starts again go on; return how often it did after a pause of unknown length.

    A counter that ran over its end goes on without one.
    """
    shift, breaks = np.zeros(time.size), 0
    for at in (np.flatnonzero(np.diff(time) < 0) + 1).tolist():
        before = float(time[at - 1])
        ahead = time[at : at + max(2, int(_LATE_S / step) if step else 2)]
        if (ahead >= before).any() or ahead.size < 2:
            # A few rows that came late, or one stamp far ahead: `_in_order` leaves them out.
            continue
        if at >= 2 and time[at - 2] < time[at] < before:
            continue
        near = _NEAR_WRAP * step
        wraps = any(abs(size * factor - before) < near and time[at] < near for size in _WRAPS)
        shift[at] = before - time[at] + (step if wraps else BREAK_S)
        breaks += not wraps
    return np.asarray(time + np.cumsum(shift)), breaks


def _in_order(time: Float) -> NDArray[np.bool_]:
    """Return which stamps stay: those that do not lie behind one that stays."""
    stays = np.ones(time.size, dtype=np.bool_)
    backwards = np.flatnonzero(np.diff(time) < 0) + 1
    for at in backwards.tolist():
        # One stamp far ahead of both sides is wrong itself.
        if at >= 2 and time[at - 2] <= time[at] and (at + 1 == time.size or time[at + 1] < time[at - 1]):
            stays[at - 1] = False
    latest = np.maximum.accumulate(np.where(stays, time, -np.inf)) if time.size else time
    return np.asarray(stays & (time >= latest))


__all__ = ["APART_S", "BREAK_S", "MendedTime", "apart", "mended", "spread"]
