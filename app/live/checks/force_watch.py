"""Watches what live frames say of the forces of each shoe, and tells changes once."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from estimators.conventions import Side
from estimators.pipelines import FORCE_STATES, Frames, Pipeline
from estimators.sentences import say

TOLD_AFTER_S: Final = 0.5
"""A cell that gives nothing for less is not worth a word."""
_BAD: Final = ("missing", "implausible")


@dataclass(frozen=True)
class ForceChange:
    """Forces of a shoe cannot be used, or can be used again.

    Attributes
    ----------
    state : str
        One of `FORCE_STATES`.
    tick : int
        Since when, of what the frames show.
    """

    side: Side
    state: str
    tick: int

    @property
    def is_lost(self) -> bool:
        """Whether they cannot be used."""
        return self.state in _BAD

    @property
    def text(self) -> str:
        """What happened, in words."""
        if self.state == "missing":
            return say("live.force_lost", side=self.side)
        if self.state == "implausible":
            return say("live.force_implausible", side=self.side)
        return say("live.force_back", side=self.side)


class ForceWatch:
    """Follows the frames of one session.

    Parameters
    ----------
    delay_ticks : int
        By which frames are late.
    """

    def __init__(self, delay_ticks: int) -> None:
        self._delay = delay_ticks
        self._since: dict[Side, tuple[int, int]] = {}
        self._told: dict[Side, bool] = {}

    @classmethod
    def of(cls, pipeline: Pipeline) -> "ForceWatch | None":
        """Return a watch over the frames of a pipeline; None when they say nothing of forces."""
        tells = any(name.endswith("_force_state") for name in pipeline.layout.scalars)
        return cls(pipeline.delay_ticks) if tells else None

    def add(self, frames: Frames) -> list[ForceChange]:
        """Take frames; return what changed for good."""
        found = []
        names = frames.layout.scalars
        sides: tuple[Side, Side] = ("left", "right")
        for side in sides:
            name = f"foot_{side}_force_state"
            if name not in names:
                continue
            states = frames.scalar[:, names.index(name)]
            before = self._since.get(side, (-1, 0))[0]
            if (states == before).all() and (FORCE_STATES[before] in _BAD) == self._told.get(side, False):
                # Nearly always: nothing has changed, and what there is to report was reported.
                continue
            for offset in np.flatnonzero(np.isfinite(states)).tolist():
                tick, state = frames.first_tick + offset - self._delay, int(states[offset])
                last, since = self._since.get(side, (-1, tick))
                if state != last:
                    since = tick
                    self._since[side] = (state, tick)
                is_bad = FORCE_STATES[state] in _BAD
                is_long = (tick - since) * frames.time_step_s >= TOLD_AFTER_S
                if is_bad != self._told.get(side, False) and (is_long or not is_bad):
                    self._told[side] = is_bad
                    found.append(ForceChange(side, FORCE_STATES[state], since))
        return found
