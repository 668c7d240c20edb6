"""An edge's feed of sessions that are live elsewhere: the bus of its views, and the reports to its gateways."""

import asyncio
import contextlib
import logging
from collections import defaultdict, deque
from collections.abc import Callable, Mapping, Sequence
from typing import Final

import nats
from nats.aio.msg import Msg
from sqlalchemy.exc import SQLAlchemyError

from app.live.bus import Listener, MemoryBus, Subscription
from app.scaled.broker import Broker
from app.scaled.edge.intake import EdgeIntake
from app.scaled.wire import (
    Here,
    Published,
    Report,
    ToEdge,
    decode_to_edge,
    encode,
    partition_of,
    subject,
    unpack_message,
)

logger = logging.getLogger(__name__)

AGAIN_S: Final = 0.5
"""An edge says so often what it wants."""
MOST_HELD: Final = 256
"""Messages of a partition that wait until the database has said who holds it; the oldest are left out."""
LOOK_S: Final = 0.2
"""So often at most the database is asked who holds partitions."""

Holders = Callable[[], Mapping[int, int]]


class FeedBus(MemoryBus):
    """The bus of the views of an edge: what they listen to is asked of whoever holds the session.

    Parameters
    ----------
    edge : str
        Below which subject this edge hears, `USER.NAME`.
    holders : callable()
        Returns the fencing number of every partition, from the database; called in a thread.
    """

    def __init__(self, broker: Broker, edge: str, holders: Holders) -> None:
        super().__init__()
        self.edge = edge
        self.intakes: dict[str, EdgeIntake] = {}
        """By connection."""
        self._broker = broker
        self._holders = holders
        self._fencing: dict[int, int] = {}
        """Of each partition, as the database has it: a sender's own word is not taken for it."""
        self._held: defaultdict[int, deque[ToEdge]] = defaultdict(lambda: deque(maxlen=MOST_HELD))
        self._looking: asyncio.Task[None] | None = None
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
        for task in (self._task, self._looking):
            if task is not None:
                task.cancel()
                await asyncio.gather(task, return_exceptions=True)

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
                known = self._fencing.get(sent.partition, 0)
                if sent.fencing > known or sent.partition in self._held:
                    self._hold(sent)
                elif sent.fencing == known:
                    self._take(sent.items)
        except Exception:
            logger.exception("a message of a worker is not understood")

    def _hold(self, sent: ToEdge) -> None:
        """Have a message wait until the database has said who holds its partition."""
        if not 0 <= sent.partition < self._broker.partitions:
            raise ValueError("no such partition")
        self._held[sent.partition].append(sent)
        if self._looking is None:
            self._looking = asyncio.create_task(self._look(), name="edge looks for holders")

    async def _look(self) -> None:
        try:
            while self._held:
                try:
                    found = await asyncio.to_thread(self._holders)
                except SQLAlchemyError as error:
                    logger.warning("who holds partitions is not known: %s", type(error).__name__)
                else:
                    self._fencing.update(found)
                    held, self._held = self._held, defaultdict(self._held.default_factory)
                    for waiting in held.values():
                        for sent in waiting:
                            if sent.fencing == self._fencing.get(sent.partition, 0):
                                self._take(sent.items)
                # Whoever claims a number that nobody has costs one look in so long.
                await asyncio.sleep(LOOK_S)
        finally:
            self._looking = None

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
                    name = subject("here", partition)
                    await self._broker.client.publish(
                        name, self._broker.seal.close(name, encode(wanted[partition]))
                    )
                except nats.errors.Error as error:
                    logger.warning("an edge could not say what it wants: %s", type(error).__name__)
            self._said = {number for number, one in wanted.items() if one.topics or one.connections}
            # Many that come together are said together.
            await asyncio.sleep(0.01)

    def _partition(self, session_id: str) -> int:
        return partition_of(session_id, self._broker.partitions)
