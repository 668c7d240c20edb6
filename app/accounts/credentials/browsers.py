"""Browsers that have signed in before: known by a cookie of their own, so that strangers cannot lock an owner out.

The cookie lives for months, says nothing and opens nothing; only its hash is stored, with each account that signed in
there. Whoever has it may fail to sign in as often as a stranger may, but apart from the strangers. It is forgotten
with all others when the password changes: then somebody else may have had one.
"""

from datetime import timedelta

from sqlalchemy import delete, select, update
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
    """Remember that an account signed in here; return the cookie's new value.

    Parameters
    ----------
    session : Session
        Writing.
    token : str or None
        The cookie that the browser has already. It may have been planted there, or read by somebody: a new one takes
        its place for all accounts that signed in here, and the old one is worth nothing.
    """
    fresh, now = new_token(), utc_now()
    mine = KnownBrowser.account_id == account_id
    if token:
        old = KnownBrowser.token_hash == hash_token(token)
        session.execute(delete(KnownBrowser).where(mine, old))
        session.execute(update(KnownBrowser).where(old).values(token_hash=hash_token(fresh)))
    session.add(KnownBrowser(account_id=account_id, token_hash=hash_token(fresh), seen_at=now))
    session.flush()
    newest = (
        select(KnownBrowser.id).where(mine).order_by(KnownBrowser.seen_at.desc()).limit(MOST_OF_AN_ACCOUNT)
    )
    session.execute(delete(KnownBrowser).where(mine, KnownBrowser.id.not_in(newest)))
    return fresh


def forget_browsers(session: Session, account_id: str, but: str | None = None) -> None:
    """Forget the browsers of an account.

    Parameters
    ----------
    session : Session
        Writing.
    but : str, optional
        Value of the cookie of the one that stays.
    """
    excepted = hash_token(but) if but else ""
    session.execute(
        delete(KnownBrowser).where(KnownBrowser.account_id == account_id, KnownBrowser.token_hash != excepted)
    )
