"""How fast one gateway may send: a sender that is too fast is read more slowly, so that its neighbours are not.

What is not read waits in the connection and then at the sender; nothing is lost.
"""

import time
from typing import Final

BURST_S: Final = 20.0
"""So much of signal is taken at any speed: what a short break of the link held up."""
PAUSE_S: Final = 0.2
"""Between one who is sent to another edge and the next, where the time is enough: as long as that edge needs for one on
a busy machine."""


class Pace:
    """Measures what a gateway sends against time.

    Parameters
    ----------
    speed : float
        Seconds of signal that are taken in a second, over a long time.
    burst_s : float
        Seconds of signal that are taken at once.
    now_s : float, optional
        Monotonic; by default the present.
    """

    def __init__(self, speed: float, burst_s: float = BURST_S, now_s: float | None = None) -> None:
        self._speed = speed
        self._burst_s = burst_s
        self._level_s = 0.0
        self._at_s = time.monotonic() if now_s is None else now_s

    def take(self, signal_s: float, now_s: float) -> float:
        """Count a message and return how long to wait before the next is read, s.

        Parameters
        ----------
        signal_s : float
            Duration of what it holds.
        now_s : float
            When it came, monotonic.
        """
        left_s = self._level_s - (now_s - self._at_s) * self._speed
        self._level_s = level_s = left_s + signal_s if left_s > 0.0 else signal_s
        self._at_s = now_s
        return (level_s - self._burst_s) / self._speed if level_s > self._burst_s else 0.0


def pause_s(connections: int, seconds: float) -> float:
    """Return how long to wait after each of some connections so that all are ended in time.

    Parameters
    ----------
    seconds : float
        In which all of them are to be ended.
    """
    return min(PAUSE_S, seconds / max(connections, 1))
