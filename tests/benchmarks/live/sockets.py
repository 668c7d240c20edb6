"""WebSocket clients of a load that shares the machine with what it measures."""

import base64
import os
import socket
from dataclasses import dataclass, field
from typing import Final

PING: Final = 9
PONG: Final = 10
MOST_READ: Final = 1 << 16
"""More would be mapped anew by the allocator with every read, which costs more than the read."""


@dataclass
class Socket:
    """A WebSocket client that costs next to nothing: no masking key but zero, no copies."""

    connection: socket.socket
    session: int
    is_live: bool
    buffer: bytearray = field(default_factory=bytearray)
    texts: list[bytes] = field(default_factory=list)

    @classmethod
    def open(cls, port: int, path: str, session: int, first: str) -> "Socket":
        connection = socket.create_connection(("127.0.0.1", port), timeout=60)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        key = base64.b64encode(os.urandom(16)).decode()
        connection.sendall(
            f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            f"Sec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n\r\n".encode()
        )
        answer = bytearray()
        while b"\r\n\r\n" not in answer:
            answer += connection.recv(4096)
        head, rest = bytes(answer).split(b"\r\n\r\n", 1)
        assert b" 101 " in head, head
        connection.sendall(client_frame(first.encode(), opcode=1))
        return cls(connection, session, path != "/ws/ingest", bytearray(rest))

    def first_text(self) -> bytes:
        """Wait for the first text message and return it."""
        while not self.texts:
            self.texts += [payload for opcode, payload in self.read() if opcode == 1]
        return self.texts[0]

    def answer_pings(self) -> None:
        """Read what has come and answer pings: a service gives up a socket that leaves them unanswered."""
        self.connection.setblocking(False)
        try:
            for opcode, payload in self.read():
                if opcode == PING:
                    self.connection.sendall(client_frame(payload, opcode=PONG))
                elif opcode == 1:
                    self.texts.append(payload)
        except BlockingIOError:
            pass
        finally:
            self.connection.setblocking(True)

    def read(self) -> list[tuple[int, bytes]]:
        """Return the (opcode, payload) of what has come."""
        data = self.connection.recv(MOST_READ)
        if not data:
            raise ConnectionError(f"the service closed a socket: {self.texts[-1:]}")
        self.buffer += data
        found = []
        while len(self.buffer) >= 2:
            length, start = self.buffer[1] & 127, 2
            if length == 126:
                length, start = int.from_bytes(self.buffer[2:4], "big"), 4
            elif length == 127:
                length, start = int.from_bytes(self.buffer[2:10], "big"), 10
            if len(self.buffer) < start + length:
                break
            opcode = self.buffer[0] & 15
            # Of a frame block only the header matters here.
            keep = 40 if opcode == 2 else length
            found.append((opcode, bytes(self.buffer[start : start + keep])))
            del self.buffer[: start + length]
        return found


def client_frame(payload: bytes, opcode: int = 2) -> bytes:
    """A masked client frame; with the key zero the payload stays as it is."""
    size = len(payload)
    length = bytes([0x80 | size]) if size < 126 else b"\xfe" + size.to_bytes(2, "big")
    return bytes([0x80 | opcode]) + length + b"\0\0\0\0" + payload
