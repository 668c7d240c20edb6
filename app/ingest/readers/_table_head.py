"""Where the table of a text file begins: what is no table, the delimiter, the names of the columns.

`web/src/lib/tableHead.ts` does the same in the browser; both are tested on `tests/data/tables` with the same answers.
docs/mappings.md says the rules in words: change all four together.
"""

import re
from collections import Counter
from csv import reader
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from app.errors import RecordingFormatError
from app.sentences import say

HEAD_BYTES: Final = 256 * 1024
"""How much of a file is looked at."""
_LINES: Final = 200
_MOST_HEADER_LINES: Final = 3
# The first of those that find equally many numbers is taken.
DELIMITERS: Final = ("\t", ";", ",", " ")
_COMMENT: Final = re.compile(r"^\s*(//|#|%)")
_KEY_VALUE: Final = re.compile(r'^\s*[A-Za-z][^,;\t":]*:([\s,;]|$)')
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
    """

    delimiter: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    skipped_lines: int
    preamble: tuple[str, ...]


def head_of_file(path: Path, delimiter: str | None = None) -> TableHead:
    """Find the table of a file.

    Parameters
    ----------
    path : Path
    delimiter : str, optional
        Where it is known; otherwise it is found.

    Raises
    ------
    RecordingFormatError
        The beginning is no text.
    """
    with path.open("rb") as file:
        start = file.read(HEAD_BYTES)
    if len(start) == HEAD_BYTES:
        end = start.rfind(b"\n")
        if end < 0:
            raise RecordingFormatError(say("table.endless_line"))
        start = start[:end]
    try:
        text = start.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise RecordingFormatError(say("table.not_utf8")) from error
    return read_head(text, delimiter)


def read_head(text: str, delimiter: str | None = None, shown_rows: int = 5) -> TableHead:
    """Find the table in the first lines of a file; see `TableHead`."""
    lines = [line.rstrip("\r") for line in text.split("\n")]
    content = [index for index, line in enumerate(lines) if line.strip() and not _COMMENT.match(line)][
        :_LINES
    ]
    tried = [_split_all(lines, content, one) for one in ((delimiter,) if delimiter else DELIMITERS)]
    best = max(tried, key=lambda one: one.numbers)
    if not best.numbers:
        # No row of numbers: the first line is taken for the header, so that something can be shown.
        best = max(tried, key=lambda one: len(one.fields[0]) if one.fields else 0)
    first, width = best.first, best.width
    header = _header(lines, content, best)
    if not header and content and (comment := _comment_header(lines, content[first], best.delimiter, width)):
        names = comment
    else:
        names = _joined([best.fields[index] for index in header], width)
    before = content[first] if first < len(content) else (content[-1] + 1 if content else 0)
    used = {content[index] for index in header}
    return TableHead(
        best.delimiter,
        tuple(_numbered(names)),
        tuple(tuple(fields) for fields in best.fields[first : first + shown_rows]),
        before,
        tuple(line for index, line in enumerate(lines[:before]) if line.strip() and index not in used),
    )


def is_number(field: str) -> bool:
    """Whether a field of a table is a number, or says that there is none."""
    return _NUMBER.match(field) is not None


def split_line(line: str, delimiter: str) -> list[str]:
    """Split one line; quoted fields may hold the delimiter."""
    if delimiter == " ":
        return line.split()
    return [field.strip() for field in next(reader([line], delimiter=delimiter, skipinitialspace=True), [])]


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
        numbers = sum(map(is_number, filled))
        if width > 1 and len(one) == width and 2 * numbers > len(filled):
            return _Split(delimiter, fields, width, index, numbers)
    return _Split(delimiter, fields, len(fields[0]) if fields else 0, min(1, len(fields)), 0)


def _header(lines: list[str], content: list[int], split: _Split) -> list[int]:
    """Return which of the lines with content, straight above the data, name the columns."""
    found: list[int] = []
    for index in range(split.first - 1, -1, -1):
        fields = split.fields[index]
        short = len(fields) == split.width - 1 and split.fields[split.first][-1:] == [""]
        is_names = len(fields) == split.width or short
        if split.numbers and (not is_names or _KEY_VALUE.match(lines[content[index]])):
            break
        found.insert(0, index)
        if len(found) == _MOST_HEADER_LINES:
            break
    return found


def _comment_header(lines: list[str], before: int, delimiter: str, width: int) -> list[str] | None:
    """Return the names of a header that stands in the last comment."""
    comments = [line for line in lines[:before] if _COMMENT.match(line)]
    names = split_line(_COMMENT.sub("", comments[-1]).strip(), delimiter) if comments else []
    return names if len(names) == width else None


def _joined(header: list[list[str]], width: int) -> list[str]:
    """Join header lines column by column; a name above several columns holds until the next one."""
    rows = [fields + [""] * (width - len(fields)) for fields in header]
    for fields in rows[:-1]:
        for column in range(1, width):
            fields[column] = fields[column] or fields[column - 1]
    return [" ".join(filter(None, (fields[column] for fields in rows))) for column in range(width)]


def _numbered(names: list[str]) -> list[str]:
    """Make each name stand once."""
    found: list[str] = []
    for position, name in enumerate(names, 1):
        plain = name or f"column {position}"
        unique, count = plain, 1
        while unique in found:
            count += 1
            unique = f"{plain} ({count})"
        found.append(unique)
    return found


__all__ = ["DELIMITERS", "HEAD_BYTES", "TableHead", "head_of_file", "is_number", "read_head", "split_line"]
