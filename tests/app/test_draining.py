"""An edge that stops sends those who are connected away one after the other, and lets nobody in meanwhile."""

import asyncio
import contextlib
import threading
import time
from collections.abc import Iterator

import httpx
import pytest
import uvicorn
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import PlainTextResponse
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket
from websockets.asyncio.client import connect

from app.commands.serve import DrainingServer
from app.network.lean_sockets import LeanSocket
from app.network.pace import PAUSE_S, pause_s
from tests.ports import free_port

SOCKETS = 5
RESTARTING = 1012


async def hold(websocket: WebSocket) -> None:
    await websocket.accept()
    while (await websocket.receive())["type"] != "websocket.disconnect":
        pass


async def here(_: Request) -> PlainTextResponse:
    return PlainTextResponse("here")


@contextlib.contextmanager
def serving(seconds: float) -> Iterator[tuple[DrainingServer, int]]:
    port, app = free_port(), Starlette(routes=[Route("/", here), WebSocketRoute("/", hold)])
    config = uvicorn.Config(app, port=port, ws=LeanSocket, log_level="error")
    server = DrainingServer(config, seconds)
    thread = threading.Thread(target=server.run)
    thread.start()
    try:
        while not server.started:
            assert thread.is_alive()
            thread.join(0.05)
        yield server, port
    finally:
        server.should_exit = True
        thread.join()


def test_sockets_end_one_after_the_other_and_nobody_comes_in() -> None:
    async def run(server: DrainingServer, port: int) -> list[float]:
        async with httpx.AsyncClient(base_url=f"http://127.0.0.1:{port}", trust_env=False) as client:
            assert (await client.get("/")).text == "here"
            held = [await connect(f"ws://127.0.0.1:{port}", proxy=None) for _ in range(SOCKETS)]
            ended_s: list[float] = []

            async def until_ended(number: int) -> None:
                await held[number].wait_closed()
                ended_s.append(time.monotonic())
                assert held[number].close_code == RESTARTING

            waiting = [asyncio.create_task(until_ended(number)) for number in range(SOCKETS)]
            server.should_exit = True
            await asyncio.wait(waiting, return_when=asyncio.FIRST_COMPLETED)
            with pytest.raises(OSError):
                await connect(f"ws://127.0.0.1:{port}", proxy=None)
            # Whoever is still here is served: a browser has a page open besides its view.
            assert (await client.get("/")).text == "here"
            await asyncio.gather(*waiting)
            return ended_s

    with serving(20.0) as (server, port):
        ended_s = asyncio.run(run(server, port))
    # Each is sent away a pause after the one before; how late it hears of it is the machine's.
    assert ended_s[-1] - ended_s[0] > (SOCKETS - 2) * PAUSE_S


def test_many_go_faster_so_that_all_have_gone_in_time() -> None:
    assert pause_s(0, 20.0) == pause_s(100, 20.0) == PAUSE_S
    assert pause_s(10_000, 20.0) == pytest.approx(0.002)
    assert pause_s(5, 0.0) == 0.0


def test_where_there_is_nobody_to_go_to_all_end_at_once() -> None:
    async def run(server: DrainingServer, port: int) -> None:
        held = [await connect(f"ws://127.0.0.1:{port}", proxy=None) for _ in range(SOCKETS)]
        server.should_exit = True
        await asyncio.gather(*(one.wait_closed() for one in held))
        assert {one.close_code for one in held} == {RESTARTING}

    with serving(0.0) as (server, port):
        asyncio.run(run(server, port))
