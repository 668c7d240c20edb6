"""Assumptions about a table: of the guess, as far as they hold, and what its signals cannot show."""

from collections import Counter
from collections.abc import Callable
from typing import Final

from app.readers.tables.clocks.counter import COUNT
from app.readers.tables.clocks.guess import rate_said
from app.readers.tables.clocks.of_day import CLOCK
from app.readers.tables.guess import SINGLE, Guess
from app.readers.tables.head import TableHead
from app.readers.tables.names import time_unit_of
from app.readers.tables.schemas import GuessedColumn, GuessedMapping
from estimators.sentences import Sentence, say

_OF_TIME: Final = frozenset({"guess.counter", "guess.rows_counted"})
"""Said again of the mapping as it is."""


def assumed(
    head: TableHead, guess: Guess, mapping: GuessedMapping, hemisphere: str | None
) -> tuple[Sentence, ...]:
    """Return what reading a table by a mapping assumes or leaves out.

    Parameters
    ----------
    guess : Guess
        Of the same table; what a person has changed since is no longer said.
    hemisphere : {"north", "south", "unknown"} or None
        Where it is taken to be recorded; None: somebody else decides it.
    """
    found = [
        note
        for note in guess.notes
        if note.code not in _OF_TIME and _STILL.get(note.code, _always)(note, guess, mapping)
    ]
    found = [_left_out(note, mapping) if note.code == "guess.left_out" else note for note in found]
    return (*_together(found, mapping), *_of_time(head, guess, mapping), *_of_signs(mapping, hemisphere))


def _together(notes: list[Sentence], mapping: GuessedMapping) -> list[Sentence]:
    """Say of many sensors once what is the same of each."""
    quantities: dict[tuple[str, ...], str] = {tuple(one.columns): one.quantity for one in mapping.signals}
    alike = Counter(_alike(note, quantities) for note in notes)
    found: dict[tuple[str, ...], Sentence] = {}
    for at, note in enumerate(notes):
        key = _alike(note, quantities)
        many = _OF_MANY.get(note.code)
        if many is None or alike[key] < _MANY:
            found[str(at),] = note
        else:
            found[key] = many(
                alike[key], quantities[tuple(note.parameters["columns"])], note.parameters["unit"]
            )
    return list(found.values())


def _alike(note: Sentence, quantities: dict[tuple[str, ...], str]) -> tuple[str, ...]:
    said = note.parameters
    return note.code, quantities.get(tuple(said.get("columns", ())), ""), str(said.get("unit", ""))


_MANY: Final = 3
_OF_MANY: Final[dict[str, Callable[[int, str, str], Sentence]]] = {
    "guess.unit_from_numbers": lambda count, quantity, unit: say(
        "guess.units_from_numbers", count=count, quantity=quantity, unit=unit
    ),
    "guess.unit_assumed": lambda count, quantity, unit: say(
        "guess.units_assumed", count=count, quantity=quantity, unit=unit
    ),
}


def missing(guess: Guess, mapping: GuessedMapping) -> tuple[Sentence, ...]:
    """Return what of a guess nobody has added yet.

    Parameters
    ----------
    mapping : GuessedMapping
        As a person has completed it.
    """
    return tuple(one for one in guess.missing if _MISSING.get(one.code, _always)(one, guess, mapping))


def _of_time(head: TableHead, guess: Guess, mapping: GuessedMapping) -> list[Sentence]:
    clock, rate = mapping.time_column, mapping.rate_hz
    has_own = mapping.signals and all(one.time_column for one in mapping.signals)
    if has_own or (clock is not None and mapping.time_unit != COUNT):
        is_guessed = clock == guess.mapping["time_column"] and mapping.time_unit == guess.mapping["time_unit"]
        if clock is None or not is_guessed or mapping.time_unit == CLOCK or time_unit_of(clock):
            return []
        return [say("guess.time_unit_assumed", column=clock, unit=mapping.time_unit)]
    if rate is None or not mapping.signals:
        return []
    found = [say("guess.rate_of_line", rate_hz=rate)] if rate_said(head.preamble) == rate else []
    if clock is None:
        return [*found, say("guess.rows_counted", rate_hz=rate)]
    return [*found, say("guess.counter", column=clock, rate_hz=rate)]


def _of_signs(mapping: GuessedMapping, hemisphere: str | None) -> list[Sentence]:
    found = [
        say("guess.turned", where=place_of(one), quantity=one.quantity)
        for one in mapping.signals
        if one.sign == -1
    ]
    quantities = {one.quantity for one in mapping.signals}
    if "magnetometer" in quantities:
        return [*found, _HEMISPHERES[hemisphere]()] if hemisphere else found
    return [*found, say("guess.sign_assumed")] if "accelerometer" in quantities else found


_HEMISPHERES: Final[dict[str, Callable[[], Sentence]]] = {
    "north": lambda: say("guess.hemisphere_north"),
    "south": lambda: say("guess.hemisphere_south"),
    "unknown": lambda: say("guess.hemisphere_unknown"),
}


def _always(_note: Sentence, _guess: Guess, _mapping: GuessedMapping) -> bool:
    return True


def _has_unit(note: Sentence, _: Guess, mapping: GuessedMapping) -> bool:
    said = note.parameters
    return any(one.columns == said["columns"] and one.unit == said["unit"] for one in mapping.signals)


def _has_clock(_note: Sentence, guess: Guess, mapping: GuessedMapping) -> bool:
    column: str | None = guess.mapping["time_column"]
    return mapping.time_column == column


def _has_own_clocks(note: Sentence, _: Guess, mapping: GuessedMapping) -> bool:
    columns: list[str] = note.parameters["columns"]
    return sorted({one.time_column or "" for one in mapping.signals}) == columns


def _has_rows(note: Sentence, _: Guess, mapping: GuessedMapping) -> bool:
    return any(note.parameters["column"] in one.rows for one in mapping.signals)


def _is_right_foot(_note: Sentence, _guess: Guess, mapping: GuessedMapping) -> bool:
    return any(one.placement == "foot_right" for one in mapping.signals)


def _leaves_any(note: Sentence, _: Guess, mapping: GuessedMapping) -> bool:
    return bool(_unused(note.parameters["columns"], mapping))


_STILL: Final[dict[str, Callable[[Sentence, Guess, GuessedMapping], bool]]] = {
    "guess.unit_from_numbers": _has_unit,
    "guess.unit_assumed": _has_unit,
    "guess.unit_of_others": _has_unit,
    "guess.rate_left": _has_clock,
    "guess.own_clocks": _has_own_clocks,
    "guess.devices": _has_rows,
    "guess.foot_side": _is_right_foot,
    "guess.left_out": _leaves_any,
}


def _lacks_time(_note: Sentence, _guess: Guess, mapping: GuessedMapping) -> bool:
    return (mapping.time_column is None or mapping.time_unit == COUNT) and mapping.rate_hz is None


def _lacks_place(note: Sentence, _: Guess, mapping: GuessedMapping) -> bool:
    return any(
        one.placement is None and set(one.columns) & set(note.parameters["columns"])
        for one in mapping.signals
    )


def _lacks_unit(note: Sentence, _: Guess, mapping: GuessedMapping) -> bool:
    return any(one.unit is None and one.columns == note.parameters["columns"] for one in mapping.signals)


def _lacks_signals(_note: Sentence, _guess: Guess, mapping: GuessedMapping) -> bool:
    return not mapping.signals


_MISSING: Final[dict[str, Callable[[Sentence, Guess, GuessedMapping], bool]]] = {
    "guess.no_time": _lacks_time,
    "guess.counter_needs_rate": _lacks_time,
    "guess.no_place": _lacks_place,
    "guess.no_unit": _lacks_unit,
    **dict.fromkeys(
        (
            "guess.no_names",
            "guess.no_gravity",
            "guess.not_whole",
            "guess.orientation_only",
            "guess.no_signal",
        ),
        _lacks_signals,
    ),
}


def _left_out(note: Sentence, mapping: GuessedMapping) -> Sentence:
    return say("guess.left_out", columns=_unused(note.parameters["columns"], mapping))


def _unused(columns: list[str], mapping: GuessedMapping) -> list[str]:
    used = {name for one in mapping.signals for name in one.columns}
    return [name for name in columns if name not in used and f"-{name}" not in used]


def place_of(signal: GuessedColumn) -> str:
    """Return where a sensor is worn, or what it is called; as the readers name it."""
    return signal.placement or signal.sensor or SINGLE
