"""Which rows of a table with one value a row are of one sample."""

from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from app.readers.tables.tall.late import with_late

_SHARED: Final = 0.3
"""Of the rows stand at the time of the row before, where values of one sample share a stamp."""
_COARSE: Final = 0.3
"""Of the rows come again at one time, where a stamp holds several samples."""
_BLOCKS: Final = 0.1
"""Of the rows are of another name than the row before; fewer: one signal stands below the other."""

_CYCLE: Final = 0.8
"""Of the rows follow the one before in the order of a sample, where all signals have one rate."""

Order = Literal["stamps", "turns", "apart", "blocks"]
"""`stamps`: values of a sample share a stamp; `turns`: they follow each other in one order; `apart`: those of a
quantity do, and quantities have rates of their own; `blocks`: one signal stands below the other."""


def order_of(signal: NDArray[np.intp], stamps: NDArray[Any] | None) -> Order:
    """Return how the rows of a sample are found."""
    if (signal[1:] != signal[:-1]).mean() < _BLOCKS and stamps is not None:
        return "blocks"
    if stamps is None or not share_stamps(stamps):
        return "turns"
    place = np.concatenate([[0], np.cumsum(stamps[1:] != stamps[:-1])])
    return "turns" if float((_number_in(place, signal) > 0).mean()) > _COARSE else "stamps"


def share_stamps(stamps: NDArray[Any] | None) -> bool:
    """Return whether rows that follow each other stand at one time."""
    return stamps is not None and bool((stamps[1:] == stamps[:-1]).mean() >= _SHARED)


def is_cycle(signal: NDArray[np.intp]) -> bool:
    """Return whether signals follow each other as in a sample, all at one rate."""
    count = int(signal.max(initial=0)) + 1
    return bool(((signal[1:] - signal[:-1]) % count == 1).mean() > _CYCLE)


def of_a_sample(signal: NDArray[np.intp], first: list[tuple[str, ...]]) -> list[tuple[str, ...]]:
    """Return the signals in the order in which a whole sample has them."""
    count = len(first)
    for at in range(signal.size - count + 1):
        one = signal[at : at + count]
        if one[0] == signal[0] and np.unique(one).size == count:
            return [first[k] for k in one.tolist()]
    return first


def places(
    signal: NDArray[np.intp], stamps: NDArray[Any] | None, order: Order, quantity: NDArray[np.intp]
) -> NDArray[np.intp]:
    """Return of each row in which sample it is.

    Parameters
    ----------
    signal : ndarray of int, shape (N,)
        By its place in a sample.
    stamps : ndarray, shape (N,), or None
    quantity : ndarray of int, shape (S,)
        Of each signal of which sensor's quantity it is an axis.
    """
    if not signal.size:
        return signal
    if order == "blocks":
        assert stamps is not None
        is_text = stamps.dtype == object
        at = np.unique(stamps.astype(str) if is_text else stamps, return_inverse=True)[1]
        if is_text and not _are_numbers(stamps):
            # Times of day: in the order in which they come.
            first = np.full(int(at.max()) + 1, at.size)
            np.minimum.at(first, at, np.arange(at.size))
            at = np.argsort(np.argsort(first))[at]
        elif is_text:
            at = np.unique(_numbers(stamps), return_inverse=True)[1]
    else:
        begins = np.zeros(signal.size, dtype=np.bool_)
        if stamps is not None and (order == "stamps" or share_stamps(stamps)):
            begins[1:] = stamps[1:] != stamps[:-1]
        if order in ("turns", "apart"):
            begins[1:] |= signal[1:] <= signal[:-1]
        if order == "apart":
            begins[1:] |= quantity[signal[1:]] != quantity[signal[:-1]]
        at = np.cumsum(begins)
    if order == "stamps":
        at = with_late(at, signal, quantity)
    # What comes again at one time is of the next sample.
    number = _number_in(at, signal)
    both = np.stack([at, number], axis=1)
    return np.unique(both, axis=0, return_inverse=True)[1].reshape(-1)


def _number_in(place: NDArray[np.intp], signal: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return of each row how many rows of the same place and signal stand above it."""
    key = place.astype(np.int64) * (int(signal.max()) + 1) + signal
    order = np.argsort(key, kind="stable")
    sorted_ = key[order]
    starts = np.flatnonzero(np.concatenate([[True], sorted_[1:] != sorted_[:-1]]))
    length = np.diff(np.append(starts, key.size))
    found = np.empty(key.size, dtype=np.intp)
    found[order] = np.arange(key.size) - np.repeat(starts, length)
    return found


def side_by_side(
    signal: NDArray[np.intp],
    place: NDArray[np.intp],
    values: NDArray[Any],
    beside: dict[str, NDArray[Any]],
    signals: int,
) -> dict[int | str, NDArray[Any]]:
    """Return a column for each signal by its number, NaN where a sample lacks it, and those beside by name."""
    count = int(place.max(initial=-1)) + 1
    found: dict[int | str, NDArray[Any]] = {}
    for number in range(signals):
        rows = signal == number
        found[number] = np.full(count, np.nan if values.dtype != object else "", dtype=values.dtype)
        found[number][place[rows]] = values[rows]
    # The first value of a sample may have come with the stamp of the one before.
    last = np.zeros(count, dtype=np.intp)
    np.maximum.at(last, place, np.arange(place.size))
    return found | {name: column[last] for name, column in beside.items()}


def _numbers(stamps: NDArray[Any]) -> NDArray[np.float64]:
    return np.array([float(str(one).replace(",", ".")) for one in stamps.tolist()])


def _are_numbers(stamps: NDArray[Any]) -> bool:
    try:
        _numbers(stamps)
    except ValueError:
        return False
    return True
