"""A stream is read on, also by a process that has no time; other tasks have theirs meanwhile."""

import asyncio
from collections.abc import Awaitable, Callable
from types import SimpleNamespace
from typing import Any

import pytest

from app.scaled.worker import reader
from tests.patience import PATIENCE_S

Hear = Callable[[Any], Awaitable[None]]


class Server:
    """Stands for NATS: has a stream of a few messages, and sends them when it is told."""

    def __init__(self, messages: int, sends: str) -> None:
        self.messages, self.sends = messages, sends
        self.consumers = self.answered = 0
        self.back: list[Callable[[], None]] = []
        self.hear: Hear | None = None
        self.client = self.streams = self
        self.is_connected = False
        self.is_asked = asyncio.Event()

    def new_inbox(self) -> str:
        return "inbox"

    def on_back(self, call: Callable[[], None]) -> Callable[[], None]:
        self.back.append(call)
        return lambda: self.back.remove(call)

    async def subscribe(self, inbox: str, cb: Hear) -> Any:
        self.hear = cb

        async def unsubscribe() -> None:
            pass

        return SimpleNamespace(unsubscribe=unsubscribe)

    async def add_consumer(self, name: str, config: Any) -> Any:
        self.consumers += 1
        self.is_asked.set()
        if self.sends == "never" and self.consumers == 1:
            await asyncio.Event().wait()
        self.answered += 1
        if self.sends != "when asked":
            await self._send()
        return SimpleNamespace(name="consumer")

    async def publish(self, inbox: str) -> None:
        pass

    async def flush(self) -> None:
        await self._send()

    async def _send(self) -> None:
        assert self.hear is not None
        for number in range(1, self.messages + 1):
            sequence = SimpleNamespace(consumer=number, stream=number)
            numbers = SimpleNamespace(sequence=sequence, num_pending=self.messages - number)
            await self.hear(SimpleNamespace(headers=None, reply="reply", metadata=numbers, data=b""))
        self.messages = 0


async def read(server: Server, count: int, each: Callable[[], None] = lambda: None) -> list[int]:
    broker: Any = server
    found: list[int] = []
    stream = reader.read(broker, 0, 0)
    async with asyncio.timeout(PATIENCE_S):
        async for sequence, _, _ in stream:
            found.append(sequence)
            each()
            if len(found) == count:
                break
    await stream.aclose()  # type: ignore[attr-defined]
    return found


def test_a_process_that_stood_still_does_not_take_the_server_for_silent(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(reader, "SILENCE_S", 0.02)
    server = Server(3, "when asked")
    assert asyncio.run(read(server, 3)) == [1, 2, 3]
    assert server.consumers == 1


def test_a_server_that_was_started_again_is_asked_at_once() -> None:
    server = Server(3, "never")

    async def story() -> list[int]:
        reading = asyncio.create_task(read(server, 3))
        await server.is_asked.wait()
        for call in list(server.back):
            call()
        return await reading

    assert asyncio.run(story()) == [1, 2, 3]
    assert (server.consumers, server.answered) == (2, 1)
    assert not server.back


def test_other_tasks_have_their_turn_while_many_messages_wait(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reader, "TURN_S", 0.0)
    turns, at = 0, []

    async def story() -> None:
        async def other() -> None:
            nonlocal turns
            while True:
                turns += 1
                await asyncio.sleep(0)

        task = asyncio.create_task(other())
        await read(Server(50, "at once"), 50, lambda: at.append(turns))
        task.cancel()

    asyncio.run(story())
    assert at[-1] - at[0] > 25, "messages that wait hold everything else up"
