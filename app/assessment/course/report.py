"""The report of a course of therapy: what was done, the words of the therapist, and which sessions begin and end it."""

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from app.accounts import audit
from app.accounts.models import Account
from app.accounts.subject import Subject
from app.assessment.course.schemas import CourseNoteIn, CourseNoteOut, CourseOut
from app.assessment.models import Comparison, CourseNote
from app.assessment.practice import ADHERENCE_WINDOW, WHEN, adherence, counts, done_since, zone_of
from app.assessment.progress import dose
from app.assessment.worries.stopped import stopped_for_pain
from app.database.base import utc_now
from app.errors import NotFound
from app.exercises.doses import dose_histories, lasting
from app.exercises.models import Exercise, Prescription
from app.patients.access import require_patient
from app.recordings.models import MotionSession
from app.version import service_version
from estimators.sentences import say


def course(
    session: Session, subject: Subject, patient_id: str, exercise_id: str, default_zone: str
) -> CourseOut:
    """Return what a course of therapy in one exercise was.

    Parameters
    ----------
    subject : Subject
        With the level `read`.
    default_zone : str
        Setting `time_zone`.

    Raises
    ------
    NotFound
        No such patient or exercise in reach.
    """
    patient = require_patient(session, subject, patient_id, "read")
    exercise = _exercise(session, patient.clinic_id, exercise_id)
    audit.record(session, subject, "course.read", patient_id, exercise_id)
    own = (MotionSession.patient_id == patient_id, MotionSession.exercise_id == exercise_id)
    count, first_at, last_at, repetitions, active_s = session.execute(
        select(
            func.count(),
            func.min(WHEN),
            func.max(WHEN),
            func.coalesce(func.sum(MotionSession.valid_repetitions), 0),
            func.coalesce(func.sum(MotionSession.active_s), 0.0),
        ).where(*own, counts())
    ).one()
    prescriptions = session.scalars(
        select(Prescription)
        .where(Prescription.patient_id == patient_id, Prescription.exercise_id == exercise_id)
        .order_by(Prescription.starts_at, Prescription.id)
    ).all()
    compared = session.execute(
        select(Comparison.id, Comparison.session_id)
        .join(MotionSession, MotionSession.id == Comparison.session_id)
        .where(
            *own, MotionSession.purpose == "exercise", Comparison.result_id == MotionSession.main_result_id
        )
        .order_by(WHEN, MotionSession.id, Comparison.created_at)
    ).all()
    done = []
    if prescriptions:
        done = done_since(session, [patient_id], min(one.starts_at for one in prescriptions))[patient_id]
    zone = zone_of(session, subject.clinic_id, default_zone)
    now = utc_now()
    history = dose_histories(session, prescriptions)
    held = sorted((each for one in history.values() for each in lasting(one)), key=lambda one: one.start)
    hurt = stopped_for_pain(session, [patient_id], now - ADHERENCE_WINDOW)[patient_id]
    return CourseOut(
        exercise_id=exercise_id,
        exercise_name=exercise.name,
        session_count=count,
        first_at=first_at,
        last_at=last_at,
        valid_repetitions=repetitions,
        active_s=active_s,
        prescribed=[dose(one, exercise.movement) for one in held],
        adherence_percent=adherence(prescriptions, done, now, zone, history),
        pain_stops=sum(one.exercise_id == exercise_id for one in hurt),
        first_comparison_id=compared[0].id if compared else None,
        last_comparison_id=compared[-1].id if compared else None,
        note=_newest_note(session, patient_id, exercise_id),
        service_version=service_version(),
    )


def write_note(session: Session, subject: Subject, patient_id: str, wanted: CourseNoteIn) -> CourseNoteOut:
    """Store the words that stand in the report from now on; earlier ones stay stored.

    Parameters
    ----------
    session : Session
        Writing.
    subject : Subject
        With the level `treat`.

    Raises
    ------
    NotFound, NotAllowed
        See `app.patients.access`; no such exercise.
    """
    patient = require_patient(session, subject, patient_id, "treat")
    _exercise(session, patient.clinic_id, wanted.exercise_id)
    note = CourseNote(
        patient_id=patient_id,
        exercise_id=wanted.exercise_id,
        text=wanted.text,
        written_by=subject.account_id or subject.id,
    )
    session.add(note)
    session.flush()
    audit.record(session, subject, "course.note", patient_id, note.id)
    return _note_out(session, note)


def notes_of(session: Session, patient_id: str) -> list[CourseNoteOut]:
    """Return every note about a patient, oldest first; access was checked."""
    found = session.scalars(
        select(CourseNote)
        .where(CourseNote.patient_id == patient_id)
        .order_by(CourseNote.created_at, CourseNote.id)
    )
    return [_note_out(session, one) for one in found]


def _newest_note(session: Session, patient_id: str, exercise_id: str) -> CourseNoteOut | None:
    note = session.scalar(
        select(CourseNote)
        .where(CourseNote.patient_id == patient_id, CourseNote.exercise_id == exercise_id)
        .order_by(CourseNote.created_at.desc(), CourseNote.id.desc())
        .limit(1)
    )
    return None if note is None else _note_out(session, note)


def _note_out(session: Session, note: CourseNote) -> CourseNoteOut:
    author = session.scalar(select(Account.display_name).where(Account.id == note.written_by))
    return CourseNoteOut(
        id=note.id,
        exercise_id=note.exercise_id,
        text=note.text,
        written_by=author or "",
        created_at=note.created_at,
    )


def _exercise(session: Session, clinic_id: str, exercise_id: str) -> Exercise:
    exercise = session.get(Exercise, exercise_id)
    if exercise is None or exercise.clinic_id != clinic_id:
        raise NotFound(say("exercise.not_found"))
    return exercise
