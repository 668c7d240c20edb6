"""`telemotion edge`, `telemotion worker` and `telemotion nats-config`: the parts of a service on many machines."""

from pathlib import Path
from typing import Final

from starlette.types import ASGIApp, Receive, Scope, Send

from app import logs
from app.commands.options.starting import NatsOptions
from app.commands.private_folder import make_private
from app.commands.serve import imported_for_good, listen, run_application
from app.database.writer_lock import shared_lock
from app.processes.c_heap import share_arenas
from app.settings import Settings

OPEN_PATHS: Final = frozenset({"/api/health", "/api/ready", "/metrics"})
"""All that a worker answers directly; the rest comes by way of an edge."""


def edge(host: str, port: int) -> None:
    """Serve gateways and browsers until stopped; sessions are live in workers.

    Parameters
    ----------
    host : str
        Address to listen on.

    Raises
    ------
    Conflict
        The port is taken, or a service in one process has the database.
    InvalidInput, Unavailable
        NATS or the database cannot be reached, or the database is not PostgreSQL.
    """
    share_arenas()
    with imported_for_good():
        from app.parts import create_edge, named, process_name

    settings = named(Settings(), process_name("edge"))
    logs.configure(settings)
    with listen(host, port) as listener:
        lock = shared_lock(settings.database_url, "telemotion edge", f"{host}:{port}")
        make_private(settings)
        run_application(settings, create_edge(settings, lock), listener, settings.drain_seconds)


def worker(host: str, port: int) -> None:
    """Hold partitions of live sessions until stopped; health and metrics are at the address. See `edge`."""
    share_arenas()
    with imported_for_good():
        from app.parts import create_worker, named, process_name

    name = process_name("worker")
    settings = named(Settings(), name)
    logs.configure(settings)
    with listen(host, port) as listener:
        lock = shared_lock(settings.database_url, "telemotion worker", f"{host}:{port}")
        make_private(settings)
        run_application(settings, _Guarded(create_worker(settings, lock, name)), listener)


def nats_config(options: NatsOptions) -> None:
    """Write the configuration of a NATS server that takes gateways by MQTT; only its owner may read it.

    Raises
    ------
    InvalidInput
        `TELEMOTION_NATS_URL` names no user and password.
    """
    from app.scaled.mqtt.configuration import configuration

    words = vars(options).copy()
    out: Path = words.pop("out")
    text = configuration(Settings(), **words)
    out.unlink(missing_ok=True)
    out.touch(mode=0o600)
    out.write_text(text)


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
