"""The bus between live sessions and their views: bounded, keeps the newest message, never blocks.

A view that is slow loses the oldest messages of its own queue, counted; nothing it does slows a session or
another view. Recordings do not go over the bus. `MemoryBus` serves one process; another implementation of
`Bus` can carry the same topics between machines.

Topics: `session/{id}/frames` (`estimators.pipelines.Frames`), `/blocks` (the same as binary blocks), `/state`,
`/health`, `/event`, `/layout`, `/guidance` (messages of `app.live.messages`).
"""

import asyncio
import contextlib
import logging
from collections import deque
from collections.abc import AsyncIterator, Iterator
from dataclasses import dataclass
from typing import Any, Final, Protocol
from weakref import WeakValueDictionary

logger = logging.getLogger(__name__)

DEFAULT_QUEUE = 64


@dataclass
class BusMetrics:
    """Counters since the start."""

    published: int = 0
    delivered: int = 0
    dropped: int = 0


class Subscription:
    """One listener's own queue of (topic, message), for one or more topics.

    Parameters
    ----------
    size : int
        Messages held; the oldest is dropped when one more comes.
    """

    def __init__(self, bus: "MemoryBus", topics: tuple[str, ...], size: int) -> None:
        self._bus = bus
        self.topics = topics
        self._queue: deque[tuple[str, Any]] = deque(maxlen=size)
        self._ready = asyncio.Event()
        self._is_closed = False
        self.dropped = 0

    def put(self, topic: str, message: Any) -> bool:
        """Take a message; False when an older one was dropped for it."""
        fits = len(self._queue) < (self._queue.maxlen or 0)
        if not fits:
            self.dropped += 1
        self._queue.append((topic, message))
        self._ready.set()
        return fits

    @property
    def has_more(self) -> bool:
        """Whether something waits."""
        return bool(self._queue)

    def take(self) -> list[tuple[str, Any]]:
        """Return everything that waits, oldest first, without waiting."""
        items = list(self._queue)
        self._queue.clear()
        self._ready.clear()
        return items

    async def wait(self) -> list[tuple[str, Any]]:
        """Wait until something is there, then return all of it; empty when the subscription was closed."""
        while not self._queue and not self._is_closed:
            self._ready.clear()
            await self._ready.wait()
        return self.take()

    async def __aiter__(self) -> AsyncIterator[Any]:
        """Yield messages until the subscription is closed."""
        while True:
            items = await self.wait()
            if not items and self._is_closed:
                return
            for _, message in items:
                yield message

    def close(self) -> None:
        """Stop receiving; a waiting reader is woken and ends."""
        self._is_closed = True
        self._bus.remove(self)
        self._ready.set()

    def __enter__(self) -> "Subscription":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class Listener(Protocol):
    """Takes messages at once, on the event loop's thread."""

    topics: tuple[str, ...]

    def put(self, topic: str, message: Any) -> bool:
        """Take a message; False when one was dropped."""


class Channel:
    """One topic. A frequent publisher holds it, and reads `listeners` before it builds a costly message."""

    __slots__ = ("__weakref__", "_metrics", "listeners", "name")

    def __init__(self, name: str, metrics: BusMetrics) -> None:
        self.name: Final = name
        self.listeners: Final[list[Listener]] = []
        self._metrics = metrics

    def publish(self, message: Any) -> None:
        """Give a message to everybody who listens; never waits."""
        metrics = self._metrics
        metrics.published += 1
        for listener in self.listeners:
            metrics.delivered += 1
            try:
                is_taken = listener.put(self.name, message)
            except Exception:
                # Who listens must harm neither the session nor those who listen besides.
                logger.exception("a message of topic %s could not be taken", self.name)
                is_taken = False
            if not is_taken:
                metrics.dropped += 1


class Bus(Protocol):
    """What sessions and views need of a bus. All calls are made on the event loop's thread."""

    def publish(self, topic: str, message: Any) -> None:
        """Give a message to everybody who listens to the topic; never waits."""

    def subscribe(self, *topics: str, size: int = DEFAULT_QUEUE) -> Subscription:
        """Listen to topics from now on; close the subscription, or use it in a `with` statement."""

    def attach(self, listener: Listener) -> contextlib.AbstractContextManager[None]:
        """Let `listener.put` be called with each message of its topics, within the context."""

    def has_listeners(self, topic: str) -> bool:
        """Whether anybody listens, so that costly messages are made only then."""

    def channel(self, topic: str) -> Channel:
        """Return the channel of a topic, the same one for as long as anybody holds it."""


class MemoryBus:
    """The bus of one process."""

    def __init__(self) -> None:
        # A channel lives as long as whoever publishes or listens.
        self._channels: WeakValueDictionary[str, Channel] = WeakValueDictionary()
        self._heard: dict[Listener, list[Channel]] = {}
        self.metrics = BusMetrics()

    def channel(self, topic: str) -> Channel:
        """Return the channel of a topic, the same one for as long as anybody holds it."""
        found = self._channels.get(topic)
        if found is None:
            self._channels[topic] = found = Channel(topic, self.metrics)
        return found

    def publish(self, topic: str, message: Any) -> None:
        """Give a message to everybody who listens to the topic; never waits."""
        self.channel(topic).publish(message)

    def subscribe(self, *topics: str, size: int = DEFAULT_QUEUE) -> Subscription:
        """Listen to topics from now on; close the subscription, or use it in a `with` statement."""
        subscription = Subscription(self, topics, size)
        self.listen(subscription)
        return subscription

    @contextlib.contextmanager
    def attach(self, listener: Listener) -> Iterator[None]:
        """Let `listener.put` be called with each message of its topics, within the context."""
        self.listen(listener)
        try:
            yield
        finally:
            self.remove(listener)

    def listen(self, listener: Listener) -> None:
        """Let a listener have each message of its topics from now on, until `remove`."""
        self._heard[listener] = [self.channel(topic) for topic in listener.topics]
        for channel in self._heard[listener]:
            channel.listeners.append(listener)

    def has_listeners(self, topic: str) -> bool:
        """Whether anybody listens, so that costly messages are made only then."""
        found = self._channels.get(topic)
        return found is not None and bool(found.listeners)

    @property
    def topics(self) -> set[str]:
        """Topics that somebody listens to."""
        return {channel.name for channels in self._heard.values() for channel in channels}

    def remove(self, listener: Listener) -> None:
        """Forget a listener; `Subscription.close` calls this."""
        for channel in self._heard.pop(listener, ()):
            channel.listeners.remove(listener)


def topic(session_id: str, name: str) -> str:
    """Return the topic of one session: name is `frames`, `state`, `health`, `event` or `layout`."""
    return f"session/{session_id}/{name}"
