"""Wire types of a walk: footprints, strides, numbers and curves over the gait cycle."""

from datetime import datetime
from typing import Literal

from pydantic import Field

from app.recordings.schemas import ResultOut
from app.schemas import Schema, Spoken

CurveName = Literal[
    "height",
    "speed",
    "force_vertical",
    "force_forward",
    "free_moment",
    "ankle_moment",
    "ankle_power",
    "toe_moment",
    "toe_power",
]


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
    flags: int | None = None
    """Bits of `estimators.gait.StrideFlag`, why it is in no mean; None of walks stored before this was recorded."""


class FootStride(StrideOut):
    """One stride in the list of both feet's, in the order of their contacts."""

    side: Literal["left", "right"]


class CycleCurve(Schema):
    """One quantity over the gait cycle, from a contact of the foot (0 %) to its next (100 %)."""

    name: CurveName
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
    """Of a long walk the first ones; all of them come in pages, see `FootStride`."""
    stride_count: int = 0
    """Of the whole walk."""
    counted_count: int = 0
    """Of them steady and straight."""
    path_m: list[list[float]]
    """x and y of the sensor, 20 a second; of a long walk less."""
    curves: list[CycleCurve]
    turning: list[WalkMeasure] = Field(default_factory=list)
    """Of strides along turns alone; empty where there were none, and of walks stored before this was recorded."""


class SupportOut(Schema):
    """The base of support at one moment: the hull of all that stands on the floor."""

    time_s: float
    outline_m: list[list[float]]
    """x and y, counter-clockwise; empty while nobody stands."""


class BalanceOut(Schema):
    """Centre of mass and pressure of a walk on instrumented shoes, in the room of the frames."""

    mass_kg: float
    apart_m: float
    apart_source: Literal["measured", "forces", "usual"]
    """Who says how far the feet stand apart at the start: a person, the forces, or nobody."""
    measures: list[WalkMeasure]
    time_s: list[float]
    """20 a second."""
    centre_m: list[list[float]]
    """x, y and z of the centre of mass."""
    centre_sigma_m: list[float]
    pressure_m: list[list[float]]
    """x and y of the centre of pressure of both feet."""
    margin_m: list[float | None]
    """Margin of stability: positive while the extrapolated centre of mass is over the base of support."""
    support: list[SupportOut]
    """About five a second."""


class WalkTestOut(Spoken):
    """Result of a walking test, found off-line."""

    kind: Literal["walk", "timed_up_and_go", "six_minute_walk"]
    start_s: float
    end_s: float
    time_s: float
    """From the first step to the last that counts."""
    distance_m: float
    distance_sigma_m: float
    speed_mps: float | None
    step_count: int
    turn_count: int
    pause_count: int
    turn_s: float | None
    """Spent turning about; None without such a turn."""
    minutes_m: list[float]
    """Distance within each minute begun."""
    reasons: list[str]


class WalkContent(Spoken):
    """What is stored of a walk with its result."""

    feet: list[FootOut]
    both: list[WalkMeasure]
    asymmetry: list[WalkMeasure]
    turn_count: int
    bout_count: int
    reasons: list[str]
    """What could not be given, and why."""
    has_step_width: bool
    """Whether the sideways distance of the feet is measured; otherwise they are drawn 15 cm apart."""
    test: WalkTestOut | None = None
    """None when nobody took a stride."""
    balance: BalanceOut | None = None
    """None without forces of both feet."""


class WalkRow(Schema):
    """One walk in the list of a patient."""

    session_id: str
    started_at: datetime
    exercise_name: str | None
    kind: Literal["walk", "timed_up_and_go", "six_minute_walk"]
    time_s: float | None
    distance_m: float | None
    speed_mps: float | None
    stride_count: int


class ConditionsIn(Schema):
    """Which walks are which condition; as many of both, two at least, are taken as pairs in this order."""

    a: list[str] = Field(min_length=1, max_length=50)
    b: list[str] = Field(min_length=1, max_length=50)


class MeasureChange(Schema):
    """What the condition changes in one measure of one foot, or of both."""

    measure: str
    foot: Literal["left", "right", "both"]
    unit: str
    a: float
    b: float
    difference: float
    """B less A."""
    sigma: float | None
    """Standard error of the difference."""
    p: float | None
    """Probability of such a difference by chance."""
    effect: float | None
    """Difference over its standard deviation."""
    count: int
    """Pairs, or strides."""
    method: Literal["pairs", "strides"]


class ConditionsOut(Schema):
    """Two conditions compared."""

    method: Literal["pairs", "strides"]
    """`pairs`: repeated-measures model over pairs of walks. `strides`: all strides of a condition, Welch's test."""
    changes: list[MeasureChange]


class GaitOut(WalkContent):
    """The walk of a result: of a long one the first strides, footholds and seconds of balance."""

    session_id: str
    result: ResultOut


class FootCurve(Schema):
    """One channel of a foot over time; None where it was not tracked."""

    channel: str
    """As in a template of the walk, such as `foot_height_right_m`."""
    value: list[float | None]
    """rad, m or m/s by the end of its name."""
    sigma: list[float | None]


class FootCurvesOut(Schema):
    """What the feet of a walk did over time."""

    result_id: str
    time_s: list[float]
    curves: list[FootCurve]
