"""Patients, grants and mountings: every query, who may, and the audit event it leaves."""

from datetime import date, datetime, timedelta
from typing import Any

from sqlalchemy import case, delete, select, update
from sqlalchemy.orm import Session

from app.accounts import audit
from app.accounts.models import Account, AuditEvent
from app.accounts.subject import Subject
from app.database.base import new_id, utc_now
from app.errors import Conflict, InvalidInput, NotAllowed, NotFound
from app.pages import Page, rows_of
from app.patients.access import Level, is_in_force, levels, require_patient, visible_patients
from app.patients.models import Grant, Mounting, Patient
from estimators.sentences import say

NO_SUCH_GRANT = say("grant.not_found")


def get_patient(
    session: Session, subject: Subject, patient_id: str, level: Level = "read", action: str = "patient.read"
) -> Patient:
    """Return a patient and note `action`.

    Parameters
    ----------
    level : str
        See `app.patients.access`.
    action : str
        For the audit trail.
    """
    patient = require_patient(session, subject, patient_id, level)
    audit.record(session, subject, action, patient_id, patient_id)
    return patient


def list_patients(
    session: Session, subject: Subject, page: Page, archived: bool | None = None
) -> list[Patient]:
    """Return a page of the patients whose data the subject may read, by name; archived ones last.

    Parameters
    ----------
    archived : bool, optional
        Only archived patients, or only the others; all when absent.
    """
    query = visible_patients(subject)
    if archived is not None:
        query = query.where(Patient.archived_at.is_not(None) if archived else Patient.archived_at.is_(None))
    is_archived = case((Patient.archived_at.is_(None), 0), else_=1)
    order = (is_archived, Patient.family_name, Patient.given_name, Patient.id)
    patients = [patient for (patient,) in rows_of(session, query, order, page)]
    note_once_an_hour(session, subject, "patient.list", [patient.id for patient in patients])
    return patients


def note_once_an_hour(session: Session, subject: Subject, action: str, patient_ids: list[str]) -> None:
    """Audit a list for each patient in it, but not again within an hour: pages refresh lists by themselves."""
    recent = set(
        session.scalars(
            select(AuditEvent.patient_id).where(
                AuditEvent.clinic_id == subject.clinic_id,
                AuditEvent.subject_id == subject.id,
                AuditEvent.action == action,
                AuditEvent.patient_id.in_(patient_ids),
                AuditEvent.at > utc_now() - timedelta(hours=1),
            )
        )
    )
    for patient_id in patient_ids:
        if patient_id not in recent:
            audit.record(session, subject, action, patient_id)


def create_patient(session: Session, subject: Subject, fields: dict[str, Any]) -> Patient:
    """Store a new patient; a therapist who makes one gets the grant `treat`.

    Parameters
    ----------
    subject : Subject
        A therapist or administrator.
    fields : dict
        Columns of `Patient`.

    Raises
    ------
    NotAllowed
        Another role.
    """
    if subject.role not in {"therapist", "administrator"}:
        raise NotAllowed(say("patient.create_not_allowed"))
    patient = Patient(id=new_id(), clinic_id=subject.clinic_id, **fields)
    session.add(patient)
    session.flush()
    audit.record(session, subject, "patient.create", patient.id, patient.id)
    if subject.role == "therapist" and subject.account_id is not None:
        _add_grant(session, subject, patient.id, subject.account_id, "treat", None)
    return patient


def require_no_twin(
    session: Session, subject: Subject, given_name: str, family_name: str, birth_date: date | None
) -> None:
    """Ask before a second record of what seems to be one person: the same name, however written, and the same birth.

    Parameters
    ----------
    subject : Subject
        Asked about among the patients in its reach; of others nothing is said, not even that they are there.

    Raises
    ------
    Conflict
        With the identifier of the record that is there; `is_another_person` answers it.
    """
    if birth_date is None:
        return
    wanted = _words(given_name, family_name)
    for other in session.scalars(visible_patients(subject).where(Patient.birth_date == birth_date)):
        if _words(other.given_name, other.family_name) == wanted:
            raise Conflict(say("patient.twin"), field="is_another_person", patient_id=other.id)


def _words(given_name: str, family_name: str) -> list[str]:
    """Return what two writings of a name have in common: its words, in no order, without case."""
    return sorted(f"{given_name} {family_name}".casefold().split())


def update_patient(session: Session, subject: Subject, patient_id: str, fields: dict[str, Any]) -> Patient:
    """Change fields of a patient.

    Parameters
    ----------
    subject : Subject
        With the level `manage`.
    fields : dict
        Only what changes; the audit trail names the fields, not their values.
    """
    patient = require_patient(session, subject, patient_id, "manage")
    for name, value in fields.items():
        setattr(patient, name, value)
    if not patient.given_name and not patient.family_name:
        raise InvalidInput(say("patient.no_name"), field="family_name")
    if fields:
        audit.record(session, subject, "patient.update", patient_id, patient_id, {"fields": sorted(fields)})
    session.flush()
    return patient


def set_archived(session: Session, subject: Subject, patient: Patient, is_archived: bool) -> None:
    """Put a patient into the archive or take it out again.

    Parameters
    ----------
    patient : Patient
        For which the subject has the level `manage`.
    """
    if (patient.archived_at is not None) == is_archived:
        return
    patient.archived_at = utc_now() if is_archived else None
    if not is_archived:
        patient.merged_into_id = None
    action = "patient.archive" if is_archived else "patient.unarchive"
    audit.record(session, subject, action, patient.id, patient.id)
    session.flush()


def erase_patient(session: Session, subject: Subject, patient: Patient, details: dict[str, int]) -> None:
    """Delete a patient with everything that hangs on it, and the accounts with which it signed in.

    The audit trail stays whole: it holds identifiers that now lead nowhere, and the event of the erasure.

    Parameters
    ----------
    patient : Patient
        For which the subject has the level `erase`; archived, and nothing is at work on its recordings.
    details : dict
        Counts for the audit trail.
    """
    accounts = list(session.scalars(select(Account.id).where(Account.patient_id == patient.id)))
    session.execute(update(Account).where(Account.id.in_(accounts)).values(patient_id=None, is_active=False))
    # Grants, consents, tokens, prescriptions, the patient's own templates and all recordings go by their foreign keys.
    session.execute(delete(Patient).where(Patient.id == patient.id))
    session.execute(delete(Account).where(Account.id.in_(accounts)))
    details = details | {"accounts": len(accounts)}
    audit.record(session, subject, "patient.erase", patient.id, patient.id, details)


def may_treat(session: Session, subject: Subject, patient: Patient) -> bool:
    """Return whether the subject may record templates and prescribe for a patient it can see."""
    return "treat" in levels(session, subject, patient)


def mounting_of(session: Session, patient_id: str) -> Mounting | None:
    """Return how a patient's sensors sat when they were last calibrated; access was checked."""
    return session.scalar(select(Mounting).where(Mounting.patient_id == patient_id))


def mounted_patients(session: Session, patient_ids: list[str]) -> set[str]:
    """Return which of the patients have a remembered calibration.

    Parameters
    ----------
    patient_ids : list of str
        Access was checked.
    """
    return set(session.scalars(select(Mounting.patient_id).where(Mounting.patient_id.in_(patient_ids))))


def treated_patients(session: Session, subject: Subject, patient_ids: list[str]) -> set[str]:
    """Return which of the patients the subject may treat.

    Parameters
    ----------
    patient_ids : list of str
        Access was checked.
    """
    if subject.role == "system":
        return set(patient_ids)
    if subject.kind != "account" or subject.role == "patient":
        return set()
    query = select(Grant.patient_id).where(
        Grant.patient_id.in_(patient_ids),
        Grant.account_id == subject.account_id,
        Grant.level == "treat",
        is_in_force(),
    )
    return set(session.scalars(query))


def list_grants(session: Session, subject: Subject, patient_id: str) -> list[tuple[Grant, str]]:
    """Return the grants in force for a patient with the name of who holds them.

    Parameters
    ----------
    subject : Subject
        With the level `read`: patients see who may look.
    """
    require_patient(session, subject, patient_id, "read")
    audit.record(session, subject, "grant.list", patient_id)
    rows = session.execute(
        select(Grant, Account.display_name)
        .join(Account, Account.id == Grant.account_id)
        .where(Grant.patient_id == patient_id, is_in_force())
        .order_by(Account.display_name, Grant.created_at)
    )
    return [(grant, name) for grant, name in rows]


def create_grant(
    session: Session,
    subject: Subject,
    patient_id: str,
    account_id: str,
    level: str,
    expires_at: datetime | None,
) -> tuple[Grant, str]:
    """Give a colleague a right to a patient; one that the colleague had is replaced.

    Parameters
    ----------
    subject : Subject
        With the level `manage`.
    patient_id, account_id : str
        Of the same clinic.
    level : {"read", "treat"}

    Raises
    ------
    InvalidInput
        The account is not an active therapist, administrator or integrator of the clinic, or the end is in
        the past.
    """
    require_patient(session, subject, patient_id, "manage")
    account = session.get(Account, account_id)
    if account is None or account.clinic_id != subject.clinic_id or not account.is_active:
        raise InvalidInput(say("grant.no_account"), field="account_id")
    if account.role == "patient":
        raise InvalidInput(say("grant.own_data"), field="account_id")
    if expires_at is not None and expires_at <= utc_now():
        raise InvalidInput(say("grant.ends_in_past"), field="expires_at")
    held = session.scalars(
        select(Grant).where(Grant.patient_id == patient_id, Grant.account_id == account_id, is_in_force())
    )
    for old in held:
        old.revoked_at = utc_now()
        audit.record(session, subject, "grant.revoke", patient_id, old.id, {"account_id": account_id})
    return _add_grant(session, subject, patient_id, account_id, level, expires_at), account.display_name


def revoke_grant(session: Session, subject: Subject, grant_id: str) -> Grant:
    """End a grant now.

    Parameters
    ----------
    subject : Subject
        With the level `manage` for the patient, or the holder giving the right back.

    Raises
    ------
    NotFound
        No such grant, no right to know of it, or it has ended already.
    """
    grant = session.get(Grant, grant_id)
    if grant is None or grant.revoked_at is not None:
        raise NotFound(NO_SUCH_GRANT)
    level: Level = "read" if grant.account_id == subject.account_id else "manage"
    try:
        require_patient(session, subject, grant.patient_id, level)
    except NotFound:
        raise NotFound(NO_SUCH_GRANT) from None
    grant.revoked_at = utc_now()
    audit.record(
        session, subject, "grant.revoke", grant.patient_id, grant.id, {"account_id": grant.account_id}
    )
    return grant


def _add_grant(
    session: Session,
    subject: Subject,
    patient_id: str,
    account_id: str,
    level: str,
    expires_at: datetime | None,
) -> Grant:
    grant = Grant(
        id=new_id(),
        patient_id=patient_id,
        account_id=account_id,
        level=level,
        granted_by=subject.account_id or subject.id,
        expires_at=expires_at,
        revoked_at=None,
    )
    session.add(grant)
    session.flush()
    details = {"account_id": account_id, "level": level}
    audit.record(session, subject, "grant.create", patient_id, grant.id, details)
    return grant
