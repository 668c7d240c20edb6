"""Tables with one value a row (time, name of the signal, value): their rows put side by side, a column for each name.

A mapping then says of `gyr_x` and `acc_z` what it says of the columns of any other table.
"""

import csv
import io
from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from app.readers.tables.body import check_present, read_table
from app.readers.tables.guess import Guess
from app.readers.tables.head import TableHead
from app.readers.tables.names import named, words_of
from app.readers.tables.tall.samples import (
    Order,
    is_cycle,
    of_a_sample,
    order_of,
    places,
    share_stamps,
    side_by_side,
)
from app.readers.tables.tall.signals import (
    MOST_NAMES,
    MOST_ROWS,
    UNIT,
    are_signals,
    called_by,
    clock_of,
    says_what,
    value_column,
    with_devices,
)
from app.readers.tables.triples import triples_of
from app.readers.tables.units import Body
from app.sentences import Sentence, say

_NO_SENSOR: Final = frozenset({"guess.no_signal", "guess.not_whole"})


@dataclass(frozen=True)
class Tall:
    """A table with one value a row.

    Attributes
    ----------
    raw : TableHead
        As it is written.
    names : tuple of str
        Columns that say what a value is of.
    value : str
    clock : str or None
    order : str
        `stamps`: values of a sample share a stamp; `turns`: they follow each other in one order; `blocks`: one signal
        stands below the other.
    signals : tuple of tuple of str
        What the names say of each column of `wide`, in the order of a sample.
    wide : TableHead
        With a row for each sample: the columns that are beside, then a column for each signal.
    """

    raw: TableHead
    names: tuple[str, ...]
    value: str
    clock: str | None
    order: Order
    signals: tuple[tuple[str, ...], ...]
    wide: TableHead

    @property
    def called(self) -> list[str]:
        """What the columns of the signals are called."""
        has_unit = bool(UNIT & set(words_of(self.names[-1])))
        return [_name(one, has_unit=has_unit) for one in self.signals]

    @property
    def quantities(self) -> NDArray[np.intp]:
        """Of each signal of which sensor's quantity it is an axis; those of none are one of their own."""
        called = self.called
        of = {column: at for at, one in enumerate(triples_of(tuple(called))) for column in one.columns}
        return np.array([of.get(column, -1) for column in called], dtype=np.intp)

    def read(
        self, path: Path, wanted: list[str], text: Collection[str]
    ) -> tuple[dict[str, NDArray[Any]], tuple[Sentence, ...]]:
        """Read columns of `wide`, shape (N,); see `read_table`.

        Parameters
        ----------
        path : Path
        wanted : list of str
        text : collection of str
            Those that are read as they are written.
        """
        check_present(wanted, self.wide)
        beside = [name for name in wanted if name in self.raw.columns]
        clock = [self.clock] if self.clock and self.clock not in beside else []
        plain = {*text, *self.names, *clock}
        table, notes = read_table(path, [*beside, *clock, *self.names, self.value], self.raw, plain)
        called = [tuple(one) for one in zip(*(table[name].tolist() for name in self.names), strict=True)]
        known = {signal: at for at, signal in enumerate(self.signals)}
        signal = np.array([known.get(tuple(str(one or "").strip() for one in said), -1) for said in called])
        notes = (*notes, *_said_of_others(self, called, signal))
        there = signal >= 0
        stamps = None if self.clock is None else table[self.clock][there]
        place = places(signal[there], stamps, self.order, self.quantities)
        found = side_by_side(
            signal[there], place, table[self.value][there], {name: table[name][there] for name in beside}
        )
        columns = {name: at for at, name in enumerate(self.called)}
        return {name: found[columns.get(name, name)] for name in wanted}, notes


def tall_of(head: TableHead) -> Tall | None:
    """Return how a table with one value a row is read; None for any other table.

    Parameters
    ----------
    head : TableHead
    """
    if any(named(column, letters=True) is not None for column in head.columns):
        return None
    body = Body(head, MOST_ROWS)
    texts = {column: np.array(body.texts(column)) for column in head.columns}
    value = value_column(head, body)
    if value is None:
        return None
    unit = next((one for one in head.columns if UNIT & set(words_of(one)) and one != value), None)
    names = [c for c in head.columns if c not in (value, unit) and says_what(c, texts[c])]
    if not names or not are_signals(called_by(texts, names, unit)):
        return None
    clock = clock_of(head, body, texts, names, value)
    names = with_devices(head, texts, names, [clock, value, unit])
    called = called_by(texts, names, unit)
    chosen = (*names, *([unit] if unit else []))
    # A row that names nothing, or a head that stands again, is of no signal.
    first = [one for one in dict.fromkeys(called) if any(one) and one != chosen]
    if len(first) > MOST_NAMES:
        return None
    at = {one: number for number, one in enumerate(first)}
    rows = np.array([one in at for one in called], dtype=np.bool_)
    called = [one for one in called if one in at]
    texts = {column: one[rows] for column, one in texts.items()}
    stamps = None if clock is None else texts[clock]
    signal = np.array([at[one] for one in called])
    if (order := order_of(signal, stamps)) == "turns":
        first = of_a_sample(signal, first)
        at = {one: number for number, one in enumerate(first)}
        signal = np.array([at[one] for one in called])
        # A stamp of several samples does not say which of two rates belong together.
        order = "turns" if is_cycle(signal) and not share_stamps(stamps) else "apart"
    found = Tall(head, chosen, value, clock, order, tuple(first), head)
    return replace(found, wide=_wide(found, signal, texts))


def of_tall(tall: Tall, guess: Guess) -> Guess:
    """Return the guess of a table's samples with what was made of its rows.

    Parameters
    ----------
    tall : Tall
    guess : Guess
        Of its `wide`.
    """
    note = say("guess.tall", columns=list(tall.names))
    if not any(one.code in _NO_SENSOR for one in guess.missing):
        return replace(guess, notes=(note, *guess.notes))
    seen = list(tall.wide.columns[-len(tall.signals) :])[:12]
    lacks = (
        say("guess.tall_lacks", values=seen)
        if tall.clock is None
        else say("guess.tall_unsorted", values=seen, column=tall.clock)
    )
    others = tuple(one for one in guess.missing if one.code not in _NO_SENSOR)
    return replace(guess, notes=(note, *guess.notes), missing=(lacks, *others))


def _wide(tall: Tall, signal: NDArray[np.intp], texts: dict[str, NDArray[Any]]) -> TableHead:
    """Return the head of the table with a row for each sample, as far as it was looked at."""
    head = tall.raw
    beside = [column for column in head.columns if column not in (*tall.names, tall.value)]
    stamps = None if tall.clock is None else texts[tall.clock].astype(object)
    place = places(signal, stamps, tall.order, tall.quantities)
    values = texts[tall.value].astype(object)
    found = side_by_side(signal, place, values, {name: texts[name].astype(object) for name in beside})
    nothing = "nan" if head.delimiter == " " else ""
    lines = []
    columns = [*(found[name] for name in beside), *(found[k] for k in range(len(tall.signals)))]
    rows = [[str(one) or nothing for one in row] for row in zip(*(c.tolist() for c in columns), strict=True)]
    for row in rows:
        text = io.StringIO()
        csv.writer(text, delimiter=head.delimiter, lineterminator="").writerow(row)
        lines.append(text.getvalue())
    return replace(
        head,
        columns=(*beside, *tall.called),
        rows=tuple(tuple(row) for row in rows[: len(head.rows)]),
        # The last sample may lack what comes behind; a last line is left out of what is looked at.
        body=tuple(lines),
    )


def _name(said: tuple[str, ...], *, has_unit: bool) -> str:
    """Return what the column of a signal is called."""
    if has_unit and said[-1]:
        return f"{' '.join(one for one in said[:-1] if one)} ({said[-1]})"
    return " ".join(one for one in said if one)


def _said_of_others(
    tall: Tall, called: Sequence[tuple[Any, ...]], signal: NDArray[np.intp]
) -> list[Sentence]:
    """Say which rows are of no signal that stands in the beginning."""
    others = Counter(
        " ".join(str(one or "").strip() for one in called[at]) for at in np.flatnonzero(signal < 0).tolist()
    )
    column = " ".join(tall.names)
    notes = []
    if empty := sum(count for name, count in others.items() if not name.strip()):
        notes.append(say("table.rows_of_nobody", count=empty, column=column))
    if named_ := {name: count for name, count in others.items() if name.strip()}:
        values = [name[:60] for name in list(named_)[:5]]
        notes.append(say("table.rows_of_no_signal", count=sum(named_.values()), column=column, values=values))
    return notes


__all__ = ["Tall", "of_tall", "tall_of"]
