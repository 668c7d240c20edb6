"""Messages of a worker to the edges: one an edge and turn, for all partitions together."""

import asyncio
import logging
from collections import defaultdict
from typing import Final

import nats

from app.scaled.broker import Broker
from app.scaled.wire import Published, Report, ToEdge, encode, subject

logger = logging.getLogger(__name__)

MESSAGE_BYTES: Final = 512 << 10
MOST_PENDING: Final = 8 << 20
"""Bytes that wait for the broker; beyond it views go without frames."""


class _Bundle:
    """A message that is being gathered."""

    def __init__(self) -> None:
        self.parts: dict[tuple[int, int], ToEdge] = {}
        self.bytes = 0

    def add(self, partition: int, fencing: int, item: Published | Report, size: int) -> None:
        part = self.parts.get((partition, fencing))
        if part is None:
            part = self.parts[partition, fencing] = ToEdge(partition, fencing, [])
        part.items.append(item)
        self.bytes += size


class EdgeSender:
    """Sends edges what partitions have for them."""

    def __init__(self, broker: Broker) -> None:
        self._broker = broker
        self._waiting: defaultdict[str, list[_Bundle]] = defaultdict(list)
        self._wake = asyncio.Event()
        self._task: asyncio.Task[None] | None = None

    @property
    def is_behind(self) -> bool:
        """Whether much waits for the broker."""
        return not self._broker.client.is_connected or self._broker.client.pending_data_size > MOST_PENDING

    def put(self, edge: str, partition: int, fencing: int, item: Published | Report) -> None:
        """Send something once the present turn is over.

        Parameters
        ----------
        partition, fencing : int
            Of the lease under which it was found.
        """
        bundles, size = self._waiting[edge], len(item.data) if isinstance(item, Published) else 0
        if not bundles or bundles[-1].bytes + size > MESSAGE_BYTES:
            bundles.append(_Bundle())
        bundles[-1].add(partition, fencing, item, size)
        self._wake.set()

    def start(self) -> None:
        """Begin to send."""
        self._task = asyncio.create_task(self._send(), name="post")

    def stop(self) -> None:
        """Send nothing more."""
        if self._task is not None:
            self._task.cancel()

    async def _send(self) -> None:
        while True:
            await self._wake.wait()
            self._wake.clear()
            waiting, self._waiting = self._waiting, defaultdict(list)
            for edge, bundles in waiting.items():
                for bundle in bundles:
                    try:
                        await self._broker.client.publish(
                            subject("to", edge), encode(list(bundle.parts.values()))
                        )
                    except nats.errors.Error as error:
                        logger.warning("messages for views lost: %s", type(error).__name__)
