"""Which sessions of a partition are due for a checkpoint."""

import random
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from app.live.session.checkpoint import State, capture
from app.live.session.runner import LiveSession
from estimators.pipelines import SessionSetup

PERIOD_S: Final = 5.0
"""With every third commit of what came, one each two seconds: at most some six seconds are estimated again of a
session that moves."""


@dataclass
class _Mark:
    made_s: float
    setup: SessionSetup
    """With the calibration under which it was made."""


class Marks:
    """Captures sessions whose checkpoint is old, or of another calibration; on the event loop's thread."""

    def __init__(self) -> None:
        self._made: dict[str, _Mark] = {}
        self._captured: dict[str, _Mark] = {}

    def due(self, sessions: Sequence[LiveSession], *, everything: bool = False) -> dict[str, State]:
        """Return where those sessions stand that are due.

        Parameters
        ----------
        sessions : sequence of LiveSession
            Settled. What they have taken is to be stored before what is returned here.
        everything : bool
            Also those whose checkpoint is young: the partition is given back.
        """
        now_s, found = time.monotonic(), {}
        for gone in self._made.keys() - {one.id for one in sessions}:
            del self._made[gone]
        for session in sessions:
            made, setup = self._made.get(session.id), session.pipeline.setup
            is_old = made is None or now_s - made.made_s > PERIOD_S or made.setup is not setup
            if session.has_store_failed or not (is_old or everything):
                continue
            state = capture(session)
            if state is not None:
                found[session.id] = state
                # Sessions that came together are not due together for ever.
                early_s = random.uniform(0.0, PERIOD_S) if made is None else 0.0  # noqa: S311
                self._captured[session.id] = _Mark(now_s - early_s, setup)
        return found

    def stored(self, sessions: Sequence[str]) -> None:
        """Note that the checkpoints of these sessions are stored."""
        for one in sessions:
            self._made[one] = self._captured.pop(one)


__all__ = ["Marks"]
