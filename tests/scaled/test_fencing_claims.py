"""An edge takes what the holder of a partition says, and the database says who that is."""

import asyncio
from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("nats", reason="the extra `scaled` is not installed")

from sqlalchemy.exc import OperationalError

from app.live.messages import StateMessage
from app.scaled.edge import feed
from app.scaled.edge.feed import FeedBus
from app.scaled.wire import ToEdge, encode, pack_message

TOPIC = "session/one/state"
MESSAGE = StateMessage(
    state="ready",
    reason="",
    session_time_s=1.0,
    recording_start_s=None,
    calibration=None,
    calibration_progress=None,
)


class Edge:
    """Hears what is said to it; the database names a holder for each partition, or is away."""

    def __init__(self, **holders: int) -> None:
        self.holders = {int(name.strip("p")): number for name, number in holders.items()}
        self.looks, self.is_away = 0, False
        broker: Any = SimpleNamespace(client=None, partitions=4)
        self.bus = FeedBus(broker, "edge-1.name", self._look)
        self.heard = self.bus.subscribe(TOPIC, size=100)

    def _look(self) -> dict[int, int]:
        self.looks += 1
        if self.is_away:
            raise OperationalError("", {}, Exception())
        return dict(self.holders)

    async def says(self, fencing: int, partition: int = 0) -> int:
        """Say something under a number; return how much of all that was said is shown."""
        sent = encode([ToEdge(partition, fencing, [pack_message(TOPIC, MESSAGE)])])
        await self.bus._hear(SimpleNamespace(data=sent))  # type: ignore[arg-type]
        await asyncio.sleep(3.0 * feed.LOOK_S)
        return len(self.heard.take())


@pytest.fixture(autouse=True)
def soon(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(feed, "LOOK_S", 0.02)


def test_a_number_that_nobody_has_stops_no_view() -> None:
    async def run() -> None:
        edge = Edge(p0=7)
        assert await edge.says(7) == 1
        assert await edge.says(1 << 62) == 0
        assert await edge.says(7) == 1, "what the holder says is shown as before"
        assert await edge.says(6) == 0
        await edge.bus.stop()

    asyncio.run(run())


def test_the_next_holder_is_heard_from_its_first_word_on() -> None:
    async def run() -> None:
        edge = Edge(p0=7)
        assert await edge.says(7) == 1
        edge.holders[0] = 8
        assert await edge.says(8) == 1
        assert await edge.says(7) == 0
        assert edge.looks == 2
        await edge.bus.stop()

    asyncio.run(run())


def test_while_the_database_is_away_a_new_number_waits() -> None:
    async def run() -> None:
        edge = Edge(p0=7)
        edge.is_away = True
        assert await edge.says(7) == 0
        edge.is_away = False
        await asyncio.sleep(0.2)
        assert len(edge.heard.take()) == 1
        await edge.bus.stop()

    asyncio.run(run())


def test_what_is_held_back_is_bounded_and_a_partition_that_is_none_is_not_looked_for() -> None:
    async def run() -> None:
        edge = Edge(p0=7)
        edge.is_away = True
        for _ in range(2 * feed.MOST_HELD):
            sent = encode([ToEdge(0, 9, [])])
            await edge.bus._hear(SimpleNamespace(data=sent))  # type: ignore[arg-type]
        assert len(edge.bus._held[0]) == feed.MOST_HELD
        assert await edge.says(1, partition=99) == 0
        assert set(edge.bus._held) == {0}
        await edge.bus.stop()

    asyncio.run(run())
