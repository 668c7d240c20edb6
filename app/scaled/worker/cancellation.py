"""Ending tasks for certain."""

import asyncio
from collections.abc import Iterable
from typing import Any, Final

AGAIN_S: Final = 1.5
"""Longer than what a task does at its end."""


async def end(tasks: Iterable[asyncio.Task[Any]], again_s: float = AGAIN_S) -> None:
    """Cancel tasks until they have ended.

    Until Python 3.12 `asyncio.wait_for` loses a cancellation that comes in the same moment as what it waits for.

    Parameters
    ----------
    again_s : float
        A task that goes on for so long is cancelled again.
    """
    pending = {one for one in tasks if not one.done()}
    while pending:
        for one in pending:
            one.cancel()
        _, pending = await asyncio.wait(pending, timeout=again_s)
