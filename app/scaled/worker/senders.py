"""Whose a packet of the stream is, for the pooled engine; and a gateway's connection, as its worker sees it."""

import asyncio
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Final

from app.errors import TelemotionError, Unavailable
from app.live.session.intake import Intake
from app.live.session.runner import LiveSession
from app.network.messages import ErrorMessage
from app.network.packet import decode_packet

AGAIN_S: Final = 0.1


class StreamSender:
    """Gives a session the packets that come for it out of the stream; implements `app.live.engine.journal.Sender`.

    Parameters
    ----------
    refused : callable(text)
        Takes the JSON of the error of a packet that could not be taken, for the gateway.
    """

    def __init__(self, session: LiveSession, refused: Callable[[str], None]) -> None:
        self.session = session
        self.held: deque[tuple[bytes, float, int]] = deque()
        """Packets that the session cannot take yet, because its store or its estimation is behind."""
        self._refused = refused

    @property
    def lane(self) -> Any:
        """The session's place among those whose packets are taken together."""
        return None if self.held else self.session.lane

    def take_rare(self, data: bytes, arrival_s: float, arrival_ns: int) -> None:
        """Take a packet the general way, behind those that wait; never raises."""
        if self.held:
            self.held.append((data, arrival_s, arrival_ns))
            return
        try:
            packet = decode_packet(data, self.session.declaration)
            self.session.receive(packet, arrival_s, arrival_ns)
        except TelemotionError as error:
            if isinstance(error, Unavailable) and error.details.get("reason") in {"store_behind", "behind"}:
                self.held.append((data, arrival_s, arrival_ns))
                asyncio.get_running_loop().call_later(AGAIN_S, self._again)
            else:
                self._refused(ErrorMessage.of(error, closing=False).model_dump_json())

    def _again(self) -> None:
        held, self.held = self.held, deque()
        while held and not self.held:
            self.take_rare(*held.popleft())
        self.held.extend(held)


@dataclass
class Connection:
    """A gateway's connection, held by an edge."""

    id: str
    edge: str
    session_id: str
    intake: Intake
    messages: list[str] = field(default_factory=list)
    """For the gateway, not sent yet."""
    reported: tuple[str, bool] | None = None
    reported_s: float = 0.0
    opened_s: float = field(default_factory=time.monotonic)
    is_stopping: bool = False
    """Its session is about to be closed: nothing more is to be taken from it."""
    stopped: asyncio.Event = field(default_factory=asyncio.Event)
    """Set when all has been read that was taken from it."""
    orders: asyncio.Task[None] | None = None

    def end(self) -> None:
        """Order nothing more."""
        if self.orders is not None:
            self.orders.cancel()
