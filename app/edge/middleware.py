"""Plain ASGI middleware: security headers, body limits and errors that nobody expected.

Written against ASGI and not `BaseHTTPMiddleware`, which would buffer streams and break the cancelling of
requests.
"""

import logging
from collections.abc import Mapping
from typing import Final
from urllib.parse import urlsplit

from starlette.datastructures import MutableHeaders
from starlette.requests import ClientDisconnect, HTTPConnection
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from app.edge.error_answers import BodyTooLarge, answer, unexpected
from app.settings import Settings
from estimators.sentences import say

logger = logging.getLogger("telemotion.requests")

CLIENT_GONE: Final = 499


def content_security_policy(settings: Settings) -> str:
    """Return the policy for pages of the client: everything from ourselves, nothing framed, nothing
    evaluated.

    Parameters
    ----------
    settings : Settings
        `base_url` names the socket's origin for browsers that do not count it as 'self'.

    Notes
    -----
    Inline styles are allowed because the component library writes its theme variables into a style element;
    inline scripts are not. The viewer's pages carry their own policy, which this one does not replace.
    """
    scheme = "wss" if settings.is_https else "ws"
    socket = f"{scheme}://{urlsplit(settings.base_url).netloc}"
    return "; ".join(
        [
            "default-src 'self'",
            "script-src 'self'",
            "style-src 'self' 'unsafe-inline'",
            "img-src 'self' data: blob:",
            "font-src 'self' data:",
            f"connect-src 'self' {socket}",
            "worker-src 'self' blob:",
            "frame-src 'self'",
            "object-src 'none'",
            "base-uri 'none'",
            "form-action 'self'",
            "frame-ancestors 'none'",
        ]
    )


class SecurityHeaders:
    """Adds the headers to every response; a header that a route has set itself stays."""

    def __init__(self, app: ASGIApp, settings: Settings) -> None:
        self.app = app
        self._headers = {
            "Content-Security-Policy": content_security_policy(settings),
            "X-Content-Type-Options": "nosniff",
            "X-Frame-Options": "DENY",
            "Referrer-Policy": "no-referrer",
            "Cross-Origin-Opener-Policy": "same-origin",
            "Cross-Origin-Resource-Policy": "same-origin",
            "Permissions-Policy": "camera=(), microphone=(), geolocation=(), payment=()",
        }
        if settings.is_https:
            self._headers["Strict-Transport-Security"] = "max-age=63072000; includeSubDomains"

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on and add the headers to its answer."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        path: str = scope["path"]

        async def send_with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in self._headers.items():
                    headers.setdefault(name, value)
                if path.startswith("/api/"):
                    headers.setdefault("Cache-Control", "no-store")
            await send(message)

        await self.app(scope, receive, send_with_headers)


class BodyLimit:
    """Refuses bodies above a limit, by their declared length or while they arrive.

    Parameters
    ----------
    by_path : mapping of path to bytes
        Routes with a larger limit; a path with one `*` holds for any text there.
    """

    def __init__(self, app: ASGIApp, default_bytes: int, by_path: Mapping[str, int]) -> None:
        self.app = app
        self._default = default_bytes
        self._by_path = {path: most for path, most in by_path.items() if "*" not in path}
        self._by_ends: list[tuple[str, str, int]] = []
        for path, most in by_path.items():
            start, star, end = path.partition("*")
            if star:
                self._by_ends.append((start, end, most))

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, counting its body."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        path = scope["path"]
        limit = self._by_path.get(path, self._default)
        for start, end, most in self._by_ends:
            if path.startswith(start) and path.endswith(end):
                limit = most
        for name, value in scope["headers"]:
            if name == b"content-length" and value.isdigit() and int(value) > limit:
                error = BodyTooLarge(limit)
                refusal = answer(413, "too_large", error.detail, {"limit_bytes": limit})
                refusal.headers["Connection"] = "close"
                await refusal(scope, receive, send)
                return
        received = 0

        async def receive_counted() -> Message:
            nonlocal received
            message = await receive()
            if message["type"] == "http.request":
                received += len(message.get("body", b""))
                if received > limit:
                    raise BodyTooLarge(limit)
            return message

        await self.app(scope, receive_counted, send)


MOST_PART_BYTES: Final = 255
MOST_PATH_BYTES: Final = 4096
"""What file systems take as a name and as a path; no address of the service comes near."""


class WholeAddresses:
    """Refuses a NUL in an address, which no database identifier and no file name holds, and addresses that are longer
    than any file's.
    """

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, or answer 404 (path) or 422 (query)."""
        is_nowhere = scope["type"] in {"http", "websocket"} and _leads_nowhere(scope["path"])
        if scope["type"] == "http" and is_nowhere:
            await answer(404, "not_found", say("edge.no_such_address"), {})(scope, receive, send)
        elif scope["type"] == "http" and b"%00" in scope["query_string"]:
            message = say("edge.query_nul")
            await answer(422, "invalid_input", message, {"fields": []})(scope, receive, send)
        elif scope["type"] == "websocket" and (is_nowhere or b"%00" in scope["query_string"]):
            await send({"type": "websocket.close", "code": 4404, "reason": "not_found"})
        else:
            await self.app(scope, receive, send)


def _leads_nowhere(path: str) -> bool:
    name = path.encode(errors="surrogatepass")
    return b"\0" in name or len(name) > MOST_PATH_BYTES or max(map(len, name.split(b"/"))) > MOST_PART_BYTES


class UnexpectedErrors:
    """Answers what no handler expected, inside the security headers and the access log."""

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on; an error after the answer has begun ends the connection."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        has_begun = False

        async def send_noting(message: Message) -> None:
            nonlocal has_begun
            has_begun = has_begun or message["type"] == "http.response.start"
            await send(message)

        try:
            await self.app(scope, receive, send_noting)
        except ClientDisconnect:
            # Nobody hears an answer; the access log and the counters get the status that proxies use for it.
            logger.info("the client went away before its request was whole")
            if not has_begun:
                await answer(CLIENT_GONE, "client_gone", "", {})(scope, receive, send)
        except Exception as error:
            if has_begun:
                raise
            await unexpected(HTTPConnection(scope), error)(scope, receive, send)
