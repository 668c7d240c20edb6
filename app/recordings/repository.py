"""Sessions, results, events and long tasks: every query, who may, and the audit event it leaves.

Reading what was measured needs the level `read`; starting and feeding a session `record` (or `treat` when it
is to become a template); analysing again and deleting `treat`; watching a task's progress `status`.
"""

from collections.abc import Iterable, Sequence
from datetime import datetime
from typing import Any

from sqlalchemy import delete, or_, select
from sqlalchemy.orm import Session

from app.accounts import audit
from app.accounts.subject import Subject
from app.database.base import utc_now
from app.errors import Conflict, InvalidInput, NotFound
from app.exercises.models import Exercise, Prescription
from app.pages import Page, rows_of
from app.patients.access import Level, require_patient
from app.patients.models import Mounting, Patient
from app.recordings.files_in_passing import remove_files_of
from app.recordings.models import WALK_STREAM, Job, MotionSession, Result, SessionEvent, SignalChunk
from app.settings import Settings
from estimators.sentences import say

NO_SUCH_SESSION = say("session.not_found")


def recording_level(purpose: str) -> Level:
    """Return the level that recording a session of this purpose needs."""
    return "treat" if purpose == "template" else "record"


def get_session(
    session: Session,
    subject: Subject,
    session_id: str,
    level: Level = "read",
    *,
    action: str = "session.read",
    details: dict[str, Any] | None = None,
) -> MotionSession:
    """Return a session that the subject has the level for, and note `action`.

    Raises
    ------
    NotFound
        No such session, or no right to know of it.
    NotAllowed
        Another right than the one needed.
    """
    found = session.get(MotionSession, session_id)
    if found is None:
        raise NotFound(NO_SUCH_SESSION)
    try:
        require_patient(session, subject, found.patient_id, level)
    except NotFound:
        raise NotFound(NO_SUCH_SESSION) from None
    if action:
        audit.record(session, subject, action, found.patient_id, found.id, details)
    return found


def list_sessions(
    session: Session, subject: Subject, patient_id: str, page: Page
) -> list[tuple[MotionSession, str | None]]:
    """Return a page of a patient's sessions, newest first, each with the name of its exercise."""
    require_patient(session, subject, patient_id, "read")
    audit.record(session, subject, "session.list", patient_id)
    query = (
        select(MotionSession, Exercise.name)
        .outerjoin(Exercise, Exercise.id == MotionSession.exercise_id)
        .where(MotionSession.patient_id == patient_id)
    )
    order = (MotionSession.created_at, MotionSession.id)
    return [(found, name) for found, name in rows_of(session, query, order, page, newest_first=True)]


def list_walks(
    session: Session, subject: Subject, patient_id: str, page: Page
) -> list[tuple[MotionSession, str | None, SignalChunk]]:
    """Return a page of a patient's analysed walks, newest first: session, exercise and the walk in numbers."""
    require_patient(session, subject, patient_id, "read")
    audit.record(session, subject, "session.list", patient_id)
    query = (
        select(MotionSession, Exercise.name, SignalChunk)
        .join(
            SignalChunk,
            (SignalChunk.session_id == MotionSession.id)
            & (SignalChunk.stream == WALK_STREAM + MotionSession.main_result_id),
        )
        .outerjoin(Exercise, Exercise.id == MotionSession.exercise_id)
        .where(MotionSession.patient_id == patient_id)
    )
    order = (MotionSession.created_at, MotionSession.id)
    return [tuple(row) for row in rows_of(session, query, order, page, newest_first=True)]


def sessions_among(
    session: Session, subject: Subject, patient_id: str, ids: list[str]
) -> dict[str, MotionSession]:
    """Return which of the sessions are the patient's, by identifier."""
    require_patient(session, subject, patient_id, "read")
    audit.record(session, subject, "session.list", patient_id)
    query = select(MotionSession).where(MotionSession.patient_id == patient_id, MotionSession.id.in_(ids))
    return {found.id: found for found in session.scalars(query)}


def create_session(session: Session, subject: Subject, new: MotionSession) -> MotionSession:
    """Store a new session for a patient after checking what it refers to.

    One that names an exercise and no prescription belongs to the prescription of that exercise, where there is one.

    Raises
    ------
    InvalidInput
        The exercise or prescription is not one of this clinic or patient.
    """
    patient = require_patient(session, subject, new.patient_id, recording_level(new.purpose))
    new.clinic_id = patient.clinic_id
    if new.prescription_id is not None:
        prescription = session.get(Prescription, new.prescription_id)
        if prescription is None or prescription.patient_id != patient.id:
            raise InvalidInput(say("session.other_prescription"), field="prescription_id")
        if new.exercise_id is None:
            new.exercise_id = prescription.exercise_id
        elif new.exercise_id != prescription.exercise_id:
            raise InvalidInput(say("session.other_exercise"), field="exercise_id")
    if new.exercise_id is not None:
        exercise = session.get(Exercise, new.exercise_id)
        if exercise is None or exercise.clinic_id != patient.clinic_id:
            raise InvalidInput(say("exercise.not_found"), field="exercise_id")
    # Of an upload whose day only the whole file says, its task asks.
    at = utc_now() if new.source == "stream" else new.started_at
    if new.prescription_id is None and new.purpose == "exercise" and at is not None:
        new.prescription_id = prescribed_at(session, new, at)
    session.add(new)
    session.flush()
    audit.record(
        session, subject, "session.create", patient.id, new.id, {"purpose": new.purpose, "source": new.source}
    )
    return new


def prescribed_at(session: Session, found: MotionSession, at: datetime) -> str | None:
    """Return which prescription of the session's patient and exercise was in force at a moment.

    Parameters
    ----------
    at : datetime
        With a time zone.

    Returns
    -------
    str or None
        None where the exercise was not prescribed, or twice: sessions that name none are shared among those by need.
    """
    if found.exercise_id is None:
        return None
    query = (
        select(Prescription.id)
        .where(
            Prescription.patient_id == found.patient_id,
            Prescription.exercise_id == found.exercise_id,
            Prescription.starts_at <= at,
            or_(Prescription.ends_at.is_(None), Prescription.ends_at > at),
        )
        .limit(2)
    )
    found_here = session.scalars(query).all()
    return found_here[0] if len(found_here) == 1 else None


def patient_of(session: Session, subject: Subject, patient_id: str, level: Level) -> Patient:
    """Return the patient for a new session."""
    return require_patient(session, subject, patient_id, level)


def mounting_of(session: Session, patient_id: str) -> Mounting | None:
    """Return the remembered calibration of a patient whose access was checked."""
    return session.scalar(select(Mounting).where(Mounting.patient_id == patient_id))


def exercise_name(session: Session, found: MotionSession) -> str | None:
    """Return the name of a session's exercise."""
    if found.exercise_id is None:
        return None
    return session.scalar(select(Exercise.name).where(Exercise.id == found.exercise_id))


def results_of(session: Session, session_id: str) -> Sequence[Result]:
    """Return the results of a session whose access was checked, oldest first."""
    return session.scalars(
        select(Result).where(Result.session_id == session_id).order_by(Result.created_at, Result.id)
    ).all()


def events_of(session: Session, session_id: str) -> Sequence[SessionEvent]:
    """Return the time line of a session whose access was checked."""
    return session.scalars(
        select(SessionEvent)
        .where(SessionEvent.session_id == session_id)
        .order_by(SessionEvent.time_s, SessionEvent.created_at)
    ).all()


def replace_events(session: Session, session_id: str, kind: str, events: Iterable[SessionEvent]) -> None:
    """Put what an analysis found on the time line in place of what an earlier one found of the same kind."""
    session.execute(
        delete(SessionEvent).where(SessionEvent.session_id == session_id, SessionEvent.kind == kind)
    )
    session.add_all(events)


def result_of(session: Session, found: MotionSession, result_id: str | None = None) -> Result:
    """Return one result of a session whose access was checked; by default the main one.

    Raises
    ------
    NotFound
        The session has no such result, or none yet.
    """
    wanted = result_id or found.main_result_id
    if wanted is None:
        complete = [r for r in results_of(session, found.id) if r.status != "failed"]
        if not complete:
            raise NotFound(say("result.not_yet"))
        return complete[-1]
    result = session.get(Result, wanted)
    if result is None or result.session_id != found.id:
        raise NotFound(say("result.not_found"))
    return result


def add_job(
    session: Session, found: MotionSession, kind: str, arguments: dict[str, Any], subject: Subject
) -> Job:
    """Queue a long task for a session whose access was checked."""
    job = Job(session_id=found.id, kind=kind, arguments=arguments, created_by=subject.id)
    session.add(job)
    session.flush()
    return job


def get_job(session: Session, subject: Subject, job_id: str) -> Job:
    """Return a task of a patient of whom the subject may know the state; progress is no patient data."""
    job = session.get(Job, job_id)
    if job is None:
        raise NotFound(say("job.not_found"))
    try:
        get_session(session, subject, job.session_id, "status", action="")
    except NotFound:
        raise NotFound(say("job.not_found")) from None
    return job


def jobs_of(session: Session, subject: Subject, session_id: str, page: Page) -> list[Job]:
    """Return a page of the tasks of a session, newest first."""
    get_session(session, subject, session_id, "status", action="")
    query = select(Job).where(Job.session_id == session_id)
    return [job for (job,) in rows_of(session, query, (Job.created_at, Job.id), page, newest_first=True)]


def delete_session(session: Session, settings: Settings, subject: Subject, session_id: str) -> None:
    """Erase a session with its signals, results, comparisons and files; the audit trail keeps that it happened.

    Raises
    ------
    Conflict
        The session is live.
    """
    found = get_session(session, subject, session_id, "treat", action="session.delete")
    if found.state in {"calibrating", "ready", "recording"}:
        raise Conflict(say("session.delete_live"), state=found.state)
    erase_session(session, settings, found)


def erase_session(session: Session, settings: Settings, found: MotionSession) -> None:
    """Delete a session with everything that hangs on it and its files; the caller has checked the right."""
    remove_files_of(session, settings, select(MotionSession.id).where(MotionSession.id == found.id))
    session.execute(delete(MotionSession).where(MotionSession.id == found.id))
