"""Watches the beginning of a stream for readings that cannot be right and tells them once each."""

import asyncio
import logging
from collections.abc import Callable, Sequence
from typing import Final

from app.ingest.alignment import joined_chunks
from estimators.calibration import FIRST_SECONDS_S, Finding, check_plausibility, in_words
from estimators.recording import ImuChunk

logger = logging.getLogger(__name__)

CHECK_EVERY_S: Final = 4.0
WATCHED_S: Final = 60.0


class FirstSeconds:
    """Keeps the last seconds of the first minute and checks them every four.

    Rest tells units, the first movement tells axes; so the first minute is looked at, not one moment.

    Parameters
    ----------
    names : sequence of str
        Placements in the order of the chunks.
    tell : callable(findings, time_s)
        Called on the loop's thread with what is new.
    """

    def __init__(self, names: Sequence[str], tell: Callable[[list[Finding], float], None]) -> None:
        self._names, self._tell = tuple(names), tell
        self._kept: list[ImuChunk] = []
        self._known: set[tuple[str, str]] = set()
        self._refused: list[Finding] = []
        self._next_s = CHECK_EVERY_S
        self._checking: asyncio.Task[None] | None = None

    @property
    def hint(self) -> str:
        """What cannot be right, in words for the therapist; empty while nothing was found."""
        return in_words(self._refused, most=2)

    def add(self, chunk: ImuChunk) -> None:
        """Take the newest ticks."""
        if self._next_s > WATCHED_S:
            return
        self._kept.append(chunk)
        end_s = float(chunk.time_s[-1])
        while len(self._kept) > 1 and self._kept[1].time_s[0] < end_s - FIRST_SECONDS_S:
            self._kept.pop(0)
        if end_s - float(self._kept[0].time_s[0]) < CHECK_EVERY_S - 1.0 or end_s < self._next_s:
            return
        if self._checking is not None and not self._checking.done():
            return
        self._next_s = end_s + CHECK_EVERY_S
        self._checking = asyncio.get_running_loop().create_task(self._check(list(self._kept), end_s))
        if self._next_s > WATCHED_S:
            self._kept.clear()

    async def _check(self, pieces: list[ImuChunk], end_s: float) -> None:
        try:
            found = await asyncio.to_thread(self._findings, pieces)
        except Exception:
            # A check that fails must not end the session.
            logger.exception("the first seconds could not be checked")
            return
        new = [finding for finding in found if finding.subject not in self._known]
        self._known |= {finding.subject for finding in new}
        self._refused += [finding for finding in new if finding.severity == "refuse"]
        if new:
            self._tell(new, end_s)

    def _findings(self, pieces: list[ImuChunk]) -> list[Finding]:
        chunk = joined_chunks(pieces)
        # A sensor that sends nothing is told as lost by the health of the link.
        return [finding for finding in check_plausibility(chunk, self._names) if finding.code != "no_data"]


__all__ = ["CHECK_EVERY_S", "WATCHED_S", "FirstSeconds"]
