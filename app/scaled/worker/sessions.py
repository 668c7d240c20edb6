"""The live sessions of one partition: the manager of a service in one process, on what a worker's partitions share."""

import asyncio
import contextlib
import logging
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, replace
from typing import Final

from sqlalchemy import Engine

from app.errors import TelemotionError, Unavailable
from app.limits import Limits
from app.live import repository
from app.live.bus import MemoryBus
from app.live.engine.shared import Shared
from app.live.manager import LiveManager
from app.live.messages import StateMessage
from app.live.repository import StoredSession
from app.live.session.opening import Place
from app.live.session.runner import LiveSession
from app.network.declaration import Declaration
from app.recordings.signals.group_commit import GroupCommitWriter
from app.scaled.takeover import read_streamed
from app.scaled.wire import partition_of
from app.scaled.worker.preparing import Preparation
from app.settings import Settings

logger = logging.getLogger(__name__)

AT_ONCE: Final = 2
"""Sessions that are taken up at the same time after a partition was taken. More threads of Python make it no sooner,
and the event loop, for which the other partitions and those who watch wait, has its turn more rarely."""


@dataclass(kw_only=True)
class OfWorker(Shared):
    """What the partitions of a worker have in common."""

    settings: Settings
    limits: Limits
    ahead: Preparation | None = None
    late_packets: int = 0
    refused_messages: int = 0
    """Of the streams, that no edge of this service has sent."""
    """Packets that came out of the stream after their session was closed."""


class PartitionSessions(LiveManager):
    """The live sessions of one partition.

    Parameters
    ----------
    engine : Engine
        Fenced.
    writer : GroupCommitWriter
        Started, on the same engine.
    on_closed : callable(session_id)
    drain : async callable(session_id)
        Returns when everything that edges have taken of a session is read.
    """

    def __init__(
        self,
        engine: Engine,
        writer: GroupCommitWriter,
        bus: MemoryBus,
        on_closed: Callable[[str], None],
        drain: Callable[[str], Awaitable[None]],
        shared: OfWorker,
    ) -> None:
        settings = shared.settings
        super().__init__(
            engine,
            writer,
            bus,
            on_closed,
            limits=shared.limits,
            longest_s=settings.session_limit_hours * 3600.0,
            place=Place(settings.hemisphere, settings.time_zone),
            confirmation_hours=settings.implant_confirmation_hours,
            shared=shared,
        )
        self._opener = replace(self._opener, is_exact=True)
        self._drain, self._ahead = drain, shared.ahead
        self._draining: dict[str, asyncio.Task[None]] = {}

    async def close(self, session_id: str, reason: str) -> StateMessage:
        """Close a session once all is read that was acknowledged to its gateway."""
        draining = self._draining.get(session_id)
        if draining is None:
            draining = asyncio.create_task(self._drained(session_id), name="drain session")
            self._draining[session_id] = draining
            draining.add_done_callback(lambda _: self._draining.pop(session_id, None))
        await asyncio.shield(draining)
        return await super().close(session_id, reason)

    async def _drained(self, session_id: str) -> None:
        if session_id not in self._closing:
            await self._drain(session_id)

    async def begin(self, partition: int, partitions: int) -> list[str]:
        """Take up the partition's sessions where what is stored of them ends, then look after them.

        Returns
        -------
        list of str
            Sessions that are open and could not be taken up at this moment.
        """
        self._loop = asyncio.get_running_loop()
        open_ones, closing = await asyncio.to_thread(
            repository.unfinished, self.engine, lambda one: partition_of(one, partitions) == partition
        )
        for session_id in closing:
            await asyncio.to_thread(self._on_closed, session_id)
        streamed = await asyncio.to_thread(read_streamed, self.engine, open_ones)
        if self._ahead is not None:
            streamed = self._ahead.put_into(streamed)
        turn, later = asyncio.Semaphore(AT_ONCE), []

        async def take_up(stored: StoredSession) -> None:
            async with turn:
                try:
                    declared = Declaration.from_dict(stored.hello or {})
                    await self.join(stored, declared, streamed=streamed.get(stored.id))
                except Unavailable as error:
                    logger.warning("session %s is taken up later: %s", stored.id, error.message)
                    later.append(stored.id)
                except TelemotionError as error:
                    logger.error("session %s could not be taken up: %s", stored.id, error.message)
                    self._housekeeping.abandoned(stored.id)

        await asyncio.gather(*(take_up(stored) for stored in open_ones))
        self._housekeeper = asyncio.create_task(self._housekeeping.run(), name="live housekeeping")
        return later

    def behind(self, is_behind: Callable[[], bool]) -> None:
        """Have nobody taken for silent while packets that have arrived are still to be read."""
        self._housekeeping.is_behind = lambda: is_behind() or self.pooled.is_behind

    def _note_where(self, session: LiveSession, *, is_last: bool = False) -> None:
        # Checkpoints are stored with the position of the stream.
        pass

    async def closed(self) -> None:
        """Wait until the sessions that are being closed are."""
        await asyncio.gather(*self._closing.values(), return_exceptions=True)

    def leave(self) -> None:
        """Let every session go as it stands; whoever holds the partition next goes on."""
        self._is_stopping = True
        for task in (self._housekeeper, *self._draining.values(), *self._closing.values(), *self._tasks):
            if task is not None:
                task.cancel()
        self.pooled.turn()
        for session in self.sessions:
            # Nothing that comes after this may reach the sessions that share the pool.
            session.line.is_running = False
            if session.lane is not None:
                with contextlib.suppress(TelemotionError):
                    session.lane.leave()
        self._sessions.clear()
        self.end_checks()
