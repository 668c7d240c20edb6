"""Wire types of exercises, templates and prescriptions."""

from datetime import datetime
from typing import Annotated, Any, Literal

from pydantic import Field

from app.exercises.design import PhaseDesign, StopDesign, TemplateDesign
from app.exercises.models import Posture
from app.schemas import Flag, Moment, Schema, Spoken, may_be_absent, without_default


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
    posture: Posture = "standing"
    """How it is done; the figure sits when the exercise does."""


class ExerciseOut(ExerciseIn):
    """An exercise."""

    id: str


class ExerciseChange(Schema):
    """Change how an exercise is called, described or shown; what is measured stays."""

    name: str = may_be_absent(min_length=1, max_length=200)
    description: str = may_be_absent(max_length=2000)
    posture: Posture = may_be_absent()


class RepetitionOut(Spoken):
    """One repetition found in a recording, in session time."""

    number: int
    start_s: float
    end_s: float
    is_kept: bool
    reason: str
    """Why it was dropped; empty when accepted."""
    counted: Literal["", "valid", "partial", "wrong"] = ""
    """How it was counted while it was made; empty where nothing was counted."""


class PhaseCurve(Schema):
    """One channel over 101 phases: mean and tolerance band as the therapist drew it."""

    channel: str
    label: str
    unit: str
    mean: list[float | None]
    low: list[float | None]
    high: list[float | None]
    """None at phases that were not measured (gaps, singular postures), and of a limit also where it is free."""
    width: list[float | None] = Field(default_factory=list)
    """Half width of the band as it was recorded, to which a design's factors apply."""
    is_judged: bool = True
    """False for what is only watched: shown, never called outside."""
    repetitions: list[list[float | None]]
    """Every repetition's curve; dropped ones too, in the order of the repetitions."""


class TemplateMeasure(Schema):
    """A measure that a repetition beside this template has."""

    measure: str
    label: str
    unit: str
    value: float | None
    """The template's own, the mean of its repetitions; None of what is measured against it."""


class TemplateContent(Schema):
    """What a template looks like."""

    duration_s: float
    repetitions: list[RepetitionOut]
    curves: list[PhaseCurve]
    phases: list[PhaseDesign] = Field(default_factory=list)
    """As the therapist named them."""
    movement_onset_phases: list[int] = Field(default_factory=list)
    measures: list[TemplateMeasure] = Field(default_factory=list)
    """Of which a weighted sum may be made."""
    side: Literal["left", "right"] = "right"
    sides: list[Literal["left", "right"]] = Field(default_factory=list)
    """Of a preview: sides to choose from, where a movement is one of both as a walk is."""


class TemplatePreviewIn(Schema):
    """Cut a recorded session into repetitions and average them, without storing anything."""

    session_id: str
    result_id: str | None = None
    dropped: list[int] | None = None
    """Numbers of the repetitions to leave out: all others are accepted, odd ones too, so [] accepts everything.
    None lets the service decide."""
    tolerance_scale: dict[str, float] = Field(default_factory=dict)
    """Factor on the band per channel, 1 when absent."""
    side: Literal["left", "right"] | None = None
    """Of a movement of both sides, as a walk: whose foot; None: that of the affected side. Others have the side of
    their exercise."""


class TemplateIn(TemplatePreviewIn):
    """Store a template (its first version) or, with `template_id`, a further version of it."""

    exercise_id: str
    patient_id: str | None = None
    template_id: str | None = None
    name: str = Field(min_length=1, max_length=200)
    phases: list[PhaseDesign] | None = Field(default=None, max_length=12)
    """That it begins with; None: those of the preview, stance and swing of a walk, otherwise none."""


class TemplateVersionOut(Schema):
    """A version without its curves."""

    id: str
    number: int
    created_at: datetime
    repetition_count: int
    source_session_id: str
    reason: str
    """Why this version was made; empty for the first."""
    made_by: str
    """Name of the person who made it."""


class TemplateOut(Schema):
    """A template with its versions, newest first."""

    id: str
    exercise_id: str
    patient_id: str | None
    name: str
    tags: list[str]
    retired_at: datetime | None
    """Set when it is no longer offered for new prescriptions."""
    created_at: datetime
    versions: list[TemplateVersionOut]


class TemplateVersionDetail(TemplateVersionOut, Spoken):
    """A version with its curves, and what was drawn on them."""

    template_id: str
    exercise_id: str
    patient_id: str | None
    name: str
    side: Literal["left", "right"]
    primary_channel: str
    is_guided: bool = True
    """Somebody can follow it while they exercise: it has cues and stop rules. A walk is compared afterwards only."""
    reach_m: float
    """Upper arm plus forearm of the person recorded; each patient sees positions in their own size."""
    design: TemplateDesign
    """With the rules of the house written out where the therapist left them."""
    troubles: list[str] = Field(default_factory=list)
    """Stored rules that the recording itself or the patient's resting pose breaks, in words; they need changing."""
    content: TemplateContent


class TemplateVersionIn(Schema):
    """Draw on a version: makes a further version of the same recording; versions never change."""

    based_on: str = Field(max_length=32)
    """Version whose recording is drawn on."""
    design: TemplateDesign
    reason: str = Field(min_length=1, max_length=500)
    """Why, for whoever reads the history."""


Tag = Annotated[str, Field(min_length=1, max_length=40)]


class TemplateChange(Schema):
    """Change what a template is called or where it is found; its versions stay as they are."""

    name: str = may_be_absent(min_length=1, max_length=200)
    tags: list[Tag] = may_be_absent(max_length=20)
    """Words by which it is found; capitals do not count."""
    is_retired: Flag = may_be_absent()
    """Retired, it is not offered for new prescriptions; those that have it go on."""


class TemplateCopyIn(Schema):
    """Copy a version as a new template, mirrored where the exercise is of the other side."""

    exercise_id: str | None = Field(default=None, max_length=32)
    """None: the same exercise of the other side, which is added where the clinic has none."""
    patient_id: str | None = Field(default=None, max_length=32)
    """For this patient only; None: for the whole clinic, which a patient's template cannot become."""
    name: str = Field(min_length=1, max_length=200)
    reason: str = Field(min_length=1, max_length=500)


TimeOfDay = Annotated[str, Field(pattern=r"^([01]\d|2[0-3]):[0-5]\d$")]


class PrescriptionIn(Schema):
    """Prescribe an exercise."""

    exercise_id: str
    template_id: str | None = None
    repetitions: int = Field(default=10, ge=1, le=200)
    sets: int = Field(default=1, ge=1, le=20)
    times_per_week: int = Field(default=5, ge=1, le=28)
    """Where `days` are given, it is their number times that of `times`, whatever is sent."""
    days: list[Annotated[int, Field(ge=1, le=7)]] = Field(default_factory=list, max_length=7)
    """Days of the week, 1 Monday to 7 Sunday; empty: any day."""
    times: list[TimeOfDay] = Field(default_factory=list, max_length=4)
    """Times of these days by the clinic's clocks, `HH:MM`; empty: any time."""
    tolerance_scale: float = Field(default=1.0, ge=0.5, le=3.0)
    """Factor on the whole band of the template for this patient."""
    stops: list[StopDesign] = Field(default_factory=list, max_length=20)
    """Stop rules of this patient besides those of the template, named for the exercise's side."""
    question: str = Field(default="", max_length=200)
    """Asked after each session besides pain and effort, answered from 0 to 10; empty: nothing more."""
    starts_at: Moment | None = None
    ends_at: Moment | None = None


class PrescriptionChangeIn(Schema):
    """Change what is prescribed; the exercise and its beginning stay, and so do the sessions made for it."""

    number: int = Field(ge=1)
    """`PrescriptionOut.number` of what was seen: somebody else's change in between is a conflict, not lost."""
    template_id: str | None = Field(default=None, json_schema_extra=without_default)
    repetitions: int = may_be_absent(ge=1, le=200)
    sets: int = may_be_absent(ge=1, le=20)
    times_per_week: int = may_be_absent(ge=1, le=28)
    days: list[Annotated[int, Field(ge=1, le=7)]] = may_be_absent(max_length=7)
    times: list[TimeOfDay] = may_be_absent(max_length=4)
    tolerance_scale: float = may_be_absent(ge=0.5, le=3.0)
    stops: list[StopDesign] = may_be_absent(max_length=20)
    question: str = may_be_absent(max_length=200)
    ends_at: Moment | None = Field(default=None, json_schema_extra=without_default)


class PrescriptionChangeOut(Schema):
    """What a prescription was until it was changed."""

    changed_at: datetime
    changed_by: str
    """Name of the person."""
    before: dict[str, Any]
    """The fields that were changed, as they were; of a template its name."""


class PrescriptionOut(Spoken):
    """A prescription with the names a person needs."""

    id: str
    exercise_id: str
    exercise_name: str
    template_id: str | None
    template_name: str | None
    repetitions: int
    sets: int
    times_per_week: int
    days: list[int]
    times: list[str]
    tolerance_scale: float
    stops: list[StopDesign]
    question: str
    starts_at: datetime
    ends_at: datetime | None
    is_due_today: bool
    """Whether today, by the clinic's clocks, is one of its days and it has begun; done or not."""
    goal: int
    """Valid repetitions of one of its times a day; 0 where no template counts them, so that a session is a time."""
    goal_done: int
    """Of these how many are done of the time that is open now; when all of today are done, of the last one."""
    done_today: int
    """How many of its times a day are done today: goals reached, or sessions where there is none."""
    done_this_week: int
    """Sessions since Monday, by the clinic's clocks, in which something valid was done; each counts once."""
    pain_stops_this_week: int = 0
    """Sessions since Monday that ended because it hurt, those among `done_this_week` and those in which nothing valid
    was done."""
    repetitions_this_week: int
    """Valid repetitions of these sessions; 0 for walks."""
    active_s_this_week: float
    """Time inside these repetitions, in steady strides or in movement."""
    number: int = 1
    """Which state of it this is; a change names it."""
    changes: list[PrescriptionChangeOut] = Field(default_factory=list)
    """What it was before, newest change first."""
    troubles: list[str] = Field(default_factory=list)
    """Limits of it that its template's recording or the patient's resting pose breaks, in words; they need changing."""
    is_twice: bool
    """Whether the same exercise is prescribed a second time: each session counts for one of the two."""
