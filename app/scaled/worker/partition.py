"""One partition while this worker holds it: its stream goes to its sessions, and how far it is stored is noted."""

import asyncio
import logging
import time
from collections.abc import Awaitable, Callable, Iterable
from dataclasses import dataclass, field
from functools import partial
from typing import Final

import nats
from nats.aio.msg import Msg
from nats.aio.subscription import Subscription
from nats.js.errors import Error as StreamError
from sqlalchemy import Engine

from app.database.unit_of_work import unit_of_work
from app.errors import TelemotionError, Unavailable
from app.live import repository
from app.live.bus import MemoryBus
from app.network.declaration import Declaration
from app.recordings.service import queue_closing
from app.recordings.signals.group_commit import GroupCommitWriter
from app.scaled.broker import Broker, stream_name
from app.scaled.fencing import Fence, fenced, save_position, take_over
from app.scaled.wire import (
    Answer,
    Entry,
    HelloEntry,
    PacketEntry,
    Report,
    Request,
    decode_entries,
    pack_error,
    subject,
)
from app.scaled.worker.connections import Connections
from app.scaled.worker.outlet import Outlet
from app.scaled.worker.questions import Questions
from app.scaled.worker.reader import read
from app.scaled.worker.senders import StreamSender
from app.scaled.worker.sessions import OfWorker, PartitionSessions
from app.sentences import say

logger = logging.getLogger(__name__)

CHECKPOINT_S: Final = 2.0
TURN_S: Final = 0.25
SOURCE_TURNS: Final = 20
"""Turns from one look at the safety of magnetic sources to the next."""
BEHIND_S: Final = 0.05

Ask = Callable[[Request], Awaitable[Answer]]


@dataclass
class _Opening:
    """A session that is being opened: what the stream has for it waits."""

    position: int
    entries: list[tuple[int, Entry]] = field(default_factory=list)


class Partition:
    """A partition that is held.

    Parameters
    ----------
    number : int
    broker : Broker
    engine : Engine
        Of this worker, not fenced.
    shared : OfWorker
    worker : str
        Name of the worker's connections to the database.
    refused : callable()
        Called on the event loop when the database says that another holds the partition.
    ask : async callable
        Answers HTTP requests.
    """

    def __init__(
        self,
        number: int,
        broker: Broker,
        engine: Engine,
        shared: OfWorker,
        worker: str,
        refused: Callable[[], None],
        ask: Ask,
    ) -> None:
        self.number, self._broker, self._engine, self._shared = number, broker, engine, shared
        self._worker, self._refused, self._ask = worker, refused, ask
        self.sessions: PartitionSessions
        self.position = 0
        """Of the stream, taken."""
        self.waiting = 0
        """Messages of the stream behind it."""
        self._opening: dict[str, _Opening] = {}
        self._senders: dict[str, StreamSender] = {}
        self._tasks: list[asyncio.Task[None]] = []
        self._openers: set[asyncio.Task[None]] = set()
        self._subscriptions: list[Subscription] = []
        # Of the monotonic clock against that of arrivals; both in seconds.
        self._clock_offset_s = time.monotonic() - time.time()

    async def take(self) -> None:
        """Fence earlier holders off, take up the sessions, and read on where they end."""
        loop = asyncio.get_running_loop()
        fencing, stored = await asyncio.to_thread(take_over, self._engine, self.number, self._worker)

        def refused() -> None:
            loop.call_soon_threadsafe(self._refused)

        engine = self._fenced = fenced(self._engine, Fence(self.number, fencing, refused))
        self._writer = GroupCommitWriter(engine)
        self._writer.start()
        bus = MemoryBus()

        def analyse(session_id: str) -> None:
            with unit_of_work(engine) as session:
                queue_closing(session, session_id)

        self.sessions = PartitionSessions(engine, self._writer, bus, analyse, self._shared)
        self._outlet = Outlet(self._broker, bus, self.number, fencing)
        self.connections = Connections(self.sessions, self._outlet)
        await self.sessions.begin(self.number, self._broker.partitions)
        info = await self._broker.streams.stream_info(stream_name(self.number))
        # A stream that was made anew begins at one: all of it is unread.
        self.position = self._stored = stored if stored <= info.state.last_seq else 0
        questions = Questions(self.sessions, self._outlet, self.connections, self._ask)
        client = self._broker.client
        for name, answer in (("ask", questions.ask), ("here", questions.hear), ("done", self._analysed)):
            self._subscriptions.append(await client.subscribe(subject(name, self.number), cb=answer))
        await client.publish(subject("taken", self.number))
        self._tasks = [
            asyncio.create_task(self._read(), name=f"partition {self.number}"),
            asyncio.create_task(self._look_after(), name=f"partition {self.number} looks"),
        ]
        logger.info("partition %d is held here, from %d on", self.number, self.position)

    async def give_back(self) -> None:
        """Read no more, store everything, and say how far that is."""
        await self._stop_reading()
        await self.sessions.closed()
        try:
            await self._checkpoint()
        except (TelemotionError, nats.errors.Error, StreamError) as error:
            logger.warning("partition %d: not stored at the end: %s", self.number, type(error).__name__)
        self._end()
        await asyncio.to_thread(self._writer.close)
        logger.info("partition %d was given back at %d", self.number, self._stored)

    def lose(self) -> None:
        """Stop at once; nothing that this partition still wants to write is written."""
        for task in self._tasks:
            task.cancel()
        self._end()
        asyncio.get_running_loop().run_in_executor(None, self._writer.close)

    def _end(self) -> None:
        for opener in self._openers:
            opener.cancel()
        self.connections.close()
        self.sessions.leave()
        self._outlet.close()
        closing = [one.unsubscribe() for one in self._subscriptions]
        self._openers.add(asyncio.ensure_future(_all(closing)))

    async def _stop_reading(self) -> None:
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)

    # --- the stream ---------------------------------------------------------------------------------------

    async def _read(self) -> None:
        async for sequence, data, waiting in read(self._broker, self.number, self.position):
            for entry in decode_entries(data):
                self._take(sequence, entry)
            self.position, self.waiting = sequence, waiting
            while any(one.held for one in self._senders.values()):  # noqa: ASYNC110 - rare, and soon over
                # Store or estimation of a session is behind: what comes waits in the stream.
                await asyncio.sleep(BEHIND_S)

    def _take(self, sequence: int, entry: Entry) -> None:
        opening = self._opening.get(entry.session_id)
        if opening is not None:
            opening.entries.append((sequence, entry))
        elif isinstance(entry, PacketEntry):
            self._packet(entry)
        elif isinstance(entry, HelloEntry):
            self._opening[entry.session_id] = _Opening(sequence)
            task = asyncio.create_task(self._open(entry), name="open from stream")
            self._openers.add(task)
            task.add_done_callback(self._openers.discard)
        else:
            # What came before it is taken.
            self.sessions.pooled.turn()
            self.connections.take(entry)

    def _packet(self, entry: PacketEntry) -> None:
        session = self.sessions.find(entry.session_id)
        if session is None:
            return
        sender = self._senders.get(entry.session_id)
        if sender is None or sender.session is not session:
            refused = partial(self.connections.say, entry.session_id)
            sender = self._senders[entry.session_id] = StreamSender(session, refused)
        arrival_s = entry.arrival_ns * 1e-9 + self._clock_offset_s
        self.sessions.pooled.offer(sender, memoryview(entry.data), 0, arrival_s, entry.arrival_ns)

    async def _open(self, hello: HelloEntry) -> None:
        try:
            stored = await asyncio.to_thread(repository.load, self._fenced, hello.session_id)
            session = await self.sessions.join(stored, Declaration.from_dict(hello.declaration))
            self.sessions.pooled.turn()
            self.connections.open(session, hello)
        except TelemotionError as error:
            self._outlet.report(hello.edge, Report(hello.connection, "failed", error=pack_error(error)))
        except Exception:
            logger.exception("session %s could not be opened", hello.session_id)
            wrong = Unavailable(say("live.preparing"), retry_after_s=2)
            self._outlet.report(hello.edge, Report(hello.connection, "failed", error=pack_error(wrong)))
        finally:
            opening = self._opening.pop(hello.session_id)
            for sequence, entry in opening.entries:
                self._take(sequence, entry)

    # --- looking after it -----------------------------------------------------------------------------------

    async def _look_after(self) -> None:
        turn, next_s = 0, time.monotonic() + CHECKPOINT_S
        while True:
            await asyncio.sleep(TURN_S)
            turn += 1
            try:
                await self.connections.report()
                for gone in self._senders.keys() - {one.id for one in self.sessions.sessions}:
                    del self._senders[gone]
                if turn % SOURCE_TURNS == 0:
                    for session in self.sessions.sessions:
                        await self.sessions.check_source(session.id)
                if time.monotonic() > next_s:
                    next_s = time.monotonic() + CHECKPOINT_S
                    await self._checkpoint()
            except (TelemotionError, nats.errors.Error, StreamError, TimeoutError) as error:
                logger.warning("partition %d: %s", self.number, type(error).__name__)
            except Exception:
                logger.exception("partition %d stumbled; it goes on", self.number)

    async def _checkpoint(self) -> None:
        """Commit everything up to where the stream was taken, then say so, then forget that part of the stream."""
        if any(sender.held for sender in self._senders.values()):
            return
        self.sessions.pooled.turn()
        position = min([self.position, *(one.position - 1 for one in self._opening.values())])
        if position <= self._stored:
            return
        flushed = []
        for session in self.sessions.sessions:
            session.settle()
            if not session.has_store_failed:
                flushed.append(asyncio.wrap_future(self._writer.flush(session.id)))
        await asyncio.gather(*flushed)
        for session in self.sessions.sessions:
            await session.saved()
        await asyncio.to_thread(save_position, self._fenced, self.number, position)
        self._stored = position
        await self._broker.streams.purge_stream(stream_name(self.number), seq=position + 1)

    async def _analysed(self, message: Msg) -> None:
        self.sessions.task_done(message.data.decode())


async def _all(works: Iterable[Awaitable[None]]) -> None:
    await asyncio.gather(*works, return_exceptions=True)


__all__ = ["Ask", "Partition"]
