"""`/ws/live/{session_id}`: what a dashboard sees of a session, as it happens.

A browser is known by its cookie and its Origin, others by a first message `{"ticket": ...}`. Then come the
layout, the state, and from then on every change, link health once a second and frames as binary blocks; a
pulse in each second without a word. A slow client loses frames, never states; nothing it does slows the session.
The right is checked again every few seconds, and the socket ends when it is lost.
"""

import asyncio
import contextlib
import random
from typing import Any

from fastapi import APIRouter, WebSocket
from pydantic import ValidationError
from starlette.websockets import WebSocketDisconnect, WebSocketDisconnected, WebSocketState

from app.accounts.credentials.cookies import shown_cookie
from app.accounts.credentials.sign_in import COOKIE
from app.accounts.dependencies import shown_token, websocket_subject
from app.accounts.subject import Subject
from app.errors import InvalidInput, SignInRequired, TelemotionError
from app.live import repository
from app.live.blocks import PublishedBlock, PublishedFrames
from app.live.bus import Subscription, topic
from app.live.checks.pulse import Pulse
from app.live.rights.authorization_checks import AuthorizationCheck, still_allowed
from app.live.rights.grace_period import GracePeriod
from app.live.service import LiveService
from app.live.wrong_tickets import WrongTickets
from app.network.conversation import until_first_ends
from app.network.lean_sockets import LeanSocket, lean_socket
from app.network.messages import ErrorMessage
from app.schemas import Schema
from app.services import Services, services_of
from estimators.sentences import say

TICKET_TIMEOUT_S = 10.0
FRAMES_KEPT = 16
MESSAGES_KEPT = 256

router = APIRouter()


class TicketMessage(Schema):
    """First message of a client without a cookie."""

    ticket: str


@router.websocket("/ws/live/{session_id}")
async def watch(websocket: WebSocket, session_id: str) -> None:
    """Serve one dashboard."""
    await websocket.accept()
    services = services_of(websocket)
    with contextlib.suppress(WebSocketDisconnect, WebSocketDisconnected):
        try:
            right = await _who(websocket, services, session_id)
            with services.limits.take("sockets", right.subject):
                await asyncio.to_thread(still_allowed, services.engine, right)
                stored = await asyncio.to_thread(repository.load, services.engine, session_id)
                await _serve(websocket, services.get(LiveService), stored, right)
        except TelemotionError as error:
            await _end(websocket, error)


async def _who(websocket: WebSocket, services: Services, session_id: str) -> AuthorizationCheck:
    """Return the question that decides, now and again later, whether this client may watch."""
    engine = services.engine
    if shown_cookie(services.settings, websocket, COOKIE) or shown_token(websocket)[1]:
        subject = await websocket_subject(websocket)
    else:
        subject = await _subject_of_ticket(websocket, services, session_id)
    stored = await asyncio.to_thread(
        repository.authorise, engine, subject, session_id, "read", "session.watch"
    )
    # A socket's Origin, which `current_subject` looks at too, stays what it was.
    return AuthorizationCheck(subject, stored.id, "read", services.settings)


async def _subject_of_ticket(websocket: WebSocket, services: Services, session_id: str) -> Subject:
    try:
        async with asyncio.timeout(TICKET_TIMEOUT_S):
            text = await websocket.receive_text()
        ticket = TicketMessage.model_validate_json(text).ticket
    except TimeoutError as error:
        raise SignInRequired(say("live.ticket_first")) from error
    except (ValidationError, KeyError) as error:
        raise InvalidInput(say("live.ticket_message")) from error
    address = websocket.client.host if websocket.client else ""
    with services.get(WrongTickets).counted(address):
        return await asyncio.to_thread(repository.watch_by_ticket, services.engine, ticket, session_id)


async def _serve(
    websocket: WebSocket, live: LiveService, stored: repository.StoredSession, right: AuthorizationCheck
) -> None:
    names = ("layout", "state", "health", "event", "calibration", "guidance")
    blocks = topic(stored.id, "blocks")
    socket = lean_socket(websocket)
    with (
        live.bus.subscribe(*(() if socket else (blocks,)), size=FRAMES_KEPT) as frames,
        live.bus.subscribe(*(topic(stored.id, name) for name in names), size=MESSAGES_KEPT) as messages,
        contextlib.ExitStack() as stack,
    ):
        for message in await live.first_messages(stored):
            await websocket.send_text(message.model_dump_json())
        if socket is not None:
            stack.enter_context(live.bus.attach(BlockSender(blocks, socket)))
        pulse = Pulse(websocket)
        tasks = [
            asyncio.create_task(_send_frames(websocket, frames), name="watch frames"),
            asyncio.create_task(_send_messages(websocket, messages, socket, pulse), name="watch messages"),
            asyncio.create_task(pulse.run(), name="watch pulse"),
            asyncio.create_task(_receive(websocket), name="watch receive"),
            asyncio.create_task(_keep_checking(live, right), name="watch right"),
        ]
        await until_first_ends(tasks)


class BlockSender:
    """Writes blocks into a connection as they are made; a client that does not keep up loses them.

    Parameters
    ----------
    name : str
        Topic of the blocks.
    """

    def __init__(self, name: str, socket: LeanSocket) -> None:
        self.topics: tuple[str, ...] = (name,)
        self._socket = socket

    def put(self, topic: str, message: Any) -> bool:
        """Send a block; False when it was dropped."""
        return self._socket.send_frame(message.frame)


async def _send_frames(websocket: WebSocket, frames: Subscription) -> None:
    async for item in frames:
        if isinstance(item, PublishedFrames | PublishedBlock):
            await websocket.send_bytes(item.block)


async def _send_messages(
    websocket: WebSocket, messages: Subscription, socket: LeanSocket | None, pulse: Pulse
) -> None:
    async for message in messages:
        pulse.said()
        text = message.model_dump_json()
        if socket is None or not socket.send_text_now(text):
            await websocket.send_text(text)


async def _receive(websocket: WebSocket) -> None:
    """Read and forget what the client sends, to notice when it leaves."""
    while (await websocket.receive())["type"] != "websocket.disconnect":
        pass


async def _keep_checking(live: LiveService, right: AuthorizationCheck) -> None:
    # Sockets that were opened together must not all be checked at the same moment.
    await asyncio.sleep(random.uniform(0.0, live.check_every_s))  # noqa: S311
    patience = GracePeriod()
    while True:
        await patience.wait(live.check_right(right))
        await asyncio.sleep(live.check_every_s)


async def _end(websocket: WebSocket, error: TelemotionError) -> None:
    if websocket.application_state is not WebSocketState.CONNECTED:
        return
    message = ErrorMessage.of(error, closing=True)
    with contextlib.suppress(WebSocketDisconnect, WebSocketDisconnected):
        await websocket.send_text(message.model_dump_json())
        await websocket.close(code=1008 if error.status < 500 else 1011, reason=error.code)
