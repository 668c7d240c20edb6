"""The one access check: what a subject may do with a patient's data.

Recordings, exercises, assessment, viewer and live all call `require_patient`; no other code decides.

=========  ==============================================  ==================================================
level      covers                                          who has it
=========  ==============================================  ==================================================
`status`   state and progress of sessions and jobs         everybody below, and the patient's device tokens
`read`     all data of the patient                         the patient; grants `read` and `treat`;
                                                           administrators
`record`   start, stream, steer and upload exercise        the patient and its device tokens (with the
           sessions                                        consent `home_streaming`); grant `treat`
`treat`    record templates, prescribe, compare,           grant `treat`
           reprocess, delete sessions
`manage`   grants, consents, device tokens, master data,   grant `treat`; administrators of the clinic
           archive
`erase`    erase the patient for good                      administrators of the clinic
=========  ==============================================  ==================================================

`record` and `treat` need the patient's consent to `treatment`: a yes that somebody wrote down, not a question that
was never asked. Of an archived patient everything can still be read; `record` and `treat` are refused until the
patient is taken out of the archive.

The service itself (`Subject.system`) has every level inside its clinic. Who has no level at all gets
`NotFound`, so the patient's existence does not leak; who has another level gets `NotAllowed`.
"""

from datetime import datetime
from typing import Literal

from sqlalchemy import ColumnElement, Select, or_, select
from sqlalchemy.orm import Session

from app.accounts.consents import consent
from app.accounts.subject import Subject
from app.database.base import utc_now
from app.errors import NotAllowed, NotFound
from app.patients.models import Grant, Patient
from app.sentences import say

Level = Literal["status", "read", "record", "treat", "manage", "erase"]

_GRANT_LEVELS: dict[str, frozenset[Level]] = {
    "read": frozenset({"status", "read"}),
    "treat": frozenset({"status", "read", "record", "treat", "manage"}),
}
_ALL: frozenset[Level] = frozenset({"status", "read", "record", "treat", "manage", "erase"})
_ADMINISTRATOR: frozenset[Level] = frozenset({"status", "read", "manage", "erase"})
_OWN: frozenset[Level] = frozenset({"status", "read", "record"})
_DEVICE: frozenset[Level] = frozenset({"status", "record"})

NO_SUCH_PATIENT = say("patient.not_found")


def require_patient(session: Session, subject: Subject, patient_id: str, level: Level = "read") -> Patient:
    """Return the patient when the subject has the level; the caller writes the audit event.

    Parameters
    ----------
    session : Session
    subject : Subject
        Who asks.
    patient_id : str
        Whose data.
    level : {"status", "read", "record", "treat", "manage", "erase"}
        What is to be done; see the module text.

    Returns
    -------
    Patient

    Raises
    ------
    NotFound
        The patient does not exist, or the subject has no right at all.
    NotAllowed
        The subject may see the patient but not do this, the patient has not consented to it, or is archived.
    """
    patient = session.get(Patient, patient_id)
    held = levels(session, subject, patient) if patient is not None else frozenset()
    if patient is None or not held:
        raise NotFound(NO_SUCH_PATIENT)
    if level not in held:
        raise NotAllowed(say("patient.level", level=level), level=level)
    if level in {"record", "treat"} and subject.role != "system":
        if patient.archived_at is not None:
            raise NotAllowed(say("patient.archived"), archived=True)
        _require_consent(session, subject, patient_id, level)
    return patient


def require_own_or_manage(session: Session, subject: Subject, patient_id: str) -> Patient:
    """Return the patient to who may manage its data, and to the patient: for own devices and own consents.

    Parameters
    ----------
    session : Session
    subject : Subject
    patient_id : str

    Raises
    ------
    NotFound, NotAllowed
        As of `require_patient`.
    """
    patient = require_patient(session, subject, patient_id, "status")
    is_own = subject.role == "patient" and subject.patient_id == patient_id
    if not is_own and "manage" not in levels(session, subject, patient):
        raise NotAllowed(say("patient.level", level="manage"), level="manage")
    return patient


def levels(session: Session, subject: Subject, patient: Patient) -> frozenset[Level]:
    """Return every level that the subject has for the patient, consent left aside.

    Parameters
    ----------
    session : Session
    subject : Subject
    patient : Patient
    """
    if subject.clinic_id != patient.clinic_id:
        return frozenset()
    match subject.role:
        case "system":
            return _ALL
        case "device":
            return _DEVICE if subject.patient_id == patient.id else frozenset()
        case "patient":
            return _OWN if subject.patient_id == patient.id else frozenset()
        case "administrator":
            return _ADMINISTRATOR | _granted(session, subject, patient.id)
        case _:
            return _granted(session, subject, patient.id)


def visible_patients(subject: Subject) -> Select[Patient]:
    """Return the query of all patients whose data the subject may read, for lists.

    Parameters
    ----------
    subject : Subject
        A device sees none: it may not read.
    """
    query = select(Patient).where(Patient.clinic_id == subject.clinic_id)
    if subject.role in {"administrator", "system"}:
        return query
    if subject.role == "patient":
        return query.where(Patient.id == (subject.patient_id or ""))
    return query.where(
        Patient.id.in_(
            select(Grant.patient_id).where(Grant.account_id == (subject.account_id or ""), is_in_force())
        )
    )


def is_in_force(at: datetime | None = None) -> ColumnElement[bool]:
    """Return the SQL condition of a grant that is neither revoked nor expired.

    Parameters
    ----------
    at : datetime, optional
        Now when absent.
    """
    return Grant.revoked_at.is_(None) & or_(Grant.expires_at.is_(None), Grant.expires_at > (at or utc_now()))


def _granted(session: Session, subject: Subject, patient_id: str) -> frozenset[Level]:
    if subject.account_id is None:
        return frozenset()
    grants = session.scalars(
        select(Grant.level).where(
            Grant.patient_id == patient_id, Grant.account_id == subject.account_id, is_in_force()
        )
    )
    held: frozenset[Level] = frozenset()
    for level in grants:
        held |= _GRANT_LEVELS.get(level, frozenset())
    return held


def _require_consent(session: Session, subject: Subject, patient_id: str, level: Level) -> None:
    treatment = consent(session, patient_id, "treatment")
    if treatment is not True:
        never_asked = treatment is None
        reason = say("patient.no_consent") if never_asked else say("patient.consent_withdrawn")
        raise NotAllowed(reason, purpose="treatment")
    at_home = subject.role in {"patient", "device"}
    if level == "record" and at_home and consent(session, patient_id, "home_streaming") is not True:
        raise NotAllowed(
            say("patient.no_home_consent"),
            purpose="home_streaming",
        )
