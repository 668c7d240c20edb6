"""A table as it is taken: its sensors with their first seconds and a sentence each, and what that assumes."""

import re
from dataclasses import dataclass
from itertools import takewhile
from typing import Final

from pydantic import ValidationError

from app.readers.tables.clocks.counter import COUNT
from app.readers.tables.clocks.of_day import CLOCK
from app.readers.tables.guess import Guess
from app.readers.tables.head import TableHead
from app.readers.tables.look.assumptions import assumed, missing, place_of
from app.readers.tables.look.seconds import FirstSeconds, first_seconds
from app.readers.tables.names import time_unit_of
from app.readers.tables.schemas import CsvMapping, GuessedColumn, GuessedMapping
from estimators.recording import SensorSignals
from estimators.sentences import Sentence, say

_ORDER: Final = ("gyroscope", "accelerometer", "magnetometer")

_UNIT: Final = re.compile(r"\s*(\([^()]*\)|\[[^\[\]]*\])$")
"""In brackets behind a name: the sentence says the unit that is taken."""
_LONG: Final = 4
"""Letters that the names of three columns share, from which on they are written once."""


@dataclass(frozen=True)
class SensorLook:
    """A sensor as it is taken.

    Attributes
    ----------
    where : str
        Where it is worn, or what it is called.
    sentence : Sentence
        Its columns, units and clock.
    signals : SensorSignals or None
        Its first seconds; None while it is not mapped whole, or has no sample there.
    """

    where: str
    sentence: Sentence
    signals: SensorSignals | None


@dataclass(frozen=True)
class Look:
    """A table as it is taken.

    Attributes
    ----------
    assumed : tuple of Sentence
        What was assumed or left out.
    missing : tuple of Sentence
        What a person must add.
    doubts : tuple of Sentence
        Why it cannot be read so, or cannot be right so, by its first seconds.
    """

    sensors: tuple[SensorLook, ...]
    assumed: tuple[Sentence, ...]
    missing: tuple[Sentence, ...]
    doubts: tuple[Sentence, ...]


def look_at(
    head: TableHead, guess: Guess, mapping: GuessedMapping | None = None, hemisphere: str | None = None
) -> Look:
    """Say what a table is taken for.

    Parameters
    ----------
    head, guess : TableHead, Guess
        Of its beginning.
    mapping : GuessedMapping, optional
        As a person has changed it; by default the guess.
    hemisphere : {"north", "south", "unknown"}, optional
        Where it is taken to be recorded; nothing is said of that where somebody else decides it.
    """
    taken = mapping or GuessedMapping.model_validate(guess.mapping)
    signals: dict[str, list[GuessedColumn]] = {}
    for one in taken.signals:
        signals.setdefault(place_of(one), []).append(one)
    lacking = missing(guess, taken)
    seen = _seen(head, taken, signals)
    return Look(
        tuple(
            SensorLook(
                where, _sentence(where, of_it, taken, seen.rates_hz.get(where)), seen.sensors.get(where)
            )
            for where, of_it in signals.items()
        ),
        assumed(head, guess, taken, hemisphere),
        lacking,
        seen.doubts,
    )


def _seen(head: TableHead, mapping: GuessedMapping, signals: dict[str, list[GuessedColumn]]) -> FirstSeconds:
    """Read the sensors that are mapped whole: what the others lack is said where it is asked for."""
    whole = [
        one
        for of_it in signals.values()
        if {"gyroscope", "accelerometer"} <= {one.quantity for one in of_it}
        and all(one.unit and all(name.lstrip("-") for name in one.columns) for one in of_it)
        for one in of_it
    ]
    has_clock = mapping.time_column is not None or all(one.time_column for one in whole)
    if not whole or (mapping.rate_hz is None and (not has_clock or mapping.time_unit == COUNT)):
        return FirstSeconds({}, {})
    given = {**mapping.model_dump(), "signals": [one.model_dump() for one in whole]}
    try:
        return first_seconds(head, CsvMapping.model_validate(given))
    except ValidationError:
        return FirstSeconds({}, {})


def _sentence(
    where: str, signals: list[GuessedColumn], mapping: GuessedMapping, rate_hz: float | None
) -> Sentence:
    """Say columns, units and clock of a sensor."""
    parts = [_part(one) for one in sorted(signals, key=lambda one: _ORDER.index(one.quantity))]
    gyroscope = next((one for one in signals if one.quantity == "gyroscope"), signals[0])
    column = gyroscope.time_column or mapping.time_column
    if column is None:
        if mapping.rate_hz is None:
            return say("guess.sensor", where=where, signals=parts)
        return say("guess.sensor_of_rows", where=where, signals=parts, rate_hz=mapping.rate_hz)
    if rate_hz is None:
        return say("guess.sensor_unread", where=where, signals=parts, column=column)
    if mapping.time_unit == COUNT:
        return say("guess.sensor_counted", where=where, signals=parts, rate_hz=rate_hz, column=column)
    if mapping.time_unit == CLOCK:
        return say("guess.sensor_of_day", where=where, signals=parts, rate_hz=rate_hz, column=column)
    if time_unit_of(column) == mapping.time_unit:
        return say("guess.sensor_stamped", where=where, signals=parts, rate_hz=rate_hz, column=column)
    return say(
        "guess.sensor_stamped_in",
        where=where,
        signals=parts,
        rate_hz=rate_hz,
        column=column,
        unit=mapping.time_unit,
    )


def _part(signal: GuessedColumn) -> Sentence:
    columns = _short(signal.columns)
    rows = ", ".join(f"{name} = {value}" for name, value in signal.rows.items())
    if not signal.unit:
        return say("guess.signal_without_unit", quantity=signal.quantity, columns=columns)
    if rows:
        return say(
            "guess.signal_of_rows", quantity=signal.quantity, unit=signal.unit, columns=columns, rows=rows
        )
    return say("guess.signal", quantity=signal.quantity, unit=signal.unit, columns=columns)


def _short(columns: list[str]) -> str:
    """Return the names of three columns without units, a long beginning that they share written once."""
    names = [_UNIT.sub("", f"−{name[1:]}" if name.startswith("-") else name) for name in columns]
    start, end = _shared(names), _shared([name[::-1] for name in names])
    if start < _LONG:
        return ", ".join(names)
    # A name that ends where the others go on has no end of its own.
    end = min(end, *(len(name) - start for name in names))
    return ", ".join([names[0], *(f"…{name[start : len(name) - end]}" for name in names[1:])])


def _shared(names: list[str]) -> int:
    """Return how many letters names share from their beginning."""
    return sum(1 for _ in takewhile(lambda letters: len(set(letters)) == 1, zip(*names, strict=False)))
