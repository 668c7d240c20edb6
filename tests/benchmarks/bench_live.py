"""Live load on one machine: `make bench-live`.

Starts the real service (one process, as `telemotion serve` does, on a fresh SQLite file) and, in this other
process, the load: sessions of 17 nine-axis sensors at 100 Hz, 5 ticks a packet as int16 counts, calibrated,
with estimation and storage on, each watched by a dashboard. Every packet is encoded before and sent when its
last tick would have been measured, the sessions spread over the packet's 50 ms.

Printed latencies use one clock, that of the machine. "Published" is the time stamp that the service puts into
a frame block when it gives the frames to the bus; it is compared with the moment before the packet was
written to the socket, so time in sockets and queues on the way in is included. The service's own figure
begins when it has read the packet.
"""

import argparse
import asyncio
import base64
import json
import os
import platform
import selectors
import socket
import sqlite3
import struct
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import psutil

from app import tables as tables
from app.gateway import DeviceStream, stream_of
from app.live.messages import HealthMessage
from estimators import pipelines
from estimators.conventions import PLACEMENTS
from estimators.simulation import ArmScenario, Schedule, simulate_arm
from tests.benchmarks.machine import processor
from tests.benchmarks.service import free_port, make_patient, new_ticket, open_sessions, start_server

FEW_SESSIONS, FEW_LIMIT_MS, LIMIT_MS = 50, 15.0, 50.0
"""The 99th percentile from a packet to its frame, for up to so many sessions and for more."""
LIMIT_CPU_MS = 3.5
"""Of a processor, for a second of a session."""
LIMIT_STORED_MB = 50.0
"""A session hour, of packets and live frames together."""
WARM_UP_S = 5.0
SLICE_S = 0.002
"""Packets that become due within it are sent together: the load shares the machine with what it measures."""
_BLOCK = struct.Struct("<4sIIIddd")


@dataclass
class Socket:
    """A WebSocket client that costs next to nothing: no masking key but zero, no copies."""

    connection: socket.socket
    session: int
    is_live: bool
    buffer: bytearray = field(default_factory=bytearray)
    texts: list[bytes] = field(default_factory=list)

    @classmethod
    def open(cls, port: int, path: str, session: int, first: str) -> "Socket":
        connection = socket.create_connection(("127.0.0.1", port), timeout=60)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        key = base64.b64encode(os.urandom(16)).decode()
        connection.sendall(
            f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            f"Sec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n\r\n".encode()
        )
        answer = bytearray()
        while b"\r\n\r\n" not in answer:
            answer += connection.recv(4096)
        head, rest = bytes(answer).split(b"\r\n\r\n", 1)
        assert b" 101 " in head, head
        connection.sendall(client_frame(first.encode(), opcode=1))
        return cls(connection, session, path != "/ws/ingest", bytearray(rest))

    def first_text(self) -> bytes:
        """Wait for the first text message and return it."""
        while not self.texts:
            self.texts += [payload for opcode, payload in self.read() if opcode == 1]
        return self.texts[0]

    def read(self) -> list[tuple[int, bytes]]:
        """Return the (opcode, payload) of what has come."""
        data = self.connection.recv(1 << 18)
        if not data:
            raise ConnectionError(f"the service closed a socket: {self.texts[-1:]}")
        self.buffer += data
        found = []
        while len(self.buffer) >= 2:
            length, start = self.buffer[1] & 127, 2
            if length == 126:
                length, start = int.from_bytes(self.buffer[2:4], "big"), 4
            elif length == 127:
                length, start = int.from_bytes(self.buffer[2:10], "big"), 10
            if len(self.buffer) < start + length:
                break
            opcode = self.buffer[0] & 15
            # Of a frame block only the header matters here.
            keep = 40 if opcode == 2 else length
            found.append((opcode, bytes(self.buffer[start : start + keep])))
            del self.buffer[: start + length]
        return found


def client_frame(payload: bytes, opcode: int = 2) -> bytes:
    """A masked client frame; with the key zero the payload stays as it is."""
    size = len(payload)
    length = bytes([0x80 | size]) if size < 126 else b"\xfe" + size.to_bytes(2, "big")
    return bytes([0x80 | opcode]) + length + b"\0\0\0\0" + payload


def prepare(folder: Path, seconds: float) -> tuple[str, str, DeviceStream]:
    """Make the database with one calibrated patient; return its URL, the patient and the stream."""
    scenario = ArmScenario(
        both_arms=True,
        exercise="drinking",
        placements=PLACEMENTS,
        schedule=Schedule(n_pose_s=10.0, repetitions=None, duration_s=seconds + 10.0),
    )
    simulated = simulate_arm(scenario)
    _, setup = pipelines.run(simulated.recording, simulated.setup, pose_s=(5.0, 9.0))
    url, patient_id = make_patient(folder, setup.to_dict()["calibration"])
    return url, patient_id, stream_of(simulated.recording)


def without_pose(stream: DeviceStream, packet_count: int) -> DeviceStream:
    """Leave out the N-pose: the sessions begin calibrated, in the middle of the movement."""
    offset = stream.packet_count - packet_count
    return DeviceStream(
        stream.placements,
        stream.rate_hz,
        stream.counts[offset * stream.ticks_per_packet :],
        stream.full_scales,
    )


PATIENCE_S = 30.0
"""From the first hello on, gateways that are sent away come again as they are told."""


def open_sockets(
    port: int,
    stream: DeviceStream,
    sessions: list[dict[str, str]],
    renew: Callable[[str], str] | None = None,
) -> tuple[list[Socket], list[str]]:
    """Connect the gateway and the dashboard of every session that is admitted; return them and the refusals' words.

    `renew` gives a session's gateway a new ticket; without it nobody comes again.
    """
    sockets: list[Socket] = []
    refusals = []
    deadline = time.monotonic() + PATIENCE_S
    for one in sessions:
        number, ticket = len(sockets) // 2, one["ingest"]
        while True:
            hello = stream.hello(ticket).model_dump_json(exclude_none=True)
            gateway = Socket.open(port, "/ws/ingest", number, hello)
            answer = json.loads(gateway.first_text())
            if answer["type"] != "error":
                break
            gateway.connection.close()
            wait_s = answer["details"].get("retry_after_s", PATIENCE_S)
            if renew is None or time.monotonic() + wait_s > deadline:
                refusals.append(answer["message"])
                break
            time.sleep(wait_s)
            ticket = renew(one["id"])
        if answer["type"] != "error":
            watcher = Socket.open(port, f"/ws/live/{one['id']}", number, f'{{"ticket": "{one["live"]}"}}')
            sockets += [gateway, watcher]
    return sockets, refusals


@dataclass
class Outcome:
    """What was measured."""

    published_ms: list[float] = field(default_factory=list)
    received_ms: list[float] = field(default_factory=list)
    late_ms: list[float] = field(default_factory=list)
    sent_s: list[float] = field(default_factory=list)
    health: dict[int, HealthMessage] = field(default_factory=dict)
    states: set[str] = field(default_factory=set)
    sent: int = 0
    server_cpu: float = 0.0
    load_cpu: float = 0.0


def run_load(
    sockets: list[Socket], frames: list[bytes], phases: np.ndarray, packet_s: float, server: psutil.Process
) -> Outcome:
    """Send every packet at its time and read whatever comes meanwhile."""
    selector = selectors.DefaultSelector()
    for one in sockets:
        one.connection.setblocking(False)
        selector.register(one.connection, selectors.EVENT_READ, one)
    gateways = {one.session: one.connection for one in sockets if not one.is_live}
    outcome = Outcome()
    sent_at = np.full((len(gateways), len(frames)), np.nan)
    order = np.argsort(phases).tolist()
    start = time.perf_counter() + 0.5
    to_epoch = time.time() - time.perf_counter()
    warm_packets = int(WARM_UP_S / packet_s)
    load = psutil.Process()
    cpu_from: tuple[float, float, float] | None = None

    def read_until(moment: float) -> None:
        while True:
            left = moment - time.perf_counter()
            ready = selector.select(max(0.0, left))
            for key, _ in ready:
                take(key.data)
            if left <= 0:
                return

    def wait_for(due: float) -> None:
        """Return when a packet is due, or at once; reading then, many sockets together, costs the machine least."""
        if time.perf_counter() < due:
            time.sleep(max(0.0, due + SLICE_S - time.perf_counter()))
            read_until(0.0)

    def take(one: Socket) -> None:
        for opcode, payload in one.read():
            if one.is_live and opcode == 2:
                now = time.perf_counter() + to_epoch
                _, _, _, first_tick, _, _, published = _BLOCK.unpack(payload)
                number = first_tick // 5
                sent = sent_at[one.session, number]
                if number >= warm_packets:
                    outcome.published_ms.append(1e3 * (published - sent))
                    outcome.received_ms.append(1e3 * (now - sent))
                    outcome.sent_s.append(sent - start - to_epoch)
            elif opcode == 1:
                one.texts.append(payload)
                if one.is_live and payload.startswith(b'{"type":"health"'):
                    outcome.health[one.session] = HealthMessage.model_validate_json(payload)
            elif opcode == 9:
                one.connection.sendall(client_frame(payload, opcode=10))

    for number, frame in enumerate(frames):
        if number == warm_packets:
            cpu_from = (time.perf_counter(), cpu_s(server), cpu_s(load))
        for session in order:
            due = start + number * packet_s + phases[session]
            wait_for(due)
            now = time.perf_counter()
            outcome.late_ms.append(1e3 * (now - due))
            sent_at[session, number] = now + to_epoch
            gateways[session].sendall(frame)
            outcome.sent += 1
    assert cpu_from is not None
    elapsed = time.perf_counter() - cpu_from[0]
    outcome.server_cpu = (cpu_s(server) - cpu_from[1]) / elapsed
    outcome.load_cpu = (cpu_s(load) - cpu_from[2]) / elapsed
    read_until(time.perf_counter() + 3.0)
    return outcome


def cpu_s(process: psutil.Process) -> float:
    """Processor time of a process and of those that it started."""
    total = 0.0
    for one in (process, *process.children(recursive=True)):
        times = one.cpu_times()
        total += times.user + times.system
    return float(total)


def stored(folder: Path, sessions: Sequence[str] = ()) -> dict[str, tuple[int, int, int]]:
    """Return chunks, ticks and bytes by stream kind, of all sessions or some."""
    some = f" WHERE session_id IN ({', '.join('?' * len(sessions))})" if sessions else ""
    with sqlite3.connect(folder / "bench.db") as connection:
        rows = connection.execute(
            "SELECT CASE WHEN stream = 'raw' THEN 'raw' ELSE 'frames' END, COUNT(*), SUM(ticks), SUM(LENGTH(data))"
            f" FROM signal_chunk{some} GROUP BY 1",
            tuple(sessions),
        ).fetchall()
    return {kind: (chunks, ticks, size) for kind, chunks, ticks, size in rows}


def row(name: str, values: Any) -> str:
    found = np.asarray(values)
    p = np.percentile(found, [50, 95, 99])
    return f"{name:<44}{p[0]:9.2f}{p[1]:9.2f}{p[2]:9.2f}{found.max():9.2f}"


def report(outcome: Outcome, folder: Path, sessions: int, seconds: float, packet_count: int) -> bool:
    """Print the table; True when the requirement holds and nothing is missing."""
    kept = stored(folder)
    frequency = psutil.cpu_freq()
    print(
        f"\nmachine   {platform.node()}, {psutil.cpu_count()} cores, {processor()}"
        + (f", {frequency.current:.0f} MHz" if frequency else "")
    )
    print(
        f"load      {sessions} sessions x 17 nine-axis sensors x 100 Hz, 5 ticks a packet, {seconds:.0f} s,"
        f" {outcome.sent} packets, {len(outcome.published_ms)} frame blocks measured"
    )
    print(f"\n{'latency, ms':<44}{'p50':>9}{'p95':>9}{'p99':>9}{'max':>9}")
    print(row("packet sent -> frame published", outcome.published_ms))
    print(row("packet sent -> frame at the dashboard", outcome.received_ms))
    medians = [one.latency_ms_median for one in outcome.health.values()]
    highs = [one.latency_ms_p99 for one in outcome.health.values()]
    print(
        f"{'packet read -> published, by the service':<44}{np.median(medians):9.2f}{'':>9}{max(highs):9.2f}"
        "   (median of sessions, worst session)"
    )
    print(row("load generator late", outcome.late_ms))
    print(
        f"\nCPU       service with its processes {100 * outcome.server_cpu:.0f} %,"
        f" load {100 * outcome.load_cpu:.0f} % of one core"
    )
    for kind, (chunks, ticks, size) in kept.items():
        print(
            f"stored    {kind:<7}{chunks:7d} chunks {ticks:9d} ticks {size / 1e6:8.1f} MB"
            f" {size / 1e6 / sessions / seconds * 3600:7.1f} MB per session hour"
        )
    in_database = kept["raw"][1] // 5
    whole = in_database == outcome.sent == sessions * packet_count
    high = float(np.percentile(outcome.published_ms, 99))
    print(f"\npackets   {outcome.sent} sent, {in_database} stored")
    print(f"required  every packet stored: {verdict(whole)}")
    limit_ms = FEW_LIMIT_MS if sessions <= FEW_SESSIONS else LIMIT_MS
    cpu_ms = 1e3 * outcome.server_cpu / sessions
    stored_mb = sum(size for _, _, size in kept.values()) / 1e6 / sessions / seconds * 3600
    judged = (high < limit_ms, cpu_ms <= LIMIT_CPU_MS, stored_mb <= LIMIT_STORED_MB)
    print(f"required  p99 below {limit_ms:.0f} ms: {verdict(judged[0])} with {high:.1f} ms")
    print(
        f"required  at most {LIMIT_CPU_MS} ms of a processor a session-second: {verdict(judged[1])} with"
        f" {cpu_ms:.1f} ms"
    )
    print(
        f"required  at most {LIMIT_STORED_MB:.0f} MB stored a session hour: {verdict(judged[2])} with"
        f" {stored_mb:.1f} MB"
    )
    return whole and all(judged)


def verdict(is_met: bool) -> str:
    return "met" if is_met else "MISSED"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sessions", type=int, default=50)
    parser.add_argument("--seconds", type=float, default=30.0, help="measured time, after 5 s of warming up")
    parser.add_argument("--together", action="store_true", help="all sessions send at the same moment")
    parser.add_argument("--slow", action="store_true", help="list the moments with latencies above 25 ms")
    parser.add_argument("--server-pid-file", type=Path, help="where to write the service's process id")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="telemotion-bench-") as name:
        folder = Path(name)
        print("preparing the stream and the database ...", flush=True)
        url, patient_id, stream = prepare(folder, arguments.seconds + WARM_UP_S)
        packet_count = int((arguments.seconds + WARM_UP_S) / stream.packet_s)
        moving = without_pose(stream, packet_count)
        frames = [client_frame(moving.packet(number)) for number in range(packet_count)]
        port = free_port()
        process = start_server(url, folder, port)
        if arguments.server_pid_file:
            arguments.server_pid_file.write_text(str(process.pid))
        try:
            sessions = asyncio.run(open_sessions(port, patient_id, moving, arguments.sessions))
            sockets, refusals = open_sockets(
                port, moving, sessions, lambda session: asyncio.run(new_ticket(port, session))
            )
            admitted = len(sockets) // 2
            if refusals:
                print(f"refused   {len(refusals)} of {len(sessions)} sessions: {refusals[0]}")
            phases = np.random.default_rng(1).uniform(0, moving.packet_s, admitted)
            if arguments.together:
                phases[:] = 0.0
            print(f"running for {arguments.seconds + WARM_UP_S:.0f} s ...", flush=True)
            outcome = run_load(sockets, frames, phases, moving.packet_s, psutil.Process(process.pid))
            is_met = report(outcome, folder, admitted, arguments.seconds + WARM_UP_S, packet_count)
            if arguments.slow:
                list_slow(outcome)
        finally:
            process.terminate()
            process.wait(30)
    return 0 if is_met else 1


def list_slow(outcome: Outcome) -> None:
    """Print stretches of slow packets: from, for how long, how many, the worst."""
    latency, sent = np.array(outcome.published_ms), np.array(outcome.sent_s)
    slow = np.sort(sent[latency > 25.0])
    for group in np.split(slow, np.flatnonzero(np.diff(slow) > 0.2) + 1):
        if group.size:
            worst = latency[(sent >= group[0]) & (sent <= group[-1])].max()
            print(
                f"slow at {group[0]:7.2f} s for {group[-1] - group[0]:5.2f} s: {group.size:4d} packets, {worst:6.1f} ms"
            )


if __name__ == "__main__":
    sys.exit(main())
