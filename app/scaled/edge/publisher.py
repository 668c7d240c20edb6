"""From an edge into the streams: what came since the last message of a partition goes as one, in order.

A partition's next message is sent when the server has acknowledged the one before; an answer that does not come is
asked for again with the same number, which the server knows for some minutes. So the order of a connection's packets is
that in which they came, and nothing is there twice because of us.
"""

import asyncio
import logging
from collections.abc import Callable, Iterable
from typing import Final

import nats
from nats.js.errors import Error as StreamError

from app.database.base import new_id
from app.errors import Unavailable
from app.scaled.broker import Broker
from app.scaled.wire import Entry, PacketEntry, encode, subject
from estimators.sentences import say

logger = logging.getLogger(__name__)

MESSAGE_BYTES: Final = 512 << 10
WAITING_BYTES: Final = 16 << 20
"""Of a partition; then gateways are read more slowly."""
GATHER_S: Final = 0.02
"""What comes within so long goes together: a message costs edge, broker and worker as much as several packets in it.
All partitions send at the same moments, so that their worker takes all of it in one turn."""
ANSWER_S: Final = 1.0
AGAIN_S: Final = 0.1

Durable = Callable[[], None]


class StreamPublisher:
    """Sends one partition's entries."""

    def __init__(self, broker: Broker, partition: int) -> None:
        self._broker, self._subject = broker, subject("in", partition)
        self._entries: list[tuple[Entry, Durable | None]] = []
        self._bytes = 0
        self._wake = asyncio.Event()
        self._task = asyncio.create_task(self._send(), name=f"publisher {partition}")

    def put(self, entry: Entry, durable: Durable | None = None) -> None:
        """Take an entry; `durable` is called once it is in the stream.

        Raises
        ------
        Unavailable
            Too much waits: the broker is behind, or away.
        """
        size = len(entry.data) if isinstance(entry, PacketEntry) else 0
        if size and self._bytes + size > WAITING_BYTES:
            raise Unavailable(say("stored.behind"), retry_after_s=1, reason="store_behind")
        self._bytes += size
        self._entries.append((entry, durable))
        self._wake.set()

    def _take(self) -> list[tuple[Entry, Durable | None]]:
        """Return as much as one message holds."""
        size = count = 0
        for entry, _ in self._entries:
            size += len(entry.data) if isinstance(entry, PacketEntry) else 0
            if count and size > MESSAGE_BYTES:
                break
            count += 1
        taken, self._entries = self._entries[:count], self._entries[count:]
        return taken

    async def _send(self) -> None:
        loop = asyncio.get_running_loop()
        while True:
            await self._wake.wait()
            await asyncio.sleep(GATHER_S - loop.time() % GATHER_S)
            self._wake.clear()
            while self._entries:
                taken = self._take()
                await self._until_acknowledged(entry for entry, _ in taken)
                self._bytes -= sum(len(one.data) for one, _ in taken if isinstance(one, PacketEntry))
                for _, durable in taken:
                    if durable is not None:
                        durable()

    async def _until_acknowledged(self, entries: Iterable[Entry]) -> None:
        data = self._broker.seal.close(self._subject, encode(list(entries)))
        headers = {"Nats-Msg-Id": new_id()}
        while True:
            try:
                await self._broker.streams.publish(self._subject, data, timeout=ANSWER_S, headers=headers)
            except (nats.errors.Error, StreamError, OSError, TimeoutError) as error:
                logger.warning("%s: sent again after %s", self._subject, type(error).__name__)
                await asyncio.sleep(AGAIN_S)
            else:
                return

    async def close(self, patience_s: float) -> None:
        """Send what waits, for a while, then nothing more."""
        try:
            async with asyncio.timeout(patience_s):
                while self._entries or self._bytes:  # noqa: ASYNC110 - once, at the end
                    await asyncio.sleep(GATHER_S)
        except TimeoutError:
            logger.warning("%s: %d entries not sent; gateways hold them", self._subject, len(self._entries))
        self._task.cancel()
