"""`/ws/ingest`: where gateways come in; the conversation is `app.ingest.websocket`."""

import contextlib

from fastapi import APIRouter, WebSocket
from starlette.websockets import WebSocketDisconnect, WebSocketDisconnected

from app.ingest.websocket import IngestConnection
from app.live.service import LiveService
from app.live.wrong_tickets import CountedSink, WrongTickets
from app.network.lean_sockets import lean_socket
from app.services import services_of

router = APIRouter()


@router.websocket("/ws/ingest")
async def ingest(websocket: WebSocket) -> None:
    """Serve one gateway."""
    await websocket.accept()
    services = services_of(websocket)
    speed = services.settings.stream_speed
    address = websocket.client.host if websocket.client else ""
    sink = CountedSink(services.get(LiveService), services.get(WrongTickets), address)
    connection = IngestConnection(websocket, sink, speed, lean_socket(websocket))
    with contextlib.suppress(WebSocketDisconnect, WebSocketDisconnected):
        await connection.serve()
