"""A session of many machines that has ended takes the rest at another edge, and ends anew."""

import asyncio
import itertools

import pytest

pytest.importorskip("nats", reason="the extra `scaled` is not installed")

from app.database.engine import create_from_url
from app.gateway import DeviceStream, GatewayClient, ServiceClient
from app.recordings.signals.store import read_packets
from tests.benchmarks.service import open_sessions
from tests.patience import PATIENCE_S
from tests.scaled.cluster import EMAIL, PASSWORD, Cluster
from tests.scaled.killing import whole_service

pytestmark = [pytest.mark.slow, pytest.mark.postgres]

FIRST, ALL = 60, 120
"""Packets that came in time, and in all."""


async def send(client: ServiceClient, session_id: str, stream: DeviceStream, first: int, last: int) -> float:
    """Send packets, end the session, and return how long it is found to be."""
    gateway = GatewayClient(client.ingest_url, lambda: client.ticket(session_id), stream.hello, pace=None)
    await gateway.run(itertools.islice(stream.deliveries(stream.plan()), first, last), goodbye=False)
    await client.steer(session_id, "close")
    await client.wait_for_state(session_id, "analysed", timeout_s=PATIENCE_S)
    return (await client.session(session_id)).duration_s or 0.0


async def end_and_reopen(cluster: Cluster, stream: DeviceStream) -> str:
    async with (
        ServiceClient(cluster.address("edge0")) as one,
        ServiceClient(cluster.address("edge1")) as other,
    ):
        for client in (one, other):
            await client.sign_in(EMAIL, PASSWORD)
        (made,) = await open_sessions(cluster.ports["edge0"], cluster.patient_id, stream, 1)
        short_s = await send(one, made["id"], stream, 0, FIRST)
        reopened = await other.steer(made["id"], "reopen")
        assert reopened.state == "link_lost"
        assert await send(other, made["id"], stream, FIRST, ALL) == pytest.approx(2.0 * short_s, abs=0.1)
    return made["id"]


def test_the_rest_comes_by_another_edge() -> None:
    with whole_service() as (cluster, _, stream, _):
        session_id = asyncio.run(end_and_reopen(cluster, stream))
        engine = create_from_url(cluster.url)
        stored = [packet.sequence for packet in read_packets(engine, session_id)]
        engine.dispose()
    assert stored == list(range(ALL))
