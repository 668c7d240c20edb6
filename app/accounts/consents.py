"""Consent by purpose: what the patient said, in the patient's or a therapist's record of it."""

from collections.abc import Collection

from sqlalchemy import bindparam, select
from sqlalchemy.orm import Session

from app.accounts.models import Consent
from app.database.base import utc_now

# Built once: it is asked for open sockets again and again, see `app.patients.access`.
_ANSWERED = select(Consent.patient_id, Consent.purpose, Consent.granted).where(
    Consent.patient_id.in_(bindparam("patients", expanding=True)),
    Consent.purpose.in_(bindparam("purposes", expanding=True)),
)


def answered(
    session: Session, patient_ids: Collection[str], purposes: Collection[str]
) -> dict[tuple[str, str], bool]:
    """Return yes or no by patient and purpose, in one statement; who was not asked is not in it.

    Parameters
    ----------
    purposes : collection of {"treatment", "research", "home_streaming"}
    """
    rows = session.execute(_ANSWERED, {"patients": list(patient_ids), "purposes": list(purposes)})
    return {(patient_id, purpose): granted for patient_id, purpose, granted in rows}


def list_consents(session: Session, patient_id: str) -> list[Consent]:
    """Return every answer of a patient, by purpose; the caller has checked the right to the patient."""
    query = select(Consent).where(Consent.patient_id == patient_id).order_by(Consent.purpose)
    return list(session.scalars(query))


def set_consent(session: Session, patient_id: str, purpose: str, granted: bool, changed_by: str) -> Consent:
    """Store the patient's answer; the caller has checked the right to the patient.

    Parameters
    ----------
    changed_by : str
        Account that stored it.
    """
    row = session.scalar(select(Consent).where(Consent.patient_id == patient_id, Consent.purpose == purpose))
    if row is None:
        row = Consent(patient_id=patient_id, purpose=purpose)
        session.add(row)
    row.granted = granted
    row.changed_at = utc_now()
    row.changed_by = changed_by
    session.flush()
    return row
