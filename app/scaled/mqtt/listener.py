"""Where gateways come in by MQTT: whichever edge the hello reaches has the conversation until its end."""

import asyncio
import contextlib
import logging
from collections.abc import Callable
from typing import Any, Final

import nats
from nats.aio.msg import Msg
from starlette.websockets import WebSocketDisconnect

from app.errors import SignInRequired, Unavailable
from app.ingest.contract import Intake, PacketSink
from app.ingest.websocket import IngestConnection
from app.network.declaration import Declaration
from app.network.messages import HelloMessage
from app.network.mqtt import connection_name, subject
from app.network.pace import pause_s
from app.scaled.broker import Broker
from app.scaled.mqtt.link import MqttLink
from app.settings import Settings
from estimators.sentences import say

logger = logging.getLogger(__name__)

END_S: Final = 3.0
EDGES: Final = "edges"
"""Of those that listen, one hears a hello."""
MOST_HEARD: Final = 100_000
"""Names of connections that said hello, of which each says so once; the oldest are forgotten."""


class OwnSession:
    """Opens a session only for the connection that was made with the same ticket; implements `PacketSink`."""

    def __init__(self, sink: PacketSink, name: str) -> None:
        self._sink, self._name = sink, name

    @property
    def check_every_s(self) -> float:
        """How often the right of a connection is checked again."""
        return self._sink.check_every_s

    async def open(self, hello: HelloMessage, declaration: Declaration) -> Intake:
        """Open the session of the hello's ticket. Raises typed errors."""
        if connection_name(hello.ticket) != self._name:
            raise SignInRequired(say("sign_in.ticket_refused"))
        return await self._sink.open(hello, declaration)


class MqttListener:
    """Serves gateways that come by MQTT.

    Parameters
    ----------
    speed : float
        As of `IngestConnection`.
    most : int
        Connections at once.
    drain_s : float
        In which gateways are sent to other edges at the end, one after the other.
    """

    def __init__(
        self,
        broker: Broker,
        sink: PacketSink,
        speed: float,
        most: int,
        drain_s: float = 0.0,
    ) -> None:
        self._broker, self._sink = broker, sink
        self._speed, self._most, self._drain_s = speed, most, drain_s
        self._served: dict[str, tuple[MqttLink, asyncio.Task[None]]] = {}
        self._heard: dict[str, None] = {}
        self._hellos: Any = None
        self._forget: Callable[[], None] = lambda: None

    @property
    def count(self) -> int:
        """Connections that are served here."""
        return len(self._served)

    async def start(self) -> None:
        """Begin to let gateways in."""
        everybody = subject("*", "hello")
        self._hellos = await self._broker.client.subscribe(everybody, queue=EDGES, cb=self._hello)
        self._forget = self._broker.on_back(self._lost)

    async def stop(self) -> None:
        """Let nobody in, and send gateways to another edge."""
        self._forget()
        with contextlib.suppress(nats.errors.Error):
            await self._hellos.unsubscribe()
        served = list(self._served.values())
        pause = pause_s(len(served), self._drain_s)
        for link, task in served:
            if not task.done():
                link.lose(Unavailable(say("live.stopping"), reason="stopping"))
                await asyncio.sleep(pause)
        if served:
            await asyncio.wait([task for _, task in served], timeout=END_S)
        with contextlib.suppress(nats.errors.Error):
            await self._broker.client.flush(timeout=1)

    def _lost(self) -> None:
        """Have gateways connect again: what they sent while the server was away is lost."""
        for link, _ in self._served.values():
            link.lose(Unavailable(say("scaled.mqtt_lost"), retry_after_s=1, reason="lost"))

    async def _hello(self, message: Msg) -> None:
        name = message.subject.split(".")[1]
        # A ticket is used once, and names one connection: another hello on it can only be refused, again and again.
        if name in self._heard:
            return
        if len(self._served) >= self._most:
            logger.warning("a gateway by MQTT is not let in: there are %d", self._most)
            return
        self._heard[name] = None
        while len(self._heard) > MOST_HEARD:
            del self._heard[next(iter(self._heard))]
        link = MqttLink(self._broker.client, name)
        link.take(message.data)
        self._served[name] = link, asyncio.create_task(self._serve(link), name="mqtt gateway")

    async def _serve(self, link: MqttLink) -> None:
        heard: list[Any] = []
        try:

            async def came(message: Msg) -> None:
                link.take(message.data)

            async def left(_: Msg) -> None:
                link.left()

            # Before its hello is answered a gateway sends nothing.
            client = self._broker.client
            heard.append(await client.subscribe(subject(link.name, "up"), cb=came))
            heard.append(await client.subscribe(subject(link.name, "left"), cb=left))
            await IngestConnection(link, OwnSession(self._sink, link.name), self._speed).serve()
        except WebSocketDisconnect:
            pass
        except Exception:
            logger.exception("a conversation by MQTT ended")
        finally:
            self._served.pop(link.name, None)
            for one in heard:
                with contextlib.suppress(nats.errors.Error):
                    await one.unsubscribe()


def open_listener(settings: Settings, broker: Broker, sink: PacketSink) -> MqttListener:
    """Return the door of an edge; it lets nobody in before its start."""
    most = settings.limit_streams.service
    return MqttListener(broker, sink, settings.stream_speed, most, settings.drain_seconds)
