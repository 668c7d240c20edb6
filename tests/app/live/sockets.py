"""What tests of the live sockets share: sessions, a gateway on its socket, and waiting for messages."""

import asyncio
import contextlib
import json
from collections.abc import AsyncIterator, Awaitable, Callable
from typing import Any

from websockets.asyncio.client import ClientConnection, connect

from app.gateway import DeviceStream, ServiceClient
from app.recordings.schemas import SessionIn
from tests.patience import PATIENCE_S

SignedIn = Callable[..., Awaitable[ServiceClient]]
Message = dict[str, Any]


async def new_session(client: ServiceClient, patient_id: str, stream: DeviceStream) -> str:
    made = await client.create_session(SessionIn(patient_id=patient_id, placements=list(stream.placements)))  # type: ignore[arg-type]
    return made.id


@contextlib.asynccontextmanager
async def gateway(
    client: ServiceClient, session_id: str, stream: DeviceStream
) -> AsyncIterator[ClientConnection]:
    """A connection after its hello was acknowledged; it comes again while the service is being prepared."""
    async with contextlib.AsyncExitStack() as stack, asyncio.timeout(PATIENCE_S) as patience:
        while True:
            socket = await stack.enter_async_context(connect(client.ingest_url, proxy=None))
            hello = stream.hello(await client.ticket(session_id))
            await socket.send(hello.model_dump_json(exclude_none=True))
            answer = json.loads(await socket.recv())
            if answer["type"] == "acknowledge":
                break
            assert answer["details"].get("reason") == "preparing", answer
        patience.reschedule(None)
        yield socket


async def until(
    socket: ClientConnection, wanted: Callable[[Message], bool], timeout_s: float = PATIENCE_S
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
