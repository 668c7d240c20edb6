"""A new password ends what the old one opened."""

from sqlalchemy.orm import Session

from app.accounts.credentials.browsers import forget_browsers
from app.accounts.credentials.sign_in import end_all_sign_ins
from app.accounts.models import Account


def replace_password(
    session: Session,
    account: Account,
    password_hash: str,
    *,
    must_change: bool,
    sign_in: str | None = None,
    browser: str | None = None,
) -> int:
    """Give an account another password; it is signed out everywhere and its known browsers are forgotten.

    Parameters
    ----------
    session : Session
        Writing.
    must_change : bool
        Somebody else knows the password: nothing else can be done before the owner has chosen another.
    sign_in : str, optional
        Identifier of the one browser session that stays.
    browser : str, optional
        Value of the cookie of the one known browser that stays.

    Returns
    -------
    int
        Browser sessions that ended.
    """
    account.password_hash = password_hash
    account.must_change_password = must_change
    forget_browsers(session, account.id, but=browser)
    return end_all_sign_ins(session, account.id, but=sign_in)
