"""Upgrading the parts of a service on many machines while sessions stream, and what is seen of it."""

import asyncio
import re
import signal
import time
from collections.abc import Iterator
from dataclasses import dataclass

import httpx

from tests.patience import PATIENCE_S
from tests.scaled.cluster import Cluster
from tests.scaled.killing import Run
from tests.scaled.streaming import shown_again

VERSION = "next"
NEXT_VERSION = f"""
import app.version
app.version.service_version = lambda: {VERSION!r}
from app.live.session import checkpoint
checkpoint.LAYOUT += 1
"""
"""Code that makes a process one of another version: it goes on from no checkpoint of the version before, and that one
from none of its own."""
STOPS_WITHIN_S = 60.0


@dataclass
class Upgrade:
    """What was seen of the upgrade of one part."""

    name: str
    stop_s: float
    """From SIGTERM to the end of the process."""
    whole_s: float
    """From SIGTERM until the new process has its share and every session shows something new after that."""
    gap_s: float
    """Longest time in between that any session showed nothing new."""


def parts_of(cluster: Cluster) -> list[str]:
    """Return what is upgraded, in the order in which it should be: workers, then edges."""
    return sorted(cluster.ports, key=lambda name: (not name.startswith("worker"), name))


async def upgrade(going: Run, name: str) -> Upgrade:
    """Stop a part in order, start it with another version, and return when everything is as it was.

    Parameters
    ----------
    going : Run
    name : str
        `workerN` or `edgeN`.
    """
    cluster, sessions = going.cluster, going.sessions
    for one in sessions:
        one.longest_gap_s = 0.0
    began_s = time.monotonic()
    cluster.signal(name, signal.SIGTERM)
    ended = await asyncio.to_thread(cluster.processes[name].wait, STOPS_WITHIN_S)
    stop_s = time.monotonic() - began_s
    assert ended in {0, -signal.SIGTERM}, cluster.log(name)
    cluster.before[name] = NEXT_VERSION
    cluster.start(name[:-1], name)
    await asyncio.to_thread(cluster.until_ready, name)
    assert version_of(cluster, name) == VERSION
    if name.startswith("worker"):
        await asyncio.to_thread(until_shared, cluster)
    await shown_again(sessions, time.monotonic())
    gap_s = max(one.longest_gap_s for one in sessions)
    return Upgrade(name, stop_s, time.monotonic() - began_s, gap_s)


def version_of(cluster: Cluster, name: str) -> object:
    """Return which version a part says that it is."""
    return httpx.get(f"{cluster.address(name)}/api/health", trust_env=False, timeout=10.0).json()["version"]


def held_of(cluster: Cluster) -> Iterator[int]:
    """Yield how many partitions each worker holds."""
    for name in cluster.ports:
        if name.startswith("worker"):
            text = httpx.get(f"{cluster.address(name)}/metrics", trust_env=False, timeout=10.0).text
            [found] = re.findall(r"^\w*partitions_held (\S+)$", text, re.MULTILINE)
            yield round(float(found))


def until_shared(cluster: Cluster) -> None:
    """Return when the workers have shared all partitions evenly."""
    all_of_them = int(cluster.environment(0)["TELEMOTION_PARTITIONS"])
    until_s = time.monotonic() + PATIENCE_S
    while True:
        held = list(held_of(cluster))
        if sum(held) == all_of_them and max(held) - min(held) <= 1:
            return
        assert time.monotonic() < until_s, held
        time.sleep(0.05)
