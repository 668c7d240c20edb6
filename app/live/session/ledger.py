"""Which packets of a session are here, which are safe, and which will never come."""

import time
from dataclasses import dataclass, field

from app.network.ranges import SequenceRanges

REPORT_AFTER_S = 0.3
"""A hole younger than this may be mere reordering."""
GIVE_UP_AFTER_S = 3.0
"""How long a connected gateway is asked for a missing packet; what comes later still is stored."""
REPORTED_HOLES = 64
NOT_STORED_AFTER_S = 3.0
"""Packets wait for their commit for a second and a quarter, with very many sessions for two; when none became durable
for so long, none is stored."""


@dataclass
class SequenceLedger:
    """Received, durable and given-up sequences of one session.

    Attributes
    ----------
    received : SequenceRanges
        Handed to the store, durable or on the way.
    durable : SequenceRanges
        Committed.
    given_up : SequenceRanges
        Asked for in vain.
    """

    received: SequenceRanges = field(default_factory=SequenceRanges)
    durable: SequenceRanges = field(default_factory=SequenceRanges)
    given_up: SequenceRanges = field(default_factory=SequenceRanges)
    last_sequence: int | None = None
    """From the goodbye: nothing above will come."""
    _durable_count: int = 0
    _durable_s: float = field(default_factory=lambda: time.monotonic())
    _asked_s: dict[tuple[int, int], float] = field(default_factory=dict)

    @property
    def acknowledged(self) -> int:
        """Everything up to and including this sequence is durable or given up; -1 when nothing is."""
        settled = self.durable.copy()
        settled.update(self.given_up)
        return settled.acknowledged

    @property
    def highest(self) -> int:
        """Highest durable sequence; -1 when none."""
        return self.durable.highest

    def is_being_stored(self) -> bool:
        """Whether what comes becomes durable; call at least once a second."""
        count = len(self.durable)
        if count != self._durable_count or count >= len(self.received):
            self._durable_count, self._durable_s = count, time.monotonic()
        return time.monotonic() - self._durable_s < NOT_STORED_AFTER_S

    def holes(self) -> list[tuple[int, int]]:
        """Return the half-open ranges, not given up, that are missing below the end."""
        known = self.received.copy()
        known.update(self.given_up)
        missing = known.missing()
        if self.last_sequence is not None and known.highest < self.last_sequence:
            missing.append((known.highest + 1, self.last_sequence + 1))
        return missing

    def review(self, elapsed_s: float) -> list[tuple[int, int]]:
        """Ask for holes and give up old ones; call a few times a second while a gateway is connected.

        Parameters
        ----------
        elapsed_s : float
            Since the last review, with the gateway connected.

        Returns
        -------
        list of (start, stop)
            What to ask the gateway for: half-open, lowest first, at most `REPORTED_HOLES`.
        """
        # Only what is asked for grows old: nothing is given up that the gateway was never asked for.
        asked = {
            hole: self._asked_s.get(hole, -elapsed_s) + elapsed_s for hole in self.holes()[:REPORTED_HOLES]
        }
        for hole in [hole for hole, age_s in asked.items() if age_s >= GIVE_UP_AFTER_S]:
            self.given_up.add_range(*hole)
            del asked[hole]
        self._asked_s = asked
        return [hole for hole, age_s in asked.items() if age_s >= REPORT_AFTER_S][:REPORTED_HOLES]

    @property
    def missing_count(self) -> int:
        """Packets that are not here, between the first and the last that should be."""
        ranges = list(self.received)
        if not ranges:
            return 0
        first = 0 if ranges[0][0] <= REPORTED_HOLES else ranges[0][0]
        end = max(self.received.highest, self.last_sequence or 0) + 1
        return end - first - len(self.received)

    @property
    def is_settled(self) -> bool:
        """Whether, after a goodbye, nothing more is to be waited for."""
        return self.last_sequence is not None and self.acknowledged >= self.last_sequence
