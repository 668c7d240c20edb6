"""Wire types of tables: which columns hold what; see docs/mapping.md."""

from typing import Literal

from pydantic import Field

from app.schemas import Schema
from estimators.conventions import Placement


class CsvColumn(Schema):
    """Where one axis triple stands in a CSV file."""

    placement: Placement | None = None
    """Where the sensor is worn; None for a single sensor that is worn nowhere in particular."""
    sensor: str = Field(default="", max_length=60)
    """What a sensor is called in the table: tells those without placement apart."""
    quantity: Literal["gyroscope", "accelerometer", "magnetometer"]
    columns: list[str] = Field(min_length=3, max_length=3)
    unit: Literal["rad/s", "deg/s", "mdps", "m/s^2", "g", "mg", "T", "uT", "mT", "G", "mG"]


class CsvMapping(Schema):
    """How to read a table: time column with its unit, or a fixed rate, and the columns of each sensor.

    Names of columns are those of docs/mapping.md: header lines joined, repeated names numbered.
    """

    time_column: str | None = None
    time_unit: Literal["s", "ms", "us", "ns", "clock"] = "s"
    """`clock`: text with a time of day, with or without a date and a zone."""
    rate_hz: float | None = Field(default=None, gt=0)
    delimiter: Literal[",", ";", "\t", "|", " "] | None = None
    """What stands between the columns; a blank for any number of blanks; None to have it found."""
    signals: list[CsvColumn]


__all__ = ["CsvColumn", "CsvMapping"]
