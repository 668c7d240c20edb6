"""uvicorn's WebSocket with a short way for binary messages that come or go by the thousand.

Handshake, text, pings and the end are uvicorn's. Whoever serves a socket may attach to it: from then on whole binary
messages are handed over where they lie, before any event or task is made of them, and finished frames are written as
they are. A message that came before, or in pieces, takes the ordinary way.
"""

import asyncio
from typing import Any, Final, Protocol

from starlette.websockets import WebSocket
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

EXTENSION: Final = "telemotion.lean"
LONGEST_FRAME: Final = 1 << 20
"""Longer ones are refused by uvicorn, see `ws_max_size`."""
_CONTINUED, _TEXT, _BINARY = 0, 1, 2
WHOLE_TEXT: Final = 0x80 | _TEXT
WHOLE_BINARY: Final = 0x80 | _BINARY
MEDIUM: Final = 126
"""A message of so many bytes or more has its length in two bytes behind the first two; see `frame_head`."""
LONG: Final = 127
LONGEST_MEDIUM: Final = 0xFFFF


def frame_head(first: int, size: int) -> bytes:
    """Return what stands before a message of `size` bytes that a server sends whole (RFC 6455, 5.2).

    Parameters
    ----------
    first : int
        `WHOLE_TEXT` or `WHOLE_BINARY`.
    """
    if size < MEDIUM:
        return bytes((first, size))
    if size <= LONGEST_MEDIUM:
        return bytes((first, MEDIUM)) + size.to_bytes(2, "big")
    return bytes((first, LONG)) + size.to_bytes(8, "big")


class BinaryReader(Protocol):
    """Takes binary messages where they lie."""

    def received(self, buffer: bytes, start: int, length: int, key: int) -> None:
        """Take `buffer[start:start + length]`, masked with the four bytes of `key` (little endian)."""


class LeanSocket(WebSocketsSansIOProtocol):
    """One connection; ASGI applications find it in their scope, see `lean_socket`."""

    def __init__(self, *args: Any, **named: Any) -> None:
        super().__init__(*args, **named)
        self._reader: BinaryReader | None = None
        self._held = bytearray()
        self._needed = 0
        self._is_in_pieces = False
        self._until_s = 0.0
        self._is_slowed = False
        self._timer: asyncio.TimerHandle | None = None

    def handle_connect(self, event: Any) -> None:
        """Offer itself to the application."""
        super().handle_connect(event)
        if hasattr(self, "scope"):
            self.scope["extensions"][EXTENSION] = {"socket": self}

    def attach(self, reader: BinaryReader) -> None:
        """Hand whole binary messages to `reader` from now on."""
        self._reader = reader

    def detach(self) -> None:
        """Hand nothing over any more."""
        self._reader = None

    def data_received(self, data: bytes) -> None:
        """Take bytes from the connection; after the handshake they are given on frame by frame."""
        if not self.handshake_initiated:
            super().data_received(data)
            return
        if self.close_sent:
            # What still comes is for nobody: it must not gather here until the sender has read the end.
            self._is_slowed = False
        if not self._held and not self._is_slowed:
            self._take(data)
            return
        # A frame that drips in is put together once it is whole, not with every piece.
        self._held += data
        if not self._is_slowed and len(self._held) >= self._needed:
            self._take_held()

    def _take_held(self) -> None:
        buffer = bytes(self._held)
        self._held.clear()
        self._take(buffer)

    def _take(self, buffer: bytes) -> None:
        """Give whole frames on, and hold the rest: a piece of one, or all that follows where the sender is slowed."""
        at, size, self._needed = 0, len(buffer), 0
        while size - at >= 2 and not self._is_slowed:
            length, head = buffer[at + 1] & 0x7F, 2
            if length == 126:
                head = 4
                if size - at < head:
                    self._needed = head
                    break
                length = buffer[at + 2] << 8 | buffer[at + 3]
            elif length == 127:
                head = 10
                if size - at < head:
                    self._needed = head
                    break
                length = int.from_bytes(buffer[at + 2 : at + 10], "big")
            is_masked = buffer[at + 1] & 0x80
            start = at + head + (4 if is_masked else 0)
            end = start + length
            if length > LONGEST_FRAME:
                super().data_received(buffer[at:])
                return
            if end > size:
                self._needed = end - at
                break
            first = buffer[at]
            is_short = first == WHOLE_BINARY and is_masked and not self._is_in_pieces
            if is_short and self._reader is not None and self.is_open:
                self._reader.received(
                    buffer, start, length, int.from_bytes(buffer[start - 4 : start], "little")
                )
            else:
                if first & 0x0F in (_CONTINUED, _TEXT, _BINARY):
                    self._is_in_pieces = not first & 0x80
                super().data_received(buffer[at:end])
            at = end
        self._held += buffer[at:]

    def slow_down(self, seconds: float) -> None:
        """Take nothing for a while: the sender is too fast, or what it sends cannot be taken yet.

        What was read already waits, too. Given on at once it would be seconds of signal, and then nothing would come
        until their time is over, which looks like a lost link. If the connection ends meanwhile it is lost; nobody has
        acknowledged it.
        """
        if self.transport.is_closing():
            return
        self._is_slowed = True
        self._until_s = max(self._until_s, self.loop.time() + seconds)
        self.read_paused = True
        self.transport.pause_reading()
        if self._timer is None:
            self._timer = self.loop.call_at(self._until_s, self._go_on)

    def _go_on(self) -> None:
        self._timer = None
        if self.transport.is_closing():
            return
        if self.loop.time() < self._until_s - 1e-3:
            self._timer = self.loop.call_at(self._until_s, self._go_on)
            return
        self._is_slowed = False
        try:
            self._take_held()
        except BaseException:
            # As uvloop does where a reading ends like this: reading would never go on.
            self.transport.abort()
            raise
        if not self._is_slowed and self.read_paused and self.queue.empty():
            self.read_paused = False
            self.transport.resume_reading()

    async def receive(self) -> Any:
        """Give the next event to the application; reading goes on when it is time."""
        message = await super().receive()
        if self._is_slowed and not self.transport.is_closing():
            self.read_paused = True
            self.transport.pause_reading()
        return message

    def keepalive_timeout(self) -> None:
        """End the connection; not while it is slowed, for the sender's pong stands behind what was not taken yet."""
        if self._is_slowed and self.ping_timeout is not None:
            self.pong_timer = self.loop.call_later(self.ping_timeout, self.keepalive_timeout)
            return
        super().keepalive_timeout()

    @property
    def is_open(self) -> bool:
        """Whether something can be sent."""
        return self.handshake_complete and not (
            self.close_sent or self.disconnected or self.transport.is_closing()
        )

    def send_frame(self, frame: bytes) -> bool:
        """Send a finished frame; False when it was dropped because the other side does not keep up."""
        if not self.is_open:
            return True
        # Frames must not fill what messages wait for: those are never dropped.
        if not self.writable.is_set():
            return False
        self.transport.write(frame)
        return True

    def send_text_now(self, text: str) -> bool:
        """Send a text message without waiting; False when the other side does not keep up."""
        if not self.is_open:
            return True
        if not self.writable.is_set():
            return False
        message = text.encode()
        self.transport.write(frame_head(WHOLE_TEXT, len(message)) + message)
        return True


def lean_socket(websocket: WebSocket) -> LeanSocket | None:
    """Return the connection under an accepted WebSocket; None where another server carries it."""
    extension = websocket.scope.get("extensions", {}).get(EXTENSION)
    return extension["socket"] if extension else None
