"""The cookies of a browser: over TLS with a name that only this very host can set, and for all of its paths alone."""

from starlette.requests import HTTPConnection
from starlette.responses import Response

from app.settings import Settings


def cookie_name(settings: Settings, name: str) -> str:
    """Return how a cookie is called here.

    Parameters
    ----------
    settings : Settings
        Over https a browser takes `__Host-...` from no neighbour under the same domain and over no plain connection.
    name : str
        Without a prefix.
    """
    return f"__Host-{name}" if settings.is_https else name


def shown_cookie(settings: Settings, connection: HTTPConnection, name: str) -> str | None:
    """Return the value of a cookie that a browser shows; empty is none.

    Parameters
    ----------
    name : str
        Without a prefix.
    """
    return connection.cookies.get(cookie_name(settings, name)) or None


def set_cookie(response: Response, settings: Settings, name: str, value: str, life_s: int) -> None:
    """Give a browser a cookie that scripts cannot read; a life of 0 deletes it.

    Parameters
    ----------
    name : str
        Without a prefix.
    """
    response.set_cookie(
        cookie_name(settings, name),
        value,
        max_age=life_s,
        expires=0 if life_s == 0 else None,
        path="/",
        secure=settings.is_https,
        httponly=True,
        samesite="lax",
    )
