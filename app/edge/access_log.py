"""One line for each request and each end of a socket, and the identifier that line, answer and errors share."""

import logging
import secrets
import time
from collections import Counter

from starlette.datastructures import MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from app.edge.registry import Histogram
from app.logs import request_id

logger = logging.getLogger("telemotion.access")

SECONDS_BOUNDS = (0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 10.0)


class Served:
    """Counts since the process began: answers by status, and how long they took."""

    def __init__(self) -> None:
        self.by_status: Counter[str] = Counter()
        self.seconds = Histogram(SECONDS_BOUNDS)


served = Served()

REQUEST_ID_HEADER = "X-Request-ID"


class AccessLog:
    """Logs method, route template, status and time. No addresses of patients, no query, no identifiers.

    Notes
    -----
    The identifier is made here and never taken from a client, who could put anything into the log with it.
    """

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request or a socket on and note how it went."""
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        is_socket = scope["type"] == "websocket"
        identifier = secrets.token_hex(8)
        token = request_id.set(identifier)
        started = time.perf_counter()
        status = 0

        async def send_noting(message: Message) -> None:
            nonlocal status
            kind = message["type"]
            if kind in ("http.response.start", "websocket.http.response.start"):
                status = message["status"]
            elif kind == "websocket.accept":
                status = 101
                logger.info("WEBSOCKET %s opened", template(scope))
            elif kind == "websocket.close" and not status:
                status = 403
            if kind in ("http.response.start", "websocket.http.response.start", "websocket.accept"):
                MutableHeaders(scope=message)[REQUEST_ID_HEADER] = identifier
            await send(message)

        try:
            await self.app(scope, receive, send_noting)
        except BaseException:
            status = status or 500
            raise
        finally:
            taken_s = time.perf_counter() - started
            if is_socket and status == 101:
                logger.info("WEBSOCKET %s closed after %.1f s", template(scope), taken_s)
            else:
                method = "WEBSOCKET" if is_socket else scope["method"]
                served.by_status[str(status)] += 1
                served.seconds.observe(taken_s)
                logger.info("%s %s %d %.1f ms", method, template(scope), status, 1e3 * taken_s)
            request_id.reset(token)


def template(scope: Scope) -> str:
    """Return the route's template, e.g. `/api/patients/{patient_id}`; never the path itself, which holds
    identifiers.

    Parameters
    ----------
    scope : Scope
        Of a request that was routed.
    """
    path = getattr(scope.get("route"), "path", None)
    return path if isinstance(path, str) else "-"
