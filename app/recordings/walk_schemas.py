"""Wire types of a walk: footprints, strides, numbers and curves over the gait cycle."""

from typing import Literal

from app.recordings.schemas import ResultOut
from app.schemas import Schema


class WalkMeasure(Schema):
    """One number of a walk; None where it is not known."""

    measure: str
    value: float | None
    """Mean over the strides that count; of asymmetries left less right over their mean."""
    sigma: float | None
    """Standard error of the mean: strides and sensors."""
    spread: float | None
    """Standard deviation over the strides."""
    count: int
    unit: str


class FootholdOut(Schema):
    """Where a foot stood, in the room of the frames: x along the walk, z up."""

    start_s: float
    stop_s: float
    x_m: float
    y_m: float
    z_m: float
    heading_rad: float
    """Where the toes point, about z from x, left positive."""
    sigma_m: float
    """Standard deviation of the place since the start, the larger of both directions."""


class StrideOut(Schema):
    """One stride, from a foothold to the next of the same foot; None where it is not known."""

    number: int
    bout: int
    toe_off_s: float | None
    contact_s: float | None
    length_m: float | None
    length_sigma_m: float | None
    duration_s: float | None
    stance_s: float | None
    swing_s: float | None
    rise_m: float | None
    clearance_m: float | None
    circumduction_m: float | None
    contact_pitch_rad: float | None
    toe_off_pitch_rad: float | None
    toe_out_rad: float | None
    turn_rad: float | None
    peak_speed_mps: float | None
    is_counted: bool
    """Steady and straight: in the means."""
    is_initiation: bool
    is_termination: bool


class CycleCurve(Schema):
    """One quantity over the gait cycle, from a contact of the foot (0 %) to its next (100 %)."""

    name: Literal["height", "speed"]
    unit: str
    mean: list[float]
    """At 0, 2, ... 100 %."""
    spread: list[float]
    """Standard deviation over the cycles."""
    cycle_count: int


class FootOut(Schema):
    """One foot."""

    side: Literal["left", "right"]
    measures: list[WalkMeasure]
    footholds: list[FootholdOut]
    """One more than strides."""
    strides: list[StrideOut]
    path_m: list[list[float]]
    """x and y of the sensor, 20 a second."""
    curves: list[CycleCurve]


class WalkContent(Schema):
    """What is kept of a walk with its result."""

    feet: list[FootOut]
    both: list[WalkMeasure]
    asymmetry: list[WalkMeasure]
    turn_count: int
    bout_count: int
    reasons: list[str]
    """What could not be given, and why."""
    has_step_width: bool
    """Whether the sideways distance of the feet is measured; otherwise they are drawn 15 cm apart."""


class GaitOut(WalkContent):
    """The walk of a result."""

    session_id: str
    result: ResultOut


__all__ = ["CycleCurve", "FootOut", "FootholdOut", "GaitOut", "StrideOut", "WalkContent", "WalkMeasure"]
