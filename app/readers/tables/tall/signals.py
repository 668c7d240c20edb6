"""The columns of a table with one value a row: which holds the values, which say what they are of."""

from collections import Counter
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from app.readers.tables.clocks.guess import TimeGuess, guess_time
from app.readers.tables.clocks.of_day import is_clock
from app.readers.tables.head import TableHead
from app.readers.tables.names import named, placement_of, quantity_of, side_of, words_of
from app.readers.tables.rows import DECIMAL, DEVICE, devices_of_rows, follow_each_other, names_devices
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
_MOST_TRIED: Final = 9
"""Signals whose rows are looked at: a gyroscope at rest tells no devices apart, a direction of gravity does."""
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


def says_quantity(texts: NDArray[Any]) -> bool:
    """Return whether a column says of a value which quantity or axis it is of."""
    several = {one for one in np.unique(texts).tolist() if one}
    if not several or len(several) > _MOST_TEXTS or all(map(is_clock, several)):
        return False
    return any(named(one, letters=True) is not None or quantity_of(words_of(one)) for one in several)


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
) -> TimeGuess:
    """Return the clock, by the rows of the signal that most of them are of."""
    said = np.array(["\0".join(one) for one in called_by(texts, names, None)])
    most = Counter(said.tolist()).most_common(1)[0][0].split("\0")
    mine = body.of_rows(dict(zip(names, most, strict=True)))
    return guess_time(head, mine, {value, *names})


def with_devices(
    head: TableHead, bodies: Sequence[Body], said: list[str], clock: TimeGuess, value: str, unit: str | None
) -> list[str]:
    """Return the columns that say what a value is of, with those that tell devices apart.

    Parameters
    ----------
    bodies : sequence of Body
        Rows that follow each other, each.
    said : list of str
        Columns that say quantity and axis.

    Notes
    -----
    A column tells devices apart where each of its values has values of the same names at the same times, or in turns. A
    label that says nothing but what the names say already is one of their words; any other one marks what was done.
    """
    names = list(said)
    for _ in head.columns:
        others = [c for c in head.columns if c not in (*names, clock.column, value, unit)]
        more = next((c for c in others if _is_word(c, bodies, names)), None) or next(
            (c for c in others if _tells_devices(c, bodies, names, clock, value)), None
        )
        if more is None:
            break
        names = [one for one in head.columns if one in (*names, more)]
    return names


def _is_word(column: str, bodies: Sequence[Body], names: list[str]) -> bool:
    """Return whether a column says of each name which device it is of, and always the same."""
    rows = (row for body in bodies for row in zip(*(body.texts(c) for c in (*names, column)), strict=True))
    pairs = {row for row in rows if any(row[:-1])}
    several = {row[-1] for row in pairs if row[-1]}
    if not several or len(several) > _MOST_TEXTS or len({row[:-1] for row in pairs}) < len(pairs):
        return False
    if all(map(is_clock, several)):
        return False
    return any(map(DEVICE.fullmatch, words_of(column))) or any(
        placement_of("_".join(words_of(one))) or side_of(one) for one in several
    )


def _tells_devices(
    column: str, bodies: Sequence[Body], names: list[str], clock: TimeGuess, value: str
) -> bool:
    """Return whether the names come for each text of a column, at the same times or in turns."""
    several = {one for body in bodies for one in body.texts(column) if one and one != column}
    if not 2 <= len(several) <= _MOST_TEXTS or any(map(DECIMAL.fullmatch, several)):
        return False
    if names_devices(column) or follow_each_other(bodies, column, several, clock.column, clock.unit):
        return True
    for body in bodies:
        texts = body.texts(column)
        if len(set(texts)) < 2:
            continue
        rows = list(zip(*(body.texts(name) for name in names), strict=True))
        if clock.column is not None:
            stamps = body.texts(clock.column)
            with_label = [(*row, text) for row, text in zip(rows, texts, strict=True)]
            if _twice(stamps, rows) >= _TWICE[0] and _twice(stamps, with_label) < _TWICE[1]:
                return True
        for signal, _ in Counter(rows).most_common(_MOST_TRIED):
            mine = body.of_rows(dict(zip(names, signal, strict=True)))
            if devices_of_rows(mine, [column], clock.column, clock.unit, (value,)) is not None:
                return True
    return False


def _twice(stamps: Sequence[str], rows: Sequence[tuple[str, ...]]) -> float:
    """Return the share of rows that hold what another one holds at the same time."""
    at, seen = 0, set()
    for k, row in enumerate(rows):
        # A counter comes to the same number again.
        at += k > 0 and stamps[k] != stamps[k - 1]
        seen.add((at, row))
    return 1.0 - len(seen) / max(len(rows), 1)
