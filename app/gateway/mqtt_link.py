"""A gateway's link by MQTT 3.1.1, with the client of Eclipse Paho: an example of what a gateway in a home does."""

import asyncio
import contextlib
import socket
import time
from typing import Any, Final, Self
from urllib.parse import urlsplit

from app.errors import InvalidInput
from app.network.mqtt import ANSWER_S, DOWN, LIVES_S, SILENCE_S, WINDOW, connection_name, topic

KEEP_ALIVE_S: Final = 15
CONNECT_S: Final = 10.0
PORTS: Final = {"mqtt": 1883, "mqtts": 8883}


class MqttLink:
    """A link by MQTT; see `app.gateway.links.Link`."""

    window: int | None = WINDOW

    def __init__(self, url: str, ticket: str) -> None:
        try:
            from paho.mqtt.client import Client
            from paho.mqtt.enums import CallbackAPIVersion
        except ImportError as error:
            raise InvalidInput("MQTT needs paho-mqtt: pip install 'telemotion[scaled]'") from error
        parts = urlsplit(url)
        self._host, self._port = parts.hostname or "", parts.port or PORTS[parts.scheme]
        self._name = connection_name(ticket)
        self._loop = asyncio.get_running_loop()
        self._answers: asyncio.Queue[str | OSError] = asyncio.Queue()
        self._done: dict[str, asyncio.Future[None]] = {
            name: self._loop.create_future() for name in ("connected", "subscribed")
        }
        self._is_open = True
        self._has_said_hello = self._is_heard = False
        self._sent_s = time.monotonic()
        client: Any = Client(CallbackAPIVersion.VERSION2, client_id=self._name, reconnect_on_failure=False)
        client.username_pw_set("gateway", ticket)
        client.will_set(topic(self._name, "left"), b"")
        if parts.scheme == "mqtts":
            client.tls_set()
        # Paho calls from a thread of its own.
        client.on_connect = lambda _c, _u, _f, code, _p: self._in_loop(self._answered, "connected", code)
        client.on_subscribe = lambda _c, _u, _m, codes, _p: self._in_loop(
            self._answered, "subscribed", codes[0]
        )
        client.on_disconnect = lambda _c, _u, _f, code, _p: self._in_loop(self._ended, str(code))
        client.on_message = lambda _c, _u, message: self._in_loop(self._came, message.payload)
        self._client = client

    @classmethod
    async def open(cls, url: str, ticket: str) -> Self:
        """Connect, and listen to the service."""
        link = cls(url, ticket)
        try:
            await asyncio.to_thread(link._client.connect, link._host, link._port, KEEP_ALIVE_S)
            link._client.loop_start()
            async with asyncio.timeout(CONNECT_S):
                await link._done["connected"]
                link._client.subscribe(topic(link._name, DOWN), 0)
                await link._done["subscribed"]
        except BaseException:
            link.abort()
            await link.close()
            raise
        return link

    def _in_loop(self, call: Any, *given: Any) -> None:
        with contextlib.suppress(RuntimeError):
            # The loop may have ended before the thread.
            self._loop.call_soon_threadsafe(call, *given)

    def _answered(self, name: str, code: Any) -> None:
        future = self._done[name]
        if future.done():
            return
        if code.is_failure:
            future.set_exception(ConnectionRefusedError(f"not {name}: {code}"))
        else:
            future.set_result(None)

    def _ended(self, reason: str) -> None:
        self._is_open = False
        for future in self._done.values():
            if not future.done():
                future.set_exception(ConnectionResetError(reason))
                # Whoever waits for the first never looks at the second.
                future.exception()
        self._answers.put_nowait(ConnectionResetError(reason))

    def _came(self, payload: bytes) -> None:
        self._answers.put_nowait(payload.decode(errors="replace"))

    def _publish(self, kind: Any, message: bytes | str) -> None:
        if not self._is_open or self._client.publish(topic(self._name, kind), message, 0).rc:
            raise ConnectionResetError("the connection by MQTT is broken")
        self._sent_s = time.monotonic()

    async def send(self, message: bytes | str) -> None:
        """Send a message; the first is the hello."""
        self._publish("up" if self._has_said_hello else "hello", message)
        self._has_said_hello = True

    async def receive(self) -> str:
        """Wait for the service's next message; silence means that its edge is gone."""
        try:
            async with asyncio.timeout(SILENCE_S if self._is_heard else ANSWER_S):
                answer = await self._answers.get()
        except TimeoutError as error:
            raise ConnectionResetError("the service says nothing") from error
        if isinstance(answer, OSError):
            raise answer
        self._is_heard = True
        if time.monotonic() - self._sent_s > LIVES_S / 4.0:
            self._publish("up", b"")
        return answer

    def abort(self) -> None:
        """Break it as a radio would: the server then says for us that we have left."""
        self._is_open = False
        found = self._client.socket()
        if found is not None:
            with contextlib.suppress(OSError):
                found.shutdown(socket.SHUT_RDWR)

    async def close(self) -> None:
        """End it in order: a will is not said for who does so."""
        if self._is_open:
            with contextlib.suppress(OSError):
                self._publish("left", b"")
            self._client.disconnect()
        self._is_open = False
        await asyncio.to_thread(self._client.loop_stop)
