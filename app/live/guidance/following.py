"""A guide that is fed with the frames of a session: over gaps, from rest to rest, and on after a pause."""

from dataclasses import replace
from typing import Final

import numpy as np

from app.assessment.design.compiled import Guidance
from app.live.guidance.settling import Settling
from estimators.comparison import trajectory
from estimators.guidance import GuidanceChunk, Guide, signals
from estimators.pipelines import Frames
from estimators.recording import Float

LONGEST_GAP_S: Final = 5.0
"""Ticks that never came are fed as unknown up to here; after a longer break the patient starts from rest again."""
TRACKED_S: Final = 1.0
"""So long everything must be seen again before a pause for want of sight ends by itself."""


class Following:
    """Feeds a `Guide`.

    Parameters
    ----------
    guidance : Guidance
        Its stop rules count no repetitions.
    tick_s : float
    """

    def __init__(self, guidance: Guidance, tick_s: float) -> None:
        self._ready, self._tick_s = guidance.ready, tick_s
        self._guide = Guide(
            guidance.ready,
            tick_s,
            valid_share=guidance.valid_share,
            rules=guidance.rules,
            stops=guidance.stops,
            pace=guidance.pace,
        )
        self._settling = Settling(guidance.ready, tick_s)
        self._is_settled = False
        self._next_tick: int | None = None
        self._tracked_s = 0.0
        self._steering = [guidance.ready.channels.index(name) for name in guidance.ready.steering]
        self._unsure_rad = min(
            (rule.limit for rule in guidance.stops if rule.kind == "unsure"), default=np.inf
        )
        self._seen: tuple[Float, Float] | None = None

    def feed(self, frames: Frames) -> tuple[GuidanceChunk, bool]:
        """Take frames; return what the guide says of the last of them, and whether it counts already."""
        values, sigma = signals(trajectory(frames), self._ready)
        missing = 0 if self._next_tick is None else frames.first_tick - self._next_tick
        self._next_tick = frames.first_tick + frames.tick_count
        if missing > 0:
            if missing * self._tick_s > LONGEST_GAP_S:
                self.leave()
            else:
                gap = np.full((missing, values.shape[1]), np.nan)
                values, sigma = np.concatenate([gap, values]), np.concatenate([gap, sigma])
        self._seen = values, sigma
        chunk = self._guide.feed(values, sigma)
        if not self._is_settled and not self._guide.is_stopped:
            rest = self._settling.add(values, sigma)
            if rest is not None:
                # What the guide took for rest before was only the beginning of the frames.
                self._guide.prompt_rest()
                again = self._guide.feed(*rest)
                self._is_settled = True
                return replace(chunk, stops=(*chunk.stops, *again.stops)), False
        return chunk, self._is_settled

    def is_tracked(self, chunk: GuidanceChunk) -> bool:
        """Say whether what tells the phase has been seen well for a while, up to the last frames."""
        if self._seen is None:
            return False
        values, sigma = (part[:, self._steering] for part in self._seen)
        is_known = np.isfinite(values).any(axis=1)
        is_sure = ~(np.nan_to_num(sigma) > self._unsure_rad).any(axis=1)
        if not (is_known & is_sure).all():
            self._tracked_s = 0.0
        else:
            self._tracked_s += len(values) * self._tick_s
        return self._tracked_s >= TRACKED_S

    def leave(self) -> None:
        """Begin from rest again with the next frames."""
        self._is_settled = False
        self._settling.restart()

    def hold(self) -> None:
        """Count and say nothing until `go_on`, from this tick on."""
        self._guide.stop_for_pain()

    def go_on(self) -> None:
        """Count again, from rest."""
        self._tracked_s = 0.0
        self.leave()
        self._guide.resume()


__all__ = ["Following"]
