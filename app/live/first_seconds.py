"""Watches a stream for readings that cannot be right, until every sensor has moved a while; tells them once each."""

import asyncio
import logging
import time
from collections import deque
from collections.abc import Callable, Sequence
from typing import Final

from app.ingest.alignment import joined_chunks
from app.live.plausibility import Check, Checked, check
from estimators.calibration import FIRST_SECONDS_S, Finding, Hemisphere, in_words
from estimators.recording import ImuChunk

logger = logging.getLogger(__name__)

CHECKING_SHARE: Final = 0.05
"""So much of a processor is given to the checks of all sessions of a service together: frames come first."""

CHECK_EVERY_S: Final = 4.0
WATCHED_S: Final = 60.0
"""How long a sensor is watched while it moves."""
RESTING_CHECKS: Final = 3
"""Rest tells units at once or not at all."""


class CheckTurns:
    """One check at a time, and after each a pause as long as its cost asks for.

    A check of 17 sensors takes a tenth of a second of a processor; dozens of sessions that begin together would take
    one whole. With many sessions each is checked less often.

    Parameters
    ----------
    share : float
        Of a processor, for all checks together.
    """

    def __init__(self, share: float = CHECKING_SHARE) -> None:
        self._share = share
        self._busy = False
        self._free_at_s = 0.0

    def begin(self) -> bool:
        """Take the turn; false while another has it or the pause lasts."""
        if self._busy or time.monotonic() < self._free_at_s:
            return False
        self._busy = True
        return True

    def end(self, took_s: float) -> None:
        """Give the turn back after a check that took so many seconds of a processor."""
        self._busy = False
        self._free_at_s = time.monotonic() + took_s * (1.0 / self._share - 1.0)


ALL_SESSIONS: Final = CheckTurns()
"""Of this process."""


class FirstSeconds:
    """Keeps the last seconds and checks them every four, until each sensor has moved for a minute.

    Rest tells units, movement tells axes and signs; a patient may stand for minutes before moving.

    Parameters
    ----------
    names : sequence of str
        Placements in the order of the chunks.
    tell : callable(findings, time_s)
        Called on the loop's thread with what is new.
    hemisphere : {"north", "south", "unknown"}
        Of the place, see `check_plausibility`.
    turns : CheckTurns, optional
        Shared between sessions; without, a check comes whenever it is due.
    work : Check
        Runs one check, in a thread; by default there.
    """

    def __init__(
        self,
        names: Sequence[str],
        tell: Callable[[list[Finding], float], None],
        hemisphere: Hemisphere = "north",
        turns: CheckTurns | None = None,
        work: Check = check,
    ) -> None:
        self._turns, self._work = turns, work
        self._names, self._tell, self._hemisphere = tuple(names), tell, hemisphere
        self._kept: deque[ImuChunk] = deque()
        self._is_done = False
        self._known: dict[tuple[str, str], Finding] = {}
        self._moved_s = dict.fromkeys(self._names, 0.0)
        self._resting_checks = 0
        self._next_s = CHECK_EVERY_S
        self._checking: asyncio.Task[float | None] | None = None

    @property
    def hint(self) -> str:
        """What cannot be right, in words for the therapist; empty while nothing was found."""
        return in_words([found for found in self._known.values() if found.severity == "refuse"], most=2)

    @property
    def refused(self) -> frozenset[str]:
        """Sensors of which something cannot be right."""
        return frozenset(found.sensor for found in self._known.values() if found.severity == "refuse")

    def restart(self, name: str) -> None:
        """Watch a sensor anew: it was away, and may have come back as another one."""
        self._moved_s[name], self._is_done = 0.0, False
        self._resting_checks = 0
        self._known = {subject: found for subject, found in self._known.items() if found.sensor != name}
        self._kept.clear()

    def add(self, chunk: ImuChunk) -> None:
        """Take the newest ticks."""
        if self._is_done:
            return
        kept, step_s = self._kept, chunk.time_step_s
        kept.append(chunk)
        end_s = (chunk.first_tick + chunk.tick_count - 1) * step_s
        while len(kept) > 1 and kept[1].first_tick * step_s < end_s - FIRST_SECONDS_S:
            kept.popleft()
        if end_s < self._next_s or end_s - kept[0].first_tick * step_s < CHECK_EVERY_S - 1.0:
            return
        if self._checking is not None and not self._checking.done():
            return
        if self._turns is not None and not self._turns.begin():
            return
        self._next_s = end_s + CHECK_EVERY_S
        self._checking = asyncio.get_running_loop().create_task(self._check(list(self._kept), end_s))
        if self._turns is not None:
            turns, began_s = self._turns, time.monotonic()

            def ended(checking: "asyncio.Task[float | None]") -> None:
                # Also when its session ends before it. One that failed costs what it took: it may fail again.
                cost_s = None if checking.cancelled() else checking.result()
                turns.end(time.monotonic() - began_s if cost_s is None else cost_s)

            self._checking.add_done_callback(ended)

    async def _check(self, pieces: list[ImuChunk], end_s: float) -> float | None:
        """Check, tell what is new and return what it cost; None when it failed."""
        try:
            found, moved, cost_s = await asyncio.to_thread(self._checked, pieces)
        except Exception:
            # A check that fails must not end the session.
            logger.exception("the first seconds could not be checked")
            return None
        for name in moved:
            self._moved_s[name] += CHECK_EVERY_S
        self._resting_checks += not moved
        self._is_done = min(self._moved_s.values()) >= WATCHED_S
        if self._is_done:
            self._kept.clear()
        new = [finding for finding in found if self._is_new(finding)]
        self._known |= {finding.subject: finding for finding in new}
        if new:
            self._tell(new, end_s)
        return cost_s

    def _is_new(self, finding: Finding) -> bool:
        """At rest a unit is only doubted: that it is wrong, told by the movement, is new."""
        known = self._known.get(finding.subject)
        return known is None or (known.severity, finding.severity) == ("warning", "refuse")

    def _checked(self, pieces: list[ImuChunk]) -> Checked:
        chunk = joined_chunks(pieces)
        newest_ticks = round(CHECK_EVERY_S / chunk.time_step_s)
        at_rest = self._resting_checks < RESTING_CHECKS
        return self._work(chunk, self._names, self._hemisphere, newest_ticks, at_rest)


__all__ = ["ALL_SESSIONS", "CHECK_EVERY_S", "WATCHED_S", "CheckTurns", "FirstSeconds"]
