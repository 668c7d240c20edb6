"""The relay between a browser and viser: what viser draws passes, from the browser only the camera's pose.

viser itself knows no users. It listens on loopback and answers only to its scene's secret (`app.viewer.guard`); this is
the only way to it, and it stays open only while
the person is signed in and has the right to the patient.
"""

import asyncio
import contextlib
from collections import deque
from collections.abc import Coroutine
from typing import Any, Final

from starlette.websockets import WebSocket, WebSocketDisconnect, WebSocketState
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidHandshake
from websockets.typing import Subprotocol

from app.accounts.dependencies import websocket_subject
from app.accounts.subject import Subject
from app.errors import InvalidInput, Unavailable
from app.viewer import wire
from app.viewer.camera import Camera
from app.viewer.service import View, Viewer
from app.viewer.stage import Stage
from estimators.sentences import say

_INJECTED_KEPT: Final = 32
_BATCHES_TO_GREETING: Final = 400
_CONNECT_TIMEOUT_S: Final = 5.0
_CAMERAS_A_SECOND: Final = 60


async def relay(websocket: WebSocket, viewer: Viewer, subject: Subject, view_id: str) -> None:
    """Serve one page of a view until it leaves, loses its right, or the view ends.

    Parameters
    ----------
    websocket : WebSocket
        Not yet accepted.
    subject : Subject
        Who opened it.

    Raises
    ------
    TelemotionError
        Not signed in any more, from another origin, no such view, no right (any more), too many scenes. The
        service's handler refuses or closes the socket with it.
    """
    view = await viewer.check(subject, view_id)
    if wire.PROTOCOL not in websocket.scope.get("subprotocols", []):
        raise InvalidInput(say("viewer.protocol", version=wire.PROTOCOL))
    with view.watched():
        await _relay(websocket, viewer, view)


async def _relay(websocket: WebSocket, viewer: Viewer, view: View) -> None:
    stage = await viewer.stage_of(view)
    try:
        upstream = await connect(
            stage.address,
            additional_headers=stage.headers,
            subprotocols=[Subprotocol(wire.PROTOCOL)],
            compression=None,
            max_size=None,
            max_queue=4,
            proxy=None,
            open_timeout=_CONNECT_TIMEOUT_S,
        )
    except (OSError, TimeoutError, InvalidHandshake) as error:
        # Also a scene that was taken down just now, whose port another scene has taken.
        raise Unavailable(say("viewer.not_ready")) from error
    async with upstream:
        await websocket.accept(subprotocol=wire.PROTOCOL)
        stage.enter()
        try:
            await _Connection(websocket, upstream, viewer, view, stage).serve()
        finally:
            stage.leave()


async def keep_checking(websocket: WebSocket, viewer: Viewer, view_id: str) -> None:
    """Raise when the person behind an open socket has signed out, lost the right, or the view has ended."""
    while True:
        await asyncio.sleep(viewer.check_right_every_s)
        await viewer.check(await websocket_subject(websocket), view_id)


async def until_one_ends(*parts: Coroutine[Any, Any, None]) -> None:
    """Run the parts of a socket side by side; when one ends or fails, end the others and raise its error.

    That a socket was closed, on either side, is an end and no error.
    """
    tasks = [asyncio.create_task(part, name="viewer socket") for part in parts]
    try:
        done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        for task in done:
            with contextlib.suppress(WebSocketDisconnect, ConnectionClosed):
                task.result()
    finally:
        for task in tasks:
            task.cancel()
        ended, _ = await asyncio.wait(tasks)
        for task in ended:
            if not task.cancelled():
                task.exception()


class _Connection:
    """One page's connection."""

    def __init__(
        self, websocket: WebSocket, upstream: ClientConnection, viewer: Viewer, view: View, stage: Stage
    ) -> None:
        self._websocket = websocket
        self._upstream = upstream
        self._viewer = viewer
        self._view = view
        self._stage = stage
        # A page that does not read loses the oldest of these; viser's own messages wait in viser, which
        # keeps only the newest of each kind.
        self._injected: deque[bytes] = deque(maxlen=_INJECTED_KEPT)
        self._has_injected = asyncio.Event()
        self._sending = asyncio.Lock()

    async def serve(self) -> None:
        """Relay in both directions; the first part to end ends all."""
        try:
            await until_one_ends(
                self._down(),
                self._up(),
                self._send_injected(),
                keep_checking(self._websocket, self._viewer, self._view.id),
            )
        finally:
            self._view.pages.discard(self._inject)
        await _close(self._websocket, 1001, "view closed")

    async def _down(self) -> None:
        greeted_after = _BATCHES_TO_GREETING
        async for message in self._upstream:
            if not isinstance(message, bytes):
                continue
            await self._send(message)
            if greeted_after:
                # The look of this view goes after viser's description of the scene, which ends with a mark.
                greeted_after -= 1
                if "ReplayDoneMessage" in wire.types_in(message) or not greeted_after:
                    greeted_after = 0
                    await self._send(wire.pack(self._viewer.greeting(self._view, self._stage)))
                    self._view.pages.add(self._inject)

    async def _up(self) -> None:
        loop = asyncio.get_running_loop()
        window_start, in_window = loop.time(), 0
        is_first = True
        while True:
            received = await self._websocket.receive()
            if received["type"] == "websocket.disconnect":
                return
            admitted = wire.admit(received.get("bytes") or b"")
            if admitted is None:
                continue
            if loop.time() - window_start >= 1.0:
                window_start, in_window = loop.time(), 0
            in_window += 1
            if in_window > _CAMERAS_A_SECOND:
                continue
            self._view.aspect = admitted.aspect
            if is_first and self._view.camera is None:
                # Only now the shape of the picture is known: step back until the person fits.
                self._inject(wire.pack(self._viewer.greeting(self._view, self._stage)))
            elif not is_first:
                self._view.camera = Camera(admitted.position_m, admitted.look_at_m)
            is_first = False
            await self._upstream.send(admitted.data)

    async def _send_injected(self) -> None:
        while True:
            await self._has_injected.wait()
            self._has_injected.clear()
            while self._injected:
                await self._send(self._injected.popleft())

    def _inject(self, packed: bytes) -> None:
        self._injected.append(packed)
        self._has_injected.set()

    async def _send(self, message: bytes) -> None:
        async with self._sending:
            await self._websocket.send_bytes(message)


async def _close(websocket: WebSocket, code: int, reason: str) -> None:
    if (
        websocket.application_state is WebSocketState.CONNECTED
        and websocket.client_state is WebSocketState.CONNECTED
    ):
        with contextlib.suppress(WebSocketDisconnect, RuntimeError):
            await websocket.close(code=code, reason=reason)
