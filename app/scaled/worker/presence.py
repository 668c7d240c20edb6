"""Which workers live: each answers for itself, and whoever nobody answers for is gone.

A lease tells of a death after its length. NATS knows sooner: the connection of a process that was killed ends with it,
and a question to which nobody listens is refused by the server within a millisecond. Each worker asks the one whose
name follows its own, so that the questions grow with the workers, not with their square. A process that is killed gives
back its memory before its connections end, some tenths of a second for a large one: the question that reaches it
meanwhile is not waited for. Who is silent in another way (paused, or cut off from the network) is known by the lease as
before.
"""

import asyncio
import contextlib
import logging
import time
from collections.abc import Awaitable, Callable
from typing import Final

import nats
from nats.aio.msg import Msg
from nats.errors import NoRespondersError
from nats.js.errors import NoKeysError

from app.scaled.broker import Broker
from app.scaled.wire import subject

logger = logging.getLogger(__name__)

PERIOD_S: Final = 0.1
AGAIN_S: Final = 0.05
"""Who did not answer is asked again so soon; a worker that loses its connection makes another at once."""
TIMES: Final = 3
"""A worker is gone when so many questions in a row found nobody."""
ANSWER_S: Final = 0.5
"""So long an answer is awaited where there is only one question."""
WORKER: Final = "worker."
"""Before the name of a worker in the key by which it says that it is there."""


class Presence:
    """Answers for this worker, and asks the next.

    Parameters
    ----------
    worker : str
        Name of this one.
    workers : callable()
        Returns the names of all that are known.
    gone : async callable(name)
        Called when nobody answers for a worker.
    grace_s : float
        After the broker was away others may still be away for so long.
    """

    def __init__(
        self,
        broker: Broker,
        worker: str,
        workers: Callable[[], set[str]],
        gone: Callable[[str], Awaitable[None]],
        grace_s: float,
    ) -> None:
        self._broker, self._worker, self._workers, self._gone = broker, worker, workers, gone
        self._grace_s, self._back_s = grace_s, time.monotonic()
        self._asked, self._unanswered = "", 0
        broker.on_back(self._back)

    async def answer(self) -> None:
        """Begin to answer."""

        async def here(message: Msg) -> None:
            await message.respond(b"")

        await self._broker.client.subscribe(subject("alive", self._worker), cb=here)

    def _back(self) -> None:
        self._back_s, self._unanswered = time.monotonic(), 0

    async def run(self) -> None:
        """Ask again and again."""
        while True:
            await asyncio.sleep(AGAIN_S if self._unanswered else PERIOD_S)
            if self._broker.client.is_connected and time.monotonic() - self._back_s > self._grace_s:
                await self._turn()

    async def _turn(self) -> None:
        others = self._workers() - {self._worker}
        if not others:
            return
        following = min((one for one in others if one > self._worker), default=min(others))
        if following != self._asked:
            self._asked, self._unanswered = following, 0
        try:
            await self._broker.client.request(subject("alive", following), timeout=PERIOD_S)
        except NoRespondersError:
            self._unanswered += 1
        except (nats.errors.Error, OSError, TimeoutError):
            # It is slow, or the broker is: its lease decides.
            self._unanswered = 0
        else:
            self._unanswered = 0
        if self._unanswered >= TIMES:
            self._unanswered = 0
            logger.warning("worker %s is gone", following)
            await self._gone(following)


async def others_of(broker: Broker, worker: str) -> set[str]:
    """Return which other workers are there and answer."""
    try:
        keys = await broker.leases.keys()
    except NoKeysError:
        return set()
    found = set()
    for name in {key.removeprefix(WORKER) for key in keys if key.startswith(WORKER)} - {worker}:
        with contextlib.suppress(nats.errors.Error, OSError, TimeoutError):
            await broker.client.request(subject("alive", name), timeout=ANSWER_S)
            found.add(name)
    return found
