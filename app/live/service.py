"""The live side for endpoints and sockets, wherever its sessions are live: here, or on another machine."""

import asyncio
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Final, TypeVar

from sqlalchemy import Engine

from app.ingest.contract import Intake
from app.live.bus import Bus
from app.live.guidance.controller import GuidanceController
from app.live.messages import StateMessage
from app.live.repository import StoredSession
from app.live.rights.authorization_checks import AuthorizationCheck, answers_apart
from app.live.rights.batcher import AuthorizationBatcher
from app.live.session.runner import LiveSession
from app.network.declaration import Declaration
from app.network.messages import HelloMessage
from app.schemas import Schema

Answer = TypeVar("Answer")
CHECK_EVERY_S: Final = 5.0
CHECK_AT_LEAST_EVERY_S: Final = 30.0
CHECKS_SHARE: Final = 0.02
"""Of a processor, for checks of rights of all open sockets."""
NEWEST: Final = 0.1
"""Weight of one check in the average of what a check costs."""
GATHERED: Final = 0.2
"""Share of the time between two checks in which a socket's question waits for those of others."""


class LiveService(ABC):
    """Where gateways' packets go, and where views learn of sessions; implements `app.ingest.contract.PacketSink`.

    Parameters
    ----------
    bus : Bus
        On which views hear of sessions.
    """

    def __init__(self, engine: Engine, bus: Bus) -> None:
        self.engine = engine
        self.bus = bus
        # One thread: the checks of many sockets at once must not outnumber the event loop for the interpreter.
        self._checks = ThreadPoolExecutor(1, thread_name_prefix="live-checks")
        self._check_cost_s = 0.0
        self._rights = AuthorizationBatcher(self._ask_all, lambda: self._gather_s)

    @abstractmethod
    async def open(self, hello: HelloMessage, declaration: Declaration) -> Intake:
        """Open the session of a hello's ticket; raises typed errors."""

    @abstractmethod
    async def first_messages(self, stored: StoredSession) -> Sequence[Schema]:
        """Return what a view receives when it connects: layout and state first."""

    @property
    @abstractmethod
    def session_count(self) -> int:
        """Sessions whose sockets are looked after here."""

    async def check(self, work: Callable[[], Answer]) -> Answer:
        """Run a small database read in the thread reserved for checks of open sockets."""
        return await self._timed(work, 1)

    async def check_right(self, question: AuthorizationCheck) -> None:
        """Check the right of an open socket again, together with that of others that ask soon; raises typed errors."""
        await self._rights.check(question)

    async def _ask_all(self, questions: Sequence[AuthorizationCheck]) -> Sequence[Exception | None]:
        return await self._timed(partial(answers_apart, self.engine, questions), len(questions))

    async def _timed(self, work: Callable[[], Answer], sockets: int) -> Answer:
        def timed() -> Answer:
            began_s = time.thread_time()
            try:
                return work()
            finally:
                self._note_cost(time.thread_time() - began_s, sockets)

        return await asyncio.get_running_loop().run_in_executor(self._checks, timed)

    def _note_cost(self, cost_s: float, sockets: int) -> None:
        """Take what so many checks cost together; each counts alike, whether it was asked alone or with others."""
        share = 1.0 - (1.0 - NEWEST) ** sockets
        self._check_cost_s += share * (cost_s / sockets - self._check_cost_s)

    @property
    def check_every_s(self) -> float:
        """How long the right of an open socket stands from one answer to the next question."""
        return self._interval_s - self._gather_s

    @property
    def _interval_s(self) -> float:
        """From one answer to the next, longer where very many are open; a lost right lasts this and one question."""
        # A session has a gateway and, mostly, somebody who watches.
        wanted_s = 2 * self.session_count * self._check_cost_s / CHECKS_SHARE
        return min(max(wanted_s, CHECK_EVERY_S), CHECK_AT_LEAST_EVERY_S)

    @property
    def _gather_s(self) -> float:
        """How long a question waits for others: of each five seconds one."""
        return GATHERED * self._interval_s

    def end_checks(self) -> None:
        """Check nothing more."""
        self._rights.end()
        self._checks.shutdown(cancel_futures=True)


class SteeredLiveService(LiveService):
    """A live side whose sessions are live in this process: people steer them here."""

    @abstractmethod
    def live(self, session_id: str) -> LiveSession:
        """Return a live session; raises `Conflict` when no gateway has connected to it here."""

    @abstractmethod
    def guidance(self, session_id: str) -> GuidanceController:
        """Return the guidance of a live session; raises `Conflict` as `live`."""

    @abstractmethod
    async def state(self, session_id: str) -> StateMessage:
        """Return the state of any session, live or not."""

    @abstractmethod
    async def close(self, session_id: str, reason: str) -> StateMessage:
        """Close a session; closing twice is closing once."""

    @abstractmethod
    async def reopen(self, session_id: str) -> StateMessage:
        """Let a session that has ended take the packets that its gateway still has."""

    @abstractmethod
    async def check_source(self, session_id: str) -> None:
        """Let the source of a session that is live here fire only while it is confirmed to be safe."""
