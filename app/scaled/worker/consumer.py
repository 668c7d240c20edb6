"""Delivery of a partition's stream to its sessions; nothing that was acknowledged is lost.

What comes for a session that is being opened waits for it. A session that is open and cannot be taken up at this
moment, because the database is away or its kernels are being compiled, is tried again, and what comes for it waits as
well: the stream forgets nothing of that (`StreamConsumer.taken`). Only what comes for a session that is closed, or not
there any more, is left out, and counted.
"""

import asyncio
import logging
import time
from dataclasses import dataclass, field
from functools import partial
from typing import Final

from sqlalchemy import Engine
from sqlalchemy.exc import DBAPIError
from sqlalchemy.exc import TimeoutError as PoolTimeout

from app.errors import Conflict, TelemotionError, Unavailable
from app.live import repository
from app.live.session.runner import LiveSession
from app.network.declaration import Declaration
from app.scaled.wire import Entry, HelloEntry, PacketEntry, Report, pack_error
from app.scaled.worker.connections import Connections
from app.scaled.worker.publisher import Publisher
from app.scaled.worker.senders import StreamSender
from app.scaled.worker.sessions import OfWorker, PartitionSessions
from estimators.sentences import say

logger = logging.getLogger(__name__)

AGAIN_S: Final = 0.2
MOST_WAITING: Final = 4096
"""Entries that wait for one session; then the stream is read no further."""


@dataclass
class _Opening:
    """A session that is being opened: what the stream has for it waits."""

    position: int
    entries: list[tuple[int, Entry]] = field(default_factory=list)

    @property
    def has_packets(self) -> bool:
        return any(isinstance(entry, PacketEntry) for _, entry in self.entries)


class StreamConsumer:
    """Gives what comes out of a partition's stream to its sessions; on the event loop's thread only.

    Parameters
    ----------
    engine : Engine
        Fenced.
    """

    def __init__(
        self,
        sessions: PartitionSessions,
        connections: Connections,
        publisher: Publisher,
        engine: Engine,
        shared: OfWorker,
    ) -> None:
        self._sessions, self._connections, self._publisher = sessions, connections, publisher
        self._engine, self._shared = engine, shared
        self._opening: dict[str, _Opening] = {}
        self._openers: set[asyncio.Task[None]] = set()
        self._senders: dict[str, StreamSender] = {}
        self._closed: set[str] = set()
        # Of the monotonic clock against that of arrivals; both in seconds.
        self._clock_offset_s = time.monotonic() - time.time()

    def take(self, sequence: int, entry: Entry) -> None:
        """Take what is at a place of the stream."""
        opening = self._opening.get(entry.session_id)
        if opening is not None:
            opening.entries.append((sequence, entry))
        elif isinstance(entry, PacketEntry):
            self._packet(sequence, entry)
        elif isinstance(entry, HelloEntry):
            self._open(sequence, entry.session_id, entry)
        else:
            # What came before it is taken.
            self._sessions.pooled.turn()
            self._connections.take(entry)

    def _packet(self, sequence: int, entry: PacketEntry) -> None:
        session = self._sessions.find(entry.session_id)
        if session is None:
            if entry.session_id in self._closed:
                self._shared.late_packets += 1
                return
            self._open(sequence, entry.session_id, None).entries.append((sequence, entry))
            return
        sender = self._senders.get(entry.session_id)
        if sender is None or sender.session is not session:
            refused = partial(self._connections.say, entry.session_id)
            sender = self._senders[entry.session_id] = StreamSender(session, refused)
        arrival_s = entry.arrival_ns * 1e-9 + self._clock_offset_s
        self._sessions.pooled.offer(sender, memoryview(entry.data), 0, arrival_s, entry.arrival_ns)

    def take_up(self, position: int, session_id: str) -> None:
        """Open a session of which nothing has been read; what comes for it waits."""
        self._open(position + 1, session_id, None)

    def _open(self, sequence: int, session_id: str, hello: HelloEntry | None) -> _Opening:
        opening = self._opening[session_id] = _Opening(sequence)
        self._closed.discard(session_id)
        task = asyncio.create_task(self._opened(session_id, hello, opening), name="open from stream")
        self._openers.add(task)
        task.add_done_callback(self._openers.discard)
        return opening

    async def _opened(self, session_id: str, hello: HelloEntry | None, opening: _Opening) -> None:
        try:
            session = await self._joined(session_id, hello, opening)
            if session is not None:
                self._sessions.pooled.turn()
                if hello is not None:
                    self._connections.open(session, hello)
        finally:
            del self._opening[session_id]
        for sequence, entry in opening.entries:
            self.take(sequence, entry)

    async def _joined(
        self, session_id: str, hello: HelloEntry | None, opening: _Opening
    ) -> LiveSession | None:
        """Return the live session; None when it cannot be opened, which its gateway hears."""
        is_said = False
        while True:
            error: TelemotionError
            try:
                stored = await asyncio.to_thread(repository.load, self._engine, session_id)
                declared = stored.hello if hello is None else hello.declaration
                if declared is None:
                    raise Conflict(say("live.not_connected"))
                # Packets that were acknowledged do not wait until there is room.
                is_admitted = hello is None or opening.has_packets
                return await self._sessions.join(
                    stored, Declaration.from_dict(declared), is_admitted=is_admitted
                )
            except Unavailable as found:
                error = found
            except TelemotionError as found:
                self._closed.add(session_id)
                self._refuse(hello, found)
                return None
            except (DBAPIError, PoolTimeout) as found:
                logger.warning("session %s waits for the database: %s", session_id, type(found).__name__)
                error = Unavailable(say("live.preparing"), retry_after_s=2)
            except Exception:
                logger.exception("session %s could not be opened", session_id)
                self._closed.add(session_id)
                self._refuse(hello, Unavailable(say("live.preparing"), retry_after_s=2))
                return None
            if hello is not None and not opening.has_packets:
                # Nothing of it is in the stream: its gateway comes again.
                self._refuse(hello, error)
                return None
            if not is_said:
                is_said = True
                logger.warning("session %s is opened later: %s", session_id, error.message)
            await asyncio.sleep(AGAIN_S)

    def _refuse(self, hello: HelloEntry | None, error: TelemotionError) -> None:
        if hello is not None:
            self._publisher.report(hello.edge, Report(hello.connection, "failed", error=pack_error(error)))

    @property
    def is_behind(self) -> bool:
        """Whether store or estimation of a session is behind: what comes should wait in the stream."""
        return any(one.held for one in self._senders.values()) or any(
            len(one.entries) > MOST_WAITING for one in self._opening.values()
        )

    @property
    def is_opening(self) -> bool:
        """Whether something waits for a session that is being opened."""
        return bool(self._opening)

    def taken(self, position: int) -> int:
        """Return up to where everything of the stream was given to its sessions, of what was read up to a position."""
        return min([position, *(one.position - 1 for one in self._opening.values())])

    def forget_ended(self) -> None:
        """Forget senders of sessions that are not live any more."""
        for gone in self._senders.keys() - {one.id for one in self._sessions.sessions}:
            del self._senders[gone]

    def close(self) -> None:
        """Open nothing more."""
        for opener in self._openers:
            opener.cancel()
