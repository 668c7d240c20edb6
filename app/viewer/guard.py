"""The lock on viser's door: its loopback port answers only to who knows a secret of this scene.

viser knows no users, and any program and any web page on the machine reaches a loopback port. Whoever connects must
send the secret as a header, with the first request already, so neither a file nor a WebSocket is given without it; a
browser cannot add such a header to a WebSocket at all. viser has no setting for this, so its server is begun with a
check in front of viser's own; when viser begins it in another way one day, nothing is served.
"""

import hmac
import secrets
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http import HTTPStatus
from typing import Any, Final

import websockets.asyncio.server as websockets_server
from websockets.asyncio.server import ServerConnection
from websockets.http11 import Request, Response

from app.errors import Unavailable
from estimators.sentences import say

HEADER: Final = "X-Telemotion-Scene"
_one_at_a_time = threading.Lock()


class SceneSecret:
    """A random secret, and the check for it."""

    def __init__(self) -> None:
        self._secret = secrets.token_urlsafe(32)

    @property
    def headers(self) -> dict[str, str]:
        """What to send to be let in."""
        return {HEADER: self._secret}

    def refusal(self, connection: ServerConnection, request: Request) -> Response | None:
        """Return the answer to a request without the secret, None to one with it."""
        given = request.headers.get_all(HEADER)
        if len(given) == 1 and hmac.compare_digest(given[0].encode(), self._secret.encode()):
            return None
        return connection.respond(HTTPStatus.FORBIDDEN, "This scene is shown through the service only.\n")


@contextmanager
def guarded(secret: SceneSecret) -> Iterator[None]:
    """Put the check in front of the one websocket server that is begun meanwhile.

    Raises
    ------
    Unavailable
        No server was begun that could be guarded.
    """
    begun = 0
    begin = websockets_server.serve

    def begin_guarded(*arguments: Any, process_request: Any = None, **keywords: Any) -> Any:
        nonlocal begun
        begun += 1

        def check(connection: ServerConnection, request: Request) -> Any:
            refusal = secret.refusal(connection, request)
            if refusal is None and process_request is not None:
                return process_request(connection, request)
            return refusal

        return begin(*arguments, process_request=check, **keywords)

    with _one_at_a_time:
        websockets_server.serve = begin_guarded  # type: ignore[assignment, misc]
        try:
            yield
        finally:
            websockets_server.serve = begin  # type: ignore[misc]
    if not begun:
        raise Unavailable(say("viewer.no_guard"))
