"""Measured values over sessions: the queries behind progress and the caseload.

One session gives one value per measure: the mean over its accepted repetitions, from the newest comparison of the
session's main result. Their spread is the standard deviation between repetitions.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from itertools import groupby
from typing import Any, Final

from sqlalchemy import ColumnElement, Subquery, func, insert, select
from sqlalchemy.orm import Session

from app.assessment.models import ALL_REPETITIONS, Comparison, ComparisonMeasure, RepetitionMeasure
from app.exercises.models import TemplateVersion
from app.recordings.models import MotionSession, Result

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
    template_id : str
        Of the template version; empty without a template.
    placements : tuple of str
        Where sensors were worn, sorted; empty where nobody wrote it down.
    is_of_all : bool
        The value is of all repetitions together: `spread` is the standard deviation of the value itself.
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
    template_id: str = ""
    placements: tuple[str, ...] = ()
    is_of_all: bool = False


def session_values(
    session: Session,
    patient_ids: Sequence[str],
    exercise_id: str | Sequence[str] | None = None,
    measures: Sequence[str] | None = None,
) -> list[SessionValue]:
    """Return every session's values, oldest first within each patient; access was checked.

    Parameters
    ----------
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
            TemplateVersion.template_id,
            MotionSession.setup["placements"],
        )
        .join(newest, (newest.c.id == Comparison.id) & (newest.c.rank == 1))
        .join(Result, Result.id == Comparison.result_id)
        .join(TemplateVersion, TemplateVersion.id == Comparison.template_version_id)
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
    _, patient, exercise, name, started_at, created_at, counted, orientation, version, pipeline, *made = head
    template_version, template, worn = made
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
        template_version_id=template_version,
        template_id=template,
        placements=placed(worn),
        is_of_all=bool(is_of_all),
    )


def placed(worn: Sequence[str] | None) -> tuple[str, ...]:
    """Return where sensors were worn, as `SessionValue` has it."""
    return tuple(sorted(worn or ()))


def store_drawn(session: Session, comparison_id: str) -> None:
    """Store each measure of a comparison drawn together over its repetitions, whose rows are there.

    By the database, once: progress over hundreds of sessions then reads a tenth of the rows.
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


def _spread(mean: float, mean_square: float, count: int) -> float | None:
    if count < 2:
        return None
    return math.sqrt(max(0.0, mean_square - mean * mean) * count / (count - 1))
