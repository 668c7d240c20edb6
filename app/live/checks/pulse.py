"""A heartbeat in each second without a message, so that the listener knows that the connection is open.

A network that goes away closes no connection, and a browser hears nothing of the pings below its sockets: silence must
mean something by itself.
"""

import asyncio
import time
from typing import Final

from fastapi import WebSocket

from app.network.lean_sockets import lean_socket

PULSE_S: Final = 1.0
_WORD: Final = '{"type":"pulse"}'
"""`app.live.messages.PulseMessage`."""


class Pulse:
    """The pulse of one accepted socket."""

    def __init__(self, websocket: WebSocket, every_s: float = PULSE_S) -> None:
        self._websocket = websocket
        self._socket = lean_socket(websocket)
        self._every_s = every_s
        self._said_s = 0.0

    def said(self) -> None:
        """Take note that something was said now."""
        self._said_s = time.monotonic()

    async def run(self) -> None:
        """Send a pulse in each second in which nothing else was said, until cancelled."""
        while True:
            await asyncio.sleep(self._every_s)
            if time.monotonic() - self._said_s < self._every_s:
                continue
            if self._socket is None:
                await self._websocket.send_text(_WORD)
            else:
                # A client that does not keep up needs no pulse to know of the service.
                self._socket.send_text_now(_WORD)
