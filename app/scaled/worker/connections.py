"""The gateways of a partition's sessions: edges hold their connections, and hear from here how their sessions stand."""

import asyncio
import contextlib
import time
from functools import partial
from typing import Final

from app.errors import Conflict
from app.live import repository
from app.live.session.runner import LiveSession
from app.live.session.states import OPEN
from app.scaled.wire import (
    GivenUpEntry,
    GoodbyeEntry,
    HelloEntry,
    LeftEntry,
    Report,
    StoppedEntry,
    pack_error,
)
from app.scaled.worker.publisher import Publisher
from app.scaled.worker.senders import Connection
from app.scaled.worker.sessions import PartitionSessions
from estimators.sentences import say

REPEAT_S: Final = 1.0
"""A report is sent again after so long, for it may be lost."""
MOST_MESSAGES: Final = 64
WELCOME_S: Final = 20.0
"""So long after a hello its edge may still wait to hear what is here."""
STOP_S: Final = 3.0
"""In which an edge that lives says that it takes nothing more."""
STOP_AGAIN_S: Final = 0.3


class Connections:
    """The connections of a partition's gateways."""

    def __init__(self, sessions: PartitionSessions, publisher: Publisher) -> None:
        self._sessions, self._publisher = sessions, publisher
        self._by_session: dict[str, Connection] = {}

    def open(self, session: LiveSession, hello: HelloEntry) -> None:
        """Let a gateway that said hello into its session; one before it is sent away."""
        before = self._by_session.get(session.id)
        if before is not None and before.id != hello.connection:
            error = Conflict(say("live.superseded"), reason="superseded")
            self._publisher.report(before.edge, Report(before.id, session.state, error=pack_error(error)))
        joined = self._join(session, hello.connection, hello.edge)
        session.connected()
        self._sessions.announce(session)
        self._send(joined)

    async def adopt(self, edge: str, session_id: str, connection: str) -> None:
        """Take note of a connection that an earlier holder of the partition knew."""
        if session_id in self._by_session:
            return
        session = self._sessions.find(session_id)
        if session is not None:
            # The answer to its hello may have ended with the earlier holder.
            self._send(self._join(session, connection, edge))
            return
        stored = await asyncio.to_thread(repository.load, self._sessions.engine, session_id)
        if stored.state not in OPEN:
            self._publisher.report(edge, Report(connection, stored.state, is_finished=True))

    def _join(self, session: LiveSession, connection: str, edge: str) -> Connection:
        before = self._by_session.pop(session.id, None)
        if before is not None:
            before.end()
        # Whether a gateway still has its right is checked by its edge.
        intake = self._sessions.attach(session, partial(asyncio.sleep, 0))
        made = self._by_session[session.id] = Connection(connection, edge, session.id, intake)
        if session.actuation is not None:
            made.orders = asyncio.create_task(self._order(made), name="orders")
        return made

    async def _order(self, connection: Connection) -> None:
        while True:
            order = await connection.intake.next_order()
            connection.messages.append(order.model_dump_json())
            self._send(connection)

    async def stop(self, session_id: str) -> bool:
        """Have nothing more taken from a session's gateway; return whether all that was taken is read.

        False also where no gateway is connected.
        """
        connection = self._by_session.get(session_id)
        if connection is None:
            return False
        connection.is_stopping = True
        until_s = time.monotonic() + STOP_S
        while self._by_session.get(session_id) is connection and time.monotonic() < until_s:
            self._send(connection)
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(STOP_AGAIN_S):
                    await connection.stopped.wait()
                    return True
        return False

    def take(self, entry: GivenUpEntry | GoodbyeEntry | LeftEntry | StoppedEntry) -> None:
        """Take what a gateway's connection says of itself."""
        session = self._sessions.find(entry.session_id)
        if session is None:
            return
        if isinstance(entry, GivenUpEntry):
            session.ledger.given_up.update(entry.ranges)
            return
        connection = self._by_session.get(entry.session_id)
        if isinstance(entry, GoodbyeEntry):
            session.ledger.last_sequence = entry.last_sequence
        elif connection is not None and connection.id == entry.connection:
            if isinstance(entry, StoppedEntry):
                connection.stopped.set()
            else:
                self._leave(connection)

    def _leave(self, connection: Connection) -> None:
        self._by_session.pop(connection.session_id, None)
        connection.end()
        connection.intake.detach()

    def say(self, session_id: str, text: str) -> None:
        """Send a session's gateway a message; beyond a few that wait, none."""
        connection = self._by_session.get(session_id)
        if connection is not None and len(connection.messages) < MOST_MESSAGES:
            connection.messages.append(text)

    async def report(self) -> None:
        """Tell edges what is new of their connections; let those go whose edge is silent."""
        self._publisher.forget_silent()
        for connection in list(self._by_session.values()):
            if not self._publisher.hears_of(connection.edge):
                self._leave(connection)
                continue
            intake = connection.intake
            if intake.ended.is_set():
                error = pack_error(intake.end_error)
                self._publisher.report(
                    connection.edge, Report(connection.id, self._state(connection), error=error)
                )
                self._leave(connection)
                continue
            found = (self._state(connection), intake.is_finished)
            is_old = time.monotonic() - connection.reported_s > REPEAT_S
            if found != connection.reported or connection.messages or is_old:
                self._send(connection)
            if intake.is_finished:
                self._leave(connection)

    def _state(self, connection: Connection) -> str:
        return "closing" if connection.is_stopping else connection.intake.state

    def _send(self, connection: Connection) -> None:
        messages, connection.messages = connection.messages, []
        connection.reported = (self._state(connection), connection.intake.is_finished)
        connection.reported_s = time.monotonic()
        report = Report(connection.id, *connection.reported, messages=messages)
        session = self._sessions.find(connection.session_id)
        if session is not None and connection.reported_s - connection.opened_s < WELCOME_S:
            report.received = list(session.ledger.received)
        self._publisher.report(connection.edge, report)

    def close(self) -> None:
        """Forget them all; their edges tell the next holder."""
        for connection in self._by_session.values():
            connection.end()
        self._by_session.clear()
