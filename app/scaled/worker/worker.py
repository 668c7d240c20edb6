"""A worker: the partitions that it holds, and the live side that their sessions make together."""

import asyncio
import contextlib
import logging
from collections.abc import Sequence
from functools import partial
from typing import Final

import nats
from nats.js.errors import Error as StreamError
from sqlalchemy import Engine

from app.errors import Conflict, Unavailable
from app.live import repository
from app.live.bus import MemoryBus
from app.live.guidance.controller import GuidanceController
from app.live.messages import StateMessage
from app.live.service import SteeredLiveService
from app.live.session.intake import Intake
from app.live.session.runner import LiveSession
from app.network.declaration import Declaration
from app.network.messages import HelloMessage
from app.scaled.broker import Broker
from app.scaled.placement import share_of
from app.scaled.wire import partition_of
from app.scaled.worker.cancellation import end
from app.scaled.worker.leases import Leases
from app.scaled.worker.partition import Ask, Partition
from app.scaled.worker.preparing import Preparation
from app.scaled.worker.presence import others_of
from app.scaled.worker.sender import EdgeSender
from app.scaled.worker.sessions import OfWorker, PartitionSessions
from app.schemas import Schema
from estimators.sentences import say

logger = logging.getLogger(__name__)

LOOK_S: Final = 0.5


class Worker(SteeredLiveService):
    """Holds partitions; steering finds the sessions of them here. Implements `app.scaled.worker.leases.Holder`.

    Parameters
    ----------
    engine : Engine
        With `app.scaled.fencing.install`; its connections are named `name`.
    """

    def __init__(self, broker: Broker, engine: Engine, shared: OfWorker, name: str) -> None:
        super().__init__(engine, MemoryBus())
        self._broker, self._shared, self._name = broker, shared, name
        self._post = EdgeSender(broker)
        self._ask: Ask | None = None
        self.partitions: dict[int, Partition] = {}
        self.leases = Leases(broker, name, self, shared.settings.lease_seconds)
        shared.ahead = self.ahead = Preparation(
            engine, shared.readiness, lambda one: partition_of(one, broker.partitions) in self.leases.held
        )
        self._others: set[str] = set()
        self._tasks: list[asyncio.Task[None]] = []

    async def look_for_others(self) -> None:
        """Find the workers that show the sessions: while there are some, `start` first estimates ahead what it can."""
        try:
            self._others = await others_of(self._broker, self._name)
        except (nats.errors.Error, StreamError, OSError, TimeoutError) as error:
            logger.warning("no other worker is known: %s", type(error).__name__)
        self.ahead.is_waited_for = bool(self._others)

    async def start(self, ask: Ask) -> None:
        """Begin to hold partitions; requests of edges are answered by `ask`."""
        self._ask = ask
        self._post.start()
        self._tasks = [asyncio.create_task(self._begin(), name="worker begins")]

    async def _begin(self) -> None:
        try:
            await self._estimate_ahead()
        except Exception:
            logger.exception("nothing could be estimated ahead")
        while True:
            try:
                await self.leases.start()
                break
            except (nats.errors.Error, StreamError, OSError, TimeoutError) as error:
                logger.error("no partition can be taken yet: %s", type(error).__name__)
                await asyncio.sleep(LOOK_S)
        self.ahead.is_waited_for = False
        await self.ahead.run()

    async def _estimate_ahead(self) -> None:
        """Wait for what is estimated ahead, while others show what this worker is about to take."""
        partitions, others = self._broker.partitions, self._others
        if not others:
            return
        rank = sorted([*others, self._name]).index(self._name)
        first, share = share_of(rank, len(others) + 1, partitions)
        self.ahead.comes_soon = lambda one: first <= partition_of(one, partitions) < first + share
        tasks = [asyncio.create_task(self.ahead.short()), asyncio.create_task(self._until_one_goes(others))]
        try:
            await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        finally:
            await end(tasks)

    async def _until_one_goes(self, others: set[str]) -> None:
        there = others
        while others <= there:
            await asyncio.sleep(LOOK_S)
            # While the broker is away nobody is known to have gone.
            with contextlib.suppress(nats.errors.Error, StreamError, OSError, TimeoutError):
                there = await others_of(self._broker, self._name)
        logger.warning("a worker has gone: what it held is taken at once")

    async def stop(self) -> None:
        """Give every partition back."""
        await end(self._tasks)
        await self.leases.stop()
        self._post.stop()
        self.end_checks()

    async def take(self, partition: int) -> None:
        """Begin to hold a partition."""
        assert self._ask is not None
        refused = partial(self.leases.fenced, partition)
        held = Partition(
            partition, self._broker, self.engine, self._shared, self._post, self._name, refused, self._ask
        )
        try:
            await held.take()
        except BaseException:
            held.abandon()
            raise
        self.partitions[partition] = held

    async def give_back(self, partition: int) -> None:
        """Store what is known of a partition, for whoever takes it next."""
        held = self.partitions.pop(partition, None)
        if held is not None:
            await held.give_back()

    def lose(self, partition: int) -> None:
        """Stop at once: somebody else holds the partition by now."""
        held = self.partitions.pop(partition, None)
        if held is not None:
            held.lose()

    def _sessions_of(self, session_id: str) -> PartitionSessions:
        held = self.partitions.get(partition_of(session_id, self._broker.partitions))
        if held is None:
            raise Unavailable(say("scaled.moving"), retry_after_s=1, reason="moving")
        return held.sessions

    @property
    def sessions(self) -> list[LiveSession]:
        """Every session that is live here."""
        return [one for held in self.partitions.values() for one in held.sessions.sessions]

    @property
    def session_count(self) -> int:
        """How many sessions are live here."""
        return sum(held.sessions.session_count for held in self.partitions.values())

    async def open(self, hello: HelloMessage, declaration: Declaration) -> Intake:
        """Send a gateway away: it connects to an edge."""
        raise Conflict(say("scaled.no_gateways_here"))

    async def first_messages(self, stored: repository.StoredSession) -> Sequence[Schema]:
        """Return what a view receives when it connects."""
        return await self._sessions_of(stored.id).first_messages(stored)

    def live(self, session_id: str) -> LiveSession:
        """Return a live session."""
        return self._sessions_of(session_id).live(session_id)

    def guidance(self, session_id: str) -> GuidanceController:
        """Return the guidance of a live session."""
        return self._sessions_of(session_id).guidance(session_id)

    async def state(self, session_id: str) -> StateMessage:
        """Return the state of any session, live or not."""
        return await self._sessions_of(session_id).state(session_id)

    async def close(self, session_id: str, reason: str) -> StateMessage:
        """Close a session."""
        return await self._sessions_of(session_id).close(session_id, reason)

    async def reopen(self, session_id: str) -> StateMessage:
        """Let a session that has ended take more packets."""
        return await self._sessions_of(session_id).reopen(session_id)

    async def check_source(self, session_id: str) -> None:
        """Let the source of a session fire only while it is confirmed to be safe."""
        await self._sessions_of(session_id).check_source(session_id)
