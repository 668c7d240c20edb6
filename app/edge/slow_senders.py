"""Time limits for who sends a request slowly or never ends it: each such connection costs memory and a place.

uvicorn itself has none: its keep-alive limit counts only between requests and every byte renews it. So the headers are
timed in its protocol, before a request exists, and the body where the request reads it. Only waiting for the sender is
counted: an upload that the service takes slowly, because its disk is busy, is nobody's fault.
"""

import asyncio
import time
from collections.abc import Callable
from typing import Any, ClassVar, Final

from starlette.types import ASGIApp, Message, Receive, Scope, Send
from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol

from app.edge.error_answers import BodyTooSlow

MOST_HEAD_BYTES: Final = 64 << 10
"""Of a request's first line and headers together; browsers send a few kilobytes."""


class TimedHeaders(HttpToolsProtocol):
    """uvicorn's HTTP protocol; a connection ends when the headers of a request are late or too long.

    What still comes of a body after its answer is read and thrown away, as long as it comes faster than a floor: who is
    refused in the middle of an upload gets to hear why.

    Attributes
    ----------
    header_limit_s : float
        From the connection, or the first byte of a further request, to the end of the headers. Also the longest
        wait for the rest of an answered body.
    floor_bytes_per_s : float
        Of the rest of an answered body.
    """

    header_limit_s: ClassVar[float] = 10.0
    floor_bytes_per_s: ClassVar[float] = 2048.0

    def __init__(self, *args: Any, **named: Any) -> None:
        super().__init__(*args, **named)
        self._timer: asyncio.TimerHandle | None = None
        self._head_bytes = 0
        self._in_body = False
        self._has_advanced = False
        """Whether headers or a body ended in the bytes that are being read."""

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Begin to wait for the first request."""
        super().connection_made(transport)
        self._wait(self.header_limit_s)

    def data_received(self, data: bytes) -> None:
        """Begin to wait for headers when nothing is being answered; every byte after that renews nothing."""
        was_in_body = self._in_body
        if self._is_idle and was_in_body:
            self._wait_for_rest(len(data))
        elif self._is_idle and self._timer is None:
            self._wait(self.header_limit_s)
        self._has_advanced = False
        super().data_received(data)
        if was_in_body and not self._in_body and self._is_idle:
            # The rest of an answered body is over, and uvicorn no longer counts this connection as a silent one.
            self._stop()
            self._wait(self.header_limit_s)
        if not was_in_body and not self._has_advanced:
            # Also those of a request that waits for the answer to the one before it.
            self._head_bytes += len(data)
            if self._head_bytes > MOST_HEAD_BYTES:
                self._end(b"431 Request Header Fields Too Large")

    def on_headers_complete(self) -> None:
        """End the wait."""
        self._stop()
        self._in_body, self._has_advanced, self._head_bytes = True, True, 0
        super().on_headers_complete()

    def on_message_complete(self) -> None:
        """Note that what follows is another request."""
        self._in_body, self._has_advanced = False, True
        super().on_message_complete()

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget the connection."""
        self._stop()
        super().connection_lost(exc)

    @property
    def _is_idle(self) -> bool:
        return self.cycle is None or self.cycle.response_complete

    def _wait(self, limit_s: float) -> None:
        self._head_bytes = 0
        self._timer = self.loop.call_later(limit_s, self._end, b"408 Request Timeout")

    def _wait_for_rest(self, size: int) -> None:
        left_s = self.header_limit_s if self._timer is None else self._timer.when() - self.loop.time()
        self._stop()
        self._wait(min(self.header_limit_s, left_s + size / self.floor_bytes_per_s))

    def _stop(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _end(self, status: bytes) -> None:
        self._stop()
        if not self.transport.is_closing():
            # Into an answer that is being sent nothing may be written, nor behind that of a body.
            if self._head_bytes and self._is_idle:
                self.transport.write(
                    b"HTTP/1.1 " + status + b"\r\ncontent-length: 0\r\nconnection: close\r\n\r\n"
                )
            self.transport.close()


def timed_headers(
    header_limit_s: float, floor_bytes_per_s: float = TimedHeaders.floor_bytes_per_s
) -> type[TimedHeaders]:
    """Return uvicorn's protocol with a time limit for headers.

    Parameters
    ----------
    floor_bytes_per_s : float
        Slowest rest of a body that was answered before its end.
    """
    limits = {"header_limit_s": header_limit_s, "floor_bytes_per_s": floor_bytes_per_s}
    return type("TimedHeaders", (TimedHeaders,), limits)


class TimedBodies:
    """Refuses a body that stops, or comes for long more slowly than a floor, with 408.

    Parameters
    ----------
    floor_bytes_per_s : float
        A sender at least so fast is waited for as long as its body lasts.
    patience_s : float
        A sender that is slower, or silent, is waited for so long; what it sent faster before does not add to it.
    clock : callable
        Monotonic seconds.
    """

    def __init__(
        self,
        app: ASGIApp,
        floor_bytes_per_s: float,
        patience_s: float,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.app = app
        self._floor = floor_bytes_per_s
        self._patience_s = patience_s
        self._clock = clock

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, timing its body."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        left_s = self._patience_s
        # After the body, and once the answer has begun, `receive` only waits for the client to go.
        is_over = False

        async def receive_timed() -> Message:
            nonlocal left_s, is_over
            if is_over:
                return await receive()
            asked_s = self._clock()
            try:
                async with asyncio.timeout(left_s):
                    message = await receive()
            except TimeoutError:
                is_over = True
                raise BodyTooSlow(self._patience_s) from None
            is_over = is_over or not message.get("more_body", False)
            left_s -= self._clock() - asked_s
            if left_s <= 0.0 and not is_over:
                is_over = True
                raise BodyTooSlow(self._patience_s)
            left_s = min(self._patience_s, left_s + len(message.get("body", b"")) / self._floor)
            return message

        async def send_noting(message: Message) -> None:
            nonlocal is_over
            is_over = True
            await send(message)

        await self.app(scope, receive_timed, send_noting)
