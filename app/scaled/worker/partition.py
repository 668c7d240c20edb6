"""One partition while this worker holds it: its stream goes to its sessions, and how far it is stored is noted."""

import asyncio
import logging
import time
from collections.abc import Awaitable, Callable, Iterable
from typing import Final

import msgspec
import nats
from nats.aio.msg import Msg
from nats.aio.subscription import Subscription
from nats.js.errors import Error as StreamError
from sqlalchemy import Engine
from sqlalchemy.exc import SQLAlchemyError

from app.database.unit_of_work import unit_of_work
from app.errors import TelemotionError
from app.live.bus import MemoryBus
from app.live.session.checkpoint import pack
from app.live.session.marks import Marks
from app.recordings.service import queue_closing
from app.recordings.signals.group_commit import GroupCommitWriter
from app.scaled.broker import Broker, stream_name
from app.scaled.checkpoints import save
from app.scaled.fencing import Fence, fenced, take_over
from app.scaled.wire import Answer, Entry, NotSealed, Request, decode_entries, subject
from app.scaled.worker.authorization_checks import AuthorizationChecks
from app.scaled.worker.cancellation import end
from app.scaled.worker.connections import Connections
from app.scaled.worker.consumer import StreamConsumer
from app.scaled.worker.publisher import Publisher
from app.scaled.worker.reader import read
from app.scaled.worker.sender import EdgeSender
from app.scaled.worker.sessions import OfWorker, PartitionSessions

logger = logging.getLogger(__name__)

CHECKPOINT_S: Final = 2.0
MARK_S: Final = 3.0
"""Of a session, with every other commit of what came: at most four seconds are estimated again of one that moves."""
COMMIT_S: Final = 0.5
"""Longest time until an event is stored. Packets and frames are stored at checkpoints, all sessions in one commit: they
are acknowledged already, and a commit costs as much for one session as for ten."""
TURN_S: Final = 0.25
SOURCE_TURNS: Final = 20
"""Turns from one look at the safety of magnetic sources to the next."""
BEHIND_S: Final = 0.05
DRAIN_S: Final = 3.0
"""A session is closed after so long, also when the end of the stream was not reached."""

Ask = Callable[[Request], Awaitable[Answer]]


class Partition:
    """A partition that is held.

    Parameters
    ----------
    engine : Engine
        Of this worker, not fenced.
    worker : str
        Name of the worker's connections to the database.
    refused : callable()
        Called on the event loop when the database says that another holds the partition; no more once this one has
        ended, for the same worker may hold the partition again by then.
    ask : async callable
        Answers HTTP requests.
    """

    def __init__(
        self,
        number: int,
        broker: Broker,
        engine: Engine,
        shared: OfWorker,
        post: EdgeSender,
        worker: str,
        refused: Callable[[], None],
        ask: Ask,
    ) -> None:
        self.number, self._broker, self._engine, self._shared = number, broker, engine, shared
        self._post, self._worker, self._refused, self._ask = post, worker, refused, ask
        self.sessions: PartitionSessions
        self.position = 0
        """Of the stream, read."""
        self.waiting = 0
        """Messages of the stream behind it."""
        self._tasks: list[asyncio.Task[None]] = []
        self._subscriptions: list[Subscription] = []
        self._marks = Marks(MARK_S)
        self._is_set_up = False
        self._has_ended = False

    async def take(self) -> None:
        """Fence earlier holders off, take up the sessions, and read on where they end."""
        loop = asyncio.get_running_loop()
        fencing, stored = await asyncio.to_thread(take_over, self._engine, self.number, self._worker)

        def refused() -> None:
            loop.call_soon_threadsafe(self._fenced_off)

        engine = self._fenced = fenced(self._engine, Fence(self.number, fencing, refused))
        self._writer = GroupCommitWriter(engine, commit_interval_s=COMMIT_S, chunk_s=2.0 * CHECKPOINT_S)
        self._writer.start()
        bus = MemoryBus()

        def analyse(session_id: str) -> None:
            with unit_of_work(engine) as session:
                queue_closing(session, session_id)

        self.sessions = PartitionSessions(engine, self._writer, bus, analyse, self._drain, self._shared)
        self._publisher = Publisher(self._post, bus, self.number, fencing)
        self.connections = Connections(self.sessions, self._publisher)
        self._entries = StreamConsumer(self.sessions, self.connections, self._publisher, engine, self._shared)
        self._is_set_up = True
        later = await self.sessions.begin(self.number, self._broker.partitions)
        info = await self._broker.streams.stream_info(stream_name(self.number))
        # A stream that was made again begins at one: all of it is unread.
        self.position = self._stored = stored if stored <= info.state.last_seq else 0
        self.waiting = info.state.last_seq - self.position
        self.sessions.behind(lambda: self.waiting > 0 or self._entries.is_opening)
        for session_id in later:
            self._entries.take_up(self.position, session_id)
        questions = AuthorizationChecks(
            self.sessions, self._publisher, self.connections, self._ask, self._broker.seal
        )
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
        try:
            await end(self._tasks)
            await self.sessions.closed()
            await self._checkpoint(is_last=True)
        except (TelemotionError, SQLAlchemyError, nats.errors.Error, StreamError, TimeoutError) as error:
            logger.warning("partition %d: not stored at the end: %s", self.number, type(error).__name__)
        finally:
            self._end()
            await asyncio.to_thread(self._writer.close)
        logger.info("partition %d was given back at %d", self.number, self._stored)

    def lose(self) -> None:
        """Stop at once; nothing that this partition still wants to write is written."""
        for task in self._tasks:
            task.cancel()
        self._end()
        asyncio.get_running_loop().run_in_executor(None, self._writer.close)

    def abandon(self) -> None:
        """Leave nothing behind of a partition that could not be taken."""
        if self._is_set_up:
            self.lose()

    def _fenced_off(self) -> None:
        if not self._has_ended:
            self._refused()

    def _end(self) -> None:
        self._has_ended = True
        self._entries.close()
        self.connections.close()
        self.sessions.leave()
        self._publisher.close()
        closing = [one.unsubscribe() for one in self._subscriptions]
        self._unsubscribing = asyncio.ensure_future(_all(closing))

    # --- the stream ---------------------------------------------------------------------------------------

    async def _read(self) -> None:
        async for sequence, data, waiting in read(self._broker, self.number, self.position):
            for entry in self._opened(data):
                self._entries.take(sequence, entry)
            self.position, self.waiting = sequence, waiting
            while self._entries.is_behind:  # noqa: ASYNC110 - rare, and soon over
                await asyncio.sleep(BEHIND_S)

    def _opened(self, data: bytes) -> list[Entry]:
        """Return what a message of the stream holds; nothing of one that no edge of this service has sent."""
        try:
            return decode_entries(self._broker.seal.open(subject("in", self.number), data))
        except (NotSealed, msgspec.MsgspecError):
            self._shared.refused_messages += 1
            logger.warning("partition %d: a message of the stream is not from an edge; left out", self.number)
            return []

    async def _drain(self, session_id: str) -> None:
        """Return when all is read that edges have taken of a session; its gateway is not listened to any more."""
        if await self.connections.stop(session_id):
            return
        try:
            # Nobody is connected, or its edge has ended: what it took lies in the stream by now.
            info = await self._broker.streams.stream_info(stream_name(self.number))
            async with asyncio.timeout(DRAIN_S):
                while self.position < info.state.last_seq:  # noqa: ASYNC110 - short, and before a session is closed
                    await asyncio.sleep(BEHIND_S)
        except (nats.errors.Error, StreamError, TimeoutError) as error:
            logger.warning("session %s is closed before all is read: %s", session_id, type(error).__name__)

    # --- looking after it -----------------------------------------------------------------------------------

    async def _look_after(self) -> None:
        turn, next_s = 0, time.monotonic() + CHECKPOINT_S
        while True:
            await asyncio.sleep(TURN_S)
            turn += 1
            try:
                await self.connections.report()
                self._entries.forget_ended()
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

    async def _checkpoint(self, *, is_last: bool = False) -> None:
        """Commit everything up to where the stream was taken, then say so, then forget that part of the stream."""
        self.sessions.pooled.turn()
        # Asked after the turn: packets that a session could not take in it are not stored yet.
        if self._entries.is_behind:
            return
        position = self._entries.taken(self.position)
        if position <= self._stored:
            return
        sessions = self.sessions.sessions
        for session in sessions:
            session.settle()
        due = {one: self._marks.due(one, is_forced=is_last) for one in sessions}
        states = {one: state for one, state in due.items() if state is not None}
        flushed = [self._writer.flush(one.id) for one in sessions if not one.has_store_failed]
        await asyncio.gather(*map(asyncio.wrap_future, flushed))
        for session in sessions:
            await session.saved()
        packed = await asyncio.to_thread(lambda: {one.id: pack(state) for one, state in states.items()})
        await asyncio.to_thread(save, self._fenced, self.number, position, packed)
        for session in states:
            self._marks.stored(session)
        self._stored = position
        await self._broker.streams.purge_stream(stream_name(self.number), seq=position + 1)

    async def _analysed(self, message: Msg) -> None:
        self.sessions.task_done(message.data.decode())


async def _all(works: Iterable[Awaitable[None]]) -> None:
    await asyncio.gather(*works, return_exceptions=True)
