"""Wire types of patients, the caseload and progress."""

from datetime import date, datetime
from typing import Literal

from pydantic import Field

from app.schemas import Schema

Side = Literal["left", "right", "both"]


class BodyDimensionsIn(Schema):
    """Measured lengths between joint centres, in metres; what is absent is scaled from stature."""

    stature_m: float | None = Field(default=None, gt=0.5, lt=2.6)
    upper_arm_m: float | None = Field(default=None, gt=0.1, lt=0.6)
    forearm_m: float | None = Field(default=None, gt=0.1, lt=0.5)
    hand_m: float | None = Field(default=None, gt=0.05, lt=0.35)
    shoulder_width_m: float | None = Field(default=None, gt=0.1, lt=0.7)
    trunk_m: float | None = Field(default=None, gt=0.2, lt=0.9)


class PatientIn(Schema):
    """A new patient or a change."""

    given_name: str = Field(min_length=1, max_length=100)
    family_name: str = Field(min_length=1, max_length=100)
    birth_date: date | None = None
    affected_side: Side | None = None
    notes: str = Field(default="", max_length=4000)
    body_dimensions: BodyDimensionsIn = BodyDimensionsIn()


class PatientPatch(Schema):
    """Only the fields to change."""

    given_name: str | None = Field(default=None, min_length=1, max_length=100)
    family_name: str | None = Field(default=None, min_length=1, max_length=100)
    birth_date: date | None = None
    affected_side: Side | None = None
    notes: str | None = Field(default=None, max_length=4000)
    body_dimensions: BodyDimensionsIn | None = None


class PatientOut(PatientIn):
    """A patient."""

    id: str
    created_at: datetime
    archived_at: datetime | None
    has_mounting: bool
    may_treat: bool
    """The caller may record and prescribe, not only read."""


class CaseloadRow(Schema):
    """One line of the caseload."""

    patient_id: str
    given_name: str
    family_name: str
    affected_side: Side | None
    due: str
    """What is prescribed, in a few words; empty when nothing is."""
    last_session_at: datetime | None
    live_session_id: str | None
    main_measure: str | None
    main_unit: str | None
    trend: list[float]
    """The last ten values of the main measure, oldest first."""
    trend_low: list[float]
    trend_high: list[float]
    adherence_percent: float | None
    reason: Literal["live", "declining", "not_practising", "bad_data", "no_template", ""]
    reason_text: str


class ProgressPoint(Schema):
    """One session's value of one measure."""

    session_id: str
    at: datetime
    value: float
    low: float
    high: float
    count: int
    """Repetitions behind the value."""
    orientation: str
    template_version_id: str | None


class ProgressMeasure(Schema):
    """One measure over the sessions."""

    measure: str
    label: str
    unit: str
    points: list[ProgressPoint]
    change: float | None
    """Last three against first three sessions; None with fewer than two points."""
    minimal_detectable_change: float | None
    """1.96 * sqrt(2) * standard error of measurement, from the spread between repetitions."""
    is_real_change: bool | None


class ProgressEvent(Schema):
    """Something pinned to the time axis."""

    at: datetime
    kind: Literal["template", "estimator", "prescription"]
    text: str


class Progress(Schema):
    """A patient's progress in one exercise."""

    exercise_id: str | None
    measures: list[ProgressMeasure]
    events: list[ProgressEvent]
