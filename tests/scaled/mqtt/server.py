"""A NATS server with its listener for MQTT, and strangers who connect to it."""

import asyncio
import contextlib
import subprocess
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

from paho.mqtt import client as paho
from pydantic import SecretStr

from app.network.mqtt import connection_name
from app.scaled.broker import Broker, connect
from app.scaled.mqtt.configuration import configuration
from app.settings import Settings
from tests.patience import PATIENCE_S
from tests.ports import free_port
from tests.scaled.cluster import SERVER

EDGES = ("edge-1", "edge-2")


def launch(folder: Path) -> subprocess.Popen[bytes]:
    """Start a server with the configuration in a folder."""
    with (folder / "nats.log").open("ab") as log:
        return subprocess.Popen([SERVER, "-c", str(folder / "nats.conf")], stdout=log, stderr=log)


@asynccontextmanager
async def running(folder: Path) -> AsyncIterator[tuple[Settings, Broker, int]]:
    """Run a server; gives settings, a connection of the service, and the port for MQTT."""
    port, mqtt_port = free_port(), free_port()
    settings = Settings(
        demo=True,
        nats_url=SecretStr(f"nats://worker:pass-word_1@127.0.0.1:{port}"),
        nats_edge_url=SecretStr(",".join(f"nats://{one}:{one}-word@127.0.0.1:{port}" for one in EDGES)),
        partitions=1,
    )
    text = configuration(
        settings, listen=f"127.0.0.1:{port}", mqtt=f"127.0.0.1:{mqtt_port}", store=str(folder / "nats")
    )
    (folder / "nats.conf").write_text(text)
    process = launch(folder)
    try:
        await until_listening(port, mqtt_port)
        broker = await connect(settings, "test")
        try:
            yield settings, broker, mqtt_port
        finally:
            await broker.close()
    finally:
        process.terminate()
        process.wait(PATIENCE_S)


async def until_listening(*ports: int) -> None:
    """Return when somebody listens on each port."""
    async with asyncio.timeout(PATIENCE_S):
        for port in ports:
            while True:
                with contextlib.suppress(OSError):
                    _, writer = await asyncio.open_connection("127.0.0.1", port)
                    writer.close()
                    await writer.wait_closed()
                    break
                await asyncio.sleep(0.05)


class Stranger:
    """An MQTT client that does what it likes."""

    def __init__(self, port: int, ticket: str, identifier: str | None = None) -> None:
        self.name = connection_name(ticket)
        self._port = port
        self._loop = asyncio.get_running_loop()
        self._codes: asyncio.Queue[Any] = asyncio.Queue()
        self.received: list[tuple[str, bytes]] = []
        self.came = asyncio.Event()
        self.is_ended = asyncio.Event()
        client = paho.Client(
            paho.CallbackAPIVersion.VERSION2,
            client_id=self.name if identifier is None else identifier,
            reconnect_on_failure=False,
        )
        client.username_pw_set("gateway", ticket)
        client.on_connect = lambda _c, _u, _f, code, _p: self._call(self._codes.put_nowait, code)
        client.on_subscribe = lambda _c, _u, _m, codes, _p: self._call(self._codes.put_nowait, codes[0])
        client.on_disconnect = lambda _c, _u, _f, _r, _p: self._call(self.is_ended.set)
        client.on_message = lambda _c, _u, one: self._call(self._took, one.topic, one.payload)
        self.client = client

    def _call(self, call: Any, *given: Any) -> None:
        self._loop.call_soon_threadsafe(call, *given)

    def _took(self, topic: str, payload: bytes) -> None:
        self.received.append((topic, payload))
        self.came.set()

    async def connect(self) -> bool:
        """Return whether it was let in."""
        await asyncio.to_thread(self.client.connect, "127.0.0.1", self._port)
        self.client.loop_start()
        return not (await self._code()).is_failure

    async def subscribe(self, topic: str, quality: int = 0) -> bool:
        """Return whether the server lets it listen."""
        self.client.subscribe(topic, quality)
        return not (await self._code()).is_failure

    async def _code(self) -> Any:
        async with asyncio.timeout(PATIENCE_S):
            return await self._codes.get()

    async def close(self) -> None:
        self.client.disconnect()
        await asyncio.to_thread(self.client.loop_stop)
