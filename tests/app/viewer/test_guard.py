"""The scene's own port, which every program and web page of the machine reaches, gives nothing without its secret."""

import http.client

import pytest
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from app.viewer import guard, wire
from app.viewer.guard import HEADER
from app.viewer.stage import LoopbackServer

ORIGINS = [None, "https://evil.example", "null", "http://127.0.0.1:8000", "http://localhost"]
WRONG = [{}, {HEADER: ""}, {HEADER: "x" * 43}]


@pytest.fixture(scope="module")
def server():
    server = LoopbackServer()
    yield server
    server.stop()


def get(port: int, path: str, headers: dict[str, str]) -> tuple[int, bytes]:
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=10)
    connection.request("GET", path, headers=headers)
    answer = connection.getresponse()
    body = answer.read()
    connection.close()
    return answer.status, body


def handshake(port: int, headers: dict[str, str], origin: str | None) -> str:
    with connect(
        f"ws://127.0.0.1:{port}",
        additional_headers=headers,
        origin=origin,
        subprotocols=[wire.PROTOCOL],
        proxy=None,
        max_size=None,
    ) as socket:
        assert socket.recv(timeout=10)
        return str(socket.subprotocol)


@pytest.mark.parametrize("headers", WRONG)
@pytest.mark.parametrize("origin", ORIGINS)
def test_without_the_secret_nothing_is_given(server, headers, origin):
    sent = headers | ({"Origin": origin} if origin is not None else {})
    for path in ("/", "/index.html", "/../../etc/passwd", "/?secret=1"):
        status, body = get(server.get_port(), path, sent)
        assert (status, len(body) < 100) == (403, True), path
    with pytest.raises(InvalidStatus) as refusal:
        handshake(server.get_port(), headers, origin)
    assert refusal.value.response.status_code == 403


def test_with_the_secret_the_scene_is_there(server):
    assert handshake(server.get_port(), server.secret.headers, None) == wire.PROTOCOL
    assert get(server.get_port(), "/", server.secret.headers)[0] == 200


def test_the_secret_of_another_scene_does_not_help(server):
    other = LoopbackServer()
    try:
        assert get(server.get_port(), "/", other.secret.headers)[0] == 403
    finally:
        other.stop()


def test_a_server_that_cannot_be_guarded_is_none():
    with pytest.raises(guard.Unavailable), guard.guarded(guard.SceneSecret()):
        pass
