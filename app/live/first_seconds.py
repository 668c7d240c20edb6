"""Watches a stream for readings that cannot be right, until every sensor has moved a while; tells them once each."""

import asyncio
import logging
import time
from collections.abc import Callable, Sequence
from typing import Final

import numpy as np

from app.ingest.alignment import joined_chunks
from estimators.calibration import FIRST_SECONDS_S, Finding, Hemisphere, check_plausibility, in_words
from estimators.recording import Float, ImuChunk

logger = logging.getLogger(__name__)

CHECKING_SHARE: Final = 0.05
"""So much of the time is given to the checks of all sessions of a process together: frames come first."""

CHECK_EVERY_S: Final = 4.0
WATCHED_S: Final = 60.0
"""How long a sensor is watched while it moves."""
RESTING_CHECKS: Final = 3
"""Rest tells units at once or not at all."""
_MOVED_MPS2: Final = 1.0
"""Spread of the specific force: turned by some six degrees, whatever the gyroscope says."""


class CheckTurns:
    """One check at a time, and after each a pause as long as its cost asks for.

    A check of 17 sensors takes a tenth of a second of a processor; dozens of sessions that begin together would leave
    nothing for the frames. With many sessions each is checked less often.

    Parameters
    ----------
    share : float
        Of the time, for all checks together.
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
        """Give the turn back after a check of so many seconds."""
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
    """

    def __init__(
        self,
        names: Sequence[str],
        tell: Callable[[list[Finding], float], None],
        hemisphere: Hemisphere = "north",
        turns: CheckTurns | None = None,
    ) -> None:
        self._turns = turns
        self._names, self._tell, self._hemisphere = tuple(names), tell, hemisphere
        self._kept: list[ImuChunk] = []
        self._known: dict[tuple[str, str], Finding] = {}
        self._moved_s = dict.fromkeys(self._names, 0.0)
        self._resting_checks = 0
        self._next_s = CHECK_EVERY_S
        self._checking: asyncio.Task[None] | None = None

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
        self._moved_s[name] = 0.0
        self._resting_checks = 0
        self._known = {subject: found for subject, found in self._known.items() if found.sensor != name}
        self._kept.clear()

    def add(self, chunk: ImuChunk) -> None:
        """Take the newest ticks."""
        if min(self._moved_s.values()) >= WATCHED_S:
            return
        self._kept.append(chunk)
        end_s = float(chunk.time_s[-1])
        while len(self._kept) > 1 and self._kept[1].time_s[0] < end_s - FIRST_SECONDS_S:
            self._kept.pop(0)
        if end_s - float(self._kept[0].time_s[0]) < CHECK_EVERY_S - 1.0 or end_s < self._next_s:
            return
        if self._checking is not None and not self._checking.done():
            return
        if self._turns is not None and not self._turns.begin():
            return
        self._next_s = end_s + CHECK_EVERY_S
        self._checking = asyncio.get_running_loop().create_task(self._check(list(self._kept), end_s))
        if self._turns is not None:
            turns, began_s = self._turns, time.monotonic()
            # Also when the check fails or its session ends before it.
            self._checking.add_done_callback(lambda _: turns.end(time.monotonic() - began_s))

    async def _check(self, pieces: list[ImuChunk], end_s: float) -> None:
        try:
            found, moved = await asyncio.to_thread(self._findings, pieces)
        except Exception:
            # A check that fails must not end the session.
            logger.exception("the first seconds could not be checked")
            return
        for name in moved:
            self._moved_s[name] += CHECK_EVERY_S
        self._resting_checks += not moved
        if min(self._moved_s.values()) >= WATCHED_S:
            self._kept.clear()
        new = [finding for finding in found if self._is_new(finding)]
        self._known |= {finding.subject: finding for finding in new}
        if new:
            self._tell(new, end_s)

    def _is_new(self, finding: Finding) -> bool:
        """At rest a unit is only doubted: that it is wrong, told by the movement, is new."""
        known = self._known.get(finding.subject)
        return known is None or (known.severity, finding.severity) == ("warning", "refuse")

    def _findings(self, pieces: list[ImuChunk]) -> tuple[list[Finding], list[str]]:
        chunk = joined_chunks(pieces)
        newest = chunk.ticks(
            max(0, chunk.tick_count - round(CHECK_EVERY_S / chunk.time_step_s)), chunk.tick_count
        )
        moved = [
            name
            for name, force in zip(self._names, newest.accelerometer_mps2, strict=True)
            if _spread(force) > _MOVED_MPS2
        ]
        if not moved and self._resting_checks >= RESTING_CHECKS:
            return [], moved
        # A sensor that sends nothing is told as lost by the health of the link.
        found = check_plausibility(chunk, self._names, hemisphere=self._hemisphere)
        return [finding for finding in found if finding.code != "no_data"], moved


def _spread(force_mps2: Float) -> float:
    """Return how much a sensor's specific force varied, all axes together; 0 where nothing came."""
    sound = force_mps2[np.isfinite(force_mps2).all(axis=1)]
    return float(np.sqrt(sound.var(axis=0).sum())) if len(sound) else 0.0


__all__ = ["ALL_SESSIONS", "CHECK_EVERY_S", "WATCHED_S", "CheckTurns", "FirstSeconds"]
