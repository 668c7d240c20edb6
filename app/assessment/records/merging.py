"""Two records of one person made one: everything moves into the record that stays, nothing is widened in silence.

Consents: a yes of the other record is not taken over, a no is, for its recordings were made under it. Rights of
colleagues to the other record stay with it, and give nothing here. Its devices are connected again, its sign-in goes
with the person unless the record that stays has one. The other record stays in the archive, empty, with its name, and
goes when the one that stays is erased. A session that does not belong is moved back (`app.assessment.records.moving`).
"""

from sqlalchemy import func, select, update
from sqlalchemy.orm import Session

from app.accounts import audit
from app.accounts.consents import list_consents, set_consent
from app.accounts.credentials.sign_in import end_all_sign_ins
from app.accounts.models import Account, DeviceToken
from app.accounts.subject import Subject
from app.assessment.models import CourseNote
from app.assessment.records.moving import move, require_rest, require_treated
from app.assessment.records.schemas import MergeIn, MergeOut
from app.database.base import utc_now
from app.errors import Conflict, InvalidInput
from app.exercises.models import Prescription, Template
from app.patients.access import require_patient
from app.patients.models import Mounting
from app.recordings.models import MotionSession
from estimators.sentences import say


def merge(session: Session, subject: Subject, patient_id: str, wanted: MergeIn) -> MergeOut:
    """Move everything of another record of the same person into this one.

    Parameters
    ----------
    session : Session
        Writing.
    subject : Subject
        Who may treat both patients.
    patient_id : str
        The record that stays; not archived, with consent to treatment.

    Raises
    ------
    NotFound, NotAllowed
        One of the records is not the subject's to treat.
    InvalidInput
        Both are the same.
    Conflict
        A session of the other record is live or being analysed, or it was merged before.
    """
    stays = require_patient(session, subject, patient_id, "treat")
    other = require_patient(session, subject, wanted.other_id, "read")
    require_treated(session, subject, other)
    reason = wanted.reason.strip()
    if not reason:
        raise InvalidInput(say("session.reason_needed"), field="reason")
    if stays.id == other.id:
        raise InvalidInput(say("patient.merge_itself"), field="other_id")
    if other.merged_into_id is not None:
        raise Conflict(say("patient.merged_before"))
    sessions = list(session.scalars(select(MotionSession).where(MotionSession.patient_id == other.id)))
    require_rest(session, sessions)
    for found in sessions:
        move(session, subject, found, stays.id, reason)
    counts = {
        "prescriptions": _prescriptions(session, stays.id, other.id),
        "templates": _own(session, Template, stays.id, other.id),
        "notes": _own(session, CourseNote, stays.id, other.id),
        "revoked_tokens": _tokens(session, subject, other.id),
    }
    withdrawn = _consents(session, subject, stays.id, other.id)
    _accounts(session, subject, stays.id, other.id)
    _mounting(session, stays.id, other.id)
    stays.birth_date = stays.birth_date or other.birth_date
    stays.affected_side = stays.affected_side or other.affected_side
    stays.body_dimensions = {**other.body_dimensions, **stays.body_dimensions}
    other.archived_at, other.merged_into_id = other.archived_at or utc_now(), stays.id
    details = {"reason": reason, "sessions": len(sessions), **counts}
    audit.record(session, subject, "patient.merge_in", stays.id, other.id, {"from": other.id, **details})
    audit.record(session, subject, "patient.merge_out", other.id, stays.id, {"to": stays.id, **details})
    session.flush()
    return MergeOut(patient_id=stays.id, sessions=len(sessions), withdrawn_consents=withdrawn, **counts)


def _own(session: Session, table: type[Template | CourseNote | Prescription], stays: str, other: str) -> int:
    found = session.scalar(select(func.count()).select_from(table).where(table.patient_id == other)) or 0
    session.execute(update(table).where(table.patient_id == other).values(patient_id=stays))
    return found


def _prescriptions(session: Session, stays: str, other: str) -> int:
    """Move prescriptions; of an exercise that is prescribed here too, the other record's ends: nobody does it twice."""
    now = utc_now()
    in_force = Prescription.ends_at.is_(None) | (Prescription.ends_at > now)
    here = select(Prescription.exercise_id).where(Prescription.patient_id == stays, in_force)
    doubled = session.scalars(
        select(Prescription).where(
            Prescription.patient_id == other, in_force, Prescription.exercise_id.in_(here)
        )
    )
    for one in doubled:
        one.ends_at = max(now, one.starts_at)
    session.flush()
    return _own(session, Prescription, stays, other)


def _tokens(session: Session, subject: Subject, other: str) -> int:
    """Revoke the other record's device tokens: each is bound to its patient by its signature."""
    tokens = session.scalars(
        select(DeviceToken).where(DeviceToken.patient_id == other, DeviceToken.revoked_at.is_(None))
    ).all()
    for row in tokens:
        row.revoked_at = utc_now()
        audit.record(session, subject, "device_token.revoke", other, row.id)
    return len(tokens)


def _consents(session: Session, subject: Subject, stays: str, other: str) -> list[str]:
    """Let each no of the other record hold here; a yes is not taken over. Returns the purposes that are withdrawn."""
    refused = {row.purpose for row in list_consents(session, other) if not row.granted}
    withdrawn = [
        row.purpose for row in list_consents(session, stays) if row.granted and row.purpose in refused
    ]
    for purpose in withdrawn:
        set_consent(session, stays, purpose, False, subject.account_id or subject.id)
        details = {"purpose": purpose, "granted": False}
        audit.record(session, subject, "consent.change", stays, None, details)
    return withdrawn


def _accounts(session: Session, subject: Subject, stays: str, other: str) -> None:
    """Let the person's sign-in open the record that stays; one too many is switched off. All are signed out."""
    has_one = session.scalar(select(Account.id).where(Account.patient_id == stays).limit(1)) is not None
    for account in session.scalars(select(Account).where(Account.patient_id == other)):
        end_all_sign_ins(session, account.id)
        if not has_one:
            account.patient_id = stays
        elif account.is_active:
            account.is_active = False
            audit.record(session, subject, "account.switch_off", other, account.id)


def _mounting(session: Session, stays: str, other: str) -> None:
    """Take the other record's remembered calibration over where there is none here."""
    if session.scalar(select(Mounting.id).where(Mounting.patient_id == stays)) is None:
        session.execute(update(Mounting).where(Mounting.patient_id == other).values(patient_id=stays))
