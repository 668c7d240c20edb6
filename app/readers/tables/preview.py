"""The preview of a file from its name and its beginning: the format, and of a table how to read it."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path, PurePath
from tempfile import TemporaryDirectory
from typing import Final, cast

from app.errors import RecordingFormatError
from app.readers.contract import TEXT, Source
from app.readers.registry import reader_of, recognised
from app.readers.tables.guess import Guess, PipelineName, guess_of_head, pipeline_for
from app.readers.tables.head import TableHead, head_of
from app.readers.tables.tall import of_tall, tall_of
from app.readers.tables.text import HEAD_BYTES

ZIPPED: Final = "zipped"
"""The format of a zip of tables."""


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
    name: str,
    start: bytes,
    pipeline: PipelineName | None = None,
    rate_hz: float | None = None,
    later: Sequence[bytes] = (),
) -> Preview:
    """Say what a file seems to be.

    Parameters
    ----------
    name : str
        Of the file, with its ending.
    start : bytes
        Its first `HEAD_BYTES`, or all of it.
    pipeline, rate_hz : optional
        What a person said already; see `guess_of_head`.
    later : sequence of bytes
        Pieces of the rest of the file; see `later_of`.

    Raises
    ------
    RecordingFormatError
        It is no recording, or no table can be made of it.
    """
    stem = PurePath(name).stem
    source = _source(name, start)
    reader = reader_of(recognised(source))
    if reader.name == ZIPPED:
        return _preview_of_zip(name, start, pipeline, rate_hz)
    if not reader.endings & TEXT:
        if (other := reader.against(source)) is not None:
            raise RecordingFormatError(other)
        worn_for = pipeline or pipeline_for(list(reader.announces(source)[0]))
        return Preview(reader.name, cast(PipelineName, reader.pipeline) or worn_for)
    head = head_of(start, later=later)
    if reader.pipeline:
        return Preview(reader.name, cast(PipelineName, reader.pipeline), head)
    if reader.needs_mapping and (tall := tall_of(head)) is not None:
        found = of_tall(tall, guess_of_head(tall.wide, stem, pipeline, rate_hz))
        return Preview(reader.name, found.pipeline, tall.wide, found)
    found = guess_of_head(head, stem, pipeline, rate_hz)
    return Preview(reader.name, found.pipeline, head, found if reader.needs_mapping else None)


def preview_zip(path: Path, pipeline: PipelineName | None = None, rate_hz: float | None = None) -> Preview:
    """Say how several tables of one recording in a zip are to be read; see `preview_text`."""
    from app.readers.tables.several import Tables

    tables = Tables(path)
    found = tables.guess(path.stem, pipeline, rate_hz)
    return Preview(ZIPPED, found.pipeline, tables.head, found)


def _preview_of_zip(name: str, start: bytes, pipeline: PipelineName | None, rate_hz: float | None) -> Preview:
    """Say it of a zip that came as a whole; of a larger one the list of its files is still to come."""
    if len(start) >= HEAD_BYTES:
        return Preview(ZIPPED, pipeline or "orientation")
    with TemporaryDirectory(prefix="telemotion-") as folder:
        path = Path(folder) / "recording.zip"
        path.write_bytes(start)
        return preview_zip(path, pipeline, rate_hz)


def _source(name: str, start: bytes) -> Source:
    source = Source(Path(name))
    # Cached properties may be given: the file itself is not here.
    vars(source).update(start=start, variables=frozenset())
    return source
