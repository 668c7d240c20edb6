"""Two edges, two workers, NATS and PostgreSQL: a worker dies in mid-stream."""

import asyncio
import signal
import struct
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from sqlalchemy import text
from websockets.asyncio.client import connect

from app.database.engine import create_from_url
from app.gateway import DeviceStream, ServiceClient
from tests.app.live.live_load import swaying
from tests.benchmarks.crash import Life, Outcome, Session
from tests.benchmarks.service import open_sessions
from tests.patience import PATIENCE_S
from tests.scaled.cluster import EMAIL, PASSWORD, Cluster
from tests.scaled.embedded import embedded_shown

pytest.importorskip("nats", reason="the extra `scaled` is not installed")
pytestmark = [
    pytest.mark.slow(
        "a whole service starts, a worker dies, and a session is estimated again to compare every bit"
    ),
    pytest.mark.postgres,
]

SESSIONS = 4
BEFORE_S, AFTER_S = 6.0, 6.0
FRAMES_WITHIN_S = 20.0
"""Of a worker's death; tests share their machine."""


@pytest.fixture
def cluster(tmp_path: Path, postgresql_database: Callable[[], str]) -> Iterator[tuple[Cluster, DeviceStream]]:
    calibration, stream = swaying(62.85)
    running = Cluster(tmp_path, postgresql_database(), calibration)
    try:
        running.begin()
        yield running, stream
    finally:
        running.close()


class Watched(Session):
    """A session whose views stay connected when its worker dies, and that holds every bit that they showed."""

    def __init__(self, number: int, session_id: str, client: ServiceClient, stream: DeviceStream) -> None:
        super().__init__(number, session_id, client, stream)
        self.shown: dict[int, bytes] = {}
        """The numbers of a frame, by tick."""

    def show(self, block: bytes) -> None:
        ticks, columns, first_tick = struct.unpack_from("<III", block, 4)
        head, size = len(block) - 4 * ticks * columns, 4 * columns
        for number in range(ticks):
            self.shown[first_tick + number] = block[head + number * size : head + (number + 1) * size]

    async def watch(self, lives: list[Life]) -> None:
        address = f"{self.client.server.replace('http', 'ws', 1)}/ws/live/{self.id}"
        ticket = await self.client.ticket(self.id, "live")
        async with connect(address, compression=None, proxy=None) as socket:
            await socket.send(f'{{"ticket": "{ticket}"}}')
            async for message in socket:
                if isinstance(message, bytes):
                    self.show(message)
                life = lives[-1]
                if isinstance(message, bytes) and self.number not in life.frame_s:
                    life.frame_s[self.number] = time.monotonic() - life.began_s
                    life.changed.set()


class Run:
    """Sessions that stream by way of two edges, each watched at the other one."""

    def __init__(self, cluster: Cluster, stream: DeviceStream) -> None:
        self.cluster, self.stream = cluster, stream
        self.sessions: list[Watched] = []
        self.killed_tick = 0
        self.lives = [Life()]

    async def go(self, disturb: Callable[["Run"], "asyncio.Future[None] | object"]) -> None:
        """Stream; disturb in the middle; stop when everything is acknowledged."""
        ports, address = self.cluster.ports, self.cluster.address
        async with ServiceClient(address("edge0")) as first, ServiceClient(address("edge1")) as second:
            for client in (first, second):
                await client.sign_in(EMAIL, PASSWORD)
            made = await open_sessions(ports["edge0"], self.cluster.patient_id, self.stream, SESSIONS)
            clients = (first, second)
            self.sessions = [
                Watched(number, one["id"], clients[number % 2], self.stream)
                for number, one in enumerate(made)
            ]
            watching = [asyncio.create_task(one.watch(self.lives)) for one in self.sessions]
            gateways = [
                asyncio.create_task(one.gateway.run(one.deliveries(), goodbye=False)) for one in self.sessions
            ]
            try:
                await self.lives[-1].until_back(SESSIONS)
                await asyncio.sleep(BEFORE_S)
                await disturb(self)  # type: ignore[misc]
                await asyncio.sleep(AFTER_S)
                for one in self.sessions:
                    one.is_over = True
                await asyncio.gather(*gateways)
                await self.until_stored()
            finally:
                for task in (*watching, *gateways):
                    task.cancel()
                await asyncio.gather(*watching, *gateways, return_exceptions=True)

    async def frames_again(self) -> float:
        """Return how long it takes from now until every session shows a frame."""
        began_s = time.monotonic()
        # What the dead worker sent last may still be on its way.
        await asyncio.sleep(0.3)
        self.lives.append(Life(began_s))
        async with asyncio.timeout(PATIENCE_S):
            await self.lives[-1].until_back(SESSIONS)
        return max(self.lives[-1].frame_s.values())

    async def until_stored(self) -> None:
        """Return when as much is stored as was sent."""
        async with asyncio.timeout(PATIENCE_S):
            while self.checked().stored < sum(one.sent for one in self.sessions):  # noqa: ASYNC110
                await asyncio.sleep(0.5)
        # Frames are stored with the packets behind them.
        await asyncio.sleep(2.0)

    def checked(self) -> Outcome:
        """Count what is stored against what was sent."""
        outcome = Outcome()
        for one in self.sessions:
            one.check(self.cluster.url, outcome)
        return outcome


def test_a_worker_dies_and_nothing_acknowledged_is_lost_and_no_bit_differs(cluster, tmp_path: Path) -> None:
    parts, stream = cluster
    run = Run(parts, stream)
    gaps: list[float] = []

    async def kill_a_worker(run: Run) -> None:
        run.killed_tick = max(run.sessions[0].shown)
        # Whichever worker has session 0.
        holder = "worker0" if run.sessions[0].id in parts.log("worker0") else "worker1"
        parts.kill(holder)
        gaps.append(await run.frames_again())

    asyncio.run(run.go(kill_a_worker))
    outcome = run.checked()
    assert outcome.is_whole, outcome
    assert all(one.gateway.report.unacknowledged == 0 for one in run.sessions)
    print(f"frames of every session {gaps[0]:.2f} s after a worker's death")
    assert gaps[0] < FRAMES_WITHIN_S
    (tmp_path / "one").mkdir(mode=0o700)
    ours = run.sessions[0].shown
    theirs = embedded_shown(tmp_path / "one", parts.calibration, stream, run.sessions[0])
    both = ours.keys() & theirs.keys()
    assert len(both) > 100 * BEFORE_S
    assert max(both) > run.killed_tick
    assert not [tick for tick in both if ours[tick] != theirs[tick]]


def test_a_worker_that_was_paused_beyond_its_lease_writes_nothing(
    cluster: tuple[Cluster, DeviceStream],
) -> None:
    parts, stream = cluster
    run = Run(parts, stream)
    written: dict[str, int] = {}

    async def pause_a_worker(run: Run) -> None:
        parts.signal("worker0", signal.SIGSTOP)
        await run.frames_again()
        await asyncio.sleep(2.0)
        holders = await asyncio.to_thread(holders_of, parts.url)
        parts.signal("worker0", signal.SIGCONT)
        written.update(holders)
        until = time.monotonic() + PATIENCE_S
        while "held by another worker" not in parts.log("worker0") and "is lost" not in parts.log("worker0"):
            assert time.monotonic() < until, parts.log("worker0")
            await asyncio.sleep(0.1)

    asyncio.run(run.go(pause_a_worker))
    # Whatever it still had was refused: each packet is stored once, by one of two writers of the same sessions.
    assert run.checked().is_whole
    assert len(set(written)) == 1, "all partitions were taken over by the one that was left"


def holders_of(url: str) -> dict[str, int]:
    engine = create_from_url(url)
    with engine.connect() as connection:
        rows = connection.execute(text("SELECT holder, count(*) FROM partition_hold GROUP BY holder")).all()
    engine.dispose()
    return {row[0]: row[1] for row in rows}
