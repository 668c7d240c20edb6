"""A gateway's side of the conversation: send, keep until acknowledged, send again what is missing.

This is the reference for integrators: the rules are in `docs/packet.md`, and this file is one way to keep
them. A packet is held until an acknowledgement covers it. After every connection the server says what it
has; everything else that is held is sent again, marked back-filled. At the end a goodbye states the last
sequence, and the session closes when all of it is settled.
"""

import asyncio
import contextlib
import logging
import random
import time
from collections.abc import Awaitable, Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Annotated

from pydantic import Field, TypeAdapter, ValidationError

from app.errors import (
    Conflict,
    InvalidInput,
    NotAllowed,
    NotFound,
    PacketError,
    SafetyUnconfirmed,
    SignInRequired,
    TelemotionError,
    Unavailable,
)
from app.gateway.links import Link, open_link
from app.network.messages import (
    AcknowledgeMessage,
    ActuateMessage,
    ActuationPlanMessage,
    ErrorMessage,
    GoodbyeMessage,
    HelloMessage,
)
from app.network.packet import PacketFlag, with_flags

logger = logging.getLogger(__name__)

SEND_AGAIN_AFTER_S = 1.0
HELLO_TIMEOUT_S = 60.0
FIRST_WAIT_S = 0.1
LONGEST_WAIT_S = 2.0
KEPT_PACKETS = 200_000

Answer = AcknowledgeMessage | ErrorMessage | ActuateMessage | ActuationPlanMessage
_answer: TypeAdapter[Answer] = TypeAdapter(Annotated[Answer, Field(discriminator="type")])
_FATAL: dict[str, type[TelemotionError]] = {
    SignInRequired.code: SignInRequired,
    NotAllowed.code: NotAllowed,
    NotFound.code: NotFound,
    Conflict.code: Conflict,
    SafetyUnconfirmed.code: SafetyUnconfirmed,
    InvalidInput.code: InvalidInput,
    PacketError.code: PacketError,
}


@dataclass(frozen=True, slots=True)
class Delivery:
    """One packet to send: its sequence, its bytes, and when, in seconds of the session."""

    sequence: int
    data: bytes
    send_s: float


@dataclass(frozen=True)
class Milestone:
    """Something to do before the first packet of `at_s` or later is sent; sending waits for it."""

    at_s: float
    act: Callable[[], Awaitable[None]]


@dataclass
class GatewayReport:
    """What happened on the way.

    Attributes
    ----------
    sent, resent : int
        Messages; `resent` are those sent again after a break or on request.
    errors : list of ErrorMessage
        Typed errors that did not end the connection; the first hundred.
    dropped : int
        Packets thrown away because the memory of the gateway was full.
    unacknowledged : int
        Packets still held at the end; zero when everything is safe.
    state : str
        Of the session, from the last acknowledgement.
    """

    sent: int = 0
    resent: int = 0
    connections: int = 0
    errors: list[ErrorMessage] = field(default_factory=list)
    dropped: int = 0
    unacknowledged: int = 0
    acknowledged: int = -1
    state: str = ""


class GatewayClient:
    """Sends one session.

    Parameters
    ----------
    url : str
        `ws://` or `wss://` address of `/ws/ingest`, or `mqtt://` or `mqtts://` address of a listener for MQTT.
    ticket : async callable
        Gets a fresh ticket for each connection.
    hello : callable(ticket) -> HelloMessage
    pace : float or None
        Seconds of the session per second; None sends as fast as the server takes it.
    give_up_s : float
        Longest time without a connection.
    heard : callable(message), optional
        Called with every message of the server: so a magnetic source learns what to do, and that it is not alone.
    """

    def __init__(
        self,
        url: str,
        ticket: Callable[[], Awaitable[str]],
        hello: Callable[[str], HelloMessage],
        *,
        pace: float | None = 1.0,
        give_up_s: float = 120.0,
        heard: Callable[[Answer], None] | None = None,
    ) -> None:
        self._url, self._ticket, self._hello = url, ticket, hello
        self._pace = pace
        self._give_up_s = give_up_s
        self._heard = heard or (lambda message: None)
        self._held: dict[int, bytes] = {}
        self._sent_s: dict[int, float] = {}
        self._connection: Link | None = None
        self._reader: asyncio.Task[None] | None = None
        self._changed = asyncio.Event()
        self._fatal: TelemotionError | None = None
        self._random = random.Random(0)  # noqa: S311 - spreads reconnections, no secret
        self.report = GatewayReport()

    async def run(
        self,
        deliveries: Iterable[Delivery],
        *,
        breaks_s: Sequence[tuple[float, float]] = (),
        milestones: Sequence[Milestone] = (),
        goodbye: bool = True,
    ) -> GatewayReport:
        """Send all deliveries, then wait until everything is acknowledged and, after a goodbye, closed.

        Parameters
        ----------
        deliveries : iterable of Delivery
            In sending order.
        breaks_s : sequence of (start, end)
            When to cut the connection and for how long, in session time.
        milestones : sequence of Milestone
            In rising time.
        goodbye : bool
            Tell the server that no more will come, which closes the session.

        Raises
        ------
        TelemotionError
            The server refused this gateway for good, or could not be reached for `give_up_s`.
        """
        waiting, cuts = list(milestones), list(breaks_s)
        last = -1
        try:
            await self._connected()
            started, began_s = time.monotonic(), None
            for delivery in deliveries:
                began_s = delivery.send_s if began_s is None else began_s
                while waiting and delivery.send_s >= waiting[0].at_s:
                    before = time.monotonic()
                    await self._act(waiting.pop(0))
                    started += time.monotonic() - before
                while cuts and delivery.send_s >= cuts[0][0]:
                    start, end = cuts.pop(0)
                    await self._cut(end - start)
                if self._pace is not None:
                    ahead_s = started + (delivery.send_s - began_s) / self._pace - time.monotonic()
                    if ahead_s > 0:
                        await asyncio.sleep(ahead_s)
                self._keep(delivery)
                last = max(last, delivery.sequence)
                await self._send(delivery.sequence, delivery.data)
            for milestone in waiting:
                await self._act(milestone)
            await self._settled(last, goodbye)
        finally:
            await self._disconnect()
        self.report.unacknowledged = len(self._held)
        return self.report

    async def _act(self, milestone: Milestone) -> None:
        """Do what a milestone asks, holding the link meanwhile: it may wait for what only a link brings."""
        acting = asyncio.ensure_future(milestone.act())
        try:
            while not acting.done():
                self._changed.clear()
                if self._connection is None:
                    await self._connected()
                changed = asyncio.ensure_future(self._changed.wait())
                await asyncio.wait({acting, changed}, return_when=asyncio.FIRST_COMPLETED)
                changed.cancel()
        finally:
            acting.cancel()
        await acting

    def _keep(self, delivery: Delivery) -> None:
        self._held.setdefault(delivery.sequence, delivery.data)
        if len(self._held) > KEPT_PACKETS:
            oldest = next(iter(self._held))
            del self._held[oldest]
            self._sent_s.pop(oldest, None)
            self.report.dropped += 1

    async def _send(self, sequence: int, data: bytes) -> None:
        """Send one packet; when the link is broken, reconnecting sends all that is held, also this one."""
        if self._fatal is not None:
            raise self._fatal
        connection = self._connection
        try:
            if connection is None:
                raise ConnectionResetError
            await self._room(connection)
            await connection.send(data)
            self._sent_s[sequence] = time.monotonic()
            self.report.sent += 1
        except OSError:
            await self._connected()

    async def _room(self, connection: Link) -> None:
        """Wait until one more packet may be under way."""
        while connection.window is not None and len(self._sent_s) >= connection.window:
            if self._connection is not connection:
                raise ConnectionResetError
            self._changed.clear()
            await self._changed.wait()

    async def _cut(self, length_s: float) -> None:
        """Break the link as a radio would: without a goodbye of any kind."""
        connection = self._connection
        if connection is not None:
            connection.abort()
            await self._disconnect()
        if self._pace is not None:
            await asyncio.sleep(length_s / self._pace)
        await self._connected()

    async def _settled(self, last: int, goodbye: bool) -> None:
        """Wait for the last acknowledgements; say goodbye again after every reconnection."""
        said_to: Link | None = None
        while True:
            if self._fatal is not None:
                raise self._fatal
            if self.report.state in {"closing", "analysed"}:
                return
            if not self._held and not goodbye:
                return
            if (
                not self._held
                and goodbye
                and self._connection is not None
                and said_to is not self._connection
            ):
                said_to = self._connection
                with contextlib.suppress(OSError):
                    await said_to.send(GoodbyeMessage(last_sequence=last).model_dump_json())
            self._changed.clear()
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(self._changed.wait(), 1.0)
            if self._connection is None and self.report.state not in {"closing", "analysed"}:
                await self._connected()

    async def _connected(self) -> None:
        """Connect, with patience, and send again what the server does not have."""
        deadline = time.monotonic() + self._give_up_s
        wait_s = FIRST_WAIT_S
        while True:
            try:
                await self._connect_once()
                return
            except (OSError, Unavailable) as error:
                await self._disconnect()
                asked_s = 0.0
                if isinstance(error, Unavailable):
                    asked_s = float(error.details.get("retry_after_s", 0.0))
                if time.monotonic() + asked_s > deadline:
                    why = error.message if isinstance(error, Unavailable) else ""
                    raise Unavailable(
                        f"The service could not be reached for {self._give_up_s:.0f} s. {why}".rstrip(),
                        retry_after_s=60,
                    ) from error
                await asyncio.sleep(max(asked_s, wait_s * self._random.uniform(0.5, 1.0)))
                wait_s = min(2.0 * wait_s, LONGEST_WAIT_S)

    async def _connect_once(self) -> None:
        await self._disconnect()
        ticket = await self._ticket()
        connection = await open_link(self._url, ticket)
        try:
            await connection.send(self._hello(ticket).model_dump_json(exclude_none=True))
            async with asyncio.timeout(HELLO_TIMEOUT_S):
                answer = _answer.validate_json(await connection.receive())
        except ValidationError as error:
            connection.abort()
            raise Unavailable(
                "The server's answer is not understood; is this a Telemotion service?"
            ) from error
        except BaseException:
            connection.abort()
            raise
        if isinstance(answer, ErrorMessage):
            self._heard(answer)
            await connection.close()
            raise _as_error(answer)
        if not isinstance(answer, AcknowledgeMessage):
            connection.abort()
            raise Unavailable("The server answered a hello with something else than an acknowledgement.")
        self.report.connections += 1
        self._connection = connection
        self._sent_s.clear()
        self._take(answer)
        self._reader = asyncio.create_task(self._read(connection), name="gateway read")
        if self.report.connections > 1 or self._held:
            missing = set(self._wanted(answer.missing))
            for sequence, data in list(self._held.items()):
                if sequence > answer.highest or sequence in missing:
                    await self._room(connection)
                    await self._send_again(connection, sequence, data)

    async def _send_again(self, connection: Link, sequence: int, data: bytes) -> None:
        await connection.send(with_flags(data, data[9] | PacketFlag.BACKFILLED))
        self._sent_s[sequence] = time.monotonic()
        self.report.resent += 1

    async def _read(self, connection: Link) -> None:
        try:
            while True:
                answer = _answer.validate_json(await connection.receive())
                self._heard(answer)
                if isinstance(answer, ActuateMessage | ActuationPlanMessage):
                    continue
                if isinstance(answer, AcknowledgeMessage):
                    self._take(answer)
                    await self._send_missing(connection, answer)
                elif answer.closing:
                    error = _as_error(answer)
                    if not isinstance(error, Unavailable):
                        self._fatal = error
                    return
                elif len(self.report.errors) < 100:
                    self.report.errors.append(answer)
        except (OSError, ValidationError):
            pass
        finally:
            if self._connection is connection:
                self._connection = None
            self._changed.set()

    def _take(self, answer: AcknowledgeMessage) -> None:
        """Forget what is safe."""
        if answer.acknowledged > self.report.acknowledged:
            for sequence in [held for held in self._held if held <= answer.acknowledged]:
                del self._held[sequence]
                self._sent_s.pop(sequence, None)
        self.report.acknowledged = max(self.report.acknowledged, answer.acknowledged)
        self.report.state = answer.state
        self._changed.set()

    async def _send_missing(self, connection: Link, answer: AcknowledgeMessage) -> None:
        """Send again what the server misses and this gateway still has, each at most once a second."""
        now = time.monotonic()
        for sequence in self._wanted(answer.missing):
            if now - self._sent_s.get(sequence, 0.0) > SEND_AGAIN_AFTER_S:
                await self._send_again(connection, sequence, self._held[sequence])

    def _wanted(self, missing: list[tuple[int, int]]) -> list[int]:
        """Return the held sequences within the half-open ranges."""
        return [held for held in self._held if any(start <= held < stop for start, stop in missing)]

    async def _disconnect(self) -> None:
        connection, self._connection = self._connection, None
        reader, self._reader = self._reader, None
        if connection is not None:
            with contextlib.suppress(OSError):
                await connection.close()
        if reader is not None and reader is not asyncio.current_task():
            reader.cancel()
            await asyncio.gather(reader, return_exceptions=True)


def _as_error(message: ErrorMessage) -> TelemotionError:
    kind = _FATAL.get(message.code, Unavailable)
    return kind(message.message, **message.details)
