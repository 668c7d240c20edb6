"""Wire types of the centre of mass of a body with worn sensors."""

from app.schemas import Schema, Spoken


class MassCentreCurve(Schema):
    """One coordinate over time; None where there is nothing."""

    name: str
    """`ahead`, `left` (both from the middle between the ankles, as the trunk faces) or `height` (above the floor under
    the lower foot)."""
    value_m: list[float | None]
    sigma_m: list[float | None]
    """One sigma: of the sensors, of segments that are assumed, and of the table of the body."""
    least_m: float | None
    most_m: float | None
    """Over the whole result at full rate."""


class MassCentreOut(Spoken):
    """The centre of mass of a result."""

    result_id: str
    time_s: list[float]
    curves: list[MassCentreCurve]
    """Empty when the sensors do not tell it."""
    assumed: list[str]
    """Segments without a sensor: they are taken to move with their neighbour."""
    reason: str
    """Why there is none; empty when there is."""
