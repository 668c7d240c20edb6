"""From the sessions of a partition to the edges that want to hear of them."""

import time
from typing import Any, Final

from app.live.bus import MemoryBus
from app.scaled.wire import Here, Published, Report, pack_message
from app.scaled.worker.sender import EdgeSender

FORGET_S: Final = 3.0
"""An edge that says nothing for so long wants nothing any more."""
_FRAMES: Final = ("blocks", "frames")


class _Wish:
    """What one edge wants; a listener of the partition's bus."""

    def __init__(self, publisher: "Publisher", edge: str) -> None:
        self.topics: tuple[str, ...] = ()
        self.edge, self.heard_s = edge, time.monotonic()
        self._publisher = publisher

    def put(self, topic: str, message: Any) -> bool:
        """Take a message; False when frames are left out because the broker is behind."""
        if topic.endswith(_FRAMES) and self._publisher.is_behind:
            return False
        self._publisher.send(self.edge, pack_message(topic, message))
        return True


class Publisher:
    """Sends edges what they want of a partition.

    Parameters
    ----------
    bus : MemoryBus
        Of the partition.
    """

    def __init__(self, post: EdgeSender, bus: MemoryBus, partition: int, fencing: int) -> None:
        self._post, self._bus, self._partition, self._fencing = post, bus, partition, fencing
        self._wishes: dict[str, _Wish] = {}

    @property
    def is_behind(self) -> bool:
        """Whether much waits for the broker."""
        return self._post.is_behind

    def send(self, edge: str, item: Published | Report) -> None:
        """Send an edge something once the present turn is over."""
        self._post.put(edge, self._partition, self._fencing, item)

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
        if edge not in self._wishes:
            self._wish(edge)
        self.send(edge, report)

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

    def close(self) -> None:
        """Hear nothing more."""
        for wish in self._wishes.values():
            self._bus.remove(wish)
