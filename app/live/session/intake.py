"""One gateway connection's way into its session."""

import asyncio
from collections.abc import Awaitable, Callable

from app.errors import Conflict, TelemotionError, Unavailable
from app.ingest.contract import PooledPackets
from app.live.engine.lane import Lane
from app.live.session.actuation import Order
from app.live.session.ledger import Acknowledgements
from app.live.session.runner import LiveSession
from app.live.session.states import OPEN
from app.network.declaration import Declaration
from app.network.messages import AcknowledgeMessage
from app.network.packet import Packet
from app.schemas import SessionState
from estimators.sentences import say


class Intake:
    """One gateway connection's way into its session; a newer connection takes its place.

    Implements `app.ingest.contract.Intake`.
    """

    def __init__(
        self,
        session: LiveSession,
        check_right: Callable[[], Awaitable[None]],
        detached: Callable[["Intake"], None],
        pooled: PooledPackets,
    ) -> None:
        self.pooled: PooledPackets = pooled
        self._session = session
        self._check_right = check_right
        self._detached = detached
        self.ended = asyncio.Event()
        self.end_error: TelemotionError = Unavailable(say("live.stopping"), reason="stopping")
        self._acknowledgements = Acknowledgements(session.id)
        self._clock = session.clock
        self._orders = None if session.actuation is None else session.actuation.connect()

    @property
    def session_id(self) -> str:
        """The session that the ticket named."""
        return self._session.id

    @property
    def declaration(self) -> Declaration:
        """What packets must fit."""
        return self._clock.declaration

    @property
    def lane(self) -> Lane | None:
        """The session's place in the pooled engine."""
        return self._session.lane

    @property
    def taken(self) -> int:
        """How many of its packets were taken together with others'."""
        return 0 if self._session.lane is None else self._session.lane.taken

    @property
    def state(self) -> SessionState:
        """The session's present state."""
        return self._session.state

    @property
    def is_open(self) -> bool:
        """Whether the session takes packets."""
        return self._session.state in OPEN

    @property
    def is_finished(self) -> bool:
        """Whether the session is closed and all of it is stored."""
        return self._session.is_finished

    def end(self, error: TelemotionError) -> None:
        """Have the connection ended for a reason."""
        self.end_error = error
        self.ended.set()

    def receive(self, packet: Packet, arrival_s: float, arrival_ns: int) -> bool:
        """Take one packet; see `LiveSession.receive`."""
        if self.ended.is_set():
            raise Conflict(self.end_error.message)
        try:
            return self._session.receive(packet, arrival_s, arrival_ns)
        except Unavailable:
            self._session.wait_for_service()
            raise

    def acknowledge(self) -> AcknowledgeMessage:
        """Return what the gateway may forget and what it should send again."""
        # As last settled: what compiled code took since is neither missing nor stored. After the goodbye the end is
        # known, and what waits in the lane would be asked for.
        ledger = self._session.now.ledger
        if ledger.last_sequence is not None:
            ledger = self._session.ledger
        return self._acknowledgements.next(ledger, self._session.state)

    def goodbye(self, last_sequence: int) -> None:
        """Note that no packet above `last_sequence` will come; the session closes once it is settled."""
        self._session.ledger.last_sequence = last_sequence

    async def check_right(self) -> None:
        """Raise when the gateway has lost its right since it connected."""
        await self._check_right()

    async def next_order(self) -> Order:
        """Wait for what the magnetic source is to do next; for ever where there is none."""
        if self._orders is None:
            await asyncio.Event().wait()
            raise AssertionError
        return await self._orders.get()

    def detach(self) -> None:
        """Note that the connection has ended."""
        self._detached(self)
