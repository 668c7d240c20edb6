"""The sockets of a running server: dashboards, takeover, links that break, JSON."""

import asyncio
import contextlib
import json
import struct
from functools import partial
from typing import Any

import numpy as np
import pytest
from sqlalchemy import Engine, select
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed

from app.database.base import utc_now
from app.database.unit_of_work import unit_of_work
from app.errors import Conflict
from app.gateway import DeviceStream, GatewayClient, Milestone, ServiceClient
from app.patients.models import Grant
from tests.app.live.sockets import (
    Message,
    SignedIn,
    gateway,
    has_acknowledged,
    new_session,
    until,
)
from tests.patience import PATIENCE_S


def test_a_pose_goes_on_when_the_link_is_back_soon(
    signed_in: SignedIn, world: Any, stream: DeviceStream
) -> None:
    """Nobody has to say twice that she stands still because a radio failed for a moment."""
    before, until_ready = 40, 190

    async def run() -> None:
        async with await signed_in() as client:
            session_id = await new_session(client, world.patient_id, stream)
            async with gateway(client, session_id, stream) as socket:
                await socket.send(stream.packet(0))
                await until(socket, has_acknowledged(0))
                await client.steer(session_id, "calibrate")
                for number in range(1, before):
                    await socket.send(stream.packet(number))
                await until(socket, has_acknowledged(before - 1))
            await client.wait_for_state(session_id, "link_lost", timeout_s=PATIENCE_S)
            async with gateway(client, session_id, stream) as socket:
                assert (await client.state(session_id)).state == "calibrating"
                for number in range(before, until_ready):
                    await socket.send(stream.packet(number))
                    await asyncio.sleep(0.01)
                await client.wait_for_state(session_id, "ready", timeout_s=PATIENCE_S)

    asyncio.run(run())


@pytest.mark.slow
def test_a_dashboard_sees_layout_states_health_and_frames_until_its_right_ends(
    signed_in: SignedIn, world: Any, stream: DeviceStream, engine: Engine
) -> None:
    async def run() -> None:
        async with await signed_in() as client, await signed_in("reader") as reader:
            session_id = await new_session(client, world.patient_id, stream)
            watching = asyncio.create_task(collect(reader, session_id))
            await asyncio.sleep(0.5)
            sender = GatewayClient(
                client.ingest_url, partial(client.ticket, session_id), stream.hello, pace=8.0
            )

            async def calibrate() -> None:
                with pytest.raises(Conflict):
                    await client.steer(session_id, "record")
                state = await client.steer(session_id, "calibrate")
                assert state.calibration_progress == 0.0
                await client.steer(session_id, "mark", {"text": "begin"})

            async def record() -> None:
                await client.wait_for_state(session_id, "ready", timeout_s=PATIENCE_S)
                await client.steer(session_id, "record")

            async def stop() -> None:
                await client.steer(session_id, "stop")

            milestones = [Milestone(1.0, calibrate), Milestone(9.0, record), Milestone(1e9, stop)]
            await sender.run(stream.deliveries(stream.plan()), milestones=milestones, goodbye=False)
            await asyncio.sleep(1.0)
            with unit_of_work(engine) as session:
                for grant in session.scalars(
                    select(Grant).where(Grant.account_id == world.accounts["reader"])
                ):
                    grant.revoked_at = utc_now()
            code, texts, blocks = await asyncio.wait_for(watching, 30)
            assert code == 1008
            assert texts[-1]["code"] == "not_found"
            layouts = [message for message in texts if message["type"] == "layout"]
            states = [message for message in texts if message["type"] == "state"]
            names = [message["state"] for message in states]
            assert texts[0]["type"] == "layout"
            order = [name for i, name in enumerate(names) if i == 0 or name != names[i - 1]]
            assert order[:6] == ["created", "calibrating", "ready", "recording", "ready", "link_lost"]
            progress = [message["calibration_progress"] for message in states]
            assert any(value is not None and 0.3 < value < 1.0 for value in progress)
            assert any("Good" in message["calibration_hint"] for message in states)
            health = [message for message in texts if message["type"] == "health"][-1]
            assert {sensor["status"] for sensor in health["sensors"]} <= {"ok", "noisy", "lost"}
            assert health["packets_missing"] == 0
            assert health["latency_ms_p99"] is not None
            kinds = {message["event"]["kind"] for message in texts if message["type"] == "event"}
            assert {"state", "mark", "calibration"} <= kinds
            columns = layouts[-1]["columns"]
            shown = [struct.unpack("<4sIIIddd", block[:40]) for block in blocks]
            assert all(header[0] == b"TMF1" and header[2] == len(columns) for header in shown)
            firsts = [header[3] for header in shown]
            assert firsts == sorted(firsts)
            last = np.frombuffer(blocks[-1][40:], "<f4").reshape(shown[-1][1], len(columns))
            assert np.isfinite(last[:, columns.index("humerus_forearm_right_zxy_flexion")]).all()

    async def collect(
        client: ServiceClient, session_id: str
    ) -> tuple[int | None, list[Message], list[bytes]]:
        texts: list[Message] = []
        blocks: list[bytes] = []
        url = client.server.replace("http", "ws", 1) + f"/ws/live/{session_id}"
        ticket = await client.ticket(session_id, "live")
        async with connect(url, proxy=None) as socket:
            await socket.send(json.dumps({"ticket": ticket}))
            with contextlib.suppress(ConnectionClosed):
                async for message in socket:
                    if isinstance(message, str):
                        texts.append(json.loads(message))
                    else:
                        blocks.append(message)
            return socket.close_code, texts, blocks

    asyncio.run(run())


def test_a_second_connection_takes_over_from_a_dead_one(
    signed_in: SignedIn, world: Any, stream: DeviceStream
) -> None:
    async def run() -> None:
        async with await signed_in() as client:
            session_id = await new_session(client, world.patient_id, stream)
            async with gateway(client, session_id, stream) as first:
                await first.send(stream.packet(0))
                async with gateway(client, session_id, stream) as second:
                    error = await until(first, lambda message: message["type"] == "error")
                    assert (error["code"], error["closing"]) == ("conflict", True)
                    await second.send(stream.packet(0))
                    await second.send(stream.packet(1))
                    await until(second, has_acknowledged(1))
                    state = await client.state(session_id)
                    assert state.state == "calibrating", "the end of the first one is no lost link"
            assert (await client.session(session_id)).packets_stored == 2

    asyncio.run(run())


@pytest.mark.slow
def test_the_same_as_json_for_people_with_curl(signed_in: SignedIn, world: Any, stream: DeviceStream) -> None:
    async def run() -> None:
        async with await signed_in() as client:
            session_id = await new_session(client, world.patient_id, stream)
            async with gateway(client, session_id, stream) as socket:
                sensor = {"gyroscope": [[0.01, 0, 0]], "accelerometer": [[0, 0.1, 9.8]]}
                for number in range(4):
                    message = {
                        "type": "packet",
                        "sequence": number,
                        "device_time_us": 1_000_000 + 10_000 * number,
                        "tick_interval_us": 10_000,
                        "sensors": [sensor] * len(stream.placements),
                    }
                    await socket.send(json.dumps(message))
                await until(socket, has_acknowledged(3))
                await socket.send('{"type": "goodbye", "last_sequence": 3}')
                await until(socket, lambda message: message.get("state") == "closing")
            url = client.server.replace("http", "ws", 1) + f"/ws/live/{session_id}"
            async with connect(url, proxy=None) as dashboard:
                await dashboard.send(json.dumps({"ticket": await client.ticket(session_id, "live")}))
                # Whoever watches is told of the end of the analysis too.
                await until(
                    dashboard, lambda message: message.get("state") == "analysed", timeout_s=PATIENCE_S
                )
            await client.wait_for_state(session_id, "analysed", timeout_s=PATIENCE_S)

    asyncio.run(run())


def test_a_session_that_never_began_closes_and_a_closed_one_takes_nothing(
    signed_in: SignedIn, world: Any, stream: DeviceStream
) -> None:
    async def run() -> None:
        async with await signed_in() as client:
            session_id = await new_session(client, world.patient_id, stream)
            with pytest.raises(Conflict):
                await client.steer(session_id, "calibrate")
            state = await client.steer(session_id, "close")
            assert state.state in {"closing", "analysed", "failed"}
            # Nothing can be analysed, so the session ends as failed; that does not open it again.
            async with asyncio.timeout(PATIENCE_S):
                while (await client.state(session_id)).state == "closing":  # noqa: ASYNC110
                    await asyncio.sleep(0.2)
            sender = GatewayClient(client.ingest_url, partial(client.ticket, session_id), stream.hello)
            with pytest.raises(Conflict):
                await sender.run(stream.deliveries(stream.plan()))

    asyncio.run(run())


def test_a_link_that_breaks_while_a_milestone_waits_comes_back(signed_in, world, stream):
    async def run() -> None:
        async with await signed_in() as service:
            session_id = await new_session(service, world.patient_id, stream)
            ticket = partial(service.ticket, session_id)
            client = GatewayClient(service.ingest_url, ticket, stream.hello, pace=None)

            async def break_and_wait() -> None:
                assert client._connection is not None
                client._connection.abort()
                async with asyncio.timeout(PATIENCE_S):
                    while client.report.connections < 2:  # noqa: ASYNC110 - another task counts
                        await asyncio.sleep(0.02)

            deliveries = list(stream.deliveries(stream.plan()))[:40]
            milestones = [Milestone(0.5, break_and_wait)]
            report = await client.run(deliveries, milestones=milestones)
            assert (report.unacknowledged, report.dropped) == (0, 0)

    asyncio.run(run())
