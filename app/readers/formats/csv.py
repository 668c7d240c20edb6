"""Tables of any sensors, read as a mapping says."""

from typing import TYPE_CHECKING

from app.errors import RecordingFormatError
from app.readers.contract import TEXT, Reader, Source
from app.readers.tables.guess import SINGLE
from app.readers.tables.head import head_of, is_number

if TYPE_CHECKING:
    from estimators.recording import Recording


def _has_numbers(start: bytes) -> bool:
    try:
        head = head_of(start)
    except RecordingFormatError:
        return False
    return len(head.columns) > 1 and any(is_number(field) for row in head.rows[:1] for field in row if field)


class CsvReader(Reader):
    """Any table of numbers: a person says which column is what, in which unit."""

    title = "Table (CSV)"
    description = "Any sensors: you say which column is what, and in which unit"
    endings = TEXT
    asks_pipeline = True
    needs_mapping = True
    is_last = True

    def recognises(self, source: Source) -> bool:
        """By its ending, or by rows of numbers: what no other format claims may be a table."""
        return source.ending in TEXT or (source.is_text and _has_numbers(source.start))

    def read(self, source: Source) -> "Recording":
        """Read it by its mapping."""
        from app.readers.tables.columns import read_csv

        assert source.mapping is not None
        return read_csv(source.path, source.mapping)

    def announces(self, source: Source) -> tuple[tuple[str, ...], float]:
        """Return what the mapping names."""
        if source.mapping is None:
            return (), 100.0
        names = [signal.placement or signal.sensor or SINGLE for signal in source.mapping.signals]
        return tuple(dict.fromkeys(names)), source.mapping.rate_hz or 100.0
