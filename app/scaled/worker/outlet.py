"""From the sessions of a partition to the edges that want to hear of them: one message an edge and turn."""

import asyncio
import logging
import time
from typing import Any, Final

import nats

from app.live.bus import MemoryBus
from app.scaled.broker import Broker
from app.scaled.wire import Here, Published, Report, ToEdge, encode, pack_message, subject

logger = logging.getLogger(__name__)

FORGET_S: Final = 3.0
"""An edge that says nothing for so long wants nothing any more."""
MOST_PENDING: Final = 8 << 20
"""Bytes that wait for the broker; beyond it views go without frames."""
_FRAMES: Final = ("blocks", "frames")


class _Wish:
    """What one edge wants; a listener of the partition's bus."""

    def __init__(self, outlet: "Outlet", edge: str) -> None:
        self.topics: tuple[str, ...] = ()
        self.edge, self.heard_s = edge, time.monotonic()
        self.items: list[Published | Report] = []
        self._outlet = outlet

    def put(self, topic: str, message: Any) -> bool:
        """Take a message; False when frames are left out because the broker is behind."""
        if topic.endswith(_FRAMES) and self._outlet.is_behind:
            return False
        self.items.append(pack_message(topic, message))
        self._outlet.flush_soon()
        return True


class Outlet:
    """Sends edges what they want of a partition.

    Parameters
    ----------
    broker : Broker
    bus : MemoryBus
        Of the partition.
    partition, fencing : int
    """

    def __init__(self, broker: Broker, bus: MemoryBus, partition: int, fencing: int) -> None:
        self._broker, self._bus, self._partition, self._fencing = broker, bus, partition, fencing
        self._wishes: dict[str, _Wish] = {}
        self._wake = asyncio.Event()
        self._task = asyncio.create_task(self._send(), name="outlet")

    @property
    def is_behind(self) -> bool:
        """Whether much waits for the broker."""
        return not self._broker.client.is_connected or self._broker.client.pending_data_size > MOST_PENDING

    def flush_soon(self) -> None:
        """Send what was gathered once the present turn is over."""
        self._wake.set()

    def hear(self, here: Here) -> None:
        """Take note of what an edge wants."""
        wish = self._wish(here.edge)
        self._listen(wish, tuple(sorted(here.topics)))

    def want(self, edge: str, topics: list[str]) -> None:
        """Take note of topics that an edge wants besides."""
        wish = self._wish(edge)
        self._listen(wish, tuple(sorted({*wish.topics, *topics})))

    def report(self, edge: str, report: Report) -> None:
        """Send a gateway's connection a report."""
        wish = self._wishes.get(edge) or self._wish(edge)
        wish.items.append(report)
        self.flush_soon()

    def _wish(self, edge: str) -> _Wish:
        wish = self._wishes.get(edge)
        if wish is None:
            wish = self._wishes[edge] = _Wish(self, edge)
        wish.heard_s = time.monotonic()
        return wish

    def _listen(self, wish: _Wish, topics: tuple[str, ...]) -> None:
        if topics != wish.topics:
            self._bus.remove(wish)
            wish.topics = topics
            self._bus.listen(wish)

    def hears_of(self, edge: str) -> bool:
        """Whether an edge was heard of lately."""
        return edge in self._wishes

    def forget_silent(self) -> None:
        """Let edges go that say nothing any more."""
        now_s = time.monotonic()
        for edge, wish in list(self._wishes.items()):
            if now_s - wish.heard_s > FORGET_S:
                self._bus.remove(wish)
                del self._wishes[edge]

    async def _send(self) -> None:
        while True:
            await self._wake.wait()
            self._wake.clear()
            for wish in list(self._wishes.values()):
                items, wish.items = wish.items, []
                if items:
                    message = encode(ToEdge(self._partition, self._fencing, items))
                    try:
                        await self._broker.client.publish(subject("to", wish.edge), message)
                    except nats.errors.Error as error:
                        logger.warning("%d messages for views lost: %s", len(items), type(error).__name__)

    def close(self) -> None:
        """Send nothing more."""
        self._task.cancel()


__all__ = ["Outlet"]
