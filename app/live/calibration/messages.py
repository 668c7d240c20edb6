"""Wire types of guided calibration: what can be calibrated, and how far a running step is."""

import math
from typing import Literal

from pydantic import Field

from app.recordings.schemas import CalibrationOut
from app.schemas import Schema, Spoken
from estimators.calibration import LocalField
from estimators.conventions import Placement

CalibrationKind = Literal[
    "static_bias",
    "six_position",
    "magnetometer",
    "n_pose",
    "t_pose",
    "functional",
    "passive",
    "heading_reset",
]
Phase = Literal["collecting", "evaluating", "done", "redo", "cancelled"]
Limb = Literal["left_arm", "right_arm", "trunk", "legs"]
Picture = Literal[
    "lie_still",
    "face_x_up",
    "face_x_down",
    "face_y_up",
    "face_y_down",
    "face_z_up",
    "face_z_down",
    "turn_x",
    "turn_y",
    "turn_z",
    "turn_all_ways",
    "n_pose",
    "t_pose",
    "elbow_flexion",
    "pronation",
    "raise_forward",
    "raise_sideways",
    "seated_rest",
    "seated_elbow_flexion",
    "seated_pronation",
    "seated_raise_forward",
    "seated_raise_sideways",
    "arm_hanging",
]
"""Which drawing the browser shows beside a step."""


class CalibrationStep(Spoken):
    """One thing to do."""

    key: str
    """`rest`, `pose`, `elbow_flexion`, `face_x_up`, `turn_z`, `turn_all_ways`, ..."""
    title: str
    instruction: str
    picture: Picture
    ends: Literal["itself", "next"]
    """`itself`: seen on the stream when it is done. `next`: a person says so, by `calibration/next`."""


class CalibrationGuide(Spoken):
    """One kind of calibration, for the choice and for the guide beside the live view."""

    kind: CalibrationKind
    title: str
    summary: str
    """What it finds and when to do it, one or two plain sentences."""
    worn: bool
    """Sensors are on the patient; otherwise in the hand or on a table."""
    one_sensor: bool
    """Done with the sensors named, in the hand; the others are left alone."""
    steps: list[CalibrationStep]


class CalibrationIn(Schema):
    """Begin a guided calibration on a live session."""

    kind: CalibrationKind
    placements: list[Placement] = Field(default_factory=list, max_length=17)
    """Of sensors in the hand (`six_position`, `magnetometer`); empty means all of the session."""
    limbs: list[Limb] = Field(default_factory=list, max_length=4)
    """Of `heading_reset`; empty means every limb that is worn. Of `functional` and `passive`: the arms that move;
    empty means those with sensors on upper arm and forearm."""


class SensorProgress(Spoken):
    """How far one sensor is."""

    placement: Placement
    progress: float
    """0 to 1."""
    hint: str = ""
    is_done: bool = False
    coverage: float | None = None
    """`magnetometer`: share of all directions that the field was seen in, 0 to 1."""
    visited: list[bool] = Field(default_factory=list)
    """`magnetometer`: for each direction of `directions`, whether it was visited."""
    residual_percent: float | None = None
    """`magnetometer`: how much the norm still varies after the fit."""
    heading_sigma_deg: float | None = None
    found: list[str] = Field(default_factory=list)
    """`six_position`: keys of the steps that were seen, in any order."""


class AxisOut(Schema):
    """One movement as it was seen."""

    name: str
    """`elbow_flexion_right`, ..."""
    range_deg: float
    sigma_deg: float


class FieldOut(Schema):
    """The earth's magnetic field as one sensor saw it while it was calibrated."""

    placement: Placement
    norm_ut: float
    """In microtesla; the earth's is 25 to 65."""
    dip_deg: float | None = None
    """Below the horizontal; null when the sensor was never quiet."""
    norm_before_ut: float | None = None
    """At the sensor's calibration before this one."""
    dip_before_deg: float | None = None
    is_plausible: bool = True
    """Whether it can be the earth's alone; else `reasons` say why not."""

    @classmethod
    def of(
        cls, placement: Placement, seen: LocalField, before: LocalField | None, is_plausible: bool
    ) -> "FieldOut":
        """Return what is reported of a field."""
        return cls(
            placement=placement,
            norm_ut=round(1e6 * seen.norm, 1),
            dip_deg=_degrees(seen),
            norm_before_ut=None if before is None else round(1e6 * before.norm, 1),
            dip_before_deg=None if before is None else _degrees(before),
            is_plausible=is_plausible,
        )


def _degrees(field: LocalField) -> float | None:
    return round(math.degrees(field.dip_rad), 1) if math.isfinite(field.dip_rad) else None


class SensorFinding(Spoken):
    """A sensor that does not sit where it should."""

    code: Literal["swapped_sides", "swapped_segments", "turned", "moved_since", "faulty"]
    placements: list[Placement]
    text: str
    """Plain words: which sensor, and what to do."""


class CalibrationMessage(Spoken):
    """Live socket: a guided calibration, on every change and at most five times a second; also on connecting."""

    type: Literal["calibration"] = "calibration"
    kind: CalibrationKind
    phase: Phase
    """`done`: in force and stored. `redo`: not usable, see `reasons`; what was in force stays in force."""
    steps: list[CalibrationStep]
    step: int
    """Index of the present one; the number of steps when all are done."""
    step_progress: float
    """0 to 1; of steps that a person ends, how much of the least time has passed."""
    hint: str
    """What the person should do or mend now."""
    sensors: list[SensorProgress] = Field(default_factory=list)
    directions: list[tuple[float, float, float]] = Field(default_factory=list)
    """`magnetometer`: unit vectors in sensor axes, the same in every message; `visited` refers to them."""
    score: float | None = None
    """0 to 1, when `done` (or `redo`, if it came to a score)."""
    reasons: list[str] = Field(default_factory=list)
    """What lowered the score, or why it cannot be used, with what to do."""
    redo_steps: list[str] = Field(default_factory=list)
    """Keys of the steps to repeat."""
    axes: list[AxisOut] = Field(default_factory=list)
    findings: list[SensorFinding] = Field(default_factory=list)
    fields: list[FieldOut] = Field(default_factory=list)
    """`magnetometer`, when `done`."""
    result: CalibrationOut | None = None
