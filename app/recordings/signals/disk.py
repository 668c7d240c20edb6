"""How much each clinic has stored, and that it may store so much and no more.

Signals are nearly all of a database; they are added up by clinic, at most every few minutes, off the live path.
"""

import threading
import time
from collections.abc import Callable
from typing import Final

from sqlalchemy import Engine, func, select

from app.database.unit_of_work import read_only
from app.errors import QuotaReached
from app.recordings.models import MotionSession, SignalChunk
from app.sentences import say

COUNTED_EVERY_S: Final = 300.0


class DiskUse:
    """Signals stored by clinic.

    Parameters
    ----------
    engine : Engine
    most_bytes : int
        That a clinic may store.
    clock : callable
        Monotonic seconds.
    """

    def __init__(self, engine: Engine, most_bytes: int, clock: Callable[[], float] = time.monotonic) -> None:
        self._engine = engine
        self._most_bytes = most_bytes
        self._clock = clock
        self._counted: dict[str, tuple[float, int]] = {}
        self._lock = threading.Lock()

    def check(self, clinic_id: str) -> None:
        """Refuse to store more for a clinic that has used up what it may; blocks on the database.

        Parameters
        ----------
        clinic_id : str

        Raises
        ------
        QuotaReached
            With both sizes.
        """
        used = self.used_bytes(clinic_id)
        if used >= self._most_bytes:
            raise QuotaReached(
                say("stored.quota", used_bytes=used, limit_bytes=self._most_bytes),
                used_bytes=used,
                limit_bytes=self._most_bytes,
            )

    def used_bytes(self, clinic_id: str) -> int:
        """Return how much a clinic has stored, as counted some minutes ago at most.

        Parameters
        ----------
        clinic_id : str
        """
        with self._lock:
            at_s, used = self._counted.get(clinic_id, (-COUNTED_EVERY_S, 0))
            # A clinic that is refused has perhaps just deleted something.
            if self._clock() - at_s < COUNTED_EVERY_S and used < self._most_bytes:
                return used
            with read_only(self._engine) as session:
                total = session.scalar(
                    select(func.coalesce(func.sum(func.length(SignalChunk.data)), 0))
                    .join(MotionSession, MotionSession.id == SignalChunk.session_id)
                    .where(MotionSession.clinic_id == clinic_id)
                )
            used = int(total or 0)
            self._counted[clinic_id] = (self._clock(), used)
            return used


__all__ = ["DiskUse"]
