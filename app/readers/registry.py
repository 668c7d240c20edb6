"""Every format that is read, found by looking into `app/readers/formats`."""

from functools import cache
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from app.errors import InvalidInput, RecordingFormatError
from app.readers import formats
from app.readers.contract import Reader, Source
from app.readers.foreign import what_it_is
from app.readers.members import ZIP_MARK
from app.readers.tables.text import start_of
from estimators.sentences import say

if TYPE_CHECKING:
    from app.readers.tables.schemas import CsvMapping
    from estimators.recording import Recording


@cache
def readers() -> dict[str, Reader]:
    """Return the readers by name of their format, in the order in which they are shown: what holds anything first."""
    found = []
    for name in formats.names():
        module = import_module(f"{formats.__name__}.{name}")
        (kind,) = (
            value
            for value in vars(module).values()
            if isinstance(value, type) and issubclass(value, Reader) and value.__module__ == module.__name__
        )
        found.append(kind())
    return {
        one.name: one
        for one in sorted(found, key=lambda one: (not one.asks_pipeline, one.pipeline, one.name))
    }


def reader_of(format: str) -> Reader:
    """Return the reader of a format.

    Raises
    ------
    InvalidInput
        Nobody reads it.
    """
    if format not in readers():
        raise InvalidInput(say("file.format_unknown", format=format, formats=list(readers())), field="format")
    return readers()[format]


def read(path: Path, format: str = "auto", csv: "CsvMapping | None" = None, name: str = "") -> "Recording":
    """Read a recording.

    Parameters
    ----------
    format : str
        A name in `readers()`, or `auto`: by the file's ending and content.
    csv : CsvMapping, optional
        Which column of a table is what, in which unit.
    name : str
        What the file was called before it was uploaded: says the side of a foot. By default its name.

    Raises
    ------
    RecordingFormatError
        The file is not what it was declared to be; the message says what to do.
    InvalidInput
        The format is unknown, or a table comes without its mapping.
    """
    if format == "auto":
        format = format_of(path, csv)
    reader = reader_of(format)
    if reader.needs_mapping and csv is None:
        raise InvalidInput(say("file.csv_needs_mapping"), field="csv")
    # Only who reads a recording waits for what does it.
    from app.readers.slower import slower

    return slower(reader.read(Source(path, name, csv)))


def format_of(path: Path, csv: "CsvMapping | None" = None) -> str:
    """Return the format of a file; what a person says of the columns of a text makes it a table.

    Raises
    ------
    RecordingFormatError
        Nothing fits.
    """
    is_table = csv is not None and not start_of(path).startswith(ZIP_MARK)
    return "csv" if is_table else guess(path)


def guess(path: Path, name: str = "") -> str:
    """Return the format that a file seems to have.

    Parameters
    ----------
    name : str
        What the file was called before it was uploaded. By default its name.

    Raises
    ------
    RecordingFormatError
        Nothing fits.
    """
    return recognised(Source(path, name))


def recognised(source: Source) -> str:
    """Return the format of a file; see `guess`.

    Raises
    ------
    RecordingFormatError
        It is known to be no recording, or nothing fits.
    """
    if (foreign := what_it_is(source.start, source.ending)) is not None:
        raise RecordingFormatError(foreign)
    for reader in sorted(readers().values(), key=lambda one: (one.is_last, one.name)):
        if reader.recognises(source):
            return reader.name
    raise RecordingFormatError(say("file.format_not_recognised", formats=list(readers())))
