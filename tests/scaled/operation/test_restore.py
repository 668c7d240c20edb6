"""A backup that is made under load, restored to an empty database and empty streams, has every acknowledged packet."""

import asyncio
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from app.database import backup as archives
from tests.patience import PATIENCE_S
from tests.scaled.cluster import ROOT, Cluster
from tests.scaled.killing import streaming, whole_service
from tests.scaled.mqtt.server import until_listening
from tests.scaled.streaming import Roving, check_stored

pytest.importorskip("nats", reason="the extra `scaled` is not installed")
pytestmark = [
    pytest.mark.slow("a whole service is thrown away and restored, so no other test can share it"),
    pytest.mark.postgres,
]

SESSIONS = 3
BEFORE_S = 4.0
UNREAD_S = 2.0
WORKERS = ("worker0", "worker1")


def command(cluster: Cluster, *words: str, **changed: str) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(
        [sys.executable, "-m", "app.cli", *words],
        env=cluster.environment(0) | changed,
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


def numbers(cluster: Cluster, sessions: list[Roving]) -> list[set[int]]:
    return [set(one.stored(cluster.url)) for one in sessions]


def test_a_backup_under_load_has_every_acknowledged_packet(tmp_path: Path) -> None:
    archive = tmp_path / "whole.backup"
    with whole_service() as (cluster, database, stream, _):

        async def run() -> tuple[list[Roving], list[set[int]]]:
            async with streaming(cluster, database, stream, SESSIONS) as going:
                await asyncio.sleep(BEFORE_S)
                # For a while what is acknowledged is in the streams alone.
                for name in WORKERS:
                    cluster.signal(name, signal.SIGSTOP)
                await asyncio.sleep(UNREAD_S)
                acknowledged = [set(range(one.gateway.report.acknowledged + 1)) for one in going.sessions]
                made = await asyncio.to_thread(command, cluster, "backup", str(archive))
                assert made.returncode == 0, made.stderr
                for name in WORKERS:
                    cluster.signal(name, signal.SIGCONT)
                return going.sessions, acknowledged

        sessions, acknowledged = asyncio.run(run())
        rows = archives.verify(archive).rows
        assert sum(count for name, count in rows.items() if name.startswith("stream.")) > 0

        refused = command(cluster, "restore", str(archive))
        assert refused.returncode != 0, "a service runs on it"
        for name in (*cluster.ports, "nats"):
            cluster.kill(name)
        shutil.rmtree(cluster.folder / "nats")
        cluster.url = database.make()
        cluster.start_broker()
        asyncio.run(until_listening(cluster.nats_port))
        for changed, reason in (
            ({"TELEMOTION_DATABASE_URL": f"sqlite:///{tmp_path / 'one.db'}"}, "no worker had stored"),
            ({"TELEMOTION_PARTITIONS": "5"}, "has 8 partitions"),
        ):
            refused = command(cluster, "restore", str(archive), **changed)
            assert refused.returncode != 0
            assert reason in refused.stderr
        restored = command(cluster, "restore", str(archive))
        assert restored.returncode == 0, restored.stderr
        before = numbers(cluster, sessions)
        assert any(wanted - found for wanted, found in zip(acknowledged, before, strict=True)), (
            "nothing was in the streams alone"
        )
        assert command(cluster, "restore", str(archive)).returncode != 0, "it is not empty any more"

        cluster.start("worker", "worker0")
        until_s = time.monotonic() + PATIENCE_S
        while any(
            wanted - found for wanted, found in zip(acknowledged, numbers(cluster, sessions), strict=True)
        ):
            assert time.monotonic() < until_s, cluster.log("worker0")
            time.sleep(0.5)
        outcome = check_stored(cluster.url, sessions)
        assert (outcome.twice, outcome.different, outcome.out_of_order) == (0, 0, 0)
