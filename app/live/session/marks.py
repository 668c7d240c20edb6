"""Which live sessions are due for a checkpoint."""

import asyncio
import contextlib
import math
import random
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Final
from weakref import WeakKeyDictionary

from app.errors import Conflict, TelemotionError, Unavailable
from app.live.session.checkpoint import State, capture, pack
from app.live.session.runner import LiveSession
from app.recordings.signals.group_commit import GroupCommitWriter
from estimators.pipelines import SessionSetup

LAST_COMMIT_S: Final = 5.0
"""So long a service that stops waits for the commit of where its sessions stand."""


@dataclass(frozen=True)
class _Mark:
    made_s: float
    setup: SessionSetup
    """With the calibration under which it was made."""


class Marks:
    """Captures sessions whose checkpoint is old, or of another calibration; on the event loop's thread.

    Parameters
    ----------
    period_s : float
        From one checkpoint of a session to the next.
    """

    def __init__(self, period_s: float) -> None:
        self._period_s = period_s
        self._made: WeakKeyDictionary[LiveSession, _Mark] = WeakKeyDictionary()
        self._captured: WeakKeyDictionary[LiveSession, _Mark] = WeakKeyDictionary()

    def due(self, session: LiveSession, *, is_forced: bool = False) -> State | None:
        """Return where a session stands if it is due, and if that can be said.

        Parameters
        ----------
        session : LiveSession
            Settled. What it has taken is to be stored before what is returned here, or with it.
        is_forced : bool
            Also where its checkpoint is young.
        """
        now_s, setup = time.monotonic(), session.pipeline.setup
        made = self._made.get(session)
        if made is None:
            # Sessions that came together, as after a restart, are not due together. One behind whose checkpoint there
            # was more is: a service that is killed again and again before it has one would take longer each time.
            rebuilt_s = session.rebuilt_ticks * session.declaration.time_step_s
            early_s = math.inf if rebuilt_s > self._period_s else random.uniform(0.0, self._period_s)  # noqa: S311
            made = self._made[session] = _Mark(now_s - early_s, setup)
        is_old = now_s - made.made_s > self._period_s or made.setup is not setup
        if session.has_store_failed or session.lacks_frames or not (is_old or is_forced):
            return None
        state = capture(session)
        if state is not None:
            self._captured[session] = _Mark(now_s, setup)
        return state

    def store(self, writer: GroupCommitWriter, session: LiveSession, *, is_last: bool = False) -> None:
        """Give the writer where a session stands, if it is due: committed with what the session gave before."""
        state = self.due(session, is_forced=is_last)
        if state is not None:
            with contextlib.suppress(Conflict, Unavailable):
                writer.add_checkpoint(session.id, partial(pack, state))
            self.stored(session)

    def stored(self, session: LiveSession) -> None:
        """Note that what `due` returned of a session is stored."""
        self._made[session] = self._captured.pop(session)


async def all_stored(writer: GroupCommitWriter, sessions: Sequence[LiveSession]) -> None:
    """Wait until what came last is stored, but not for ever: the writer, closed later, goes on trying."""
    if writer.trouble() is not None:
        return
    flushed = []
    for session in sessions:
        with contextlib.suppress(TelemotionError):
            flushed.append(asyncio.wrap_future(writer.flush(session.id)))
    with contextlib.suppress(TimeoutError):
        async with asyncio.timeout(LAST_COMMIT_S):
            await asyncio.gather(*flushed, return_exceptions=True)
