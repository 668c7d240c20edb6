"""What can be done with the password of an edge, which faces the internet: nothing but what an edge does."""

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("nats", reason="the extra `scaled` is not installed")

import nats
from nats.aio.client import Client
from nats.js.errors import Error as StreamError
from pydantic import SecretStr

from app.scaled.broker import Broker, connect, inbox_of, stream_name
from app.scaled.mqtt.configuration import issuer_of
from app.scaled.wire import NotSealed, Seal, encode, subject
from app.settings import Settings
from tests.patience import PATIENCE_S
from tests.scaled.mqtt.server import EDGES, running

OURS, THEIRS = EDGES


@dataclass
class Evil:
    """Somebody who has the password of an edge, and no more."""

    settings: Settings
    workers: Broker
    edge: Client
    refused: list[str] = field(default_factory=list)

    async def may_not(self, act: Awaitable[Any]) -> None:
        """Do something, and see that the server refuses it."""
        before = len(self.refused)
        try:
            await act
            await self.edge.flush(timeout=5)
        except (nats.errors.Error, StreamError):
            pass
        async with asyncio.timeout(PATIENCE_S):
            while len(self.refused) == before:  # noqa: ASYNC110
                await asyncio.sleep(0.01)
        assert "permissions violation" in self.refused[-1].lower()


async def written(client: Client) -> None:
    """Return when the server has what was asked before: one ping overtakes it, the second one does not."""
    for _ in range(2):
        await client.flush()


@asynccontextmanager
async def evil(folder: Path) -> AsyncIterator[Evil]:
    async with running(folder) as (settings, workers, _):
        refused: list[str] = []

        async def broken(error: Exception) -> None:
            refused.append(str(error))

        address = settings.nats_edge_url.get_secret_value().split(",")[0]
        client = await nats.connect(address, error_cb=broken, inbox_prefix=inbox_of(OURS))
        try:
            yield Evil(settings, workers, client, refused)
        finally:
            await client.close()


def story(folder: Path, of: Callable[[Evil], Awaitable[None]]) -> None:
    async def run() -> None:
        async with evil(folder) as found:
            await of(found)

    asyncio.run(run())


@pytest.mark.parametrize(
    "heard",
    [
        "telemotion.>",
        ">",
        subject("in", 0),
        subject("ask", "*"),
        subject("here", "*"),
        subject("done", 0),
        subject("to", f"{THEIRS}.>"),
        subject("to", "*.edge"),
        f"{inbox_of(THEIRS)}.>",
        "_INBOX.>",
        "$KV.>",
        "$JS.>",
        "$SYS.REQ.USER.AUTH",
        "gateway.*.down",
    ],
)
def test_an_edge_hears_nothing_that_is_not_its_own(tmp_path: Path, heard: str) -> None:
    async def of(found: Evil) -> None:
        await found.may_not(found.edge.subscribe(heard))

    story(tmp_path, of)


@pytest.mark.parametrize(
    "said",
    [
        subject("to", f"{THEIRS}.edge"),
        subject("to", f"{OURS}.edge"),
        subject("taken", 0),
        subject("done", 0),
        subject("alive", "worker"),
        f"$JS.API.STREAM.PURGE.{stream_name(0)}",
        f"$JS.API.STREAM.DELETE.{stream_name(0)}",
        f"$JS.API.STREAM.MSG.GET.{stream_name(0)}",
        f"$JS.API.CONSUMER.CREATE.{stream_name(0)}",
        "$JS.API.STREAM.NAMES",
        "$KV.telemotion.partition.0",
        "gateway.somebody.up",
        "$MQTT.msgs.gateway.somebody.down",
        "_INBOX.somebody",
    ],
)
def test_an_edge_says_nothing_in_the_name_of_another(tmp_path: Path, said: str) -> None:
    async def of(found: Evil) -> None:
        await found.may_not(found.edge.publish(said, b"forged"))

    story(tmp_path, of)


def test_an_edge_has_what_it_needs(tmp_path: Path) -> None:
    async def of(found: Evil) -> None:
        url = found.settings.nats_edge_url.get_secret_value().split(",")[1]
        settings = found.settings.model_copy(update={"nats_url": SecretStr(url)})
        edge = await connect(settings, "an edge", is_edge=True)
        try:
            heard = asyncio.Event()

            async def hear(message: Any) -> None:
                heard.set()

            await edge.client.subscribe(subject("to", f"{THEIRS}.edge"), cb=hear)
            await written(edge.client)
            name = subject("in", 0)
            stored = await edge.streams.publish(name, edge.seal.close(name, encode([])), timeout=5)
            assert stored.seq == 1
            await found.workers.client.publish(subject("to", f"{THEIRS}.edge"), b"for it")
            async with asyncio.timeout(PATIENCE_S):
                await heard.wait()

            async def answer(message: Any) -> None:
                await message.respond(b"here")

            await found.workers.client.subscribe(subject("ask", 0), cb=answer)
            await written(found.workers.client)
            assert (await edge.client.request(subject("ask", 0), b"", timeout=5)).data == b"here"
        finally:
            await edge.close()

    story(tmp_path, of)


def test_a_message_without_the_mark_of_the_service_is_not_opened() -> None:
    seal, name = Seal(bytes(32)), subject("in", 0)
    sealed = seal.close(name, b"a packet")
    assert seal.open(name, sealed) == b"a packet"
    for forged in (b"", b"a packet", sealed[:-1], sealed + b"x", bytes(16) + b"a packet"):
        with pytest.raises(NotSealed):
            seal.open(name, forged)
    with pytest.raises(NotSealed):
        seal.open(subject("in", 1), sealed)
    with pytest.raises(NotSealed):
        Seal(bytes(31) + b"x").open(name, sealed)


def test_an_edge_cannot_sign_for_who_comes_by_mqtt(tmp_path: Path) -> None:
    """It has the service's secret, and not the workers' password."""

    async def of(found: Evil) -> None:
        workers = found.settings
        address = workers.nats_edge_url.get_secret_value().split(",")[0]
        edge = workers.model_copy(update={"nats_url": SecretStr(address)})
        assert edge.key_for("mqtt-issuer") == workers.key_for("mqtt-issuer")
        assert issuer_of(edge).public != issuer_of(workers).public

    story(tmp_path, of)
