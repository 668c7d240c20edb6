"""By how much the sessions of a clinic's patients differ, measure by measure: what a new patient is judged with."""

import re
import time
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import tzinfo
from typing import Any, Final
from weakref import WeakKeyDictionary

import numpy as np
from sqlalchemy import func, select
from sqlalchemy.orm import Session

from app.assessment.course.days import days_of
from app.assessment.course.published import published_of
from app.assessment.measures import SessionValue, session_values
from app.assessment.practice import WHEN
from app.assessment.walk_progress import walk_values
from app.exercises.models import Exercise
from app.recordings.models import MotionSession
from estimators.progress import FEWEST_SESSIONS, NO_PRIOR, Scatter, learn_scatter, second_differences

MOST_PATIENTS: Final = 200
"""Those who practised last: more would say the same."""
_SHARE: Final = 100.0
"""What took a second to learn is learnt again after a hundred."""
_SIDE: Final = re.compile("left|right")
_PUBLISHED_FREEDOM: Final = 10.0
"""For so many sessions counts what was published of other people, with other devices."""

_learnt: WeakKeyDictionary[Any, dict[tuple[str, str], tuple[float, "Scatters"]]] = WeakKeyDictionary()


@dataclass(frozen=True)
class Scatters:
    """What is known before the patient's own sessions.

    Attributes
    ----------
    movement : str
        Of the exercise.
    by_measure : mapping of str to Scatter
        Of the clinic, both sides together.
    """

    movement: str
    by_measure: Mapping[str, Scatter]

    def of(self, measure: str) -> tuple[Scatter, str]:
        """Return what is known of a measure, and who says so: the source, empty for the clinic or nobody."""
        own = self.by_measure.get(_SIDE.sub("side", measure))
        if own is not None and own.freedom > 0.0:
            return own, ""
        known = published_of(measure, self.movement)
        if known is None:
            return NO_PRIOR, ""
        return Scatter(known.scatter**2, _PUBLISHED_FREEDOM, known.people), known.scatter_source


def scatters_of(session: Session, clinic_id: str, exercise: Exercise | None, zone: tzinfo) -> Scatters:
    """Return what the patients of a clinic say of the measures of an exercise, with its twin of the other side.

    Parameters
    ----------
    clinic_id : str
        Of the patient who is judged; access was checked.
    exercise : Exercise or None
        Without one nothing is known.
    zone : tzinfo
        Whose days.

    Notes
    -----
    Of all who practised it in four sessions or more; only what sessions differ by leaves this function. Stored in
    memory a hundred times as long as it took.
    """
    if exercise is None:
        return Scatters("", {})
    known = _learnt.setdefault(session.get_bind(), {})
    name = (clinic_id, exercise.movement)
    if name in known and known[name][0] > time.monotonic():
        return known[name][1]
    begun = time.monotonic()
    found = Scatters(exercise.movement, _learn(session, clinic_id, exercise.movement, zone))
    now = time.monotonic()
    known[name] = (now + _SHARE * (now - begun), found)
    return found


def _learn(session: Session, clinic_id: str, movement: str, zone: tzinfo) -> dict[str, Scatter]:
    exercises = select(Exercise.id).where(Exercise.clinic_id == clinic_id, Exercise.movement == movement)
    ids = session.scalars(exercises).all()
    patients = session.scalars(
        select(MotionSession.patient_id)
        .where(
            MotionSession.clinic_id == clinic_id,
            MotionSession.exercise_id.in_(ids),
            MotionSession.purpose == "exercise",
            MotionSession.main_result_id.is_not(None),
        )
        .group_by(MotionSession.patient_id)
        .having(func.count() >= FEWEST_SESSIONS)
        .order_by(func.max(WHEN).desc(), MotionSession.patient_id)
        .limit(MOST_PATIENTS)
    ).all()
    if not patients:
        return {}
    values = [*session_values(session, patients, ids), *walk_values(session, patients, ids)]
    return learnt_of(values, zone)


def learnt_of(values: Sequence[SessionValue], zone: tzinfo) -> dict[str, Scatter]:
    """Return what each measure scatters by, of the values of many patients.

    Parameters
    ----------
    values : sequence of SessionValue
        Oldest first within each patient.
    """
    series: dict[tuple[str, str | None, str], list[SessionValue]] = defaultdict(list)
    for value in values:
        series[value.patient_id, value.exercise_id, value.measure].append(value)
    found: dict[str, list[tuple[float, float]]] = defaultdict(list)
    for (_, _, measure), own in series.items():
        if len(own) < FEWEST_SESSIONS:
            continue
        days = days_of(own, zone)
        if len(days.days) < FEWEST_SESSIONS:
            continue
        variance, freedom = second_differences(days.days, days.values, days.segments)
        found[_SIDE.sub("side", measure)].append((float(variance), freedom))
    return {
        measure: learn_scatter(*(np.array(column) for column in zip(*pairs, strict=True)))
        for measure, pairs in found.items()
    }
