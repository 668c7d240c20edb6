"""What a table with one value a row says of its values: which column holds them, which say what they are of."""

import re
from collections import Counter
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from app.readers.tables.clocks.guess import guess_time
from app.readers.tables.clocks.of_day import is_clock
from app.readers.tables.head import TableHead
from app.readers.tables.names import named, placement_of, quantity_of, side_of, words_of
from app.readers.tables.rows import DEVICE
from app.readers.tables.units import Body

_VALUE: Final = frozenset({"value", "values", "val", "wert", "messwert", "reading", "measurement", "data"})
"""What the column of values is called."""
UNIT: Final = frozenset({"unit", "units", "einheit", "einheiten", "uom"})
MOST_ROWS: Final = 20_000
"""Of the beginning: a sample has many."""
_RISES: Final = 0.9
"""Of the steps of a clock or of a number of the row; values of several signals go to and fro."""
MOST_NAMES: Final = 400
_MOST_TEXTS: Final = 60
"""Different texts in a column that says what a value is of."""
_DECIMAL: Final = re.compile(r"[+-]?\d*[.,]\d+")
_MOST_DEVICES: Final = 17
_TWICE: Final = (0.1, 0.01)
"""Rows of one name and one time are of two devices where a column that makes them few is found."""


def value_column(head: TableHead, body: Body) -> str | None:
    """Return the only column that can hold the values."""
    found = []
    for column in head.columns:
        values = body.numbers(column)[:, 0]
        steps = np.diff(values[np.isfinite(values)])
        is_even = not steps.size or 2 * steps.size < len(body) or (steps >= 0.0).mean() > _RISES
        if not is_even and not any(map(DEVICE.fullmatch, words_of(column))):
            found.append(column)
    called = [column for column in found if _VALUE & set(words_of(column))]
    found = called or found
    return found[0] if len(found) == 1 else None


def says_what(column: str, texts: NDArray[Any]) -> bool:
    """Return whether a column says of a value which quantity, axis or sensor it is of."""
    several = {one for one in np.unique(texts).tolist() if one}
    if not several or len(several) > _MOST_TEXTS or all(map(is_clock, several)):
        return False
    if any(map(DEVICE.fullmatch, words_of(column))):
        return True
    return any(
        named(one, letters=True) is not None
        or quantity_of(words_of(one))
        or placement_of("_".join(words_of(one)))
        or side_of(one)
        for one in several
    )


def called_by(
    texts: dict[str, NDArray[Any]], names: Sequence[str], unit: str | None
) -> list[tuple[str, ...]]:
    """Return of each row what the names say, and the unit."""
    columns = [texts[name].tolist() for name in (*names, *([unit] if unit else []))]
    return [tuple(one) for one in zip(*columns, strict=True)]


def are_signals(called: Sequence[tuple[str, ...]]) -> bool:
    """Return whether something is said to be an axis of a quantity."""
    found = (named(" ".join(one), letters=True) for one in dict.fromkeys(called))
    return any(one is not None and one.quantity for one in found)


def clock_of(
    head: TableHead, body: Body, texts: dict[str, NDArray[Any]], names: list[str], value: str
) -> str | None:
    """Return the clock, by the rows of the signal that most of them are of."""
    said = np.array(["\0".join(one) for one in called_by(texts, names, None)])
    most = Counter(said.tolist()).most_common(1)[0][0].split("\0")
    mine = body.of_rows(dict(zip(names, most, strict=True)))
    return guess_time(head, mine, {value, *names}).column


def with_devices(
    head: TableHead, texts: dict[str, NDArray[Any]], names: list[str], others: list[str | None]
) -> list[str]:
    """Return the names with the column that tells devices apart whose values have one name and one time."""
    clock = others[0]
    if clock is None:
        return names
    before = _twice(texts, [clock, *names])
    if before < _TWICE[0]:
        return names
    for column in head.columns:
        if any(map(_DECIMAL.fullmatch, texts[column][:_MOST_TEXTS].tolist())):
            continue
        few = 2 <= len(np.unique(texts[column])) <= _MOST_DEVICES
        if few and column not in (*names, *others) and _twice(texts, [clock, *names, column]) < _TWICE[1]:
            return [one for one in head.columns if one in (*names, column)]
    return names


def _twice(texts: dict[str, NDArray[Any]], columns: list[str]) -> float:
    """Return the share of rows that hold what another one holds at the same time; the clock is the first column."""
    stamps = texts[columns[0]]
    # A counter comes to the same number again.
    at = np.cumsum(np.concatenate([[False], stamps[1:] != stamps[:-1]])).tolist()
    rows = list(zip(at, *(texts[column].tolist() for column in columns[1:]), strict=True))
    return 1.0 - len(set(rows)) / max(len(rows), 1)


__all__ = [
    "MOST_NAMES",
    "MOST_ROWS",
    "UNIT",
    "are_signals",
    "called_by",
    "clock_of",
    "says_what",
    "value_column",
    "with_devices",
]
