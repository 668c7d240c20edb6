"""Requests of edges to the holder of a partition: a view's first messages, and requests that steer a session."""

import asyncio
import logging
from collections.abc import Awaitable, Callable

from nats.aio.msg import Msg

from app.errors import TelemotionError
from app.live import repository
from app.live.bus import topic
from app.scaled.wire import (
    Answer,
    Look,
    NotSealed,
    Request,
    Seal,
    decode_here,
    decode_question,
    encode,
    pack_message,
)
from app.scaled.worker.connections import Connections
from app.scaled.worker.publisher import Publisher
from app.scaled.worker.sessions import PartitionSessions

logger = logging.getLogger(__name__)

_VIEW = ("layout", "state", "health", "event", "calibration", "guidance", "blocks")


class AuthorizationChecks:
    """Answers what is asked of a partition.

    Parameters
    ----------
    answer : async callable(Request)
    seal : Seal
        Of what edges send.
    """

    def __init__(
        self,
        sessions: PartitionSessions,
        publisher: Publisher,
        connections: Connections,
        answer: Callable[[Request], Awaitable[Answer]],
        seal: Seal,
    ) -> None:
        self._sessions, self._publisher, self._connections = sessions, publisher, connections
        self._answer, self._seal = answer, seal
        self._tasks: set[asyncio.Task[None]] = set()

    async def hear(self, message: Msg) -> None:
        """Take note of what an edge wants."""
        try:
            here = decode_here(self._seal.open(message.subject, message.data))
        except NotSealed:
            logger.warning("what an edge wants is not from an edge of this service")
            return
        self._publisher.hear(here)
        for session_id, connection in here.connections.items():
            try:
                await self._connections.adopt(here.edge, session_id, connection)
            except TelemotionError as error:
                logger.warning("session %s of an edge: %s", session_id, error.message)

    async def ask(self, message: Msg) -> None:
        """Answer a question; another one does not wait for it."""
        task = asyncio.create_task(self._respond(message), name="answer edge")
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _respond(self, message: Msg) -> None:
        try:
            question = decode_question(self._seal.open(message.subject, message.data))
            if isinstance(question, Look):
                await message.respond(await self._look(question))
            else:
                await message.respond(encode(await self._answer(question)))
        except Exception:
            # The edge that asked says after a moment that nobody answers.
            logger.exception("a question of an edge was not answered")

    async def _look(self, look: Look) -> bytes:
        # From now on, so that nothing falls between what is answered and what is published.
        self._publisher.want(look.edge, [topic(look.session_id, name) for name in _VIEW])
        stored = await asyncio.to_thread(repository.load, self._sessions.engine, look.session_id)
        found = await self._sessions.first_messages(stored)
        return encode([pack_message(topic(look.session_id, one.type), one) for one in found])  # type: ignore[attr-defined]
