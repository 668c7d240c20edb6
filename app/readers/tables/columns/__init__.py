"""CSV with a declared mapping: which columns are what, in which unit. Checked in words."""

from pathlib import Path
from typing import TYPE_CHECKING

from app.readers.moments import as_metadata
from app.readers.tables.body import read_table
from app.readers.tables.clocks.counter import COUNT
from app.readers.tables.clocks.of_day import CLOCK
from app.readers.tables.clocks.stamps import UNIT_FACTORS, nominal_rate
from app.readers.tables.columns.mapped import checked_mapping, clocks_of, columns_of, with_times
from app.readers.tables.columns.sensors import TableSensors
from app.readers.tables.head import head_of_file
from app.readers.tables.schemas import CsvMapping
from app.readers.tables.tall import tall_of
from estimators.recording import Float, Recording

if TYPE_CHECKING:
    from app.readers.tables.several import Tables


def read_csv(path: Path, mapping: CsvMapping, tables: "Tables | None" = None) -> Recording:
    """Read a CSV file as declared.

    Parameters
    ----------
    tables : Tables, optional
        Several tables of one recording, of which the file is a zip.

    Raises
    ------
    RecordingFormatError
        A column is missing or not numeric, a unit cannot be right, time does not advance, or it is too long.
    """
    by_placement = checked_mapping(mapping)
    head = head_of_file(path, mapping.delimiter) if tables is None else tables.head
    tall = tall_of(head) if tables is None else None
    head = head if tall is None else tall.wide
    wanted, text = columns_of(mapping, head)
    if tables is not None:
        table, said_of_rows = tables.read(wanted, text, mapping.time_unit, clocks_of(mapping))
    elif tall is not None:
        table, said_of_rows = tall.read(path, wanted, text)
    else:
        table, said_of_rows = read_table(path, wanted, head, text)
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


__all__ = ["TableSensors", "checked_mapping", "columns_of", "read_csv", "with_times"]
