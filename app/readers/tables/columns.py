"""CSV with a declared mapping: which columns are what, in which unit. Checked in words."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from app.errors import RecordingFormatError
from app.readers.moments import as_metadata
from app.readers.tables.body import read_table
from app.readers.tables.clock import CLOCK, seconds_of_clock
from app.readers.tables.counter import COUNT, seconds_of_counter
from app.readers.tables.guess import SINGLE
from app.readers.tables.head import TableHead, head_of_file
from app.readers.tables.schemas import CsvColumn, CsvMapping
from app.readers.tables.time import HIGHEST_HZ, LOWEST_HZ, UNIT_FACTORS, check_unit, nominal_rate
from app.readers.tables.time_mended import mended, usual_interval
from app.readers.units import (
    TO_SI,
    UNITS,
    check_accelerometer,
    check_gyroscope,
    check_magnetometer,
)
from app.sentences import Sentence, say
from estimators.recording import Float, Recording, SensorSignals


def read_csv(path: Path, mapping: CsvMapping) -> Recording:
    """Read a CSV file as declared.

    Parameters
    ----------
    path : Path
    mapping : CsvMapping

    Raises
    ------
    RecordingFormatError
        A column is missing or not numeric, a unit cannot be right, time does not advance, or it is too long.
    """
    by_placement = _check_mapping(mapping)
    head = head_of_file(path, mapping.delimiter)
    wanted = [_source(name, head)[0] for signal in mapping.signals for name in signal.columns]
    if mapping.time_column is not None:
        wanted.append(mapping.time_column)
    clock = mapping.time_column if mapping.time_unit == CLOCK else None
    table, said_of_rows = read_table(path, list(dict.fromkeys(wanted)), head, clock)
    notes = list(said_of_rows)
    if clock is not None:
        table[clock], said = seconds_of_clock(table[clock].tolist())
        notes += said
    recorded = _first_moment(mapping, table)
    rows = len(next(iter(table.values())))
    if rows < 2:
        raise RecordingFormatError(say("file.too_few_rows"))
    if mapping.time_column is not None:
        with _naming([mapping.time_column]):
            table, time_s, mended_notes = _on_time(table, mapping.time_column, mapping)
        notes += mended_notes
        rate_hz = mapping.rate_hz or nominal_rate(time_s)
    else:
        assert mapping.rate_hz is not None
        rate_hz = mapping.rate_hz
        time_s = np.arange(rows) / rate_hz
    sensors = {
        placement: _sensor(placement, quantities, table, time_s, head)
        for placement, quantities in by_placement.items()
    }
    return Recording(
        sensors, rate_hz, origin="CSV file", metadata={"format": "csv", **recorded}, notes=tuple(notes)
    )


def _first_moment(mapping: CsvMapping, table: dict[str, Float]) -> dict[str, str]:
    """Return when a table says that it was recorded: its numbers count from 1970. Times of day as text have no zone."""
    if (
        mapping.time_unit in (CLOCK, COUNT)
        or mapping.time_column is None
        or not len(table[mapping.time_column])
    ):
        return {}
    return as_metadata(float(table[mapping.time_column][0]) * UNIT_FACTORS[mapping.time_unit])


def _on_time(
    table: dict[str, Float], column: str, mapping: CsvMapping
) -> tuple[dict[str, Float], Float, list[Sentence]]:
    """Return the rows that have a place in time, that time, and what was mended."""
    others = np.stack([values for name, values in table.items() if name != column], axis=1)
    stamps, unit, notes = table[column], mapping.time_unit, list[Sentence]()
    if unit == COUNT:
        assert mapping.rate_hz is not None
        stamps, notes = seconds_of_counter(stamps, mapping.rate_hz)
    if unit in (COUNT, CLOCK):
        unit = "s"
    found = mended(stamps, UNIT_FACTORS[unit], others)
    if found.time_s.size < 2:
        raise RecordingFormatError(say("file.too_few_rows"))
    check_unit(usual_interval(found.time_s) / UNIT_FACTORS[unit], unit)
    table = {name: values[found.rows] for name, values in table.items()}
    return table, found.time_s, [*notes, *found.notes]


def _check_mapping(mapping: CsvMapping) -> dict[str, dict[str, CsvColumn]]:
    if mapping.rate_hz is None and (mapping.time_column is None or mapping.time_unit == COUNT):
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


@contextmanager
def _naming(columns: Sequence[str]) -> Iterator[None]:
    """Add the columns to what is said against their content."""
    try:
        yield
    except RecordingFormatError as error:
        raise type(error)(
            say("table.in_columns", columns=list(columns), reason=error.message),
            **{**error.details, "columns": list(columns)},
        ) from error


def _source(name: str, head: TableHead) -> tuple[str, float]:
    """Return the column that a name of a mapping stands for, and its sign: `-acc_z` turns one, unless it is a name."""
    if name.startswith("-") and name not in head.columns and name[1:].strip() in head.columns:
        return name[1:].strip(), -1.0
    return name, 1.0


def _sensor(
    placement: str, quantities: dict[str, CsvColumn], table: dict[str, Float], time_s: Float, head: TableHead
) -> SensorSignals:
    def values(quantity: str) -> Float | None:
        signal = quantities.get(quantity)
        if signal is None:
            return None
        sources = [_source(name, head) for name in signal.columns]
        axes = [sign * table[name] for name, sign in sources]
        return np.stack(axes, axis=1) * (signal.sign * TO_SI[signal.unit])

    gyroscope, accelerometer, field = values("gyroscope"), values("accelerometer"), values("magnetometer")
    assert gyroscope is not None
    assert accelerometer is not None
    with _naming(quantities["gyroscope"].columns):
        check_gyroscope(gyroscope, quantities["gyroscope"].unit, placement)
    with _naming(quantities["accelerometer"].columns):
        step_s = float(np.median(np.diff(time_s)))
        check_accelerometer(accelerometer, step_s, quantities["accelerometer"].unit, placement)
    if field is not None:
        with _naming(quantities["magnetometer"].columns):
            check_magnetometer(field, quantities["magnetometer"].unit, placement)
    return SensorSignals(time_s, gyroscope, accelerometer, field)


__all__ = ["read_csv"]
