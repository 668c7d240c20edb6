"""Collecting the seconds during which the patient holds the calibration pose."""

import numpy as np

from app.ingest.alignment import joined_chunks
from estimators.recording import ImuChunk, SampleQuality

HOLD_S = 3.0
TIMEOUT_S = 60.0
_TURNING_LIMIT_RADPS = 0.25
"""Root mean square over one chunk; a resting tremor stays below."""
_TILT_LIMIT_MPS2 = 0.8
"""Drift of specific force from the start of the hold, about 5 degrees of slow turning."""


class PoseCollector:
    """Watches aligned chunks until all sensors were still for long enough.

    Parameters
    ----------
    placements : tuple of str
        For the hint.
    time_step_s : float
    """

    def __init__(self, placements: tuple[str, ...], time_step_s: float) -> None:
        self._placements = placements
        self._step_s = time_step_s
        self._held: list[ImuChunk] = []
        self._held_ticks = 0
        self._seen_ticks = 0
        self.hint = "Stand upright, arms hanging, palms to the thighs, and hold still."

    @property
    def progress(self) -> float:
        """From 0 to 1."""
        return min(1.0, self._held_ticks * self._step_s / HOLD_S)

    @property
    def is_timed_out(self) -> bool:
        """Whether the patient was not still for a whole minute."""
        return self._seen_ticks * self._step_s > TIMEOUT_S

    def add(self, chunk: ImuChunk) -> ImuChunk | None:
        """Take the next ticks; return the pose once it was held long enough."""
        self._seen_ticks += chunk.tick_count
        fault = self._fault(chunk)
        if fault:
            self.hint = fault
            self._held, self._held_ticks = [], 0
            return None
        self._held.append(chunk)
        self._held_ticks += chunk.tick_count
        self.hint = "Good, keep still."
        if self.progress < 1.0:
            return None
        return joined_chunks(self._held)

    def _fault(self, chunk: ImuChunk) -> str:
        missing = ((chunk.quality & SampleQuality.MISSING) != 0).any(axis=1)
        if missing.any():
            return f"The sensor {self._names(missing)} sends nothing; check it."
        turning = np.sqrt((chunk.gyroscope_radps**2).sum(axis=2).mean(axis=1))
        if (turning > _TURNING_LIMIT_RADPS).any():
            return f"Hold still: {self._names(turning > _TURNING_LIMIT_RADPS)} moved."
        if self._held:
            start = self._held[0].accelerometer_mps2.mean(axis=1)
            drift = np.linalg.norm(chunk.accelerometer_mps2.mean(axis=1) - start, axis=1)
            if (drift > _TILT_LIMIT_MPS2).any():
                return f"Hold still: {self._names(drift > _TILT_LIMIT_MPS2)} moved."
        return ""

    def _names(self, which: np.ndarray) -> str:
        return ", ".join(self._placements[i].replace("_", " ") for i in np.flatnonzero(which)[:3])
