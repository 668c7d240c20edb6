"""What an edge hears of sessions that are live elsewhere: the bus of its views, and the reports to its gateways."""

import asyncio
import contextlib
import logging
from collections import defaultdict
from collections.abc import Sequence
from typing import Final

import nats
from nats.aio.msg import Msg

from app.live.bus import Listener, MemoryBus, Subscription
from app.scaled.broker import Broker
from app.scaled.edge.intake import EdgeIntake
from app.scaled.wire import (
    Here,
    Published,
    Report,
    decode_to_edge,
    encode,
    partition_of,
    subject,
    unpack_message,
)

logger = logging.getLogger(__name__)

AGAIN_S: Final = 0.5
"""An edge says so often what it wants."""


class FeedBus(MemoryBus):
    """The bus of the views of an edge: what they listen to is asked of whoever holds the session.

    Parameters
    ----------
    broker : Broker
    edge : str
        Name of this edge.
    """

    def __init__(self, broker: Broker, edge: str) -> None:
        super().__init__()
        self.edge = edge
        self.intakes: dict[str, EdgeIntake] = {}
        """By connection."""
        self._broker = broker
        self._fencing: dict[int, int] = {}
        self._said: set[int] = set()
        self._changed = asyncio.Event()
        self._task: asyncio.Task[None] | None = None

    async def start(self) -> None:
        """Begin to hear and to say what is wanted."""
        client = self._broker.client
        await client.subscribe(subject("to", self.edge), cb=self._hear)
        await client.subscribe(subject("taken", "*"), cb=self._taken)
        self._task = asyncio.create_task(self._say(), name="edge says")

    async def stop(self) -> None:
        """Say nothing more."""
        if self._task is not None:
            self._task.cancel()
            await asyncio.gather(self._task, return_exceptions=True)

    def listen(self, listener: Listener | Subscription) -> None:
        """Let a listener have each message of its topics from now on, until `remove`."""
        super().listen(listener)
        self._changed.set()

    def remove(self, listener: Listener | Subscription) -> None:
        """Forget a listener."""
        super().remove(listener)
        self._changed.set()

    def say_soon(self) -> None:
        """Say at once what is wanted."""
        self._changed.set()

    async def _hear(self, message: Msg) -> None:
        try:
            for sent in decode_to_edge(message.data):
                if sent.fencing >= self._fencing.get(sent.partition, 0):
                    self._fencing[sent.partition] = sent.fencing
                    self._take(sent.items)
        except Exception:
            logger.exception("a message of a worker is not understood")

    def _take(self, items: Sequence[Published | Report]) -> None:
        for item in items:
            if isinstance(item, Report):
                intake = self.intakes.get(item.connection)
                if intake is not None:
                    intake.hear(item)
            elif self.has_listeners(item.topic):
                self.publish(item.topic, unpack_message(item))

    async def _taken(self, message: Msg) -> None:
        partition = int(message.subject.rpartition(".")[2])
        self._changed.set()
        for intake in list(self.intakes.values()):
            if partition_of(intake.session_id, self._broker.partitions) == partition:
                intake.repeat()

    async def _say(self) -> None:
        while True:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(AGAIN_S):
                    await self._changed.wait()
            self._changed.clear()
            wanted: dict[int, Here] = defaultdict(lambda: Here(self.edge, [], {}))
            for topic in self.topics:
                wanted[self._partition(topic.split("/")[1])].topics.append(topic)
            for intake in self.intakes.values():
                wanted[self._partition(intake.session_id)].connections[intake.session_id] = intake.connection
            # What nothing is wanted of any more hears so once.
            for partition in wanted.keys() | self._said:
                try:
                    await self._broker.client.publish(subject("here", partition), encode(wanted[partition]))
                except nats.errors.Error as error:
                    logger.warning("an edge could not say what it wants: %s", type(error).__name__)
            self._said = {number for number, one in wanted.items() if one.topics or one.connections}
            # Many that come together are said together.
            await asyncio.sleep(0.01)

    def _partition(self, session_id: str) -> int:
        return partition_of(session_id, self._broker.partitions)


__all__ = ["FeedBus"]
