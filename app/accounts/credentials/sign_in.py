"""Browser sessions: made by sign-in, found again by the cookie, ended by sign-out, idleness or age."""

from collections.abc import Collection
from dataclasses import dataclass
from datetime import timedelta
from typing import Any, Literal

from sqlalchemy import Row, delete, select, update
from sqlalchemy.orm import Session

from app.accounts.credentials.tickets import account_subject
from app.accounts.credentials.tokens import hash_token, new_token
from app.accounts.models import Account, Clinic, SignIn, Ticket
from app.accounts.schemas import Me
from app.accounts.subject import Subject
from app.database.base import utc_now
from app.errors import NotAllowed, PasswordChangeRequired, SecondFactorRequired, SignInRequired
from app.sentences import say
from app.settings import Settings

COOKIE = "telemotion_session"
SEEN_AGAIN_AFTER = timedelta(seconds=60)
"""`last_seen_at` is written at most this often, so reading stays cheap."""
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


def normalise_email(email: str) -> str:
    """Return the form in which an e-mail address is stored and compared.

    Parameters
    ----------
    email : str
    """
    return email.strip().lower()


def password_hash_of(session: Session, email: str) -> tuple[str | None, str | None]:
    """Return account and password hash for a sign-in; `(None, None)` when nobody may sign in so.

    Parameters
    ----------
    session : Session
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
    account_id : str
    user_agent : str
        As the browser calls itself; shortened.

    Returns
    -------
    str
        The cookie's value; only its hash is stored.
    SignIn
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
    session : Session
    settings : Settings
    token : str
        The cookie's value.

    Raises
    ------
    SignInRequired
        Unknown, too old, idle too long, or the account is no longer active.
    """
    found = find_sign_ins(session, settings, {token})[token]
    if isinstance(found, SignInRequired):
        raise found
    return found


def find_sign_ins(
    session: Session, settings: Settings, tokens: Collection[str]
) -> dict[str, FoundSignIn | SignInRequired]:
    """Return the browser session behind each of some cookies, or what `find_sign_in` raises; in one statement.

    Parameters
    ----------
    session : Session
    settings : Settings
    tokens : collection of str
        Values of cookies.
    """
    now = utc_now()
    hashes = {hash_token(token): token for token in tokens}
    rows = session.execute(
        select(
            SignIn.id.label("sign_in_id"),
            SignIn.token_hash,
            SignIn.csrf_token,
            SignIn.last_seen_at,
            Account.id,
            Account.clinic_id,
            Account.role,
            Account.patient_id,
            Account.must_change_password,
            Account.totp_since,
        )
        .join(Account, Account.id == SignIn.account_id)
        .where(
            SignIn.token_hash.in_(hashes),
            SignIn.expires_at > now,
            SignIn.last_seen_at > now - timedelta(minutes=settings.sign_in_idle_minutes),
            Account.is_active,
        )
    )
    found: dict[str, FoundSignIn | SignInRequired] = {token: SignInRequired(_PLEASE) for token in tokens}
    for row in rows:
        token = hashes[row.token_hash]
        try:
            subject = account_subject(row)
        except SignInRequired as error:
            found[token] = error
            continue
        found[token] = FoundSignIn(
            id=row.sign_in_id,
            subject=subject,
            csrf_token=row.csrf_token,
            needs_touch=now - row.last_seen_at > SEEN_AGAIN_AFTER,
            must=must_first(settings, row),
        )
    return found


def first_to_do(found: FoundSignIn) -> NotAllowed | None:
    """Return the refusal of whatever else is asked for before what an account must do first.

    Parameters
    ----------
    found : FoundSignIn
    """
    if found.must == "password":
        return PasswordChangeRequired(say("sign_in.change_password_first"))
    if found.must == "second_factor":
        return SecondFactorRequired(say("sign_in.second_factor_first"))
    return None


def must_first(settings: Settings, account: Account | Row[*tuple[Any, ...]]) -> Must | None:
    """Return what an account has to do before anything else.

    Parameters
    ----------
    settings : Settings
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
    sign_in_id : str
    """
    session.execute(update(SignIn).where(SignIn.id == sign_in_id).values(last_seen_at=utc_now()))


def end_sign_in(session: Session, token: str) -> None:
    """Forget the browser session behind a cookie and the account's tickets that are still good.

    Parameters
    ----------
    session : Session
        Writing.
    token : str
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
    account_id : str
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
    account_id : str
    locale : str
        A language of the client; empty for that of the browser.
    """
    session.execute(update(Account).where(Account.id == account_id).values(locale=locale))


def me(session: Session, settings: Settings, account_id: str, csrf_token: str) -> Me:
    """Return what a browser needs to know about its own account.

    Parameters
    ----------
    session : Session
    settings : Settings
    account_id : str
    csrf_token : str
    """
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
        idle_minutes=settings.sign_in_idle_minutes,
    )
