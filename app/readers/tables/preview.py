"""What a file seems to be, from its name and its beginning: the format, and of a table how to read it."""

from dataclasses import dataclass
from pathlib import Path, PurePath
from typing import cast

from app.readers.contract import Source
from app.readers.registry import reader_of, recognised
from app.readers.tables.guess import Guess, PipelineName, guess_of_head, pipeline_for
from app.readers.tables.head import TableHead, head_of


@dataclass(frozen=True)
class Preview:
    """What a file seems to be.

    Attributes
    ----------
    format : str
        A name in `readers()`.
    pipeline : str
        What it seems to be for.
    head : TableHead or None
        Of a table.
    guess : Guess or None
        How to read a table of format `csv`.
    """

    format: str
    pipeline: PipelineName
    head: TableHead | None = None
    guess: Guess | None = None


def preview_text(
    name: str, start: bytes, pipeline: PipelineName | None = None, rate_hz: float | None = None
) -> Preview:
    """Say what a text file seems to be.

    Parameters
    ----------
    name : str
        Of the file, with its ending.
    start : bytes
        Its first `HEAD_BYTES`, or all of it.
    pipeline, rate_hz : optional
        What a person said already; see `guess_of_head`.

    Raises
    ------
    RecordingFormatError
        It is no text, or no table can be made of it.
    """
    stem = PurePath(name).stem
    reader = reader_of(text_format(name, start))
    head = head_of(start)
    if reader.pipeline:
        return Preview(reader.name, cast(PipelineName, reader.pipeline), head)
    found = guess_of_head(head, stem, pipeline, rate_hz)
    return Preview(reader.name, found.pipeline, head, found if reader.needs_mapping else None)


def text_format(name: str, start: bytes) -> str:
    """Return the format that a text file seems to have.

    Parameters
    ----------
    name : str
        With its ending.
    start : bytes
    """
    source = Source(Path(name))
    # Cached properties may be given: the file itself is not here.
    vars(source).update(start=start, variables=frozenset())
    return recognised(source)


__all__ = ["Preview", "pipeline_for", "preview_text", "text_format"]
