"""The sockets of a running server: bad input, strangers, dashboards, takeover, revoked rights."""

import asyncio
import contextlib
import json
import struct
import zlib
from collections.abc import AsyncIterator, Awaitable, Callable
from functools import partial
from typing import Any

import numpy as np
import pytest
from sqlalchemy import Engine, select
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed

from app.accounts.models import AuditEvent, DeviceToken
from app.database.base import utc_now
from app.database.unit_of_work import unit_of_work
from app.errors import Conflict, NotAllowed, NotFound, PacketError, SignInRequired
from app.gateway import DeviceStream, GatewayClient, Milestone, ServiceClient, stream_of
from app.ingest import websocket as ingest_websocket
from app.ingest.packet import encode_packet
from app.patients.models import Grant
from app.recordings.schemas import SessionIn
from estimators.simulation import ArmScenario, Schedule, simulate_arm

SignedIn = Callable[..., Awaitable[ServiceClient]]
Message = dict[str, Any]


@pytest.fixture(scope="module")
def stream() -> DeviceStream:
    scenario = ArmScenario(schedule=Schedule(n_pose_s=10.0, repetitions=1), seed=5)
    return stream_of(simulate_arm(scenario).recording)


async def new_session(client: ServiceClient, patient_id: str, stream: DeviceStream) -> str:
    made = await client.create_session(SessionIn(patient_id=patient_id, placements=list(stream.placements)))  # type: ignore[arg-type]
    return made.id


@contextlib.asynccontextmanager
async def gateway(
    client: ServiceClient, session_id: str, stream: DeviceStream
) -> AsyncIterator[ClientConnection]:
    """A connection after its hello was acknowledged."""
    async with connect(client.ingest_url, proxy=None) as socket:
        hello = stream.hello(await client.ticket(session_id))
        await socket.send(hello.model_dump_json(exclude_none=True))
        answer = json.loads(await socket.recv())
        assert answer["type"] == "acknowledge", answer
        yield socket


async def until(
    socket: ClientConnection, wanted: Callable[[Message], bool], timeout_s: float = 20.0
) -> Message:
    """Read until a JSON message is wanted."""
    async with asyncio.timeout(timeout_s):
        while True:
            text = await socket.recv()
            if isinstance(text, str) and wanted(message := json.loads(text)):
                return message


def is_error(reason: str) -> Callable[[Message], bool]:
    return lambda message: message["type"] == "error" and message["details"].get("reason") == reason


def has_acknowledged(sequence: int) -> Callable[[Message], bool]:
    return lambda message: message["type"] == "acknowledge" and message["acknowledged"] >= sequence


def resealed(data: bytes) -> bytes:
    return data[:28] + struct.pack("<I", zlib.crc32(data[:28] + data[32:])) + data[32:]


def not_a_number(stream: DeviceStream) -> bytes:
    values = np.zeros((5, len(stream.placements), 9), dtype="<f4")
    values[2, 1, 4] = np.nan
    return encode_packet(values, sequence=1, device_time_us=10**9 + 50_000, tick_interval_us=10_000)


BAD: dict[str, tuple[Callable[[DeviceStream], bytes | str], str]] = {
    "truncated": (lambda s: s.packet(1)[:-7], "truncated"),
    "half a header": (lambda s: s.packet(1)[:20], "truncated"),
    "empty": (lambda s: b"", "truncated"),
    "magic": (lambda s: b"XXXX" + s.packet(1)[4:], "magic"),
    "crc": (lambda s: s.packet(1)[:-1] + b"\x55", "crc"),
    "counts": (lambda s: resealed(s.packet(1)[:5] + b"\x09" + s.packet(1)[6:]), "truncated"),
    "absurd sensors": (lambda s: resealed(s.packet(1)[:4] + b"\xff" + s.packet(1)[5:]), "sensor_count"),
    "not a number": (not_a_number, "not_finite"),
    "time backwards": (lambda s: s.packet(1, device_time_s=-1.0), "time_backwards"),
    "time far ahead": (lambda s: s.packet(1, device_time_s=1e6), "time_jump"),
    "too long": (lambda s: b"BNP1" + bytes(300_000), "length"),
    "no json": (lambda s: "{not json", "json"),
    "unknown message": (lambda s: '{"type": "dance"}', "json"),
    "json counts": (
        lambda s: json.dumps(
            {"type": "packet", "sequence": 1, "device_time_us": 1, "tick_interval_us": 10_000, "sensors": []}
        ),
        "sensor_count",
    ),
    "json of a megabyte": (lambda s: " " * 600_000, "length"),
}


def test_bad_input_gets_typed_errors_and_the_sessions_live_on(
    signed_in: SignedIn, world: Any, stream: DeviceStream
) -> None:
    async def run() -> None:
        async with await signed_in() as client:
            session_id = await new_session(client, world.patient_id, stream)
            other_id = await new_session(client, world.other_patient_id, stream)
            async with (
                gateway(client, session_id, stream) as socket,
                gateway(client, other_id, stream) as neighbour,
            ):
                await socket.send(stream.packet(0))
                await neighbour.send(stream.packet(0))
                for name, (make, reason) in BAD.items():
                    await socket.send(make(stream))
                    error = await until(socket, is_error(reason))
                    assert error["code"] == "packet", name
                    assert not error["closing"], name
                    assert len(error["message"]) > 20, name
                    # The limit on errors a second must not hide one of these.
                    await asyncio.sleep(0.06)
                for number in range(1, 6):
                    await socket.send(stream.packet(number))
                    await neighbour.send(stream.packet(number))
                await until(socket, has_acknowledged(5))
                await until(neighbour, has_acknowledged(5))
            assert (await client.session(session_id)).packets_stored == 6

    asyncio.run(run())


HELLOS: dict[str, tuple[dict[str, Any], str, str]] = {
    "other version": ({"protocol_version": 9}, "packet", "protocol_version"),
    "unknown placement": ({"placements": ["tail"]}, "packet", "placements"),
    "other placements": ({"placements": ["sternum", "pelvis"]}, "packet", "placements"),
    "absurd rate": ({"rate_hz": 1e9}, "packet", "hello"),
    "absurd scale": ({"gyroscope_scale": 12.0}, "packet", "scales"),
    "no such ticket": ({"ticket": "made-up"}, "sign_in_required", ""),
    "unknown field": ({"colour": "red"}, "packet", "hello"),
}


@pytest.mark.parametrize("name", HELLOS)
def test_a_wrong_hello_ends_the_connection_with_words(
    name: str, signed_in: SignedIn, world: Any, stream: DeviceStream
) -> None:
    changes, code, reason = HELLOS[name]

    async def run() -> None:
        async with await signed_in() as client:
            session_id = await new_session(client, world.patient_id, stream)
            async with connect(client.ingest_url, proxy=None) as socket:
                hello = stream.hello(await client.ticket(session_id)).model_dump(exclude_none=True)
                await socket.send(json.dumps(hello | changes))
                error = json.loads(await socket.recv())
                assert (error["type"], error["code"], error["closing"]) == ("error", code, True)
                assert error["details"].get("reason", "") == reason
                with pytest.raises(ConnectionClosed):
                    await socket.recv()
            # The session is untouched: a right hello opens it.
            async with gateway(client, session_id, stream):
                pass

    asyncio.run(run())


def test_tickets_are_for_one_use_one_session_and_one_purpose(
    signed_in: SignedIn, world: Any, stream: DeviceStream
) -> None:
    async def refused(client: ServiceClient, ticket: str) -> str:
        async with connect(client.ingest_url, proxy=None) as socket:
            await socket.send(stream.hello(ticket).model_dump_json(exclude_none=True))
            return str(json.loads(await socket.recv())["code"])

    async def run() -> None:
        async with await signed_in() as client:
            session_id = await new_session(client, world.patient_id, stream)
            ticket = await client.ticket(session_id)
            async with connect(client.ingest_url, proxy=None) as socket:
                await socket.send(stream.hello(ticket).model_dump_json(exclude_none=True))
                assert json.loads(await socket.recv())["session_id"] == session_id
            assert await refused(client, ticket) == "sign_in_required"
            assert await refused(client, await client.ticket(session_id, "live")) == "sign_in_required"

    asyncio.run(run())


@pytest.mark.parametrize("name", ["other_patient", "colleague", "former", "expired", "foreign_therapist"])
def test_a_stranger_gets_no_ticket_no_view_and_cannot_steer(
    name: str, signed_in: SignedIn, world: Any, stream: DeviceStream, email: Callable[[str], str]
) -> None:
    async def run() -> None:
        async with await signed_in() as client:
            session_id = await new_session(client, world.patient_id, stream)
            good = await client.ticket(session_id, "live")
        address = email(name)
        if name.startswith("foreign"):
            address = f"{name}@{world.foreign_clinic_id[:6]}.example"
        async with ServiceClient(client.server) as stranger:
            await stranger.sign_in(address, "a long enough password")
            for purpose in ("ingest", "live"):
                with pytest.raises(NotFound):
                    await stranger.ticket(session_id, purpose)
            for action in ("calibrate", "record", "stop", "close"):
                with pytest.raises(NotFound):
                    await stranger.steer(session_id, action)
            with pytest.raises(NotFound):
                await stranger.steer(session_id, "mark", {"text": "x"})
            with pytest.raises(NotFound):
                await stranger.state(session_id)
            code, messages = await watch(stranger, session_id, None)
            assert (code, [m["code"] for m in messages]) == (1008, ["not_found"])
            # A right ticket for another session's address is no ticket there.
            code, messages = await watch(stranger, "0" * 32, good)
            assert (code, [m["code"] for m in messages]) == (1008, ["sign_in_required"])

    asyncio.run(run())


async def watch(
    client: ServiceClient, session_id: str, ticket: str | None
) -> tuple[int | None, list[Message]]:
    """Open the live socket by ticket or cookie and read until it closes."""
    url = client.server.replace("http", "ws", 1) + f"/ws/live/{session_id}"
    headers = {}
    if ticket is None:
        headers["Cookie"] = "; ".join(f"{name}={value}" for name, value in client.http.cookies.items())
    messages = []
    async with connect(url, proxy=None, additional_headers=headers, origin=client.server) as socket:  # type: ignore[arg-type]
        if ticket is not None:
            await socket.send(json.dumps({"ticket": ticket}))
        with contextlib.suppress(ConnectionClosed):
            async with asyncio.timeout(10):
                while True:
                    messages.append(json.loads(await socket.recv()))
        return socket.close_code, messages


@pytest.mark.parametrize("headers", [{}, {"Origin": "https://evil.example"}], ids=["nobody", "another site"])
def test_the_live_socket_needs_somebody_from_our_own_pages(
    headers: dict[str, str], signed_in: SignedIn, world: Any, stream: DeviceStream
) -> None:
    async def run() -> None:
        async with await signed_in() as client:
            session_id = await new_session(client, world.patient_id, stream)
            cookie = "; ".join(f"{name}={value}" for name, value in client.http.cookies.items())
            url = client.server.replace("http", "ws", 1) + f"/ws/live/{session_id}"
            given = headers | ({"Cookie": cookie} if headers else {})
            async with connect(url, proxy=None, additional_headers=given) as socket:
                if not headers:
                    await socket.send('{"ticket": "made-up"}')
                error = json.loads(await socket.recv())
                assert error["code"] in {"sign_in_required", "not_allowed"}
                with pytest.raises(ConnectionClosed):
                    await socket.recv()

    asyncio.run(run())


@pytest.mark.slow
def test_a_device_streams_for_its_own_patient_only_until_it_is_revoked(
    server: Any,
    signed_in: SignedIn,
    world: Any,
    stream: DeviceStream,
    engine: Engine,
    device_token: Callable[[str], str],
    settings: Any,
) -> None:
    async def run() -> None:
        token = device_token(world.patient_id)
        async with await signed_in() as therapist, ServiceClient(server.address, token) as device:
            session_id = await new_session(device, world.patient_id, stream)
            others = await new_session(therapist, world.other_patient_id, stream)
            with pytest.raises(NotFound):
                await device.ticket(others)
            with pytest.raises(NotAllowed):
                await device.ticket(session_id, "live")
            async with gateway(device, session_id, stream) as socket:
                await socket.send(stream.packet(0))
                await until(socket, has_acknowledged(0))
                with unit_of_work(engine) as session:
                    for row in session.scalars(select(DeviceToken)):
                        row.revoked_at = utc_now()
                error = await until(socket, lambda message: message["type"] == "error")
                assert (error["code"], error["closing"]) == ("sign_in_required", True)
            with pytest.raises(SignInRequired):
                await device.ticket(session_id)
        with unit_of_work(engine) as session:
            actions = set(
                session.scalars(select(AuditEvent.action).where(AuditEvent.resource_id == session_id))
            )
        assert {"session.create", "session.ticket", "session.stream"} <= actions

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
                await client.wait_for_state(session_id, "ready")
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


def test_other_sensors_in_a_later_hello_are_refused(
    signed_in: SignedIn, world: Any, stream: DeviceStream
) -> None:
    async def run() -> None:
        async with await signed_in() as client:
            session_id = await new_session(client, world.patient_id, stream)
            async with gateway(client, session_id, stream) as socket:
                await socket.send(stream.packet(0))
            changed = stream.hello("").model_copy(update={"rate_hz": 50.0})
            sender = GatewayClient(
                client.ingest_url,
                partial(client.ticket, session_id),
                lambda ticket: changed.model_copy(update={"ticket": ticket}),
            )
            with pytest.raises(PacketError) as caught:
                await sender.run([])
            assert caught.value.details["reason"] == "network_changed"

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
                await until(dashboard, lambda message: message.get("state") == "analysed", timeout_s=60)
            await client.wait_for_state(session_id, "analysed", timeout_s=60)

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
            async with asyncio.timeout(60):
                while (await client.state(session_id)).state == "closing":  # noqa: ASYNC110
                    await asyncio.sleep(0.2)
            sender = GatewayClient(client.ingest_url, partial(client.ticket, session_id), stream.hello)
            with pytest.raises(Conflict):
                await sender.run(stream.deliveries(stream.plan()))

    asyncio.run(run())


def test_a_sender_that_gets_nothing_right_is_turned_away(
    signed_in: SignedIn, world: Any, stream: DeviceStream
) -> None:
    async def run() -> None:
        async with await signed_in() as client:
            session_id = await new_session(client, world.patient_id, stream)
            async with gateway(client, session_id, stream) as socket:
                errors = []
                with contextlib.suppress(ConnectionClosed):
                    for _ in range(ingest_websocket.WRONG_IN_A_ROW + 50):
                        await socket.send(b"BNP1 nonsense")
                with contextlib.suppress(ConnectionClosed):
                    async with asyncio.timeout(20):
                        while True:
                            errors.append(json.loads(await socket.recv()))
                errors = [message for message in errors if message["type"] == "error"]
                assert errors[-1]["closing"]
                assert errors[-1]["details"]["reason"] == "give_up"
                assert len(errors) < 200, "errors a second are limited"

    asyncio.run(run())


def test_a_link_that_breaks_while_a_milestone_waits_comes_back(signed_in, world, stream):
    async def run() -> None:
        async with await signed_in() as service:
            session_id = await new_session(service, world.patient_id, stream)
            ticket = partial(service.ticket, session_id)
            client = GatewayClient(service.ingest_url, ticket, stream.hello, pace=None)

            async def break_and_wait() -> None:
                assert client._connection is not None
                client._connection.transport.abort()
                async with asyncio.timeout(20.0):
                    while client.report.connections < 2:  # noqa: ASYNC110 - another task counts
                        await asyncio.sleep(0.02)

            deliveries = list(stream.deliveries(stream.plan()))[:40]
            milestones = [Milestone(0.5, break_and_wait)]
            report = await client.run(deliveries, milestones=milestones)
            assert (report.unacknowledged, report.dropped) == (0, 0)

    asyncio.run(run())
