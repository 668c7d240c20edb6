"""The short way of binary messages: whole frames where they lie, whatever the network does to them."""

import contextlib
import socket
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from starlette.websockets import WebSocket, WebSocketDisconnect
from websockets.frames import Frame, Opcode
from websockets.streams import StreamReader

from app.network.lean_sockets import WHOLE_BINARY, WHOLE_TEXT, LeanSocket, frame_head, lean_socket
from tests.app.serving import serving
from tests.patience import PATIENCE_S
from tests.ports import free_port


class Reader:
    """Notes what comes the short way, and slows the sender down where it is asked to."""

    def __init__(self, connection: LeanSocket, pause_s: float) -> None:
        self.got: list[bytes] = []
        self.connection, self._pause_s = connection, pause_s

    def received(self, buffer: bytes, start: int, length: int, key: int) -> None:
        mask = np.resize(np.frombuffer(key.to_bytes(4, "little"), np.uint8), length)
        self.got.append((np.frombuffer(buffer, np.uint8, length, start) ^ mask).tobytes())
        if self.got[-1] == b"wrong":
            raise ValueError
        if self._pause_s:
            self.connection.slow_down(self._pause_s)


class Application:
    """Attaches to its socket after the first text, and takes the rest the ordinary way."""

    def __init__(self) -> None:
        self.reader: Reader | None = None
        self.ordinary: list[Any] = []
        self.is_sent_to_nobody = False
        self.pause_at_end_s = 0.0

    async def __call__(self, scope: Any, receive: Any, send: Any) -> None:
        websocket = WebSocket(scope, receive, send)
        await websocket.accept()
        connection = lean_socket(websocket)
        assert connection is not None
        try:
            pause_s = float(await websocket.receive_text())
            self.reader = Reader(connection, pause_s)
            connection.attach(self.reader)
            await websocket.send_text("attached")
            while True:
                message = await websocket.receive()
                if message["type"] == "websocket.disconnect":
                    return
                self.ordinary.append(message.get("bytes") or message.get("text"))
                if message.get("text") == "end":
                    if self.pause_at_end_s:
                        connection.slow_down(self.pause_at_end_s)
                    await websocket.close()
                    # Whoever still has something to say needs not know, and falls back on nothing that raises.
                    self.is_sent_to_nobody = connection.send_text_now("late")
                    return
        except WebSocketDisconnect:
            return


KEEPALIVE_S = 0.3


@pytest.fixture
def served(request: pytest.FixtureRequest) -> Iterator[tuple[Application, socket.socket]]:
    """The application and a client's socket after the handshake; settings of uvicorn may be its parameter."""
    application, port = Application(), free_port()
    with serving(application, port, ws=LeanSocket, lifespan="off", **getattr(request, "param", {})):
        connection = socket.create_connection(("127.0.0.1", port), timeout=PATIENCE_S)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        connection.sendall(
            f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n".encode()
        )
        answer = b""
        while b"\r\n\r\n" not in answer:
            answer += connection.recv(4096)
        yield application, connection
        connection.close()


def frame(payload: bytes, opcode: int, key: int, *, is_last: bool = True) -> bytes:
    size = len(payload)
    mask = key.to_bytes(4, "little")
    head = bytes([(0x80 if is_last else 0) | opcode])
    head += bytes([0x80 | size]) if size < 126 else b"\xfe" + size.to_bytes(2, "big")
    masked = np.frombuffer(payload, np.uint8) ^ np.resize(np.frombuffer(mask, np.uint8), size)
    return head + mask + masked.tobytes()


def begin(connection: socket.socket, pause_s: float) -> None:
    connection.sendall(frame(str(pause_s).encode(), 1, 7))
    assert b"attached" in connection.recv(4096)


def until(is_met: Any) -> None:
    deadline = time.monotonic() + PATIENCE_S
    while not is_met():
        assert time.monotonic() < deadline
        time.sleep(0.01)


def test_frames_in_any_pieces_arrive_whole_and_in_order(served: tuple[Application, socket.socket]) -> None:
    application, connection = served
    begin(connection, 0.0)
    random = np.random.default_rng(5)
    messages = [random.bytes(int(random.choice([0, 1, 125, 126, 1568, 9000]))) for _ in range(60)]
    sent = b"".join(frame(one, 2, int(random.integers(1 << 32))) for one in messages)
    # In pieces of its own, a message is none of the short way; a ping may come between its pieces.
    sent += frame(b"first ", 2, 1, is_last=False) + frame(b"", 9, 1) + frame(b"second", 0, 1)
    sent += frame(b"end", 1, 3)
    at = 0
    while at < len(sent):
        size = int(random.choice([1, 2, 3, 900, 5000]))
        connection.sendall(sent[at : at + size])
        at += size
    until(lambda: application.is_sent_to_nobody)
    assert application.reader is not None
    assert application.reader.got == messages
    assert application.ordinary == [b"first second", "end"]


def got(application: Application) -> list[bytes]:
    return [] if application.reader is None else application.reader.got


def test_a_sender_that_is_slowed_down_waits(served: tuple[Application, socket.socket]) -> None:
    """However much one reading held: behind each message that is too much nothing is given on for a while."""
    application, connection = served
    begin(connection, 0.2)
    one = frame(b"x" * 1500, 2, 9)
    began_s = time.monotonic()
    connection.sendall(5 * one)
    until(lambda: got(application))
    connection.sendall(4 * one + frame(b"end", 1, 3))
    for count in range(1, 9):
        assert len(got(application)) <= 1 + (time.monotonic() - began_s) / 0.2
        until(lambda least=count + 1: len(got(application)) >= least)  # type: ignore[misc]
    assert time.monotonic() - began_s >= 8 * 0.2 - 0.01
    until(lambda: application.is_sent_to_nobody)
    assert application.ordinary == ["end"]


def test_what_a_slowed_sender_goes_on_sending_waits_at_the_sender(
    served: tuple[Application, socket.socket],
) -> None:
    application, connection = served
    begin(connection, 60.0)
    connection.settimeout(0.5)
    sent, one = 0, frame(b"x" * 60_000, 2, 9)
    with contextlib.suppress(TimeoutError):
        while sent < 60_000_000:
            sent += connection.send(one)
    assert sent < 60_000_000
    assert len(got(application)) == 1
    assert application.reader is not None
    assert len(application.reader.connection._held) < 400_000 < sent


def test_text_between_what_is_held_comes_in_its_place_and_reading_goes_on(
    served: tuple[Application, socket.socket],
) -> None:
    application, connection = served
    begin(connection, 0.0133)
    parts = [b"%d" % number for number in range(40)]
    sent = b"".join(frame(part, 2, 9) + frame(part, 1, 8) for part in parts)
    pieces = frame(b"in ", 2, 1, is_last=False) + frame(b"", 9, 1) + frame(b"pieces", 0, 1)
    for piece in (
        sent[: len(sent) // 2],
        sent[len(sent) // 2 :],
        pieces[:7],
        pieces[7:],
        frame(b"end", 1, 3),
    ):
        connection.sendall(piece)
        time.sleep(0.05)
    until(lambda: application.is_sent_to_nobody)
    assert got(application) == parts
    assert application.ordinary == [*(part.decode() for part in parts), b"in pieces", "end"]


@pytest.mark.parametrize(
    "served", [{"ws_ping_interval": KEEPALIVE_S, "ws_ping_timeout": KEEPALIVE_S}], indirect=True
)
def test_a_slowed_sender_is_not_ended_for_a_pong_that_waits_behind_its_packets(
    served: tuple[Application, socket.socket],
) -> None:
    application, connection = served
    begin(connection, KEEPALIVE_S)
    connection.sendall(8 * frame(b"x" * 1500, 2, 9))
    until(lambda: len(got(application)) == 8)
    # It has sent no pong, and nothing of it waits any more.
    received = b""
    while piece := connection.recv(4096):
        received += piece
    assert b"keepalive" in received


def test_a_reader_that_fails_behind_a_pause_ends_the_connection(
    served: tuple[Application, socket.socket],
) -> None:
    application, connection = served
    begin(connection, 0.1)
    # Not only by the keepalive, after 20 s and more.
    connection.settimeout(10.0)
    connection.sendall(frame(b"right", 2, 9) + frame(b"wrong", 2, 9) + frame(b"never", 2, 9))
    with contextlib.suppress(ConnectionResetError):
        while connection.recv(4096):
            pass
    assert got(application) == [b"right", b"wrong"]


def test_nothing_gathers_behind_the_end_of_a_slowed_connection(
    served: tuple[Application, socket.socket],
) -> None:
    application, connection = served
    begin(connection, 0.0)
    application.pause_at_end_s = 60.0
    connection.sendall(frame(b"x", 2, 9) + frame(b"end", 1, 3))
    until(lambda: application.is_sent_to_nobody)
    assert application.reader is not None
    with contextlib.suppress(OSError):
        for _ in range(200):
            connection.sendall(frame(b"x" * 60_000, 2, 9))
    assert len(application.reader.connection._held) < 400_000
    assert got(application) == [b"x"]


def test_reading_goes_on_behind_a_text_whatever_the_clock_says(
    served: tuple[Application, socket.socket],
) -> None:
    """Timers may run a millisecond before their time."""
    application, connection = served
    begin(connection, 0.0)
    assert application.reader is not None
    application.reader.connection._until_s = application.reader.connection.loop.time() + 60.0
    connection.sendall(frame(b"text", 1, 3))
    until(lambda: application.ordinary)
    connection.sendall(frame(b"x", 2, 9))
    until(lambda: got(application))


def test_nothing_is_handed_over_behind_the_end(served: tuple[Application, socket.socket]) -> None:
    application, connection = served
    begin(connection, 0.0)
    connection.sendall(frame(b"\x03\xe8", 8, 1) + frame(b"late", 2, 1))
    assert application.reader is not None
    until(lambda: connection.recv(4096) == b"")
    assert application.reader.got == []


@pytest.mark.parametrize("size", [0, 1, 125, 126, 65_535, 65_536])
@pytest.mark.parametrize(("first", "opcode"), [(WHOLE_TEXT, Opcode.TEXT), (WHOLE_BINARY, Opcode.BINARY)])
def test_what_is_written_as_it_is_is_a_frame(size: int, first: int, opcode: Opcode) -> None:
    reader = StreamReader()
    reader.feed_data(frame_head(first, size) + bytes(size))
    reader.feed_eof()
    parsing = Frame.parse(reader.read_exact, mask=False)
    with pytest.raises(StopIteration) as found:
        next(parsing)
    assert found.value.value == Frame(opcode, bytes(size))
    assert not reader.buffer
