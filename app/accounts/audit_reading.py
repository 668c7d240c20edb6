"""The audit trail for people: names instead of identifiers; and for the register of what was ended for good."""

from pathlib import Path

from sqlalchemy import Engine, func, select
from sqlalchemy.orm import Session

from app.accounts.models import Account, AuditEvent, DeviceToken
from app.accounts.schemas import AuditOut
from app.database import ended
from app.database.unit_of_work import read_only
from app.pages import Page, rows_of


def read_audit(session: Session, clinic_id: str, patient_id: str, page: Page) -> list[AuditOut]:
    """Return a page of the events about a patient, newest first; the caller has checked the right to the patient."""
    query = select(AuditEvent).where(AuditEvent.clinic_id == clinic_id, AuditEvent.patient_id == patient_id)
    rows = rows_of(session, query, (AuditEvent.number,), page, newest_first=True)
    events = [event for (event,) in rows]
    people = _people(session, {event.subject_id for event in events})
    return [_out(event, people) for event in events]


def note_ended(engine: Engine, path: Path, above: int = 0) -> int:
    """Copy what the audit trail says was ended for good into the register, where it is not in it yet.

    Parameters
    ----------
    path : Path
        Of the register.
    above : int
        Only events with a higher number of their row.

    Returns
    -------
    int
        The highest number of a row, for the next time.
    """
    query = select(AuditEvent.__table__).where(AuditEvent.id > above, AuditEvent.action.in_(ended.ACTIONS))
    with read_only(engine) as session:
        newest = session.scalar(select(func.max(AuditEvent.id))) or 0
        rows = session.execute(query).mappings().all()
    ended.add(path, [one for row in rows if (one := ended.of_event(dict(row))) is not None])
    return newest


def _people(session: Session, ids: set[str]) -> dict[str, tuple[str, str]]:
    """Return name and role by identifier."""
    found = {"service": ("Telemotion", "system")}
    accounts = select(Account.id, Account.display_name, Account.role).where(Account.id.in_(ids))
    for account_id, name, role in session.execute(accounts):
        found[account_id] = (name, role)
    for token_id, label in session.execute(
        select(DeviceToken.id, DeviceToken.label).where(DeviceToken.id.in_(ids))
    ):
        found[token_id] = (label, "device")
    return found


def _out(event: AuditEvent, people: dict[str, tuple[str, str]]) -> AuditOut:
    who, role = people.get(event.subject_id, ("a former account", event.subject_kind))
    return AuditOut(
        at=event.at,
        who=who,
        role=role,
        action=event.action,
        resource_id=event.resource_id,
        details=event.details,
    )
