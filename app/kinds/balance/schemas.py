"""Wire types of a balance test."""

from typing import Literal

from app.recordings.schemas import ResultOut
from app.schemas import Schema, Spoken

Condition = Literal[
    "eyes_open_firm", "eyes_closed_firm", "eyes_open_foam", "eyes_closed_foam", "reach", "unmarked"
]


class BalanceMeasure(Schema):
    """One number of a trial; None where it is not known."""

    measure: str
    value: float | None
    sigma: float | None
    """One standard deviation."""
    unit: str


class EllipseOut(Schema):
    """The ellipse that holds 95 % of the places."""

    long_m: float
    """Half of its longer axis."""
    short_m: float
    angle_rad: float
    """From forward to the longer axis, to the left."""


class TrialOut(Spoken):
    """One trial, from its mark to the next."""

    condition: Condition
    """`unmarked`: a recording without marks, whole."""
    start_s: float
    end_s: float
    measures: list[BalanceMeasure]
    """Empty where it is too short; then `reason` says so."""
    path_m: list[list[float]]
    """Way of the point at `height_m`, forward and left of its middle, 20 a second."""
    ellipse: EllipseOut | None
    reason: str


class RombergOut(Schema):
    """Sway with eyes closed over that with eyes open, of the last trial of each."""

    surface: Literal["firm", "foam"]
    measures: list[BalanceMeasure]


class BalanceTestOut(Spoken):
    """A balance test."""

    session_id: str
    result: ResultOut
    placement: str
    """The sensor that all numbers are of."""
    height_m: float
    """Of the point of which displacement is given, the hips, above the ankles."""
    trials: list[TrialOut]
    romberg: list[RombergOut]
    reasons: list[str]
    """What a reader of the numbers must know."""
