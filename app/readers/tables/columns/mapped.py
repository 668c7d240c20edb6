"""The columns that a mapping needs of a table, as numbers or as they are written. Checked in words."""

from typing import Any

import numpy as np

from app.errors import RecordingFormatError
from app.readers.tables.clocks.counter import COUNT
from app.readers.tables.clocks.of_day import CLOCK, seconds_of_clock
from app.readers.tables.clocks.stamps import HIGHEST_HZ, LOWEST_HZ
from app.readers.tables.guess import SINGLE
from app.readers.tables.head import TableHead
from app.readers.tables.schemas import CsvColumn, CsvMapping
from app.readers.units import UNITS
from estimators.sentences import Sentence, say


def checked_mapping(mapping: CsvMapping) -> dict[str, dict[str, CsvColumn]]:
    """Return the signals of each sensor by quantity.

    Raises
    ------
    RecordingFormatError
        It is no mapping of whole sensors with a time; says what is missing.
    """
    has_clock = mapping.time_column is not None or all(one.time_column for one in mapping.signals)
    if mapping.rate_hz is None and (not has_clock or mapping.time_unit == COUNT):
        raise RecordingFormatError(say("mapping.no_time"))
    if mapping.rate_hz is not None and not LOWEST_HZ <= mapping.rate_hz <= HIGHEST_HZ:
        raise RecordingFormatError(
            say("mapping.rate", rate_hz=mapping.rate_hz, lowest_hz=LOWEST_HZ, highest_hz=HIGHEST_HZ)
        )
    found: dict[str, dict[str, CsvColumn]] = {}
    for signal in mapping.signals:
        where = signal.placement or signal.sensor or SINGLE
        if signal.unit not in UNITS[signal.quantity]:
            raise RecordingFormatError(
                say(
                    "mapping.unit",
                    unit=signal.unit,
                    quantity=signal.quantity,
                    columns=list(signal.columns),
                    units=list(UNITS[signal.quantity]),
                ),
                sensor=where,
            )
        quantities = found.setdefault(where, {})
        if signal.quantity in quantities:
            raise RecordingFormatError(
                say(
                    "mapping.twice",
                    where=where,
                    quantity=signal.quantity,
                    first=list(quantities[signal.quantity].columns),
                    second=list(signal.columns),
                ),
                sensor=where,
            )
        quantities[signal.quantity] = signal
    if not found:
        raise RecordingFormatError(say("mapping.no_sensor"))
    for placement, quantities in found.items():
        for needed in ("gyroscope", "accelerometer"):
            if needed not in quantities:
                raise RecordingFormatError(
                    say("mapping.needed", where=placement, quantity=needed),
                    sensor=placement,
                )
    with_field = [p for p, quantities in found.items() if "magnetometer" in quantities]
    if with_field and len(with_field) < len(found):
        without = [p for p in found if p not in with_field]
        raise RecordingFormatError(say("mapping.magnetometers", places=without))
    return found


def columns_of(mapping: CsvMapping, head: TableHead) -> tuple[list[str], set[str]]:
    """Return the columns that a mapping needs, each once, and those of them that are read as they are written.

    Raises
    ------
    RecordingFormatError
        A column would be both.
    """
    text = {column for signal in mapping.signals for column in signal.rows}
    clocks = clocks_of(mapping)
    if mapping.time_unit == CLOCK:
        text |= clocks
    wanted = [source_of(name, head)[0] for signal in mapping.signals for name in signal.columns]
    if both := sorted(text & set(wanted)):
        raise RecordingFormatError(say("mapping.text_and_signal", columns=both))
    return list(dict.fromkeys([*wanted, *sorted(clocks | text)])), text


def with_times(mapping: CsvMapping, table: dict[str, Any], text: set[str]) -> list[Sentence]:
    """Make seconds of times of day, in place, and trim other text; returns what was concluded from the times.

    Parameters
    ----------
    text : set of str
        Columns as they are written, of `columns_of`.
    """
    notes: list[Sentence] = []
    clocks = clocks_of(mapping) if mapping.time_unit == CLOCK else set()
    for clock in sorted(clocks):
        table[clock], said = seconds_of_clock(table[clock].tolist())
        notes += said
    for column in text - clocks:
        table[column] = np.array([str(value or "").strip() for value in table[column]], dtype=object)
    return notes


def clocks_of(mapping: CsvMapping) -> set[str]:
    """Return the time columns that a mapping names."""
    return {c for one in mapping.signals if (c := one.time_column or mapping.time_column) is not None}


def source_of(name: str, head: TableHead) -> tuple[str, float]:
    """Return the column that a name of a mapping stands for, and its sign: `-acc_z` turns one, unless it is a name."""
    if name.startswith("-") and name not in head.columns and name[1:].strip() in head.columns:
        return name[1:].strip(), -1.0
    return name, 1.0
