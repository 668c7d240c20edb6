"""Signing in and out, and the clinic's accounts."""

from anyio import to_thread
from fastapi import APIRouter, Depends, Request, Response

from app.accounts import administration, clinics, service
from app.accounts.credentials import browsers, second_factor
from app.accounts.credentials.cookies import set_cookie, shown_cookie
from app.accounts.credentials.sign_in import COOKIE, choose_locale, end_sign_in, me
from app.accounts.dependencies import (
    CurrentAccount,
    CurrentSignIn,
    is_own_origin,
    require_own_origin,
)
from app.accounts.schemas import (
    AccountIn,
    AccountOut,
    AccountPatch,
    ClinicOut,
    ClinicPatch,
    Me,
    MePatch,
    OwnPassword,
    PasswordIn,
    RecoveryCodes,
    SecondFactorConfirm,
    SecondFactorOut,
    SecondFactorSetup,
    SignInRequest,
)
from app.database.dependencies import ReadSession, WriteSession
from app.pages import WantedPage
from app.services import services_of

router = APIRouter(prefix="/api", tags=["accounts"])


def _not_from_another_site(request: Request) -> None:
    """Refuse a sign-in that another site's page provokes; programs without a browser send no Origin."""
    if request.headers.get("origin") and not is_own_origin(services_of(request).settings, request):
        require_own_origin(request)


@router.post("/sign-in", dependencies=[Depends(_not_from_another_site)], responses={401: {}, 403: {}})
async def sign_in(body: SignInRequest, request: Request, response: Response) -> Me:
    """Sign in with e-mail and password; the answer sets the session cookie.

    Errors: `sign_in_required` for any wrong pair, `code_required` when the account has a second factor,
    `too_many_attempts` with Retry-After, `unavailable`.
    """
    services = services_of(request)
    address = _address(request)
    agent = request.headers.get("user-agent", "")
    settings = services.settings
    browser = shown_cookie(settings, request, browsers.COOKIE)
    old_token = shown_cookie(settings, request, COOKIE)
    account_id = await service.check_password(services, body, address, browser)
    token, known, found = await to_thread.run_sync(
        service.open_sign_in, services, account_id, agent, old_token, browser
    )
    set_cookie(response, settings, COOKIE, token, settings.sign_in_hours * 3600)
    set_cookie(response, settings, browsers.COOKIE, known, int(browsers.LIFE.total_seconds()))
    return found


@router.post("/sign-out", status_code=204)
def sign_out(current: CurrentSignIn, request: Request, response: Response, session: WriteSession) -> None:
    """End this browser session."""
    settings = services_of(request).settings
    end_sign_in(session, shown_cookie(settings, request, COOKIE) or "")
    set_cookie(response, settings, COOKIE, "", 0)


@router.get("/me")
def who_am_i(current: CurrentSignIn, request: Request, session: ReadSession) -> Me:
    """Return the signed-in account with its CSRF token."""
    return me(session, services_of(request).settings, current.subject.id, current.csrf_token)


@router.patch("/me", status_code=204)
def change_me(body: MePatch, current: CurrentSignIn, session: WriteSession) -> None:
    """Choose the language of the own account."""
    choose_locale(session, current.subject.id, body.locale)


@router.post("/me/password", status_code=204)
async def change_password(body: PasswordIn, current: CurrentSignIn, request: Request) -> None:
    """Change the own password; every other browser is signed out.

    Errors: `invalid_input` with the field when the current password is wrong or the new one is too short or the same,
    `too_many_attempts` with Retry-After.
    """
    browser = shown_cookie(services_of(request).settings, request, browsers.COOKIE)
    await service.change_password(services_of(request), current, body, _address(request), browser)


@router.get("/me/second-factor")
def read_second_factor(current: CurrentSignIn, session: ReadSession) -> SecondFactorOut:
    """Return whether an authenticator app is asked for at sign-in."""
    return second_factor.second_factor(session, current.subject)


@router.post("/me/second-factor", responses={409: {}})
async def begin_second_factor(
    body: OwnPassword, current: CurrentSignIn, request: Request
) -> SecondFactorSetup:
    """Get a secret for an authenticator app, with the own password; it counts once a code of the app was sent to
    `confirm`.

    Errors: `invalid_input` when the password is wrong, `too_many_attempts` with Retry-After, `conflict` when one is in
    force.
    """
    return await service.begin_second_factor(services_of(request), current, body.password, _address(request))


@router.post("/me/second-factor/confirm", responses={409: {}})
def confirm_second_factor(
    body: SecondFactorConfirm, current: CurrentSignIn, session: WriteSession
) -> RecoveryCodes:
    """Put the second factor in force; the answer has the recovery codes, this once.

    Errors: `invalid_input` for a wrong code, `conflict` when nothing was begun.
    """
    return RecoveryCodes(codes=second_factor.confirm(session, current.subject, body.code))


@router.post("/me/second-factor/remove", status_code=204)
async def remove_second_factor(body: OwnPassword, current: CurrentSignIn, request: Request) -> None:
    """Turn the second factor off, with the own password.

    Errors: `invalid_input` when it is wrong, `too_many_attempts` with Retry-After.
    """
    await service.remove_second_factor(services_of(request), current, body.password, _address(request))


@router.post("/me/second-factor/noted", status_code=204)
def note_second_factor(current: CurrentSignIn, session: WriteSession) -> None:
    """Stop telling that an administrator turned the second factor off."""
    second_factor.note_read(session, current.subject)


@router.get("/accounts")
def list_accounts(subject: CurrentAccount, session: ReadSession, page: WantedPage) -> list[AccountOut]:
    """Return the clinic's accounts: all for administrators, colleagues only for therapists."""
    return administration.list_accounts(session, subject, page)


@router.post("/accounts", status_code=201)
async def create_account(body: AccountIn, subject: CurrentAccount, request: Request) -> AccountOut:
    """Create an account; administrators only.

    Errors: `not_allowed`, `conflict` when the e-mail address is taken, `not_found` for another clinic's
    patient.
    """
    return await administration.create_account(services_of(request), subject, body)


@router.patch("/accounts/{account_id}")
async def update_account(
    account_id: str, body: AccountPatch, subject: CurrentAccount, request: Request
) -> AccountOut:
    """Rename an account, switch it off or on, give a new password to who forgot it, or take the second factor away
    from who lost it; administrators only.

    All but renaming and switching on sign the account out everywhere.

    Errors: `not_allowed`, `not_found` for another clinic's account, `conflict` for the own one.
    """
    return await administration.update_account(services_of(request), subject, account_id, body)


@router.get("/clinic")
def read_clinic(subject: CurrentAccount, session: ReadSession, request: Request) -> ClinicOut:
    """Return the own clinic with the time zone in which its weeks begin."""
    return clinics.read_clinic(session, subject, services_of(request).settings.time_zone)


@router.patch("/clinic")
def change_clinic(
    body: ClinicPatch, subject: CurrentAccount, session: WriteSession, request: Request
) -> ClinicOut:
    """Set the time zone of the own clinic; administrators only.

    Errors: `not_allowed`, `invalid_input` when there is no such time zone.
    """
    return clinics.change_clinic(session, subject, body, services_of(request).settings.time_zone)


def _address(request: Request) -> str:
    return request.client.host if request.client else "unknown"
