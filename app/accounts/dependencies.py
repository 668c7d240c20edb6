"""Who asks: FastAPI dependencies for HTTP and the function for sockets.

A browser shows its cookie. Browsers attach cookies to requests that other sites provoke, so a change by
cookie also needs the CSRF token in `X-CSRF-Token` and an `Origin` of our own; a socket by cookie needs the
`Origin` (browsers let any site open sockets). Gateways show `Authorization: Bearer <device token>`, which no
browser attaches by itself, and need neither.
"""

import hmac
from typing import Annotated
from urllib.parse import urlsplit

from anyio import to_thread
from fastapi import Depends
from starlette.requests import HTTPConnection
from starlette.websockets import WebSocket

from app.accounts.credentials.cookies import shown_cookie
from app.accounts.credentials.sign_in import (
    COOKIE,
    FoundSignIn,
    find_sign_in,
    first_to_do,
    seen_again_after,
    touch,
)
from app.accounts.device_tokens import subject_of_device_token
from app.accounts.subject import Subject
from app.database.unit_of_work import read_only, unit_of_work
from app.errors import NotAllowed, SignInRequired
from app.services import services_of
from app.settings import Settings
from estimators.sentences import say

IDLE_HEADER = "X-Idle-Seconds"
CSRF_HEADER = "X-CSRF-Token"
SAFE_METHODS = frozenset({"GET", "HEAD", "OPTIONS"})


def is_own_origin(settings: Settings, connection: HTTPConnection) -> bool:
    """Return whether the request comes from a page of this service.

    Parameters
    ----------
    settings : Settings
        `base_url` is the only origin; a service on this machine's own address also accepts the address it was called
        by, so `localhost` and `127.0.0.1` both work (`app.edge.hosts` lets no other name in).
    """
    origin = connection.headers.get("origin")
    if not origin:
        return False
    if origin == settings.base_url:
        return True
    if settings.is_https or not settings.is_loopback:
        return False
    parts = urlsplit(origin)
    return parts.scheme == "http" and parts.netloc == connection.headers.get("host")


def require_own_origin(connection: HTTPConnection) -> None:
    """Refuse a request that another site provoked.

    Raises
    ------
    NotAllowed
        The `Origin` is absent or not ours.
    """
    if not is_own_origin(services_of(connection).settings, connection):
        raise NotAllowed(say("sign_in.origin"))


def current_sign_in(connection: HTTPConnection) -> FoundSignIn:
    """Return the valid browser session of a request, with CSRF and Origin checked for changes.

    Raises
    ------
    SignInRequired
        No cookie, or its session has ended.
    NotAllowed
        A change without the CSRF token or from another origin, or a socket from another origin.
    """
    services = services_of(connection)
    cookie = shown_cookie(services.settings, connection, COOKIE)
    if not cookie:
        raise SignInRequired(say("sign_in.required"))
    with read_only(services.engine) as session:
        found = find_sign_in(session, services.settings, cookie)
    if connection.scope["type"] == "websocket":
        require_own_origin(connection)
    elif connection.scope["method"] not in SAFE_METHODS:
        require_own_origin(connection)
        given = connection.headers.get(CSRF_HEADER, "")
        if not hmac.compare_digest(given.encode(), found.csrf_token.encode()):
            raise NotAllowed(
                say("sign_in.csrf", header=CSRF_HEADER),
                header=CSRF_HEADER,
            )
    if found.needs_touch and _is_in_use(connection, services.settings):
        with unit_of_work(services.engine) as writer:
            touch(writer, found.id)
    return found


def _is_in_use(connection: HTTPConnection, settings: Settings) -> bool:
    """Return whether a person is at the browser: a socket that stays open, or a page that asks by itself, is no sign.

    The client says with each request how long nobody has touched keyboard, mouse or screen; a program says nothing.
    """
    if connection.scope["type"] == "websocket":
        return False
    idle = connection.headers.get(IDLE_HEADER, "0")
    return idle.isdigit() and len(idle) < 10 and int(idle) < seen_again_after(settings).total_seconds()


def shown_token(connection: HTTPConnection) -> tuple[str, str]:
    """Return scheme and token of the `Authorization` header; without a token the cookie decides who asks."""
    scheme, _, token = connection.headers.get("authorization", "").partition(" ")
    return scheme, token.strip()


def current_subject(connection: HTTPConnection) -> Subject:
    """Return who asks, by device token or cookie; blocks on the database, so call it in a thread.

    Raises
    ------
    SignInRequired
        Nobody valid.
    NotAllowed
        See `current_sign_in`.
    """
    scheme, token = shown_token(connection)
    if not token:
        found = current_sign_in(connection)
        if (refusal := first_to_do(found)) is not None:
            raise refusal
        return found.subject
    if scheme.lower() != "bearer":
        raise SignInRequired(say("sign_in.bearer_only"))
    services = services_of(connection)
    with read_only(services.engine) as session:
        return subject_of_device_token(session, services.settings, token)


def current_account(subject: Annotated[Subject, Depends(current_subject)]) -> Subject:
    """Return the subject when it is a person or integrator that signed in, not a device.

    Raises
    ------
    NotAllowed
        A device.
    """
    if subject.kind != "account":
        raise NotAllowed(say("sign_in.no_device_token"))
    return subject


def current_device(subject: Annotated[Subject, Depends(current_subject)]) -> Subject:
    """Return the subject when it is a device with a token.

    Raises
    ------
    NotAllowed
        A person that signed in.
    """
    if subject.kind != "device":
        raise NotAllowed(say("sign_in.device_token_only"))
    return subject


async def websocket_subject(websocket: WebSocket) -> Subject:
    """Return who opens a socket by cookie or device token, without blocking the loop.

    Parameters
    ----------
    websocket : WebSocket
        Accepted or not; the error handler closes it in either case.

    Raises
    ------
    SignInRequired, NotAllowed
        As `current_subject`.
    """
    return await to_thread.run_sync(current_subject, websocket)


CurrentSubject = Annotated[Subject, Depends(current_subject)]
"""Any valid subject, devices included; the access check decides what it may do."""

CurrentDevice = Annotated[Subject, Depends(current_device)]
"""A gateway or telephone with a device token."""

CurrentAccount = Annotated[Subject, Depends(current_account)]
"""A person or integrator that signed in."""

CurrentSignIn = Annotated[FoundSignIn, Depends(current_sign_in)]
"""A browser session with its CSRF token."""
