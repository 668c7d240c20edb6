"""One recording in several tables of one clock, in a zip: side by side, each column named by its table too.

So `Gyroscope.csv` and `Accelerometer.csv` are one table with the columns `Gyroscope x` and `Accelerometer x`, of which
a mapping says what it says of any other; each signal has the clock of its table.
"""

import csv
import io
import re
from collections.abc import Collection
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Final, cast

import numpy as np
from numpy.typing import NDArray

from app.errors import RecordingFormatError
from app.readers.contract import TEXT
from app.readers.members import Member, members_of, reading
from app.readers.tables.body import read_table
from app.readers.tables.clocks.counter import COUNT, unwrapped
from app.readers.tables.clocks.guess import TimeGuess, guess_time
from app.readers.tables.guess import Guess, PipelineName, guess_of_head
from app.readers.tables.head import TableHead, head_of, is_number, split_line
from app.readers.tables.names import named, side_of, words_of
from app.readers.tables.pauses import Pauses, pauses_of
from app.readers.tables.text import start_of
from app.readers.tables.units import Body
from estimators.recording import Float
from estimators.sentences import Sentence, say

_OF_TIME: Final = frozenset(
    {"guess.no_time", "guess.counter_needs_rate", "guess.counter", "guess.rate_left", "guess.rows_counted"}
) | {"guess.own_clocks", "guess.microseconds", "guess.clocks_left", "guess.time_unit"}
"""What is said of the clock of a table: each of several has its own."""
_COUNTER_WRAPS: Final = (2.0**16, 2.0**32)
_GRAVITY: Final = "gravity"


@dataclass(frozen=True)
class Part:
    """One of several tables.

    Attributes
    ----------
    label : str
        Stands before the names of its columns; empty where it is the only one.
    """

    member: Member
    head: TableHead
    label: str = ""

    def called(self, column: str) -> str:
        """Return what a column of it is called beside those of the others."""
        return f"{self.label} {column}".strip()


class Tables:
    """The tables of one recording in a zip.

    Raises
    ------
    RecordingFormatError
        It is damaged or out of bounds (see `members_of`), or holds no table of a sensor's measurements.
    """

    def __init__(self, archive: Path) -> None:
        members = members_of(archive)
        with reading():
            found = [(one, head) for one in members if (head := _head_of(one)) is not None]
            self._pauses: Pauses | None = pauses_of(members)
        chosen = _with_gravity([Part(one, head) for one, head in found if _measures(one, head)], members)
        if not chosen:
            raise RecordingFormatError(say("zip.no_table", names=[one.name for one in members][:9]))
        labels = _labels([one.member.stem for one in chosen])
        self.parts = [replace(one, label=label) for one, label in zip(chosen, labels, strict=True)]
        self._counters: set[str] = set()

    @cached_property
    def head(self) -> TableHead:
        """All of them as one table, row by row: as far as names and numbers are looked at."""
        heads = [one.head for one in self.parts]
        bodies = [[split_line(line, head.delimiter) for line in head.body[:-1]] for head in heads]
        columns = tuple(one.called(name) for one in self.parts for name in one.head.columns)
        lines = []
        for k in range(max(map(len, bodies))):
            text = io.StringIO()
            row: list[str] = []
            for head, body in zip(heads, bodies, strict=True):
                width = len(head.columns)
                row += (body[k][:width] if k < len(body) else []) + [""] * (
                    width - min(width, len(body[k]) if k < len(body) else 0)
                )
            csv.writer(text, lineterminator="").writerow(row)
            lines.append(text.getvalue())
        # A last line is left out of what is looked at, as one that may be cut.
        return TableHead(",", columns, (), 0, (), "utf-8", (*lines, ""))

    def guess(
        self, name: str = "", pipeline: PipelineName | None = None, rate_hz: float | None = None
    ) -> Guess:
        """Guess the mapping; see `guess_of_head`. The clock of each signal is that of its table."""
        found = guess_of_head(self.head, name, pipeline, rate_hz)
        used = [
            part for part in self.parts if any(part is self._part(one) for one in found.mapping["signals"])
        ]
        clocks = [self._clock(part, rate_hz) for part in used]
        notes = [one for one in found.notes if one.code not in _OF_TIME]
        missing = [one for one in found.missing if one.code not in _OF_TIME]
        for part, clock in zip(used, clocks, strict=True):
            notes += _said_of(part, clock.notes)
            missing += _said_of(part, clock.missing)
        kinds = {(clock.unit, clock.rate_hz) for clock in clocks}
        if len(kinds) > 1 and not missing:
            missing.append(say("zip.clocks_differ", names=[part.member.name for part in used]))
        if len(used) > 1 and not missing:
            notes.append(self._said_of_clocks(used, clocks))
        mapping = {**found.mapping, "delimiter": None}
        if clocks:
            first = clocks[0]
            own = {
                id(part): part.called(clock.column)
                for part, clock in zip(used, clocks, strict=True)
                if clock.column
            }
            signals = [{**one, "time_column": own.get(id(self._part(one)))} for one in mapping["signals"]]
            mapping |= {"signals": signals, "time_unit": first.unit, "rate_hz": first.rate_hz}
            mapping["time_column"] = own.get(id(used[0]))
        return replace(
            found, mapping=mapping, notes=tuple(dict.fromkeys(notes)), missing=tuple(dict.fromkeys(missing))
        )

    def read(
        self, wanted: list[str], text: Collection[str], time_unit: str, clocks: Collection[str]
    ) -> tuple[dict[str, NDArray[Any]], tuple[Sentence, ...]]:
        """Read columns of any of the tables, shape (N,): those of shorter tables end with nothing.

        Parameters
        ----------
        wanted : list of str
            As `head` has them.
        text : collection of str
            Those that are read as they are written.
        time_unit : str
            Of the clocks; see `CsvMapping`.
        """
        found: dict[str, NDArray[Any]] = {}
        notes: list[Sentence] = []
        for part in self.parts:
            mine = {part.called(name): name for name in part.head.columns if part.called(name) in wanted}
            if not mine:
                continue
            plain = {name for called, name in mine.items() if called in text}
            with reading():
                table, said = read_table(cast(Path, part.member), list(mine.values()), part.head, plain)
            notes += _said_of(part, said)
            found |= {called: table[name] for called, name in mine.items()}
        for clock in clocks:
            if clock in found and self._pauses is not None and time_unit == "s":
                found[clock] = self._pauses.put_back(found[clock])
        if time_unit == COUNT or all("fine" in words_of(clock) for clock in clocks):
            found |= _one_counter({clock: found[clock] for clock in clocks if clock in found})
        if self._pauses is not None and self._pauses.count:
            notes.append(say("zip.pauses", count=self._pauses.count))
        longest = max(map(len, found.values()), default=0)
        return {name: _padded(values, longest) for name, values in found.items()}, tuple(notes)

    def _part(self, signal: dict[str, Any]) -> Part | None:
        first = str(signal["columns"][0])
        return next((p for p in self.parts if first in map(p.called, p.head.columns)), None)

    def _clock(self, part: Part, rate_hz: float | None) -> TimeGuess:
        """Return the clock of one table; what all devices share before what each began to count by itself."""
        signals = {name for name in part.head.columns if named(part.called(name)) is not None}
        body = Body(part.head)
        fine = [c for c in part.head.columns if "fine" in words_of(c) and np.isfinite(body.numbers(c)).any()]
        others = {c for c in part.head.columns if fine and "counter" in words_of(c)}
        return guess_time(part.head, body, signals | others, rate_hz)

    def _said_of_clocks(self, used: list[Part], clocks: list[TimeGuess]) -> Sentence:
        """Say by what several tables are joined, and what was assumed of it."""
        names = [part.member.name for part in used]
        if any(clock.column is None for clock in clocks):
            return say("zip.joined_by_rows", names=names)
        starts = [
            float(Body(part.head).times(str(clock.column), clock.unit if clock.unit != COUNT else "s")[0])
            for part, clock in zip(used, clocks, strict=True)
        ]
        is_own = len(set(starts)) == 1 and starts[0] in (0.0, 1.0)
        return say("zip.joined_from_start", names=names) if is_own else say("zip.joined", names=names)


def _head_of(member: Member) -> TableHead | None:
    """Return the head of a table with numbers; None for anything else."""
    if member.ending not in TEXT:
        return None
    try:
        head = head_of(start_of(cast(Path, member)))
    except RecordingFormatError:
        return None
    return head if any(is_number(field) for row in head.rows[:1] for field in row if field) else None


def _measures(member: Member, head: TableHead) -> bool:
    """Whether a table has a quantity of a sensor, by its names or its own."""
    return any(
        (one := named(f"{member.stem} {column}")) is not None and one.quantity for column in head.columns
    )


def _with_gravity(parts: list[Part], members: list[Member]) -> list[Part]:
    """Leave out what apps for phones write twice: accelerations without gravity, and readings before calibration.

    Raises
    ------
    RecordingFormatError
        The only acceleration has no gravity.
    """
    words = {part.member.name: words_of(part.member.stem) for part in parts}
    plain = {name for name, one in words.items() if "uncalibrated" not in one}
    if plain:
        parts = [part for part in parts if part.member.name in plain]
    if not any(_GRAVITY in words_of(member.stem) for member in members):
        return parts
    bare = [p for p in parts if re.search(r"(^|/)acceleromet(er|re)$", p.member.stem, re.IGNORECASE)]
    if bare and not any("total" in words[part.member.name] for part in parts):
        raise RecordingFormatError(say("zip.no_gravity", names=[part.member.name for part in bare]))
    return [part for part in parts if part not in bare]


def _labels(stems: list[str]) -> list[str]:
    """Return what tells the names of several files apart."""
    if len(stems) == 1:
        return [""]
    split = [re.split(r"[/\s_]+", stem) for stem in stems]
    # All may be of one side: that is said of each.
    sides = [word for word in dict.fromkeys(split[0]) if side_of(word) and all(word in one for one in split)]
    while all(len(one) > 1 for one in split) and len({one[0] for one in split}) == 1:
        split = [one[1:] for one in split]
    while all(len(one) > 1 for one in split) and len({one[-1] for one in split}) == 1:
        split = [one[:-1] for one in split]
    found = [" ".join([*one, *(word for word in sides if word not in one)]) for one in split]
    return found if len(set(found)) == len(found) else [f"{k} {label}" for k, label in enumerate(found, 1)]


def _said_of(part: Part, said: tuple[Sentence, ...]) -> list[Sentence]:
    """Return what is said of one of several tables with its name."""
    return [one if not part.label else say("zip.of_table", name=part.member.name, said=one) for one in said]


def _one_counter(clocks: dict[str, Float]) -> dict[str, Float]:
    """Let counters of several devices go on alike where they begin again: all name one moment by one number."""
    going = {}
    for name, values in clocks.items():
        there = np.isfinite(values)
        going[name] = values.astype(np.float64, copy=True)
        going[name][there] = unwrapped(values[there])[0]
    highest = max(
        (float(np.nanmax(values)) for values in clocks.values() if np.isfinite(values).any()), default=0.0
    )
    wrap = next((one for one in _COUNTER_WRAPS if highest < one), None)
    starts = {
        name: float(values[np.isfinite(values)][0])
        for name, values in going.items()
        if np.isfinite(values).any()
    }
    for name, start in starts.items():
        behind = next(iter(starts.values())) - start
        if wrap is not None and abs(behind) > 0.5 * wrap:
            going[name] += np.rint(behind / wrap) * wrap
    return going


def _padded(values: NDArray[Any], length: int) -> NDArray[Any]:
    if len(values) == length:
        return values
    nothing = np.full(length - len(values), "" if values.dtype == object else np.nan, dtype=values.dtype)
    return np.concatenate([values, nothing])
