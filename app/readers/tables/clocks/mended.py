"""Time columns of real devices: stamps that repeat, miss, step back or start again, mended where that is certain.

Every sample that was measured stays; a row that was written twice, or has no place in time, is left out. What was done
is reported with its count, and where more than a tenth of the rows is concerned nothing is mended: no time column.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from app.errors import RecordingFormatError
from app.readers.tables.clocks.counter import gone_on
from estimators.recording import Float
from estimators.sentences import Sentence, say

APART_S: Final = 1e-6
"""Of samples that all carry one stamp: nothing says how far they are apart."""
LEAST_SPACING: Final = 0.5
"""Of a usual interval: samples that follow closer arrived together, and were not measured so."""
_LONGEST_BURST_S: Final = 0.5
"""Packets that hold several samples come more often than this; what is longer is a pause."""
_SHORTEST_STEP_S: Final = 2.5e-3
"""Rows that follow each other faster than 400 Hz between holes arrived together; hardly any sensor measures so."""
_ALIKE: Final = 0.1
"""Of the interval: packets that differ by less are whole."""
_LOST: Final = 0.75
"""Of a sample: where a packet has so much less than fits into its time, one is missing."""
_HOLE: Final = 1.5
"""Times what a packet takes: packets that are farther apart have a hole between them."""
_FEW_PAUSES: Final = 200
"""Of so many steps one may be a pause, which says nothing of the rate."""
BREAK_S: Final = 1.0
"""Between two stretches of a clock that started again: how long the pause was is not known, but too long to bridge."""
_MOST_SHARE: Final = 0.1
_EACH_TWICE: Final = 0.45
"""Of the rows that share a stamp repeat the one before, where each was written twice."""
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
    start_s : float
        The first of them by the column's own zero.
    """

    time_s: Float
    rows: NDArray[np.intp]
    notes: tuple[Sentence, ...]
    start_s: float = 0.0


def mended(column: Float, factor: float, values: Float | None = None) -> MendedTime:
    """Return a time column with every stamp later than the one before.

    Parameters
    ----------
    column : ndarray, shape (N,)
        As written, in units of `factor` seconds; NaN where a row has no time.
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
    time = gone_on(column[rows]) * factor
    backwards = int((np.diff(time) < 0).sum())
    if backwards > _MOST_SHARE * column.size or np.unique(time[:1000]).size < 2:
        raise RecordingFormatError(say("time.does_not_advance"), count=backwards)
    time, breaks = _set_back(time, _usual_step(time))
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
        still = np.diff(time) == 0
        twice[1:] = still & same.all(axis=1)
        # A sensor repeats its values now and then: within a stamp of many samples that is no row written twice.
        is_chance = still.mean() > 0.5 and twice[1:][still].mean() < _EACH_TWICE
        if twice.any() and not is_chance:
            notes.append(say("time.row_twice", count=int(twice.sum())))
            rows, time = rows[~twice], time[~twice]
    if column.size - rows.size > _MOST_SHARE * column.size:
        raise RecordingFormatError(
            say("time.hopeless", count=column.size - rows.size, rows=column.size),
            count=column.size - rows.size,
        )
    time, repeated = spaced(time)
    if repeated:
        notes.append(say("time.repeated", count=repeated))
    start_s = float(time[0]) if time.size else 0.0
    return MendedTime(time - start_s, rows, tuple(notes), start_s)


def spaced(time_s: Float) -> tuple[Float, int]:
    """Give samples that share a stamp, or nearly do, their places between their neighbours.

    Parameters
    ----------
    time_s : ndarray, shape (N,)
        Never falling.

    Returns
    -------
    time_s : ndarray, shape (N,)
        Rising; where there is room no two are closer than half a usual interval.
    count : int
        How many samples came less than that after the one before.

    Notes
    -----
    Stamps are often those of the arrival: samples that were measured evenly arrive together. The gap that their number
    fits says whether they are late (it lies before them) or the stamp is that of the first (it lies behind). Where
    most share a stamp the clock is coarser than the rate, or packets hold several samples: each fills the way to the
    next stamp.
    """
    if time_s.size < 3:
        return time_s, 0
    usual = usual_interval(time_s)
    starts = np.flatnonzero(np.append(True, np.diff(time_s) >= LEAST_SPACING * usual))
    length = np.diff(np.append(starts, time_s.size))
    count = int(time_s.size - starts.size)
    if not count:
        return time_s, 0
    if 2 * int(length[length > 1].sum()) > time_s.size:
        return _spread(time_s, starts, length), count
    found = time_s.copy()
    for place in np.flatnonzero(length > 1).tolist():
        first, size = int(starts[place]), int(length[place])
        last = first + size - 1
        before = (time_s[last] - found[first - 1]) / size if first else 0.0
        behind = (time_s[last + 1] - time_s[first]) / size if last + 1 < time_s.size else usual
        at = np.arange(size)
        if max(before, behind) < LEAST_SPACING * usual and first and last + 1 < time_s.size:
            step = (time_s[last + 1] - found[first - 1]) / (size + 1)
            found[first : last + 1] = found[first - 1] + step * (at + 1)
        elif abs(before - usual) < abs(behind - usual):
            found[first : last + 1] = time_s[last] - min(before, usual) * at[::-1]
        else:
            found[first : last + 1] = time_s[first] + min(behind, usual) * at
    return found, count


def usual_interval(time_s: Float) -> float:
    """Return the time from one sample to the next, pauses left out.

    Parameters
    ----------
    time_s : ndarray, shape (N,)
        Never falling.

    Notes
    -----
    The median of the steps, unless most of them are none, or far shorter than what a row takes in the mean and than
    sensors of people measure: then rows arrive in bursts, and the mean says how many were measured in a second. Even
    steps of a usual rate between holes are stamps of the device: the rest was lost, or not measured.
    """
    steps = np.sort(np.diff(time_s))
    usual = steps[: max(1, steps.size - 1 - steps.size // _FEW_PAUSES)]
    usual = usual[usual <= _LONGEST_BURST_S]
    mean, rising = float(usual.mean()) if usual.size else 0.0, steps[steps > 0]
    middle = float(np.median(rising)) if rising.size else 0.0
    if mean <= 0.0 or LEAST_SPACING * mean <= middle <= mean / LEAST_SPACING:
        return middle
    return middle if middle >= _SHORTEST_STEP_S and float(np.median(steps)) > 0.0 else mean


def _spread(time_s: Float, starts: NDArray[np.intp], length: NDArray[np.intp]) -> Float:
    """Spread groups of samples evenly, each from its first stamp up to that of the next group."""
    to_next = np.append(np.diff(time_s[starts]), np.nan) / length
    typical = float(np.nanmedian(np.repeat(to_next, length))) if starts.size > 1 else APART_S
    # The recording began within the first of them.
    typical = float(np.nanmedian(np.repeat(to_next, length)[length[0] :])) if starts.size > 2 else typical
    alike = np.abs(to_next - typical) < _ALIKE * typical
    alike[0] &= starts.size < 3
    usual = float((to_next * length)[alike].sum() / length[alike].sum()) if alike.any() else typical
    # A pause after the last of them, or samples that are lost, are no time in which the others were measured.
    is_whole = (to_next / usual - 1.0) * length < _LOST
    each = np.where(is_whole, to_next, usual)
    first = time_s[starts]
    if to_next[0] > usual:
        # The recording began within a tick of its clock: what there is of it stands before the next one.
        each[0] = usual
        first[0] = first[1] - length[0] * usual
    if starts.size > 2:
        # Behind a hole a packet that lacks samples lacks its first ones: the rest ends where the next one begins.
        usual_s = float(np.median(length)) * usual
        gap_s = np.diff(time_s[starts])
        late = 1 + np.flatnonzero(
            (gap_s[:-1] > _HOLE * usual_s)
            & (length[1:-1] < np.median(length))
            & (np.abs(gap_s[1:] - usual_s) < _LOST * usual)
        )
        first[late] = time_s[starts][late + 1] - length[late] * usual
    place = np.arange(time_s.size) - np.repeat(starts, length)
    return np.asarray(np.repeat(first, length) + place * np.repeat(each, length))


def _usual_step(time: Float) -> float:
    steps = np.diff(time)
    steps = steps[steps > 0]
    return float(np.median(steps)) if steps.size else 0.0


def _set_back(time: Float, step: float) -> tuple[Float, int]:
    """Let a clock that starts again go on after a pause of unknown length; return how often it did."""
    shift, breaks = np.zeros(time.size), 0
    for at in (np.flatnonzero(np.diff(time) < 0) + 1).tolist():
        before = float(time[at - 1])
        ahead = time[at : at + max(2, int(_LATE_S / step) if step else 2)]
        if (ahead >= before).any() or ahead.size < 2:
            # A few rows that came late, or one stamp far ahead: `_in_order` leaves them out.
            continue
        if at >= 2 and time[at - 2] < time[at] < before:
            continue
        shift[at] = before - time[at] + BREAK_S
        breaks += 1
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
