"""The service is killed again and again in mid-stream: `python -m tests.benchmarks.crash --times 100`.

The real service on a fresh SQLite file; in this other process the gateways that integrators copy (`app.gateway`), one a
session in real time, and somebody who watches each. SIGKILL comes at a moment drawn by chance, some while sessions are
only just coming back, and only to the service itself: processes that it started must end by themselves. At the end the
gateways have forgotten what was acknowledged, so whatever the store lost then is lost for good.

Required: every packet is stored once, as it was sent; and from each start of the process to a frame of the last session
that comes back 8 s. Times are of this machine with all that it does beside.
"""

import argparse
import asyncio
import contextlib
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from subprocess import Popen

import httpx
import numpy as np
import psutil
from websockets.asyncio.client import connect
from websockets.exceptions import WebSocketException

from app.database.engine import create_from_url
from app.errors import TelemotionError
from app.gateway import DeviceStream, GatewayClient, ServiceClient
from app.gateway.client import Delivery
from app.gateway.encoding import EPOCH_US
from app.network.packet import HEADER_BYTES, encode_packet
from app.recordings.signals.store import read_packets
from tests.app.live.live_load import swaying
from tests.benchmarks.machine import processor
from tests.benchmarks.service import (
    EMAIL,
    PASSWORD,
    compile_usual,
    environment_of,
    launch,
    make_patient,
    open_sessions,
)
from tests.patience import PATIENCE_S
from tests.ports import free_port

FIRST_FRAME_S = 8.0
PERIOD_S = 62.85
"""Of the movement, which begins anew: ten turns of a sine."""
EARLY = 0.2
"""Share of kills that come while sessions are still coming back."""


@dataclass
class Life:
    """One process of the service, from its start to its kill."""

    began_s: float = field(default_factory=time.monotonic)
    ready_s: float = np.nan
    frame_s: dict[int, float] = field(default_factory=dict)
    """From the start to the first frame, by session."""
    changed: asyncio.Event = field(default_factory=asyncio.Event)

    async def until_back(self, count: int) -> None:
        """Return when so many sessions have shown a frame."""
        async with asyncio.timeout(PATIENCE_S):
            while len(self.frame_s) < count:
                self.changed.clear()
                await self.changed.wait()


@dataclass
class Outcome:
    """What came of it."""

    lives: list[Life] = field(default_factory=list)
    sent: int = 0
    stored: int = 0
    twice: int = 0
    missing: int = 0
    different: int = 0
    resent: int = 0
    left_over: int = 0
    """Processes of killed services that have not ended."""

    @property
    def is_whole(self) -> bool:
        """Whether every packet is there once, as it was sent."""
        return self.sent == self.stored > 0 and not (self.twice or self.missing or self.different)


class Session:
    """One session: its gateway, and somebody who watches."""

    def __init__(self, number: int, session_id: str, client: ServiceClient, stream: DeviceStream) -> None:
        self.number, self.id, self.client, self.stream = number, session_id, client, stream
        self.is_over = False
        self.sent = 0
        self.gateway = GatewayClient(
            client.ingest_url, lambda: client.ticket(session_id), stream.hello, give_up_s=PATIENCE_S
        )

    def time_us(self, number: int) -> int:
        """Return the device's clock at a packet."""
        return EPOCH_US + round(1e6 * number * self.stream.packet_s)

    def packet(self, number: int) -> bytes:
        """Return a packet; no two sessions send the same."""
        stream = self.stream
        first = stream.ticks_per_packet * ((number + 37 * self.number) % stream.packet_count)
        return encode_packet(
            stream.counts[first : first + stream.ticks_per_packet],
            sequence=number,
            device_time_us=self.time_us(number),
            tick_interval_us=round(1e6 / stream.rate_hz),
            channels=stream.channels,
        )

    def deliveries(self) -> Iterator[Delivery]:
        """Yield packets until it is over."""
        while not self.is_over:
            number, self.sent = self.sent, self.sent + 1
            yield Delivery(number, self.packet(number), number * self.stream.packet_s)

    async def watch(self, lives: list[Life]) -> None:
        """Look on until cancelled, over every restart."""
        address = f"{self.client.server.replace('http', 'ws', 1)}/ws/live/{self.id}"
        while True:
            life = lives[-1]
            with contextlib.suppress(TelemotionError, WebSocketException, OSError, TimeoutError):
                ticket = await self.client.ticket(self.id, "live")
                async with connect(address, compression=None, proxy=None) as socket:
                    await socket.send(f'{{"ticket": "{ticket}"}}')
                    async for message in socket:
                        if isinstance(message, bytes) and self.number not in life.frame_s:
                            life.frame_s[self.number] = time.monotonic() - life.began_s
                            life.changed.set()
            await asyncio.sleep(0.1)

    def check(self, url: str, outcome: Outcome) -> None:
        """Count what is stored of it against what was sent."""
        engine = create_from_url(url)
        seen: set[int] = set()
        for packet in read_packets(engine, self.id):
            number = packet.sequence
            outcome.twice += number in seen
            seen.add(number)
            outcome.different += (packet.device_time_us, packet.payload) != (
                self.time_us(number),
                self.packet(number)[HEADER_BYTES:],
            )
        engine.dispose()
        outcome.sent += self.sent
        outcome.stored += len(seen)
        outcome.missing += len(set(range(self.sent)) - seen)
        outcome.resent += self.gateway.report.resent


def is_alive(process: psutil.Process) -> bool:
    """Return whether it still runs; one that has ended may wait to be collected by whoever inherited it."""
    with contextlib.suppress(psutil.NoSuchProcess):
        return process.is_running() and process.status() != psutil.STATUS_ZOMBIE
    return False


def left_over(killed: list[psutil.Process]) -> int:
    """Return how many have not ended: a helper that was just starting learns of the death once it has started."""
    until = time.monotonic() + PATIENCE_S
    while (left := sum(map(is_alive, killed))) and time.monotonic() < until:
        time.sleep(0.1)
    return left


async def live_on(environment: Mapping[str, str], client: ServiceClient, life: Life) -> Popen[bytes]:
    """Start the service; return when it can store."""
    process = launch(environment)
    while True:
        with contextlib.suppress(httpx.TransportError):
            if (await client.http.get("/api/ready")).is_success:
                life.ready_s = time.monotonic() - life.began_s
                return process
        if process.poll() is not None or time.monotonic() - life.began_s > PATIENCE_S:
            raise RuntimeError("the service did not start")
        await asyncio.sleep(0.05)


async def run(
    environment: Mapping[str, str], patient_id: str, stream: DeviceStream, sessions: int, times: int
) -> Outcome:
    """Stream, kill, start again; at last let the gateways bring what they hold, and count."""
    random, outcome = np.random.default_rng(1), Outcome()
    lives, address = outcome.lives, environment["TELEMOTION_BASE_URL"]
    lives.append(Life())
    async with ServiceClient(address) as client:
        process = await live_on(environment, client, lives[-1])
        killed: list[psutil.Process] = []
        try:
            await client.sign_in(EMAIL, PASSWORD)
            port = int(address.rsplit(":", 1)[1])
            made = await open_sessions(port, patient_id, stream, sessions)
            streamed = [Session(number, one["id"], client, stream) for number, one in enumerate(made)]
            tasks = [asyncio.create_task(one.watch(lives)) for one in streamed]
            gateways = [
                asyncio.create_task(one.gateway.run(one.deliveries(), goodbye=False)) for one in streamed
            ]
            for number in range(times):
                is_early = number > 0 and random.random() < EARLY
                await lives[-1].until_back(1 if is_early else sessions)
                await asyncio.sleep(random.uniform(0.0, 1.0) if is_early else random.uniform(0.2, 2.0))
                killed += psutil.Process(process.pid).children(recursive=True)
                process.kill()
                process.wait()
                lives.append(Life())
                process = await live_on(environment, client, lives[-1])
                told(number + 1, times, lives[-1], streamed)
            await lives[-1].until_back(sessions)
            for one in streamed:
                one.is_over = True
            await asyncio.gather(*gateways)
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
        finally:
            process.terminate()
            process.wait(PATIENCE_S)
    outcome.left_over = left_over(killed)
    for one in streamed:
        one.check(environment["TELEMOTION_DATABASE_URL"], outcome)
    return outcome


def told(number: int, times: int, life: Life, sessions: list[Session]) -> None:
    """Say now and then how far it is."""
    if number % 10 == 0:
        sent = sum(one.sent for one in sessions)
        print(
            f"killed {number} of {times} times, {sent} packets, ready {life.ready_s:.1f} s after it",
            flush=True,
        )


def report(outcome: Outcome, sessions: int) -> bool:
    """Print what came of it; True when all that is required holds."""
    back = [life for life in outcome.lives[1:] if len(life.frame_s) == sessions]
    first = [min(life.frame_s.values()) for life in outcome.lives[1:] if life.frame_s]
    last = [max(life.frame_s.values()) for life in back]
    print(f"\nmachine   {processor()}, {psutil.cpu_count()} cores")
    print(
        f"killed    {len(outcome.lives) - 1} times, {len(outcome.lives) - 1 - len(back)} of them before all were back"
    )
    print(f"\n{'from the start of the process, s':<44}{'median':>9}{'most':>9}")
    ready = [life.ready_s for life in outcome.lives[1:]]
    for what, found in (("ready", ready), ("first frame of a session", first), ("of the last session", last)):
        print(f"{what:<44}{np.median(found):9.2f}{max(found):9.2f}")
    print(
        f"\npackets   {outcome.sent} sent, {outcome.resent} of them again, {outcome.stored} stored;"
        f" {outcome.missing} missing, {outcome.twice} twice, {outcome.different} different"
    )
    judged = {
        "every packet stored once, as it was sent": (outcome.is_whole, f"{outcome.stored} of {outcome.sent}"),
        f"frames of all sessions within {FIRST_FRAME_S:.0f} s": (
            max(last) < FIRST_FRAME_S,
            f"{max(last):.1f} s",
        ),
        "no process of a killed service left": (outcome.left_over == 0, f"{outcome.left_over}"),
    }
    for what, (is_met, found) in judged.items():
        print(f"required  {what}: {'met' if is_met else 'MISSED'} with {found}")
    return all(is_met for is_met, _ in judged.values())


def main() -> int:
    """Kill a service as often as is asked."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--times", type=int, default=100)
    parser.add_argument("--sessions", type=int, default=20)
    arguments = parser.parse_args()
    calibration, stream = swaying(PERIOD_S)
    with tempfile.TemporaryDirectory(prefix="telemotion-bench-") as name:
        folder = Path(name)
        url, patient_id = make_patient(folder, calibration)
        environment = environment_of(url, folder, free_port())
        # Python's own helper of processes says what the killed one left to it.
        environment["PYTHONWARNINGS"] = "ignore:resource_tracker"
        compile_usual()
        outcome = asyncio.run(run(environment, patient_id, stream, arguments.sessions, arguments.times))
    return 0 if report(outcome, arguments.sessions) else 1


if __name__ == "__main__":
    sys.exit(main())
