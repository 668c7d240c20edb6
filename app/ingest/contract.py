"""The contract of a gateway's conversation with the link under it and the live side behind it."""

import asyncio
from collections.abc import MutableMapping
from typing import Any, Protocol

from starlette.websockets import WebSocketState

from app.errors import TelemotionError
from app.network.declaration import Declaration
from app.network.messages import AcknowledgeMessage, ActuateMessage, ActuationPlanMessage, HelloMessage
from app.network.packet import Packet


class GatewaySocket(Protocol):
    """The link under a conversation, as far as it is used; a WebSocket that was accepted is one."""

    @property
    def application_state(self) -> WebSocketState:
        """`CONNECTED` until it was closed from here."""

    async def receive(self) -> MutableMapping[str, Any]:
        """Wait for a message (`websocket.receive` with `bytes` or `text`) or the end (`websocket.disconnect`).

        Raises
        ------
        TelemotionError
            The conversation cannot go on, for this reason.
        """

    async def send_text(self, data: str) -> None:
        """Send a message."""

    async def close(self, code: int = 1000, reason: str | None = None) -> None:
        """End the link."""


class PacketSender(Protocol):
    """A connection whose packets are taken together with others'."""

    @property
    def lane(self) -> Any:
        """The session's place among those whose packets are taken together."""

    def take_rare(self, data: bytes, arrival_s: float, arrival_ns: int, size: int | None = None) -> None:
        """Take a packet by itself."""


class PooledPackets(Protocol):
    """Takes packets of many sessions together; implemented by the live side."""

    def offer(
        self, sender: PacketSender, data: memoryview, key: int, arrival_s: float, arrival_ns: int
    ) -> None:
        """Take a packet as it came, masked; it is given to its session soon, or to `PacketSender.take_rare`."""


class Intake(Protocol):
    """One connection's way into its session."""

    pooled: PooledPackets
    ended: asyncio.Event
    """Set when the connection must end; `end_error` says why."""
    end_error: TelemotionError

    @property
    def lane(self) -> Any:
        """The session's place among those whose packets are taken together."""

    @property
    def session_id(self) -> str:
        """The session that the ticket named."""

    @property
    def declaration(self) -> Declaration:
        """What packets must fit."""

    @property
    def is_open(self) -> bool:
        """Whether the session takes packets."""

    @property
    def taken(self) -> int:
        """How many of its packets were taken together with others'."""

    @property
    def is_finished(self) -> bool:
        """Whether the session is closed and all of it is stored."""

    def receive(self, packet: Packet, arrival_s: float, arrival_ns: int) -> bool:
        """Take one packet; False when it was here before. Raises typed errors."""

    def acknowledge(self) -> AcknowledgeMessage:
        """Return what the gateway may forget and what it should send again."""

    def goodbye(self, last_sequence: int) -> None:
        """Note that nothing above `last_sequence` will come."""

    async def check_right(self) -> None:
        """Raise when the gateway has lost its right since it connected."""

    async def next_order(self) -> ActuateMessage | ActuationPlanMessage:
        """Wait for what the magnetic source is to do next; for ever where there is none."""

    def end(self, error: TelemotionError) -> None:
        """Have the connection ended for a reason."""

    def detach(self) -> None:
        """Note that the connection has ended."""


class PacketSink(Protocol):
    """Where packets go; implemented by the live side, wired by `app.main` as `Services.live`."""

    @property
    def check_every_s(self) -> float:
        """How often the right of a connection is checked again."""

    async def open(self, hello: HelloMessage, declaration: Declaration) -> Intake:
        """Open the session of the hello's ticket. Raises typed errors."""
