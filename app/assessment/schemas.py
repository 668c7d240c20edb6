"""Wire types of comparisons."""

from datetime import datetime

from app.exercises.schemas import PhaseCurve, RepetitionOut
from app.schemas import Schema


class MeasureValue(Schema):
    """One measure: never a number without its unit and what stands behind it."""

    measure: str
    label: str
    value: float | None
    unit: str
    uncertainty: float | None
    """One standard deviation: between repetitions in a summary, of the estimate in a repetition."""
    count: int
    template_value: float | None
    group: str
    """timing, shape, range, smoothness, path or compensation."""


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


class ComparisonOut(Schema):
    """A comparison in a list."""

    id: str
    session_id: str
    result_id: str
    template_version_id: str
    template_name: str
    created_at: datetime
    repetition_count: int
    summary: list[MeasureValue]


class ComparisonDetail(ComparisonOut):
    """A comparison with everything a page draws."""

    repetitions: list[RepetitionComparison]
    curves: list[PhaseCurve]
    """Template mean and band with every patient repetition, aligned in time, in `repetitions`."""
    findings: list[str]
    """At most three plain sentences, the most important first."""
