"""Wire types of curves over time."""

from app.schemas import Schema, Spoken


class CurveOut(Schema):
    """One number over time; None where there is nothing."""

    series: str
    """The one that it was asked for with."""
    name: str
    unit: str
    value: list[float | None]
    sigma: list[float | None] | None
    """One sigma; None where nobody can say."""
    least: float | None
    most: float | None
    """Over the whole time that was asked for, at full rate."""


class SeriesOut(Spoken):
    """Curves of a result."""

    result_id: str
    time_s: list[float]
    curves: list[CurveOut]
    reasons: dict[str, str]
    """Of each series that this result cannot have: why."""
    unworn: list[str]
    """Places without a sensor: a segment there is taken to move with its neighbour."""
