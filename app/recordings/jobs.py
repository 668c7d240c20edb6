"""Long tasks off the live path: a queue in the database, one worker process of low priority.

A task is a row; its progress is written to the row, and a task that was running when the service died is
taken up again at the next start. A task whose worker process dies twice has failed. One service process at a
time runs the queue of a database.

The worker is a process of its own because estimating an hour of signals must not slow the live sessions; it
ends with its parent, also when that is killed, so that no orphan writes on.
"""

import logging
import multiprocessing
import os
import threading
import time
from collections.abc import Callable, Mapping
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any, Final

from sqlalchemy import CursorResult, Engine, select, update

from app.accounts.subject import Subject
from app.database import engine as engines
from app.database.unit_of_work import read_only, unit_of_work
from app.errors import NotFound, TelemotionError
from app.recordings.models import Job, MotionSession, Result
from app.settings import Settings
from estimators.errors import EstimationError

logger = logging.getLogger(__name__)

POLL_S: Final = 0.5
PROGRESS_S: Final = 0.3
MAX_ATTEMPTS: Final = 2
NICENESS: Final = 10


@dataclass
class JobContext:
    """What a task works with.

    Attributes
    ----------
    subject : Subject
        The service itself, inside the session's clinic: who asked for the task was checked when it was
        queued.
    arguments : dict
        As queued. `attempt` counts from 1.
    """

    engine: Engine
    settings: Settings
    job_id: str
    session_id: str
    subject: Subject
    arguments: dict[str, Any]
    attempt: int = 1
    _last_written_s: float = field(default=0.0, repr=False)

    def progress(self, fraction: float, message: str = "") -> None:
        """Tell how far the task is, 0 to 1; written at most a few times a second.

        Raises
        ------
        NotFound
            The session was deleted meanwhile: stop.
        """
        now_s = time.monotonic()
        if now_s - self._last_written_s < PROGRESS_S:
            return
        self._last_written_s = now_s
        values: dict[str, Any] = {"progress": min(max(fraction, 0.0), 1.0)}
        if message:
            values["message"] = message[:500]
        with unit_of_work(self.engine) as session:
            changed = session.execute(update(Job).where(Job.id == self.job_id).values(**values))
            if isinstance(changed, CursorResult) and changed.rowcount == 0:
                raise NotFound("the session of this task was deleted")

    def remember(self, **arguments: Any) -> None:
        """Keep facts with the task that its next attempt needs."""
        self.arguments = {**self.arguments, **arguments}
        with unit_of_work(self.engine) as session:
            session.execute(update(Job).where(Job.id == self.job_id).values(arguments=self.arguments))


Handler = Callable[[JobContext], str]
"""Does one kind of task; returns what to say when it is done. A further attempt starts anew."""


@dataclass(frozen=True)
class JobDone:
    """Told to subscribers when a task ends."""

    job_id: str
    session_id: str
    kind: str
    status: str
    message: str


def run_job(engine: Engine, settings: Settings, job_id: str, handler: Handler) -> JobDone | None:
    """Run one queued task to its end in this process; None when it is gone or taken.

    A failure is written to the row in words; it never escapes.
    """
    with unit_of_work(engine) as session:
        job = session.get(Job, job_id)
        if job is None or job.status != "queued":
            return None
        clinic_id = session.scalars(
            select(MotionSession.clinic_id).where(MotionSession.id == job.session_id)
        ).one()
        attempt = int(job.arguments.get("attempt", 0)) + 1
        job.arguments = {**job.arguments, "attempt": attempt}
        job.status = "running"
        job.message = ""
        context = JobContext(
            engine, settings, job.id, job.session_id, Subject.system(clinic_id), job.arguments, attempt
        )
        kind = job.kind
    try:
        message = handler(context)
    except (TelemotionError, EstimationError) as error:
        status, message = "failed", str(error)
    except Exception:
        logger.exception("task %s (%s) failed", job_id, kind)
        status, message = (
            "failed",
            "An internal error stopped this task; it was logged. The raw data is kept.",
        )
    else:
        status = "complete"
    _finish(engine, context, kind, status, message)
    return JobDone(job_id, context.session_id, kind, status, message)


def _finish(engine: Engine, context: JobContext, kind: str, status: str, message: str) -> None:
    with unit_of_work(engine) as session:
        job = session.get(Job, context.job_id)
        if job is None:
            return
        job.status, job.message = status, message[:500]
        if status == "complete":
            job.progress = 1.0
            return
        owner = session.get(MotionSession, job.session_id)
        # A session that waits for this task must not wait for ever.
        if owner is not None and owner.state == "closing":
            owner.state, owner.state_reason = "failed", f"Analysis failed: {message}"[:500]
        result_id = context.arguments.get("result_id")
        result = session.get(Result, result_id) if isinstance(result_id, str) else None
        if result is not None and result.status == "running":
            result.status, result.message = "failed", message[:500]


_worker_engines: dict[str, Engine] = {}


def _start_worker() -> None:
    """Lower the worker's priority and tie its life to its parent's."""
    os.nice(NICENESS)
    # A fresh process knows only the tables of this room; foreign keys need those of the others.
    import_module("app.tables")
    parent = multiprocessing.parent_process()

    def leave_with_parent() -> None:
        if parent is not None:
            parent.join()
        os._exit(1)

    threading.Thread(target=leave_with_parent, name="leave-with-parent", daemon=True).start()


def _work(settings: Settings, job_id: str, handler: Handler) -> JobDone | None:
    engine = _worker_engines.get(settings.database_url)
    if engine is None:
        engine = _worker_engines[settings.database_url] = engines.create(settings)
    return run_job(engine, settings, job_id, handler)


class JobRunner:
    """Takes queued tasks one by one and runs them in the worker process.

    Parameters
    ----------
    engine : Engine
    settings : Settings
    handlers : mapping of kind to Handler
        Module-level functions (they are sent to the worker by name).
    """

    def __init__(self, engine: Engine, settings: Settings, handlers: Mapping[str, Handler]) -> None:
        self._engine = engine
        self._settings = settings
        self._handlers = dict(handlers)
        self._subscribers: list[Callable[[JobDone], None]] = []
        self._wake = threading.Event()
        self._stopping = threading.Event()
        self._thread: threading.Thread | None = None
        self._pool: ProcessPoolExecutor | None = None

    def subscribe(self, callback: Callable[[JobDone], None]) -> None:
        """Call `callback` from the runner's thread whenever a task ends."""
        self._subscribers.append(callback)

    def start(self) -> None:
        """Queue again what was running when the service ended, then begin to work."""
        with unit_of_work(self._engine) as session:
            for job in session.scalars(select(Job).where(Job.status == "running")):
                self._interrupted(job)
        self._thread = threading.Thread(target=self._run, name="jobs", daemon=True)
        self._thread.start()

    def wake(self) -> None:
        """Look for tasks now instead of at the next poll."""
        self._wake.set()

    def stop(self) -> None:
        """Stop; a task in progress is ended and taken up again at the next start."""
        self._stopping.set()
        self._wake.set()
        self._end_pool()
        if self._thread is not None:
            self._thread.join(10.0)
            self._thread = None

    def _run(self) -> None:
        while not self._stopping.is_set():
            try:
                done_one = self._run_next()
            except Exception:
                logger.exception("the task queue stumbled; it goes on")
                done_one = False
            if not done_one:
                self._wake.wait(POLL_S)
                self._wake.clear()

    def _run_next(self) -> bool:
        with read_only(self._engine) as session:
            row = session.execute(
                select(Job.id, Job.kind)
                .where(Job.status == "queued")
                .order_by(Job.created_at, Job.id)
                .limit(1)
            ).first()
        if row is None:
            return False
        handler = self._handlers.get(row.kind)
        if handler is None:
            with unit_of_work(self._engine) as session:
                session.execute(
                    update(Job)
                    .where(Job.id == row.id)
                    .values(status="failed", message=f"This service cannot do tasks of the kind {row.kind}.")
                )
            return True
        try:
            if self._pool is None:
                self._pool = ProcessPoolExecutor(
                    1, mp_context=multiprocessing.get_context("spawn"), initializer=_start_worker
                )
            done = self._pool.submit(_work, self._settings, row.id, handler).result()
        except BrokenProcessPool:
            if self._stopping.is_set():
                return False
            self._end_pool()
            logger.error("the worker process of task %s died", row.id)
            done = self._worker_died(row.id)
        if done is not None:
            self._tell(done)
        return True

    def _worker_died(self, job_id: str) -> JobDone | None:
        with unit_of_work(self._engine) as session:
            job = session.get(Job, job_id)
            if job is None:
                return None
            self._interrupted(job)
            if job.status != "failed":
                return None
            return JobDone(job.id, job.session_id, job.kind, job.status, job.message)

    def _interrupted(self, job: Job) -> None:
        """Queue a task again, unless that was tried often enough."""
        if job.is_retryable and int(job.arguments.get("attempt", 0)) < MAX_ATTEMPTS:
            job.status, job.progress, job.message = "queued", 0.0, "Interrupted; it starts again."
        elif job.status != "queued":
            job.status = "failed"
            job.message = "The task was interrupted and is not tried again; the raw data is kept."

    def _tell(self, done: JobDone) -> None:
        for callback in self._subscribers:
            try:
                callback(done)
            except Exception:
                logger.exception("a subscriber of the task queue failed")

    def _end_pool(self) -> None:
        pool, self._pool = self._pool, None
        if pool is None:
            return
        for process in list((pool._processes or {}).values()):
            process.terminate()
        pool.shutdown(wait=False, cancel_futures=True)


__all__ = ["Handler", "JobContext", "JobDone", "JobRunner", "run_job"]
