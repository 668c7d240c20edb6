"""Who holds which partition: keys in a bucket of NATS, renewed again and again.

A lease is a key that its holder writes anew a few times in its length. Who sees a key unchanged for that length, by the
own clock, may write it, on condition that it is still the same: of several only one succeeds. Workers write that they
live in the same way; each wants its share of the partitions, rounded up, and gives one back when it has more.

A lease only decides who tries. That an earlier holder writes nothing is the database's word, see `app.scaled.fencing`.
"""

import asyncio
import logging
import math
import time
from collections.abc import Awaitable, Callable
from typing import Final, Protocol

import nats
from nats.js.errors import Error as StreamError
from nats.js.errors import KeyWrongLastSequenceError
from nats.js.kv import KeyValue

from app.scaled.broker import Broker

logger = logging.getLogger(__name__)

TURNS: Final = 5
"""In the length of a lease."""


class Holder(Protocol):
    """What is done with partitions."""

    async def take(self, partition: int) -> None:
        """Begin to hold a partition."""

    async def give_back(self, partition: int) -> None:
        """Store what is known of a partition, for whoever takes it next."""

    def lose(self, partition: int) -> None:
        """Stop at once: somebody else holds the partition by now."""


class Leases:
    """The leases of one worker.

    Parameters
    ----------
    broker : Broker
    worker : str
        Its name; no other has it.
    holder : Holder
    length_s : float
    """

    def __init__(self, broker: Broker, worker: str, holder: Holder, length_s: float) -> None:
        self._broker, self._worker, self._holder, self._length_s = broker, worker, holder, length_s
        self._seen: dict[str, tuple[int, float]] = {}
        """Revision of a key, and when it was first seen; by key."""
        self._held: dict[int, tuple[int, float]] = {}
        """Revision of an own lease, and when it was written; by partition."""
        self._tasks: list[asyncio.Task[None]] = []

    @property
    def held(self) -> list[int]:
        """Partitions that are held."""
        return sorted(self._held)

    async def start(self) -> None:
        """Begin to take partitions."""
        self._tasks = [
            asyncio.create_task(self._forever(self._watch), name="lease watch"),
            asyncio.create_task(self._forever(self._turns), name="lease turns"),
        ]

    async def stop(self) -> None:
        """Give every partition back, so that others take them at once."""
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        await asyncio.gather(*(self._give_back(one) for one in list(self._held)))
        await self._ignoring(self._broker.leases.delete(f"worker.{self._worker}"))

    async def _forever(self, work: Callable[[], Awaitable[None]]) -> None:
        while True:
            try:
                await work()
            except (nats.errors.Error, StreamError, OSError, TimeoutError) as error:
                logger.warning("leases: %s", type(error).__name__)
                await asyncio.sleep(self._length_s / TURNS)
            except Exception:
                logger.exception("leases stumbled; they go on")
                await asyncio.sleep(self._length_s / TURNS)

    async def _watch(self) -> None:
        watcher = await self._broker.leases.watchall()
        try:
            while True:
                try:
                    entry: KeyValue.Entry | None = await watcher.updates(timeout=5.0)  # type: ignore[no-untyped-call]
                except TimeoutError:
                    return
                if entry is None:
                    continue
                if entry.operation in {"DEL", "PURGE"}:
                    self._seen.pop(entry.key, None)
                elif entry.revision is not None:
                    self._seen[entry.key] = (entry.revision, time.monotonic())
        finally:
            await watcher.stop()  # type: ignore[no-untyped-call]

    async def _turns(self) -> None:
        await self._broker.leases.put(f"worker.{self._worker}", b"")
        # What is there already is seen before anything is judged as old.
        await asyncio.sleep(self._length_s / TURNS)
        while True:
            began_s = time.monotonic()
            await self._broker.leases.put(f"worker.{self._worker}", b"")
            for partition in list(self._held):
                await self._renew(partition)
            await self._balance()
            await asyncio.sleep(max(0.0, began_s + self._length_s / TURNS - time.monotonic()))
            if time.monotonic() - began_s > self._length_s:
                # This process, or the broker, stood still: what others wrote meanwhile has not been read yet.
                await asyncio.sleep(self._length_s / TURNS)

    async def _renew(self, partition: int) -> None:
        revision, written_s = self._held[partition]
        try:
            renewed = await self._broker.leases.update(_key(partition), self._worker.encode(), last=revision)
        except KeyWrongLastSequenceError:
            logger.warning("the lease of partition %d is lost", partition)
            self._lose(partition)
        except (nats.errors.Error, StreamError, TimeoutError):
            if time.monotonic() - written_s > 2 * self._length_s:
                logger.warning("the lease of partition %d could not be renewed", partition)
            raise
        else:
            if partition in self._held:
                self._held[partition] = (renewed, time.monotonic())

    async def _balance(self) -> None:
        now_s = time.monotonic()
        old = {key for key, (_, since_s) in self._seen.items() if now_s - since_s > self._length_s}
        workers = {key for key in self._seen if key.startswith("worker.")} - old | {f"worker.{self._worker}"}
        partitions = self._broker.partitions
        share = math.ceil(partitions / len(workers))
        if len(self._held) > share:
            await self._give_back(max(self._held))
            return
        first = sorted(workers).index(f"worker.{self._worker}") * share
        for number in range(partitions):
            if len(self._held) >= share:
                return
            partition = (first + number) % partitions
            key = _key(partition)
            if partition not in self._held and (key not in self._seen or key in old):
                await self._take(partition, key)

    async def _take(self, partition: int, key: str) -> None:
        leases, name = self._broker.leases, self._worker.encode()
        try:
            known = self._seen.get(key)
            revision = await (
                leases.create(key, name) if known is None else leases.update(key, name, last=known[0])
            )
        except KeyWrongLastSequenceError:
            return
        self._held[partition] = (revision, time.monotonic())
        try:
            await self._holder.take(partition)
        except Exception:
            logger.exception("partition %d could not be taken", partition)
            self._lose(partition)
            await self._ignoring(leases.delete(key, last=revision))

    async def _give_back(self, partition: int) -> None:
        await self._holder.give_back(partition)
        held = self._held.pop(partition, None)
        if held is not None:
            await self._ignoring(self._broker.leases.delete(_key(partition), last=held[0]))

    def _lose(self, partition: int) -> None:
        self._held.pop(partition, None)
        self._holder.lose(partition)

    def fenced(self, partition: int) -> None:
        """Note that the database has refused to write for a partition."""
        if partition in self._held:
            logger.warning("partition %d is held by another worker", partition)
            self._lose(partition)

    @staticmethod
    async def _ignoring(work: Awaitable[object]) -> None:
        try:
            await work
        except (nats.errors.Error, StreamError, OSError, TimeoutError) as error:
            logger.warning("leases: %s", type(error).__name__)


def _key(partition: int) -> str:
    return f"partition.{partition}"


__all__ = ["Holder", "Leases"]
