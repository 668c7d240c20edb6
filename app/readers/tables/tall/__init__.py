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
from app.readers.tables.tall.pieces import Piece
from app.readers.tables.tall.samples import (
    Order,
    is_cycle,
    of_a_sample,
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
    says_quantity,
    value_column,
    with_devices,
)
from app.readers.tables.triples import triples_of
from app.readers.tables.units import bodies_of
from estimators.sentences import Sentence, say

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
    order : str
        `stamps`: values of a sample share a stamp; `turns`: they follow each other in one order; `blocks`: one signal
        stands below the other.
    signals : tuple of tuple of str
        What the names say of each column of `wide`, in the order of a sample.
    wide : TableHead
        With a row for each sample: the columns that are beside, then a column for each signal.
    late : frozenset of tuple of str
        Signals that are not in the beginning: a mapping that was made by that alone leaves them out.
    """

    raw: TableHead
    names: tuple[str, ...]
    value: str
    clock: str | None
    order: Order
    signals: tuple[tuple[str, ...], ...]
    wide: TableHead
    late: frozenset[tuple[str, ...]] = frozenset()

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
        of = dict(zip(self.signals, self.called, strict=True))
        left_out = [known[one] for one in self.late if of[one] not in wanted]
        notes = (*notes, *_said_of_others(self, called, (signal < 0) | np.isin(signal, left_out)))
        there = signal >= 0
        stamps = None if self.clock is None else table[self.clock][there]
        place = places(signal[there], stamps, self.order, self.quantities)
        found = side_by_side(
            signal[there],
            place,
            table[self.value][there],
            {name: table[name][there] for name in beside},
            len(self.signals),
        )
        columns = {name: at for at, name in enumerate(self.called)}
        return {name: found[columns.get(name, name)] for name in wanted}, notes


def tall_of(head: TableHead) -> Tall | None:
    """Return how a table with one value a row is read; None for any other table."""
    if any(named(column, letters=True) is not None for column in head.columns):
        return None
    bodies = bodies_of(head, MOST_ROWS)
    value = value_column(head, bodies[0])
    if value is None:
        return None
    unit = next((one for one in head.columns if UNIT & set(words_of(one)) and one != value), None)
    texts = {column: np.array(bodies[0].texts(column)) for column in head.columns}
    said = [c for c in head.columns if c not in (value, unit) and says_quantity(texts[c])]
    if not said or not are_signals(called_by(texts, said, unit)):
        return None
    clock = clock_of(head, bodies[0], texts, said, value)
    names = with_devices(head, bodies, said, clock, value, unit)
    chosen = (*names, *([unit] if unit else []))
    # What was looked at of the rest has the signals of devices that begin later.
    pieces = [Piece.of(body, head, chosen, clock.column) for body in bodies]
    if (order := pieces[0].order) == "blocks":
        del pieces[1:]
    first = list(dict.fromkeys(one for piece in pieces for one in piece.called))
    if len(first) > MOST_NAMES:
        return None
    if order == "turns":
        whole = max(pieces, key=lambda piece: len(set(piece.called)))
        first = list(dict.fromkeys([*of_a_sample(whole.signal, whole.first), *first]))
        # A stamp of several samples does not say which of two rates belong together.
        is_one = is_cycle(whole.numbered(first)) and not share_stamps(pieces[0].stamps)
        order = "turns" if is_one else "apart"
    late = frozenset(first) - set(pieces[0].called)
    found = Tall(head, chosen, value, clock.column, order, tuple(first), head, late)
    lines = [_lines(found, piece.numbered(first), piece.texts) for piece in pieces]
    return replace(found, wide=_wide(found, lines))


def of_tall(tall: Tall, guess: Guess) -> Guess:
    """Return the guess of a table's samples with what was made of its rows.

    Parameters
    ----------
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


def _wide(tall: Tall, pieces: list[list[tuple[str, ...]]]) -> TableHead:
    """Return the head of the table with a row for each sample, as far as it was looked at."""
    head = tall.raw
    beside = [column for column in head.columns if column not in (*tall.names, tall.value)]

    def written(row: tuple[str, ...]) -> str:
        text = io.StringIO()
        csv.writer(text, delimiter=head.delimiter, lineterminator="").writerow(row)
        return text.getvalue()

    # The last sample may lack what comes behind; a last line is left out of what is looked at.
    bodies = [tuple(map(written, rows)) for rows in pieces]
    return replace(
        head,
        columns=(*beside, *tall.called),
        rows=tuple(pieces[0][: len(head.rows)]),
        body=bodies[0],
        later=tuple(bodies[1:]),
    )


def _lines(tall: Tall, signal: NDArray[np.intp], texts: dict[str, NDArray[Any]]) -> list[tuple[str, ...]]:
    """Return rows that follow each other with a row for each sample."""
    beside = [column for column in tall.raw.columns if column not in (*tall.names, tall.value)]
    stamps = None if tall.clock is None else texts[tall.clock].astype(object)
    place = places(signal, stamps, tall.order, tall.quantities)
    values = texts[tall.value].astype(object)
    found = side_by_side(
        signal,
        place,
        values,
        {name: texts[name].astype(object) for name in beside},
        len(tall.signals),
    )
    nothing = "nan" if tall.raw.delimiter == " " else ""
    columns = [*(found[name] for name in beside), *(found[k] for k in range(len(tall.signals)))]
    return [
        tuple(str(one) or nothing for one in row) for row in zip(*(c.tolist() for c in columns), strict=True)
    ]


def _name(said: tuple[str, ...], *, has_unit: bool) -> str:
    """Return what the column of a signal is called."""
    if has_unit and said[-1]:
        return f"{' '.join(one for one in said[:-1] if one)} ({said[-1]})"
    return " ".join(one for one in said if one)


def _said_of_others(
    tall: Tall, called: Sequence[tuple[Any, ...]], is_left_out: NDArray[np.bool_]
) -> list[Sentence]:
    """Say which rows are left out: of no signal that was looked at, or of one that came late and is not mapped."""
    others = Counter(
        " ".join(str(one or "").strip() for one in called[at]) for at in np.flatnonzero(is_left_out).tolist()
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
