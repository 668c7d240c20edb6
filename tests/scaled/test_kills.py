"""Edge, broker and database are killed in mid-stream, sessions end early and are reopened, at one service for all.

One gateway of three comes by MQTT.

`tests/benchmarks/scaled/kills.py` kills many times.
"""

import asyncio
import itertools
from collections.abc import Iterator

import pytest

from app.database.engine import create_from_url
from app.gateway import DeviceStream, GatewayClient, ServiceClient
from app.recordings.signals.store import read_packets
from tests.benchmarks.service import open_sessions
from tests.patience import PATIENCE_S
from tests.scaled.cluster import EMAIL, PASSWORD, Cluster
from tests.scaled.database import Database
from tests.scaled.killing import Calibration, streaming, whole_service

pytest.importorskip("nats", reason="the extra `scaled` is not installed")
pytest.importorskip("paho.mqtt", reason="the extra `scaled` is not installed")
pytestmark = [
    pytest.mark.slow("a whole service starts, and each part that was killed starts again"),
    pytest.mark.postgres,
]

SESSIONS = 3
BETWEEN_S = 2.0
SHOWN_WITHIN_S = 20.0
"""Of a kill; tests share their machine. What is asked for is measured by the benchmark."""

FIRST, ALL = 60, 120
"""Packets that came in time, and in all."""

Started = tuple[Cluster, Database, DeviceStream, Calibration]


@pytest.fixture(scope="module")
def started() -> Iterator[Started]:
    """One service for all tests here: each leaves it whole."""
    with whole_service() as running:
        yield running


@pytest.mark.parametrize("name", ["edge0", "nats", "database"])
def test_nothing_acknowledged_is_lost_and_frames_go_on(started: Started, name: str) -> None:
    cluster, database, stream, _ = started

    async def run() -> None:
        async with streaming(cluster, database, stream, SESSIONS, by_mqtt={1}) as going:
            await asyncio.sleep(BETWEEN_S)
            seen = await going.kill(name)
            print(f"{name}: frames {max(seen.shown_s):.2f} s after it")
            await asyncio.sleep(BETWEEN_S)
            stored = await going.finish()
        assert stored.is_whole, stored
        assert max(seen.shown_s) < SHOWN_WITHIN_S
        assert not any(one.contradictions for one in going.sessions)

    asyncio.run(run())


def test_a_session_that_is_closed_while_its_gateway_sends_has_all_that_was_acknowledged(
    started: Started,
) -> None:
    cluster, database, stream, _ = started

    async def run() -> None:
        async with streaming(cluster, database, stream, SESSIONS) as going:
            await asyncio.sleep(BETWEEN_S)
            for one in going.sessions:
                state = await one.client.steer(one.id, "close")
                assert state.state == "closing"
            await asyncio.sleep(BETWEEN_S)
            for one in going.sessions:
                one.is_over = True
            for one in going.sessions:
                await one.client.wait_for_state(one.id, "analysed", timeout_s=PATIENCE_S)
            stored = [set(one.stored(cluster.url)) for one in going.sessions]
        for one, found in zip(going.sessions, stored, strict=True):
            acknowledged = set(range(one.gateway.report.acknowledged + 1))
            assert acknowledged, "nothing was acknowledged"
            assert acknowledged <= found
            assert len(found) < one.sent, "the gateway went on sending after the close"

    asyncio.run(run())


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


def test_the_rest_of_a_session_that_has_ended_comes_by_another_edge(started: Started) -> None:
    cluster, _, stream, _ = started
    session_id = asyncio.run(end_and_reopen(cluster, stream))
    engine = create_from_url(cluster.url)
    stored = [packet.sequence for packet in read_packets(engine, session_id)]
    engine.dispose()
    assert stored == list(range(ALL))
