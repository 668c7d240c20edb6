"""Patience with a database that does not answer: what is open stays open for a while.

A right that cannot be looked up is not a right that is lost. Sockets that were allowed stay so while the database is
gone, but not for long: an account that lost the right meanwhile must not go on for ever.
"""

import time
from collections.abc import Awaitable
from typing import Final

from sqlalchemy.exc import OperationalError
from sqlalchemy.exc import TimeoutError as PoolTimeout

UNANSWERED_S: Final = 60.0


class GracePeriod:
    """Of one open socket.

    Parameters
    ----------
    unanswered_s : float
        After so long without an answer the error of the database is raised after all.
    """

    def __init__(self, unanswered_s: float = UNANSWERED_S) -> None:
        self._unanswered_s = unanswered_s
        self._answered_s = time.monotonic()

    async def wait(self, check: Awaitable[object]) -> None:
        """Await a check; what it raises passes, but for a database that does not answer."""
        try:
            await check
        except (OperationalError, PoolTimeout):
            if time.monotonic() - self._answered_s > self._unanswered_s:
                raise
        else:
            self._answered_s = time.monotonic()
