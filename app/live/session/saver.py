"""Small database writes of one session, in order, without making the event loop wait."""

import asyncio
import logging
from collections import deque
from collections.abc import Callable

from app.errors import TelemotionError

logger = logging.getLogger(__name__)


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
        """Queue a write; a failure is logged, the next ones still run."""
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
                    await asyncio.to_thread(write)
                except TelemotionError as error:
                    logger.error("session %s was not saved: %s", self._session_id, error.message)
                except Exception:
                    logger.exception("session %s was not saved", self._session_id)
        finally:
            self._task = None
