"""From patients' rows to what a page shows."""

from sqlalchemy.orm import Session

from app.accounts.audit import record
from app.accounts.audit_reading import read_audit
from app.accounts.consents import list_consents, set_consent
from app.accounts.schemas import (
    AuditOut,
    ConsentIn,
    ConsentOut,
    GrantIn,
    GrantOut,
)
from app.accounts.subject import Subject
from app.errors import InvalidInput
from app.pages import Page
from app.patients import repository
from app.patients.access import require_own_or_manage, require_patient
from app.patients.models import Grant, Patient
from app.patients.schemas import BodyDimensionsIn, MountingOut, NewPatientIn, PatientOut, PatientPatch
from estimators.sentences import say


def list_patients(
    session: Session, subject: Subject, page: Page, archived: bool | None = None
) -> list[PatientOut]:
    """Return a page of the patients in reach.

    Parameters
    ----------
    archived : bool, optional
        Only archived patients, or only the others; all when absent.
    """
    patients = repository.list_patients(session, subject, page, archived)
    ids = [patient.id for patient in patients]
    mounted = repository.mounted_patients(session, ids)
    treated = repository.treated_patients(session, subject, ids)
    return [_out(subject, patient, patient.id in mounted, patient.id in treated) for patient in patients]


def get_patient(session: Session, subject: Subject, patient_id: str) -> PatientOut:
    """Return one patient."""
    return patient_out(session, subject, repository.get_patient(session, subject, patient_id))


def create_patient(session: Session, subject: Subject, body: NewPatientIn) -> PatientOut:
    """Store a new patient."""
    if not body.is_another_person:
        repository.require_no_twin(session, subject, body.given_name, body.family_name, body.birth_date)
    fields = body.model_dump(exclude={"body_dimensions", "agrees_to_treatment", "is_another_person"})
    fields["body_dimensions"] = body.body_dimensions.model_dump(exclude_none=True)
    patient = repository.create_patient(session, subject, fields)
    if body.agrees_to_treatment:
        _note_consent(session, subject, patient.id, "treatment", True)
    return patient_out(session, subject, patient)


def update_patient(session: Session, subject: Subject, patient_id: str, body: PatientPatch) -> PatientOut:
    """Change what the request names; `null` clears a date of birth or a side, never a name."""
    fields = body.model_dump(exclude_unset=True, exclude={"body_dimensions", "is_archived"})
    if body.body_dimensions is not None:
        fields["body_dimensions"] = body.body_dimensions.model_dump(exclude_none=True)
    patient = repository.update_patient(session, subject, patient_id, fields)
    if body.is_archived is not None:
        repository.set_archived(session, subject, patient, body.is_archived)
    return patient_out(session, subject, patient)


def patient_out(session: Session, subject: Subject, patient: Patient) -> PatientOut:
    """Return a patient as the subject sees it.

    Parameters
    ----------
    patient : Patient
        Access was checked.
    """
    mounting = repository.mounting_of(session, patient.id)
    out = _out(subject, patient, mounting is not None, repository.may_treat(session, subject, patient))
    if mounting is not None:
        known = mounting.calibration
        out.mounting = MountingOut(
            placements=list(known.get("q_sensor_segment", {})),
            method=str(known.get("method", "n_pose")),
            score=float(known.get("score", 1.0)),
            updated_at=mounting.updated_at,
        )
    return out


def list_grants(session: Session, subject: Subject, patient_id: str) -> list[GrantOut]:
    """Return who may see a patient."""
    return [_grant_out(*row) for row in repository.list_grants(session, subject, patient_id)]


def create_grant(session: Session, subject: Subject, patient_id: str, body: GrantIn) -> GrantOut:
    """Give a colleague a right."""
    if body.expires_at is not None and body.expires_at.tzinfo is None:
        raise InvalidInput(say("grant.end_needs_zone"), field="expires_at")
    return _grant_out(
        *repository.create_grant(session, subject, patient_id, body.account_id, body.level, body.expires_at)
    )


def patient_audit(session: Session, subject: Subject, patient_id: str, page: Page) -> list[AuditOut]:
    """Return who did what with a patient's data, newest first; patients read their own."""
    patient = require_patient(session, subject, patient_id, "read")
    record(session, subject, "audit.read", patient_id)
    return read_audit(session, patient.clinic_id, patient_id, page)


def consents(session: Session, subject: Subject, patient_id: str) -> list[ConsentOut]:
    """Return what the patient agreed to."""
    require_patient(session, subject, patient_id, "read")
    record(session, subject, "consent.read", patient_id)
    return [ConsentOut.model_validate(row) for row in _answers(session, patient_id)]


def put_consent(session: Session, subject: Subject, patient_id: str, body: ConsentIn) -> list[ConsentOut]:
    """Store one answer and return all.

    Parameters
    ----------
    subject : Subject
        The patient, or who has the level `manage` and writes down what the patient said.
    """
    require_own_or_manage(session, subject, patient_id)
    _note_consent(session, subject, patient_id, body.purpose, body.granted)
    return [ConsentOut.model_validate(row) for row in _answers(session, patient_id)]


def _note_consent(session: Session, subject: Subject, patient_id: str, purpose: str, granted: bool) -> None:
    set_consent(session, patient_id, purpose, granted, subject.account_id or subject.id)
    record(session, subject, "consent.change", patient_id, None, {"purpose": purpose, "granted": granted})


def _answers(session: Session, patient_id: str) -> list[dict[str, object]]:
    return [
        {"purpose": row.purpose, "granted": row.granted, "changed_at": row.changed_at}
        for row in list_consents(session, patient_id)
    ]


def _out(subject: Subject, patient: Patient, has_mounting: bool, may_treat: bool) -> PatientOut:
    return PatientOut(
        id=patient.id,
        created_at=patient.created_at,
        archived_at=patient.archived_at,
        merged_into_id=patient.merged_into_id,
        given_name=patient.given_name,
        family_name=patient.family_name,
        birth_date=patient.birth_date,
        affected_side=patient.affected_side,
        notes=patient.notes,
        body_dimensions=BodyDimensionsIn(**patient.body_dimensions),
        has_mounting=has_mounting,
        may_treat=may_treat and patient.archived_at is None,
        may_manage=may_treat or subject.role == "administrator",
    )


def _grant_out(grant: Grant, display_name: str) -> GrantOut:
    return GrantOut(
        id=grant.id,
        account_id=grant.account_id,
        display_name=display_name,
        level=grant.level,
        expires_at=grant.expires_at,
        created_at=grant.created_at,
    )
