"""Which packets of a session are here, which are safe, and which will never come; and what a gateway hears of it."""

import time
from dataclasses import dataclass, field

from app.network.messages import AcknowledgeMessage
from app.network.ranges import SequenceRanges
from app.schemas import SessionState

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
        return self._settled(self.durable).acknowledged

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
        known = self._settled(self.received)
        missing = known.missing()
        if self.last_sequence is not None and known.highest < self.last_sequence:
            missing.append((known.highest + 1, self.last_sequence + 1))
        return missing

    def _settled(self, known: SequenceRanges) -> SequenceRanges:
        """Return what is known or given up; only to be read."""
        if not self.given_up:
            return known
        settled = known.copy()
        settled.update(self.given_up)
        return settled

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
        holes = self.holes()
        if not holes:
            self._asked_s = {}
            return []
        asked = {hole: self._asked_s.get(hole, -elapsed_s) + elapsed_s for hole in holes[:REPORTED_HOLES]}
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


class Acknowledgements:
    """What one connected gateway hears of its packets."""

    def __init__(self, session_id: str) -> None:
        self._session_id = session_id
        self._reviewed_s = time.monotonic()
        self._last: AcknowledgeMessage | None = None

    def next(self, ledger: SequenceLedger, state: SessionState) -> AcknowledgeMessage:
        """Review a ledger; return what the gateway may forget and what it should send again.

        Asked for a few times a second for each session: while nothing has changed it is the same message as before.

        Parameters
        ----------
        state : str
            Of the session.
        """
        now_s, last = time.monotonic(), self._last
        asked = ledger.review(now_s - self._reviewed_s)
        self._reviewed_s = now_s
        acknowledged, highest = ledger.acknowledged, ledger.highest
        missing = [(start, min(stop, highest)) for start, stop in asked if start < highest]
        if (
            last is None
            or (last.acknowledged, last.highest, last.state) != (acknowledged, highest, state)
            or last.missing != missing
        ):
            self._last = last = AcknowledgeMessage(
                session_id=self._session_id,
                acknowledged=acknowledged,
                highest=highest,
                missing=missing,
                state=state,
            )
        return last
