"""When a patient sits at rest in the start posture: what the guide takes its start from."""

from collections import deque
from typing import Final

import numpy as np

from estimators.guidance._contract import GuidanceTemplate
from estimators.recording import Float

REST_S: Final = 1.0
STILL_RAD: Final = float(np.radians(4.0))
STILL_M: Final = 0.03
PATIENCE_S: Final = 6.0
"""After so long the start is taken as it is: a tremor is no reason never to begin."""


class RestDetector:
    """Waits for a second of rest."""

    def __init__(self, ready: GuidanceTemplate, tick_s: float) -> None:
        self._steering = [ready.channels.index(name) for name in ready.steering]
        self._limits = np.array([STILL_M if "." in name else STILL_RAD for name in ready.steering])
        self._ticks = max(2, round(REST_S / tick_s))
        self._patience = round(PATIENCE_S / tick_s)
        self.restart()

    def restart(self) -> None:
        """Wait again."""
        self._rows: deque[tuple[Float, Float]] = deque(maxlen=self._ticks)
        self._waited = 0

    def add(self, values: Float, sigma: Float) -> tuple[Float, Float] | None:
        """Take ticks; return the last second of them once the patient has rested so long, None before."""
        self._waited += len(values)
        self._rows.extend(zip(values, sigma, strict=True))
        if len(self._rows) < self._ticks:
            return None
        rest, doubt = (np.stack(one) for one in zip(*self._rows, strict=True))
        seen = rest[:, self._steering]
        known = np.isfinite(seen).all(axis=0)
        if not known.any():
            return None
        is_still = bool((np.ptp(seen[:, known], axis=0) < self._limits[known]).all())
        return (rest, doubt) if is_still or self._waited >= self._patience else None
