"""Watches a stream for readings that cannot be right, as evidence of its movement gathers; reports each once."""

import asyncio
import logging
import time
from collections.abc import Callable, Sequence
from typing import Final

import numpy as np

from app.errors import Unavailable
from app.live.checks.live_words import in_live_words
from app.live.checks.plausibility import Check, check, packed
from app.live.checks.recent import LATE_TICKS, RecentSamples
from estimators.calibration import Finding, Hemisphere, RecordingCheck, TwoLooks, in_words
from estimators.recording import Float, ImuChunk

logger = logging.getLogger(__name__)

CHECKING_SHARE: Final = 0.05
"""So much of a processor is given to the checks of all sessions of a service together: frames come first."""

FIRST_CHECK_S: Final = 4.0
"""Rest tells units at once or not at all."""
CHECK_EVERY_S: Final = 12.0
"""What is looked at together: some windows of movement. What came before and was not looked at is forgotten."""
NOTHING: Final = -1


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
    """Collects the newest seconds and has them checked together with what is known of those before.

    Rest tells units, movement tells axes and signs; a patient may stand for minutes before moving.

    Parameters
    ----------
    names : sequence of str
        Placements in the order of the chunks.
    tell : callable(findings, time_s)
        Called on the loop's thread with what is new.
    hemisphere : {"north", "south", "unknown"}
        Of the place, see `RecordingCheck`.
    turns : CheckTurns, optional
        Shared between sessions; without, a check comes whenever it is due.
    work : Check
        Runs one check, in a thread; by default there.
    clipped : callable(levels), optional
        Called on the loop's thread after each check with the clip levels found, see `RecordingCheck.clip_levels`;
        those of a sensor that was away meanwhile are infinite.
    clip_levels : ndarray, optional
        Those that the session was watched with before the service was restarted.
    """

    def __init__(
        self,
        names: Sequence[str],
        time_step_s: float,
        tell: Callable[[list[Finding], float], None],
        hemisphere: Hemisphere = "north",
        turns: CheckTurns | None = None,
        work: Check = check,
        clipped: Callable[[Float], None] | None = None,
        clip_levels: Float | None = None,
    ) -> None:
        self._clipped = clipped
        self._turns, self._work = turns, work
        self._names, self._tell = tuple(names), tell
        self._step_s = time_step_s
        self.recent = RecentSamples(round(CHECK_EVERY_S / time_step_s) + LATE_TICKS)
        """The newest ticks; the writer calls `seen` after each write."""
        self._from_tick = NOTHING
        """First tick not looked at yet; it may have left the ring."""
        self._known = packed(RecordingCheck(self._names, hemisphere, clip_levels))
        self._looks = TwoLooks()
        self._gone: set[str] = set()
        self._told: dict[tuple[str, str], Finding] = {}
        self._current: list[Finding] = []
        self._next_s = FIRST_CHECK_S
        self._checking: asyncio.Task[float | None] | None = None

    @property
    def hint(self) -> str:
        """What cannot be right, in words for the therapist; empty while nothing was found."""
        return in_words([found for found in self._current if found.severity == "refuse"], most=2)

    @property
    def refused(self) -> frozenset[str]:
        """Sensors of which something cannot be right."""
        return frozenset(found.sensor for found in self._current if found.severity == "refuse")

    def restart(self, name: str) -> None:
        """Watch a sensor again: it was away, and may have come back as another one."""
        self._gone.add(name)
        self._next_s = 0.0
        self._told = {subject: found for subject, found in self._told.items() if found.sensor != name}
        self._current = [found for found in self._current if found.sensor != name]
        self._from_tick = NOTHING

    def add(self, chunk: ImuChunk) -> None:
        """Take the newest ticks."""
        self.recent.add(chunk)
        self.seen(chunk.first_tick, chunk.first_tick + chunk.tick_count)

    def seen(self, first_tick: int, stop_tick: int) -> None:
        """Note that ticks were written into `recent`, and begin a check when one is due."""
        if self._from_tick == NOTHING:
            self._from_tick = first_tick
        end_s = (stop_tick - 1) * self._step_s
        if end_s < self._next_s:
            return
        from_tick, is_late = self._from_tick, self._from_tick < stop_tick - self.recent.ticks
        if is_late:
            # Where the oldest were there may be samples behind these already.
            from_tick = stop_tick - (self.recent.ticks - LATE_TICKS)
        if end_s - from_tick * self._step_s < FIRST_CHECK_S - 1.0:
            return
        if self._checking is not None and not self._checking.done():
            return
        if self._turns is not None and not self._turns.begin():
            return
        self._next_s = end_s + CHECK_EVERY_S
        self._from_tick = NOTHING
        newest = self.recent.chunk(from_tick, stop_tick, self._step_s)
        self._checking = asyncio.get_running_loop().create_task(self._check(newest, end_s))
        if self._turns is not None:
            turns, began_s = self._turns, time.monotonic()

            def ended(checking: "asyncio.Task[float | None]") -> None:
                # Also when its session ends before it. One that failed costs what it took: it may fail again.
                error = None if checking.cancelled() else checking.exception()
                if error is not None:
                    logger.error("what a check found could not be reported", exc_info=error)
                cost_s = None if checking.cancelled() or error is not None else checking.result()
                turns.end(time.monotonic() - began_s if cost_s is None else cost_s)

            self._checking.add_done_callback(ended)

    async def _check(self, newest: ImuChunk, end_s: float) -> float | None:
        """Check, tell what is new and return what it cost; None when it failed."""
        gone, self._gone = self._gone, set()
        for name in gone:
            self._looks.forget(name)
        try:
            checked = await asyncio.to_thread(self._work, self._known, newest, gone)
        except Unavailable:
            # The service is stopping.
            return None
        except Exception:
            # A check that fails must not end the session.
            logger.exception("the readings could not be checked")
            self._gone |= gone
            return None
        self._known = checked.known
        if self._clipped is not None:
            levels = checked.clip_levels
            levels[[name in self._gone for name in self._names]] = np.inf
            self._clipped(levels)
        reported = self._looks.reported(checked.findings)
        self._current = [in_live_words(finding) for finding in reported if finding.sensor not in self._gone]
        new = [finding for finding in self._current if self._is_new(finding)]
        self._told |= {finding.subject: finding for finding in new}
        if new:
            self._tell(new, end_s)
        return checked.cost_s

    def _is_new(self, finding: Finding) -> bool:
        """At rest a unit is only doubted: that it is wrong, as the movement shows, is new."""
        known = self._told.get(finding.subject)
        return known is None or (known.severity, finding.severity) == ("warning", "refuse")
