"""The load of a live service: sessions are opened, every packet is sent at its time, and what comes back is timed."""

import asyncio
import contextlib
import json
import math
import selectors
import socket
import struct
import time
from array import array
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from heapq import heapify, heappop, heappush

import numpy as np
import psutil

from app.gateway import ServiceClient
from app.kinds.magnetic.schemas import MagneticSafetyIn
from app.live.messages import HealthMessage
from app.network.messages import GoodbyeMessage
from tests.benchmarks.live.parts import Part
from tests.benchmarks.live.sockets import PING, PONG, Socket, client_frame
from tests.benchmarks.service import EMAIL, PASSWORD, new_ticket

WARM_UP_S = 10.0
"""When measuring begins: the first checks of all sessions are over by then."""
BEGUN_S = 5.0
"""Sessions of a clinic do not begin within the same twentieth of a second, but one after the other in so long."""
READING_S = 9.0
"""Before measuring begins: what the service and the machine say is read; what is sent late for that is not measured."""
SLICE_S = 0.002
"""Packets that become due within it are sent together: the load shares the machine with what it measures."""
PATIENCE_S = 30.0
"""For so long gateways that are sent away come again as they are told; once one was refused for good, no longer."""
CREATED_TOGETHER = 20
_BLOCK = struct.Struct("<4sIIIddd")


@dataclass(frozen=True)
class Created:
    """A session that may be connected to."""

    part: Part
    id: str
    ingest: str
    live: str
    """Tickets of its gateway and of who watches."""


async def create(
    port: int, patient_id: str, parts: Sequence[tuple[Part, int]], email: str = EMAIL
) -> list[Created]:
    """Create so many sessions of each part and get their tickets."""
    made = []
    async with ServiceClient(f"http://127.0.0.1:{port}") as client:
        await client.sign_in(email, PASSWORD)
        for part, count in parts:
            wanted = part.wanted.model_copy(update={"patient_id": patient_id})
            for _ in range(count):
                session = await client.create_session(wanted)
                if wanted.pipeline == "relative_pose":
                    safe = MagneticSafetyIn(patient_has_no_implant=True, people_nearby_have_none=True)
                    await client.confirm_no_implants(session.id, safe)
                is_ready = session.calibration is not None or not wanted.use_mounting
                assert is_ready, "the sessions must be calibrated, else little is estimated"
                tickets = [await client.ticket(session.id, purpose) for purpose in ("ingest", "live")]
                made.append(Created(part, session.id, *tickets))
    return made


@dataclass
class Refusal:
    """What a gateway that was sent away was told."""

    message: str
    retry_after_s: float


@dataclass
class Opened:
    """Sessions that were admitted."""

    parts: list[Part] = field(default_factory=list)
    """By number of the session."""
    ids: list[str] = field(default_factory=list)
    sockets: list[Socket] = field(default_factory=list)
    """Of gateways and of dashboards, two a session."""
    refusals: list[Refusal] = field(default_factory=list)
    """Of who was sent away, and stayed so."""

    def add(self, session: Created, gateway: Socket, dashboard: Socket) -> None:
        """Note a session that was admitted."""
        self.parts.append(session.part)
        self.ids.append(session.id)
        self.sockets += [gateway, dashboard]

    def wait(self, seconds: float) -> None:
        """Let time pass without losing those that are connected."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0.0:
            self.answer_pings()
            time.sleep(min(left, 1.0))

    def answer_pings(self) -> None:
        """Answer the pings that came to any socket."""
        for one in self.sockets:
            one.answer_pings()


def connect_one(port: int, session: Created, number: int, ticket: str) -> tuple[Socket, Socket] | Refusal:
    """Connect a session's gateway and, when it is admitted, the dashboard."""
    hello = session.part.hello(ticket).model_dump_json(exclude_none=True)
    gateway = Socket.open(port, "/ws/ingest", number, hello)
    answer = json.loads(gateway.first_text())
    if answer["type"] == "error":
        gateway.connection.close()
        return Refusal(answer["message"], answer["details"].get("retry_after_s", np.nan))
    return gateway, Socket.open(port, f"/ws/live/{session.id}", number, f'{{"ticket": "{session.live}"}}')


def open_all(port: int, patient_id: str, parts: Sequence[tuple[Part, int]]) -> Opened:
    """Create and connect so many sessions of each part, some at a time: a ticket expires while all are created."""
    opened = Opened()
    for part, count in parts:
        for first in range(0, count, CREATED_TOGETHER):
            some = min(CREATED_TOGETHER, count - first)
            made = asyncio.run(create(port, patient_id, [(part, some)]))
            connect(port, made, opened, time.monotonic() + (0.0 if opened.refusals else PATIENCE_S))
            opened.answer_pings()
    return opened


def connect(port: int, sessions: Sequence[Created], opened: Opened, deadline: float) -> None:
    """Connect every session that is admitted; gateways that are sent away come again as they are told."""
    for one in sessions:
        ticket = one.ingest
        found = connect_one(port, one, len(opened.ids), ticket)
        while isinstance(found, Refusal) and time.monotonic() + found.retry_after_s < deadline:
            opened.wait(found.retry_after_s)
            ticket = asyncio.run(new_ticket(port, one.id))
            found = connect_one(port, one, len(opened.ids), ticket)
        if isinstance(found, Refusal):
            opened.refusals.append(found)
        else:
            opened.add(one, *found)


@dataclass
class Latencies:
    """Of some sessions, in milliseconds from the moment before a packet was sent; `sent_s` since the load began."""

    published_ms: "array[float]" = field(default_factory=lambda: array("d"))
    received_ms: "array[float]" = field(default_factory=lambda: array("d"))
    sent_s: "array[float]" = field(default_factory=lambda: array("d"))


@dataclass
class Outcome:
    """What was measured."""

    of_part: dict[str, Latencies] = field(default_factory=lambda: defaultdict(Latencies))
    late_ms: "array[float]" = field(default_factory=lambda: array("d"))
    health: dict[int, HealthMessage] = field(default_factory=dict)
    states: set[str] = field(default_factory=set)
    sent: int = 0
    streamed_s: float = 0.0
    """Of all sessions together."""
    server_cpu: float = 0.0
    load_cpu: float = 0.0

    @property
    def published_ms(self) -> np.ndarray:
        """Of all sessions: from a packet to the time stamp of its frame."""
        return np.concatenate([one.published_ms for one in self.of_part.values()])

    @property
    def received_ms(self) -> np.ndarray:
        """Of all sessions: from a packet to its frame at the dashboard."""
        return np.concatenate([one.received_ms for one in self.of_part.values()])

    @property
    def sent_s(self) -> np.ndarray:
        """When the packets of these latencies were sent."""
        return np.concatenate([one.sent_s for one in self.of_part.values()])


class Load:
    """Sends packets and reads what comes, on one thread.

    Parameters
    ----------
    opened : Opened
        Sessions that send from the beginning.
    server : Process
        The service, whose processor time is counted.
    loss : float
        Share of packets that the link loses the first time.
    together : bool
        Whether all sessions send at the same moment instead of spread over a packet's time.
    """

    def __init__(
        self, opened: Opened, server: psutil.Process, *, loss: float = 0.0, together: bool = False
    ) -> None:
        self._server, self._loss, self._is_together = server, loss, together
        self._random = np.random.default_rng(1)
        self._selector = selectors.DefaultSelector()
        self._parts: list[Part] = []
        self._gateways: list[socket.socket] = []
        self._waiting: list[bytearray] = []
        self._is_over: list[bool] = []
        """Sessions that said goodbye: the service ends their connections."""
        self._sent_at: list[np.ndarray] = []
        self._events: list[tuple[float, int, int, bytes]] = []
        """The next packet of each session: when, whose, its number, its frame."""
        self._rest: list[Iterator[tuple[float, int, int, bytes]]] = []
        self._start = 0.0
        self._to_epoch = 0.0
        self.outcome = Outcome()
        for number, part in enumerate(opened.parts):
            self.add(part, *opened.sockets[2 * number : 2 * number + 2])

    def add(self, part: Part, gateway: Socket, dashboard: Socket) -> None:
        """Let a session send from now on."""
        session = len(self._parts)
        gateway.session = dashboard.session = session
        for one in (gateway, dashboard):
            one.connection.setblocking(False)
            self._selector.register(one.connection, selectors.EVENT_READ, one)
        self._parts.append(part)
        self._gateways.append(gateway.connection)
        self._waiting.append(bytearray())
        self._is_over.append(False)
        self._sent_at.append(np.full(len(part.packets), np.nan))
        is_first = not self._start and not self._is_together
        self._rest.append(
            self._events_of(session, self._random.uniform(0.0, BEGUN_S) if is_first else self.now_s)
        )
        self._advance(session)

    def goodbye(self, session: int) -> None:
        """Let a session send nothing more, and say so."""
        self._rest[session] = iter(())
        self._events = [one for one in self._events if one[1] != session]
        heapify(self._events)
        highest = int(np.flatnonzero(np.isfinite(self._sent_at[session]))[-1])
        message = GoodbyeMessage(last_sequence=highest).model_dump_json()
        self._send(session, client_frame(message.encode(), opcode=1))
        self._is_over[session] = True

    @property
    def now_s(self) -> float:
        """Time since the load began."""
        return time.perf_counter() - self._start if self._start else 0.0

    def _events_of(self, session: int, from_s: float) -> Iterator[tuple[float, int, int, bytes]]:
        part = self._parts[session]
        from_s += 0.0 if self._is_together else self._random.uniform(0.0, part.packet_s)
        for due_s, number, frame in part.events(self._loss, seed=session):
            yield from_s + due_s, session, number, frame

    def _advance(self, session: int) -> None:
        following = next(self._rest[session], None)
        if following is not None:
            heappush(self._events, following)

    def run(
        self,
        each_minute: Callable[[float], None] | None = None,
        on_warm: Callable[[], None] | None = None,
        until_s: float = math.inf,
    ) -> Outcome:
        """Send every packet at its time and read whatever comes meanwhile.

        Parameters
        ----------
        each_minute : callable(minutes), optional
            Called after each minute of measured time.
        on_warm : callable, optional
            Called some seconds before measuring begins.
        until_s : float
            What would be sent later is not: all sessions send while it is measured.
        """
        outcome, load = self.outcome, psutil.Process()
        self.begin()
        cpu_from: tuple[float, float, float] | None = None
        served: list[psutil.Process] = []
        minute = 1
        while self._events and (due_s := self._events[0][0]) < until_s:
            if not served and due_s >= WARM_UP_S - READING_S:
                if on_warm is not None:
                    on_warm()
                served = [self._server, *self._server.children(recursive=True)]
            if cpu_from is None and due_s >= WARM_UP_S:
                cpu_from = (time.perf_counter(), cpu_s(served), cpu_s([load]))
            if each_minute is not None and due_s >= WARM_UP_S + 60.0 * minute:
                each_minute(minute)
                minute += 1
            self.send_next()
        assert cpu_from is not None
        elapsed = time.perf_counter() - cpu_from[0]
        outcome.server_cpu = (cpu_s(served) - cpu_from[1]) / elapsed
        # Not with its children: the service is one.
        outcome.load_cpu = (cpu_s([load]) - cpu_from[2]) / elapsed
        self.end()
        return outcome

    def begin(self) -> None:
        """Begin in half a second."""
        self._start = time.perf_counter() + 0.5
        self._to_epoch = time.time() - time.perf_counter()

    def end(self) -> None:
        """Send what the connections did not take, and read for three seconds more."""
        for _ in range(30):
            for session, waiting in enumerate(self._waiting):
                if waiting:
                    self._send(session, b"")
            self.read_for(0.1)

    def send_next(self) -> None:
        """Wait until the next packet is due, and send it."""
        due_s, session, number, frame = heappop(self._events)
        self._advance(session)
        due = self._start + due_s
        self._wait_for(due)
        now = time.perf_counter()
        if due_s >= WARM_UP_S:
            self.outcome.late_ms.append(1e3 * (now - due))
        self._sent_at[session][number] = now + self._to_epoch
        self._send(session, frame)
        self.outcome.sent += 1
        self.outcome.streamed_s += self._parts[session].packet_s

    def drive_until(self, until_s: float) -> bool:
        """Send what is due before a moment of the load; False where no session sends."""
        while self._events and self._events[0][0] < until_s:
            self.send_next()
        return bool(self._events)

    def read_for(self, seconds: float) -> None:
        """Read what comes for a while."""
        self._read_until(time.perf_counter() + seconds)

    def _send(self, session: int, frame: bytes) -> None:
        """Send a frame, or as much as the connection takes: the rest waits, as it would in a gateway."""
        waiting = self._waiting[session]
        waiting += frame
        with contextlib.suppress(BlockingIOError):
            del waiting[: self._gateways[session].send(waiting)]

    def _wait_for(self, due: float) -> None:
        """Return when a packet is due, or at once; reading then, many sockets together, costs the machine least."""
        if time.perf_counter() < due:
            time.sleep(max(0.0, due + SLICE_S - time.perf_counter()))
            self._read_until(0.0)

    def _read_until(self, moment: float) -> None:
        while True:
            left = moment - time.perf_counter()
            for key, _ in self._selector.select(max(0.0, left)):
                self._take(key.data)
            if left <= 0:
                return

    def _take(self, one: Socket) -> None:
        outcome = self.outcome
        try:
            found = one.read()
        except ConnectionError:
            if not self._is_over[one.session]:
                raise
            self._selector.unregister(one.connection)
            one.connection.close()
            return
        for opcode, payload in found:
            if one.is_live and opcode == 2:
                self._frame(one.session, payload)
            elif opcode == 1:
                one.texts.append(payload)
                del one.texts[:-16]
                if one.is_live and payload.startswith(b'{"type":"health"'):
                    outcome.health[one.session] = HealthMessage.model_validate_json(payload)
            elif opcode == PING:
                one.connection.sendall(client_frame(payload, opcode=PONG))

    def _frame(self, session: int, payload: bytes) -> None:
        now = time.perf_counter() + self._to_epoch
        _, ticks, _, first_tick, _, _, published = _BLOCK.unpack(payload)
        # The packet that made the block whole: behind a gap there are ticks of earlier ones in it.
        number = (first_tick + ticks - 1) // 5
        sent = self._sent_at[session]
        if number >= len(sent) or not sent[number] - self._start - self._to_epoch >= WARM_UP_S:
            return
        found = self.outcome.of_part[self._parts[session].name]
        found.published_ms.append(1e3 * (published - sent[number]))
        found.received_ms.append(1e3 * (now - sent[number]))
        found.sent_s.append(sent[number] - self._start - self._to_epoch)


def cpu_s(processes: Iterable[psutil.Process]) -> float:
    """Processor time of processes; of one that has ended, none."""
    total = 0.0
    for one in processes:
        with contextlib.suppress(psutil.NoSuchProcess):
            times = one.cpu_times()
            total += times.user + times.system
    return float(total)
