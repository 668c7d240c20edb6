"""Sessions that ended because it hurt: the patient pressed "It hurts", and nobody went on afterwards."""

from collections import defaultdict
from collections.abc import Iterable
from datetime import datetime
from typing import NamedTuple

from sqlalchemy import ColumnElement, func, select
from sqlalchemy.orm import Session, aliased

from app.assessment.course.attention import PAIN
from app.recordings.models import MotionSession, SessionEvent


class StoppedForPain(NamedTuple):
    """One session that ended because it hurt.

    Attributes
    ----------
    at : datetime
        When it began.
    """

    session_id: str
    at: datetime
    exercise_id: str | None
    prescription_id: str | None


def is_stopped_for_pain() -> ColumnElement[bool]:
    """Return the condition that a session was ended by pain; who went on afterwards ended it otherwise."""
    hurt, resumed = aliased(SessionEvent), aliased(SessionEvent)
    goes_on = (
        select(resumed.id)
        .where(resumed.session_id == hurt.session_id)
        .where(resumed.kind == "guidance_resume", resumed.time_s > hurt.time_s)
        .exists()
    )
    return select(hurt.id).where(hurt.session_id == MotionSession.id, hurt.kind == PAIN, ~goes_on).exists()


def stopped_for_pain(
    session: Session, patient_ids: Iterable[str], start: datetime
) -> dict[str, list[StoppedForPain]]:
    """Return the sessions of exercise that ended because it hurt, by patient, oldest first; access was checked.

    Parameters
    ----------
    start : datetime
        Sessions that began since then. Also those in which nothing valid was done before it hurt.
    """
    began = func.coalesce(MotionSession.started_at, MotionSession.created_at)
    rows = session.execute(
        select(
            MotionSession.patient_id,
            MotionSession.id,
            MotionSession.started_at,
            MotionSession.created_at,
            MotionSession.exercise_id,
            MotionSession.prescription_id,
        )
        .where(MotionSession.patient_id.in_(patient_ids), MotionSession.purpose == "exercise", start <= began)
        .where(is_stopped_for_pain())
        .order_by(began, MotionSession.id)
    )
    found: dict[str, list[StoppedForPain]] = defaultdict(list)
    for patient_id, session_id, started_at, created_at, exercise_id, prescription_id in rows:
        found[patient_id].append(
            StoppedForPain(session_id, started_at or created_at, exercise_id, prescription_id)
        )
    return found
