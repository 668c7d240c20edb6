"""`telemotion serve`: the service in one process."""

import asyncio
import contextlib
import errno
import gc
import logging
import os
import socket
import sys
from collections.abc import Iterator
from typing import Final

import uvicorn
from starlette.types import ASGIApp

from app import logs
from app.commands.private_folder import make_private
from app.database import migrate
from app.database.writer_lock import WriterLock, writer_lock
from app.errors import Conflict, InvalidInput
from app.network.pace import pause_s
from app.processes.c_heap import gives_back, share_arenas
from app.settings import Settings

logger = logging.getLogger("telemotion.service")

EXIT_NOT_STARTED: Final = 3
EXIT_TAKEN_OVER: Final = 4
_WAITING_CONNECTIONS: Final = 2048


def serve(host: str, port: int) -> None:
    """Take the port and the database, bring it to the newest schema, then serve until stopped.

    Parameters
    ----------
    host : str
        Address to listen on.

    Raises
    ------
    Conflict
        The port is taken, or another process holds the database. Nothing was touched then.
    InvalidInput, Unavailable
        No such address on this machine; the database cannot be reached.
    """
    settings = Settings()
    with claim(settings, host, port, "telemotion serve") as (listener, lock):
        migrate.upgrade(settings.database_url)
        run(settings, listener, lock)


@contextlib.contextmanager
def claim(
    settings: Settings, host: str, port: int, purpose: str
) -> Iterator[tuple[socket.socket, WriterLock]]:
    """Hold a port and a database, in this order, before anything is read or changed.

    Parameters
    ----------
    settings : Settings
        `database_url` and `data_dir` are used; both are closed to other accounts of the machine.
    host, port
        As of `listen`.
    purpose : str
        What for; named to others who ask for the database.

    Yields
    ------
    listener : socket
    lock : WriterLock
    """
    logs.configure(settings)
    with (
        listen(host, port) as listener,
        writer_lock(settings.database_url, purpose, f"{host}:{port}") as lock,
    ):
        # Another process writes then. Closing in order would write too, so this one ends as if it were killed.
        lock.on_taken_over = _leave
        make_private(settings)
        yield listener, lock


def run(settings: Settings, listener: socket.socket, lock: WriterLock) -> None:
    """Serve everything in one process until asked to stop: a live session's estimator state lives in it.

    Parameters
    ----------
    settings : Settings
        Its database is at the newest schema.
    listener, lock
        From `claim`.

    Raises
    ------
    SystemExit
        The service could not open.
    """
    share_arenas()
    with imported_for_good():
        from app.main import create_app

    run_application(settings, create_app(settings, lock=lock), listener)


@contextlib.contextmanager
def imported_for_good() -> Iterator[None]:
    """Import what lives as long as the process without looking for garbage in it, then or later.

    There is hardly any, and looking through the growing heap again and again is a good part of these imports' time.
    """
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
        gc.freeze()
    finally:
        if was_on:
            gc.enable()


class DrainingServer(uvicorn.Server):
    """Sends who is connected away one after the other when it is asked to stop, where there are others to go to.

    A client that loses its connection reconnects at once, and each costs another edge some work: tickets, rights,
    the session's answer. All at once, the last would wait there for all of them, and longer the more there are.

    Parameters
    ----------
    seconds : float
        Longest time for it; 0 ends all at once.
    """

    def __init__(self, config: uvicorn.Config, seconds: float) -> None:
        super().__init__(config)
        self._seconds = seconds

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Let nobody in any more, send everybody away, and close the application."""
        from app.network.lean_sockets import LeanSocket

        for server in self.servers:
            server.close()
        for one in sockets or []:
            one.close()
        connected = [one for one in self.server_state.connections if isinstance(one, LeanSocket)]
        pause = pause_s(len(connected), self._seconds)
        for socket_ in connected:
            if self.force_exit or not pause:
                break
            if socket_.is_open:
                socket_.shutdown()
                await asyncio.sleep(pause)
        await super().shutdown(sockets)


def run_application(settings: Settings, app: ASGIApp, listener: socket.socket, drain_s: float = 0.0) -> None:
    """Serve an application until asked to stop.

    Parameters
    ----------
    listener : socket
        From `listen`.
    drain_s : float
        In which who is connected is sent to others when it stops, see `DrainingServer`.

    Raises
    ------
    SystemExit
        The application could not open.

    Notes
    -----
    Per-message deflate is off because packets are binary and small, and access lines are the service's own (no query
    strings, no patient data).
    """
    from app.edge.slow_senders import timed_headers
    from app.network.lean_sockets import LeanSocket

    server = DrainingServer(
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
        ),
        drain_s,
    )
    with gives_back(), contextlib.suppress(KeyboardInterrupt):
        server.run(sockets=[listener])
    if not server.started:
        sys.exit(EXIT_NOT_STARTED)


def listen(host: str, port: int) -> socket.socket:
    """Take a port now, so that nothing is prepared for one that somebody else has.

    Parameters
    ----------
    host : str
        Name or address of this machine.

    Returns
    -------
    socket
        Listening: who connects before the service is open waits for it.

    Raises
    ------
    Conflict
        Somebody else listens there.
    InvalidInput
        The address is none of this machine, or the port may not be used.
    """
    try:
        family, kind, protocol, _, place = socket.getaddrinfo(
            host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
        )[0]
        listener = socket.socket(family, kind, protocol)
        try:
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            listener.bind(place)
            listener.listen(_WAITING_CONNECTIONS)
        except OSError:
            listener.close()
            raise
    except OSError as error:
        reason = f"cannot listen on {host} port {port}"
        if error.errno == errno.EADDRINUSE:
            raise Conflict(
                f"{reason}: it is taken; stop what runs there, or choose another --port."
            ) from error
        raise InvalidInput(f"{reason}: {error.strerror}.") from error
    return listener


def _leave(sentence: str) -> None:
    logger.critical("%s This process ends.", sentence)
    logging.shutdown()
    os._exit(EXIT_TAKEN_OVER)
