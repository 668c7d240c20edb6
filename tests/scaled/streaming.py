"""Sessions that stream through a service on many machines: gateways and views that go to whichever edge answers."""

import asyncio
import contextlib
import itertools
import struct
import time
from collections.abc import Sequence
from dataclasses import dataclass, field

from websockets.asyncio.client import connect
from websockets.exceptions import WebSocketException

from app.database.engine import create_from_url
from app.errors import TelemotionError
from app.gateway import DeviceStream, GatewayClient, ServiceClient
from app.recordings.signals.store import read_packets
from tests.benchmarks.crash import Outcome, Session
from tests.patience import PATIENCE_S

JUST_SENT_S = 0.3
"""What a killed process sent last may be on its way so long."""


class RovingGateway(GatewayClient):
    """A gateway that knows several edges, and tries the next one when it has lost the one before.

    By MQTT it asks the next one for a ticket only: which edge has the conversation it does not know.
    """

    def __init__(
        self, clients: Sequence[ServiceClient], session_id: str, stream: DeviceStream, mqtt_url: str = ""
    ) -> None:
        self._clients = itertools.cycle(clients)
        self._client = next(self._clients)
        self._mqtt_url = mqtt_url
        super().__init__(
            mqtt_url or self._client.ingest_url,
            lambda: self._client.ticket(session_id),
            stream.hello,
            give_up_s=PATIENCE_S,
        )
        self._is_first = True

    async def _connect_once(self) -> None:
        if not self._is_first:
            self._client = next(self._clients)
            self._url = self._mqtt_url or self._client.ingest_url
        self._is_first = False
        await super()._connect_once()


class Roving(Session):
    """A session whose gateway and whose view each go to another edge when theirs ends."""

    def __init__(
        self,
        number: int,
        session_id: str,
        clients: Sequence[ServiceClient],
        stream: DeviceStream,
        *,
        holds: bool = False,
        mqtt_url: str = "",
    ) -> None:
        first = number % len(clients)
        own = [*clients[first:], *clients[:first]]
        super().__init__(number, session_id, own[0], stream)
        self.gateway = RovingGateway(own, session_id, stream, mqtt_url)
        self._views = itertools.cycle([*own[1:], own[0]])
        self._holds = holds
        self.shown: dict[int, bytes] = {}
        """The numbers of a frame, by tick; only where the session holds them."""
        self.newest = -1
        """Newest tick that was shown."""
        self.newest_s = 0.0
        """Monotonic time at which it was."""
        self.longest_gap_s = 0.0
        """Longest time between two moments at which something newer was shown; begun anew by whoever measures."""
        self.contradictions = 0
        """Ticks that were shown twice with other numbers."""
        self.moved = asyncio.Event()
        self.is_settled = False
        """Whether all that was sent is acknowledged."""

    async def send(self) -> None:
        """Send until it is over and everything is acknowledged."""
        await self.gateway.run(self.deliveries(), goodbye=False)
        self.is_settled = True

    def show(self, block: bytes) -> None:
        """Take note of a block."""
        ticks, columns, first_tick = struct.unpack_from("<III", block, 4)
        if self._holds:
            head, size = len(block) - 4 * ticks * columns, 4 * columns
            for number in range(ticks):
                row = block[head + number * size : head + (number + 1) * size]
                self.contradictions += self.shown.setdefault(first_tick + number, row) != row
        last = first_tick + ticks - 1
        if last > self.newest:
            now_s = time.monotonic()
            if self.newest >= 0:
                self.longest_gap_s = max(self.longest_gap_s, now_s - self.newest_s)
            self.newest, self.newest_s = last, now_s
            self.moved.set()

    async def look_on(self) -> None:
        """Watch until cancelled, at the next edge whenever a connection ends."""
        while True:
            client = next(self._views)
            address = f"{client.server.replace('http', 'ws', 1)}/ws/live/{self.id}"
            with contextlib.suppress(TelemotionError, WebSocketException, OSError, TimeoutError):
                ticket = await client.ticket(self.id, "live")
                async with connect(address, compression=None, proxy=None, ping_timeout=5.0) as socket:
                    await socket.send(f'{{"ticket": "{ticket}"}}')
                    async for message in socket:
                        if isinstance(message, bytes):
                            self.show(message)
            await asyncio.sleep(0.1)

    def stored(self, url: str) -> list[int]:
        """Return the numbers of the packets that are stored of it, in their order."""
        engine = create_from_url(url)
        try:
            return [packet.sequence for packet in read_packets(engine, self.id)]
        finally:
            engine.dispose()

    async def newer_than(self, tick: int) -> float:
        """Wait until something newer than a tick was shown; return when, monotonic."""
        while self.newest <= tick:
            self.moved.clear()
            await self.moved.wait()
        return time.monotonic()


async def shown_again(sessions: Sequence[Roving], since_s: float, patience_s: float = 240.0) -> list[float]:
    """Return how long after a moment each session showed something that was not there before it."""
    await asyncio.sleep(max(0.0, since_s + JUST_SENT_S - time.monotonic()))
    known = [one.newest for one in sessions]
    async with asyncio.timeout(patience_s):
        found = await asyncio.gather(
            *(one.newer_than(tick) for one, tick in zip(sessions, known, strict=True))
        )
    return [at_s - since_s for at_s in found]


@dataclass
class Stored(Outcome):
    """What is stored against what was sent, with its order."""

    out_of_order: int = 0
    """Packets that were stored behind one with a higher number."""
    per_session: list[int] = field(default_factory=list)

    @property
    def is_whole(self) -> bool:
        """Whether every packet is there once, as it was sent, in order."""
        return super().is_whole and not self.out_of_order


def check_stored(url: str, sessions: Sequence[Roving]) -> Stored:
    """Count what is stored of the sessions against what was sent."""
    outcome = Stored()
    for one in sessions:
        one.check(url, outcome)
        numbers = one.stored(url)
        outcome.out_of_order += sum(after < before for before, after in itertools.pairwise(numbers))
        outcome.per_session.append(len(numbers))
    return outcome
