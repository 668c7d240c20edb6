"""Decisions about signing in and changing one's own password."""

from anyio import to_thread

from app.accounts import audit
from app.accounts.credentials import second_factor
from app.accounts.credentials.browsers import known_browser, remember_browser
from app.accounts.credentials.password_change import replace_password
from app.accounts.credentials.password_rules import check_password as check_password_rules
from app.accounts.credentials.passwords import Passwords
from app.accounts.credentials.rate_limit import Attempt, SignInLimits
from app.accounts.credentials.sign_in import (
    FoundSignIn,
    create_sign_in,
    end_sign_in,
    me,
    normalise_email,
    password_hash_of,
)
from app.accounts.credentials.tickets import account_subject
from app.accounts.models import Account
from app.accounts.refusals import RefusedSignIns
from app.accounts.schemas import Me, PasswordIn, SecondFactorSetup, SignInRequest
from app.database.unit_of_work import read_only, unit_of_work
from app.errors import CodeRequired, Conflict, InvalidInput, SignInRequired
from app.services import Services
from estimators.sentences import say

WRONG = say("sign_in.wrong")


async def check_password(services: Services, wanted: SignInRequest, address: str, browser: str | None) -> str:
    """Return the account that e-mail, password and code belong to.

    Parameters
    ----------
    wanted : SignInRequest
        As typed.
    address : str
        Of the client, for the rate limit.
    browser : str or None
        The cookie of a browser that may have signed in before.

    Raises
    ------
    SignInRequired
        One answer for every wrong pair, and the same time to give it.
    CodeRequired
        The pair is right, the account has a second factor and no code came with it.
    TooManyAttempts
        After too many failures of this account or address.
    Unavailable
        Too many sign-ins wait already.
    """
    email = normalise_email(wanted.email)
    attempt = await to_thread.run_sync(_attempt, services, email, address, browser)
    account_id, password_hash = await to_thread.run_sync(_look_up, services, email)
    fits = await services.get(Passwords).verify_in_turn(password_hash, wanted.password)
    if not fits or account_id is None:
        services.get(RefusedSignIns).note(email)
        raise SignInRequired(WRONG)
    # A wrong code is a failed attempt like a wrong password: nothing is given back.
    has_second = await to_thread.run_sync(_check_code, services, account_id, wanted.code)
    if has_second is False:
        services.get(RefusedSignIns).note(email)
        raise SignInRequired(say("sign_in.code_wrong"), field="code")
    await to_thread.run_sync(attempt.succeeded)
    if has_second is None:
        raise CodeRequired(say("sign_in.code_needed"), field="code")
    if password_hash is not None and services.get(Passwords).needs_rehash(password_hash):
        renewed = await services.get(Passwords).hash_in_turn(wanted.password)
        await to_thread.run_sync(_store_hash, services, account_id, renewed)
    return account_id


def _attempt(services: Services, email: str, address: str, browser: str | None) -> Attempt:
    """Count an attempt, of a browser that has signed in before or of a stranger."""
    with read_only(services.engine) as session:
        known = known_browser(session, email, browser)
    return services.get(SignInLimits).attempt(email, address, known)


def _check_code(services: Services, account_id: str, code: str | None) -> bool | None:
    """Return whether the second factor is satisfied; None when a code is needed and there is none."""
    with unit_of_work(services.engine) as session:
        account = session.get_one(Account, account_id)
        if account.totp_since is None:
            return True
        return second_factor.use(session, account, code) if code else None


def open_sign_in(
    services: Services, account_id: str, agent: str, old_token: str | None, browser: str | None
) -> tuple[str, str, Me]:
    """Open a browser session; one that the same browser still had is ended.

    Parameters
    ----------
    agent : str
        User agent.
    old_token, browser : str or None
        The cookies that came with the request.

    Returns
    -------
    token, browser : str
        Values of the cookies.
    found : Me
    """
    with unit_of_work(services.engine) as session:
        if old_token:
            end_sign_in(session, old_token)
        token, row = create_sign_in(session, services.settings, account_id, agent)
        browser = remember_browser(session, account_id, browser)
        account = session.get_one(Account, account_id)
        audit.record(session, account_subject(account), "account.sign_in", account.patient_id, account_id)
        return token, browser, me(session, services.settings, account_id, row.csrf_token)


async def begin_second_factor(
    services: Services, current: FoundSignIn, password: str, address: str
) -> SecondFactorSetup:
    """Begin an own second factor: who finds a browser open must not lock its owner out.

    Parameters
    ----------
    password : str
        The own one.
    address : str
        Of the client.

    Raises
    ------
    InvalidInput
        The password is wrong.
    TooManyAttempts
        After too many wrong ones.
    Conflict
        One is in force already.
    """
    await _require_password(services, current, password, address, "password")

    def begin() -> SecondFactorSetup:
        with unit_of_work(services.engine) as session:
            return second_factor.begin(session, current.subject)

    return await to_thread.run_sync(begin)


async def remove_second_factor(services: Services, current: FoundSignIn, password: str, address: str) -> None:
    """Turn the own second factor off.

    Parameters
    ----------
    password : str
        The own one.
    address : str
        Of the client.

    Raises
    ------
    InvalidInput
        The password is wrong.
    TooManyAttempts
        After too many wrong ones.
    """
    await _require_password(services, current, password, address, "password")

    def remove() -> None:
        with unit_of_work(services.engine) as session:
            second_factor.remove(session, current.subject, session.get_one(Account, current.subject.id))

    await to_thread.run_sync(remove)


async def _require_password(
    services: Services, current: FoundSignIn, password: str, address: str, field: str
) -> str | None:
    """Return the hash of the own password when it was typed rightly."""
    # Who is signed in has a budget apart from strangers.
    own = f"signed in {current.subject.id}"
    account, attempt = await to_thread.run_sync(_own_attempt, services, current.subject.id, address, own)
    password_hash = account.password_hash
    if not await services.get(Passwords).verify_in_turn(password_hash, password):
        services.get(RefusedSignIns).note(account.email)
        raise InvalidInput(say("account.password_wrong"), field=field)
    await to_thread.run_sync(attempt.succeeded)
    return password_hash


async def change_password(
    services: Services, current: FoundSignIn, body: PasswordIn, address: str, browser: str | None
) -> None:
    """Replace the own password; the account is signed out everywhere but here.

    Parameters
    ----------
    current : FoundSignIn
        Whose password, and the one browser session that stays.
    address : str
        Of the client: guesses at the current password count as failed sign-ins.
    browser : str or None
        The cookie of this browser, which stays known; others are forgotten.

    Raises
    ------
    InvalidInput
        The current password is wrong, or the new one is the same or too easy to guess.
    TooManyAttempts
        After too many wrong ones.
    Conflict
        The password was changed elsewhere at the same moment.
    """
    password_hash = await _require_password(services, current, body.old_password, address, "old_password")
    if body.new_password == body.old_password:
        raise InvalidInput(say("account.password_same"), field="new_password")
    own = await to_thread.run_sync(_names_of, services, current.subject.id)
    check_password_rules(body.new_password, *own, field="new_password")
    renewed = await services.get(Passwords).hash_in_turn(body.new_password)
    await to_thread.run_sync(_replace_hash, services, current, password_hash, renewed, browser)


def _names_of(services: Services, account_id: str) -> tuple[str, str]:
    with read_only(services.engine) as session:
        row = session.get_one(Account, account_id)
        return row.email, row.display_name


def _look_up(services: Services, email: str) -> tuple[str | None, str | None]:
    with read_only(services.engine) as session:
        return password_hash_of(session, email)


def _store_hash(services: Services, account_id: str, password_hash: str) -> None:
    with unit_of_work(services.engine) as session:
        session.get_one(Account, account_id).password_hash = password_hash


def _own_attempt(services: Services, account_id: str, address: str, own: str) -> tuple[Account, Attempt]:
    """Count an attempt at the own password; return the account and the attempt."""
    with read_only(services.engine) as session:
        row = session.get_one(Account, account_id)
        session.expunge(row)
    return row, services.get(SignInLimits).attempt(row.email, address, own)


def _replace_hash(
    services: Services, current: FoundSignIn, present: str | None, renewed: str, browser: str | None
) -> None:
    with unit_of_work(services.engine) as session:
        row = session.get_one(Account, current.subject.id)
        if row.password_hash != present:
            raise Conflict(say("account.password_changed_elsewhere"))
        ended = replace_password(
            session, row, renewed, must_change=False, sign_in=current.id, browser=browser
        )
        audit.record(
            session,
            current.subject,
            "account.password_change",
            row.patient_id,
            row.id,
            {"sign_ins_ended": ended},
        )
