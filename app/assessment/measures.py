"""Measured values over sessions: the queries behind progress and the caseload, and the statistics of change.

One session gives one value per measure: the mean over its accepted repetitions, from the newest comparison of the
session's main result. Their spread is the standard deviation between repetitions.
"""

import math
import statistics
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from itertools import groupby
from typing import Any, Final

from sqlalchemy import ColumnElement, Subquery, func, select
from sqlalchemy.orm import Session

from app.assessment.models import ALL_REPETITIONS, Comparison, RepetitionMeasure
from app.recordings.models import MotionSession, Result
from estimators.comparison.measures import FEWEST_SESSIONS, detectable_change

BASELINE: Final = FEWEST_SESSIONS
"""Sessions needed before it can be said how much one differs from another without any change."""


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
        Mean of the later sessions minus mean of the baseline; None without a baseline or a later session.
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
    drawn = _over_repetitions(newest, measures)
    found: dict[str, list[Sequence[Any]]] = defaultdict(list)
    for row in session.execute(select(drawn).order_by(drawn.c.comparison_id, drawn.c.measure)):
        found[row[0]].append(row)
    return [value for one in sessions for value in _values(one, found.get(one[0], ()))]


def _values(one: Sequence[Any], measured: Sequence[Sequence[Any]]) -> list[SessionValue]:
    """Return the values of a session, from the two statements of `session_values`.

    Rows are taken apart by place: by name each of ten thousand costs far more.
    """
    _, patient, exercise, name, started_at, created_at, counted, orientation, version, pipeline, template = (
        one
    )
    at = started_at or created_at
    values = []
    for _, measure, unit, mean, mean_square, repetitions, first, uncertainty in measured:
        is_of_all = first == ALL_REPETITIONS
        values.append(
            SessionValue(
                patient_id=patient,
                exercise_id=exercise,
                session_id=name,
                at=at,
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
        )
    return values


def _over_repetitions(newest: Subquery, measures: Sequence[str] | None) -> Subquery:
    """Return each measure of the comparison that counts of each session, drawn together over its repetitions.

    Only of the sessions that are asked for: repetitions of other exercises are by far the most.
    """
    drawn = (
        select(
            RepetitionMeasure.comparison_id,
            RepetitionMeasure.measure,
            func.min(RepetitionMeasure.unit).label("unit"),
            func.avg(RepetitionMeasure.value).label("mean"),
            func.avg(RepetitionMeasure.value * RepetitionMeasure.value).label("mean_square"),
            func.count().label("repetitions"),
            func.min(RepetitionMeasure.repetition).label("first"),
            func.max(RepetitionMeasure.uncertainty).label("uncertainty"),
        )
        .join(newest, (newest.c.id == RepetitionMeasure.comparison_id) & (newest.c.rank == 1))
        .group_by(RepetitionMeasure.comparison_id, RepetitionMeasure.measure)
    )
    if measures is not None:
        drawn = drawn.where(RepetitionMeasure.measure.in_(measures))
    return drawn.subquery()


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


def change(values: Sequence[SessionValue]) -> Change:
    """Compare the last sessions, at most three, with the first three.

    Parameters
    ----------
    values : sequence of SessionValue
        Of one measure, oldest first.
    """
    first, later = values[:BASELINE], values[BASELINE:][-BASELINE:]
    limit = minimal_detectable_change(first)
    if limit is None or not later:
        return Change(None, limit)
    return Change(_mean(later) - _mean(first), limit)


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
