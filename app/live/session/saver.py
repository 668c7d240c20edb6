"""Small database writes of one session, in order, without making the event loop wait."""

import asyncio
import logging
import time
from collections import deque
from collections.abc import Callable
from typing import Final

from sqlalchemy.exc import OperationalError
from sqlalchemy.exc import TimeoutError as PoolTimeout

from app.errors import TelemotionError

logger = logging.getLogger(__name__)

PATIENCE_S: Final = 60.0
"""So long a write waits for a database that does not answer; then it is given up, and said."""
AGAIN_S: Final = 0.5


async def until_written(write: Callable[[], None], patience_s: float = PATIENCE_S) -> None:
    """Write, in a thread; while the database is away, again and again.

    Parameters
    ----------
    write : callable()
        One transaction, so that it can be repeated.

    Raises
    ------
    OperationalError
        The database was away all the time.
    """
    until_s = time.monotonic() + patience_s
    while True:
        try:
            await asyncio.to_thread(write)
            return
        except (OperationalError, PoolTimeout) as error:
            if time.monotonic() > until_s:
                raise
            logger.warning("a write waits for the database: %s", type(error).__name__)
        await asyncio.sleep(AGAIN_S)


class Saver:
    """Runs writes one after the other in threads.

    Parameters
    ----------
    session_id : str
        For the log.
    """

    def __init__(self, session_id: str) -> None:
        self._session_id = session_id
        self._waiting: deque[Callable[[], None]] = deque()
        self._task: asyncio.Task[None] | None = None

    def save(self, write: Callable[[], None]) -> None:
        """Queue a write, one transaction; it waits for a database that is away, and the next ones behind it."""
        self._waiting.append(write)
        if self._task is None:
            self._task = asyncio.create_task(self._write_all(), name="save session")

    async def saved(self) -> None:
        """Wait until every write so far is done."""
        while self._task is not None:
            await asyncio.shield(self._task)

    async def _write_all(self) -> None:
        try:
            while self._waiting:
                write = self._waiting.popleft()
                try:
                    await until_written(write)
                except TelemotionError as error:
                    logger.error("session %s was not saved: %s", self._session_id, error.message)
                except Exception:
                    logger.exception("session %s was not saved", self._session_id)
        finally:
            self._task = None
