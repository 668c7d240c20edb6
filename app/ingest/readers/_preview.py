"""What a file seems to be, from its name and its beginning: the format, and of a table how to read it."""

from dataclasses import dataclass
from pathlib import PurePath
from typing import Final

from app.ingest.readers import _gait_tracking, _gaitmap, _instrumented_shoe
from app.ingest.readers._csv_guess import Guess, PipelineName, guess_of_head, pipeline_for
from app.ingest.readers._table_head import TableHead, head_of
from app.ingest.readers._text import encoding_of

_OF_MAKERS: Final = {
    "gait_tracking": _gait_tracking.looks_like,
    "instrumented_shoe": _instrumented_shoe.looks_like,
    "gaitmap": _gaitmap.looks_like,
}


@dataclass(frozen=True)
class Preview:
    """What a file seems to be.

    Attributes
    ----------
    format : str
        Of `FORMATS`.
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
    head = head_of(start)
    format = text_format(stem, start)
    if format != "csv":
        return Preview(format, "gait", head)
    found = guess_of_head(head, stem, pipeline, rate_hz)
    return Preview(format, found.pipeline, head, found)


def text_format(stem: str, start: bytes) -> str:
    """Return the format that a text file seems to have.

    Parameters
    ----------
    stem : str
        Its name without the ending.
    start : bytes
    """
    if encoding_of(start).startswith("utf-8"):
        for format, looks_like in _OF_MAKERS.items():
            if looks_like(stem, start):
                return format
    return "csv"


__all__ = ["Preview", "pipeline_for", "preview_text", "text_format"]
