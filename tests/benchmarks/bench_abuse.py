"""What neighbours notice of one account that takes all it can get: `make bench-abuse`.

The real service with the limits that it comes with. One account of clinic A opens 100 3D views, uploads 100 files that
unpack to a thousand times their size, asks for ten exports at once, and streams five times faster than real time; what
is refused it asks for again at once, whatever the answer says. Meanwhile a colleague in clinic A and a therapist of
clinic B each stream one patient and watch, as in `bench_live`, and clinic B uploads a recording now and then.

Required: frames of the two within 100 ms at the 99th percentile and no packet of theirs lost; the analysis of every
upload of clinic B begins within 10 s. Account, neighbours and clinic B are processes of their own.
"""

import argparse
import asyncio
import multiprocessing
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, replace
from multiprocessing.queues import Queue
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import psutil
from websockets.asyncio.client import ClientConnection
from websockets.asyncio.client import connect as connect_socket
from websockets.exceptions import WebSocketException
from websockets.typing import Subprotocol

from app.database.engine import create_from_url
from app.database.unit_of_work import unit_of_work
from app.errors import TelemotionError
from app.gateway import DeviceStream, GatewayClient, ServiceClient
from app.network.packet_log import log_entry, log_head
from app.patients.models import Mounting
from app.recordings.schemas import SessionIn
from app.viewer.wire import PROTOCOL
from tests.app.readers.test_unpacked import bomb
from tests.benchmarks.live.load import PATIENCE_S, WARM_UP_S, Load, Opened, connect, create
from tests.benchmarks.live.parts import moving_arms, part_of
from tests.benchmarks.live.report import heading, judge, row
from tests.benchmarks.live.watching import stored
from tests.benchmarks.service import (
    EMAIL,
    PASSWORD,
    add_clinic,
    add_patient,
    make_patient,
    start_server,
)
from tests.ports import free_port

GREEDY, FOREIGN = "greedy@bench.example", "therapist@other.example"
LATENCY_MS, BEGIN_S = 100.0, 10.0
VIEWS, BOMBS, EXPORTS, SPEED = 100, 100, 10, 5.0
BOMB_BYTES = 3 << 29
AGAIN_S = 0.25
UPLOAD_EVERY_S = 12.0


@dataclass
class Account:
    """Who takes part, from a process of its own."""

    port: int
    email: str
    patient_id: str
    stream: DeviceStream
    log: Path
    seconds: float

    @property
    def address(self) -> str:
        return f"http://127.0.0.1:{self.port}"


class Greedy:
    """The account that takes all it can get; `answers` counts by what was asked for and the answer."""

    def __init__(self, account: Account, client: ServiceClient, bomb_path: Path) -> None:
        self.account, self.client = account, client
        self.bomb = bomb_path.read_bytes()
        self.answers: Counter[str] = Counter()
        self.until = time.monotonic() + account.seconds
        self.opening = asyncio.Lock()
        self.blocks = 0
        """Messages of the scenes that arrived."""

    async def run(self, session_id: str) -> None:
        tasks = [self.view(session_id) for _ in range(VIEWS)]
        tasks += [self.again("bomb", self.upload) for _ in range(BOMBS)]
        tasks += [self.again("export", self.export) for _ in range(EXPORTS)]
        tasks.append(self.stream())
        left_s = max(0.0, self.until - time.monotonic())
        _, open_still = await asyncio.wait([asyncio.create_task(one) for one in tasks], timeout=left_s)
        for one in open_still:
            one.cancel()
        await asyncio.gather(*open_still, return_exceptions=True)
        self.answers["view messages received"] = self.blocks

    async def again(self, what: str, ask: Callable[[], Awaitable[int]]) -> None:
        while time.monotonic() < self.until:
            try:
                status = await ask()
            except httpx.TransportError as error:
                self.answers[f"{what} {type(error).__name__}"] += 1
                continue
            self.answers[f"{what} {status}"] += 1
            if status not in (429, 503):
                return
            await asyncio.sleep(AGAIN_S)

    async def upload(self) -> int:
        return (await send(self.client, self.account.patient_id, "qmt_mat", self.bomb)).status_code

    async def export(self) -> int:
        path = f"/api/patients/{self.account.patient_id}/export"
        async with self.client.http.stream("GET", path, timeout=300.0) as answer:
            async for _ in answer.aiter_raw():
                pass
            return answer.status_code

    async def view(self, session_id: str) -> None:
        """Open a replay and look at it to the end, with a scene of its own."""
        while time.monotonic() < self.until:
            # One after the other: a scene that nobody looks at yet makes room for the next.
            async with self.opening:
                socket = await self.look(session_id)
            if socket is not None:
                break
            await asyncio.sleep(AGAIN_S)
        else:
            return
        try:
            async for _ in socket:
                self.blocks += 1
            self.answers[f"view closed {socket.close_code}"] += 1
        except WebSocketException as error:
            self.answers[f"view {error}"] += 1
        finally:
            await socket.close()

    async def look(self, session_id: str) -> ClientConnection | None:
        """Ask for a scene and connect to it; None where the service refuses either."""
        http = self.client.http
        opened = await http.post(f"/api/sessions/{session_id}/views", json={"mode": "replay"}, timeout=300.0)
        if opened.is_error:
            self.answers[f"view {opened.status_code}"] += 1
            return None
        cookies = "; ".join(f"{one.name}={one.value}" for one in http.cookies.jar)
        address = f"{self.account.address}/viewer/{opened.json()['id']}".replace("http", "ws", 1)
        try:
            socket = await connect_socket(
                address,
                additional_headers={"Cookie": cookies},
                origin=self.account.address,  # type: ignore[arg-type]
                subprotocols=[Subprotocol(PROTOCOL)],
                max_size=None,
                open_timeout=60.0,
                proxy=None,
            )
        except (WebSocketException, TimeoutError, OSError) as error:
            self.answers[f"view's socket: {error}"] += 1
            return None
        self.answers["view opened"] += 1
        return socket

    async def stream(self) -> None:
        """Send all that there is, five times faster than real time, again and again."""
        account = self.account
        wanted = SessionIn(patient_id=account.patient_id, placements=list(account.stream.placements))  # type: ignore[arg-type]
        counts = account.stream.counts
        much = replace(
            account.stream,
            counts=np.tile(counts, (int(SPEED * account.seconds * 100 / len(counts)) + 1, 1, 1)),
        )
        made = await self.client.create_session(wanted)
        gateway = GatewayClient(
            self.client.ingest_url, lambda: self.client.ticket(made.id), much.hello, pace=SPEED
        )
        try:
            await gateway.run(much.deliveries(much.plan()))
        except TelemotionError as error:
            self.answers[f"stream {error.code}"] += 1
        finally:
            self.answers["stream packets sent"] = gateway.report.sent


async def send(client: ServiceClient, patient_id: str, kind: str, content: bytes) -> httpx.Response:
    """Upload a recording."""
    declaration = f'{{"patient_id": "{patient_id}", "format": "{kind}"}}'
    files = {"declaration": (None, declaration, "application/json"), "file": ("recording", content)}
    return await client.http.post("/api/uploads", files=files, timeout=300.0)  # type: ignore[arg-type]


async def analysed(client: ServiceClient, account: Account) -> str:
    """Upload the recording and wait for its analysis; return the session."""
    answer = await send(client, account.patient_id, "packet_log", account.log.read_bytes())
    job = answer.raise_for_status().json()
    while job["status"] not in ("complete", "failed"):
        await asyncio.sleep(0.2)
        job = (await client.http.get(f"/api/jobs/{job['id']}")).json()
    assert job["status"] == "complete", job
    return str(job["session_id"])


def be_greedy(account: Account, bomb_path: Path, begun: Any, told: "Queue[Counter[str]]") -> None:
    """Process of the greedy account: record something, say so by `begun`, then take all there is."""

    async def run() -> None:
        async with ServiceClient(account.address) as client:
            client.http = httpx.AsyncClient(
                base_url=client.server,
                headers={"Origin": client.server},
                timeout=30.0,
                trust_env=False,
                limits=httpx.Limits(max_connections=None),
            )
            await client.sign_in(account.email, PASSWORD)
            session_id = await analysed(client, account)
            begun.set()
            greedy = Greedy(account, client, bomb_path)
            await greedy.run(session_id)
            told.put(greedy.answers)

    asyncio.run(run())


def work_next_door(account: Account, told: "Queue[list[float]]") -> None:
    """Process of clinic B: upload now and then; tell how long after asking each analysis began, s."""

    async def run() -> None:
        waits: list[float] = []
        until = time.monotonic() + account.seconds
        async with ServiceClient(account.address) as client:
            await client.sign_in(account.email, PASSWORD)
            while (asked := time.monotonic()) + BEGIN_S < until:
                answer = await send(client, account.patient_id, "packet_log", account.log.read_bytes())
                job = answer.raise_for_status().json()
                while job["status"] == "queued" and time.monotonic() < until:
                    await asyncio.sleep(0.1)
                    job = (await client.http.get(f"/api/jobs/{job['id']}")).json()
                waits.append(time.monotonic() - asked)
                await asyncio.sleep(max(0.0, UPLOAD_EVERY_S - waits[-1]))
        told.put(waits)

    asyncio.run(run())


def add_others(url: str) -> dict[str, str]:
    """Add the greedy account to clinic A, and clinic B; return the patients by e-mail address."""
    engine = create_from_url(url)
    with unit_of_work(engine) as session:
        known = session.query(Mounting).one()
        calibration = known.calibration
        clinic_id = session.connection().exec_driver_sql("SELECT clinic_id FROM patient").scalar_one()
        patients = {
            GREEDY: add_patient(session, clinic_id, GREEDY, calibration),
            FOREIGN: add_patient(session, add_clinic(session), FOREIGN, calibration),
        }
    engine.dispose()
    return patients


def write_recording(path: Path, stream: DeviceStream) -> Path:
    """Write the whole stream as a packet log."""
    hello = stream.hello("").model_dump(mode="json", exclude={"ticket"}, exclude_none=True)
    with path.open("wb") as file:
        file.write(log_head(hello))
        for number in range(stream.packet_count):
            file.write(log_entry(stream.packet(number)))
    return path


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=60.0, help="measured time, after 5 s of warming up")
    parser.add_argument("--alone", action="store_true", help="without the greedy account, to compare")
    arguments = parser.parse_args()
    seconds = arguments.seconds + WARM_UP_S
    spawn = multiprocessing.get_context("spawn")
    with tempfile.TemporaryDirectory(prefix="telemotion-bench-") as name:
        folder = Path(name)
        print("preparing the streams, the files and the database ...", flush=True)
        stream, calibration = moving_arms(seconds)
        url, patient_id = make_patient(folder, calibration)
        patients = add_others(url) | {EMAIL: patient_id}
        log = write_recording(folder / "recording.tmlog", stream)
        bomb_path = bomb(folder / "bomb.mat", BOMB_BYTES, stated_bytes=1000)
        wanted = SessionIn(patient_id="", placements=list(stream.placements))  # type: ignore[arg-type]
        part = part_of("neighbours", wanted, stream, int(seconds / stream.packet_s))
        port = free_port()
        process = start_server(url, folder, port, settings={})
        children: list[Any] = []
        try:
            answers: Queue[Counter[str]] = spawn.Queue()
            waits: Queue[list[float]] = spawn.Queue()
            begun = spawn.Event()
            greedy = Account(port, GREEDY, patients[GREEDY], stream, log, seconds)
            foreign = Account(port, FOREIGN, patients[FOREIGN], stream, log, seconds)
            if not arguments.alone:
                children.append(
                    spawn.Process(target=be_greedy, args=(greedy, bomb_path, begun, answers), daemon=True)
                )
                children[0].start()
                if not begun.wait(180.0):
                    raise TimeoutError("the greedy account's first recording was not analysed")
            sessions = []
            for email in (EMAIL, FOREIGN):
                sessions += asyncio.run(create(port, patients[email], [(part, 1)], email))
            opened = Opened()
            connect(port, sessions, opened, time.monotonic() + PATIENCE_S)
            children.append(spawn.Process(target=work_next_door, args=(foreign, waits), daemon=True))
            children[-1].start()
            print(f"running for {seconds:.0f} s ...", flush=True)
            outcome = Load(opened, psutil.Process(process.pid)).run(until_s=seconds)
            taken = Counter() if arguments.alone else answers.get(timeout=60.0)
            began = waits.get(timeout=60.0)
            arrived = stored(folder, opened.ids)["raw"][1] // stream.ticks_per_packet
        finally:
            for child in children:
                child.kill()
            process.terminate()
            process.wait(60)
    print(heading("latency of the neighbours, ms"))
    print(row("packet sent -> frame published", outcome.published_ms))
    print(row("packet sent -> frame at the dashboard", outcome.received_ms))
    print(row("load generator late", outcome.late_ms))
    print("\ngreedy    " + ", ".join(f"{what}: {count}" for what, count in sorted(taken.items())))
    print("clinic B  analyses began after " + ", ".join(f"{wait:.1f}" for wait in began) + " s")
    high = float(np.percentile(outcome.received_ms, 99))
    met = {
        f"neighbours' frames below {LATENCY_MS:.0f} ms at p99": (high < LATENCY_MS, f"{high:.1f} ms"),
        "no packet of theirs lost": (arrived == outcome.sent, f"{arrived} of {outcome.sent}"),
        f"clinic B's analyses begin within {BEGIN_S:.0f} s": (
            bool(began) and max(began) < BEGIN_S,
            f"{max(began, default=np.nan):.1f} s",
        ),
    }
    return 0 if judge(met) else 1


if __name__ == "__main__":
    sys.exit(main())
