"""The sockets of a running server: bad input, wrong hellos and senders that get nothing right."""

import asyncio
import contextlib
import json
import struct
import zlib
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pytest
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed

from app.errors import PacketError
from app.gateway import DeviceStream, GatewayClient
from app.ingest import websocket as ingest_websocket
from app.network.packet import encode_packet
from tests.app.live.sockets import (
    SignedIn,
    gateway,
    has_acknowledged,
    is_error,
    new_session,
    until,
)
from tests.patience import PATIENCE_S


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


def test_who_is_too_busy_to_say_hello_is_asked_to_come_again(
    signed_in: SignedIn, world: Any, stream: DeviceStream, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ingest_websocket, "HELLO_TIMEOUT_S", 0.2)

    async def run() -> None:
        async with await signed_in() as client, connect(client.ingest_url, proxy=None) as socket:
            answer = json.loads(await socket.recv())
            # A gateway ends at invalid input; this one it tries again, with a new ticket.
            assert answer["code"] == "unavailable"
            assert answer["closing"] is True
            assert answer["details"]["retry_after_s"] == 1

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
                    async with asyncio.timeout(PATIENCE_S):
                        while True:
                            errors.append(json.loads(await socket.recv()))
                errors = [message for message in errors if message["type"] == "error"]
                assert errors[-1]["closing"]
                assert errors[-1]["details"]["reason"] == "give_up"
                assert len(errors) < 200, "errors a second are limited"

    asyncio.run(run())
