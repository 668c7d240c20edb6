"""A lease is deleted by whoever holds it, and by nobody who held it before."""

import asyncio
from collections.abc import Awaitable, Callable
from types import SimpleNamespace
from typing import Any

import pytest
from nats.js.errors import KeyNotFoundError, KeyWrongLastSequenceError

from app.scaled.worker.leases import Leases, _Key

P = 3
KEY = "partition.3"


class Bucket:
    """Keys with revisions as NATS has them: what is deleted without a revision is deleted whatever it is."""

    def __init__(self) -> None:
        self.keys: dict[str, tuple[int, bytes]] = {}
        self.answer: Callable[[], Awaitable[object]] | None = None
        """Awaited by an update that is done, before its caller hears of it."""
        self._revision = 0

    def write(self, key: str, value: bytes, last: int | None) -> int:
        if last is not None and self.keys.get(key, (0, b""))[0] != last:
            raise KeyWrongLastSequenceError
        self._revision += 1
        self.keys[key] = (self._revision, value)
        return self._revision

    async def create(self, key: str, value: bytes) -> int:
        return self.write(key, value, 0)

    async def update(self, key: str, value: bytes, last: int) -> int:
        revision = self.write(key, value, last)
        if self.answer is not None:
            await self.answer()
        return revision

    async def get(self, key: str) -> Any:
        if key not in self.keys:
            raise KeyNotFoundError
        revision, value = self.keys[key]
        return SimpleNamespace(revision=revision, value=value)

    async def delete(self, key: str, last: int | None = None) -> None:
        if last is not None and self.keys.get(key, (0, b""))[0] != last:
            raise KeyWrongLastSequenceError
        self.keys.pop(key, None)


class Holder:
    """Takes partitions as it is asked to by a test."""

    def __init__(self) -> None:
        self.taking: Callable[[], None] = lambda: None
        self.giving: Callable[[int], None] = lambda _: None

    async def take(self, partition: int) -> None:
        self.taking()

    async def give_back(self, partition: int) -> None:
        self.giving(partition)

    def lose(self, partition: int) -> None:
        """Hold nothing."""


Made = tuple[Bucket, Holder, Leases]


@pytest.fixture
def made() -> Made:
    bucket, holder = Bucket(), Holder()
    broker: Any = SimpleNamespace(leases=bucket, partitions=8, on_back=lambda _: None)
    return bucket, holder, Leases(broker, "own", holder, 0.05)


async def acquired(leases: Leases, *partitions: int) -> None:
    for partition in partitions:
        await leases._acquire(partition)
    await asyncio.gather(*leases._moving.values())


def test_who_fails_to_take_a_partition_that_another_has_taken_leaves_the_lease_of_the_other(
    made: Made,
) -> None:
    bucket, holder, leases = made

    def refuse() -> None:
        bucket.write(KEY, b"other", None)
        leases.fenced(P)
        raise ValueError

    holder.taking = refuse
    asyncio.run(acquired(leases, P))
    assert bucket.keys[KEY][1] == b"other"
    assert leases.held == []


def test_who_fails_to_take_a_partition_frees_its_lease(made: Made) -> None:
    bucket, holder, leases = made

    def refuse() -> None:
        raise ValueError

    holder.taking = refuse
    asyncio.run(acquired(leases, P))
    assert bucket.keys == {}


def test_a_partition_that_cannot_be_stored_is_free_all_the_same_and_so_are_the_others(made: Made) -> None:
    bucket, holder, leases = made

    def refuse(partition: int) -> None:
        if partition == P:
            raise ValueError

    holder.giving = refuse

    async def story() -> None:
        await acquired(leases, P, 4)
        await leases.stop()

    asyncio.run(story())
    assert bucket.keys == {}
    assert leases.held == []


def other_there(leases: Leases) -> None:
    leases._seen["worker.other"] = _Key(1, 0.0, b"")


def test_who_stops_gives_the_next_partition_back_when_the_one_before_is_taken_up(made: Made) -> None:
    bucket, _, leases = made
    held: list[list[int]] = []

    async def story() -> None:
        await acquired(leases, 1, 2, 3)
        other_there(leases)
        stopping = asyncio.create_task(leases.stop())
        for partition in (1, 2, 3):
            # Longer than it takes to give one back.
            await asyncio.sleep(0.1)
            held.append(leases.held)
            assert all(f"partition.{one}" in bucket.keys for one in leases.held)
            message: Any = SimpleNamespace(subject=f"telemotion.taken.{partition}")
            await leases._taken(message)
        await stopping

    asyncio.run(story())
    assert held == [[2, 3], [3], []]
    assert bucket.keys == {}


def test_who_stops_gives_all_that_is_left_back_where_nobody_takes_them(
    made: Made, monkeypatch: pytest.MonkeyPatch
) -> None:
    bucket, _, leases = made
    monkeypatch.setattr("app.scaled.worker.leases.TAKEN_S", 0.01)

    async def story() -> None:
        await acquired(leases, 1, 2, 3)
        other_there(leases)
        await leases.stop()

    asyncio.run(story())
    assert bucket.keys == {}
    assert leases.held == []


def test_a_lease_that_is_renewed_while_it_is_given_back_is_free(made: Made) -> None:
    bucket, _, leases = made

    async def story() -> None:
        await acquired(leases, P)
        bucket.answer = lambda: leases._give_back(P)
        await leases._renew(P)

    asyncio.run(story())
    assert bucket.keys == {}


def test_what_was_given_back_since_the_turn_began_is_not_renewed(made: Made) -> None:
    bucket, _, leases = made

    async def story() -> None:
        await acquired(leases, P)
        await leases._give_back(P)
        await leases._renew(P)

    asyncio.run(story())
    assert bucket.keys == {}
