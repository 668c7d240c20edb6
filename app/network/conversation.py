"""Sides of a conversation over one socket: the first that ends, ends them all."""

import asyncio
from collections.abc import Iterable


async def until_first_ends(tasks: Iterable[asyncio.Task[None]]) -> None:
    """Wait for the first task to end, stop the others, and raise what it raised.

    Parameters
    ----------
    tasks : iterable of asyncio.Task
        Started; none runs on after this returns or raises.
    """
    sides = list(tasks)
    try:
        done, _ = await asyncio.wait(sides, return_when=asyncio.FIRST_COMPLETED)
        for task in done:
            task.result()
    finally:
        for task in sides:
            task.cancel()
        # Not `gather`: cancelled itself, it would pass on the cancellation of a side as if it were its own, and
        # whoever cancelled this conversation could not know it for the one they asked for.
        await asyncio.wait(sides)
        for task in sides:
            if not task.cancelled():
                task.exception()
