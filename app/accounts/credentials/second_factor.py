"""The second factor of an account: set up, used at sign-in, taken away.

Codes come from an authenticator program; ten recovery codes, each good once and stored hashed, stand in for a lost
telephone. An administrator can take the second factor of a colleague away, as with a forgotten password.
"""

import secrets
import time

from sqlalchemy import CursorResult, update
from sqlalchemy.orm import Session

from app.accounts import audit
from app.accounts.credentials import totp
from app.accounts.credentials.tickets import account_subject
from app.accounts.credentials.tokens import hash_token
from app.accounts.models import Account
from app.accounts.schemas import SecondFactorOut, SecondFactorSetup
from app.accounts.subject import Subject
from app.database.base import utc_now
from app.errors import Conflict, InvalidInput
from estimators.sentences import say

RECOVERY_CODES = 10
_LETTERS = "abcdefghjkmnpqrstuvwxyz23456789"


def second_factor(session: Session, subject: Subject) -> SecondFactorOut:
    """Return whether the own second factor is in force.

    Parameters
    ----------
    subject : Subject
        An account.
    """
    account = session.get_one(Account, subject.id)
    is_on = account.totp_since is not None
    return SecondFactorOut(
        is_on=is_on,
        since=account.totp_since,
        recovery_codes_left=len(account.recovery_hashes) if is_on else 0,
    )


def begin(session: Session, subject: Subject) -> SecondFactorSetup:
    """Make a secret for an authenticator program; it is not in force before `confirm`.

    Parameters
    ----------
    session : Session
        Writing.
    subject : Subject
        An account.

    Raises
    ------
    Conflict
        One is in force already.
    """
    account = session.get_one(Account, subject.id)
    if account.totp_since is not None:
        raise Conflict(say("second_factor.is_on"))
    account.totp_secret = totp.new_secret()
    return SecondFactorSetup(secret=account.totp_secret, uri=totp.uri(account.totp_secret, account.email))


def confirm(session: Session, subject: Subject, code: str) -> list[str]:
    """Put the second factor in force and return the recovery codes, this once.

    Parameters
    ----------
    session : Session
        Writing.
    subject : Subject
        An account.
    code : str
        From the program: proof that it has the secret.

    Raises
    ------
    Conflict
        Nothing was begun, or one is in force already.
    InvalidInput
        The code is wrong.
    """
    account = session.get_one(Account, subject.id)
    if account.totp_secret is None or account.totp_since is not None:
        raise Conflict(say("second_factor.not_begun"))
    step = totp.step_of(account.totp_secret, code, time.time())
    if step is None:
        raise InvalidInput(
            say("second_factor.code_wrong"),
            field="code",
        )
    codes = [_recovery_code() for _ in range(RECOVERY_CODES)]
    account.totp_since, account.totp_last_step, account.totp_removed_at = utc_now(), step, None
    account.recovery_hashes = [hash_token(one) for one in codes]
    audit.record(session, subject, "account.second_factor_on", account.patient_id, account.id)
    return codes


def _recovery_code() -> str:
    """Return 79 random bits that can be read from paper."""
    return "-".join("".join(secrets.choice(_LETTERS) for _ in range(4)) for _ in range(4))


def use(session: Session, account: Account, code: str) -> bool:
    """Use a code up; False when it is wrong or was used before.

    Parameters
    ----------
    session : Session
        Writing.
    account : Account
        With a second factor in force.
    code : str
        Of the program, or a recovery code.
    """
    step = totp.step_of(account.totp_secret or "", code, time.time())
    if step is not None:
        # One statement decides who was first.
        used = session.execute(
            update(Account)
            .where(Account.id == account.id, Account.totp_last_step < step)
            .values(totp_last_step=step)
            .execution_options(synchronize_session=False)
        )
        return isinstance(used, CursorResult) and used.rowcount == 1
    typed = hash_token(code.strip().lower())
    if typed not in account.recovery_hashes:
        return False
    account.recovery_hashes = [one for one in account.recovery_hashes if one != typed]
    left = {"left": len(account.recovery_hashes)}
    acting = account_subject(account)
    audit.record(session, acting, "account.recovery_code", account.patient_id, account.id, left)
    return True


def remove(session: Session, acting: Subject, account: Account) -> None:
    """Take a second factor away; nothing happens when there is none.

    Parameters
    ----------
    session : Session
        Writing.
    acting : Subject
        Who does it: the account itself or an administrator.
    """
    if account.totp_since is not None:
        audit.record(session, acting, "account.second_factor_off", account.patient_id, account.id)
        if acting.account_id != account.id:
            account.totp_removed_at = utc_now()
    account.totp_secret = account.totp_since = None
    account.recovery_hashes = []


def note_read(session: Session, subject: Subject) -> None:
    """Note that the person has read that an administrator took the second factor away.

    Parameters
    ----------
    session : Session
        Writing.
    subject : Subject
        An account.
    """
    session.get_one(Account, subject.id).totp_removed_at = None
