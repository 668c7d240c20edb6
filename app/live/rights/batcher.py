"""Gathers what open sockets ask within a short time and asks the database for all of them at once."""

import asyncio
from collections.abc import Awaitable, Callable, Sequence
from types import TracebackType
from typing import Final

from app.live.rights.authorization_checks import AuthorizationCheck

MOST_AT_ONCE: Final = 128
"""Of one question to the database: it may hold the interpreter for a few milliseconds, no longer."""

AskAll = Callable[[Sequence[AuthorizationCheck]], Awaitable[Sequence[Exception | None]]]

_Answer = asyncio.Future[tuple[Exception | None, TracebackType | None]]
"""What a socket is refused with, and where that was raised."""


class AuthorizationBatcher:
    """Where open sockets ask whether they may go on.

    Parameters
    ----------
    ask_all : async callable(questions)
        Returns for each question what it is refused with, or None; may raise when nothing is known of any.
    gather_s : callable
        Returns how long the first of them waits for others, in seconds.
    """

    def __init__(self, ask_all: AskAll, gather_s: Callable[[], float]) -> None:
        self._ask_all, self._gather_s = ask_all, gather_s
        self._waiting: list[tuple[AuthorizationCheck, _Answer]] = []
        self._timer: asyncio.TimerHandle | None = None
        self._asking: set[asyncio.Task[None]] = set()

    async def check(self, question: AuthorizationCheck) -> None:
        """Return when a socket may go on; raise why it may not.

        Raises
        ------
        SignInRequired, NotFound, NotAllowed
            See `app.live.rights.authorization_checks`.
        OperationalError, TimeoutError
            The database did not answer.
        """
        loop = asyncio.get_running_loop()
        answer: _Answer = loop.create_future()
        self._waiting.append((question, answer))
        if len(self._waiting) >= MOST_AT_ONCE:
            self._ask()
        elif self._timer is None:
            self._timer = loop.call_later(self._gather_s(), self._ask)
        refusal, raised_at = await answer
        if refusal is not None:
            # Many sockets may share it: its traceback must not grow with each.
            try:
                raise refusal.with_traceback(raised_at)
            finally:
                # Else each holds the other until the collector comes, which it rarely does.
                del refusal, raised_at

    def end(self) -> None:
        """Answer nobody any more."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        for _, answer in self._waiting:
            answer.cancel()
        self._waiting.clear()

    def _ask(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        # Who has left meanwhile need not be asked for.
        waiting = [(question, answer) for question, answer in self._waiting if not answer.done()]
        self._waiting = []
        if waiting:
            task = asyncio.create_task(self._answer(waiting), name="live rights")
            self._asking.add(task)
            task.add_done_callback(self._asking.discard)

    async def _answer(self, waiting: list[tuple[AuthorizationCheck, _Answer]]) -> None:
        found: Sequence[Exception | None]
        try:
            found = await self._ask_all([question for question, _ in waiting])
        except asyncio.CancelledError:
            for _, answer in waiting:
                answer.cancel()
            raise
        except Exception as error:
            found = [error] * len(waiting)
        # Taken before the first socket raises one that others share.
        refusals = [(one, one.__traceback__ if one is not None else None) for one in found]
        for (_, answer), refusal in zip(waiting, refusals, strict=True):
            if not answer.done():
                answer.set_result(refusal)
        del found, refusals, refusal
