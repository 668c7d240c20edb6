"""A TCP relay between a browser and the service that can be broken and mended, as a home's network is."""

import contextlib
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from urllib.parse import urlsplit


class Relay:
    """Passes bytes on until it is broken: then every connection is cut and no new one is taken.

    Or it swallows them, as a network that went away does: no connection is closed, and nothing arrives.
    """

    def __init__(self) -> None:
        self._target = ("127.0.0.1", 0)
        self._pairs: set[tuple[socket.socket, socket.socket]] = set()
        self._is_broken = self._swallows = False
        self._refused = b""
        self._lets_sockets_through = True
        self._dead: set[tuple[socket.socket, ...]] = set()
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.address = f"http://127.0.0.1:{self._listener.getsockname()[1]}"

    def serve(self, target: str) -> None:
        """Begin to pass on to this address."""
        parts = urlsplit(target)
        self._target = (parts.hostname or "", parts.port or 0)
        threading.Thread(target=self._accept, daemon=True).start()

    def break_link(self) -> None:
        self._is_broken = True
        for pair in list(self._pairs):
            self._cut(pair)

    def swallow(self) -> None:
        """Take everything and pass nothing on, until mended; what was taken is gone."""
        self._swallows = True

    def refuse(self, beginning: bytes) -> None:
        """Cut every connection that asks for something that begins so, as if it did not come through."""
        self._refused = beginning

    def refuse_sockets(self) -> None:
        """Answer each handshake of a WebSocket with 403, as proxies of clinics do; HTTP passes."""
        self._lets_sockets_through = False

    def mend(self) -> None:
        """Pass on again, over new connections: those that lost something on the way are dead."""
        dead = list(self._pairs) if self._swallows else []
        self._is_broken, self._swallows, self._refused = False, False, b""
        self._lets_sockets_through = True
        self._dead.update(dead)

    def close(self) -> None:
        self._listener.close()
        self.break_link()

    def _accept(self) -> None:
        with contextlib.suppress(OSError):
            while True:
                inner, _ = self._listener.accept()
                if self._is_broken:
                    inner.close()
                    continue
                try:
                    outer = socket.create_connection(self._target)
                except OSError:
                    inner.close()
                    continue
                pair = (inner, outer)
                self._pairs.add(pair)
                for source, sink in (pair, pair[::-1]):
                    threading.Thread(target=self._pass, args=(source, sink, pair), daemon=True).start()

    def _pass(self, source: socket.socket, sink: socket.socket, pair: tuple[socket.socket, ...]) -> None:
        with contextlib.suppress(OSError):
            while data := source.recv(65536):
                if self._refused and data.startswith(self._refused):
                    break
                if not self._lets_sockets_through and _is_handshake(data):
                    source.sendall(
                        b"HTTP/1.1 403 Forbidden\r\nContent-Length: 0\r\nConnection: close\r\n\r\n"
                    )
                    break
                if self._swallows or pair in self._dead:
                    continue
                sink.sendall(data)
        self._cut((pair[0], pair[1]))

    def _cut(self, pair: tuple[socket.socket, socket.socket]) -> None:
        self._pairs.discard(pair)
        for one in pair:
            with contextlib.suppress(OSError):
                one.shutdown(socket.SHUT_RDWR)
            one.close()


def _is_handshake(data: bytes) -> bool:
    """Whether these first bytes of a request ask for a WebSocket: a browser sends them in one piece."""
    return data.startswith(b"GET ") and b"upgrade: websocket" in data.lower()


@contextmanager
def relaying() -> Iterator[Relay]:
    relay = Relay()
    try:
        yield relay
    finally:
        relay.close()
