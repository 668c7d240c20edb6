"""Edge, broker and database are killed in mid-stream, and one gateway of three comes by MQTT.

`tests/benchmarks/scaled/kills.py` kills many times.
"""

import asyncio
from collections.abc import Iterator

import pytest

from app.gateway import DeviceStream
from tests.patience import PATIENCE_S
from tests.scaled.cluster import Cluster
from tests.scaled.database import Database
from tests.scaled.killing import Calibration, streaming, whole_service

pytest.importorskip("nats", reason="the extra `scaled` is not installed")
pytest.importorskip("paho.mqtt", reason="the extra `scaled` is not installed")
pytestmark = [pytest.mark.slow, pytest.mark.postgres]

SESSIONS = 3
BETWEEN_S = 2.0
SHOWN_WITHIN_S = 20.0
"""Of a kill; tests share their machine. What is asked for is measured by the benchmark."""

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
