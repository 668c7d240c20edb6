"""A gateway's connection, from its hello to its goodbye: over `/ws/ingest`, or over whatever else is a `GatewaySocket`.

The first message is a JSON hello with a one-use ticket; then binary packets, or JSON packets at low rate. The
server acknowledges a few times a second what is durably stored, and says what is missing. A wrong
message is answered with a typed error and the connection lives on; only a sender that gets nothing right is
turned away. What a live session is, this module does not know: it talks to a `PacketSink`.
"""

import asyncio
import contextlib
import math
import random
import time
from collections import deque
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import Field, TypeAdapter, ValidationError
from starlette.websockets import WebSocketDisconnect, WebSocketDisconnected, WebSocketState

from app.errors import InvalidInput, PacketError, TelemotionError, Unavailable
from app.ingest.contract import GatewaySocket, Intake, PacketSink
from app.network.conversation import until_first_ends
from app.network.declaration import check_hello
from app.network.lean_sockets import LeanSocket
from app.network.messages import (
    AcknowledgeMessage,
    ErrorMessage,
    GoodbyeMessage,
    HelloMessage,
    JsonPacket,
)
from app.network.pace import Pace
from app.network.packet import (
    HEADER_BYTES,
    MAX_PACKET_BYTES,
    MAX_TICKS,
    OFFSETS,
    Packet,
    decode_packet,
    packet_from_json,
)
from app.schemas import Schema
from estimators.sentences import say

HELLO_TIMEOUT_S = 10.0
ACKNOWLEDGE_EVERY_S = 0.5
MAX_TEXT_BYTES = 256 * 1024
ERRORS_A_SECOND = 20
"""Error messages sent; further errors of that second are counted only."""
WRONG_IN_A_ROW = 1000
"""A connection that sends so many wrong messages and no right one between is ended."""
BEHIND_S = 0.1
"""Until a packet is given again that could not be taken yet."""
LEAST_PAUSE_S = 0.1
"""Of a connection that is too fast: what it may send in that time is taken together. Shorter than any silence that is
looked at."""
_TICKS_AT = OFFSETS["tick_count"]
TURN_S = 0.005
"""A connection that has messages waiting lets the others have their turn after so long."""


@dataclass
class IngestMetrics:
    """Counters of all connections since the start."""

    connections: int = 0
    packets: int = 0
    duplicates: int = 0
    errors: int = 0


metrics = IngestMetrics()

_message: TypeAdapter[JsonPacket | GoodbyeMessage] = TypeAdapter(
    Annotated[JsonPacket | GoodbyeMessage, Field(discriminator="type")]
)


class IngestConnection:
    """The conversation with one gateway.

    Parameters
    ----------
    speed : float
        Seconds of signal that are read in a second, see `Pace`.
    lean : LeanSocket, optional
        The short way for packets, where the link has one.
    """

    def __init__(
        self,
        websocket: GatewaySocket,
        sink: PacketSink,
        speed: float = math.inf,
        lean: LeanSocket | None = None,
    ) -> None:
        self._websocket = websocket
        self._sink = sink
        self._pace = Pace(speed)
        self._step_s = 0.0
        self._sending = asyncio.Lock()
        self._error_second = 0
        self._errors_sent = 0
        self._wrong_in_a_row = 0
        self._taken_before = 0
        self._socket = lean
        self._intake: Intake | None = None
        self._lane: Any = None
        self._held: deque[tuple[bytes, float, int]] = deque()
        """Packets of the short way that the session cannot take yet."""

    async def serve(self) -> None:
        """Run from hello to goodbye."""
        metrics.connections += 1
        try:
            intake = await self._hello()
        except (TelemotionError, TimeoutError) as error:
            if isinstance(error, TimeoutError):
                # Passes: who was too busy to say hello tries again, a gateway would end at invalid input.
                error = Unavailable(say("hello.timeout", seconds=HELLO_TIMEOUT_S), retry_after_s=1)
            await self._end(error)
            return
        try:
            await self._send(intake.acknowledge())
            if self._socket is not None:
                self._intake, self._lane = intake, intake.lane
                self._step_s = intake.declaration.time_step_s
                self._socket.attach(self)
            await self._converse(intake)
        finally:
            if self._socket is not None:
                self._socket.detach()
            intake.detach()

    # --- the short way: packets as they lie in the connection, given on many at a time -------------------

    @property
    def lane(self) -> Any:
        """The session's place among those whose packets are taken together."""
        return None if self._held else self._lane

    def received(self, buffer: bytes, start: int, length: int, key: int) -> None:
        """Take a binary message; implements `BinaryReader`."""
        intake = self._intake
        if intake is None or intake.ended.is_set() or not HEADER_BYTES <= length <= MAX_PACKET_BYTES:
            self.take_rare(b"", time.monotonic(), time.time_ns(), size=length)
            return
        ticks = 1
        if length > _TICKS_AT:
            ticks = min((buffer[start + _TICKS_AT] ^ (key >> 8)) & 0xFF, MAX_TICKS)
        arrival_s = time.monotonic()
        intake.pooled.offer(self, memoryview(buffer)[start : start + length], key, arrival_s, time.time_ns())
        wait_s = self._pace.take(ticks * self._step_s, arrival_s)
        if wait_s > 0.0 and self._socket is not None:
            self._socket.slow_down(max(wait_s, LEAST_PAUSE_S))

    def take_rare(self, data: bytes, arrival_s: float, arrival_ns: int, size: int | None = None) -> None:
        """Take a packet of the short way by itself, behind those that wait; `size` stands for data that is too long."""
        if self._held:
            self._held.append((data, arrival_s, arrival_ns))
            if self._socket is not None:
                self._socket.slow_down(BEHIND_S)
            return
        intake = self._intake
        if intake is None or intake.ended.is_set():
            return
        try:
            if size is not None and size > MAX_PACKET_BYTES:
                raise PacketError(say("packet.too_long", size=size, most=MAX_PACKET_BYTES), reason="length")
            packet = self._decode(data, intake)
            if not intake.receive(packet, arrival_s, arrival_ns):
                metrics.duplicates += 1
            metrics.packets += 1
            self._wrong_in_a_row = 0
        except TelemotionError as error:
            if _is_behind(error) and self._socket is not None:
                self._held.append((data, arrival_s, arrival_ns))
                self._socket.slow_down(BEHIND_S)
                asyncio.get_running_loop().call_later(BEHIND_S, self._try_again)
            elif intake.is_open and not intake.ended.is_set():
                self._note_wrong(intake, error)

    def _try_again(self) -> None:
        if self._intake is None or self._intake.ended.is_set():
            self._held.clear()
            return
        held, self._held = self._held, deque()
        while held and not self._held:
            self.take_rare(*held.popleft())
        self._held.extend(held)

    def _note_wrong(self, intake: Intake, error: TelemotionError) -> None:
        answer = self._counted(error)
        if self._wrong_in_a_row >= WRONG_IN_A_ROW:
            intake.end(InvalidInput(say("packet.nothing_right"), reason="give_up"))
        elif answer is not None and self._socket is not None:
            self._socket.send_text_now(answer.model_dump_json())

    # --- the ordinary way -------------------------------------------------------------------------------

    async def _hello(self) -> Intake:
        async with asyncio.timeout(HELLO_TIMEOUT_S):
            message = await self._websocket.receive()
        if message["type"] == "websocket.disconnect":
            raise WebSocketDisconnect(message.get("code", 1000))
        text = message.get("text")
        if text is None or len(text) > MAX_TEXT_BYTES:
            raise PacketError(say("hello.first"), reason="hello")
        try:
            hello = HelloMessage.model_validate_json(text)
        except ValidationError as error:
            raise PacketError(say("hello.not_understood", faults=in_words(error)), reason="hello") from error
        return await self._sink.open(hello, check_hello(hello))

    async def _converse(self, intake: Intake) -> None:
        """Receive until the gateway leaves, while acknowledging; the first that ends, ends both."""
        sides = (
            asyncio.create_task(self._receive_all(intake), name="ingest receive"),
            asyncio.create_task(self._acknowledge(intake), name="ingest acknowledge"),
            asyncio.create_task(self._keep_checking(intake), name="ingest right"),
            asyncio.create_task(self._order(intake), name="ingest order"),
        )
        try:
            await until_first_ends(sides)
        except TelemotionError as error:
            await self._end(error)
        if self._websocket.application_state is WebSocketState.CONNECTED:
            with contextlib.suppress(WebSocketDisconnect, WebSocketDisconnected):
                await self._websocket.close()

    async def _order(self, intake: Intake) -> None:
        while True:
            await self._send(await intake.next_order())

    async def _receive_all(self, intake: Intake) -> None:
        turn_s = time.monotonic()
        while True:
            message = await self._websocket.receive()
            if message["type"] == "websocket.disconnect":
                return
            arrival_s, arrival_ns = time.monotonic(), time.time_ns()
            data, text = message.get("bytes"), message.get("text")
            # Whatever is wrong or there already costs time too.
            ticks = 1
            try:
                if data is not None:
                    packet = self._decode(data, intake)
                    ticks = packet.tick_count
                    await self._give(intake, packet, arrival_s, arrival_ns)
                elif text is not None:
                    await self._take_text(intake, text, arrival_s, arrival_ns)
                self._wrong_in_a_row = 0
            except TelemotionError as error:
                if not intake.is_open:
                    # Reported by the closing acknowledgement.
                    continue
                await self._wrong(error)
            wait_s = self._pace.take(ticks * intake.declaration.time_step_s, arrival_s)
            if wait_s > 0.0:
                await asyncio.sleep(wait_s)
            if time.monotonic() - turn_s > TURN_S:
                await asyncio.sleep(0)
                turn_s = time.monotonic()

    @staticmethod
    def _decode(data: bytes, intake: Intake) -> Packet:
        if len(data) > MAX_PACKET_BYTES:
            raise PacketError(
                say("packet.too_long", size=len(data), most=MAX_PACKET_BYTES),
                reason="length",
            )
        return decode_packet(data, intake.declaration)

    async def _take_text(self, intake: Intake, text: str, arrival_s: float, arrival_ns: int) -> None:
        if len(text) > MAX_TEXT_BYTES:
            raise PacketError(say("packet.json_too_long", limit_bytes=MAX_TEXT_BYTES), reason="length")
        try:
            message = _message.validate_json(text)
        except ValidationError as error:
            raise PacketError(say("packet.not_understood", faults=in_words(error)), reason="json") from error
        if isinstance(message, GoodbyeMessage):
            while self._held and not intake.ended.is_set():  # noqa: ASYNC110 - rare, and soon over
                # Packets that wait for their place came before it.
                await asyncio.sleep(BEHIND_S)
            intake.goodbye(message.last_sequence)
        else:
            await self._give(intake, packet_from_json(message, intake.declaration), arrival_s, arrival_ns)

    async def _give(self, intake: Intake, packet: Packet, arrival_s: float, arrival_ns: int) -> None:
        """Hand a packet on; while the store is behind, stop reading so the gateway slows down."""
        metrics.packets += 1
        while True:
            try:
                if not intake.receive(packet, arrival_s, arrival_ns):
                    metrics.duplicates += 1
            except Unavailable as error:
                if not _is_behind(error):
                    raise
                await asyncio.sleep(BEHIND_S)
            else:
                return

    async def _acknowledge(self, intake: Intake) -> None:
        """Acknowledge; returns when the session has closed and all is stored."""
        last: AcknowledgeMessage | None = None
        sent_s = time.monotonic()
        while True:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(ACKNOWLEDGE_EVERY_S):
                    await intake.ended.wait()
            if intake.ended.is_set():
                raise intake.end_error
            now = time.monotonic()
            # Asked first, so that the last acknowledgement covers everything that was stored.
            is_finished = intake.is_finished
            found = intake.acknowledge()
            if found is not last or now - sent_s > 1.0:
                await self._send(found)
                last, sent_s = found, now
            if is_finished:
                return

    async def _keep_checking(self, intake: Intake) -> None:
        """Watch the right; raises when it is lost. By itself: an answer takes its time, acknowledgements must not."""
        # Connections that came together after a restart must not all be checked at the same moment.
        await asyncio.sleep(random.uniform(0.0, self._sink.check_every_s))  # noqa: S311
        while True:
            await intake.check_right()
            await asyncio.sleep(self._sink.check_every_s)

    async def _wrong(self, error: TelemotionError) -> None:
        answer = self._counted(error)
        if self._wrong_in_a_row >= WRONG_IN_A_ROW:
            raise InvalidInput(say("packet.nothing_right"), reason="give_up")
        if answer is not None:
            await self._send(answer)

    def _counted(self, error: TelemotionError) -> ErrorMessage | None:
        """Count a wrong message and return the answer to it, unless there were many within this second."""
        metrics.errors += 1
        taken = 0 if self._intake is None else self._intake.taken
        if taken != self._taken_before:
            self._taken_before, self._wrong_in_a_row = taken, 0
        self._wrong_in_a_row += 1
        second = int(time.monotonic())
        if second != self._error_second:
            self._error_second, self._errors_sent = second, 0
        self._errors_sent += 1
        return as_message(error) if self._errors_sent <= ERRORS_A_SECOND else None

    async def _end(self, error: TelemotionError) -> None:
        with contextlib.suppress(WebSocketDisconnect, WebSocketDisconnected):
            await self._send(as_message(error, closing=True))
            await self._websocket.close(code=1008 if error.status < 500 else 1013, reason=error.code)

    async def _send(self, message: Schema) -> None:
        await self._send_text(message.model_dump_json())

    async def _send_text(self, text: str) -> None:
        if self._socket is not None and self._socket.send_text_now(text):
            return
        async with self._sending:
            if self._websocket.application_state is WebSocketState.CONNECTED:
                await self._websocket.send_text(text)


def _is_behind(error: TelemotionError) -> bool:
    """Whether a packet may be given again in a moment: store or estimation is behind."""
    return isinstance(error, Unavailable) and error.details.get("reason") in {"store_behind", "behind"}


def as_message(error: TelemotionError, *, closing: bool = False) -> ErrorMessage:
    """Return a typed error as the message that tells it."""
    return ErrorMessage.of(error, closing=closing)


def in_words(error: ValidationError) -> str:
    """Return the first few faults of a JSON message, without its values."""
    faults = error.errors(include_url=False, include_context=False, include_input=False)
    return "; ".join(
        f"{'.'.join(str(step) for step in fault['loc']) or 'message'}: {fault['msg']}" for fault in faults[:3]
    )
