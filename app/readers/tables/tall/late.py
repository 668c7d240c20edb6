"""Values with the stamp of the sample before theirs, in a table with one value a row."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

_ALL_AXES: Final = 0b111
_FIRST_AXES: Final = (0b001, 0b011)
"""Sets of axes, by their bits in the order of a sample, that may come with the stamp before."""
_FEWEST: Final = 3
_HABIT: Final = 0.5
"""Of the groups that look alike: where fewer are followed by what they lack, values were lost."""


def with_late(at: NDArray[np.intp], signal: NDArray[np.intp], quantity: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return the sample of each row, those values moved to the next one that have the stamp of the one before.

    Parameters
    ----------
    at : ndarray of int, shape (N,)
        By the stamps.
    signal : ndarray of int, shape (N,)
    quantity : ndarray of int, shape (S,)
        Of each signal of which sensor's quantity it is an axis; -1: of none.

    Notes
    -----
    The first axes of a sample may carry the stamp of the value before them. They stand behind the values of that stamp,
    and the next stamp has exactly the axes that they lack. Lost values leave the same picture now and then by chance:
    values are moved only where most of those that look alike fit.
    """
    groups = _groups(at, signal, quantity)
    left = np.zeros(groups.number.size, dtype=np.intp)
    left[:-1] = np.where(groups.number[1:] == groups.number[:-1] + 1, groups.head[1:], 0)
    moved = np.zeros(groups.number.size, dtype=np.bool_)
    for is_again in (True, False):
        for axes in _FIRST_AXES:
            alike = (groups.tail == axes) & (groups.is_again == is_again)
            fits = alike & (left == _ALL_AXES - axes)
            if fits.sum() >= max(_FEWEST, _HABIT * alike.sum()):
                moved |= fits
    found = at.copy()
    found[groups.rows[moved[groups.of_row] & groups.is_tail]] += 1
    return found


@dataclass(frozen=True)
class _Groups:
    """Values of one quantity at one stamp, G groups of R rows; a set of axes is a number of three bits.

    Attributes
    ----------
    number : ndarray of int, shape (G,)
        Quantity after quantity; within one, one more is the next stamp.
    head, tail : ndarray of int, shape (G,)
        Axes that have their time right, and those that may belong to the next stamp.
    is_again : ndarray of bool, shape (G,)
        The tail begins where the order of a sample begins again; otherwise it is all of the group, behind others.
    rows, of_row, is_tail : ndarray, shape (R,)
        Rows of the table, the group of each, and whether it is of the tail.
    """

    number: NDArray[np.intp]
    head: NDArray[np.intp]
    tail: NDArray[np.intp]
    is_again: NDArray[np.bool_]
    rows: NDArray[np.intp]
    of_row: NDArray[np.intp]
    is_tail: NDArray[np.bool_]


def _groups(at: NDArray[np.intp], signal: NDArray[np.intp], quantity: NDArray[np.intp]) -> _Groups:
    number = quantity[signal] * (int(at[-1]) + 2) + at
    rows = np.argsort(number, kind="stable")
    rows = rows[quantity[signal[rows]] >= 0]
    begins = np.append(True, np.diff(number[rows]) > 0)[: rows.size]
    starts = np.flatnonzero(begins)
    of_row, size = np.cumsum(begins) - 1, np.diff(np.append(starts, rows.size))
    place = np.arange(rows.size) - starts[of_row]
    axis = _in_order(signal[rows], quantity, place, size[of_row])[signal[rows]]
    falls = np.cumsum(np.append(0, np.diff(axis) <= 0)[: rows.size] * ~begins)
    falls -= falls[starts][of_row]

    def axes(which: NDArray[np.bool_]) -> NDArray[np.intp]:
        bits = np.where(which, 1 << axis, 0)
        return np.bitwise_or.reduceat(bits, starts) if starts.size else bits

    ends = np.append(np.diff(at) > 0, True)
    last = rows[starts + size - 1]
    is_again = np.asarray(falls[starts + size - 1] == 1)
    is_behind = ends[last] & ~np.append(True, ends[:-1])[rows[starts]] & (last - rows[starts] == size - 1)
    is_behind &= falls[starts + size - 1] == 0
    is_tail = np.where(is_again[of_row], falls == 1, is_behind[of_row])
    return _Groups(number[rows][starts], axes(~is_tail), axes(is_tail), is_again, rows, of_row, is_tail)


def _in_order(
    signal: NDArray[np.intp], quantity: NDArray[np.intp], place: NDArray[np.intp], size: NDArray[np.intp]
) -> NDArray[np.intp]:
    """Return of each signal which axis it is, by where it usually stands among three of one stamp, shape (S,)."""
    three = size == _ALL_AXES.bit_count()
    count = np.bincount(signal[three], minlength=quantity.size)
    usual = np.bincount(signal[three], place[three], minlength=quantity.size) / np.maximum(count, 1)
    order = np.lexsort((usual, quantity))
    first = np.searchsorted(quantity[order], quantity[order])
    found = np.empty(quantity.size, dtype=np.intp)
    found[order] = np.arange(quantity.size) - first
    return found
