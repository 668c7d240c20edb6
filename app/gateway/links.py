"""The link of a gateway to the service: a WebSocket to an edge, or MQTT to the NATS server's listener."""

from typing import Final, Protocol, Self
from urllib.parse import urlsplit

from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidHandshake

PONG_WITHIN_S: Final = 120.0
"""A service that slows a gateway down reads its pings late: that is no broken link."""


class Link(Protocol):
    """One connection. Everything raises `OSError` when it is broken."""

    window: int | None
    """Packets that may be under way without an acknowledgement; None where the link itself makes a sender wait."""

    async def send(self, message: bytes | str) -> None:
        """Send a message; the first is the hello."""

    async def receive(self) -> str:
        """Wait for the service's next message."""

    def abort(self) -> None:
        """Break it as a radio would, without a goodbye of any kind."""

    async def close(self) -> None:
        """End it in order."""


class WebSocketLink:
    """A link over a WebSocket; see `open_link`."""

    window: int | None = None

    def __init__(self, connection: ClientConnection) -> None:
        self._connection = connection

    @classmethod
    async def open(cls, url: str) -> Self:
        """Connect."""
        try:
            return cls(
                await connect(url, compression=None, max_queue=64, proxy=None, ping_timeout=PONG_WITHIN_S)
            )
        except InvalidHandshake as error:
            raise ConnectionError(str(error)) from error

    async def send(self, message: bytes | str) -> None:
        """Send a message."""
        try:
            await self._connection.send(message)
        except ConnectionClosed as error:
            raise ConnectionResetError(str(error)) from error

    async def receive(self) -> str:
        """Wait for the service's next message."""
        try:
            return await self._connection.recv(decode=True)
        except ConnectionClosed as error:
            raise ConnectionResetError(str(error)) from error

    def abort(self) -> None:
        """Break it as a radio would."""
        self._connection.transport.abort()

    async def close(self) -> None:
        """End it in order."""
        await self._connection.close()


async def open_link(url: str, ticket: str) -> Link:
    """Connect to a service.

    Parameters
    ----------
    url : str
        `ws://` or `wss://` address of `/ws/ingest`, or `mqtt://` or `mqtts://` address of a NATS server's listener.
    ticket : str
        Opens the connection by MQTT; over a WebSocket the hello shows it.

    Raises
    ------
    OSError
        Nobody answers there, or the connection is refused.
    InvalidInput
        What MQTT needs is not installed.
    """
    if urlsplit(url).scheme in {"mqtt", "mqtts"}:
        # Most gateways come by WebSocket, and what MQTT needs may not be there.
        from app.gateway.mqtt_link import MqttLink

        return await MqttLink.open(url, ticket)
    return await WebSocketLink.open(url)
