"""Wire types of tables: which columns hold what; see docs/mapping.md."""

from typing import Annotated, Literal

from pydantic import BeforeValidator, Field

from app.readers.sensor_names import PATTERN
from app.schemas import Schema
from estimators.conventions import Placement

Unit = Literal["rad/s", "deg/s", "mdps", "m/s^2", "g", "mg", "T", "uT", "mT", "G", "mG", "local"]
"""`local`: multiples of the field where the magnetometer was calibrated, as makers write it."""


class _Column(Schema):
    placement: Placement | None = None
    """Where the sensor is worn; None for a single sensor that is worn nowhere in particular."""
    sensor: str = Field(default="", max_length=60, pattern=PATTERN)
    """What a sensor is called in the table: tells those without placement apart."""
    quantity: Literal["gyroscope", "accelerometer", "magnetometer"]
    columns: list[str] = Field(min_length=3, max_length=3)
    """x, y and z in the frame of the sensor; `-name` where the axis points the other way and no column is called so."""
    sign: Literal[1, -1] = 1
    """-1 where all three have the other sign: an accelerometer that gives gravity instead of specific force."""
    rows: dict[str, str] = Field(default_factory=dict, max_length=3)
    """Which rows hold it, where rows of several devices or of several kinds take turns: a column, and what it holds."""
    time_column: str | None = None
    """A clock of its own, in the unit of the mapping; None: that of the mapping."""


class CsvColumn(_Column):
    """Where one axis triple stands in a CSV file."""

    unit: Unit


class GuessedColumn(_Column):
    """Where one axis triple seems to stand."""

    unit: Annotated[Unit | None, BeforeValidator(lambda said: said or None)]
    """None where neither a heading nor the size of the numbers says it."""


class _Mapping(Schema):
    time_column: str | None = None
    time_unit: Literal["s", "ms", "us", "ns", "clock", "count"] = "s"
    """`clock`: text with a time of day, with or without a date and a zone. `count`: a counter that takes its usual step
    `rate_hz` times in a second; a hole in it is a hole in time."""
    rate_hz: float | None = Field(default=None, gt=0)
    delimiter: Literal[",", ";", "\t", "|", " "] | None = None
    """What stands between the columns; a blank for any number of blanks; None to have it found."""


class CsvMapping(_Mapping):
    """How to read a table: time column with its unit, or a fixed rate, and the columns of each sensor.

    Names of columns are those of docs/mapping.md: header lines joined, repeated names numbered.
    """

    signals: list[CsvColumn]


class GuessedMapping(_Mapping):
    """How a table seems to be read, until a person has completed it to a `CsvMapping`."""

    signals: list[GuessedColumn]
