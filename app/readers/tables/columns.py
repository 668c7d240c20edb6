"""CSV with a declared mapping: which columns are what, in which unit. Checked in words."""

import math
from collections import Counter
from collections.abc import Hashable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from app.errors import RecordingFormatError
from app.readers.moments import as_metadata
from app.readers.tables.body import MAX_VALUES, read_table
from app.readers.tables.clocks.counter import COUNT
from app.readers.tables.clocks.of_day import CLOCK, seconds_of_clock
from app.readers.tables.clocks.stamps import HIGHEST_HZ, LOWEST_HZ, UNIT_FACTORS, nominal_rate
from app.readers.tables.guess import SINGLE
from app.readers.tables.head import TableHead, head_of_file
from app.readers.tables.schemas import CsvColumn, CsvMapping
from app.readers.tables.streams import Clock, Stream, begun, joined, share_rows, stream_of
from app.readers.units import (
    TO_SI,
    UNITS,
    check_accelerometer,
    check_gyroscope,
    check_magnetometer,
    is_earths,
)
from app.sentences import Sentence, say
from estimators.recording import Float, Recording, SensorSignals

if TYPE_CHECKING:
    from app.readers.tables.several import Tables

_COUNTED_APART: Final = 20.0
"""In samples: counters farther apart than that in rows that stand together are not of one moment."""
_PAUSE_S: Final = 5.0
"""Without any sample for longer than this a recording paused, and its headings begin anew."""


def read_csv(path: Path, mapping: CsvMapping, tables: "Tables | None" = None) -> Recording:
    """Read a CSV file as declared.

    Parameters
    ----------
    path : Path
    mapping : CsvMapping
    tables : Tables, optional
        Several tables of one recording, of which the file is a zip.

    Raises
    ------
    RecordingFormatError
        A column is missing or not numeric, a unit cannot be right, time does not advance, or it is too long.
    """
    by_placement = checked_mapping(mapping)
    head = head_of_file(path, mapping.delimiter) if tables is None else tables.head
    wanted, text = columns_of(mapping, head)
    table, said_of_rows = (
        read_table(path, wanted, head, text)
        if tables is None
        else tables.read(wanted, text, mapping.time_unit, _clocks(mapping))
    )
    notes = [*said_of_rows, *with_times(mapping, table, text)]
    recorded = _first_moment(mapping, table)
    reader = TableSensors(mapping, table, head, is_one_table=tables is None)
    sensors = {placement: reader.sensor(placement, by_placement[placement]) for placement in by_placement}
    rate_hz = mapping.rate_hz or max(nominal_rate(one.time_s) for one in sensors.values())
    return Recording(
        reader.together(sensors, 1.0 / rate_hz),
        rate_hz,
        origin="CSV file",
        metadata={"format": "csv", **recorded},
        notes=tuple(dict.fromkeys((*notes, *reader.notes))),
    )


def columns_of(mapping: CsvMapping, head: TableHead) -> tuple[list[str], set[str]]:
    """Return the columns that a mapping needs, each once, and those of them that are read as they are written.

    Parameters
    ----------
    mapping : CsvMapping
    head : TableHead

    Raises
    ------
    RecordingFormatError
        A column would be both.
    """
    text = {column for signal in mapping.signals for column in signal.rows}
    clocks = _clocks(mapping)
    if mapping.time_unit == CLOCK:
        text |= clocks
    wanted = [_source(name, head)[0] for signal in mapping.signals for name in signal.columns]
    if both := sorted(text & set(wanted)):
        raise RecordingFormatError(say("mapping.text_and_signal", columns=both))
    return list(dict.fromkeys([*wanted, *sorted(clocks | text)])), text


def with_times(mapping: CsvMapping, table: dict[str, Any], text: set[str]) -> list[Sentence]:
    """Make seconds of times of day, in place, and trim other text; returns what was concluded from the times.

    Parameters
    ----------
    mapping : CsvMapping
    table : dict of str to ndarray
    text : set of str
        Columns as they are written, of `columns_of`.
    """
    notes: list[Sentence] = []
    clocks = _clocks(mapping) if mapping.time_unit == CLOCK else set()
    for clock in sorted(clocks):
        table[clock], said = seconds_of_clock(table[clock].tolist())
        notes += said
    for column in text - clocks:
        table[column] = np.array([str(value or "").strip() for value in table[column]], dtype=object)
    return notes


def _clocks(mapping: CsvMapping) -> set[str]:
    return {c for one in mapping.signals if (c := one.time_column or mapping.time_column) is not None}


def _first_moment(mapping: CsvMapping, table: dict[str, Float]) -> dict[str, str]:
    """Return when a table says that it was recorded: its numbers count from 1970. Times of day as text have no zone."""
    if (
        mapping.time_unit in (CLOCK, COUNT)
        or mapping.time_column is None
        or mapping.time_column not in table
        or not len(table[mapping.time_column])
    ):
        return {}
    return as_metadata(float(table[mapping.time_column][0]) * UNIT_FACTORS[mapping.time_unit])


class TableSensors:
    """The sensors of a table, each by the clocks of its signals.

    Parameters
    ----------
    mapping : CsvMapping
    table : dict of str to ndarray, shape (T,)
        What it needs, with times in numbers; see `with_times`.
    head : TableHead

    Raises
    ------
    RecordingFormatError
        There are fewer than two rows.
    """

    def __init__(
        self, mapping: CsvMapping, table: dict[str, Any], head: TableHead, *, is_one_table: bool = True
    ) -> None:
        self._mapping, self._table, self._head = mapping, table, head
        self._count = len(next(iter(table.values())))
        if self._count < 2:
            raise RecordingFormatError(say("file.too_few_rows"))
        self._streams: dict[Hashable, Stream] = {}
        self._bases: dict[str, Stream] = {}
        # Rows of several tables that have the same place are not of one moment.
        self._has_places = is_one_table
        self.notes = _of_nobody(mapping, table)

    def sensor(self, placement: str, quantities: dict[str, CsvColumn]) -> SensorSignals:
        """Return the signals of one sensor, on the stamps of its gyroscope; refused where they cannot be right."""
        signals = self.as_mapped(placement, quantities)
        found = {"gyroscope": signals.gyroscope_radps, "accelerometer": signals.accelerometer_mps2}
        if signals.magnetometer_t is not None:
            found["magnetometer"] = signals.magnetometer_t
        self._check(placement, quantities, found, float(np.median(np.diff(signals.time_s))))
        return replace(signals, magnetometer_t=found.get("magnetometer"))

    def as_mapped(self, placement: str, quantities: dict[str, CsvColumn]) -> SensorSignals:
        """Return the signals of one sensor as the mapping says, whatever they are."""
        values = {name: self._values(one) for name, one in quantities.items()}
        base = quantities["gyroscope"]
        is_one = len({(one.time_column, *sorted(one.rows.items())) for one in quantities.values()}) == 1
        if is_one and all(share_rows(values["gyroscope"], one) for one in values.values()):
            # Of one clock for all, whatever any sensor holds tells a row that was written twice.
            of = quantities.values() if base.rows or base.time_column else self._mapping.signals
            stream = self._stream(base, *of)
            found = {name: one[stream.rows] for name, one in values.items()}
        else:
            stream = self._stream(base, base)
            found = {"gyroscope": values["gyroscope"][stream.rows]}
            for name, one in quantities.items():
                if name != "gyroscope":
                    own = self._stream(one, one)
                    found[name] = joined(own.time_s, values[name][own.rows], stream.time_s)
            self.notes.append(say("table.joined", where=placement))
        self._bases[placement] = stream
        return SensorSignals(
            stream.time_s, found["gyroscope"], found["accelerometer"], found.get("magnetometer")
        )

    def _check(
        self, placement: str, quantities: dict[str, CsvColumn], found: dict[str, Float], step_s: float
    ) -> None:
        """Refuse what cannot be in the unit that was declared, with the names of its columns."""
        for name, one in quantities.items():
            with _naming(one.columns):
                if name == "gyroscope":
                    check_gyroscope(found[name], one.unit, placement)
                elif name == "accelerometer":
                    check_accelerometer(found[name], step_s, one.unit, placement)
                else:
                    found[name] = self._without_iron(placement, found[name])
                    check_magnetometer(found[name], one.unit, placement)

    def _without_iron(self, placement: str, field_t: Float) -> Float:
        """Take iron out of a compass that was never calibrated, where its size cannot be the earth's field."""
        if is_earths(field_t):
            return field_t
        # Most tables need no fit: nobody waits for what does it.
        from estimators.calibration.field.device_iron import device_iron

        iron_t = device_iron(field_t)
        if iron_t is None:
            return field_t
        self.notes.append(say("table.iron", where=placement, field_t=float(np.linalg.norm(iron_t))))
        return np.asarray(field_t - iron_t)

    def together(self, sensors: dict[str, SensorSignals], step_s: float) -> dict[str, SensorSignals]:
        """Return all sensors on one time that begins with the first of them; on even stamps where theirs differ.

        Raises
        ------
        RecordingFormatError
            Two of them were never on at once: their clocks have nothing in common.
        """
        is_counted = self._mapping.time_unit == COUNT and self._has_places
        if is_counted and (moved := begun(self._bases, _COUNTED_APART * step_s)):
            self.notes.append(say("table.counters_apart", where=list(moved)))
            sensors = {
                name: replace(one, time_s=one.time_s + moved.get(name, 0.0)) for name, one in sensors.items()
            }
        first = min(float(one.time_s[0]) for one in sensors.values())
        earliest_end = min(float(one.time_s[-1]) for one in sensors.values())
        latest = max(float(one.time_s[0]) for one in sensors.values())
        if latest > earliest_end:
            raise RecordingFormatError(say("table.clocks_apart", where=list(sensors)))
        sensors = {name: replace(one, time_s=one.time_s - first) for name, one in sensors.items()}
        pauses_s = np.concatenate(
            [gaps[gaps > _PAUSE_S] for one in sensors.values() if (gaps := np.diff(one.time_s)).size]
        )
        if pauses_s.size:
            longest = float(pauses_s.max())
            self.notes.append(
                say("time.pauses", count=math.ceil(pauses_s.size / len(sensors)), longest_s=longest)
            )
        base = next(iter(sensors.values())).time_s
        if all(np.array_equal(base, one.time_s) for one in sensors.values()):
            return sensors
        last_s = max(float(one.time_s[-1]) for one in sensors.values())
        # One of them that was set to another epoch would stretch all over years.
        if last_s / step_s * len(sensors) > MAX_VALUES:
            raise RecordingFormatError(say("table.clocks_apart", where=list(sensors)))
        self.notes.append(say("table.sensors_joined", where=list(sensors)))
        at_s = step_s * np.arange(round(last_s / step_s) + 1, dtype=np.float64)
        return {name: _at(one, at_s) for name, one in sensors.items()}

    def _values(self, signal: CsvColumn) -> Float:
        sources = [_source(name, self._head) for name in signal.columns]
        axes = [sign * self._table[name] for name, sign in sources]
        return np.stack(axes, axis=1) * (signal.sign * TO_SI[signal.unit])

    def _stream(self, signal: CsvColumn, *of: CsvColumn) -> Stream:
        """Return the samples on the clock of a signal; `of`: the signals whose columns tell its rows apart."""
        column = signal.time_column or self._mapping.time_column
        columns = list(dict.fromkeys(_source(name, self._head)[0] for one in of for name in one.columns))
        key = column, tuple(sorted(signal.rows.items())), tuple(columns)
        if key not in self._streams:
            there = np.ones(self._count, dtype=np.bool_)
            for name, value in signal.rows.items():
                there &= self._table[name] == value
            clock = Clock(column, self._mapping.time_unit, self._mapping.rate_hz)
            with _naming([column] if column else columns):
                self._streams[key] = stream_of(self._table, np.flatnonzero(there), clock, columns)
            self.notes += self._streams[key].notes
        return self._streams[key]


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


def _of_nobody(mapping: CsvMapping, table: dict[str, Any]) -> list[Sentence]:
    """Return what is to be said of rows that no sensor of the mapping holds."""
    notes = []
    for column in dict.fromkeys(name for signal in mapping.signals for name in signal.rows):
        wanted = {signal.rows.get(column) for signal in mapping.signals}
        counted = Counter(value for value in table[column].tolist() if value not in wanted)
        if None in wanted or not counted:
            continue
        if empty := counted.pop("", 0):
            notes.append(say("table.rows_of_nobody", count=empty, column=column))
        if counted:
            values = [value[:60] for value, _ in counted.most_common(5)]
            notes.append(say("table.rows_of_none", count=counted.total(), column=column, values=values))
    return notes


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


def _at(signals: SensorSignals, at_s: Float) -> SensorSignals:
    """Return the signals of a sensor at other times."""
    field = signals.magnetometer_t
    return SensorSignals(
        at_s,
        joined(signals.time_s, signals.gyroscope_radps, at_s),
        joined(signals.time_s, signals.accelerometer_mps2, at_s),
        None if field is None else joined(signals.time_s, field, at_s),
    )


def _source(name: str, head: TableHead) -> tuple[str, float]:
    """Return the column that a name of a mapping stands for, and its sign: `-acc_z` turns one, unless it is a name."""
    if name.startswith("-") and name not in head.columns and name[1:].strip() in head.columns:
        return name[1:].strip(), -1.0
    return name, 1.0


__all__ = ["TableSensors", "checked_mapping", "columns_of", "read_csv", "with_times"]
