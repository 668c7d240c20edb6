"""The audit trail: one event for each read and write of patient data, in one hash chain per clinic.

Each event carries the SHA-256 of its own content and of the event before. Changing, inserting or removing an
event in the middle breaks every hash after it; `verify` finds the first break. The database refuses updates
and deletes of events with triggers. Somebody who owns the database file can still rewrite the whole chain or
cut its end off: keep `head` somewhere else (the backup archive does) and give it to `verify`.

Events hold identifiers and words, never names or measurements: erasing a patient leaves the trail whole.
"""

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import partial
from typing import Any

from sqlalchemy import insert, select
from sqlalchemy.orm import Session

from app.accounts.models import AuditEvent, Clinic
from app.accounts.subject import Subject
from app.database import ended
from app.database.base import utc_now
from app.database.unit_of_work import after_commit, before_commit

GENESIS = "0" * 64
"""Previous hash of the first event of a clinic."""


@dataclass(frozen=True)
class _Entry:
    subject: Subject
    action: str
    patient_id: str | None
    resource_id: str | None
    details: dict[str, Any]
    at: datetime


@dataclass(frozen=True)
class ChainReport:
    """Result of checking a clinic's chain.

    Attributes
    ----------
    events : int
        Events checked.
    broken_at : int or None
        Number of the first event that does not fit.
    head : str
        Hash of the last event that fits.
    """

    is_intact: bool
    events: int
    broken_at: int | None
    reason: str
    head: str


def record(
    session: Session,
    subject: Subject,
    action: str,
    patient_id: str | None = None,
    resource_id: str | None = None,
    details: dict[str, Any] | None = None,
) -> None:
    """Note one read or write; it is stored with this unit of work's commit, or not at all.

    Parameters
    ----------
    session : Session
        Of `unit_of_work` or `read_only`; after a read-only unit the event is written before the answer is
        given.
    subject : Subject
        Who acted.
    action : str
        Noun and verb: `patient.read`, `session.create`, `template.publish`.
    patient_id, resource_id : str, optional
        Whose data, and which thing.
    details : dict, optional
        JSON facts without names or measurements.
    """
    entry = _Entry(subject, action, patient_id, resource_id, dict(details or {}), utc_now())
    before_commit(session, _append, entry)


def _append(session: Session, entries: list[Any]) -> None:
    by_clinic: dict[str, list[_Entry]] = {}
    for entry in entries:
        by_clinic.setdefault(entry.subject.clinic_id, []).append(entry)
    # Always in the same order, so two units that touch the same two clinics cannot wait for each other.
    for clinic_id in sorted(by_clinic):
        _append_to_clinic(session, clinic_id, by_clinic[clinic_id])


def _append_to_clinic(session: Session, clinic_id: str, entries: Sequence[_Entry]) -> None:
    # One writer at a time per chain: SQLite's write lock is already held; PostgreSQL locks the clinic's row, in
    # the mode that does not disturb foreign keys to it.
    if session.get_bind().dialect.name == "postgresql":
        session.execute(select(Clinic.id).where(Clinic.id == clinic_id).with_for_update(key_share=True))
    number, previous = _last(session, clinic_id)
    rows = []
    for entry in entries:
        number += 1
        row = {
            "clinic_id": clinic_id,
            "number": number,
            "at": entry.at,
            "subject_kind": entry.subject.kind,
            "subject_id": entry.subject.id,
            "action": entry.action,
            "patient_id": entry.patient_id,
            "resource_id": entry.resource_id,
            "details": entry.details,
            "previous_hash": previous,
        }
        row["hash"] = previous = _digest(row)
        rows.append(row)
    # Plain inserts: the write lock is held, and objects would double the time.
    session.execute(insert(AuditEvent.__table__), rows)  # type: ignore[arg-type]
    register = session.get_bind().get_execution_options().get(ended.OPTION)
    if register is not None and (entries_for_good := [one for row in rows if (one := ended.of_event(row))]):
        after_commit(session, partial(ended.add, register, entries_for_good))


_CONTENT = (
    "clinic_id",
    "number",
    "at",
    "subject_kind",
    "subject_id",
    "action",
    "patient_id",
    "resource_id",
    "details",
    "previous_hash",
)


def _digest(row: Mapping[str, Any]) -> str:
    moment: datetime = row["at"]
    zoned = moment.astimezone(UTC).isoformat(timespec="microseconds")
    content = [zoned if name == "at" else row[name] for name in _CONTENT]
    text = json.dumps(content, sort_keys=True, separators=(",", ":"), ensure_ascii=True)
    return hashlib.sha256(text.encode()).hexdigest()


def hash_event(event: AuditEvent) -> str:
    """Return the SHA-256 of an event's content, in hexadecimal.

    Parameters
    ----------
    event : AuditEvent
        With `previous_hash`; its own `hash` is not part of the content.
    """
    return _digest({name: getattr(event, name) for name in _CONTENT})


def head(session: Session, clinic_id: str) -> tuple[int, str]:
    """Return number and hash of a clinic's last event; `(0, GENESIS)` for an empty chain."""
    return _last(session, clinic_id)


def verify(session: Session, clinic_id: str, expected_head: tuple[int, str] | None = None) -> ChainReport:
    """Check a clinic's whole chain.

    Parameters
    ----------
    expected_head : (int, str), optional
        A `head` that was stored elsewhere: the chain must still contain it, so a cut end is found too.

    Returns
    -------
    ChainReport
        With the first event that does not fit.
    """
    previous, count = GENESIS, 0
    found_head = expected_head is None or expected_head[0] == 0
    events = select(AuditEvent).where(AuditEvent.clinic_id == clinic_id).order_by(AuditEvent.number)
    for event in session.scalars(events.execution_options(yield_per=1000)):
        reason = _fault(event, count + 1, previous)
        if reason:
            return ChainReport(False, count, event.number, reason, previous)
        previous, count = event.hash, count + 1
        if expected_head is not None and event.number == expected_head[0]:
            if event.hash != expected_head[1]:
                return ChainReport(
                    False, count, event.number, "differs from the head that was stored", previous
                )
            found_head = True
    if not found_head:
        return ChainReport(False, count, count + 1, "events at the end are missing", previous)
    return ChainReport(True, count, None, "", previous)


def _fault(event: AuditEvent, number: int, previous: str) -> str:
    if event.number != number:
        return "an event is missing or out of order"
    if event.previous_hash != previous:
        return "does not follow the event before"
    if event.hash != hash_event(event):
        return "content was changed"
    return ""


def _last(session: Session, clinic_id: str) -> tuple[int, str]:
    row = session.execute(
        select(AuditEvent.number, AuditEvent.hash)
        .where(AuditEvent.clinic_id == clinic_id)
        .order_by(AuditEvent.number.desc())
        .limit(1)
    ).first()
    return (row.number, row.hash) if row else (0, GENESIS)
