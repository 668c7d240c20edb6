"""Wire types of what a file seems to be, before anything of it is uploaded."""

from typing import Annotated, Literal

from pydantic import Base64Bytes, Field

from app.readers.tables.schemas import GuessedMapping
from app.schemas import Schema, Spoken

_Axes = list[list[float | None]]


class PreviewIn(Schema):
    """The beginning of a file whose format is to be guessed."""

    file_name: str = Field(max_length=200)
    """With its ending; may say the side of a foot."""
    beginning: Base64Bytes = Field(max_length=360_000)
    """The first 256 KiB, or the whole file."""
    later: list[Annotated[Base64Bytes, Field(max_length=45_000)]] = Field(default_factory=list, max_length=12)
    """Of a longer file up to 12 pieces of 32 KiB, spread over its rest, the last one its end."""
    pipeline: Literal["arm", "gait", "orientation"] | None = None
    """What it is for, where a person said so."""
    rate_hz: float | None = Field(default=None, gt=0)
    """Samples a second, where a person said it: a counter is then a clock, and how far a sensor turns tells units."""
    mapping: GuessedMapping | None = None
    """As a person has changed the guess; None: the guess."""
    hemisphere: Literal["north", "south", "unknown"] | None = None
    """Of `UploadIn`. None: where the service is."""


class SensorPreview(Spoken):
    """A sensor of a table as it is taken, with its first seconds."""

    where: str
    """Where it is worn, or what it is called."""
    sentence: str
    """Its columns, units and clock."""
    time_s: list[float]
    """Empty while it is not mapped whole, or has no sample in the beginning."""
    gyroscope_radps: _Axes
    """x, y and z, each as long as `time_s`; null where there is no number."""
    accelerometer_mps2: _Axes
    magnetometer_t: _Axes
    """Empty without a magnetometer."""


class TablePreview(Spoken):
    """What a file seems to be, from its beginning; nothing of it was stored."""

    format: str
    """Of `UploadIn`."""
    pipeline: Literal["arm", "gait", "orientation"]
    """What the recording seems to be for."""
    columns: list[str]
    rows: list[list[str]]
    """The first rows of data."""
    skipped_lines: int
    mapping: GuessedMapping | None
    """How to read a table of the format `csv`: as a person said, else as far as names and numbers say it."""
    sensors: list[SensorPreview]
    """Those of the mapping; `telemotion process --guess` prints the same sentences."""
    notes: list[str]
    """What is assumed or left out."""
    missing: list[str]
    """What a person must add."""
    doubts: list[str]
    """Why it cannot be read so, or cannot be right so, by its beginning."""
