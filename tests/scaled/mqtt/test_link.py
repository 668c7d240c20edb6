"""A gateway by MQTT talks as over the WebSocket: hello, packets, acknowledgements, errors, its end."""

import asyncio
import json
from collections.abc import Awaitable, Callable
from typing import Any

import pytest

pytest.importorskip("nats", reason="the extra `scaled` is not installed")

from app.errors import SignInRequired, TelemotionError, Unavailable
from app.ingest.websocket import IngestConnection
from app.network.declaration import Declaration
from app.network.messages import AcknowledgeMessage, HelloMessage
from app.network.mqtt import connection_name
from app.network.packet import Packet
from app.scaled.mqtt import link as links
from app.scaled.mqtt.link import MqttLink
from app.scaled.mqtt.listener import OwnSession
from tests.app.live.live_load import swaying
from tests.patience import PATIENCE_S

TICKET = "a ticket"


class Client:
    """What NATS was given for the gateway."""

    def __init__(self) -> None:
        self.sent: asyncio.Queue[tuple[str, dict[str, Any]]] = asyncio.Queue()

    async def publish(self, subject: str, data: bytes) -> None:
        self.sent.put_nowait((subject, json.loads(data)))


class Session:
    """A session that stores whatever comes; a sink and its only intake."""

    lane = None
    pooled: Any = None
    taken = 0
    is_open = True
    is_finished = False
    session_id = "s"
    check_every_s = 60.0

    def __init__(self) -> None:
        self.packets: list[bytes] = []
        self.last = -1
        self.ended = asyncio.Event()
        self.end_error: TelemotionError = Unavailable("")
        self.is_detached = False

    async def open(self, hello: HelloMessage, declaration: Declaration) -> "Session":
        self.declaration = declaration
        return self

    def receive(self, packet: Packet, arrival_s: float, arrival_ns: int) -> bool:
        self.packets.append(packet.data)
        return True

    def acknowledge(self) -> AcknowledgeMessage:
        count = len(self.packets)
        return AcknowledgeMessage(
            session_id="s", acknowledged=count - 1, highest=count - 1, missing=[], state="ready"
        )

    def goodbye(self, last_sequence: int) -> None:
        self.last = last_sequence

    async def check_right(self) -> None: ...

    async def next_order(self) -> Any:
        await asyncio.Event().wait()

    def end(self, error: TelemotionError) -> None:
        self.end_error = error
        self.ended.set()

    def detach(self) -> None:
        self.is_detached = True


class Talk:
    """A gateway that talks to a session over a link."""

    def __init__(self, lives_s: float = 60.0) -> None:
        _, self.stream = swaying(2.0)
        self.client, self.session = Client(), Session()
        self.link = MqttLink(self.client, connection_name(TICKET), lives_s)  # type: ignore[arg-type]
        sink = OwnSession(self.session, self.link.name)
        self.task = asyncio.create_task(IngestConnection(self.link, sink).serve())

    def hello(self, ticket: str = TICKET) -> None:
        self.link.take(self.stream.hello(ticket).model_dump_json(exclude_none=True).encode())

    async def said(self, kind: str) -> dict[str, Any]:
        """Return the next message of a type."""
        async with asyncio.timeout(PATIENCE_S):
            while True:
                subject, message = await self.client.sent.get()
                assert subject == f"gateway.{self.link.name}.down"
                if message["type"] == kind:
                    return message

    async def over(self) -> None:
        async with asyncio.timeout(PATIENCE_S):
            await self.task


def story(of: Callable[[], Awaitable[None]]) -> None:
    asyncio.run(of())  # type: ignore[arg-type]


def test_packets_are_taken_acknowledged_and_refused_as_over_the_socket() -> None:
    async def of() -> None:
        talk = Talk()
        talk.hello()
        assert (await talk.said("acknowledge"))["acknowledged"] == -1
        sent = [one.data for one in talk.stream.deliveries(talk.stream.plan())][:3]
        for data in (sent[0], b"", sent[1], b"{no json", sent[2][:40], sent[2]):
            talk.link.take(data)
        assert (await talk.said("error"))["details"]["reason"] == "json"
        assert (await talk.said("error"))["details"]["reason"] == "truncated"
        while (await talk.said("acknowledge"))["acknowledged"] < 2:
            pass
        assert talk.session.packets == sent
        talk.link.take(b'{"type": "goodbye", "last_sequence": 2}')
        talk.link.left()
        await talk.over()
        assert talk.session.last == 2
        assert talk.session.is_detached

    story(of)


def test_a_hello_with_a_ticket_of_another_connection_opens_nothing() -> None:
    async def of() -> None:
        talk = Talk()
        talk.hello("another ticket")
        refused = await talk.said("error")
        assert (refused["code"], refused["closing"]) == (SignInRequired.code, True)
        await talk.over()
        assert not hasattr(talk.session, "declaration")

    story(of)


def test_who_sends_more_than_is_read_connects_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(links, "WAITING_BYTES", 4000)

    async def of() -> None:
        talk = Talk()
        talk.hello()
        await talk.said("acknowledge")
        for _ in range(5):
            talk.link.take(bytes(1000))
        ended = await talk.said("error")
        assert (ended["details"]["reason"], ended["closing"]) == ("lost", True)
        await talk.over()
        assert talk.session.packets == []
        assert talk.session.is_detached

    story(of)


def test_a_gateway_that_says_nothing_any_more_has_gone() -> None:
    async def of() -> None:
        talk = Talk(lives_s=0.2)
        talk.hello()
        await talk.said("acknowledge")
        await talk.over()
        assert talk.session.is_detached

    story(of)


def test_a_session_that_ends_says_why() -> None:
    async def of() -> None:
        talk = Talk()
        talk.hello()
        await talk.said("acknowledge")
        talk.session.end(Unavailable("over", reason="stopping"))
        ended = await talk.said("error")
        assert (ended["details"]["reason"], ended["closing"]) == ("stopping", True)
        await talk.over()

    story(of)
