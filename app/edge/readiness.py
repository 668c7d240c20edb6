"""Ready: whether what is sent now can be stored. Apart from alive: whether the process answers.

A watcher asks once a second whether the lock of the database is held, whether a change can be committed, whether there
is room on the disks, and whether the group commit gets rid of what it holds. Each has a few seconds; what does not
answer in that time is not well. Nothing here changes what the service does: gateways keep what is not acknowledged, and
when the cause is gone the next look says so.
"""

import asyncio
import contextlib
import logging
import shutil
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any, Final

from fastapi import APIRouter, Request
from fastapi.responses import JSONResponse
from sqlalchemy import Engine, make_url
from sqlalchemy.exc import SQLAlchemyError

from app.database.engine import try_to_write
from app.database.writer_lock import WriterLock
from app.logs import safe_words
from app.schemas import Schema
from app.services import services_of
from app.settings import Settings

logger = logging.getLogger("telemotion.readiness")

EVERY_S: Final = 1.0
PATIENCE_S: Final = 2.5
_WRITE_PATIENCE_MS: Final = 2000
LEAST_FREE_BYTES: Final = 32 << 20
"""Below it a disk counts as full: SQLite needs room beside what it stores."""

Check = Callable[[], str | None]
"""Returns in words what is wrong, None when nothing is; may block."""


class ReadyOut(Schema):
    """Whether what is sent now can be stored."""

    status: str
    """`ready` or `not_ready`."""
    reasons: dict[str, str]
    """By part (`lock`, `database`, `disk`, `group_commit`, `service`): what is wrong, in words."""


class Readiness:
    """Looks at the parts that storing needs, again and again."""

    def __init__(
        self, checks: Mapping[str, Check], *, every_s: float = EVERY_S, patience_s: float = PATIENCE_S
    ):
        self._checks = dict(checks)
        self._every_s = every_s
        self._patience_s = patience_s
        self._reasons: dict[str, str] = {"service": "The service is starting."}
        self._running: dict[str, asyncio.Future[str | None]] = {}
        # Of its own: when the database hangs, the threads of everybody else hang too.
        self._threads = ThreadPoolExecutor(len(self._checks), thread_name_prefix="readiness")
        self._task: asyncio.Task[None] | None = None

    @property
    def reasons(self) -> dict[str, str]:
        """What is wrong now, by part; empty when ready."""
        return dict(self._reasons)

    async def start(self) -> None:
        """Look once, then go on looking."""
        await self._look()
        self._task = asyncio.create_task(self._run(), name="readiness")

    async def stop(self) -> None:
        """Look no more; not ready from now on."""
        if self._task is not None:
            self._task.cancel()
            await asyncio.gather(self._task, return_exceptions=True)
        await asyncio.gather(*self._running.values(), return_exceptions=True)
        self._threads.shutdown(wait=False)
        self._reasons = {"service": "The service is stopping."}

    async def _run(self) -> None:
        while True:
            await asyncio.sleep(self._every_s)
            try:
                await self._look()
            except Exception:
                logger.exception("readiness could not be looked at")

    async def _look(self) -> None:
        answers = await asyncio.gather(*(self._ask(name) for name in self._checks))
        found = {name: answer for name, answer in zip(self._checks, answers, strict=True) if answer}
        for name in found.keys() - self._reasons.keys():
            logger.error("not ready (%s): %s", name, found[name])
        for name in self._reasons.keys() - found.keys() - {"service"}:
            logger.warning("well again (%s)", name)
        self._reasons = found

    async def _ask(self, name: str) -> str | None:
        running = self._running.get(name)
        # One that hangs is not asked a second time beside itself.
        if running is None:
            loop = asyncio.get_running_loop()
            running = self._running[name] = loop.run_in_executor(self._threads, self._checks[name])
        try:
            answer = await asyncio.wait_for(asyncio.shield(running), self._patience_s)
        except TimeoutError:
            return f"No answer within {self._patience_s:.1f} s."
        except Exception as error:
            answer = f"{type(error).__name__} {safe_words(error)}".strip()
        self._running.pop(name, None)
        return answer


def storing_checks(settings: Settings, engine: Engine, lock: WriterLock, recorder: Any) -> dict[str, Check]:
    """Return what storing needs; `recorder` is a `GroupCommitWriter`."""
    return {
        "lock": lock.trouble,
        "database": partial(_write, engine),
        "disk": partial(_room, settings),
        "group_commit": recorder.trouble,
    }


def _write(engine: Engine) -> str | None:
    try:
        try_to_write(engine, _WRITE_PATIENCE_MS)
    except SQLAlchemyError as error:
        return f"Nothing can be written: {safe_words(error) or type(error).__name__}."
    return None


def _room(settings: Settings) -> str | None:
    folders = {"data": settings.data_dir}
    url = make_url(settings.database_url)
    if url.get_backend_name() == "sqlite":
        folders["database"] = Path(url.database or "").parent
    for name, folder in folders.items():
        with contextlib.suppress(FileNotFoundError):
            free = shutil.disk_usage(folder).free
            if free < LEAST_FREE_BYTES:
                return f"The disk of the {name} folder has {free >> 20} MB left; make room."
    return None


router = APIRouter(prefix="/api", tags=["service"])


@router.get("/ready", responses={503: {"model": ReadyOut, "description": "Nothing can be stored now."}})
async def ready(request: Request) -> ReadyOut:
    """Return whether what is sent now can be stored; 503 with the reasons when not. No sign-in needed."""
    reasons = services_of(request).get(Readiness).reasons
    if not reasons:
        return ReadyOut(status="ready", reasons={})
    body = ReadyOut(status="not_ready", reasons=reasons).model_dump()
    return JSONResponse(body, status_code=503, headers={"Retry-After": "5"})  # type: ignore[return-value]
