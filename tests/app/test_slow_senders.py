"""Senders that are slow on purpose, over real sockets: headers and bodies that never end are ended."""

import logging
import socket
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from fastapi import FastAPI
from starlette.types import Message

from app.edge.error_answers import BodyTooSlow
from app.edge.slow_senders import MOST_HEAD_BYTES, TimedBodies, timed_headers
from app.settings import Settings
from tests.ports import free_port

from .conftest import BASE_URL, ServiceClient, World
from .serving import serving

HEADERS_S = 0.4
PATIENCE_S = 0.5
FLOOR = 2000.0
_NO_MORE = b"\r\ncontent-length: 0\r\nconnection: close\r\n\r\n"
WAIT_S = 60.0
"""A reading that has brought nothing after this long fails the test; what is asserted comes much sooner."""


@pytest.fixture
def settings(settings: Settings) -> Settings:
    limits = {"request_patience_seconds": PATIENCE_S, "request_floor_bytes_per_s": FLOOR}
    return settings.model_copy(update=limits)


@pytest.fixture
def port(application: FastAPI) -> Iterator[int]:
    port = free_port()
    with serving(application, port, http=timed_headers(HEADERS_S)):
        yield port


def connected(port: int) -> socket.socket:
    found = socket.create_connection(("127.0.0.1", port))
    found.settimeout(WAIT_S)
    return found


def rest(connection: socket.socket) -> bytes:
    """What comes until the service closes the connection."""
    found = b""
    try:
        while piece := connection.recv(65536):
            found += piece
    except ConnectionResetError:
        pass
    return found


def request(path: str, length: int, kind: str = "application/json") -> bytes:
    return (
        f"POST {path} HTTP/1.1\r\nHost: 127.0.0.1\r\nOrigin: {BASE_URL}\r\nContent-Type: {kind}\r\n"
        f"Content-Length: {length}\r\n\r\n"
    ).encode()


@pytest.mark.parametrize(
    "begun", [b"", b"G", b"GET /api/health HTTP/1.1\r\nHost: 127.0.0.1\r\n", b"\r\n\r\n"]
)
def test_headers_that_do_not_come_end_the_connection(port: int, begun: bytes) -> None:
    with connected(port) as connection:
        started = time.monotonic()
        connection.sendall(begun)
        said = rest(connection)
    assert time.monotonic() - started < WAIT_S / 2
    assert said.startswith(b"HTTP/1.1 408 ") if begun else said == b""


def test_a_byte_now_and_then_renews_nothing(port: int) -> None:
    with connected(port) as connection:
        started = time.monotonic()
        connection.sendall(b"GET /api/health HTTP/1.1\r\n")
        connection.settimeout(0.1)
        ended = False
        while not ended and time.monotonic() - started < WAIT_S:
            try:
                connection.sendall(b"X-A: b\r\n")
                ended = connection.recv(4096).startswith(b"HTTP/1.1 408 ")
            except TimeoutError:
                continue
    assert ended


def test_the_second_request_of_a_connection_is_timed_too(port: int) -> None:
    whole = b"GET /api/health HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"
    with connected(port) as connection:
        for _ in range(2):
            connection.sendall(whole)
            answer = b""
            while not answer.endswith(b"}"):
                answer += connection.recv(65536)
            assert answer.startswith(b"HTTP/1.1 200 ")
        connection.sendall(whole[:20])
        assert rest(connection).startswith(b"HTTP/1.1 408 ")


def test_endless_headers_end_the_connection(application: FastAPI) -> None:
    port = free_port()
    # So long a time that only the size can end it within `WAIT_S`.
    with serving(application, port, http=timed_headers(300.0)), connected(port) as connection:
        connection.sendall(b"GET /api/health HTTP/1.1\r\nX: ")
        connection.sendall(b"a" * (2 * MOST_HEAD_BYTES))
        # What was not read any more may end the connection before the answer is heard.
        assert rest(connection) in (b"", b"HTTP/1.1 431 Request Header Fields Too Large" + _NO_MORE)


def test_a_body_that_stops_is_answered_408_and_closed(port: int) -> None:
    with connected(port) as connection:
        connection.sendall(request("/api/sign-in", 100) + b'{"email": ')
        said = rest(connection)
    assert said.startswith(b"HTTP/1.1 408 ")
    assert b'"code":"too_slow"' in said
    assert b"connection: close" in said.lower()


async def _refusing(scope: Any, receive: Any, send: Any) -> None:
    """Answers before the body is there, as an upload is refused whose declaration is wrong."""
    if scope["type"] == "http":
        await send({"type": "http.response.start", "status": 422, "headers": [(b"content-length", b"2")]})
        await send({"type": "http.response.body", "body": b"no"})


@pytest.mark.slow
def test_who_is_refused_in_the_middle_of_an_upload_hears_why() -> None:
    """The rest of the body is longer than headers may be, and takes longer than they may."""
    port, size = free_port(), 3 * MOST_HEAD_BYTES
    with serving(_refusing, port, http=timed_headers(HEADERS_S, FLOOR)), connected(port) as connection:
        connection.sendall(request("/api/uploads", size))
        for _ in range(12):
            time.sleep(HEADERS_S / 8)
            connection.sendall(b"x" * (size // 12))
        said = connection.recv(65536)
        assert said.startswith(b"HTTP/1.1 422 ")
        assert said.endswith(b"\r\n\r\nno")
        connection.sendall(request("/again", 0))
        assert connection.recv(65536).startswith(b"HTTP/1.1 422 ")
        assert rest(connection) == b""


@pytest.mark.parametrize("then", [b"", b"x"])
def test_the_rest_of_an_answered_body_may_not_stop_or_crawl(then: bytes) -> None:
    port = free_port()
    with serving(_refusing, port, http=timed_headers(HEADERS_S, FLOOR)), connected(port) as connection:
        connection.sendall(request("/api/uploads", 1_000_000))
        said = connection.recv(65536)
        connection.sendall(b"x")
        connection.settimeout(0.05)
        started, ended = time.monotonic(), False
        while not ended and time.monotonic() - started < WAIT_S:
            try:
                connection.sendall(then)
                piece = connection.recv(65536)
            except TimeoutError:
                continue
            except (BrokenPipeError, ConnectionResetError):
                piece = b""
            said, ended = said + piece, not piece
    assert ended
    assert said.endswith(b"\r\n\r\nno"), "nothing is written behind the answer"


def test_endless_headers_behind_an_unanswered_request_end_the_connection() -> None:
    async def silent(scope: Any, receive: Any, send: Any) -> None:
        if scope["type"] == "http":
            while (await receive())["type"] != "http.disconnect":
                continue

    port = free_port()
    with serving(silent, port, http=timed_headers(300.0)), connected(port) as connection:
        connection.sendall(b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
        time.sleep(0.1)
        connection.sendall(b"GET / HTTP/1.1\r\nX: ")
        connection.sendall(b"a" * (2 * MOST_HEAD_BYTES))
        assert rest(connection) == b""


def test_a_body_that_crawls_is_answered_408(port: int) -> None:
    """A tenth of the floor, without a pause as long as the patience: it is the rate that is too low."""
    with connected(port) as connection:
        connection.sendall(request("/api/sign-in", 100_000))
        connection.settimeout(0.05)
        said, started = b"", time.monotonic()
        while not said and time.monotonic() - started < WAIT_S:
            try:
                connection.sendall(b" " * int(0.05 * FLOOR / 10))
                said = connection.recv(65536)
            except TimeoutError:
                continue
    assert said.startswith(b"HTTP/1.1 408 ")


def test_a_slow_line_is_waited_for(port: int) -> None:
    """Four times the floor, for longer than the patience."""
    body = b'{"email": "nobody@example.org", "password": "wrong password here"' + b" " * 8000 + b"}"
    with connected(port) as connection:
        connection.sendall(request("/api/sign-in", len(body)))
        started = time.monotonic()
        step = int(0.05 * 4 * FLOOR)
        for start in range(0, len(body), step):
            connection.sendall(body[start : start + step])
            time.sleep(0.05)
        assert time.monotonic() - started > 1.5 * PATIENCE_S
        assert connection.recv(65536).startswith(b"HTTP/1.1 401 ")


class Line:
    """A sender with a clock of its own: pieces come after so many seconds, and none makes a test wait."""

    def __init__(self, *pieces: tuple[float, int]) -> None:
        self.now_s = 0.0
        self._pieces = list(pieces)

    async def receive(self) -> Message:
        after_s, size = self._pieces.pop(0)
        self.now_s += after_s
        return {"type": "http.request", "body": b"x" * size, "more_body": bool(self._pieces)}


async def _send(message: Message) -> None:
    del message


def _timed(line: Line, taken_s: float = 0.0, **limits: float) -> int:
    """Bytes that an application reads through the limit, which itself takes its time for each piece."""
    import asyncio

    async def app(_: Any, receive: Any, __: Any) -> None:
        nonlocal read
        more = True
        while more:
            message = await receive()
            read += len(message["body"])
            more = message["more_body"]
            line.now_s += taken_s

    read = 0
    asyncio.run(TimedBodies(app, clock=lambda: line.now_s, **limits)({"type": "http"}, line.receive, _send))
    return read


def test_home_lines_send_a_recording_of_any_length() -> None:
    """64 kB/s for an hour, with pauses of ten seconds, by the limits that the service has."""
    limits = {
        "floor_bytes_per_s": Settings.model_fields["request_floor_bytes_per_s"].default,
        "patience_s": Settings.model_fields["request_patience_seconds"].default,
    }
    minute = [(1.0, 64_000)] * 50 + [(10.0, 0)]
    assert _timed(Line(*minute * 60), **limits) == 60 * 50 * 64_000


def test_what_the_service_takes_is_not_counted() -> None:
    assert (
        _timed(Line((0.1, 10), (0.1, 10), (0.1, 10)), taken_s=1000.0, floor_bytes_per_s=100, patience_s=5)
        == 30
    )


def test_speed_of_before_buys_no_silence() -> None:
    # A gigabyte at once is not an allowance of days: the next wait has the patience, and no more.
    line = Line((0.1, 10_000_000), (4.9, 1), (4.9, 1), (0.2, 1), (0.1, 1))
    with pytest.raises(BodyTooSlow):
        _timed(line, floor_bytes_per_s=100, patience_s=5)


def test_an_upload_whose_sender_goes_away_is_no_error(
    port: int, sign_in: Any, world: World, settings: Settings, caplog: pytest.LogCaptureFixture
) -> None:
    client: ServiceClient = sign_in("therapist")
    cookie = "; ".join(f"{name}={value}" for name, value in client.cookies.items())
    head = request("/api/uploads", 10_000_000, "multipart/form-data; boundary=b").replace(
        b"\r\n\r\n",
        f"\r\nCookie: {cookie}\r\nX-CSRF-Token: {client.headers['X-CSRF-Token']}\r\n\r\n".encode(),
    )
    part = b'--b\r\nContent-Disposition: form-data; name="declaration"\r\n\r\n'
    with caplog.at_level(logging.INFO):
        with connected(port) as connection:
            connection.sendall(head + part)
            time.sleep(0.1)
        deadline = time.monotonic() + WAIT_S
        while not (said := [r for r in caplog.records if "went away" in r.message]):
            assert time.monotonic() < deadline, caplog.text
            time.sleep(0.02)
        while not (lines := [r.message for r in caplog.records if "/api/uploads 499" in r.message]):
            assert time.monotonic() < deadline, caplog.text
            time.sleep(0.02)
    assert [record.levelno for record in said] == [logging.INFO]
    assert len(lines) == 1
    assert not [record for record in caplog.records if record.levelno >= logging.WARNING]
    assert not list(Path(settings.data_dir).rglob("*.part")), "nothing of it stays"
