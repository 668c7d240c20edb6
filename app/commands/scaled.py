"""`telemotion edge` and `telemotion worker`: the parts of a service on many machines."""

import contextlib
import logging
import socket
import sys
from typing import Any, Final

import uvicorn
from starlette.types import ASGIApp, Receive, Scope, Send

from app import logs
from app.commands.private_folder import make_private
from app.commands.serve import EXIT_NOT_STARTED, listen
from app.database.writer_lock import shared_lock
from app.settings import Settings

logger = logging.getLogger("telemotion.service")

OPEN_PATHS: Final = frozenset({"/api/health", "/api/ready", "/metrics"})
"""All that a worker answers directly; the rest comes by way of an edge."""


def edge(host: str, port: int) -> None:
    """Serve gateways and browsers until stopped; sessions are live in workers.

    Parameters
    ----------
    host : str
        Address to listen on.
    port : int

    Raises
    ------
    Conflict
        The port is taken, or a service in one process has the database.
    InvalidInput, Unavailable
        NATS or the database cannot be reached, or the database is not PostgreSQL.
    """
    from app.parts import create_edge, named, process_name

    settings = named(Settings(), process_name("edge"))
    logs.configure(settings)
    with listen(host, port) as listener:
        lock = shared_lock(settings.database_url, "telemotion edge", f"{host}:{port}")
        make_private(settings)
        _run(settings, create_edge(settings, lock), listener)


def worker(host: str, port: int) -> None:
    """Hold partitions of live sessions until stopped; health and metrics are at the address. See `edge`."""
    from app.parts import create_worker, named, process_name

    name = process_name("worker")
    settings = named(Settings(), name)
    logs.configure(settings)
    with listen(host, port) as listener:
        lock = shared_lock(settings.database_url, "telemotion worker", f"{host}:{port}")
        make_private(settings)
        _run(settings, _Guarded(create_worker(settings, lock, name)), listener)


class _Guarded:
    """Answers nothing but `OPEN_PATHS`."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan" or (scope["type"] == "http" and scope["path"] in OPEN_PATHS):
            await self._app(scope, receive, send)
        elif scope["type"] == "http":
            await send({"type": "http.response.start", "status": 404, "headers": []})
            await send({"type": "http.response.body", "body": b""})
        else:
            await send({"type": "websocket.close", "code": 1008})


def _run(settings: Settings, app: Any, listener: socket.socket) -> None:
    from app.edge.slow_senders import timed_headers
    from app.network.lean_sockets import LeanSocket

    server = uvicorn.Server(
        uvicorn.Config(
            app,
            ws=LeanSocket,
            loop="uvloop",
            http=timed_headers(settings.request_header_seconds, settings.request_floor_bytes_per_s),
            ws_per_message_deflate=False,
            ws_max_size=1 << 20,
            access_log=False,
            log_config=None,
            timeout_graceful_shutdown=10,
            server_header=False,
            forwarded_allow_ips=settings.trusted_proxies,
        )
    )
    with contextlib.suppress(KeyboardInterrupt):
        server.run(sockets=[listener])
    if not server.started:
        sys.exit(EXIT_NOT_STARTED)


__all__ = ["edge", "worker"]
