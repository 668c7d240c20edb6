"""A service on a real port of this machine, for what needs a socket."""

import contextlib
import threading
from collections.abc import Iterator
from typing import Any

import uvicorn
from starlette.types import ASGIApp


@contextlib.contextmanager
def serving(app: ASGIApp, port: int, **config: Any) -> Iterator[str]:
    """Serve in a thread while the context lasts; gives the address."""
    config = {"log_level": "error", "ws": "websockets-sansio"} | config
    server = uvicorn.Server(uvicorn.Config(app, port=port, **config))
    thread = threading.Thread(target=server.run)
    thread.start()
    try:
        while not server.started:
            assert thread.is_alive(), "the service did not start"
            thread.join(0.05)
        yield f"http://127.0.0.1:{port}"
    finally:
        server.should_exit = True
        thread.join()
