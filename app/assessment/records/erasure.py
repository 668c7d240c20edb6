"""Erasing a patient for good: master data, recordings, results, comparisons, accounts, files in passing.

It is here and not in `patients` because it must know of recordings: nothing may be at work on them. The audit trail
stays (`app.accounts.audit`), backups too: they are erased by their age (see the page on operations), and what a restore
brings back is erased again (`app.assessment.records.ended_again`).
"""

from sqlalchemy import Engine, delete, exists, func, select, update
from sqlalchemy.orm import Session

from app.accounts.subject import Subject
from app.assessment.models import Comparison
from app.database.engine import forget_deleted
from app.database.unit_of_work import unit_of_work
from app.errors import Conflict
from app.exercises.models import Prescription, Template, TemplateVersion
from app.patients import repository as patients
from app.patients.access import require_patient
from app.patients.models import Patient
from app.recordings.files_in_passing import remove_files_of
from app.recordings.models import Job, MotionSession
from app.settings import Settings
from estimators.sentences import say

STREAMING = ("calibrating", "ready", "recording", "link_lost")


def erase(engine: Engine, settings: Settings, subject: Subject, patient_id: str) -> None:
    """Erase an archived patient with everything that was ever recorded.

    Parameters
    ----------
    settings : Settings
        For the folder of uploaded files.
    subject : Subject
        With the level `erase`.

    Raises
    ------
    NotFound, NotAllowed
        See `app.patients.access`.
    Conflict
        The patient is not archived, streams at this moment, or one of the recordings is being analysed.

    Notes
    -----
    The deleted rows are overwritten in the database file (SQLite's `secure_delete`), and its write-ahead log is
    emptied as soon as nobody reads from it.
    """
    with unit_of_work(engine) as session:
        patient = require_patient(session, subject, patient_id, "erase")
        if patient.archived_at is None:
            raise Conflict(say("patient.archive_first"), archived=False)
        _require_rest(session, patient_id)
        erase_now(session, settings, subject, patient)
        for shell in session.scalars(select(Patient).where(Patient.merged_into_id == patient_id)).all():
            # The other record of the same person, which was merged into this one.
            erase_now(session, settings, subject, shell)
    forget_deleted(engine)


def erase_now(session: Session, settings: Settings, subject: Subject, patient: Patient) -> None:
    """Delete a patient with everything, whatever its state; the caller has checked the right and that it rests.

    Parameters
    ----------
    session : Session
        Writing. Files go once it is committed.
    """
    own = select(MotionSession.id).where(MotionSession.patient_id == patient.id)
    remove_files_of(session, settings, own)
    erase_templates_from(session, patient.id)
    count = session.scalar(select(func.count()).where(MotionSession.patient_id == patient.id)) or 0
    patients.erase_patient(session, subject, patient, {"sessions": count})


def erase_templates_from(session: Session, patient_id: str) -> None:
    """Erase versions of the clinic's templates that were made from a recording of the patient; others stay.

    A template whose only versions they were goes with them, and prescriptions of it go on without one.

    Parameters
    ----------
    session : Session
        Writing.
    """
    own = select(MotionSession.id).where(MotionSession.patient_id == patient_id)
    made_from = TemplateVersion.source_session_id.in_(own)
    touched = session.scalars(select(TemplateVersion.template_id).where(made_from).distinct()).all()
    versions = select(TemplateVersion.id).where(made_from)
    session.execute(delete(Comparison).where(Comparison.template_version_id.in_(versions)))
    session.execute(delete(TemplateVersion).where(made_from))
    left = select(TemplateVersion.id).where(TemplateVersion.template_id == Template.id)
    empty = session.scalars(select(Template.id).where(Template.id.in_(touched), ~exists(left))).all()
    session.execute(update(Prescription).where(Prescription.template_id.in_(empty)).values(template_id=None))
    session.execute(delete(Template).where(Template.id.in_(empty)))


def _require_rest(session: Session, patient_id: str) -> None:
    own = MotionSession.patient_id == patient_id
    # A session that is closing without a task is still being written by the live side.
    is_written = (MotionSession.state == "closing") & ~exists().where(Job.session_id == MotionSession.id)
    live = select(MotionSession.id).where(own, MotionSession.state.in_(STREAMING) | is_written)
    if session.scalar(live.limit(1)) is not None:
        raise Conflict(say("patient.session_live"), reason="live")
    at_work = select(Job.id).join(MotionSession, MotionSession.id == Job.session_id)
    if session.scalar(at_work.where(own, Job.status == "running").limit(1)) is not None:
        raise Conflict(say("patient.being_analysed"), reason="analysis")
