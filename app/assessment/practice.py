"""What was practised of what was prescribed: the sessions done this week, and adherence over four weeks.

Prescriptions themselves are the room `exercises`; here they meet the recorded sessions.
"""

from datetime import datetime, timedelta

from sqlalchemy import ColumnElement, func, select
from sqlalchemy.orm import Session

from app.accounts.subject import Subject
from app.database.base import utc_now
from app.exercises import repository as exercises
from app.exercises.models import Prescription
from app.exercises.schemas import PrescriptionIn, PrescriptionOut
from app.recordings.models import MotionSession

ADHERENCE_WINDOW = timedelta(days=28)


def list_prescriptions(session: Session, subject: Subject, patient_id: str) -> list[PrescriptionOut]:
    """Return a patient's present and coming prescriptions with the sessions done this week.

    Parameters
    ----------
    session : Session
    subject : Subject
        With the level `read`.
    patient_id : str
    """
    rows = exercises.list_prescriptions(session, subject, patient_id)
    done = done_since(session, patient_id, week_start(utc_now()))
    return [_out(*row, done.get(row[0].exercise_id, 0)) for row in rows]


def prescribe(session: Session, subject: Subject, patient_id: str, body: PrescriptionIn) -> PrescriptionOut:
    """Prescribe an exercise; what was done of it earlier this week counts.

    Parameters
    ----------
    session : Session
    subject : Subject
        With the level `treat`.
    patient_id : str
    body : PrescriptionIn
    """
    row, exercise, template = exercises.create_prescription(session, subject, patient_id, body)
    done = done_since(session, patient_id, week_start(utc_now()))
    return _out(row, exercise, template, done.get(row.exercise_id, 0))


def week_start(now: datetime) -> datetime:
    """Return the last Monday, 00:00 UTC.

    Parameters
    ----------
    now : datetime
    """
    return (now - timedelta(days=now.weekday())).replace(hour=0, minute=0, second=0, microsecond=0)


def recorded_something() -> ColumnElement[bool]:
    """Return the condition that a session holds a recording: one that was opened and left is no practice."""
    end_s = func.coalesce(MotionSession.recording_end_s, MotionSession.duration_s)
    return end_s > func.coalesce(MotionSession.recording_start_s, 0.0)


def done_since(session: Session, patient_id: str, start: datetime) -> dict[str, int]:
    """Return the number of sessions done since a time, by exercise; access was checked.

    Parameters
    ----------
    session : Session
    patient_id : str
    start : datetime
    """
    at = func.coalesce(MotionSession.started_at, MotionSession.created_at)
    rows = session.execute(
        select(MotionSession.exercise_id, func.count())
        .where(
            MotionSession.patient_id == patient_id,
            MotionSession.purpose == "exercise",
            MotionSession.exercise_id.is_not(None),
            MotionSession.state.in_(("closing", "analysed")),
            recorded_something(),
            at >= start,
        )
        .group_by(MotionSession.exercise_id)
    )
    return {exercise_id: count for exercise_id, count in rows if exercise_id is not None}


def adherence(
    prescriptions: list[Prescription], practised: list[tuple[datetime, str | None]], now: datetime
) -> float | None:
    """Return sessions done in percent of sessions prescribed, over the last four weeks; None before the first
    is due.

    Parameters
    ----------
    prescriptions : list of Prescription
    practised : list of (time, exercise)
    now : datetime

    Notes
    -----
    More than prescribed in one exercise does not make up for none in another: each counts at most in full.
    """
    expected_total, done_total = 0.0, 0.0
    for prescription in prescriptions:
        start = max(prescription.starts_at, now - ADHERENCE_WINDOW)
        end = min(prescription.ends_at or now, now)
        expected = prescription.times_per_week * max(0.0, (end - start) / timedelta(weeks=1))
        done = sum(
            1 for at, exercise in practised if exercise == prescription.exercise_id and start <= at <= end
        )
        expected_total += expected
        done_total += min(float(done), expected)
    return round(100.0 * done_total / expected_total, 1) if expected_total >= 1.0 else None


def _out(row: Prescription, exercise: str, template: str | None, done: int) -> PrescriptionOut:
    return PrescriptionOut(
        id=row.id,
        exercise_id=row.exercise_id,
        exercise_name=exercise,
        template_id=row.template_id,
        template_name=template,
        repetitions=row.repetitions,
        sets=row.sets,
        times_per_week=row.times_per_week,
        starts_at=row.starts_at,
        ends_at=row.ends_at,
        done_this_week=done,
    )
