"""Opening views, their page, its socket and the socket that steers them."""

import asyncio
import contextlib
import gzip
from functools import lru_cache
from typing import Annotated
from urllib.parse import urlsplit

from fastapi import APIRouter, Request, Response, WebSocket
from pydantic import Field, TypeAdapter, ValidationError
from starlette.websockets import WebSocketDisconnect, WebSocketState

from app.accounts.dependencies import CurrentAccount, websocket_subject
from app.errors import InvalidInput, TelemotionError
from app.live.checks.pulse import Pulse
from app.live.messages import CameraCommand, ErrorMessage, PlayerCommand
from app.recordings.schemas import ViewIn, ViewOut
from app.services import Services, services_of
from app.viewer.page import build_page
from app.viewer.proxy import keep_checking, relay, until_one_ends
from app.viewer.service import View, Viewer
from estimators.sentences import say

router = APIRouter(tags=["views"])

_LARGEST_COMMAND = 2048
_COMMAND: TypeAdapter[PlayerCommand | CameraCommand] = TypeAdapter(
    Annotated[PlayerCommand | CameraCommand, Field(discriminator="type")]
)


@router.post("/api/sessions/{session_id}/views", status_code=201)
async def open_view(session_id: str, wanted: ViewIn, request: Request, subject: CurrentAccount) -> ViewOut:
    """Open a 3D view of a session, live or as a replay, with the template's ghost when there is one."""
    viewer: Viewer = services_of(request).get(Viewer)
    return await viewer.open(subject, session_id, wanted)


@router.get("/viewer/{view_id}/", response_class=Response, include_in_schema=False)
async def page(view_id: str, request: Request, subject: CurrentAccount) -> Response:
    """Return the page of a view, for a frame of the client."""
    services = services_of(request)
    viewer: Viewer = services.get(Viewer)
    await viewer.check(subject, view_id)
    built = await asyncio.to_thread(build_page)
    headers = {
        "Content-Security-Policy": built.policy(_socket_origin(services)),
        "X-Frame-Options": "SAMEORIGIN",
        "Cache-Control": "private, no-store",
        "Vary": "Accept-Encoding",
    }
    if "gzip" in request.headers.get("accept-encoding", ""):
        headers["Content-Encoding"] = "gzip"
        return Response(await asyncio.to_thread(_compressed_page), media_type="text/html", headers=headers)
    return Response(built.html, media_type="text/html", headers=headers)


@router.websocket("/viewer/{view_id}")
async def page_socket(websocket: WebSocket, view_id: str) -> None:
    """Relay between the page of a view and its scene."""
    viewer: Viewer = services_of(websocket).get(Viewer)
    subject = await websocket_subject(websocket)
    with services_of(websocket).limits.take("sockets", subject), contextlib.suppress(WebSocketDisconnect):
        await relay(websocket, viewer, subject, view_id)


@router.websocket("/ws/views/{view_id}")
async def control(websocket: WebSocket, view_id: str) -> None:
    """Steer a view: `player` and `camera` commands in, `player_state` out."""
    services = services_of(websocket)
    viewer: Viewer = services.get(Viewer)
    # Accepted first: a browser does not learn why a handshake was refused, so it could not open another view.
    await websocket.accept()
    try:
        subject = await websocket_subject(websocket)
        view = await viewer.check(subject, view_id)
        with services.limits.take("sockets", subject), view.watched():
            await until_one_ends(
                _commands(websocket, viewer, view),
                keep_checking(websocket, viewer, view_id),
                Pulse(websocket).run(),
            )
    except TelemotionError as error:
        await _say_why(websocket, error)
        raise


async def _commands(websocket: WebSocket, viewer: Viewer, view: View) -> None:
    stage = await viewer.stage_of(view)
    await websocket.send_text(stage.player.state().model_dump_json())
    while True:
        received = await websocket.receive()
        if received["type"] == "websocket.disconnect":
            return
        text = received.get("text") or ""
        try:
            if len(text) > _LARGEST_COMMAND:
                raise InvalidInput(say("viewer.command_too_long"))
            try:
                command = _COMMAND.validate_json(text)
            except ValidationError as error:
                fields = sorted({".".join(str(part) for part in found["loc"]) for found in error.errors()})
                raise InvalidInput(say("viewer.command"), fields=fields) from None
            state = await viewer.obey(view, command)
        except InvalidInput as error:
            answer = ErrorMessage.of(error, closing=False)
            await websocket.send_text(answer.model_dump_json())
            continue
        await websocket.send_text(state.model_dump_json())


async def _say_why(websocket: WebSocket, error: TelemotionError) -> None:
    if websocket.application_state is not WebSocketState.CONNECTED:
        return
    message = ErrorMessage.of(error, closing=True)
    with contextlib.suppress(WebSocketDisconnect, RuntimeError):
        await websocket.send_text(message.model_dump_json())


def _socket_origin(services: Services) -> str:
    scheme = "wss" if services.settings.is_https else "ws"
    return f"{scheme}://{urlsplit(services.settings.base_url).netloc}"


@lru_cache(maxsize=1)
def _compressed_page() -> bytes:
    return gzip.compress(build_page().html.encode("utf-8"), 6, mtime=0)
