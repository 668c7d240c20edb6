"""Browser sessions: made by sign-in, found again by the cookie, ended by sign-out, idleness or age."""

import base64
from collections.abc import Collection
from dataclasses import dataclass
from datetime import timedelta
from typing import Any, Literal

from sqlalchemy import Row, bindparam, delete, select, update
from sqlalchemy.orm import Session

from app.accounts.credentials.tickets import account_subject
from app.accounts.credentials.tokens import hash_token, new_token
from app.accounts.models import Account, Clinic, SignIn, Ticket
from app.accounts.schemas import Me
from app.accounts.subject import Subject
from app.database.base import utc_now
from app.errors import NotAllowed, PasswordChangeRequired, SecondFactorRequired, SignInRequired
from app.settings import Settings
from estimators.sentences import say

COOKIE = "telemotion_session"
_SEEN_AGAIN_AFTER = timedelta(seconds=60)
_PLEASE = say("sign_in.required")


Must = Literal["password", "second_factor"]


@dataclass(frozen=True)
class FoundSignIn:
    """A valid browser session."""

    id: str
    subject: Subject
    csrf_token: str
    needs_touch: bool
    must: Must | None = None
    """What has to be done before anything else."""


def seen_again_after(settings: Settings) -> timedelta:
    """Return how often `last_seen_at` is written at most, so reading stays cheap.

    Parameters
    ----------
    settings : Settings
        A browser session in use must not end between two writes: a quarter of the time after which an idle one ends.
    """
    return min(_SEEN_AGAIN_AFTER, timedelta(minutes=settings.sign_in_idle_minutes) / 4)


def normalise_email(email: str) -> str:
    """Return the form in which an e-mail address is stored and compared."""
    return email.strip().lower()


def password_hash_of(session: Session, email: str) -> tuple[str | None, str | None]:
    """Return account and password hash for a sign-in; `(None, None)` when nobody may sign in so.

    Parameters
    ----------
    email : str
        Normalised.
    """
    row = session.execute(
        select(Account.id, Account.password_hash).where(Account.email == email, Account.is_active)
    ).first()
    return (row.id, row.password_hash) if row else (None, None)


def create_sign_in(
    session: Session, settings: Settings, account_id: str, user_agent: str
) -> tuple[str, SignIn]:
    """Open a browser session.

    Parameters
    ----------
    session : Session
        Writing.
    settings : Settings
        For the life time.
    user_agent : str
        As the browser calls itself; shortened.

    Returns
    -------
    str
        The cookie's value; only its hash is stored.
    """
    now = utc_now()
    session.execute(delete(SignIn).where(SignIn.expires_at < now))
    token = new_token()
    row = SignIn(
        account_id=account_id,
        token_hash=hash_token(token),
        csrf_token=new_token(),
        expires_at=now + timedelta(hours=settings.sign_in_hours),
        last_seen_at=now,
        user_agent=user_agent[:200],
    )
    session.add(row)
    session.flush()
    return token, row


def find_sign_in(session: Session, settings: Settings, token: str) -> FoundSignIn:
    """Return the browser session behind a cookie.

    Parameters
    ----------
    token : str
        The cookie's value.

    Raises
    ------
    SignInRequired
        Unknown, too old, idle too long, or the account is no longer active.
    """
    row = session.execute(_BY_TOKEN, {"token_hash": hash_token(token)}).one_or_none()
    return in_use(settings, row)


_SIGN_INS = (
    select(
        SignIn.id.label("sign_in_id"),
        SignIn.csrf_token,
        SignIn.last_seen_at,
        SignIn.expires_at,
        Account.id,
        Account.clinic_id,
        Account.role,
        Account.patient_id,
        Account.must_change_password,
        Account.totp_since,
    )
    .join(Account, Account.id == SignIn.account_id)
    .where(Account.is_active)
)
_BY_TOKEN = _SIGN_INS.where(SignIn.token_hash == bindparam("token_hash"))
_BY_ID = _SIGN_INS.where(SignIn.id.in_(bindparam("ids", expanding=True)))


def sign_ins_of(session: Session, ids: Collection[str]) -> dict[str, Row[*tuple[Any, ...]]]:
    """Return what is stored of browser sessions that nobody has ended, in one statement, for `in_use`.

    Parameters
    ----------
    ids : collection of str
        Their identifiers.
    """
    if not ids:
        return {}
    return {row.sign_in_id: row for row in session.execute(_BY_ID, {"ids": list(ids)})}


def in_use(settings: Settings | None, row: Row[*tuple[Any, ...]] | None) -> FoundSignIn:
    """Return a browser session that has not ended.

    Parameters
    ----------
    settings : Settings or None
        None where it need not be in use: it stands until somebody signs out, the password changes, or it is too old.
    row : Row or None
        As stored; None for one that is not.

    Raises
    ------
    SignInRequired
        Ended, too old, or idle too long.
    """
    now = utc_now()
    if row is None or row.expires_at <= now:
        raise SignInRequired(_PLEASE)
    subject = account_subject(row, row.sign_in_id)
    if settings is None:
        return FoundSignIn(row.sign_in_id, subject, row.csrf_token, needs_touch=False)
    if now - row.last_seen_at >= timedelta(minutes=settings.sign_in_idle_minutes):
        raise SignInRequired(_PLEASE)
    return FoundSignIn(
        id=row.sign_in_id,
        subject=subject,
        csrf_token=row.csrf_token,
        needs_touch=now - row.last_seen_at > seen_again_after(settings),
        must=must_first(settings, row),
    )


def first_to_do(found: FoundSignIn) -> NotAllowed | None:
    """Return the refusal of whatever else is asked for before what an account must do first."""
    if found.must == "password":
        return PasswordChangeRequired(say("sign_in.change_password_first"))
    if found.must == "second_factor":
        return SecondFactorRequired(say("sign_in.second_factor_first"))
    return None


def must_first(settings: Settings, account: Account | Row[*tuple[Any, ...]]) -> Must | None:
    """Return what an account has to do before anything else.

    Parameters
    ----------
    account : Account or Row
        The row has `role`, `must_change_password` and `totp_since`.
    """
    if account.must_change_password:
        return "password"
    is_staff = account.role in {"administrator", "therapist"}
    if is_staff and settings.staff_second_factor == "required" and account.totp_since is None:
        return "second_factor"
    return None


def touch(session: Session, sign_in_id: str) -> None:
    """Note that the browser session is in use.

    Parameters
    ----------
    session : Session
        Writing.
    """
    session.execute(update(SignIn).where(SignIn.id == sign_in_id).values(last_seen_at=utc_now()))


def end_sign_in(session: Session, token: str) -> None:
    """Forget the browser session behind a cookie and the account's tickets that are still good.

    Parameters
    ----------
    session : Session
        Writing.
    """
    ended = session.scalars(
        delete(SignIn).where(SignIn.token_hash == hash_token(token)).returning(SignIn.account_id)
    ).all()
    # A ticket lives for seconds: another browser of the same person asks for a new one.
    session.execute(delete(Ticket).where(Ticket.account_id.in_(ended), Ticket.used_at.is_(None)))


def end_all_sign_ins(session: Session, account_id: str, but: str | None = None) -> int:
    """Forget every browser session of an account, and its tickets that are still good.

    Parameters
    ----------
    session : Session
        Writing.
    but : str, optional
        Identifier of the one browser session that stays.

    Returns
    -------
    int
        Browser sessions that ended.
    """
    ended = session.scalars(
        delete(SignIn).where(SignIn.account_id == account_id, SignIn.id != (but or "")).returning(SignIn.id)
    ).all()
    session.execute(delete(Ticket).where(Ticket.account_id == account_id, Ticket.used_at.is_(None)))
    return len(ended)


def choose_locale(session: Session, account_id: str, locale: str) -> None:
    """Remember in which language somebody reads the client.

    Parameters
    ----------
    session : Session
        Writing.
    locale : str
        A language of the client; empty for that of the browser.
    """
    session.execute(update(Account).where(Account.id == account_id).values(locale=locale))


def me(session: Session, settings: Settings, account_id: str, csrf_token: str) -> Me:
    """Return what a browser needs to know about its own account."""
    account, clinic_name = session.execute(
        select(Account, Clinic.name)
        .join(Clinic, Clinic.id == Account.clinic_id)
        .where(Account.id == account_id)
    ).one()
    return Me(
        account_id=account.id,
        display_name=account.display_name,
        email=account.email,
        role=account.role,
        clinic_id=account.clinic_id,
        clinic_name=clinic_name,
        patient_id=account.patient_id,
        locale=account.locale,
        csrf_token=csrf_token,
        must=must_first(settings, account),
        second_factor_removed_at=account.totp_removed_at,
        second_factor_since=account.totp_since,
        store_key=base64.b64encode(settings.key_for(f"browser-store/{account.id}")).decode(),
        idle_minutes=settings.sign_in_idle_minutes,
    )
