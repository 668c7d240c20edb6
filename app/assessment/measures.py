"""Measured values over sessions: the queries behind progress and the caseload, and the statistics of change.

One session gives one value per measure: the mean over its accepted repetitions, from the newest comparison of the
session's main result. Their spread is the standard deviation between repetitions.
"""

import math
import statistics
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from itertools import groupby
from typing import Any, Final

from sqlalchemy import ColumnElement, Subquery, func, insert, select
from sqlalchemy.orm import Session

from app.assessment.models import ALL_REPETITIONS, Comparison, ComparisonMeasure, RepetitionMeasure
from app.recordings.models import MotionSession, Result
from estimators.comparison.measures import FEWEST_SESSIONS, detectable_change

BASELINE: Final = FEWEST_SESSIONS
"""Sessions needed before it can be said how much one differs from another without any change."""

_MEASURES: Final[Any] = ComparisonMeasure.__table__
"""By the table itself, whose rows come sooner than those of the class."""


@dataclass(frozen=True, slots=True)
class SessionValue:
    """One measure of one session.

    Attributes
    ----------
    mean : float
        Over the repetitions, in the unit of the measure.
    spread : float or None
        Standard deviation between repetitions, None for a single one; of what only all of them together give, that of
        the value.
    count : int
        Repetitions.
    """

    patient_id: str
    exercise_id: str | None
    session_id: str
    at: datetime
    measure: str
    unit: str
    mean: float
    spread: float | None
    count: int
    orientation: str
    orientation_version: str
    pipeline_version: str
    template_version_id: str


@dataclass(frozen=True, slots=True)
class Change:
    """How a measure moved from the baseline, and whether that is more than one session differs from another.

    Attributes
    ----------
    difference : float or None
        What is compared minus the mean of what it is compared with; None where there is none of either.
    minimal_detectable : float or None
        Smallest difference from the baseline that is unlikely to be chance; None without a baseline.
    """

    difference: float | None
    minimal_detectable: float | None

    @property
    def is_real(self) -> bool | None:
        """Whether the difference is larger than the minimal detectable one; None when that is unknown."""
        if self.difference is None or self.minimal_detectable is None:
            return None
        return abs(self.difference) > self.minimal_detectable


def session_values(
    session: Session,
    patient_ids: Sequence[str],
    exercise_id: str | Sequence[str] | None = None,
    measures: Sequence[str] | None = None,
) -> list[SessionValue]:
    """Return every session's values, oldest first within each patient; access was checked.

    Parameters
    ----------
    session : Session
    patient_ids : sequence of str
    exercise_id : str or sequence of str, optional
        Only sessions of this exercise, or of these.
    measures : sequence of str, optional
        Only these; all when absent.
    """
    conditions: list[ColumnElement[bool]] = [
        MotionSession.patient_id.in_(patient_ids),
        MotionSession.purpose == "exercise",
    ]
    if exercise_id is not None:
        wanted = [exercise_id] if isinstance(exercise_id, str) else exercise_id
        conditions.append(MotionSession.exercise_id.in_(wanted))
    newest = _ranked_comparisons(conditions)
    at = func.coalesce(MotionSession.started_at, MotionSession.created_at)
    # What is the same for all measures of a session is read once a session: each has dozens of them.
    sessions = session.execute(
        select(
            Comparison.id,
            MotionSession.patient_id,
            MotionSession.exercise_id,
            MotionSession.id,
            MotionSession.started_at,
            MotionSession.created_at,
            Comparison.repetition_count,
            Result.orientation,
            Result.orientation_version,
            Result.pipeline_version,
            Comparison.template_version_id,
        )
        .join(newest, (newest.c.id == Comparison.id) & (newest.c.rank == 1))
        .join(Result, Result.id == Comparison.result_id)
        .join(MotionSession, MotionSession.id == Comparison.session_id)
        .order_by(MotionSession.patient_id, at, MotionSession.id)
    ).all()
    if not sessions:
        return []
    drawn = (
        select(_MEASURES)
        .join(newest, (newest.c.id == _MEASURES.c.comparison_id) & (newest.c.rank == 1))
        .order_by(_MEASURES.c.comparison_id, _MEASURES.c.measure)
    )
    if measures is not None:
        drawn = drawn.where(_MEASURES.c.measure.in_(measures))
    found: dict[str, list[SessionValue]] = {one[0]: [] for one in sessions}
    heads = {one[0]: one for one in sessions}
    # By the connection: the session would hold ten thousand rows until the last is read.
    for row in session.connection().execute(drawn):
        # One may have been compared between both statements.
        if row[0] in heads:
            found[row[0]].append(_value(heads[row[0]], row))
    return [value for values in found.values() for value in values]


def _value(head: Sequence[Any], measured: Sequence[Any]) -> SessionValue:
    """Return a value of a session, from a row of each statement of `session_values`.

    Rows are taken apart by place: by name each of ten thousand costs far more.
    """
    _, patient, exercise, name, started_at, created_at, counted, orientation, version, pipeline, template = (
        head
    )
    _, measure, unit, mean, mean_square, repetitions, is_of_all, uncertainty = measured
    return SessionValue(
        patient_id=patient,
        exercise_id=exercise,
        session_id=name,
        at=started_at or created_at,
        measure=measure,
        unit=unit,
        mean=mean,
        spread=uncertainty if is_of_all else _spread(mean, mean_square, repetitions),
        count=counted if is_of_all else repetitions,
        orientation=orientation,
        orientation_version=version,
        pipeline_version=pipeline,
        template_version_id=template,
    )


def store_drawn(session: Session, comparison_id: str) -> None:
    """Store each measure of a comparison drawn together over its repetitions, whose rows are there.

    By the database, once: progress over hundreds of sessions then reads a tenth of the rows.

    Parameters
    ----------
    session : Session
    comparison_id : str
    """
    drawn = (
        select(
            RepetitionMeasure.comparison_id,
            RepetitionMeasure.measure,
            func.min(RepetitionMeasure.unit),
            func.avg(RepetitionMeasure.value),
            func.avg(RepetitionMeasure.value * RepetitionMeasure.value),
            func.count(),
            func.min(RepetitionMeasure.repetition) == ALL_REPETITIONS,
            func.max(RepetitionMeasure.uncertainty),
        )
        .where(RepetitionMeasure.comparison_id == comparison_id)
        .group_by(RepetitionMeasure.comparison_id, RepetitionMeasure.measure)
    )
    session.execute(insert(_MEASURES).from_select(_MEASURES.c.keys(), drawn))


def _ranked_comparisons(sessions: Sequence[ColumnElement[bool]]) -> Subquery:
    """Return the comparisons of each session with their `rank`: 1 is that of its main result, the newest of these."""
    order = (
        (Comparison.result_id == MotionSession.main_result_id).desc(),
        Comparison.created_at.desc(),
        Comparison.id,
    )
    rank = func.row_number().over(partition_by=Comparison.session_id, order_by=order).label("rank")
    return (
        select(Comparison.id, rank)
        .join(MotionSession, MotionSession.id == Comparison.session_id)
        .where(*sessions)
        .subquery()
    )


def by_patient(values: Sequence[SessionValue]) -> dict[str, list[SessionValue]]:
    """Return values grouped by patient, in their order.

    Parameters
    ----------
    values : sequence of SessionValue
        From `session_values`.
    """
    return {patient: list(found) for patient, found in groupby(values, key=lambda value: value.patient_id)}


def pooled_spread(values: Sequence[SessionValue]) -> float | None:
    """Return the standard deviation between repetitions, pooled over sessions by their degrees of freedom.

    Parameters
    ----------
    values : sequence of SessionValue
        Of one measure.
    """
    known = [(value.spread, value.count) for value in values if value.spread is not None]
    freedom = sum(count - 1 for _, count in known)
    if not freedom:
        return None
    return math.sqrt(sum(spread**2 * (count - 1) for spread, count in known) / freedom)


def minimal_detectable_change(baseline: Sequence[SessionValue]) -> float | None:
    """Return how far a session must be from the mean of the baseline before that is unlikely (5 percent) to be chance.

    Parameters
    ----------
    baseline : sequence of SessionValue
        Of one measure, from sessions between which nothing is supposed to have changed.

    Returns
    -------
    float or None
        In the unit of the measure; None with fewer than three sessions.

    Notes
    -----
    t sd sqrt(1 + 1/k) of the means of k baseline sessions (`estimators.comparison.measures.detectable_change`). The
    spread between repetitions of one day is not used: they resemble each other more than sessions do, and would call
    a different day a real change. A mean of several later sessions is judged by the same limit, which is then on the
    safe side.
    """
    limit = detectable_change([value.mean for value in baseline])
    return limit if math.isfinite(limit) else None


def recent_change(values: Sequence[SessionValue]) -> Change:
    """Compare the last three sessions with the three before them, fewer where there are not six.

    Parameters
    ----------
    values : sequence of SessionValue
        Of one measure, oldest first.
    """
    limit = minimal_detectable_change(values[:BASELINE])
    if len(values) <= BASELINE:
        return Change(None, limit)
    recent = values[-2 * BASELINE :]
    half = len(recent) // 2
    return Change(_mean(recent[-half:]) - _mean(recent[:half]), limit)


def session_changes(values: Sequence[SessionValue]) -> list[Change]:
    """Compare each session with the baseline, the first three; one of the baseline itself has no difference.

    Parameters
    ----------
    values : sequence of SessionValue
        Of one measure, oldest first.
    """
    first, later = values[:BASELINE], values[BASELINE:]
    limit = minimal_detectable_change(first)
    before = [Change(None, limit)] * len(first)
    if limit is None:
        return before
    middle = _mean(first)
    return [*before, *(Change(value.mean - middle, limit) for value in later)]


def _mean(values: Sequence[SessionValue]) -> float:
    return statistics.fmean(value.mean for value in values)


def _spread(mean: float, mean_square: float, count: int) -> float | None:
    if count < 2:
        return None
    return math.sqrt(max(0.0, mean_square - mean * mean) * count / (count - 1))
