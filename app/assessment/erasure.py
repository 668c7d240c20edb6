"""Erasing a patient for good: master data, recordings, results, comparisons, accounts, files in passing.

It is here and not in `patients` because it must know of recordings: nothing may be at work on them. The audit trail
stays (`app.accounts.audit`), backups too: they are erased by their age (see the page on operations).
"""

from pathlib import Path

from sqlalchemy import Engine, delete, exists, func, select, update
from sqlalchemy.orm import Session

from app.accounts.subject import Subject
from app.assessment.models import Comparison
from app.database.engine import forget_deleted
from app.database.unit_of_work import unit_of_work
from app.errors import Conflict
from app.exercises.models import Prescription, Template, TemplateVersion
from app.ingest.upload import upload_folder
from app.patients import repository as patients
from app.patients.access import require_patient
from app.recordings.models import Job, MotionSession
from app.sentences import say
from app.settings import Settings

STREAMING = ("calibrating", "ready", "recording", "link_lost")


def erase(engine: Engine, settings: Settings, subject: Subject, patient_id: str) -> None:
    """Erase an archived patient with everything that was ever recorded.

    Parameters
    ----------
    engine : Engine
    settings : Settings
        For the folder of uploaded files.
    subject : Subject
        With the level `erase`.
    patient_id : str

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
        files = _uploaded_files(session, settings, patient_id)
        erase_templates_from(session, patient_id)
        count = session.scalar(select(func.count()).where(MotionSession.patient_id == patient_id)) or 0
        patients.erase_patient(session, subject, patient, {"sessions": count})
    for file in files:
        file.unlink(missing_ok=True)
    forget_deleted(engine)


def erase_templates_from(session: Session, patient_id: str) -> None:
    """Erase versions of the clinic's templates that were made from a recording of the patient; others stay.

    A template whose only versions they were goes with them, and prescriptions of it go on without one.

    Parameters
    ----------
    session : Session
        Writing.
    patient_id : str
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


def _uploaded_files(session: Session, settings: Settings, patient_id: str) -> list[Path]:
    """Return files that were received and not yet taken into the database."""
    jobs = session.scalars(
        select(Job)
        .join(MotionSession, MotionSession.id == Job.session_id)
        .where(MotionSession.patient_id == patient_id, Job.kind == "upload")
    )
    names = [job.arguments.get("file") for job in jobs]
    return [upload_folder(settings) / Path(name).name for name in names if isinstance(name, str)]


__all__ = ["erase"]
