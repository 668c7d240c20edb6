"""Wire types of exercises, templates and prescriptions."""

from datetime import datetime
from typing import Literal

from pydantic import Field

from app.schemas import Moment, Schema, Spoken


class ExerciseIn(Schema):
    """A new exercise."""

    name: str = Field(min_length=1, max_length=200)
    description: str = Field(default="", max_length=2000)
    movement: Literal[
        "reaching",
        "drinking",
        "abduction",
        "flexion",
        "pronation",
        "other",
        "walk",
        "timed_up_and_go",
        "six_minute_walk",
    ]
    side: Literal["left", "right"] = "right"
    primary_angle: str = Field(default="", max_length=80)
    """Empty for walks, which are judged by time and distance."""


class ExerciseOut(ExerciseIn):
    """An exercise."""

    id: str


class RepetitionOut(Spoken):
    """One repetition found in a recording, in session time."""

    number: int
    start_s: float
    end_s: float
    is_kept: bool
    reason: str
    """Why it was dropped; empty when accepted."""


class PhaseCurve(Schema):
    """One channel over 101 phases: mean and tolerance band."""

    channel: str
    label: str
    unit: str
    mean: list[float | None]
    low: list[float | None]
    high: list[float | None]
    """None at phases that were not measured (gaps, singular postures)."""
    repetitions: list[list[float | None]]
    """Every repetition's curve; dropped ones too, in the order of the repetitions."""


class TemplateContent(Schema):
    """What a template looks like."""

    duration_s: float
    repetitions: list[RepetitionOut]
    curves: list[PhaseCurve]
    movement_onset_phases: list[int] = Field(default_factory=list)


class TemplatePreviewIn(Schema):
    """Cut a recorded session into repetitions and average them, without storing anything."""

    session_id: str
    result_id: str | None = None
    dropped: list[int] | None = None
    """Numbers of the repetitions to leave out: all others are accepted, odd ones too, so [] accepts everything.
    None lets the service decide."""
    tolerance_scale: dict[str, float] = Field(default_factory=dict)
    """Factor on the band per channel, 1 when absent."""


class TemplateIn(TemplatePreviewIn):
    """Store a template (its first version) or, with `template_id`, a further version of it."""

    exercise_id: str
    patient_id: str | None = None
    template_id: str | None = None
    name: str = Field(min_length=1, max_length=200)


class TemplateVersionOut(Schema):
    """A version without its curves."""

    id: str
    number: int
    created_at: datetime
    repetition_count: int
    source_session_id: str


class TemplateOut(Schema):
    """A template with its versions, newest first."""

    id: str
    exercise_id: str
    patient_id: str | None
    name: str
    created_at: datetime
    versions: list[TemplateVersionOut]


class TemplateVersionDetail(TemplateVersionOut):
    """A version with its curves."""

    template_id: str
    name: str
    content: TemplateContent


class PrescriptionIn(Schema):
    """Prescribe an exercise."""

    exercise_id: str
    template_id: str | None = None
    repetitions: int = Field(default=10, ge=1, le=200)
    sets: int = Field(default=1, ge=1, le=20)
    times_per_week: int = Field(default=5, ge=1, le=28)
    starts_at: Moment | None = None
    ends_at: Moment | None = None


class PrescriptionOut(Schema):
    """A prescription with the names a person needs."""

    id: str
    exercise_id: str
    exercise_name: str
    template_id: str | None
    template_name: str | None
    repetitions: int
    sets: int
    times_per_week: int
    starts_at: datetime
    ends_at: datetime | None
    done_this_week: int
    """Sessions since Monday, by the clinic's clocks, in which something valid was done; each counts once."""
    repetitions_this_week: int
    """Valid repetitions of these sessions; 0 for walks."""
    active_s_this_week: float
    """Time inside these repetitions, in steady strides or in movement."""
    is_twice: bool
    """Whether the same exercise is prescribed a second time: each session counts for one of the two."""
