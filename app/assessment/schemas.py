"""Wire types of comparisons, progress and the caseload."""

from dataclasses import dataclass
from datetime import date, datetime
from typing import Literal

from pydantic import Field

from app.assessment.worries.schemas import WorryOut
from app.exercises.design import PhaseDesign
from app.exercises.schemas import PhaseCurve, RepetitionOut
from app.patients.schemas import Side
from app.schemas import Schema, Spoken


class MeasureValue(Spoken):
    """One measure: never a number without its unit and what stands behind it."""

    measure: str
    label: str
    value: float | None
    unit: str
    uncertainty: float | None
    """One standard deviation: between repetitions in a summary (of what all of them together give: of that), of the
    estimate in a repetition."""
    count: int
    template_value: float | None
    group: str
    """timing, shape, range, smoothness, coordination, path or compensation."""
    note: str = ""
    """Why it is undefined, or what of it is; empty where nothing is to be said."""


class RepetitionComparison(Schema):
    """One repetition beside the template."""

    repetition: RepetitionOut
    measures: list[MeasureValue]
    outside_band: dict[str, list[tuple[int, int]]]
    """Per channel, half-open phase intervals (0..101) outside the tolerance band."""
    warp_template_phase: list[float]
    """For each of 101 patient phases the template phase (0..100) it is aligned with."""


class ComparisonIn(Schema):
    """Compare a session with a template version."""

    template_version_id: str
    result_id: str | None = None


class ComparisonOut(Spoken):
    """A comparison in a list."""

    id: str
    session_id: str
    result_id: str
    template_version_id: str
    template_name: str
    created_at: datetime
    repetition_count: int
    summary: list[MeasureValue]


class OtherSide(Schema):
    """A measure of a session beside that of the newest session with the unaffected side."""

    measure: str
    label: str
    unit: str
    value: float
    other_value: float
    other_count: int
    symmetry_ratio: float
    """ln(affected side / other side)."""
    symmetry_ratio_sigma: float
    symmetry_angle_percent: float


class WeightedPart(Schema):
    """One part of a weighted sum: a measure times its weight."""

    measure: str
    label: str
    unit: str
    weight: float
    value: float | None
    """Mean over the repetitions that the sum is of; None where no repetition has this measure."""
    part: float | None
    """weight x value"""
    template_value: float | None
    template_part: float | None


class WeightedSum(Schema):
    """What the therapist weighed on the template: the sum and all that it is made of."""

    value: float | None
    """Mean over the repetitions that have every part; None where none has: nothing is left out in silence."""
    uncertainty: float | None
    """Standard deviation between these repetitions; None of a single one."""
    count: int
    template_value: float | None
    """Of the template's own measures; None where a part is measured against the template."""
    parts: list[WeightedPart]


class ComparisonDetail(ComparisonOut, Spoken):
    """A comparison with everything a page draws."""

    repetitions: list[RepetitionComparison]
    curves: list[PhaseCurve]
    """Template mean and band with every patient repetition, aligned in time, in `repetitions`."""
    phases: list[PhaseDesign] = Field(default_factory=list)
    """As the therapist named them on the template."""
    findings: list[str]
    """Plain sentences, compensation first; beside what leaves the band at most three."""
    other_side: list[OtherSide] = Field(default_factory=list)
    """Where the exercise is one of the affected side and its twin was practised; nothing of what may be nothing."""
    weighted_sum: WeightedSum | None = None
    """Where the therapist defined one with the version of the template that was compared with."""


class CaseloadRow(Spoken):
    """One line of the caseload."""

    patient_id: str
    given_name: str
    family_name: str
    affected_side: Side | None
    due: str
    """What is prescribed, in a few words; empty when nothing is."""
    last_session_at: datetime | None
    live_session_id: str | None
    """A session that is open now."""
    live_state: Literal["streaming", "link_lost"] | None
    """Whether anything comes from the sensors of the open session."""
    main_measure: str | None
    main_measure_name: str | None = None
    """Its name; `main_measure` is its label."""
    main_unit: str | None
    trend: list[float]
    """The main measure day by day over eight weeks, oldest first."""
    trend_days: list[date]
    """By the clinic's clocks, as long as `trend`."""
    trend_low: list[float]
    trend_high: list[float]
    adherence_percent: float | None
    pain_stops: int = 0
    """Sessions of the last four weeks that ended because it hurt; they count as practised where something valid was
    done."""
    reason: Literal[
        "pain",
        "stop",
        "declining",
        "link_lost",
        "compensation",
        "few_repetitions",
        "not_practising",
        "rarely_practised",
        "bad_data",
        "no_template",
        "",
    ]
    reason_text: str
    worry: WorryOut | None
    """The gravest that nobody has marked as seen, of the same kind the newest; also beside a more urgent reason."""
    worry_count: int
    """How many nobody has marked as seen."""
    may_treat: bool
    """Whether who asks may mark them."""
    action: Literal[
        "watch", "open_live", "replay", "progress", "contact", "record_template", "prescribe", "open"
    ]
    """The one thing to do next."""
    action_session_id: str | None
    """Of `watch`, `open_live` and `replay`."""


@dataclass(slots=True)
class ProgressPoint:
    """One session's value of one measure.

    Thousands of them are made of what the database holds, in one answer: they are not checked again.
    """

    session_id: str
    at: datetime
    value: float
    low: float
    high: float
    count: int
    """Repetitions behind the value."""
    orientation: str
    template_version_id: str | None


class ProgressBand(Spoken):
    """What the values of a measure are shown beside."""

    kind: Literal["other_side", "norm"]
    low: float
    high: float
    """Of the other side mean and one standard deviation between its repetitions; of a norm as its text says."""
    text: str
    """What it is; of a norm with its source."""
    value: float | None = None
    """Of the other side, in its newest session."""
    symmetry_ratio: float | None = None
    """ln(affected side / other side) of the newest sessions; None where one may be nothing (below two sigma)."""
    symmetry_ratio_sigma: float | None = None
    symmetry_angle_percent: float | None = None
    """(45 deg - atan(left / right)) / 90 deg; 0 is alike."""


ChangeWord = Literal[
    "values",
    "more",
    "less",
    "a_little_more",
    "a_little_less",
    "probably_more",
    "probably_less",
    "unchanged",
    "unknown",
]


class ProgressBreak(Schema):
    """From when on a measure is measured in another way: a step there is no change of the patient."""

    at: datetime
    kind: Literal["estimator", "template", "placement"]


class ProgressTrend(Schema):
    """What may be said of how a measure changed since the baseline: the first day of the last eight weeks."""

    word: ChangeWord
    """`values`: three days or fewer, nothing may be said. `a_little_...`: surely, but less than what matters.
    `probably_...`: with a probability of 0.8 to 0.975. `unchanged`: the interval is narrow. `unknown`: it is wide."""
    since: datetime
    """The day of the baseline."""
    until: datetime
    """The last day that counts: the newest, or the one before it where the newest is unusual."""
    days: int
    """With values, from the baseline on."""
    start: float | None
    now: float | None
    """Levels of both days by the trend; None where nothing may be said, as what follows."""
    change: float | None
    half_width: float | None
    """Half of the 95 percent interval of the change."""
    per_week: float | None
    probability: float | None
    """That the change is above zero."""
    important: float | None
    """The least change that matters to people, where it was published."""
    important_source: str
    scatter: float | None
    """Standard error of measurement: by how much one session differs from another without any change."""
    scatter_people: int
    """How many others it was shrunk to; 0: by the patient's own sessions alone."""
    scatter_source: str
    """Where these were published; empty where they are of the clinic."""
    minimal_detectable_change: float | None
    """Of two single sessions, at 95 percent: 1.96 sqrt(2) times `scatter`."""
    is_last_day_unusual: bool
    """The newest day is one of a hundred by those before it, and is left out."""
    expected: float | None
    """Then what was expected of it."""
    breaks: list[ProgressBreak]


class ProgressMeasure(Schema):
    """One measure over the sessions."""

    measure: str
    label: str
    unit: str
    points: list[ProgressPoint]
    trend: ProgressTrend
    bands: list[ProgressBand]


class ProgressEvent(Spoken):
    """Something pinned to the time axis."""

    at: datetime
    kind: Literal["template", "estimator", "prescription", "pain"]
    text: str


class Progress(Schema):
    """A patient's progress in one exercise."""

    exercise_id: str | None
    measures: list[ProgressMeasure]
    events: list[ProgressEvent]
