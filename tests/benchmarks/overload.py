"""Twice as many sessions as the machine carries, and a device that floods: `python -m tests.benchmarks.overload`.

The real service on a fresh SQLite file; in this other process the gateways and dashboards.

First sessions of 17 sensors come one after the other and stream at once. Where the first is sent away is what the
machine carries; as many again knock, and come again as they are told. Then half of those that stream end. Required:
frames of all that were admitted stay below 100 ms at the 99th percentile; whoever is sent away gets a sentence and a
time; the memory stays where it is; within 5 s of the end somebody new is admitted, and frames are below 50 ms.

Then, on a service of its own, a device sends as fast as its connection takes it, beside sessions that send as they
should. Required: its own session is slowed to the speed that the service allows, and its neighbours' frames stay below
50 ms.

On a machine that does other work latencies are upper bounds.
"""

import argparse
import asyncio
import multiprocessing
import queue
import signal
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from multiprocessing.synchronize import Event
from pathlib import Path

import numpy as np
import psutil

from app.gateway import ServiceClient
from app.network.pace import BURST_S
from app.settings import Settings
from tests.benchmarks.live.load import (
    PATIENCE_S,
    WARM_UP_S,
    Created,
    Load,
    Opened,
    Refusal,
    connect,
    connect_one,
    create,
)
from tests.benchmarks.live.parts import Part, arms
from tests.benchmarks.live.report import LIMIT_MS, heading, judge, machine, row
from tests.benchmarks.live.sockets import MOST_READ, Socket
from tests.benchmarks.live.watching import Memory, idle_mb, stored
from tests.benchmarks.service import EMAIL, PASSWORD, make_patient, start_server
from tests.ports import free_port

OVERLOAD_MS, RECOVERY_S = 100.0, 5.0
MEMORY_GROWTH = 1.1
ARRIVAL_S = 0.2
"""Between two sessions that come."""
AGAIN_S = 0.5
"""Who wants to know when there is room again asks so often."""
NEIGHBOURS = 20


@contextmanager
def service(calibration: dict[str, object]) -> Iterator[tuple[int, str, psutil.Process, Path]]:
    """Run a service; yields its port, its patient, its process and its folder."""
    with tempfile.TemporaryDirectory(prefix="telemotion-bench-") as name:
        folder = Path(name)
        url, patient_id = make_patient(folder, calibration)
        port = free_port()
        process = start_server(url, folder, port)
        try:
            yield port, patient_id, psutil.Process(process.pid), folder
        finally:
            process.terminate()
            process.wait(60)


Found = tuple[Socket, Socket] | Refusal


class Door:
    """Knocks at a service; each who knocks has a ticket of that moment: one that waited would be too old."""

    def __init__(self, port: int) -> None:
        self._port, self._loop = port, asyncio.new_event_loop()
        self._client = ServiceClient(f"http://127.0.0.1:{port}")
        self._loop.run_until_complete(self._client.sign_in(EMAIL, PASSWORD))

    def knock(self, session: Created) -> Found:
        """Try to connect; returns gateway and dashboard when the session is in."""
        ingest, live = (
            self._loop.run_until_complete(self._client.ticket(session.id, purpose))
            for purpose in ("ingest", "live")
        )
        return connect_one(self._port, replace(session, ingest=ingest, live=live), 0, ingest)


def come(
    port: int, sessions: list[Created], found: "multiprocessing.Queue[tuple[int, Found]]", is_over: Event
) -> None:
    """Let sessions come one after the other, from a process of its own: who is sent away comes again as it is told.

    Twice as many come as were in when the first was sent away. Whoever reads latencies must not wait for them.
    """
    door, carried, count = Door(port), 0, 0
    coming = [(time.monotonic() + ARRIVAL_S * number, number) for number in range(len(sessions))]
    knocked: set[int] = set()
    while coming and not is_over.is_set():
        coming.sort()
        at_s, number = coming.pop(0)
        if number not in knocked and carried and len(knocked) >= 2 * carried:
            continue
        is_over.wait(max(0.0, at_s - time.monotonic()))
        answer = door.knock(sessions[number])
        found.put((number, answer))
        knocked.add(number)
        if isinstance(answer, Refusal):
            carried = carried or count
            coming.append((time.monotonic() + answer.retry_after_s, number))
        else:
            count += 1
    # Sockets are handed over by this process.
    signal.pause()


@dataclass
class Arrivals:
    """Who is in and who was sent away.

    Attributes
    ----------
    carried : int
        Sessions that were in when the first was sent away; 0 before.
    """

    refusals: list[Refusal] = field(default_factory=list)
    entered: list[Created] = field(default_factory=list)
    carried: int = 0

    def take(
        self, found: "multiprocessing.Queue[tuple[int, Found]]", made: list[Created], load: Load
    ) -> None:
        """Let whoever was let in send from now on."""
        with suppress(queue.Empty):
            while True:
                number, answer = found.get_nowait()
                if isinstance(answer, Refusal):
                    self.carried = self.carried or len(self.entered)
                    self.refusals.append(answer)
                else:
                    load.add(made[number].part, *answer)
                    self.entered.append(made[number])


def overload(part: Part, calibration: dict[str, object], most: int, hold_s: float) -> bool:
    """Print what a machine does with twice what it carries; True when all that is required is met."""
    spawn = multiprocessing.get_context("spawn")
    with service(calibration) as (port, patient_id, server, folder):
        made = asyncio.run(create(port, patient_id, [(part, most)]))
        memory = Memory(server, idle_mb(server))
        load, arrivals = Load(Opened(), server), Arrivals()
        found: multiprocessing.Queue[tuple[int, Found]] = spawn.Queue()
        is_over = spawn.Event()
        comers = spawn.Process(target=come, args=(port, made, found, is_over), daemon=True)
        load.begin()
        comers.start()

        def drive(seconds: float) -> None:
            until_s = load.now_s + seconds
            while load.now_s < until_s:
                arrivals.take(found, made, load)
                if not load.drive_until(min(until_s, load.now_s + 0.1)):
                    load.read_for(0.02)

        while not arrivals.carried and len(arrivals.entered) < most:
            drive(1.0)
        if not arrivals.carried:
            print(f"this machine carries all {most} sessions: let more come, with --most")
            return False
        print(f"carries   {arrivals.carried} sessions; as many again knock", flush=True)
        drive(ARRIVAL_S * arrivals.carried + 2.0)
        full_s = load.now_s
        memory.note(0.0)
        drive(hold_s)
        memory.note(hold_s / 60.0)
        held_s = load.now_s
        is_over.set()
        # Who knocks at this moment is in or sent away before the process that passes sockets on ends.
        drive(2.0)
        comers.terminate()
        entered = list(arrivals.entered)
        for session in range(0, len(entered), 2):
            load.goodbye(session)
        outside = next(one for one in made if one.id not in {session.id for session in entered})
        back_s = recover(load, Door(port), outside)
        drive(RECOVERY_S)
        load.end()
        kept = stored(folder, [one.id for one in entered])["raw"][1] // 5
    return report(load, arrivals, memory, (full_s, held_s, back_s, kept))


def recover(load: Load, door: Door, outside: Created) -> float:
    """Go on sending until somebody who was sent away is admitted; returns when, seconds after the load has ended."""
    ended_s = load.now_s
    while load.now_s < ended_s + 60.0:
        load.drive_until(load.now_s + AGAIN_S)
        if not isinstance(door.knock(outside), Refusal):
            return load.now_s - ended_s
    return float("inf")


def report(load: Load, arrivals: Arrivals, memory: Memory, found: tuple[float, float, float, int]) -> bool:
    """Print what overload did."""
    full_s, held_s, back_s, kept = found
    refusals, count = arrivals.refusals, len(arrivals.entered)
    outcome = load.outcome
    sent_s, published_ms = outcome.sent_s, outcome.published_ms
    during = published_ms[(sent_s >= full_s) & (sent_s < held_s)]
    after = published_ms[sent_s >= held_s + RECOVERY_S]
    told = [one for one in refusals if one.message and one.retry_after_s > 0.0]
    print(f"\nmachine   {machine()}")
    print(
        f"load      {2 * arrivals.carried} sessions came, {count} streamed, sent away {len(refusals)} times"
    )
    print(f"refused   {refusals[0].message} Again after {refusals[0].retry_after_s:.0f} s.")
    print(heading())
    print(row("all that the machine takes, published", during))
    print(row("5 s after half of them have ended", after))
    print(row("load generator late", outcome.late_ms))
    begun, ended = memory.minutes[0][1], memory.minutes[-1][1]
    high, later = float(np.percentile(during, 99)), float(np.percentile(after, 99))
    return judge(
        {
            f"p99 below {OVERLOAD_MS:.0f} ms while twice as many want in": (
                high < OVERLOAD_MS,
                f"{high:.1f} ms",
            ),
            "a sentence and a time for everybody sent away": (
                len(told) == len(refusals),
                f"{len(told)} of {len(refusals)}",
            ),
            "memory stays where it is": (ended < MEMORY_GROWTH * begun, f"{begun:.0f} to {ended:.0f} MB"),
            f"room again within {RECOVERY_S:.0f} s": (back_s < RECOVERY_S, f"{back_s:.1f} s"),
            f"p99 below {LIMIT_MS:.0f} ms after that": (later < LIMIT_MS, f"{later:.1f} ms"),
            "every packet stored": (kept == outcome.sent, f"{kept} of {outcome.sent}"),
        }
    )


def flooding(port: int, session: Created, seconds: float, told: "multiprocessing.Queue[int]") -> None:
    """Send as fast as the connection takes it, from a process of its own; tells how many packets that were."""
    found = connect_one(port, session, 0, session.ingest)
    assert not isinstance(found, Refusal), found
    gateway, dashboard = found
    threading.Thread(target=swallow, args=(gateway,), daemon=True).start()
    threading.Thread(target=swallow, args=(dashboard,), daemon=True).start()
    until, sent = time.monotonic() + seconds, 0
    gateway.connection.settimeout(1.0)
    for frame in session.part.frames:
        view = memoryview(frame)
        while view and time.monotonic() < until:
            with suppress(TimeoutError):
                view = view[gateway.connection.send(view) :]
        if view:
            break
        sent += 1
    # The buffers of the connection may hold all of it: what is still in them when this process ends is lost.
    time.sleep(max(0.0, until - time.monotonic()))
    told.put(sent)


def swallow(one: Socket) -> None:
    """Read and forget."""
    with suppress(OSError):
        while one.connection.recv(MOST_READ):
            pass


def flood(part: Part, calibration: dict[str, object], seconds: float) -> bool:
    """Print what neighbours notice of a device that floods; True when all that is required is met."""
    spawn = multiprocessing.get_context("spawn")
    speed = float(Settings.model_fields["stream_speed_limit"].default)
    rest, _ = arms(speed * seconds + 2.0 * BURST_S)
    with service(calibration) as (port, patient_id, server, folder):
        made = asyncio.run(create(port, patient_id, [(part, NEIGHBOURS), (rest, 1)]))
        opened = Opened()
        connect(port, made[:-1], opened, time.monotonic() + PATIENCE_S)
        load = Load(opened, server)
        told: multiprocessing.Queue[int] = spawn.Queue()
        flooder = spawn.Process(target=flooding, args=(port, made[-1], seconds, told), daemon=True)
        flooder.start()
        outcome = load.run(until_s=WARM_UP_S + seconds)
        flooded = told.get(timeout=60.0)
        flooder.kill()
        kept = stored(folder, opened.ids)["raw"][1] // 5
        taken = stored(folder, [made[-1].id])["raw"][1] // 5
    # What the buffers of the connection hold is sent, but not read.
    read_s = taken * part.packet_s
    allowed_s = speed * seconds + BURST_S
    print(heading("latency of the neighbours, ms"))
    print(row("packet sent -> frame published", outcome.published_ms))
    print(row("load generator late", outcome.late_ms))
    print(
        f"flooding  {flooded} packets sent in {seconds:.0f} s, {taken} taken: {read_s / seconds:.1f} times real time"
    )
    high = float(np.percentile(outcome.published_ms, 99))
    return judge(
        {
            f"neighbours' p99 below {LIMIT_MS:.0f} ms": (high < LIMIT_MS, f"{high:.1f} ms"),
            "no packet of theirs lost": (kept == outcome.sent, f"{kept} of {outcome.sent}"),
            f"{speed:.0f} times real time and {BURST_S:.0f} s at once taken of the flood, to a tenth": (
                0.9 * allowed_s <= read_s <= 1.1 * allowed_s,
                f"{read_s:.0f} of {allowed_s:.0f} s",
            ),
        }
    )


def main() -> int:
    """Overload a service, then flood one."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--most", type=int, default=600, help="sessions that come until the first is sent away"
    )
    parser.add_argument(
        "--seconds", type=float, default=30.0, help="how long the overload, and the flood, last"
    )
    parser.add_argument("--only", choices=("overload", "flood"))
    arguments = parser.parse_args()
    # Sessions stream from when they come until all is over; each arrives a while after the one before.
    longest_s = 2.0 * ARRIVAL_S * arguments.most + arguments.seconds + 120.0
    is_met = True
    if arguments.only != "flood":
        part, calibration = arms(longest_s)
        is_met = overload(part, calibration, arguments.most, arguments.seconds)
    if arguments.only != "overload":
        part, calibration = arms(arguments.seconds + WARM_UP_S)
        is_met = flood(part, calibration, arguments.seconds) and is_met
    return 0 if is_met else 1


if __name__ == "__main__":
    sys.exit(main())
