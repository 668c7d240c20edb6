"""Where the table of a text file begins: what is no table, the delimiter, the names of the columns.

docs/mapping.md says the rules in words, tests/data/tables holds examples: change them together.
"""

import re
from collections import Counter
from collections.abc import Sequence
from csv import Error, reader
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from app.errors import RecordingFormatError
from app.readers.tables.clocks.of_day import is_clock
from app.readers.tables.text import HEAD_BYTES, encoding_of, later_of, lines_of, start_of, text_of
from estimators.sentences import say

_LINES: Final = 200
"""Lines with content that are looked at to find delimiter and header."""
_MOST_HEADER_LINES: Final = 4
_MOST_COLUMNS: Final = 2000
_LONGEST_NAME: Final = 200
_COMMAS_MORE: Final = 1.4
"""Times as many fields as names: most numbers, not all, have a decimal comma."""
# The first of those that find equally many numbers is taken.
DELIMITERS: Final = ("\t", ";", ",", "|", " ")
_FEWEST_OF_WORDS: Final = 5
"""Rows."""
_COMMENT: Final = re.compile(r"^\s*(//|#|%)")
_KEY_VALUE: Final = re.compile(r'^\s*"?[A-Za-z][^,;\t|":]*"?\s*:([\s,;|]|$)')
_SEPARATOR: Final = re.compile(r"^\s*\"?sep\s*=\s*(.)\"?\s*$", re.IGNORECASE)
_NUMBER: Final = re.compile(
    r"^([+-]?(\d+([.,]\d+)?\.?|[.,]\d+)(e[+-]?\d+)?|nan|na|null|[+-]?inf)$", re.IGNORECASE
)


@dataclass(frozen=True)
class TableHead:
    """The head of a table.

    Attributes
    ----------
    delimiter : str
        Blank stands for any number of blanks.
    columns : tuple of str
        Names, each once: header lines joined, repeated names numbered, empty ones `column 3`.
    rows : tuple of tuple of str
        The first rows of data.
    skipped_lines : int
        Lines of the file before the first row of data.
    preamble : tuple of str
        Lines that are neither header nor data.
    encoding : str
        A codec's name.
    body : tuple of str
        Lines from the first row of data on, as far as the file was looked at; the last one may be cut and is left out.
    """

    delimiter: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    skipped_lines: int
    preamble: tuple[str, ...]
    encoding: str = "utf-8"
    body: tuple[str, ...] = ()
    later: tuple[tuple[str, ...], ...] = ()
    """Lines of pieces of the rest of the file, where it goes on: what begins later is in them."""


def head_of_file(path: Path, delimiter: str | None = None) -> TableHead:
    """Find the table of a file; see `head_of`."""
    return head_of(start_of(path), delimiter, later_of(path))


def head_of(start: bytes, delimiter: str | None = None, later: Sequence[bytes] = ()) -> TableHead:
    """Find the table in the beginning of a file.

    Parameters
    ----------
    start : bytes
        The whole file, or its first `HEAD_BYTES`.
    delimiter : str, optional
        Where it is known; otherwise it is found.
    later : sequence of bytes
        Pieces of the rest of the file; see `later_of`.

    Raises
    ------
    RecordingFormatError
        It is no text, or no table can be made of it.
    """
    start = start[:HEAD_BYTES]
    encoding = encoding_of(start)
    text = text_of(start)
    if len(start) == HEAD_BYTES:
        end = text.rfind("\n")
        if end < 0:
            raise RecordingFormatError(say("table.endless_line"))
        text = text[:end]
    found = read_head(text, delimiter, encoding=encoding)
    return replace(found, later=tuple(lines_of(piece, start) for piece in later))


def read_head(
    text: str, delimiter: str | None = None, shown_rows: int = 5, *, encoding: str = "utf-8"
) -> TableHead:
    """Find the table in the first lines of a file; see `TableHead`."""
    lines = text.removeprefix("\ufeff").replace("\r\n", "\n").split("\n")
    content = [
        index
        for index, line in enumerate(lines)
        if line.strip() and not _COMMENT.match(line) and not _SEPARATOR.match(line)
    ][:_LINES]
    if not content:
        raise RecordingFormatError(say("table.empty"))
    tried = [_split_all(lines, content, one) for one in ((delimiter,) if delimiter else DELIMITERS)]
    best = max(tried, key=lambda one: one.numbers)
    if not _is_named(best):
        best = next((one for split in tried if (one := _of_words(split)) is not None), best)
    if not best.numbers:
        # No row of numbers: the first line is taken for the header, so that something can be shown.
        best = max(tried, key=lambda one: len(one.fields[0]) if one.fields else 0)
    first, width = best.first, best.width
    _check_commas(best)
    rows = best.fields[first:]
    if best.numbers and 2 * sum(len(fields) == width for fields in rows) < len(rows):
        raise RecordingFormatError(say("table.ragged"))
    header = _header(lines, content, best)
    if (
        not header
        and content
        and (comment := _comment_header(lines, content[min(first, len(content) - 1)], width))
    ):
        names = comment
    else:
        names = _joined([_aligned(best.fields[index], best) for index in header], width)
    if len(names) > _MOST_COLUMNS:
        raise RecordingFormatError(say("table.too_many_columns", columns=len(names), most=_MOST_COLUMNS))
    before = content[first] if first < len(content) else (content[-1] + 1 if content else 0)
    used = {content[index] for index in header}
    return TableHead(
        best.delimiter,
        tuple(_numbered(names)),
        tuple(tuple(fields) for fields in best.fields[first : first + shown_rows]),
        before,
        tuple(line for index, line in enumerate(lines[:before]) if line.strip() and index not in used),
        encoding,
        tuple(line for line in lines[before:] if line.strip()),
    )


def is_number(field: str) -> bool:
    """Whether a field of a table is a number, or says that there is none."""
    return _NUMBER.match(field) is not None


def split_line(line: str, delimiter: str) -> list[str]:
    """Split one line; quoted fields may hold the delimiter."""
    if delimiter == " ":
        return line.split()
    try:
        return [
            field.strip() for field in next(reader([line], delimiter=delimiter, skipinitialspace=True), [])
        ]
    except Error:
        # A quote that never ends, or a field of a megabyte.
        return [field.strip() for field in line.split(delimiter)]


@dataclass(frozen=True)
class _Split:
    """The lines with content, split by one delimiter; `first` is the first row of data among them."""

    delimiter: str
    fields: list[list[str]]
    width: int
    first: int
    numbers: int


def _split_all(lines: list[str], content: list[int], delimiter: str) -> _Split:
    fields = [split_line(lines[index], delimiter) for index in content]
    counted = Counter(len(one) for one in fields)
    width = max(counted, key=lambda one: (counted[one], one), default=0)
    for index, one in enumerate(fields):
        filled = [field for field in one if field]
        numbers = sum(is_number(field) or is_clock(field) for field in filled)
        if width > 1 and len(one) == width and 2 * numbers > len(filled):
            return _Split(delimiter, fields, width, index, numbers)
    return _Split(delimiter, fields, len(fields[0]) if fields else 0, min(1, len(fields)), 0)


def _is_named(split: _Split) -> bool:
    """Return whether a line of as many names stands straight above the first row of data."""
    above = split.fields[split.first - 1] if split.numbers and split.first else []
    return bool(above) and _aligned(above, split) is not None and not any(map(is_number, filter(None, above)))


def _of_words(split: _Split) -> _Split | None:
    """Return where rows begin that hold more words than numbers, as rows of one value do; None where none do.

    Each has as many fields as the line of names above them, and numbers in the same places.
    """
    for index, names in enumerate(split.fields[:-_FEWEST_OF_WORDS]):
        width = len(names)
        if width < 3 or not all(names) or any(map(is_number, names)):
            continue
        rows = [one for one in split.fields[index + 1 :] if len(one) == width]
        if 10 * len(rows) < 9 * len(split.fields[index + 1 :]):
            continue
        placed = [sum(is_number(row[place]) or not row[place] for row in rows) for place in range(width)]
        numbers = sum(10 * one >= 9 * len(rows) for one in placed)
        if 0 < numbers < width:
            return _Split(split.delimiter, split.fields, width, index + 1, numbers)
    return None


def _check_commas(split: _Split) -> None:
    """Refuse commas both between and within the numbers: rows then have more fields than there are names."""
    if split.delimiter != ",":
        return
    names, after = 0, 0
    for index, fields in enumerate(split.fields[: split.first]):
        if len(fields) > 2 and not any(map(is_number, fields)):
            names, after = len(fields), index + 1
    widths = sorted(len(fields) for fields in split.fields[after:])
    if names and widths and widths[0] >= names and widths[len(widths) // 2] >= _COMMAS_MORE * names:
        raise RecordingFormatError(say("table.commas_twice"))


def _header(lines: list[str], content: list[int], split: _Split) -> list[int]:
    """Return which of the lines with content, straight above the data, name the columns."""
    found: list[int] = []
    for index in range(split.first - 1, -1, -1):
        fields = split.fields[index]
        if split.numbers and (_aligned(fields, split) is None or _KEY_VALUE.match(lines[content[index]])):
            break
        if found and sum(map(bool, fields)) == 1 and fields[0] and split.width > 3:
            # A title with the delimiters that a spreadsheet adds.
            break
        found.insert(0, index)
        if len(found) == _MOST_HEADER_LINES:
            break
    return found


def _aligned(fields: list[str], split: _Split) -> list[str] | None:
    """Return a line as names of all columns; None where it is none."""
    width = split.width
    if len(fields) == width or not split.numbers:
        return fields
    if len(fields) == width + 1 and not fields[-1]:
        # A delimiter at the end of the header only.
        return fields[:-1]
    if len(fields) == width - 1:
        # A delimiter at the end of the rows only, or rows that begin with their number and a header that does not.
        return [*fields, ""] if split.fields[split.first][-1] == "" else ["", *fields]
    return None


def _comment_header(lines: list[str], before: int, width: int) -> list[str] | None:
    """Return the names of a header that stands in the last comment, split as it may be."""
    comments = [line for line in lines[:before] if _COMMENT.match(line)]
    for delimiter in DELIMITERS if comments else ():
        names = split_line(_COMMENT.sub("", comments[-1]).strip(), delimiter)
        if len(names) == width:
            return names
    return None


def _joined(header: list[list[str] | None], width: int) -> list[str]:
    """Join header lines column by column; a name above several columns holds until the next one."""
    rows = [fields + [""] * (width - len(fields)) for fields in header if fields is not None]
    for fields in rows[:-1]:
        for column in range(1, width):
            fields[column] = fields[column] or fields[column - 1]
    return [" ".join(filter(None, (fields[column] for fields in rows))) for column in range(width)]


def _numbered(names: list[str]) -> list[str]:
    """Make each name stand once."""
    found: dict[str, None] = {}
    for position, name in enumerate(names, 1):
        plain = name[:_LONGEST_NAME] or f"column {position}"
        unique, count = plain, 1
        while unique in found:
            count += 1
            unique = f"{plain} ({count})"
        found[unique] = None
    return list(found)
