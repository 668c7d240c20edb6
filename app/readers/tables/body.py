"""The columns of a table as numbers, parsed in blocks; what is no number is refused with its line."""

import io
import re
from collections.abc import Collection
from pathlib import Path
from typing import Any, BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from app.errors import RecordingFormatError
from app.readers.tables.head import TableHead, head_of_file, is_number, split_line
from app.readers.tables.text import opened
from estimators.recording import Float
from estimators.sentences import Sentence, say

MAX_VALUES: Final = 60_000_000
"""About an hour of 17 nine-axis sensors at 100 Hz; more is to be split."""
MAX_LINE_BYTES: Final = 1 << 20
_BLOCK_BYTES: Final = 4 << 20
_MOST_RAGGED: Final = 0.1
"""A larger share of rows with another number of columns is no table."""
_NOTHING: Final = ["", "NaN", "nan", "NAN", "NA", "N/A", "n/a", "#N/A", "null", "NULL", "None", "-", "--"]
"""What stands where no number does."""
# A device may be called NA.
_EMPTY: Final[dict[str, Any]] = {"null_values": _NOTHING, "strings_can_be_null": False}


def read_columns(path: Path, wanted: list[str], delimiter: str | None) -> dict[str, Float]:
    """Read the wanted columns as numbers, each shape (N,), with decimal points or decimal commas.

    Parameters
    ----------
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
    path: Path, wanted: list[str], head: TableHead, text: Collection[str] = ()
) -> tuple[dict[str, NDArray[Any]], tuple[Sentence, ...]]:
    """Read the wanted columns of a table whose head is known; see `read_columns`.

    Parameters
    ----------
    text : collection of str
        Those of them that are read as they are written.

    Returns
    -------
    table : dict of str to ndarray, shape (N,)
    notes : tuple of Sentence
        Which rows were left out: those with another number of columns, as a last one that is cut, and a head that
        stands again.
    """
    check_present(wanted, head)
    # Only who reads a table waits for the library to be imported.
    import pyarrow as pa

    again: list[int] = []
    while True:
        refused = None
        # Between commas, decimal commas stand in quotes.
        for decimal_point in ".,":
            try:
                table, notes = _read_with(path, wanted, head, decimal_point, text, frozenset(again))
            except pa.ArrowInvalid as error:
                if "conversion error" not in str(error):
                    raise _in_words(error, head) from error
                refused = refused or error
            else:
                said = (say("table.header_again", count=len(again), line=again[0]),) if again else ()
                return table, (*notes, *said)
        assert refused is not None
        if again or not (again := _heads_again(path, wanted, head, text)):
            raise _in_words(refused, head) from refused


def check_present(wanted: Collection[str], head: TableHead) -> None:
    """Refuse a table that has not all columns that are wanted.

    Raises
    ------
    RecordingFormatError
        With those that are missing.
    """
    missing = [name for name in wanted if name not in head.columns]
    if missing:
        shown = ", ".join(head.columns[:40])[:600]
        raise RecordingFormatError(
            say("table.no_column", missing=missing[:9], present=shown), missing=missing[:40]
        )


def _heads_again(path: Path, wanted: list[str], head: TableHead, text: Collection[str]) -> list[int]:
    """Return in which lines the names of the columns stand again.

    Raises
    ------
    RecordingFormatError
        A value of another line is not a number.
    """
    found: list[int] = []
    places = [(head.columns.index(name), name) for name in wanted if name not in text]
    with opened(path, head.encoding) as file:
        for number, line in enumerate(iter(lambda: file.readline(MAX_LINE_BYTES), b""), 1):
            if number <= head.skipped_lines or not line.strip():
                continue
            fields = split_line(line.decode().rstrip("\n"), head.delimiter)
            if len(fields) != len(head.columns):
                continue
            wrong = next((name for at, name in places if not _is_value(fields[at])), None)
            if wrong is None:
                continue
            if not all(field in name for field, name in zip(fields, head.columns, strict=True)):
                raise RecordingFormatError(
                    say("table.not_a_number_in_line", column=wrong, line=number), column=wrong, line=number
                )
            found.append(number)
    return found


def _is_value(field: str) -> bool:
    return field in _NOTHING or is_number(field)


def _read_with(
    path: Path,
    wanted: list[str],
    head: TableHead,
    decimal_point: str,
    text: Collection[str],
    without: frozenset[int] = frozenset(),
) -> tuple[dict[str, NDArray[Any]], tuple[Sentence, ...]]:
    import pyarrow as pa
    from pyarrow import csv

    types = {name: pa.string() if name in text else pa.float64() for name in wanted}
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
                _lines_of(file, head, without),
                read_options=csv.ReadOptions(
                    block_size=_BLOCK_BYTES, use_threads=False, column_names=list(head.columns)
                ),
                parse_options=csv.ParseOptions(delimiter=head.delimiter, invalid_row_handler=leave_out),
                convert_options=csv.ConvertOptions(
                    include_columns=wanted, column_types=types, decimal_point=decimal_point, **_EMPTY
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
        name: np.concatenate(pieces).astype(object if name in text else np.float64, copy=False)
        for name, pieces in parts.items()
    }
    return table, (say("table.rows_left_out", count=left_out),) if left_out else ()


def _lines_of(file: BinaryIO, head: TableHead, without: frozenset[int]) -> Any:
    """Return the rows of a table as a reader takes them: blanks one each, some lines of the file left out."""
    if head.delimiter != " " and not without:
        return file
    return _Lines(file, is_single=head.delimiter == " ", without=without, number=head.skipped_lines)


class _Lines(io.RawIOBase):
    """A text line by line, some left out, with single blanks where any number stands between two fields."""

    def __init__(self, file: BinaryIO, *, is_single: bool, without: frozenset[int], number: int) -> None:
        self._file, self._left = file, b""
        self._is_single, self._without, self._number = is_single, without, number

    def readable(self) -> bool:
        return True

    def readinto(self, target: Any) -> int:
        while not self._left:
            line = self._file.readline(MAX_LINE_BYTES)
            if not line:
                return 0
            self._number += 1
            # Lines of blanks only vanish, as empty ones do in any table.
            if self._number in self._without or not line.strip():
                continue
            self._left = b" ".join(line.split()) + b"\n" if self._is_single else line
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
