"""A source that fires although it should not: in a session without one, or after it was stopped.

Coil states (mask bit 6) in the packets of any session are stored as they came; only a session with a magnetic source
uses them. A coil that is on anywhere else was asked for by nobody, and nobody was asked about implants: it is reported.
"""

from collections.abc import Callable
from typing import Final

import numpy as np

from estimators.recording import Float
from estimators.sentences import say

KIND: Final = "source_unasked"
GRACE_S: Final = 1.0
"""What was fired before the order to stop arrived is no trouble."""
_NO_SOURCE: Final = say("live.stray_source")
_STOPPED: Final = say("live.source_not_stopped")


class UnexpectedEmission:
    """Watches the coil states of one live session.

    Parameters
    ----------
    tell : callable
        Takes kind, session time, placement and words of an event.
    """

    def __init__(self, tell: Callable[[str, float, str, str], None]) -> None:
        self._tell = tell
        self._stopped_s: float | None = None
        self._is_told = False

    def add(
        self,
        first_s: float,
        time_step_s: float,
        coil_state: Float | None,
        placements: tuple[str, ...],
        is_allowed: bool | None,
    ) -> None:
        """Take ticks, reported once, and once more each time a source was stopped.

        Parameters
        ----------
        first_s : float
            Session time of the first tick.
        coil_state : ndarray, shape (S, K), or None
            As the sensors sent it; None where they sent none.
        placements : tuple of str
            Of the S sensors.
        is_allowed : bool or None
            Whether the source may fire; None where the session has none.
        """
        if is_allowed:
            self._stopped_s, self._is_told = None, False
            return
        if is_allowed is False and self._stopped_s is None:
            self._stopped_s = first_s
        if coil_state is None or self._is_told:
            return
        on = np.nan_to_num(coil_state) != 0.0
        if self._stopped_s is not None:
            on[:, first_s + np.arange(on.shape[1]) * time_step_s < self._stopped_s + GRACE_S] = False
        if on.any():
            row, tick = (int(index) for index in np.argwhere(on)[0])
            self._is_told = True
            words = _NO_SOURCE if is_allowed is None else _STOPPED
            self._tell(KIND, first_s + tick * time_step_s, placements[row], words)
