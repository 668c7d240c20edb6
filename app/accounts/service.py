"""What sign-in and account administration decide."""

from anyio import to_thread
from sqlalchemy import select
from sqlalchemy.orm import Session

from app.accounts import audit
from app.accounts.models import PATIENT, Account
from app.accounts.schemas import AccountIn, AccountOut, Me
from app.accounts.sign_in import (
    create_sign_in,
    end_sign_in,
    me,
    normalise_email,
    password_hash_of,
)
from app.accounts.subject import Subject
from app.accounts.tickets import account_subject
from app.database.base import new_id
from app.database.unit_of_work import read_only, unit_of_work
from app.errors import Conflict, InvalidInput, NotAllowed, NotFound, SignInRequired
from app.services import Services

WRONG = "E-mail address or password is wrong."


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


def list_accounts(session: Session, subject: Subject) -> list[AccountOut]:
    """Return the accounts that the subject may know of.

    Parameters
    ----------
    session : Session
    subject : Subject
        Administrators see all of their clinic, therapists their colleagues (to give grants to), others
        nobody.
    """
    query = select(Account).where(Account.clinic_id == subject.clinic_id).order_by(Account.display_name)
    if subject.role == "therapist":
        query = query.where(Account.role.in_(["administrator", "therapist", "integrator"]), Account.is_active)
    elif subject.role != "administrator":
        raise NotAllowed("Only the clinic's staff can list its accounts.")
    return [account_out(row) for row in session.scalars(query)]


async def create_account(services: Services, subject: Subject, body: AccountIn) -> AccountOut:
    """Create an account in the subject's clinic.

    Parameters
    ----------
    services : Services
    subject : Subject
        An administrator.
    body : AccountIn

    Raises
    ------
    NotAllowed
        Not an administrator.
    Conflict
        The e-mail address is taken.
    InvalidInput
        A patient's account without a patient, or another one with.
    NotFound
        No such patient in this clinic.
    """
    if subject.role != "administrator":
        raise NotAllowed("Only an administrator of the clinic can create accounts.")
    if (body.role == "patient") != (body.patient_id is not None):
        raise InvalidInput(
            "An account with the role patient, and no other, needs patient_id.", field="patient_id"
        )
    email = normalise_email(body.email)
    if email.count("@") != 1 or email.startswith("@") or email.endswith("@"):
        raise InvalidInput("The e-mail address needs a name, an @ and a host.", field="email")
    password_hash = await services.passwords.hash_in_turn(body.password)
    return await to_thread.run_sync(_store_account, services, subject, body, email, password_hash)


def account_out(row: Account) -> AccountOut:
    """Return an account as a colleague sees it.

    Parameters
    ----------
    row : Account
    """
    return AccountOut(
        id=row.id,
        display_name=row.display_name,
        email=row.email,
        role=row.role,
        is_active=row.is_active,
    )


def _look_up(services: Services, email: str) -> tuple[str | None, str | None]:
    with read_only(services.engine) as session:
        return password_hash_of(session, email)


def _store_hash(services: Services, account_id: str, password_hash: str) -> None:
    with unit_of_work(services.engine) as session:
        session.get_one(Account, account_id).password_hash = password_hash


def _store_account(
    services: Services, subject: Subject, body: AccountIn, email: str, password_hash: str
) -> AccountOut:
    with unit_of_work(services.engine) as session:
        if body.patient_id is not None:
            clinic_id = session.scalar(select(PATIENT.c.clinic_id).where(PATIENT.c.id == body.patient_id))
            if clinic_id != subject.clinic_id:
                raise NotFound("There is no such patient in this clinic.")
        if session.scalar(select(Account.id).where(Account.email == email)) is not None:
            raise Conflict("There is an account with this e-mail address already.", field="email")
        row = Account(
            id=new_id(),
            clinic_id=subject.clinic_id,
            role=body.role,
            email=email,
            display_name=body.display_name,
            password_hash=password_hash,
            patient_id=body.patient_id,
            is_active=True,
        )
        session.add(row)
        session.flush()
        audit.record(session, subject, "account.create", body.patient_id, row.id, {"role": body.role})
        return account_out(row)
