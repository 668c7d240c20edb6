"""Whoever shows a ticket by MQTT gets to the topics of that ticket's connection, and nowhere else."""

import asyncio
import json
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("nats", reason="the extra `scaled` is not installed")
pytest.importorskip("paho.mqtt", reason="the extra `scaled` is not installed")

from app.network.mqtt import connection_name
from app.scaled.broker import Broker
from app.scaled.mqtt.callout import Callout
from app.scaled.mqtt.configuration import issuer_of
from tests.patience import PATIENCE_S
from tests.scaled.mqtt.server import Stranger, running

OURS, THEIRS = "our ticket", "their ticket"


@dataclass
class Place:
    broker: Broker
    port: int
    heard: list[tuple[str, bytes]]
    came: asyncio.Event

    async def until_heard(self, data: bytes) -> None:
        async with asyncio.timeout(PATIENCE_S):
            while data not in [one for _, one in self.heard]:
                self.came.clear()
                await self.came.wait()


@asynccontextmanager
async def place(folder: Path) -> AsyncIterator[Place]:
    async def is_open(ticket: str) -> bool:
        return ticket in {OURS, THEIRS}

    async with running(folder) as (settings, broker, port):
        found = Place(broker, port, [], asyncio.Event())

        async def hear(message: Any) -> None:
            found.heard.append((message.subject, message.data))
            found.came.set()

        # Whatever reaches the account of edges and workers.
        await broker.client.subscribe("gateway.>", cb=hear)
        await broker.client.subscribe("telemotion.>", cb=hear)
        callout = Callout(broker, issuer_of(settings), is_open, 60.0)
        await callout.start()
        # The client's ping overtakes what it has not written yet; the second one does not.
        for _ in range(2):
            await broker.client.flush()
        yield found


def story(folder: Path, of: Callable[[Place], Awaitable[None]]) -> None:
    async def run() -> None:
        async with place(folder) as found:
            await of(found)

    asyncio.run(run())


@pytest.mark.parametrize(
    ("ticket", "identifier"),
    [("no ticket", None), ("", None), (OURS, "another name"), (OURS, connection_name(THEIRS))],
)
def test_who_has_no_ticket_or_takes_another_name_is_not_let_in(
    tmp_path: Path, ticket: str, identifier: str | None
) -> None:
    async def of(found: Place) -> None:
        stranger = Stranger(found.port, ticket, identifier)
        assert not await stranger.connect()
        await stranger.close()

    story(tmp_path, of)


def test_a_gateway_hears_only_what_is_for_it(tmp_path: Path) -> None:
    async def of(found: Place) -> None:
        ours, theirs = Stranger(found.port, OURS), Stranger(found.port, THEIRS)
        assert await ours.connect()
        assert await theirs.connect()
        assert await theirs.subscribe(f"gateway/{theirs.name}/down")
        for topic in (
            f"gateway/{theirs.name}/down",
            f"gateway/{theirs.name}/up",
            f"gateway/{ours.name}/+",
            "gateway/+/down",
            "+/+/+",
            "#",
            "telemotion/#",
            "$SYS/#",
            "$JS/#",
            "$MQTT/#",
            "$MQTT/msgs/#",
            "$MQTT/sub/#",
        ):
            for quality in (0, 1):
                assert not await ours.subscribe(topic, quality), topic
        assert await ours.subscribe(f"gateway/{ours.name}/down")
        await found.broker.client.publish(f"gateway.{theirs.name}.down", b"for them")
        await found.broker.client.publish(f"gateway.{ours.name}.down", b"for us")
        for one in (ours, theirs):
            async with asyncio.timeout(PATIENCE_S):
                await one.came.wait()
        assert ours.received == [(f"gateway/{ours.name}/down", b"for us")]
        assert theirs.received == [(f"gateway/{theirs.name}/down", b"for them")]
        await ours.close()
        await theirs.close()

    story(tmp_path, of)


def test_a_gateway_says_nothing_in_the_name_of_another(tmp_path: Path) -> None:
    async def of(found: Place) -> None:
        ours, theirs = Stranger(found.port, OURS), Stranger(found.port, THEIRS)
        assert await ours.connect()
        assert await theirs.connect()
        assert await theirs.subscribe(f"gateway/{theirs.name}/down", 1)
        for topic in (
            f"gateway/{theirs.name}/up",
            f"gateway/{theirs.name}/hello",
            f"gateway/{theirs.name}/left",
            f"gateway/{theirs.name}/down",
            f"$MQTT/msgs/gateway/{theirs.name}/down",
            "telemotion/in/0",
            "$SYS/REQ/USER/AUTH",
            "$JS/API/STREAM/NAMES",
        ):
            for quality in (0, 1):
                ours.client.publish(topic, b"forged", quality)
        # On the same connection, so behind all that.
        ours.client.publish(f"gateway/{ours.name}/up", b"our own")
        await found.until_heard(b"our own")
        await found.broker.client.publish(f"gateway.{theirs.name}.down", b"true")
        async with asyncio.timeout(PATIENCE_S):
            await theirs.came.wait()
        assert found.heard[:1] == [(f"gateway.{ours.name}.up", b"our own")]
        assert theirs.received == [(f"gateway/{theirs.name}/down", b"true")]
        await ours.close()
        await theirs.close()

    story(tmp_path, of)


def test_nobody_reaches_the_service_without_its_password(tmp_path: Path) -> None:
    async def of(found: Place) -> None:
        address = found.broker.client.connected_url
        assert address is not None
        for user, password in (("", ""), ("telemotion", "wrong"), ("gateway", OURS)):
            reader, writer = await asyncio.open_connection("127.0.0.1", address.port)
            shown = json.dumps({"user": user, "pass": password, "verbose": True})
            writer.write(f"CONNECT {shown}\r\n".encode())
            async with asyncio.timeout(PATIENCE_S):
                answer = await reader.read()
            writer.close()
            await writer.wait_closed()
            assert b"Authorization Violation" in answer
            assert b"+OK" not in answer

    story(tmp_path, of)
