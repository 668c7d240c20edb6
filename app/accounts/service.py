"""What signing in and changing the own password decide."""

from anyio import to_thread

from app.accounts import audit
from app.accounts.models import Account
from app.accounts.schemas import Me, PasswordIn
from app.accounts.sign_in import (
    FoundSignIn,
    create_sign_in,
    end_all_sign_ins,
    end_sign_in,
    me,
    normalise_email,
    password_hash_of,
)
from app.accounts.tickets import account_subject
from app.database.unit_of_work import read_only, unit_of_work
from app.errors import Conflict, InvalidInput, SignInRequired
from app.sentences import say
from app.services import Services

WRONG = say("sign_in.wrong")


async def check_password(services: Services, email: str, password: str, address: str) -> str:
    """Return the account that e-mail and password belong to.

    Parameters
    ----------
    services : Services
    email, password : str
        As typed.
    address : str
        Of the client, for the rate limit.

    Raises
    ------
    SignInRequired
        One answer for every wrong pair, and the same time to give it.
    TooManyAttempts
        After too many failures of this account or address.
    Unavailable
        Too many sign-ins wait already.
    """
    email = normalise_email(email)
    services.sign_in_limits.attempt(email, address)
    account_id, password_hash = await to_thread.run_sync(_look_up, services, email)
    fits = await services.passwords.verify_in_turn(password_hash, password)
    if not fits or account_id is None:
        services.refused_sign_ins.note(email)
        raise SignInRequired(WRONG)
    services.sign_in_limits.succeeded(email, address)
    if password_hash is not None and services.passwords.needs_rehash(password_hash):
        renewed = await services.passwords.hash_in_turn(password)
        await to_thread.run_sync(_store_hash, services, account_id, renewed)
    return account_id


def open_sign_in(services: Services, account_id: str, agent: str, old_token: str | None) -> tuple[str, Me]:
    """Open a browser session; one that the same browser still had is ended.

    Parameters
    ----------
    services : Services
    account_id : str
    agent : str
        User agent.
    old_token : str or None
        The cookie that came with the request.
    """
    with unit_of_work(services.engine) as session:
        if old_token:
            end_sign_in(session, old_token)
        token, row = create_sign_in(session, services.settings, account_id, agent)
        account = session.get_one(Account, account_id)
        audit.record(session, account_subject(account), "account.sign_in", account.patient_id, account_id)
        return token, me(session, account_id, row.csrf_token)


async def change_password(services: Services, current: FoundSignIn, body: PasswordIn, address: str) -> None:
    """Replace the own password; the account is signed out everywhere but here.

    Parameters
    ----------
    services : Services
    current : FoundSignIn
        Whose password, and the one browser session that stays.
    body : PasswordIn
    address : str
        Of the client: guesses at the present password count as failed sign-ins.

    Raises
    ------
    InvalidInput
        The present password is wrong, or the new one is the same.
    TooManyAttempts
        After too many wrong ones.
    Conflict
        The password was changed elsewhere at the same moment.
    """
    email, password_hash = await to_thread.run_sync(_own_hash, services, current.subject.id)
    services.sign_in_limits.attempt(email, address)
    if not await services.passwords.verify_in_turn(password_hash, body.old_password):
        services.refused_sign_ins.note(email)
        raise InvalidInput(say("account.password_wrong"), field="old_password")
    services.sign_in_limits.succeeded(email, address)
    if body.new_password == body.old_password:
        raise InvalidInput(say("account.password_same"), field="new_password")
    renewed = await services.passwords.hash_in_turn(body.new_password)
    await to_thread.run_sync(_replace_hash, services, current, password_hash, renewed)


def _look_up(services: Services, email: str) -> tuple[str | None, str | None]:
    with read_only(services.engine) as session:
        return password_hash_of(session, email)


def _store_hash(services: Services, account_id: str, password_hash: str) -> None:
    with unit_of_work(services.engine) as session:
        session.get_one(Account, account_id).password_hash = password_hash


def _own_hash(services: Services, account_id: str) -> tuple[str, str | None]:
    with read_only(services.engine) as session:
        row = session.get_one(Account, account_id)
        return row.email, row.password_hash


def _replace_hash(services: Services, current: FoundSignIn, present: str | None, renewed: str) -> None:
    with unit_of_work(services.engine) as session:
        row = session.get_one(Account, current.subject.id)
        if row.password_hash != present:
            raise Conflict(say("account.password_changed_elsewhere"))
        row.password_hash = renewed
        ended = end_all_sign_ins(session, row.id, but=current.id)
        audit.record(
            session,
            current.subject,
            "account.password_change",
            row.patient_id,
            row.id,
            {"sign_ins_ended": ended},
        )
