"""The sensors of a table by its mapping, each on the clocks of its signals, with what its readings can be."""

import math
from collections import Counter
from collections.abc import Hashable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import Any, Final

import numpy as np

from app.errors import RecordingFormatError
from app.readers.tables.body import MAX_VALUES
from app.readers.tables.clocks.counter import COUNT
from app.readers.tables.columns.mapped import source_of
from app.readers.tables.head import TableHead
from app.readers.tables.schemas import CsvColumn, CsvMapping
from app.readers.tables.streams import Clock, Stream, begun, joined, share_rows, stream_of
from app.readers.units import TO_SI, check_accelerometer, check_gyroscope, check_magnetometer, is_earths
from estimators.recording import Float, SensorSignals
from estimators.sentences import Sentence, say

_COUNTED_APART: Final = 20.0
"""In samples: counters farther apart than that in rows that stand together are not of one moment."""
_PAUSE_S: Final = 5.0
"""Without any sample for longer than this a recording paused, and its headings begin again."""


class TableSensors:
    """The sensors of a table, each by the clocks of its signals.

    Parameters
    ----------
    table : dict of str to ndarray, shape (T,)
        What it needs, with times in numbers; see `with_times`.

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
        if signals.magnetometer_t is not None and not np.isfinite(signals.magnetometer_t).all(axis=1).any():
            self.notes.append(self._without_field(placement, quantities["magnetometer"]))
            quantities = {name: one for name, one in quantities.items() if name != "magnetometer"}
            del found["magnetometer"]
        self._check(placement, quantities, found, float(np.median(np.diff(signals.time_s))))
        return replace(signals, magnetometer_t=found.get("magnetometer"))

    def as_mapped(self, placement: str, quantities: dict[str, CsvColumn]) -> SensorSignals:
        """Return the signals of one sensor as the mapping says, whatever they are."""
        values = {name: self._values(one) for name, one in quantities.items()}
        base = quantities["gyroscope"]
        is_one = len({(one.time_column, *sorted(one.rows.items())) for one in quantities.values()}) == 1
        if is_one and all(share_rows(values["gyroscope"], one) for one in values.values()):
            stream = self._stream(base, *self._beside(quantities))
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

    def _beside(self, quantities: dict[str, CsvColumn]) -> list[CsvColumn]:
        """Return the signals in the rows of a sensor: whatever they hold tells a row that was written twice."""
        base = quantities["gyroscope"]
        if base.rows or base.time_column:
            return list(quantities.values())
        return [one for one in self._mapping.signals if share_rows(self._first(base), self._first(one))]

    def _first(self, signal: CsvColumn) -> Float:
        """Return the first axis of a signal, shape (T, 1)."""
        return np.asarray(self._table[source_of(signal.columns[0], self._head)[0]][:, np.newaxis])

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

    def _without_field(self, placement: str, one: CsvColumn) -> Sentence:
        """Return the sentence about a magnetometer of which no sample has three numbers."""
        is_there = np.isfinite(self._values(one))
        empty = [name for axis, name in enumerate(one.columns) if not is_there[:, axis].any()]
        return say("table.no_field", where=placement, columns=empty or list(one.columns))

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
        sources = [source_of(name, self._head) for name in signal.columns]
        axes = [sign * self._table[name] for name, sign in sources]
        return np.stack(axes, axis=1) * (signal.sign * TO_SI[signal.unit])

    def _stream(self, signal: CsvColumn, *of: CsvColumn) -> Stream:
        """Return the samples on the clock of a signal; `of`: the signals whose columns tell its rows apart."""
        column = signal.time_column or self._mapping.time_column
        columns = list(dict.fromkeys(source_of(name, self._head)[0] for one in of for name in one.columns))
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
