"""The sockets of a running server: tickets, strangers, revoked rights."""

import asyncio
import contextlib
import json
from collections.abc import Callable
from typing import Any

import pytest
from sqlalchemy import Engine, select
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed

from app.accounts.models import AuditEvent, DeviceToken
from app.database.base import utc_now
from app.database.unit_of_work import unit_of_work
from app.errors import NotAllowed, NotFound, SignInRequired
from app.gateway import DeviceStream, ServiceClient
from tests.app.live.sockets import (
    Message,
    SignedIn,
    gateway,
    has_acknowledged,
    new_session,
    until,
)
from tests.patience import PATIENCE_S


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
            async with asyncio.timeout(PATIENCE_S):
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
