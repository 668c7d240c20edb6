"""Whether open sockets may stay open: one question to the database for many of them.

Every rule stands where it always stood (`app.patients.access`, `app.accounts`); here the facts of all sockets are read
together, so that a socket costs its share of seven statements at most.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import BindParameter, Engine, Row, bindparam, select
from sqlalchemy.exc import OperationalError
from sqlalchemy.exc import TimeoutError as PoolTimeout
from sqlalchemy.orm import Session

from app.accounts.credentials.sign_in import first_to_do, in_use, sign_ins_of
from app.accounts.device_tokens import is_valid
from app.accounts.models import Account, DeviceToken
from app.accounts.subject import Subject
from app.database.unit_of_work import read_only
from app.errors import NotFound, SignInRequired, TelemotionError
from app.live.repository import NO_SUCH_SESSION
from app.patients.access import Asked, Level, refusals
from app.recordings.models import MotionSession
from app.settings import Settings
from estimators.sentences import say

_IDS: BindParameter[list[str]] = bindparam("ids", expanding=True)
# Built once: see `app.patients.access`.
_SESSIONS = select(MotionSession.id, MotionSession.patient_id).where(MotionSession.id.in_(_IDS))
_DEVICES = select(DeviceToken.id, DeviceToken.revoked_at, DeviceToken.expires_at).where(
    DeviceToken.id.in_(_IDS)
)
_ACTIVE_ACCOUNTS = select(Account.id).where(Account.id.in_(_IDS), Account.is_active)


@dataclass(frozen=True)
class AuthorizationCheck:
    """Whether an open socket may stay open.

    Attributes
    ----------
    subject : Subject
        Who opened it. An account's socket ends with the browser session that opened it or asked for its ticket.
    session_id : str
        Of which session.
    level : {"status", "read", "record", "treat", "manage", "erase"}
        What it does with it.
    settings : Settings or None
        Of a socket that shows something: its browser session must be in use, and nothing else must be done first. None
        for one that takes movement: who exercises touches no screen.
    """

    subject: Subject
    session_id: str
    level: Level
    settings: Settings | None = None


def still_allowed(engine: Engine, question: AuthorizationCheck) -> None:
    """Check one open socket again: a set of one.

    Raises
    ------
    SignInRequired
        The browser session has ended, or account or device are not valid any more.
    PasswordChangeRequired, SecondFactorRequired
        As of a request.
    NotFound, NotAllowed
        Its right to the patient has gone; see `app.patients.access`.
    """
    (refusal,) = answers(engine, [question])
    if refusal is not None:
        raise refusal


def answers(engine: Engine, questions: Sequence[AuthorizationCheck]) -> list[TelemotionError | None]:
    """Return for each socket why it must end, None while it may go on.

    Notes
    -----
    Seven statements at most, however many sockets: browser sessions, devices, accounts, sessions; then patients, grants
    and consents.
    """
    with read_only(engine) as session:
        sign_ins = sign_ins_of(
            session, {one.subject.sign_in_id for one in questions if one.subject.sign_in_id}
        )
        devices = _valid_devices(
            session, {one.subject.id for one in questions if one.subject.kind == "device"}
        )
        accounts = _active(session, {one.subject.id for one in questions if one.subject.kind == "account"})
        found = session.execute(_SESSIONS, {"ids": list({one.session_id for one in questions})})
        patients = {row.id: row.patient_id for row in found}
        refused: list[TelemotionError | None] = []
        left: dict[int, Asked] = {}
        for number, one in enumerate(questions):
            refusal = _ended(one, sign_ins)
            if refusal is None:
                refusal = _is_nobody(one.subject, devices, accounts)
            if refusal is None and one.session_id not in patients:
                refusal = NotFound(NO_SUCH_SESSION)
            if refusal is None:
                left[number] = Asked(one.subject, patients[one.session_id], one.level)
            refused.append(refusal)
        for number, lost in zip(left, refusals(session, list(left.values())), strict=True):
            refused[number] = lost
        return refused


def answers_apart(engine: Engine, questions: Sequence[AuthorizationCheck]) -> list[Exception | None]:
    """Return the `answers`; what goes wrong with one question is the answer to it alone.

    Raises
    ------
    OperationalError, TimeoutError
        The database does not answer: nothing is known of any of them.
    """
    try:
        return list(answers(engine, questions))
    except (OperationalError, PoolTimeout):
        raise
    except Exception as error:
        if len(questions) == 1:
            return [error]
        return [answer for one in questions for answer in answers_apart(engine, [one])]


def _ended(
    question: AuthorizationCheck, sign_ins: Mapping[str, Row[*tuple[Any, ...]]]
) -> TelemotionError | None:
    if question.subject.sign_in_id is None:
        return None
    try:
        return first_to_do(in_use(question.settings, sign_ins.get(question.subject.sign_in_id)))
    except SignInRequired as error:
        return error


def _is_nobody(
    subject: Subject, devices: Collection[str], accounts: Collection[str]
) -> SignInRequired | None:
    if subject.kind == "device" and subject.id not in devices:
        return SignInRequired(say("live.token_expired"))
    if subject.kind == "account" and subject.id not in accounts:
        return SignInRequired(say("live.account_inactive"))
    return None


def _valid_devices(session: Session, ids: set[str]) -> set[str]:
    if not ids:
        return set()
    rows = session.execute(_DEVICES, {"ids": list(ids)})
    return {row.id for row in rows if is_valid(row)}


def _active(session: Session, ids: set[str]) -> set[str]:
    if not ids:
        return set()
    return set(session.scalars(_ACTIVE_ACCOUNTS, {"ids": list(ids)}))
