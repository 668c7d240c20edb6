"""The load of a live service: sessions are opened, every packet is sent at its time, and what comes back is timed."""

import asyncio
import contextlib
import json
import selectors
import struct
import time
from array import array
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from heapq import merge

import numpy as np
import psutil

from app.gateway import ServiceClient
from app.kinds.magnetic.schemas import MagneticSafetyIn
from app.live.messages import HealthMessage
from tests.benchmarks.live.parts import Part
from tests.benchmarks.live.sockets import Socket, client_frame
from tests.benchmarks.service import EMAIL, PASSWORD, new_ticket

WARM_UP_S = 5.0
SLICE_S = 0.002
"""Packets that become due within it are sent together: the load shares the machine with what it measures."""
PATIENCE_S = 30.0
"""From the first hello on, gateways that are sent away come again as they are told."""
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
class Opened:
    """Sessions that were admitted."""

    parts: list[Part] = field(default_factory=list)
    """By number of the session."""
    ids: list[str] = field(default_factory=list)
    sockets: list[Socket] = field(default_factory=list)
    """Of gateways and of dashboards."""
    refusals: list[str] = field(default_factory=list)
    """The words of who was sent away, and stayed so."""
    retries_s: list[float] = field(default_factory=list)
    """When each refusal asked to come again."""


def connect(port: int, sessions: Sequence[Created], *, is_patient: bool = True) -> Opened:
    """Connect the gateway and the dashboard of every session that is admitted.

    Patient gateways that are sent away come again as they are told.
    """
    opened = Opened()
    deadline = time.monotonic() + PATIENCE_S
    for one in sessions:
        number, ticket = len(opened.ids), one.ingest
        while True:
            hello = one.part.hello(ticket).model_dump_json(exclude_none=True)
            gateway = Socket.open(port, "/ws/ingest", number, hello)
            answer = json.loads(gateway.first_text())
            if answer["type"] != "error":
                break
            gateway.connection.close()
            wait_s = answer["details"].get("retry_after_s", PATIENCE_S)
            opened.retries_s.append(wait_s)
            if not is_patient or time.monotonic() + wait_s > deadline:
                opened.refusals.append(answer["message"])
                break
            time.sleep(wait_s)
            ticket = asyncio.run(new_ticket(port, one.id))
        if answer["type"] != "error":
            watcher = Socket.open(port, f"/ws/live/{one.id}", number, f'{{"ticket": "{one.live}"}}')
            opened.sockets += [gateway, watcher]
            opened.parts.append(one.part)
            opened.ids.append(one.id)
    return opened


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
        self._opened, self._server, self._loss = opened, server, loss
        phases = np.random.default_rng(1).uniform(0.0, 1.0, len(opened.parts))
        self._phases = np.zeros_like(phases) if together else phases
        self._selector = selectors.DefaultSelector()
        for one in opened.sockets:
            one.connection.setblocking(False)
            self._selector.register(one.connection, selectors.EVENT_READ, one)
        self._gateways = {one.session: one.connection for one in opened.sockets if not one.is_live}
        self._waiting = [bytearray() for _ in opened.parts]
        self._sent_at = [np.full(len(part.packets), np.nan) for part in opened.parts]
        self._start = 0.0
        self._to_epoch = 0.0
        self.outcome = Outcome()

    def _events(self, session: int) -> Iterator[tuple[float, int, int, bytes]]:
        part = self._opened.parts[session]
        phase_s = float(self._phases[session]) * part.packet_s
        for due_s, number, frame in part.events(self._loss, seed=session):
            yield due_s + phase_s, session, number, frame

    def run(
        self, each_minute: Callable[[float], None] | None = None, on_warm: Callable[[], None] | None = None
    ) -> Outcome:
        """Send every packet at its time and read whatever comes meanwhile.

        Parameters
        ----------
        each_minute : callable(minutes), optional
            Called after each minute of measured time.
        on_warm : callable, optional
            Called where measuring begins.
        """
        outcome, load = self.outcome, psutil.Process()
        self._start = time.perf_counter() + 0.5
        self._to_epoch = time.time() - time.perf_counter()
        cpu_from: tuple[float, float, float] | None = None
        minute = 1
        for due_s, session, number, frame in merge(*map(self._events, range(len(self._opened.parts)))):
            if cpu_from is None and due_s >= WARM_UP_S:
                if on_warm is not None:
                    on_warm()
                cpu_from = (time.perf_counter(), cpu_s(self._server), cpu_s(load))
            if each_minute is not None and due_s >= WARM_UP_S + 60.0 * minute:
                each_minute(minute)
                minute += 1
            due = self._start + due_s
            self._wait_for(due)
            now = time.perf_counter()
            outcome.late_ms.append(1e3 * (now - due))
            self._sent_at[session][number] = now + self._to_epoch
            self._send(session, frame)
            outcome.sent += 1
        assert cpu_from is not None
        elapsed = time.perf_counter() - cpu_from[0]
        outcome.server_cpu = (cpu_s(self._server) - cpu_from[1]) / elapsed
        outcome.load_cpu = (cpu_s(load) - cpu_from[2]) / elapsed
        for _ in range(30):
            self._send_rest()
            self._read_until(time.perf_counter() + 0.1)
        return outcome

    def _send(self, session: int, frame: bytes) -> None:
        """Send a frame, or as much as the connection takes: the rest waits, as it would in a gateway."""
        waiting = self._waiting[session]
        waiting += frame
        with contextlib.suppress(BlockingIOError):
            del waiting[: self._gateways[session].send(waiting)]

    def _send_rest(self) -> None:
        for session, waiting in enumerate(self._waiting):
            if waiting:
                self._send(session, b"")

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
        for opcode, payload in one.read():
            if one.is_live and opcode == 2:
                self._frame(one.session, payload)
            elif opcode == 1:
                one.texts.append(payload)
                del one.texts[:-16]
                if one.is_live and payload.startswith(b'{"type":"health"'):
                    outcome.health[one.session] = HealthMessage.model_validate_json(payload)
            elif opcode == 9:
                one.connection.sendall(client_frame(payload, opcode=10))

    def _frame(self, session: int, payload: bytes) -> None:
        now = time.perf_counter() + self._to_epoch
        _, ticks, _, first_tick, _, _, published = _BLOCK.unpack(payload)
        # The packet that made the block whole: behind a gap there are ticks of earlier ones in it.
        number = (first_tick + ticks - 1) // 5
        sent = self._sent_at[session]
        if number >= len(sent) or not sent[number] - self._start - self._to_epoch >= WARM_UP_S:
            return
        found = self.outcome.of_part[self._opened.parts[session].name]
        found.published_ms.append(1e3 * (published - sent[number]))
        found.received_ms.append(1e3 * (now - sent[number]))
        found.sent_s.append(sent[number] - self._start - self._to_epoch)


def cpu_s(process: psutil.Process) -> float:
    """Processor time of a process and of those that it started."""
    total = 0.0
    for one in (process, *process.children(recursive=True)):
        times = one.cpu_times()
        total += times.user + times.system
    return float(total)
