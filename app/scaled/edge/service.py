"""The live side of an edge: gateways' packets go into streams, views ask the worker that holds their session."""

import asyncio
from collections.abc import Sequence
from typing import Final

import nats
from sqlalchemy import Engine

from app.database.base import new_id
from app.errors import Conflict, Unavailable
from app.limits import Hold, Limits
from app.live import repository
from app.live.rights.authorization_checks import AuthorizationCheck
from app.live.rights.grace_period import GracePeriod
from app.live.service import LiveService
from app.live.session.states import OPEN
from app.live.session.stored import stored_layout, stored_state
from app.network.declaration import Declaration
from app.network.messages import HelloMessage
from app.scaled.broker import Broker
from app.scaled.edge.feed import FeedBus
from app.scaled.edge.intake import EdgeIntake
from app.scaled.edge.publisher import StreamPublisher
from app.scaled.wire import (
    Answer,
    HelloEntry,
    Look,
    Request,
    decode_answer,
    decode_published,
    encode,
    partition_of,
    subject,
    unpack_message,
)
from app.schemas import Schema
from estimators.sentences import say

WELCOME_S: Final = 20.0
LOOK_S: Final = 1.0
REQUEST_S: Final = 20.0
CLOSE_S: Final = 3.0


class EdgeLiveService(LiveService):
    """What sockets of an edge ask for.

    Parameters
    ----------
    confirmation_hours : float
        As of `LiveManager`.
    """

    def __init__(
        self, engine: Engine, broker: Broker, feed: FeedBus, limits: Limits, confirmation_hours: float
    ) -> None:
        super().__init__(engine, feed)
        self._broker, self._feed, self._limits = broker, feed, limits
        self._confirmation_hours = confirmation_hours
        self._publishers = [StreamPublisher(broker, number) for number in range(broker.partitions)]
        self._holds: dict[str, Hold] = {}
        self._is_stopping = False

    @property
    def session_count(self) -> int:
        """Sessions whose gateways are connected here."""
        return len(self._feed.intakes)

    async def stop(self) -> None:
        """Send gateways to another edge, and what they brought into the streams."""
        self._is_stopping = True
        for intake in list(self._feed.intakes.values()):
            intake.end(Unavailable(say("live.stopping"), reason="stopping"))
        await asyncio.gather(*(one.close(CLOSE_S) for one in self._publishers))
        self.end_checks()

    def _partition(self, session_id: str) -> int:
        return partition_of(session_id, self._broker.partitions)

    async def open(self, hello: HelloMessage, declaration: Declaration) -> EdgeIntake:
        """Let a gateway in once the worker that holds its session has opened it; raises typed errors."""
        if self._is_stopping:
            raise Unavailable(say("live.stopping"), retry_after_s=5)
        who, stored = await asyncio.to_thread(
            repository.open_by_ticket, self.engine, hello.ticket, self._confirmation_hours
        )
        if stored.state not in OPEN or stored.is_ended:
            raise Conflict(say("live.closed"), state=stored.state)
        right = AuthorizationCheck(who, stored.id, "record")
        patience = GracePeriod()

        async def check_right() -> None:
            await patience.wait(self.check_right(right))

        publisher, connection = self._publishers[self._partition(stored.id)], new_id()
        intake = EdgeIntake(stored.id, connection, declaration, publisher, check_right, self._detach)
        self._holds[connection] = self._limits.take("streams", who)
        self._feed.intakes[connection] = intake
        try:
            publisher.put(HelloEntry(stored.id, connection, self._feed.edge, declaration.to_dict()))
            async with asyncio.timeout(WELCOME_S):
                await intake.is_welcome.wait()
            if intake.ended.is_set():
                raise intake.end_error
        except TimeoutError as error:
            intake.detach()
            raise Unavailable(say("scaled.moving"), retry_after_s=1, reason="moving") from error
        except BaseException:
            intake.detach()
            raise
        return intake

    def _detach(self, intake: EdgeIntake) -> None:
        self._feed.intakes.pop(intake.connection, None)
        hold = self._holds.pop(intake.connection, None)
        if hold is not None:
            hold.release()

    async def first_messages(self, stored: repository.StoredSession) -> Sequence[Schema]:
        """Return what a view receives when it connects: of the session's worker, else what is stored."""
        try:
            answer = await self._question(stored.id, Look(self._feed.edge, stored.id), LOOK_S)
        except nats.errors.Error:
            # The partition is on its way to another worker; what comes next is said on the bus.
            layout = await asyncio.to_thread(stored_layout, stored)
            return [layout, stored_state(stored)]
        return [unpack_message(one) for one in decode_published(answer)]

    async def ask(self, session_id: str, request: Request) -> Answer:
        """Let the worker that holds a session answer a request.

        Raises
        ------
        Unavailable
            Nobody holds its partition at this moment.
        """
        try:
            answer = await self._question(session_id, request, REQUEST_S)
        except nats.errors.Error as error:
            raise Unavailable(say("scaled.moving"), retry_after_s=1, reason="moving") from error
        return decode_answer(answer)

    async def _question(self, session_id: str, question: Look | Request, patience_s: float) -> bytes:
        """Return what whoever holds a session's partition answers."""
        name = subject("ask", self._partition(session_id))
        asked = self._broker.seal.close(name, encode(question))
        answer: bytes = (await self._broker.client.request(name, asked, timeout=patience_s)).data
        return answer
