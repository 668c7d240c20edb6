"""Requests that steer a session, answered by the worker that holds it: rights, audit and words are its own."""

from typing import Final

from fastapi import APIRouter, Request, Response
from fastapi.routing import APIRoute

from app.live.calibration.endpoints import router as calibration_router
from app.live.endpoints import steering_router
from app.live.guidance.endpoints import router as guidance_router
from app.scaled import wire
from app.scaled.edge.service import EdgeLiveService
from app.services import services_of

_HERE: Final = {"give_ticket"}
"""Needs the database only."""
_OF_CONNECTION: Final = {b"connection", b"content-length", b"transfer-encoding", b"keep-alive", b"upgrade"}


async def forward(session_id: str, request: Request) -> Response:
    """Have a request answered where the session is live."""
    client = request.client
    asked = wire.Request(
        request.method,
        request.url.path + (f"?{request.url.query}" if request.url.query else ""),
        [(name, value) for name, value in request.headers.raw if name not in _OF_CONNECTION],
        await request.body(),
        ("", 0) if client is None else (client.host, client.port),
    )
    answer = await services_of(request).get(EdgeLiveService).ask(session_id, asked)
    response = Response(answer.body, answer.status)
    response.raw_headers = [(name, value) for name, value in answer.headers if name not in _OF_CONNECTION]
    response.raw_headers.append((b"content-length", str(len(answer.body)).encode()))
    return response


def forwarding_router() -> APIRouter:
    """Return the routes that an edge answers through a worker; matched before those of the live side."""
    router = APIRouter()
    for source in (steering_router, calibration_router, guidance_router):
        for route in source.routes:
            if isinstance(route, APIRoute) and "{session_id}" in route.path and route.name not in _HERE:
                router.add_api_route(
                    route.path, forward, methods=sorted(route.methods or ()), include_in_schema=False
                )
    return router
