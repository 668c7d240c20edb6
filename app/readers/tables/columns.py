"""CSV with a declared mapping: which columns are what, in which unit. Parsed in blocks, checked in words."""

import io
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from app.errors import RecordingFormatError
from app.readers.moments import as_metadata
from app.readers.tables.clock import CLOCK, seconds_of_clock
from app.readers.tables.guess import SINGLE
from app.readers.tables.head import TableHead, head_of_file
from app.readers.tables.schemas import CsvColumn, CsvMapping
from app.readers.tables.text import opened
from app.readers.tables.time import HIGHEST_HZ, LOWEST_HZ, UNIT_FACTORS, check_unit, nominal_rate
from app.readers.tables.time_mended import mended
from app.readers.units import (
    TO_SI,
    UNITS,
    check_accelerometer,
    check_gyroscope,
    check_magnetometer,
)
from app.sentences import Sentence, say
from estimators.recording import Float, Recording, SensorSignals

MAX_VALUES: Final = 60_000_000
"""About an hour of 17 nine-axis sensors at 100 Hz; more is to be split."""
MAX_LINE_BYTES: Final = 1 << 20
_BLOCK_BYTES: Final = 4 << 20
_MOST_RAGGED: Final = 0.1
"""A larger share of rows with another number of columns is no table."""
_NOTHING: Final = ["", "NaN", "nan", "NAN", "NA", "N/A", "n/a", "#N/A", "null", "NULL", "None", "-", "--"]
"""What stands where no number does."""


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
    wanted = [column for signal in mapping.signals for column in signal.columns]
    if mapping.time_column is not None:
        wanted.append(mapping.time_column)
    head = head_of_file(path, mapping.delimiter)
    clock = mapping.time_column if mapping.time_unit == CLOCK else None
    table, left_out = read_table(path, list(dict.fromkeys(wanted)), head, clock)
    notes = [say("table.rows_left_out", count=left_out)] if left_out else []
    if clock is not None:
        table[clock], said = seconds_of_clock(table[clock].tolist())
        notes += said
    recorded = _first_moment(mapping, table)
    rows = len(next(iter(table.values())))
    if rows < 2:
        raise RecordingFormatError(say("file.too_few_rows"))
    if mapping.time_column is not None:
        with _naming([mapping.time_column]):
            unit = "s" if clock is not None else mapping.time_unit
            table, time_s, mended_notes = _on_time(table, mapping.time_column, unit)
        notes += mended_notes
        rate_hz = mapping.rate_hz or nominal_rate(time_s)
    else:
        assert mapping.rate_hz is not None
        rate_hz = mapping.rate_hz
        time_s = np.arange(rows) / rate_hz
    sensors = {
        placement: _sensor(placement, quantities, table, time_s)
        for placement, quantities in by_placement.items()
    }
    return Recording(
        sensors, rate_hz, origin="CSV file", metadata={"format": "csv", **recorded}, notes=tuple(notes)
    )


def _first_moment(mapping: CsvMapping, table: dict[str, Float]) -> dict[str, str]:
    """Return when a table says that it was recorded: its numbers count from 1970. Times of day as text have no zone."""
    if mapping.time_column is None or mapping.time_unit == CLOCK or not len(table[mapping.time_column]):
        return {}
    return as_metadata(float(table[mapping.time_column][0]) * UNIT_FACTORS[mapping.time_unit])


def _on_time(
    table: dict[str, Float], column: str, unit: str
) -> tuple[dict[str, Float], Float, list[Sentence]]:
    """Return the rows that have a place in time, that time, and what was mended."""
    others = np.stack([values for name, values in table.items() if name != column], axis=1)
    found = mended(table[column], UNIT_FACTORS[unit], others)
    if found.time_s.size < 2:
        raise RecordingFormatError(say("file.too_few_rows"))
    steps = np.diff(found.time_s)
    check_unit(float(np.median(steps)) / UNIT_FACTORS[unit], unit)
    return {name: values[found.rows] for name, values in table.items()}, found.time_s, list(found.notes)


def _check_mapping(mapping: CsvMapping) -> dict[str, dict[str, CsvColumn]]:
    if mapping.time_column is None and mapping.rate_hz is None:
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


def _sensor(
    placement: str, quantities: dict[str, CsvColumn], table: dict[str, Float], time_s: Float
) -> SensorSignals:
    def values(quantity: str) -> Float | None:
        signal = quantities.get(quantity)
        if signal is None:
            return None
        return np.stack([table[name] for name in signal.columns], axis=1) * TO_SI[signal.unit]

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


def read_columns(path: Path, wanted: list[str], delimiter: str | None) -> dict[str, Float]:
    """Read the wanted columns as numbers, each shape (N,), with decimal points or decimal commas.

    Parameters
    ----------
    path : Path
    wanted : list of str
        Names as `TableHead.columns` has them.
    delimiter : str or None
        None where it is to be found; a blank stands for any number of blanks.

    Raises
    ------
    RecordingFormatError
        A column is missing or not numeric, or the file is too long or damaged.
    """
    return read_table(path, wanted, head_of_file(path, delimiter))[0]


def read_table(
    path: Path, wanted: list[str], head: TableHead, text: str | None = None
) -> tuple[dict[str, NDArray[Any]], int]:
    """Read the wanted columns of a table whose head is known; see `read_columns`.

    Parameters
    ----------
    path : Path
    wanted : list of str
    head : TableHead
    text : str, optional
        The one of them that is read as it is written.

    Returns
    -------
    table : dict of str to ndarray, shape (N,)
    left_out : int
        Rows with another number of columns: the last one is often cut.
    """
    missing = [name for name in wanted if name not in head.columns]
    if missing:
        shown = ", ".join(head.columns[:40])[:600]
        raise RecordingFormatError(
            say("table.no_column", missing=missing[:9], present=shown), missing=missing[:40]
        )
    # Only who reads a table waits for the library to be imported.
    import pyarrow as pa

    try:
        return _read_with(path, wanted, head, ".", text)
    except pa.ArrowInvalid as error:
        if "conversion error" not in str(error):
            raise _in_words(error, head) from error
        with_points = error
    try:
        # Between commas, decimal commas stand in quotes.
        return _read_with(path, wanted, head, ",", text)
    except pa.ArrowInvalid:
        raise _in_words(with_points, head) from with_points


def _read_with(
    path: Path, wanted: list[str], head: TableHead, decimal_point: str, text: str | None
) -> tuple[dict[str, NDArray[Any]], int]:
    import pyarrow as pa
    from pyarrow import csv

    parts: dict[str, list[Any]] = {name: [] for name in wanted}
    values = left_out = 0

    def leave_out(_: Any) -> str:
        nonlocal left_out
        left_out += 1
        return "skip"

    with opened(path, head.encoding) as file:
        # Only lines of the beginning were decoded; readline goes past them without a table's rules.
        for _ in range(head.skipped_lines):
            file.readline(MAX_LINE_BYTES)
        try:
            reader = csv.open_csv(
                _SingleBlanks(file) if head.delimiter == " " else file,
                read_options=csv.ReadOptions(
                    block_size=_BLOCK_BYTES, use_threads=False, column_names=list(head.columns)
                ),
                parse_options=csv.ParseOptions(delimiter=head.delimiter, invalid_row_handler=leave_out),
                convert_options=csv.ConvertOptions(
                    include_columns=wanted,
                    column_types={name: pa.string() if name == text else pa.float64() for name in wanted},
                    decimal_point=decimal_point,
                    null_values=_NOTHING,
                    strings_can_be_null=True,
                ),
            )
        except pa.ArrowInvalid as error:
            if "Empty CSV file" in str(error):
                raise RecordingFormatError(say("table.no_rows")) from error
            raise
        with reader:
            for batch in reader:
                values += batch.num_rows * len(wanted)
                if values > MAX_VALUES:
                    raise RecordingFormatError(
                        say("table.too_long", rows=MAX_VALUES // len(wanted), columns=len(wanted))
                    )
                for name in wanted:
                    parts[name].append(batch.column(name).to_numpy(zero_copy_only=False))
    rows = values // len(wanted)
    if left_out > _MOST_RAGGED * (rows + left_out) and left_out > 1:
        raise RecordingFormatError(say("table.ragged"))
    if not values:
        raise RecordingFormatError(say("table.no_rows"))
    table = {
        name: np.concatenate(pieces).astype(object if name == text else np.float64, copy=False)
        for name, pieces in parts.items()
    }
    return table, left_out


class _SingleBlanks(io.RawIOBase):
    """A text in which any number of blanks stands between two fields, with one each; read block by block."""

    def __init__(self, file: BinaryIO) -> None:
        self._file, self._left = file, b""

    def readable(self) -> bool:
        return True

    def readinto(self, target: Any) -> int:
        while not self._left:
            line = self._file.readline(MAX_LINE_BYTES)
            if not line:
                return 0
            # Lines of blanks only vanish, as empty ones do in any table.
            self._left = b" ".join(line.split()) + b"\n" if line.strip() else b""
        taken, self._left = self._left[: len(target)], self._left[len(target) :]
        target[: len(taken)] = taken
        return len(taken)


def _in_words(error: ValueError, head: TableHead) -> RecordingFormatError:
    text = str(error)
    if "conversion error" in text:
        at = re.search(r"In CSV column #(\d+)", text)
        name = head.columns[int(at[1])] if at else "?"
        return RecordingFormatError(say("table.not_a_number", column=name), column=name)
    return RecordingFormatError(say("table.unreadable"))


__all__ = ["MAX_VALUES", "read_columns", "read_csv"]
