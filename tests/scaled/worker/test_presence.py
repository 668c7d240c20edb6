"""Who nobody answers for is gone; who is slow is not."""

import asyncio
from collections.abc import Awaitable, Callable, Iterator
from types import SimpleNamespace
from typing import Any

import pytest
from nats.errors import NoRespondersError

from app.scaled.worker.presence import PERIOD_S, TIMES, Presence

Question = Callable[[], Awaitable[None]]


async def answered() -> None:
    pass


async def nobody() -> None:
    raise NoRespondersError


async def never() -> None:
    await asyncio.sleep(60.0)


def asked(questions: Iterator[Question]) -> list[str]:
    """Ask until there are no more questions; return who was found to be gone after each."""
    gone: list[str] = []

    async def request(subject: str, timeout: float) -> None:  # noqa: ASYNC109 - as the client of NATS has it
        assert timeout <= PERIOD_S, "the next question is due"
        async with asyncio.timeout(timeout):
            await next(questions)()

    async def go() -> None:
        client: Any = SimpleNamespace(is_connected=True, request=request)
        broker: Any = SimpleNamespace(client=client, on_back=lambda _: None)

        async def note(worker: str) -> None:
            gone.append(worker)

        presence = Presence(broker, "a", lambda: {"a", "b"}, note, grace_s=-1.0)
        running = asyncio.create_task(presence.run())
        await asyncio.wait([running])
        with pytest.raises((StopIteration, RuntimeError)):
            running.result()

    asyncio.run(go())
    return gone


def test_a_worker_is_gone_when_nobody_was_there_for_some_questions_in_a_row() -> None:
    assert asked(iter([nobody] * TIMES)) == ["b"]
    assert asked(iter([nobody] * (TIMES - 1) + [answered] + [nobody] * (TIMES - 1))) == []


def test_a_worker_that_is_slow_is_not_gone() -> None:
    assert asked(iter([nobody] * (TIMES - 1) + [never] + [nobody] * (TIMES - 1))) == []


def test_a_question_that_reached_a_process_as_it_ended_holds_up_no_other() -> None:
    assert asked(iter([never] + [nobody] * TIMES)) == ["b"]
