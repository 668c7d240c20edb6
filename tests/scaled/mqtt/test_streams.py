"""Gateways by WebSocket and by MQTT in one run: a link that is lost, an edge that dies, tickets of others."""

import asyncio
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest

pytest.importorskip("nats", reason="the extra `scaled` is not installed")
pytest.importorskip("paho.mqtt", reason="the extra `scaled` is not installed")

from app.gateway import DeviceStream, ServiceClient
from tests.benchmarks.service import open_sessions
from tests.patience import PATIENCE_S
from tests.scaled.cluster import EMAIL, PASSWORD, Cluster
from tests.scaled.database import Database
from tests.scaled.embedded import embedded_shown
from tests.scaled.killing import Calibration, streaming, whole_service
from tests.scaled.mqtt.server import Stranger

pytestmark = [
    pytest.mark.slow("a broker, PostgreSQL, two edges and two workers start, and stream by MQTT"),
    pytest.mark.postgres,
]

BETWEEN_S = 2.0
"""Of the death of an edge, which is five seconds of silence by MQTT; tests share their machine."""

Started = tuple[Cluster, Database, DeviceStream, Calibration]


@pytest.fixture(scope="module")
def started() -> Iterator[Started]:
    """One service for all tests here: each leaves it whole."""
    with whole_service() as running:
        yield running


def served_by_mqtt(cluster: Cluster) -> dict[str, float]:
    """Return how many gateways each edge serves by MQTT."""
    found = {}
    for name in ("edge0", "edge1"):
        text = httpx.get(f"{cluster.address(name)}/metrics", trust_env=False).text
        [line] = [one for one in text.splitlines() if one.startswith("telemotion_mqtt_gateways ")]
        found[name] = float(line.split()[1])
    return found


def test_both_ways_in_one_run_store_and_show_the_same_over_a_lost_link(
    started: Started, tmp_path: Path
) -> None:
    cluster, database, stream, calibration = started

    async def run() -> Any:
        async with streaming(cluster, database, stream, 2, by_mqtt={0}) as going:
            await asyncio.sleep(BETWEEN_S)
            assert sum(served_by_mqtt(cluster).values()) == 1
            for one in going.sessions:
                assert one.gateway._connection is not None
                one.gateway._connection.abort()
            await asyncio.sleep(2.0 * BETWEEN_S)
            stored = await going.finish()
        assert stored.is_whole, stored
        assert [one.gateway.report.connections for one in going.sessions] == [2, 2]
        assert not any(one.gateway.report.errors for one in going.sessions)
        assert not any(one.contradictions for one in going.sessions)
        return going.sessions[0]

    by_mqtt = asyncio.run(run())
    (tmp_path / "one").mkdir(mode=0o700)
    ours = by_mqtt.shown
    theirs = embedded_shown(tmp_path / "one", calibration, stream, by_mqtt)
    both = ours.keys() & theirs.keys()
    assert len(both) > 100 * BETWEEN_S
    assert not [tick for tick in both if ours[tick] != theirs[tick]]


def test_the_edge_that_serves_a_gateway_by_mqtt_dies_and_the_other_goes_on(started: Started) -> None:
    cluster, database, stream, _ = started

    async def run() -> None:
        async with streaming(cluster, database, stream, 2, by_mqtt={1}) as going:
            await asyncio.sleep(BETWEEN_S)
            before = served_by_mqtt(cluster)
            [name] = [edge for edge, count in before.items() if count]
            seen = await going.kill(name)
            print(f"{name}: frames {max(seen.shown_s):.2f} s after it")
            await asyncio.sleep(BETWEEN_S)
            after = served_by_mqtt(cluster)
            stored = await going.finish()
        assert stored.is_whole, stored
        assert max(seen.shown_s) < PATIENCE_S
        assert after[name] == 0
        assert sum(after.values()) == 1
        assert going.sessions[1].gateway.report.connections == 2

    asyncio.run(run())


def test_a_ticket_opens_its_own_session_by_its_own_connection_once(started: Started) -> None:
    cluster, _, stream, _ = started

    async def said(gateway: Stranger) -> dict[str, Any]:
        async with asyncio.timeout(PATIENCE_S):
            while not gateway.received:
                gateway.came.clear()
                await gateway.came.wait()
        return dict(json.loads(gateway.received.pop(0)[1]))

    async def hello(gateway: Stranger, ticket: str) -> dict[str, Any]:
        assert await gateway.subscribe(f"gateway/{gateway.name}/down")
        content = stream.hello(ticket).model_dump_json(exclude_none=True)
        gateway.client.publish(f"gateway/{gateway.name}/hello", content)
        return await said(gateway)

    async def run() -> None:
        async with ServiceClient(cluster.address("edge0")) as client:
            await client.sign_in(EMAIL, PASSWORD)
            made = await open_sessions(cluster.ports["edge0"], cluster.patient_id, stream, 2)
            ours, theirs, spare = [await client.ticket(made[number]["id"]) for number in (0, 1, 0)]
            live = await client.ticket(made[0]["id"], "live")
            for wrong in (live, "made up"):
                stranger = Stranger(cluster.mqtt_port, wrong)
                assert not await stranger.connect()
                await stranger.close()

            gateway = Stranger(cluster.mqtt_port, ours)
            assert await gateway.connect()
            refused = await hello(gateway, theirs)
            assert (refused["code"], refused["closing"]) == ("sign_in_required", True)
            await gateway.close()

            # The ticket of the other session was not used up by that.
            gateway = Stranger(cluster.mqtt_port, theirs)
            assert await gateway.connect()
            answer = await hello(gateway, theirs)
            assert (answer["type"], answer["session_id"]) == ("acknowledge", made[1]["id"])
            again = Stranger(cluster.mqtt_port, theirs)
            assert not await again.connect(), "a ticket that was used opens nothing"
            await again.close()

            # What another connection sends does not come to this one.
            gateway.received.clear()
            other = Stranger(cluster.mqtt_port, spare)
            assert await other.connect()
            other.client.publish(f"gateway/{gateway.name}/up", b'{"type": "goodbye", "last_sequence": -1}')
            state = await said(gateway)
            await other.close()
            assert state["state"] not in {"closing", "analysed"}
            await gateway.close()

    asyncio.run(run())
