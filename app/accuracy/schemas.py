"""Wire types of the accuracy page: what `telemotion validate --json` prints and `GET /api/accuracy` returns."""

from datetime import datetime
from typing import Literal

from pydantic import Field

from app.schemas import Schema

AccuracyVerdict = Literal["pass", "open", "short"]


class AccuracyFigure(Schema):
    """One number of an experiment: published, required and ours.

    `median`, `worst` and `spread` (standard deviation) are over the values; the worst is that farthest toward the
    limit. Null means that it could not be measured.
    """

    name: str
    unit: str
    published: float | None
    required: float | None = Field(description="The limit; null for figures that are only shown.")
    at_most: bool = Field(description="The limit is an upper one; otherwise a lower one.")
    judged_by: Literal["worst", "median", "mean"]
    median: float | None
    worst: float | None
    spread: float | None
    values: list[float | None] = Field(description="One a seed, a batch of seeds or a recording; see `each`.")
    each: Literal["seed", "batch", "recording"]
    judged: float | None = Field(
        description="What is held against the limit: of seeds the median, the mean or what nine in ten reach, of "
        "batches the mean, of recordings the median, the mean or the worst."
    )
    low: float | None = Field(description="Lower end of its 95 % confidence interval; recordings have none.")
    high: float | None = Field(description="Upper end of the interval.")
    verdict: AccuracyVerdict = Field(description="`open`: the limit lies within the interval.")


class AccuracyCurve(Schema):
    """One line of a plot; null makes a hole in it."""

    name: str
    x: list[float | None]
    y: list[float | None]


class AccuracyPlot(Schema):
    """Curves on common axes, measured with the first seed: error over time, Allan deviation, residuals."""

    title: str
    x_label: str
    x_unit: str
    y_label: str
    y_unit: str
    logarithmic: bool = Field(description="Both axes.")
    curves: list[AccuracyCurve]


class AccuracyProtocol(Schema):
    """One published experiment with its figures and plots."""

    name: str
    title: str
    source: str
    what: str
    verdict: AccuracyVerdict
    seeds: int
    first_seed: int
    seconds: float
    figures: list[AccuracyFigure]
    plots: list[AccuracyPlot]


class AccuracyReport(Schema):
    """A whole run, and what it was run with.

    `data` names the recordings that were given. The seeds are `first_seed` and those after it; an experiment that was
    measured again by itself names its own.
    """

    format: Literal[2] = 2
    version: str = Field(description="Version of Telemotion that was measured.")
    made_at: datetime
    command: str = Field(description="What to type to measure again.")
    seeds: int
    first_seed: int
    machine: str
    data: list[str]
    seconds: float
    protocols: list[AccuracyProtocol]
