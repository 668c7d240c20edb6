"""The clinic's accounts: listed for colleagues; made, changed and switched off by administrators."""

from anyio import to_thread
from sqlalchemy import select
from sqlalchemy.orm import Session

from app.accounts import audit
from app.accounts.credentials import second_factor
from app.accounts.credentials.password_change import replace_password
from app.accounts.credentials.password_rules import check_password
from app.accounts.credentials.passwords import Passwords
from app.accounts.credentials.sign_in import end_all_sign_ins, normalise_email
from app.accounts.models import PATIENT, Account
from app.accounts.schemas import AccountIn, AccountOut, AccountPatch
from app.accounts.subject import Subject
from app.database.base import new_id
from app.database.unit_of_work import unit_of_work
from app.errors import Conflict, InvalidInput, NotAllowed, NotFound
from app.pages import Page, rows_of
from app.services import Services
from estimators.sentences import say

NO_SUCH_ACCOUNT = say("account.not_found")


def list_accounts(session: Session, subject: Subject, page: Page) -> list[AccountOut]:
    """Return a page of the accounts that the subject may know of, by name.

    Parameters
    ----------
    subject : Subject
        Administrators see all of their clinic, therapists their colleagues (to give grants to), others
        nobody.
    """
    query = select(Account).where(Account.clinic_id == subject.clinic_id)
    if subject.role == "therapist":
        query = query.where(Account.role.in_(["administrator", "therapist", "integrator"]), Account.is_active)
    elif subject.role != "administrator":
        raise NotAllowed(say("account.list_not_allowed"))
    rows = rows_of(session, query, (Account.display_name, Account.id), page)
    return [account_out(row, subject) for (row,) in rows]


async def create_account(services: Services, subject: Subject, body: AccountIn) -> AccountOut:
    """Create an account in the subject's clinic.

    Parameters
    ----------
    subject : Subject
        An administrator.

    Raises
    ------
    NotAllowed
        Not an administrator.
    Conflict
        The e-mail address is taken.
    InvalidInput
        The password is too easy to guess; a patient's account without a patient, or another one with.
    NotFound
        No such patient in this clinic.
    """
    if subject.role != "administrator":
        raise NotAllowed(say("account.create_not_allowed"))
    if (body.role == "patient") != (body.patient_id is not None):
        raise InvalidInput(say("account.patient_id"), field="patient_id")
    email = normalise_email(body.email)
    if email.count("@") != 1 or email.startswith("@") or email.endswith("@"):
        raise InvalidInput(say("account.email_form"), field="email")
    check_password(body.password, email, body.display_name)
    password_hash = await services.get(Passwords).hash_in_turn(body.password)
    return await to_thread.run_sync(_store_account, services, subject, body, email, password_hash)


async def update_account(
    services: Services, subject: Subject, account_id: str, body: AccountPatch
) -> AccountOut:
    """Change an account of the subject's clinic: its name, whether it may sign in, or a forgotten password.

    Parameters
    ----------
    subject : Subject
        An administrator.

    Raises
    ------
    NotAllowed
        Not an administrator.
    NotFound
        No such account in this clinic.
    Conflict
        The administrator's own account: switching it off could leave the clinic without one, and the own password and
        second factor are changed by who knows the current password.

    Notes
    -----
    Switched off, with a new password or without its second factor, an account is signed out everywhere. Device
    tokens that it made stay: they belong to the patients, and each can be revoked there.
    """
    if subject.role != "administrator":
        raise NotAllowed(say("account.change_not_allowed"))
    password_hash = None
    if body.password is not None:
        check_password(body.password)
        password_hash = await services.get(Passwords).hash_in_turn(body.password)
    return await to_thread.run_sync(_change_account, services, subject, account_id, body, password_hash)


def account_out(row: Account, subject: Subject) -> AccountOut:
    """Return an account as a colleague sees it.

    Parameters
    ----------
    subject : Subject
        Who looks: only administrators see whether it has a second factor.
    """
    return AccountOut(
        id=row.id,
        display_name=row.display_name,
        email=row.email,
        role=row.role,
        is_active=row.is_active,
        has_second_factor=row.totp_since is not None if subject.role == "administrator" else None,
    )


def _store_account(
    services: Services, subject: Subject, body: AccountIn, email: str, password_hash: str
) -> AccountOut:
    with unit_of_work(services.engine) as session:
        if body.patient_id is not None:
            clinic_id = session.scalar(select(PATIENT.c.clinic_id).where(PATIENT.c.id == body.patient_id))
            if clinic_id != subject.clinic_id:
                raise NotFound(say("account.no_such_patient"))
        if session.scalar(select(Account.id).where(Account.email == email)) is not None:
            raise Conflict(say("account.email_taken"), field="email")
        row = Account(
            id=new_id(),
            clinic_id=subject.clinic_id,
            role=body.role,
            email=email,
            display_name=body.display_name,
            password_hash=password_hash,
            patient_id=body.patient_id,
            is_active=True,
            must_change_password=True,
        )
        session.add(row)
        session.flush()
        audit.record(session, subject, "account.create", body.patient_id, row.id, {"role": body.role})
        return account_out(row, subject)


def _change_account(
    services: Services, subject: Subject, account_id: str, body: AccountPatch, password_hash: str | None
) -> AccountOut:
    with unit_of_work(services.engine) as session:
        row = session.get(Account, account_id)
        if row is None or row.clinic_id != subject.clinic_id:
            raise NotFound(NO_SUCH_ACCOUNT)
        if row.id == subject.account_id and (
            body.is_active is False or password_hash is not None or body.remove_second_factor
        ):
            raise Conflict(say("account.own"))
        actions = []
        if body.display_name is not None and body.display_name != row.display_name:
            row.display_name = body.display_name
            actions.append("account.rename")
        if password_hash is not None:
            replace_password(session, row, password_hash, must_change=True)
            actions.append("account.password_reset")
        if body.is_active is not None and body.is_active != row.is_active:
            row.is_active = body.is_active
            actions.append("account.switch_on" if body.is_active else "account.switch_off")
        lost_factor = body.remove_second_factor and row.totp_since is not None
        if not row.is_active or lost_factor:
            end_all_sign_ins(session, row.id)
        if body.remove_second_factor:
            second_factor.remove(session, subject, row)
        for action in actions:
            audit.record(session, subject, action, row.patient_id, row.id)
        session.flush()
        return account_out(row, subject)
