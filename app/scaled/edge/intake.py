"""A gateway's connection at an edge: its packets go into the stream, and are acknowledged once they are there."""

import asyncio
from collections.abc import Awaitable, Callable
from typing import Any

from app.errors import Conflict, TelemotionError, Unavailable
from app.ingest.contract import PacketSender, PooledPackets
from app.live.session.ledger import Acknowledgements, SequenceLedger
from app.live.session.states import OPEN
from app.network.declaration import Declaration
from app.network.messages import AcknowledgeMessage
from app.network.packet import Packet
from app.network.ranges import SequenceRanges
from app.scaled.edge.publisher import StreamPublisher
from app.scaled.wire import (
    GivenUpEntry,
    GoodbyeEntry,
    LeftEntry,
    PacketEntry,
    Report,
    StoppedEntry,
    unpack_error,
)
from estimators.sentences import say

_WRAP = 1 << 32


class Unmasking:
    """Gives packets of the short way to their connection, one by one; see `app.ingest.contract.PooledPackets`."""

    def offer(
        self, sender: PacketSender, data: memoryview, key: int, arrival_s: float, arrival_ns: int
    ) -> None:
        """Take a packet as it came, masked."""
        packet = bytes(data)
        if key:
            size = len(packet)
            mask = (key.to_bytes(4, "little") * (size // 4 + 1))[:size]
            plain = int.from_bytes(packet, "little") ^ int.from_bytes(mask, "little")
            packet = plain.to_bytes(size, "little")
        sender.take_rare(packet, arrival_s, arrival_ns)


class Text:
    """A message for a gateway, as a worker wrote it."""

    def __init__(self, text: str) -> None:
        self._text = text

    def model_dump_json(self) -> str:
        """Return its JSON."""
        return self._text


class EdgeIntake:
    """One gateway's way into the stream; implements `app.ingest.contract.Intake`.

    Parameters
    ----------
    publisher : StreamPublisher
        Of the session's partition.
    detached : callable(intake)
    """

    def __init__(
        self,
        session_id: str,
        connection: str,
        declaration: Declaration,
        publisher: StreamPublisher,
        check_right: Callable[[], Awaitable[None]],
        detached: Callable[["EdgeIntake"], None],
    ) -> None:
        self.session_id, self.connection, self.declaration = session_id, connection, declaration
        self.pooled: PooledPackets = Unmasking()
        self.lane: Any = None
        self.taken = 0
        self.ended = asyncio.Event()
        self.end_error: TelemotionError = Unavailable(say("live.stopping"), reason="stopping")
        self.is_finished = False
        self.is_welcome = asyncio.Event()
        """Set with the first report: the session is open, or `ended` says why not."""
        self._state: Any = "created"
        self._publisher, self._check_right, self._detached = publisher, check_right, detached
        self._ledger = SequenceLedger()
        self._acknowledgements = Acknowledgements(session_id)
        self._messages: asyncio.Queue[Text] = asyncio.Queue()

    @property
    def is_open(self) -> bool:
        """Whether the session takes packets."""
        return self._state in OPEN

    def hear(self, report: Report) -> None:
        """Take what the holder of the partition says."""
        was_open = self.is_open
        self._state, self.is_finished = report.state, self.is_finished or report.is_finished
        if was_open and not self.is_open:
            # From here on `receive` takes nothing: whoever closes the session waits for what lies before this.
            self._publisher.put(StoppedEntry(self.session_id, self.connection))
        if report.received is not None and not self.is_welcome.is_set():
            # All of it came out of the stream, or out of the database.
            self._ledger.received = SequenceRanges(report.received)
            self._ledger.durable = SequenceRanges(report.received)
            self.is_welcome.set()
        for text in report.messages:
            self._messages.put_nowait(Text(text))
        if report.error is not None:
            self.end(unpack_error(report.error))
            self.is_welcome.set()

    def repeat(self) -> None:
        """Say again what a new holder of the partition may not know."""
        given_up = list(self._ledger.given_up)
        if given_up:
            self._publisher.put(GivenUpEntry(self.session_id, given_up))
        if self._ledger.last_sequence is not None:
            self._publisher.put(GoodbyeEntry(self.session_id, self.connection, self._ledger.last_sequence))

    def receive(self, packet: Packet, arrival_s: float, arrival_ns: int) -> bool:
        """Take one packet; False when it was here before."""
        if self.ended.is_set():
            raise Conflict(self.end_error.message)
        if not self.is_open:
            raise Conflict(say("live.closed"), state=self._state)
        sequence, ledger = self._unwrapped(packet.sequence), self._ledger
        if sequence in ledger.received:
            return False
        entry = PacketEntry(self.session_id, arrival_ns, packet.data)
        self._publisher.put(entry, lambda: self._durable(sequence))
        ledger.received.add(sequence)
        return True

    def _durable(self, sequence: int) -> None:
        self._ledger.durable.add(sequence)
        self.taken += 1

    def _unwrapped(self, sent: int) -> int:
        """Return the sequence without the wraps of 32 bits, as `PacketClock` counts it."""
        highest = self._ledger.received.highest
        if highest < 0:
            return sent
        step = (sent - highest + (_WRAP >> 1)) % _WRAP - (_WRAP >> 1)
        sequence = highest + step
        return sequence if sequence >= 0 else sequence + _WRAP

    def acknowledge(self) -> AcknowledgeMessage:
        """Return what the gateway may forget and what it should send again."""
        ledger = self._ledger
        before = len(ledger.given_up)
        found = self._acknowledgements.next(ledger, self._state)
        if len(ledger.given_up) != before:
            self._publisher.put(GivenUpEntry(self.session_id, list(ledger.given_up)))
        return found

    def goodbye(self, last_sequence: int) -> None:
        """Note that nothing above `last_sequence` will come."""
        self._ledger.last_sequence = last_sequence
        self._publisher.put(GoodbyeEntry(self.session_id, self.connection, last_sequence))

    async def check_right(self) -> None:
        """Raise when the gateway has lost its right since it connected."""
        await self._check_right()

    async def next_order(self) -> Any:
        """Wait for what the holder of the session has to say to its gateway."""
        return await self._messages.get()

    def end(self, error: TelemotionError) -> None:
        """Have the connection ended for a reason."""
        self.end_error = error
        self.ended.set()

    def detach(self) -> None:
        """Note that the connection has ended."""
        self._publisher.put(LeftEntry(self.session_id, self.connection))
        self._detached(self)
