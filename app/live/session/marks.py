"""Which live sessions are due for a checkpoint."""

import random
import time
from dataclasses import dataclass
from weakref import WeakKeyDictionary

from app.live.session.checkpoint import State, capture
from app.live.session.runner import LiveSession
from estimators.pipelines import SessionSetup


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
            # Sessions that came together, as after a restart, are not due together.
            early_s = random.uniform(0.0, self._period_s)  # noqa: S311
            made = self._made[session] = _Mark(now_s - early_s, setup)
        is_old = now_s - made.made_s > self._period_s or made.setup is not setup
        if session.has_store_failed or session.lacks_frames or not (is_old or is_forced):
            return None
        state = capture(session)
        if state is not None:
            self._captured[session] = _Mark(now_s, setup)
        return state

    def stored(self, session: LiveSession) -> None:
        """Note that what `due` returned of a session is stored."""
        self._made[session] = self._captured.pop(session)


__all__ = ["Marks"]
