"""Who comes when the machine is full is sent away with a sentence, instead of everybody's frames coming late.

Packets are taken and published by one thread, that of the event loop; others estimate and store. Measured is what share
of a processor the loop uses, how late it wakes, and how long turns of packets last. A session is admitted while that,
with what sessions will use that are here but do not stream yet, leaves room for one more of the usual cost. Where they
were too many, that number is the most for a while. A session that has streamed before is never sent away: its gateway
holds packets that nobody else has.
"""

import asyncio
import math
import time
from collections import deque
from collections.abc import Callable, Collection
from typing import Final

from app.errors import Unavailable
from app.live.session.runner import LiveSession
from app.live.session.states import OPEN
from estimators.sentences import say

FULL: Final = say("live.full")
TURN_S: Final = 0.25
WINDOW_S: Final = 3.0
"""What was used and how late the thread woke is judged over so long."""
MOST_BUSY: Final = 0.85
"""Share of a processor: queues grow without end at 1, and long before that in bursts."""
LATE_S: Final = 0.25
"""Where half of the turns come later, something else uses the machine up."""
CROWDED_BUSY: Final = 0.3
CROWDED_S: Final = 0.03
"""Where the thread uses more than that share, and in a quarter of the times that it is looked at, it woke later than
that or the longest turn of packets lasted longer, its sessions use the machine up."""
CARRIED: Final = 0.9
REMEMBERED_S: Final = 60.0
"""Where so many streamed that packets came late, only this share of them is let in for so long."""
CROWD: Final = 25
"""Fewer cannot have used the machine up; something else did."""
USUAL_COST: Final = 0.0032
"""Share of a processor for a session of 17 sensors at 100 Hz; what is measured counts as soon as something is."""
LEAST_COST: Final = 0.0015
MOST_COST: Final = 0.012
"""Few sessions cannot be distinguished from whatever else the thread does."""
RETRY_S: Final = 10
QUIET_S: Final = 60.0
"""A session from which nothing came for longer is not expected to stream at any moment."""


def crowd(sessions: Collection[LiveSession]) -> tuple[int, int]:
    """Return how many of these stream, and how many more may at any moment: none that is being closed.

    One that has just been closed has streamed: its share of what was measured is its own.
    """
    now_s = time.monotonic()
    streaming = quiet = 0
    for one in sessions:
        silent_s = now_s - one.last_arrival_s
        if silent_s < WINDOW_S < now_s - one.opened_s:
            streaming += 1
        elif silent_s < QUIET_S and one.state in OPEN:
            quiet += 1
    return streaming, quiet


class Admission:
    """Measures the event loop's thread and decides whether one more session fits; on that thread only."""

    def __init__(self) -> None:
        turns = round(WINDOW_S / TURN_S)
        self.refused = 0
        """Sessions sent away since the start; each time counts."""
        self._turns: deque[tuple[float, float, float]] = deque(maxlen=turns)
        """How long each lasted, what it used of a processor, and how late the loop woke or packets were shown."""
        self._lags: deque[float] = deque(maxlen=10 * turns)
        self._most = math.inf
        """Sessions that the machine carries, as far as it has shown."""
        self._most_until_s = 0.0

    async def run(self, take_longest_s: Callable[[], float]) -> None:
        """Measure until cancelled.

        Parameters
        ----------
        take_longest_s : callable()
            Returns how long the longest turn of packets lasted since it was last asked, seconds.
        """
        loop = asyncio.get_running_loop()
        while True:
            began_s, used_s = loop.time(), time.thread_time()
            await asyncio.sleep(TURN_S)
            lasted_s = loop.time() - began_s
            late_s = max(0.0, lasted_s - TURN_S)
            self.note(lasted_s, time.thread_time() - used_s, late_s, take_longest_s())

    def note(self, lasted_s: float, used_s: float, late_s: float, packets_s: float = 0.0) -> None:
        """Take one turn: how long it lasted, what it used of a processor, how late its end came.

        `packets_s` is how long packets were worked on at most in it.
        """
        self._turns.append((lasted_s, used_s, max(late_s, packets_s)))
        self._lags.append(late_s)

    def take_lags(self) -> list[float]:
        """Return how late the thread woke in the turns since the last call, seconds."""
        lags = list(self._lags)
        self._lags.clear()
        return lags

    @property
    def busy(self) -> float:
        """Share of a processor that the thread used of late."""
        lasted_s = sum(lasted for lasted, _, _ in self._turns)
        return sum(used for _, used, _ in self._turns) / lasted_s if lasted_s > 0.0 else 0.0

    def require_room(self, streaming: int, quiet: int) -> None:
        """Return when one more session fits.

        Parameters
        ----------
        streaming : int
            Sessions whose packets were measured already.
        quiet : int
            Sessions that are here and may stream at any moment.

        Raises
        ------
        Unavailable
            With when to try again.
        """
        busy = self.busy
        cost = min(max(busy / streaming, LEAST_COST), MOST_COST) if streaming else USUAL_COST
        late_s = sorted(late for _, _, late in self._turns)
        turns = len(late_s)
        is_whole, now_s = turns == self._turns.maxlen, time.monotonic()
        is_late = is_whole and late_s[turns // 2] > LATE_S
        if now_s > self._most_until_s:
            self._most = math.inf
        if is_whole and busy > CROWDED_BUSY and late_s[3 * turns // 4] > CROWDED_S:
            is_late = True
            if streaming >= (CROWD if self._most == math.inf else CARRIED * self._most):
                # Far fewer than are known to be carried are late for another reason: those who left are analysed.
                self._most = min(self._most, CARRIED * streaming)
                self._most_until_s = now_s + REMEMBERED_S
        if is_late or streaming + quiet >= self._most or busy + (quiet + 1) * cost > MOST_BUSY:
            self.refused += 1
            raise Unavailable(FULL, retry_after_s=RETRY_S, reason="full")
