"""A session moved to the right patient or exercise: results stay, comparisons and the day's count are made again.

What one patient's template said about a movement says nothing about another patient's, so comparisons with it go and
the session is compared again with what was prescribed where it now belongs. Moving it back undoes it.
"""

from typing import Final

from sqlalchemy import delete, or_, select
from sqlalchemy.orm import Session

from app.accounts import audit
from app.accounts.subject import Subject
from app.assessment.models import Comparison
from app.assessment.records.schemas import SessionPatch
from app.errors import Conflict, InvalidInput, NotAllowed
from app.exercises.models import Exercise, Template, TemplateVersion
from app.patients.access import levels, require_patient
from app.patients.models import Mounting, Patient
from app.recordings import repository as recordings
from app.recordings.models import Job, MotionSession, SessionEvent
from estimators.sentences import say

AT_REST: Final = ("created", "analysed", "failed")
"""States in which nothing writes to a session."""


def change(session: Session, subject: Subject, session_id: str, wanted: SessionPatch) -> MotionSession:
    """Move a session to another patient, another exercise, or both.

    Parameters
    ----------
    session : Session
        Writing.
    subject : Subject
        Who may treat both patients.

    Raises
    ------
    NotFound, NotAllowed
        The session or the patient is not the subject's to treat, the other patient has not consented, or is archived.
    Conflict
        The session is live or being analysed, or a template of the patient was made from it.
    InvalidInput
        No such exercise in the clinic, or nothing that changes.
    """
    found = recordings.get_session(session, subject, session_id, action="")
    require_treated(session, subject, session.get_one(Patient, found.patient_id))
    reason = wanted.reason.strip()
    if not reason:
        raise InvalidInput(say("session.reason_needed"), field="reason")
    to_patient = wanted.patient_id not in {None, found.patient_id}
    exercise = _exercise(session, found, wanted.exercise_id)
    if not to_patient and exercise is None:
        raise InvalidInput(say("session.nothing_to_move"), field="patient_id")
    require_rest(session, [found])
    if to_patient:
        right = require_patient(session, subject, str(wanted.patient_id), "treat")
        _require_no_own_template(session, found)
        move(session, subject, found, right.id, reason)
    if exercise is not None:
        details = {"from": found.exercise_id, "to": exercise.id, "reason": reason}
        audit.record(session, subject, "session.exercise", found.patient_id, found.id, details)
        found.exercise_id = exercise.id
        note(session, found, say("session.exercise_changed", reason=reason))
    found.prescription_id = recordings.prescribed_at(session, found, found.started_at or found.created_at)
    compare_anew(session, subject, found)
    session.flush()
    return found


def require_treated(session: Session, subject: Subject, patient: Patient) -> None:
    """Refuse who may not treat a patient; consent and archive are left aside, for data also leaves such a record."""
    if "treat" not in levels(session, subject, patient):
        raise NotAllowed(say("patient.level", level="treat"), level="treat")


def require_rest(session: Session, sessions: list[MotionSession]) -> None:
    """Refuse to touch sessions that something writes to.

    Raises
    ------
    Conflict
    """
    busy = [one.state for one in sessions if one.state not in AT_REST]
    ids = [one.id for one in sessions]
    # A comparison that is under way notices that the session is another one by now, and is made again.
    at_work = select(Job.id).where(
        Job.session_id.in_(ids), Job.status.in_(("queued", "running")), Job.kind != "compare"
    )
    if busy or session.scalar(at_work.limit(1)) is not None:
        raise Conflict(say("session.move_live"), reason="live" if busy else "analysis")


def move(session: Session, subject: Subject, found: MotionSession, patient_id: str, reason: str) -> None:
    """Give a session to another patient and note it in both audit trails and on its time line.

    Parameters
    ----------
    subject : Subject
        Its rights to both were checked.
    patient_id : str
        Of the same clinic.
    """
    left = found.patient_id
    audit.record(session, subject, "session.move_out", left, found.id, {"to": patient_id, "reason": reason})
    audit.record(session, subject, "session.move_in", patient_id, found.id, {"from": left, "reason": reason})
    found.patient_id = patient_id
    # How sensors sat on somebody else is offered to nobody.
    session.execute(delete(Mounting).where(Mounting.patient_id == left, Mounting.session_id == found.id))
    note(session, found, say("session.moved", reason=reason))


def note(session: Session, found: MotionSession, text: str) -> None:
    """Write a line on a session's time line."""
    session.add(SessionEvent(session_id=found.id, kind="state", time_s=found.duration_s, text=text))


def compare_anew(session: Session, subject: Subject, found: MotionSession) -> None:
    """Drop comparisons that say nothing any more, and queue the one with what is prescribed now.

    Parameters
    ----------
    found : MotionSession
        Where it belongs now.
    """
    other = select(TemplateVersion.id).join(Template, Template.id == TemplateVersion.template_id)
    other = other.where(
        or_(
            Template.patient_id != found.patient_id,
            Template.exercise_id != found.exercise_id,
        )
    )
    session.execute(
        delete(Comparison)
        .where(Comparison.session_id == found.id, Comparison.template_version_id.in_(other))
        .execution_options(synchronize_session=False)
    )
    if found.state == "analysed":
        found.valid_repetitions = found.active_s = None
        recordings.add_job(session, found, "compare", {"close": True}, subject)


def _exercise(session: Session, found: MotionSession, wanted: str | None) -> Exercise | None:
    """Return the exercise to change to; None where it stays."""
    if wanted is None or wanted == found.exercise_id:
        return None
    exercise = session.get(Exercise, wanted)
    if exercise is None or exercise.clinic_id != found.clinic_id:
        raise InvalidInput(say("exercise.not_found"), field="exercise_id")
    return exercise


def _require_no_own_template(session: Session, found: MotionSession) -> None:
    """Refuse where a patient's own template was made of it: made from somebody else's movement, it misleads."""
    made = (
        select(Template.name)
        .join(TemplateVersion, TemplateVersion.template_id == Template.id)
        .where(Template.patient_id == found.patient_id, TemplateVersion.source_session_id == found.id)
    )
    if (name := session.scalar(made.limit(1))) is not None:
        raise Conflict(say("session.move_template", name=name), reason="template")


def put_again(session: Session, session_id: str, patient_id: str) -> bool:
    """Move a session as the register says it was moved, in an older database; False where nothing is to be done."""
    found, patient = session.get(MotionSession, session_id), session.get(Patient, patient_id)
    if found is None or patient is None or found.patient_id == patient_id:
        return False
    move(session, Subject.system(found.clinic_id), found, patient_id, "")
    found.prescription_id = recordings.prescribed_at(session, found, found.started_at or found.created_at)
    compare_anew(session, Subject.system(found.clinic_id), found)
    return True
