"""Killing the parts of a service on many machines while sessions stream, and what is seen of it."""

import asyncio
import shutil
import tempfile
import time
from collections.abc import AsyncIterator, Container, Iterator, Sequence
from contextlib import AsyncExitStack, ExitStack, asynccontextmanager, contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from app.gateway import DeviceStream, ServiceClient
from tests.app.live.live_load import swaying
from tests.benchmarks.service import open_sessions
from tests.patience import PATIENCE_S
from tests.scaled.cluster import EMAIL, PASSWORD, Cluster
from tests.scaled.database import Database
from tests.scaled.streaming import Roving, Stored, check_stored, shown_again
from tests.scaled.tls.certificates import Authority
from tests.scaled.tls.front import by_tls

AWAY_S = 1.0
"""So long a broker or a database is not there before it is started again."""


Calibration = dict[str, object]


@contextmanager
def whole_service(
    authority: Authority | None = None,
    kind: type[Cluster] = Cluster,
) -> Iterator[tuple[Cluster, Database, DeviceStream, Calibration]]:
    """Run everything that there is, with a database that can be killed; gives a stream and its calibration too.

    With an authority NATS and PostgreSQL speak TLS only.
    """
    # A path short enough for the socket of PostgreSQL.
    folder = Path(tempfile.mkdtemp(prefix="tm-"))
    calibration, stream = swaying(62.85)
    database = Database(folder / "pg")
    url = database.make()
    with ExitStack() as stack:
        stack.callback(shutil.rmtree, folder, ignore_errors=True)
        stack.callback(database.close)
        if authority is not None:
            url, _ = stack.enter_context(by_tls(url, authority))
        cluster = kind(folder, url, calibration, authority)
        stack.callback(cluster.close)
        cluster.begin()
        yield cluster, database, stream, calibration


@dataclass
class Kill:
    """What was seen of one kill."""

    name: str
    shown_s: list[float]
    """Until each session showed something new: from the kill, or from the start of what was started again."""
    gap_s: float
    """Longest time that any session showed nothing new, from the kill on."""


@dataclass
class Run:
    """Sessions that stream through a cluster."""

    cluster: Cluster
    database: Database
    sessions: list[Roving]
    kills: list[Kill] = field(default_factory=list)

    async def kill(self, name: str) -> Kill:
        """Kill a part, start it again, and see when every session shows something new.

        Parameters
        ----------
        name : str
            `workerN`, `edgeN`, `nats` or `database`.
        """
        for one in self.sessions:
            one.longest_gap_s = 0.0
        since_s, starting = time.monotonic(), None
        if name == "database":
            await asyncio.to_thread(self.database.kill)
            await asyncio.sleep(AWAY_S)
            since_s = time.monotonic()
            starting = asyncio.create_task(asyncio.to_thread(self.database.start))
        else:
            self.cluster.kill(name)
            if name == "nats":
                await asyncio.sleep(AWAY_S)
                since_s = time.monotonic()
                self.cluster.start_broker()
        shown_s = await shown_again(self.sessions, since_s)
        if starting is not None:
            await starting
        seen = Kill(name, shown_s, max(one.longest_gap_s for one in self.sessions))
        self.kills.append(seen)
        if name.startswith(("worker", "edge")):
            self.cluster.start(name[:-1], name)
            await asyncio.to_thread(self.cluster.until_ready, name)
        return seen

    async def finish(self) -> Stored:
        """End the streams, wait until everything is stored, and count it."""
        for one in self.sessions:
            one.is_over = True
        async with asyncio.timeout(PATIENCE_S):
            while any(not one.is_settled for one in self.sessions):  # noqa: ASYNC110
                await asyncio.sleep(0.1)
        until_s = time.monotonic() + PATIENCE_S
        while True:
            found = await asyncio.to_thread(check_stored, self.cluster.url, self.sessions)
            if found.stored >= found.sent or time.monotonic() > until_s:
                return found
            await asyncio.sleep(0.5)


@asynccontextmanager
async def streaming(
    cluster: Cluster,
    database: Database,
    stream: DeviceStream,
    count: int,
    by_mqtt: Container[int] = (),
) -> AsyncIterator[Run]:
    """Let sessions stream in real time, some by MQTT, each watched; session 0 holds what it shows."""
    edges = [name for name in cluster.ports if name.startswith("edge")]
    async with AsyncExitStack() as stack:
        clients: Sequence[ServiceClient] = [
            await stack.enter_async_context(ServiceClient(cluster.address(name))) for name in edges
        ]
        for client in clients:
            await client.sign_in(EMAIL, PASSWORD)
        made = await open_sessions(cluster.ports[edges[0]], cluster.patient_id, stream, count)
        sessions = [
            Roving(
                number,
                one["id"],
                clients,
                stream,
                holds=number == 0,
                mqtt_url=cluster.mqtt_url if number in by_mqtt else "",
            )
            for number, one in enumerate(made)
        ]
        tasks = [asyncio.create_task(one.look_on()) for one in sessions]
        tasks += [asyncio.create_task(one.send()) for one in sessions]
        try:
            async with asyncio.timeout(PATIENCE_S):
                await asyncio.gather(*(one.newer_than(-1) for one in sessions))
            yield Run(cluster, database, sessions)
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
