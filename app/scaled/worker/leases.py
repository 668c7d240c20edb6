"""Who holds which partition: keys in a bucket of NATS, renewed again and again.

A lease is a key that its holder renews a few times in its length. Who sees a key unchanged for that length, by the
own clock, may write it, on condition that it is still the same: of several only one succeeds. Workers write that they
live in the same way; each wants its share of the partitions (`share_of`), and gives one back when it has more, the next
when that one is taken up. The keys of a worker whose process has ended are deleted by another one
(`app.scaled.worker.presence`), and free at once.

A lease only decides who tries. That an earlier holder writes nothing is the database's word, see `app.scaled.fencing`.
"""

import asyncio
import contextlib
import logging
import time
from collections.abc import Awaitable, Callable, Coroutine
from dataclasses import dataclass, replace
from typing import Any, Final, Protocol

import nats
from nats.aio.msg import Msg
from nats.js.errors import Error as StreamError
from nats.js.errors import KeyNotFoundError, KeyWrongLastSequenceError
from nats.js.kv import KeyValue

from app.scaled.broker import Broker
from app.scaled.placement import share_of
from app.scaled.wire import subject
from app.scaled.worker.cancellation import end
from app.scaled.worker.presence import WORKER, Presence

logger = logging.getLogger(__name__)

TURNS: Final = 5
"""In the length of a lease."""
TAKEN_S: Final = 3.0
"""So long the next partition is not given back until the one before is taken up: who takes several at once shows
nothing of any until the last is taken up."""
STOP_S: Final = 20.0
"""After so long a worker that stops gives back all that is left at once."""


class Holder(Protocol):
    """What is done with partitions."""

    async def take(self, partition: int) -> None:
        """Begin to hold a partition."""

    async def give_back(self, partition: int) -> None:
        """Store what is known of a partition, for whoever takes it next."""

    def lose(self, partition: int) -> None:
        """Stop at once: somebody else holds the partition by now."""


@dataclass(frozen=True)
class _Key:
    """A key of the bucket, as it was last seen."""

    revision: int
    since_s: float
    """Monotonic time at which this revision was first seen."""
    value: bytes


class Leases:
    """The leases of one worker.

    Parameters
    ----------
    worker : str
        Its name; no other has it.
    """

    def __init__(self, broker: Broker, worker: str, holder: Holder, length_s: float) -> None:
        self._broker, self._worker, self._holder, self._length_s = broker, worker, holder, length_s
        self._seen: dict[str, _Key] = {}
        self._held: dict[int, int] = {}
        """Revision of an own lease, by partition."""
        self._moving: dict[int, asyncio.Task[Any]] = {}
        """Partitions that are just being taken or given back; their leases are renewed meanwhile."""
        self._leaving: set[int] = set()
        """Of these, those that are given back."""
        self._given: dict[int, asyncio.Event] = {}
        """Set when another worker has taken a partition that was given back."""
        self._tasks: list[asyncio.Task[None]] = []
        self._changed = asyncio.Event()
        self._presence = Presence(broker, worker, self._workers_seen, self._reap, length_s)
        broker.on_back(self._back)

    @property
    def held(self) -> list[int]:
        """Partitions that are held."""
        return sorted(self._held)

    async def start(self) -> None:
        """Begin to take partitions."""
        await self._presence.answer()
        await self._broker.client.subscribe(subject("taken", "*"), cb=self._taken)
        self._tasks = [
            asyncio.create_task(self._forever(self._watch), name="lease watch"),
            asyncio.create_task(self._forever(self._turns), name="lease turns"),
            asyncio.create_task(self._forever(self._presence.run), name="lease presence"),
        ]

    async def stop(self) -> None:
        """Give every partition back, one after the other, so that others take them at once."""
        await end(self._tasks)
        await asyncio.gather(*self._moving.values(), return_exceptions=True)
        # Nobody counts on this one from now on.
        await self._ignoring(self._broker.leases.delete(f"worker.{self._worker}"))
        renewing = asyncio.create_task(self._forever(self._renew_held), name="lease renewals")
        until_s = time.monotonic() + STOP_S
        for partition in self.held:
            if not await self._give_back(partition) or time.monotonic() > until_s:
                break
        await end([renewing])
        await asyncio.gather(*(self._give_back(one) for one in self.held), return_exceptions=True)

    def _back(self) -> None:
        # What others wrote while the broker was away, or would have written, is awaited again.
        now_s = time.monotonic()
        self._seen = {key: replace(one, since_s=now_s) for key, one in self._seen.items()}

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
        # What this worker writes itself comes oftener: silence is the end of the watch.
        silence_s = 2.0 * self._length_s / TURNS
        try:
            while True:
                try:
                    entry: KeyValue.Entry | None = await watcher.updates(timeout=silence_s)  # type: ignore[no-untyped-call]
                except TimeoutError:
                    return
                if entry is None:
                    continue
                if entry.operation in {"DEL", "PURGE"}:
                    self._seen.pop(entry.key, None)
                    self._changed.set()
                elif entry.revision is not None:
                    known = self._seen.get(entry.key)
                    if known is None or known.revision < entry.revision:
                        self._seen[entry.key] = _Key(entry.revision, time.monotonic(), entry.value or b"")
                    if known is None and entry.key.startswith(WORKER):
                        self._changed.set()
        finally:
            await watcher.stop()  # type: ignore[no-untyped-call]

    async def _turns(self) -> None:
        await self._announce()
        # What is there already is seen before anything is judged as old.
        await asyncio.sleep(self._length_s / TURNS)
        while True:
            began_s = time.monotonic()
            await asyncio.gather(self._announce(), *(self._renew(one) for one in self.held))
            # What becomes free in between is taken at once.
            next_s = began_s + self._length_s / TURNS
            while True:
                await self._balance()
                remaining_s = next_s - time.monotonic()
                if remaining_s <= 0.0:
                    break
                self._changed.clear()
                with contextlib.suppress(TimeoutError):
                    async with asyncio.timeout(remaining_s):
                        await self._changed.wait()
            if time.monotonic() - began_s > self._length_s:
                # This process stood still: what others wrote meanwhile has not been read yet.
                self._back()

    async def _announce(self) -> None:
        await self._broker.leases.put(f"{WORKER}{self._worker}", b"")

    async def _renew_held(self) -> None:
        await asyncio.gather(*(self._renew(one) for one in self.held))
        await asyncio.sleep(self._length_s / TURNS)

    async def _renew(self, partition: int) -> None:
        revision, key = self._held.get(partition), _key(partition)
        if revision is None:
            # Given back or lost since the turn began.
            return
        renewed: int | None
        try:
            renewed = await self._broker.leases.update(key, self._worker.encode(), last=revision)
        except KeyWrongLastSequenceError:
            renewed = await self._own_revision(key)
        if partition not in self._held:
            if renewed is not None:
                # Given back meanwhile: what was deleted then was an earlier revision, if anything.
                await self._ignoring(self._broker.leases.delete(key, last=renewed))
            return
        if renewed is None:
            logger.warning("the lease of partition %d is lost", partition)
            self._lose(partition)
        else:
            self._held[partition] = renewed

    async def _own_revision(self, key: str) -> int | None:
        """Return the revision of a lease that is ours all the same: the answer to a renewal may be lost."""
        try:
            entry = await self._broker.leases.get(key)
        except KeyNotFoundError:
            return None
        return entry.revision if entry.value == self._worker.encode() else None

    def _workers_seen(self) -> set[str]:
        return {key.removeprefix(WORKER) for key in self._seen if key.startswith(WORKER)}

    async def _reap(self, worker: str) -> None:
        """Free what a worker held that is gone."""
        found = [
            (key, one.revision)
            for key, one in self._seen.items()
            if one.value == worker.encode() or key == f"{WORKER}{worker}"
        ]
        # Somebody else may be faster.
        await asyncio.gather(
            *(self._ignoring(self._broker.leases.delete(key, last=revision)) for key, revision in found)
        )

    async def _balance(self) -> None:
        now_s = time.monotonic()
        old = {key for key, one in self._seen.items() if now_s - one.since_s > self._length_s}
        workers = {key for key in self._seen if key.startswith(WORKER)} - old | {f"{WORKER}{self._worker}"}
        partitions = self._broker.partitions
        rank = sorted(workers).index(f"{WORKER}{self._worker}")
        first, share = share_of(rank, len(workers), partitions)
        staying = self._held.keys() - self._leaving
        if len(staying) > share:
            ready = staying - self._moving.keys()
            if ready and not self._leaving:
                partition = max(ready)
                self._leaving.add(partition)
                self._move(partition, self._give_back(partition))
            return
        free = [
            partition
            for partition in ((first + number) % partitions for number in range(partitions))
            if partition not in self._held and (_key(partition) not in self._seen or _key(partition) in old)
        ]
        # Side by side: each waits for the broker and the database.
        await asyncio.gather(*(self._acquire(one) for one in free[: share - len(staying)]))

    def _move(self, partition: int, work: Coroutine[Any, Any, Any]) -> None:
        task = self._moving[partition] = asyncio.create_task(work, name=f"move partition {partition}")

        def moved(_: asyncio.Task[None]) -> None:
            del self._moving[partition]
            self._leaving.discard(partition)

        task.add_done_callback(moved)

    async def _acquire(self, partition: int) -> None:
        if partition in self._moving:
            return
        key, leases, name = _key(partition), self._broker.leases, self._worker.encode()
        known = self._seen.get(key)
        try:
            revision = await (
                leases.create(key, name) if known is None else leases.update(key, name, last=known.revision)
            )
        except KeyWrongLastSequenceError:
            return
        self._held[partition] = revision
        self._seen[key] = _Key(revision, time.monotonic(), name)
        self._move(partition, self._take(partition))

    async def _take(self, partition: int) -> None:
        try:
            await self._holder.take(partition)
        except Exception:
            logger.exception("partition %d could not be taken", partition)
            revision = self._held.get(partition)
            self._lose(partition)
            # The cause may last: others have their turn first.
            await asyncio.sleep(self._length_s / TURNS)
            # One that was lost meanwhile is another worker's by now.
            if revision is not None:
                await self._ignoring(self._broker.leases.delete(_key(partition), last=revision))
        else:
            if partition not in self._held:
                # Lost while it was being taken.
                self._holder.lose(partition)

    async def _give_back(self, partition: int) -> bool:
        """Return whether another worker has taken the partition before `TAKEN_S` were over."""
        taken = self._given[partition] = asyncio.Event()
        try:
            try:
                await self._holder.give_back(partition)
            except Exception:
                logger.exception("partition %d was not given back as it should be", partition)
            finally:
                revision = self._held.pop(partition, None)
                if revision is not None:
                    await self._ignoring(self._broker.leases.delete(_key(partition), last=revision))
            if revision is not None and self._workers_seen() - {self._worker}:
                with contextlib.suppress(TimeoutError):
                    async with asyncio.timeout(TAKEN_S):
                        await taken.wait()
            return taken.is_set()
        finally:
            self._given.pop(partition, None)

    async def _taken(self, message: Msg) -> None:
        """Hear that a worker has taken a partition, and that its sessions are taken up."""
        taken = self._given.get(int(message.subject.rsplit(".", 1)[1]))
        if taken is not None:
            taken.set()

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
