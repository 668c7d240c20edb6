"""Wire types of the points of interest."""

from app.schemas import Schema


class PointCurve(Schema):
    """One point over time; None where there is nothing."""

    name: str
    """Of the layout, e.g. `wrist_right`."""
    position_m: list[list[float | None]]
    """x, y and z in the room: x where the patient faces, z up."""
    sigma_m: list[list[float | None]]
    """One-sigma of each, from orientations and segment lengths; None throughout where the method tells none, and of
    live results."""
    speed_mps: list[float | None]
    acceleration_mps2: list[float | None]
    """Of the point's own movement, without gravity; its size."""


class PointsOut(Schema):
    """Elbows, wrists and hands of a result."""

    result_id: str
    time_s: list[float]
    points: list[PointCurve]
