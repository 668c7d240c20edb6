"""How fast one gateway may send: a sender that is too fast is read more slowly, so that its neighbours are not.

What is not read waits in the connection and then at the sender; nothing is lost.
"""

import time
from collections.abc import Callable
from typing import Final

BURST_S: Final = 20.0
"""So much of signal is taken at any speed: what a short break of the link held up."""


class Pace:
    """Measures what a gateway sends against time.

    Parameters
    ----------
    speed : float
        Seconds of signal that are taken in a second, over a long time.
    burst_s : float
        Seconds of signal that are taken at once.
    clock : callable
        Monotonic seconds.
    """

    def __init__(
        self, speed: float, burst_s: float = BURST_S, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._speed = speed
        self._burst_s = burst_s
        self._clock = clock
        self._level_s = 0.0
        self._at_s = clock()

    def take(self, signal_s: float) -> float:
        """Count a message and return how long to wait before the next is read, s.

        Parameters
        ----------
        signal_s : float
            Duration of what it holds.
        """
        now = self._clock()
        self._level_s = max(0.0, self._level_s - (now - self._at_s) * self._speed) + signal_s
        self._at_s = now
        return max(0.0, (self._level_s - self._burst_s) / self._speed)


__all__ = ["BURST_S", "Pace"]
