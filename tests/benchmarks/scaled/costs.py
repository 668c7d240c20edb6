"""What a live session costs each part of a service on many machines: `make bench-scaled`.

NATS, PostgreSQL, an edge and a worker as real processes on this machine, then a service in one process, with the same
sessions of 17 sensors at 100 Hz, each watched. Processor time is what the operating system counts of each process.
Then a second worker comes: how long it takes until it has its share, and how long nothing new is shown.
"""

import argparse
import asyncio
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import AsyncExitStack
from pathlib import Path

import psutil
from sqlalchemy import text

from app.database.engine import create_from_url
from app.gateway import DeviceStream, ServiceClient
from tests.app.live.live_load import swaying
from tests.benchmarks.crash import PERIOD_S
from tests.benchmarks.machine import processor
from tests.benchmarks.service import EMAIL, PASSWORD, ROOMY, make_patient, open_sessions, start_server
from tests.ports import free_port
from tests.scaled.cluster import Cluster
from tests.scaled.database import Database
from tests.scaled.killing import Run, streaming
from tests.scaled.streaming import Roving, shown_again

SETTLE_S = 10.0
MOVED_WITHIN_S = 10.0
MOST_TIMES = 2.0


def processor_s(pid: int) -> float:
    """Return the processor seconds of a process and of those that it started."""
    first = psutil.Process(pid)
    return sum(sum(one.cpu_times()[:2]) for one in (first, *first.children(recursive=True)))


async def used(parts: dict[str, Callable[[], float]], sessions: int, seconds: float) -> dict[str, float]:
    """Return milliseconds of processor time a second of a session, by part."""
    await asyncio.sleep(SETTLE_S)
    before, began_s = {name: of() for name, of in parts.items()}, time.monotonic()
    await asyncio.sleep(seconds)
    lasted_s = time.monotonic() - began_s
    return {name: 1000.0 * (of() - before[name]) / (sessions * lasted_s) for name, of in parts.items()}


async def add_worker(going: Run) -> tuple[float, float]:
    """Start a second worker; return how long after it is ready it has its share, and the longest gap of a session."""
    cluster = going.cluster
    for one in going.sessions:
        one.longest_gap_s = 0.0
    cluster.start("worker", "worker1")
    await asyncio.to_thread(cluster.until_ready, "worker1")
    began_s = time.monotonic()
    engine = create_from_url(cluster.url)
    question = text("SELECT count(*) FROM partition_hold GROUP BY holder")
    while True:
        with engine.connect() as connection:
            held = connection.scalars(question).all()
        if len(held) > 1 and max(held) - min(held) <= 1:
            break
        await asyncio.sleep(0.1)
    engine.dispose()
    moved_s = time.monotonic() - began_s
    await shown_again(going.sessions, time.monotonic())
    return moved_s, max(one.longest_gap_s for one in going.sessions)


async def scaled(
    folder: Path, calibration: dict[str, object], stream: DeviceStream, sessions: int, seconds: float
) -> tuple[dict[str, float], float, float]:
    """Measure a service on many machines."""
    database = Database(folder / "pg")
    cluster = Cluster(folder, database.make(), calibration)
    try:
        cluster.begin(edges=1, workers=1)
        parts: dict[str, Callable[[], float]] = {
            kind: lambda pid=cluster.processes[name].pid: processor_s(pid)  # type: ignore[misc]
            for kind, name in (("edge", "edge0"), ("broker", "nats"), ("worker", "worker0"))
        }
        parts["database"] = database.processor_s
        async with streaming(cluster, database, stream, sessions) as going:
            found = await used(parts, sessions, seconds)
            moved_s, gap_s = await add_worker(going)
            await going.finish()
        return found, moved_s, gap_s
    finally:
        cluster.close()
        database.close()


async def embedded(
    port: int, pid: int, patient_id: str, stream: DeviceStream, sessions: int, seconds: float
) -> float:
    """Measure a service in one process."""
    async with AsyncExitStack() as stack:
        client = await stack.enter_async_context(ServiceClient(f"http://127.0.0.1:{port}"))
        await client.sign_in(EMAIL, PASSWORD)
        made = await open_sessions(port, patient_id, stream, sessions)
        streamed = [Roving(number, one["id"], [client], stream) for number, one in enumerate(made)]
        tasks = [asyncio.create_task(work) for one in streamed for work in (one.look_on(), one.send())]
        try:
            await asyncio.gather(*(one.newer_than(-1) for one in streamed))
            return (await used({"service": lambda: processor_s(pid)}, sessions, seconds))["service"]
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)


def report(found: dict[str, float], alone: float, moved_s: float, gap_s: float, sessions: int) -> bool:
    """Print what was found; True when all that is required holds."""
    print(f"\nmachine   {processor()}, {psutil.cpu_count()} cores; {sessions} sessions, each watched")
    print(f"\n{'processor, ms a second of a session':<44}")
    for name, value in found.items():
        print(f"  {name:<30}{value:8.2f}")
    total = sum(found.values())
    print(f"  {'together':<30}{total:8.2f}\n  {'one process':<30}{alone:8.2f}")
    judged = {
        f"at most {MOST_TIMES:.0f} times one process": (total <= MOST_TIMES * alone, f"{total / alone:.2f}"),
        f"a worker that comes has its share within {MOVED_WITHIN_S:.0f} s": (
            moved_s <= MOVED_WITHIN_S,
            f"{moved_s:.1f} s, nothing new for {gap_s:.2f} s",
        ),
    }
    for what, (is_met, words) in judged.items():
        print(f"required  {what}: {'met' if is_met else 'MISSED'}: {words}")
    return all(is_met for is_met, _ in judged.values())


def main() -> int:
    """Measure both layouts."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sessions", type=int, default=20)
    parser.add_argument("--seconds", type=float, default=60.0)
    arguments = parser.parse_args()
    calibration, stream = swaying(PERIOD_S)
    with tempfile.TemporaryDirectory(prefix="tm-") as name:
        folder = Path(name)
        found, moved_s, gap_s = asyncio.run(
            scaled(folder, calibration, stream, arguments.sessions, arguments.seconds)
        )
        (folder / "one").mkdir(mode=0o700)
        url, patient_id = make_patient(folder / "one", calibration)
        port = free_port()
        process = start_server(url, folder / "one", port, settings=ROOMY)
        try:
            alone = asyncio.run(
                embedded(port, process.pid, patient_id, stream, arguments.sessions, arguments.seconds)
            )
        finally:
            process.terminate()
            process.wait(60)
    return 0 if report(found, alone, moved_s, gap_s, arguments.sessions) else 1


if __name__ == "__main__":
    sys.exit(main())
