"""The register of what was ended for good, applied to an older database that a restore brought back.

The register (`app.database.ended`) names what was erased, revoked and withdrawn after a backup was made. It is applied
right after a restore, and at every start of the service: a database may also have been put back by hand.
"""

from collections import Counter
from collections.abc import Sequence
from functools import partial
from typing import Any, Final

from sqlalchemy import Engine, select
from sqlalchemy.orm import Session

from app.accounts import audit
from app.accounts.credentials.sign_in import end_all_sign_ins
from app.accounts.models import Account, AuditEvent, Consent, DeviceToken
from app.accounts.subject import Subject
from app.assessment.records import moving
from app.assessment.records.erasure import erase_now
from app.database.ended import ACTIONS, Ended
from app.database.engine import forget_deleted
from app.database.unit_of_work import read_only, unit_of_work
from app.patients.models import Grant, Patient
from app.recordings import repository as recordings
from app.recordings.models import MotionSession
from app.settings import Settings

AGAIN: Final = {"again": True}
"""Details of the audit event: done by the service itself, because the register says that it was done before."""


def apply(engine: Engine, settings: Settings, entries: Sequence[Ended]) -> Counter[str]:
    """End again what a register says was ended and the database holds as if it never was.

    Parameters
    ----------
    engine : Engine
        Of a database of the newest schema.
    entries : sequence of Ended
        Oldest first.

    Returns
    -------
    Counter of str
        How many: `patients`, `sessions`, `moves`, `tokens`, `grants`, `consents`, `accounts`; and `passwords` of
        accounts that had another one later than the database knows, which nobody can bring back.
    """
    done: Counter[str] = Counter()
    with read_only(engine) as session:
        # What the trail of the database has, the database has: both were committed together.
        known = set(session.scalars(select(AuditEvent.hash).where(AuditEvent.action.in_(ACTIONS))))
    newest = {_key(entry): entry for entry in entries}
    for entry in entries:
        if entry.hash in known or newest[_key(entry)] is not entry:
            continue
        with unit_of_work(engine) as session:
            if (name := _apply(session, settings, entry)) is not None:
                done[name] += 1
    if done["patients"] or done["sessions"]:
        forget_deleted(engine)
    return +done


def _key(entry: Ended) -> tuple[object, ...]:
    """Return what an event is about: of several, the newest says how it is."""
    what = entry.action.partition("_")[0] if entry.action.startswith("account.") else entry.action
    if entry.action == "session.move_in":
        return what, entry.resource_id
    return what, entry.patient_id, entry.resource_id, entry.details.get("purpose")


def in_words(done: Counter[str]) -> str:
    """Return what was done in one line for who runs the service, empty for nothing.

    Parameters
    ----------
    done : Counter of str
        From `apply`.
    """
    erased = [f"{done[name]} {name}" for name in ("patients", "sessions") if done[name]]
    moved = [f"moved again: {done['moves']} sessions"] if done["moves"] else []
    revoked = [f"{done[name]} {name}" for name in ("tokens", "grants", "consents", "accounts") if done[name]]
    parts = [f"erased again: {', '.join(erased)}"] if erased else []
    parts += moved
    parts += [f"revoked: {', '.join(revoked)}"] if revoked else []
    if done["passwords"]:
        parts.append(f"{done['passwords']} accounts have an older password again, give them a new one")
    return ", ".join(parts)


def _apply(session: Session, settings: Settings, entry: Ended) -> str | None:
    """End one thing again; return the name under which it is counted."""
    service = Subject.system(entry.clinic_id)
    note = partial(audit.record, session, service, entry.action, entry.patient_id, entry.resource_id)
    match entry.action:
        case "patient.erase":
            patient = session.get(Patient, entry.patient_id)
            if patient is None:
                return None
            erase_now(session, settings, service, patient)
            return "patients"
        case "session.delete":
            found = session.get(MotionSession, entry.resource_id)
            if found is None:
                return None
            recordings.erase_session(session, settings, found)
            note(AGAIN)
            return "sessions"
        case "session.move_in":
            is_moved = moving.put_again(session, str(entry.resource_id), str(entry.patient_id))
            return "moves" if is_moved else None
        case "device_token.revoke":
            return _revoked(session, DeviceToken, "tokens", entry, note)
        case "grant.revoke":
            return _revoked(session, Grant, "grants", entry, note)
        case "consent.change":
            return _withdrawn(session, entry, note)
        case "account.switch_off" | "account.switch_on":
            return _switched(session, entry, note)
        case "account.password_change" | "account.password_reset":
            return "passwords" if session.get(Account, entry.resource_id) is not None else None
    return None


def _revoked(
    session: Session, table: type[DeviceToken | Grant], name: str, entry: Ended, note: Any
) -> str | None:
    row: Any = session.get(table, entry.resource_id)
    if row is None or row.revoked_at is not None:
        return None
    row.revoked_at = entry.moment
    note(AGAIN)
    return name


def _withdrawn(session: Session, entry: Ended, note: Any) -> str | None:
    """Withdraw a yes that is older than a no. A yes that is lost is asked for again: nothing is widened here."""
    query = select(Consent).where(
        Consent.patient_id == entry.patient_id, Consent.purpose == entry.details.get("purpose")
    )
    row = session.scalar(query)
    if entry.details.get("granted") is not False or row is None or not row.granted:
        return None
    if row.changed_at > entry.moment:
        return None
    row.granted, row.changed_at = False, entry.moment
    note(entry.details | AGAIN)
    return "consents"


def _switched(session: Session, entry: Ended, note: Any) -> str | None:
    account = session.get(Account, entry.resource_id)
    is_active = entry.action == "account.switch_on"
    if account is None or account.is_active == is_active:
        return None
    account.is_active = is_active
    end_all_sign_ins(session, account.id)
    note(AGAIN)
    return None if is_active else "accounts"
