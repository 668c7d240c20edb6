"""Attempts that are counted in the database, so that many edges share one count; see `rate_limit` for the meaning.

A row has the moment at which its level will be zero: every attempt moves it on by the time that gives one attempt
back. One statement decides and counts, so attempts at many edges at once cannot slip past. Keys are stored as hashes
with a key of the service: addresses and accounts cannot be read from the table, and rows at level zero are deleted.
The clocks of edges must agree to some milliseconds anyway.
"""

import hmac
import time
from collections.abc import Callable
from types import ModuleType
from typing import Any, Final

from sqlalchemy import Engine, case, delete, select, update
from sqlalchemy.dialects import postgresql, sqlite
from sqlalchemy.orm import Session

from app.accounts.credentials.rate_limit import Limit
from app.accounts.models import AttemptCount
from app.database.unit_of_work import read_only, unit_of_work
from app.settings import Settings

CLEANED_EVERY_S: Final = 60.0
_SLACK_S: Final = 1e-3
"""Moments are stored to a microsecond: a level must not be above its capacity by rounding."""


class StoredCounter:
    """Counts attempts per key for all edges; stands for `LeakyCounter`.

    Parameters
    ----------
    settings : Settings
        For the key of the hashes.
    clock : callable
        Seconds since the epoch.
    """

    def __init__(
        self, limit: Limit, engine: Engine, settings: Settings, clock: Callable[[], float] = time.time
    ) -> None:
        self._limit, self._engine, self._clock = limit, engine, clock
        self._key = settings.key_for("attempt-count")
        self._cleaned_at = 0.0

    def take(self, key: str) -> float:
        """Count an attempt, in a transaction of its own; see `LeakyCounter.take`."""
        now, limit = self._clock(), self._limit
        self._clean(now)
        row, step = AttemptCount.__table__.c, limit.recovery_s
        moved = case((row.empty_at > now, row.empty_at), else_=now) + step
        dialect: ModuleType = postgresql if self._engine.dialect.name == "postgresql" else sqlite
        insert: Any = dialect.insert(AttemptCount).values(key_hash=self._hash(key), empty_at=now + step)
        statement = insert.on_conflict_do_update(
            index_elements=["key_hash"],
            set_={"empty_at": moved},
            where=moved <= now + limit.capacity * step + _SLACK_S,
        ).returning(AttemptCount.key_hash)
        with unit_of_work(self._engine) as session:
            if session.execute(statement).one_or_none() is not None:
                return 0.0
        with read_only(self._engine) as session:
            found = select(AttemptCount.empty_at).where(AttemptCount.key_hash == self._hash(key))
            empty_at = session.scalar(found) or now
        # Another edge may have given one back meanwhile: refused all the same, for a moment.
        return max(_SLACK_S, empty_at - now - (limit.capacity - 1) * step)

    def give_back(self, key: str, session: Session | None = None) -> None:
        """Take one counted attempt back; see `LeakyCounter.give_back`.

        Parameters
        ----------
        session : Session, optional
            Writing: given back in its transaction. By default in one of its own.
        """
        statement = (
            update(AttemptCount)
            .where(AttemptCount.key_hash == self._hash(key))
            .values(empty_at=AttemptCount.empty_at - self._limit.recovery_s)
            .execution_options(synchronize_session=False)
        )
        if session is not None:
            session.execute(statement)
            return
        with unit_of_work(self._engine) as own:
            own.execute(statement)

    def _clean(self, now: float) -> None:
        if now < self._cleaned_at + CLEANED_EVERY_S:
            return
        self._cleaned_at = now
        # What another edge counts or deletes at this moment is left to it: nobody waits for anybody.
        old = select(AttemptCount.key_hash).where(AttemptCount.empty_at <= now)
        rows = old.with_for_update(skip_locked=True)
        with unit_of_work(self._engine) as session:
            session.execute(
                delete(AttemptCount)
                .where(AttemptCount.key_hash.in_(rows))
                .execution_options(synchronize_session=False)
            )

    def _hash(self, key: str) -> str:
        return hmac.digest(self._key, key.encode(), "sha256").hex()
