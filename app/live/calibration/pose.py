"""Collecting the seconds during which the patient holds the calibration pose."""

import numpy as np
from numpy.typing import NDArray

from estimators.recording import Float, ImuChunk, SampleQuality
from estimators.sentences import say

HOLD_S = 3.0
SETTLE_S = 3.0
"""The orientation filters need so long after their start, or after a gap, before a pose is worth holding."""
TIMEOUT_S = 60.0
BEGIN = say("live.pose")
_TURNING_LIMIT_RADPS = 0.25
"""Root mean square over one chunk; a resting tremor stays below."""
_TILT_LIMIT_MPS2 = 0.8
"""Drift of specific force from the start of the hold, about 5 degrees of slow turning."""


class PoseCollector:
    """Sees every aligned chunk; once begun, waits until all sensors were still for long enough.

    Parameters
    ----------
    placements : tuple of str
        For the hint.
    begin_hint : str
        What to do, shown until the first chunk.
    """

    def __init__(self, placements: tuple[str, ...], time_step_s: float, begin_hint: str = BEGIN) -> None:
        self._placements = placements
        self._begin_hint = begin_hint
        self._step_s = time_step_s
        self._settled_tick = round(SETTLE_S / time_step_s)
        self._held: list[ImuChunk] = []
        self._held_ticks = 0
        self._seen_ticks = 0
        self.is_active = False
        self.hint = ""

    @property
    def progress(self) -> float | None:
        """From 0 to 1; None when no pose is awaited."""
        return min(1.0, self._held_ticks * self._step_s / HOLD_S) if self.is_active else None

    def begin(self) -> None:
        """Begin to look for the pose, or begin again."""
        self._held, self._held_ticks, self._seen_ticks = [], 0, 0
        self.is_active = True
        self.hint = self._begin_hint

    def end(self, hint: str = "") -> None:
        """Look no more."""
        self._held, self._held_ticks = [], 0
        self.is_active = False
        self.hint = hint

    def add(self, chunk: ImuChunk) -> ImuChunk | None:
        """Take the next ticks; return the pose once it was held long enough, and end."""
        missing = (chunk.quality & SampleQuality.MISSING) != 0
        if missing.any():
            self._settled_tick = chunk.first_tick + chunk.tick_count + round(SETTLE_S / self._step_s)
        if not self.is_active:
            return None
        self._seen_ticks += chunk.tick_count
        fault = self._fault(chunk, missing)
        if fault:
            self.hint = fault
            self._held, self._held_ticks = [], 0
            if self._seen_ticks * self._step_s > TIMEOUT_S:
                self.end(say("live.never_still", hold_s=HOLD_S))
            return None
        self._held.append(chunk)
        self._held_ticks += chunk.tick_count
        self.hint = say("live.good_still")
        if self._held_ticks * self._step_s < HOLD_S:
            return None
        pose = ImuChunk.join(self._held)
        self.end()
        return pose

    def _fault(self, chunk: ImuChunk, missing: NDArray[np.bool_]) -> str:
        if missing.all():
            return say("live.gap_hold")
        if missing.any():
            return say("live.sends_nothing", sensors=self._names(np.asarray(missing.any(axis=1))))
        turning: Float = np.sqrt((chunk.gyroscope_radps**2).sum(axis=2).mean(axis=1))
        if (turning > _TURNING_LIMIT_RADPS).any():
            return say("live.moved", sensors=self._names(turning > _TURNING_LIMIT_RADPS))
        if chunk.first_tick < self._settled_tick:
            return say("live.settling")
        if self._held:
            start = self._held[0].accelerometer_mps2.mean(axis=1)
            drift: Float = np.linalg.norm(chunk.accelerometer_mps2.mean(axis=1) - start, axis=1)
            if (drift > _TILT_LIMIT_MPS2).any():
                return say("live.moved", sensors=self._names(drift > _TILT_LIMIT_MPS2))
        return ""

    def _names(self, which: NDArray[np.bool_]) -> list[str]:
        return [self._placements[i] for i in np.flatnonzero(which)[:3]]
