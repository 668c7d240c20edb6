"""Tickets: a right to open one socket once, within 30 seconds. They travel in the first message, never in a
URL.
"""

from dataclasses import dataclass
from datetime import timedelta
from typing import Any, Literal

from sqlalchemy import CursorResult, Row, delete, select, update
from sqlalchemy.orm import Session

from app.accounts.credentials.tokens import hash_token, new_token
from app.accounts.device_tokens import device_subject, is_valid
from app.accounts.models import Account, DeviceToken, SignIn, Ticket
from app.accounts.subject import Subject
from app.database.base import utc_now
from app.errors import SignInRequired
from estimators.sentences import say

LIFE = timedelta(seconds=30)
Purpose = Literal["ingest", "live", "viewer"]
TICKET_REFUSED = say("sign_in.ticket_refused")


@dataclass(frozen=True)
class Redeemed:
    """What a ticket stood for: who, and for which session (or view)."""

    subject: Subject
    session_id: str


def issue_ticket(session: Session, subject: Subject, purpose: Purpose, session_id: str) -> tuple[str, Ticket]:
    """Make a ticket; the caller has checked the right to the session.

    Parameters
    ----------
    session : Session
        Writing.
    subject : Subject
        An account or a device.
    purpose : {"ingest", "live", "viewer"}
        The only use the ticket has.
    session_id : str
        The only session (or view) it opens.

    Returns
    -------
    str
        The ticket itself; only its hash is stored.
    Ticket
        The row, with `expires_at`.
    """
    now = utc_now()
    session.execute(delete(Ticket).where(Ticket.expires_at < now - timedelta(hours=1)))
    token = new_token()
    row = Ticket(
        token_hash=hash_token(token),
        purpose=purpose,
        account_id=subject.account_id,
        device_token_id=subject.id if subject.kind == "device" else None,
        sign_in_id=subject.sign_in_id,
        session_id=session_id,
        expires_at=now + LIFE,
        used_at=None,
    )
    session.add(row)
    session.flush()
    return token, row


def redeem_ticket(session: Session, token: str, purpose: Purpose, session_id: str | None = None) -> Redeemed:
    """Use a ticket up and return who it was given to; the caller checks the right to the session again.

    Parameters
    ----------
    session : Session
        Writing.
    token : str
        From the first message of the socket.
    purpose : {"ingest", "live", "viewer"}
        What this socket is for.
    session_id : str, optional
        The session that the socket's address names, where it names one.

    Raises
    ------
    SignInRequired
        Unknown, used, too old, for another purpose or session, or the account or device has lost its right, or the
        browser session that asked for it has ended.
    """
    now = utc_now()
    # One statement decides who was first, on every database.
    used = session.execute(
        update(Ticket)
        .where(
            Ticket.token_hash == hash_token(token),
            Ticket.purpose == purpose,
            Ticket.used_at.is_(None),
            Ticket.expires_at > now,
        )
        .values(used_at=now)
        .execution_options(synchronize_session=False)
    )
    if not isinstance(used, CursorResult) or used.rowcount != 1:
        raise SignInRequired(TICKET_REFUSED)
    row = session.scalars(select(Ticket).where(Ticket.token_hash == hash_token(token))).one()
    if session_id is not None and row.session_id != session_id:
        raise SignInRequired(TICKET_REFUSED)
    return Redeemed(_subject(session, row), row.session_id)


def is_open(session: Session, token: str, purpose: Purpose) -> bool:
    """Return whether a ticket could be redeemed now; it stays unused."""
    found = select(Ticket.id).where(
        Ticket.token_hash == hash_token(token),
        Ticket.purpose == purpose,
        Ticket.used_at.is_(None),
        Ticket.expires_at > utc_now(),
    )
    return session.scalar(found) is not None


def _subject(session: Session, row: Ticket) -> Subject:
    if row.device_token_id is not None:
        device = session.get(DeviceToken, row.device_token_id)
        if device is not None and is_valid(device):
            return device_subject(device)
    elif row.account_id is not None:
        account = session.get(Account, row.account_id)
        stands = row.sign_in_id is None or session.get(SignIn, row.sign_in_id) is not None
        if account is not None and account.is_active and stands:
            return account_subject(account, row.sign_in_id)
    raise SignInRequired(TICKET_REFUSED)


def account_subject(account: Account | Row[*tuple[Any, ...]], sign_in_id: str | None = None) -> Subject:
    """Return the subject of an account.

    Parameters
    ----------
    account : Account or Row
        The row has `id`, `clinic_id`, `role` and `patient_id`.
    sign_in_id : str, optional
        The browser session by which it asks.

    Raises
    ------
    SignInRequired
        Its role is none that this service knows.
    """
    role: str = account.role
    if role not in {"administrator", "therapist", "patient", "integrator"}:
        raise SignInRequired(say("sign_in.no_role"))
    return Subject(
        "account",
        account.id,
        account.id,
        account.clinic_id,
        role,  # type: ignore[arg-type]
        account.patient_id,
        sign_in_id,
    )
