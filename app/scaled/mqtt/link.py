"""One gateway's link by MQTT, as `app.ingest.websocket.IngestConnection` uses a WebSocket."""

import asyncio
import contextlib
from collections import deque
from collections.abc import MutableMapping
from typing import Any, Final

import nats
from nats.aio.client import Client
from starlette.websockets import WebSocketState

from app.errors import TelemotionError, Unavailable
from app.network.mqtt import DOWN, LIVES_S, subject
from estimators.sentences import say

WAITING_BYTES: Final = 16 << 20
"""Of messages that are not read yet: nothing tells a sender by MQTT to wait, so more than that ends its connection."""


class MqttLink:
    """Implements `app.ingest.contract.GatewaySocket`.

    Parameters
    ----------
    client : Client
        Of NATS.
    name : str
        Of the connection.
    lives_s : float
        So long a gateway may say nothing.
    """

    def __init__(self, client: Client, name: str, lives_s: float = LIVES_S) -> None:
        self.name = name
        self._client, self._lives_s = client, lives_s
        self._waiting: deque[bytes] = deque()
        self._bytes = 0
        self._came = asyncio.Event()
        self._has_left = False
        self._error: TelemotionError | None = None
        self._state = WebSocketState.CONNECTED

    @property
    def application_state(self) -> WebSocketState:
        """`CONNECTED` until it was closed from here."""
        return self._state

    def take(self, data: bytes) -> None:
        """Take a message of the gateway; an empty one says only that it is there."""
        if self._bytes + len(data) > WAITING_BYTES:
            self.lose(Unavailable(say("scaled.mqtt_lost"), retry_after_s=1, reason="lost"))
        elif data and self._error is None:
            self._waiting.append(data)
            self._bytes += len(data)
        self._came.set()

    def left(self) -> None:
        """Note that the gateway has gone; what it brought before is read."""
        self._has_left = True
        self._came.set()

    def lose(self, error: TelemotionError) -> None:
        """Have the conversation ended: what waits is thrown away, and the gateway is asked to connect again."""
        self._error = error
        self._waiting.clear()
        self._bytes = 0
        self._came.set()

    async def receive(self) -> MutableMapping[str, Any]:
        """Wait for a message or the end; see `GatewaySocket`."""
        while True:
            if self._error is not None:
                raise self._error
            if self._waiting:
                data = self._waiting.popleft()
                self._bytes -= len(data)
                if data.startswith(b"{"):
                    return {"type": "websocket.receive", "text": data.decode(errors="replace")}
                return {"type": "websocket.receive", "bytes": data}
            if self._has_left:
                return {"type": "websocket.disconnect", "code": 1000}
            self._came.clear()
            try:
                async with asyncio.timeout(self._lives_s):
                    await self._came.wait()
            except TimeoutError:
                self._has_left = True

    async def send_text(self, data: str) -> None:
        """Send a message."""
        # While the server is away nothing goes; gateways lose their connections with it.
        with contextlib.suppress(nats.errors.Error):
            await self._client.publish(subject(self.name, DOWN), data.encode())

    async def close(self, code: int = 1000, reason: str | None = None) -> None:
        """Send and receive nothing more; the gateway knows it by what was said before."""
        self._state = WebSocketState.DISCONNECTED
        self.left()
