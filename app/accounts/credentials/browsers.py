"""Browsers that have signed in before: known by a cookie of their own, so that strangers cannot lock an owner out.

The cookie lives for months, says nothing and opens nothing; only its hash is stored, with each account that signed in
there. Whoever has it may fail to sign in as often as a stranger may, but apart from the strangers. It is forgotten
with all others when the password changes: then somebody else may have had one.
"""

from datetime import timedelta

from sqlalchemy import delete, select
from sqlalchemy.orm import Session

from app.accounts.credentials.tokens import hash_token, new_token
from app.accounts.models import Account, KnownBrowser
from app.database.base import utc_now

COOKIE = "telemotion_browser"
LIFE = timedelta(days=365)
MOST_OF_AN_ACCOUNT = 20


def known_browser(session: Session, email: str, token: str | None) -> str | None:
    """Return the key of a browser that has signed in to an account before; None for a stranger.

    Parameters
    ----------
    session : Session
    email : str
        Normalised.
    token : str or None
        The cookie's value.
    """
    if not token:
        return None
    return session.scalar(
        select(KnownBrowser.token_hash)
        .join(Account, Account.id == KnownBrowser.account_id)
        .where(
            Account.email == email,
            KnownBrowser.token_hash == hash_token(token),
            KnownBrowser.seen_at > utc_now() - LIFE,
        )
    )


def remember_browser(session: Session, account_id: str, token: str | None) -> str:
    """Remember that an account signed in here; return the cookie's value.

    Parameters
    ----------
    session : Session
        Writing.
    account_id : str
    token : str or None
        The cookie that the browser has already: one serves all accounts that sign in there.
    """
    token = token if token and len(token) == len(new_token()) else new_token()
    mine = KnownBrowser.account_id == account_id
    row = session.scalar(select(KnownBrowser).where(mine, KnownBrowser.token_hash == hash_token(token)))
    if row is None:
        row = KnownBrowser(account_id=account_id, token_hash=hash_token(token))
        session.add(row)
    row.seen_at = utc_now()
    session.flush()
    newest = (
        select(KnownBrowser.id).where(mine).order_by(KnownBrowser.seen_at.desc()).limit(MOST_OF_AN_ACCOUNT)
    )
    session.execute(delete(KnownBrowser).where(mine, KnownBrowser.id.not_in(newest)))
    return token


def forget_browsers(session: Session, account_id: str, but: str | None = None) -> None:
    """Forget the browsers of an account.

    Parameters
    ----------
    session : Session
        Writing.
    account_id : str
    but : str, optional
        Value of the cookie of the one that stays.
    """
    excepted = hash_token(but) if but else ""
    session.execute(
        delete(KnownBrowser).where(KnownBrowser.account_id == account_id, KnownBrowser.token_hash != excepted)
    )


__all__ = ["COOKIE", "LIFE", "forget_browsers", "known_browser", "remember_browser"]
