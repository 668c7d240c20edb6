"""CSV with a declared mapping: which columns are what, in which unit. Parsed in blocks, checked in words."""

from pathlib import Path
from typing import Any, Final

import numpy as np
import pyarrow as pa
from pyarrow import csv

from app.errors import RecordingFormatError
from app.ingest.readers._time import HIGHEST_HZ, LOWEST_HZ, nominal_rate, seconds_of
from app.ingest.readers._units import (
    TO_SI,
    UNITS,
    check_accelerometer,
    check_gyroscope,
    check_magnetometer,
)
from app.recordings.schemas import CsvColumn, CsvMapping
from estimators.recording import Float, Recording, SensorSignals

MAX_VALUES: Final = 60_000_000
"""About an hour of 17 nine-axis sensors at 100 Hz; more is to be split."""
MAX_LINE_BYTES: Final = 1 << 20
_BLOCK_BYTES: Final = 4 << 20


def read_csv(path: Path, mapping: CsvMapping) -> Recording:
    """Read a CSV file as declared.

    Parameters
    ----------
    path : Path
    mapping : CsvMapping

    Raises
    ------
    RecordingFormatError
        A column is missing or not numeric, a unit cannot be right, time does not rise, or it is too long.
    """
    by_placement = _check_mapping(mapping)
    wanted = [column for signal in mapping.signals for column in signal.columns]
    if mapping.time_column is not None:
        wanted.append(mapping.time_column)
    table = read_columns(path, list(dict.fromkeys(wanted)), mapping.delimiter)
    rows = len(next(iter(table.values())))
    if mapping.time_column is not None:
        time_s = seconds_of(table[mapping.time_column], mapping.time_unit)
        rate_hz = mapping.rate_hz or nominal_rate(time_s)
    else:
        assert mapping.rate_hz is not None
        rate_hz = mapping.rate_hz
        time_s = np.arange(rows) / rate_hz
        if rows < 2:
            raise RecordingFormatError("The file holds fewer than two rows; there is nothing to estimate.")
    sensors = {
        placement: _sensor(placement, quantities, table, time_s)
        for placement, quantities in by_placement.items()
    }
    return Recording(sensors, rate_hz, origin="CSV file", metadata={"format": "csv"})


def _check_mapping(mapping: CsvMapping) -> dict[str, dict[str, CsvColumn]]:
    if mapping.time_column is None and mapping.rate_hz is None:
        raise RecordingFormatError("The mapping names neither a time column nor a rate; give one of them.")
    if mapping.rate_hz is not None and not LOWEST_HZ <= mapping.rate_hz <= HIGHEST_HZ:
        raise RecordingFormatError(
            f"A rate of {mapping.rate_hz:g} Hz cannot be used; use {LOWEST_HZ:g} to {HIGHEST_HZ:g} Hz."
        )
    found: dict[str, dict[str, CsvColumn]] = {}
    for signal in mapping.signals:
        if signal.unit not in UNITS[signal.quantity]:
            raise RecordingFormatError(
                f"{signal.unit} is no unit of a {signal.quantity}; use"
                f" {' or '.join(UNITS[signal.quantity])}.",
                sensor=signal.placement,
            )
        quantities = found.setdefault(signal.placement, {})
        if signal.quantity in quantities:
            raise RecordingFormatError(
                f"The {signal.quantity} of {signal.placement} is mapped twice.", sensor=signal.placement
            )
        quantities[signal.quantity] = signal
    if not found:
        raise RecordingFormatError("The mapping names no sensor.")
    for placement, quantities in found.items():
        for needed in ("gyroscope", "accelerometer"):
            if needed not in quantities:
                raise RecordingFormatError(
                    f"The {needed} of {placement} is not mapped; gyroscope and accelerometer are needed.",
                    sensor=placement,
                )
    with_field = [p for p, quantities in found.items() if "magnetometer" in quantities]
    if with_field and len(with_field) < len(found):
        without = ", ".join(p for p in found if p not in with_field)
        raise RecordingFormatError(
            f"The magnetometer of {without} is not mapped; map the magnetometer of all sensors or of none."
        )
    return found


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
    check_gyroscope(gyroscope, quantities["gyroscope"].unit, placement)
    check_accelerometer(accelerometer, quantities["accelerometer"].unit, placement)
    if field is not None:
        check_magnetometer(field, quantities["magnetometer"].unit, placement)
    return SensorSignals(time_s, gyroscope, accelerometer, field)


def read_columns(path: Path, wanted: list[str], delimiter: str) -> dict[str, Float]:
    """Read the wanted columns as numbers, each shape (N,); a semicolon file may use decimal commas.

    Raises
    ------
    RecordingFormatError
        A column is missing or not numeric, or the file is too long or damaged.
    """
    decimal_points = [".", ","] if delimiter == ";" else ["."]
    for decimal_point in decimal_points:
        try:
            return _read_with(path, wanted, delimiter, decimal_point)
        except pa.ArrowInvalid as error:
            if decimal_point == decimal_points[-1] or "conversion error" not in str(error):
                raise _in_words(error) from error
    raise RecordingFormatError("The file cannot be read.")


def _read_with(path: Path, wanted: list[str], delimiter: str, decimal_point: str) -> dict[str, Float]:
    _check_header(path, wanted, delimiter)
    reader = csv.open_csv(
        path,
        read_options=csv.ReadOptions(block_size=_BLOCK_BYTES, use_threads=False),
        parse_options=csv.ParseOptions(delimiter=delimiter),
        convert_options=csv.ConvertOptions(
            include_columns=wanted,
            column_types={name: pa.float64() for name in wanted},
            decimal_point=decimal_point,
            null_values=["", "NaN", "nan", "NA", "null"],
            strings_can_be_null=True,
        ),
    )
    parts: dict[str, list[Any]] = {name: [] for name in wanted}
    values = 0
    with reader:
        for batch in reader:
            values += batch.num_rows * len(wanted)
            if values > MAX_VALUES:
                raise RecordingFormatError(
                    f"The file holds more than {MAX_VALUES // len(wanted)} rows for {len(wanted)} columns;"
                    " split it into shorter recordings."
                )
            for name in wanted:
                parts[name].append(batch.column(name).to_numpy(zero_copy_only=False))
    if not values:
        raise RecordingFormatError("The file has a header but no rows.")
    return {name: np.concatenate(pieces).astype(np.float64, copy=False) for name, pieces in parts.items()}


def _check_header(path: Path, wanted: list[str], delimiter: str) -> None:
    with path.open("rb") as file:
        line = file.readline(MAX_LINE_BYTES)
    if len(line) >= MAX_LINE_BYTES and not line.endswith(b"\n"):
        raise RecordingFormatError("The first line has no end; this is no CSV file.")
    try:
        header = line.decode("utf-8-sig").strip("\r\n")
    except UnicodeDecodeError as error:
        raise RecordingFormatError("The first line is not UTF-8 text; this is no CSV file.") from error
    present = [name.strip().strip('"') for name in header.split(delimiter)]
    missing = [name for name in wanted if name not in present]
    if missing:
        shown = ", ".join(present[:40])
        raise RecordingFormatError(
            f"The file has no column {', '.join(missing[:9])}. It has: {shown[:600]}."
            " Correct the mapping, or choose another delimiter.",
            missing=missing[:40],
        )
    repeated = [name for name in wanted if present.count(name) > 1]
    if repeated:
        raise RecordingFormatError(f"The column {repeated[0]} stands in the file more than once.")


def _in_words(error: pa.ArrowInvalid) -> RecordingFormatError:
    text = str(error)
    if "conversion error" in text:
        column = text.split("In CSV column #")[-1].split(":")[0] if "In CSV column #" in text else "?"
        return RecordingFormatError(
            f"A value in column number {column} is not a number; the file must hold numbers with a decimal"
            " point in all mapped columns."
        )
    if "Expected" in text and "columns" in text:
        return RecordingFormatError(
            "A row has another number of columns than the header; the file is damaged."
        )
    return RecordingFormatError("The file cannot be read as CSV; check delimiter and encoding (UTF-8).")


__all__ = ["MAX_VALUES", "read_columns", "read_csv"]
