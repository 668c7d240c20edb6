"""Sides of a conversation end together, and a cancellation from outside keeps its name."""

import asyncio

import pytest

from app.network.conversation import until_first_ends


async def forever() -> None:
    await asyncio.sleep(3600)


async def fail() -> None:
    raise ValueError("made to fail")


def test_the_first_that_fails_stops_the_others():
    async def run() -> bool:
        other = asyncio.create_task(forever())
        with pytest.raises(ValueError, match="made to fail"):
            await until_first_ends([asyncio.create_task(fail()), other])
        return other.cancelled()

    assert asyncio.run(run())


def test_a_cancellation_is_told_as_it_was_asked_for():
    async def run() -> tuple[object, ...]:
        async def stubborn() -> None:
            try:
                await forever()
            finally:
                await asyncio.sleep(0.01)

        whole = asyncio.create_task(until_first_ends([asyncio.create_task(stubborn())]))
        await asyncio.sleep(0)
        await asyncio.sleep(0)
        whole.cancel("by the owner")
        await asyncio.sleep(0)
        whole.cancel("by the owner")
        with pytest.raises(asyncio.CancelledError) as caught:
            await whole
        return caught.value.args

    assert asyncio.run(run()) == ("by the owner",)
