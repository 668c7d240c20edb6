"""Long tasks off the live path: a queue in the database, worked off by a few child processes (`app.processes`).

A task is a row; its progress is written to the row, and a task that was running when the service died is
taken up again at the next start. A task whose process dies twice has failed. One service process runs the
queue of a database, or several workers share it: each takes tasks in its own fair order, and up again what
ran at one that has ended (`Runners`).

The queue is fair (`app.recordings.analysis.queue`): clinics take turns, and inside a clinic whoever asked for tasks.
"""

import contextlib
import logging
import threading
import time
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Final, Protocol

from sqlalchemy import CursorResult, Engine, select, update
from sqlalchemy.orm import Session

from app import logs, processes
from app.accounts.audit_reading import note_ended
from app.accounts.subject import Subject
from app.database import ended
from app.database import engine as engines
from app.database.unit_of_work import after_commit, read_only, unit_of_work
from app.errors import NotFound, TelemotionError
from app.recordings.analysis.queue import FairQueue, Waiting
from app.recordings.files_in_passing import SWEEP_S, remove_file, remove_orphans
from app.recordings.models import Job, MotionSession, Result
from app.settings import Settings
from estimators.errors import EstimationError
from estimators.sentences import say

logger = logging.getLogger(__name__)

POLL_S: Final = 0.5
PROGRESS_S: Final = 0.3
MAX_ATTEMPTS: Final = 2
LOOK_S: Final = 2.0
"""How often several that share a queue look whether one has ended."""


class Runners(Protocol):
    """Several that work off one queue; this one among them."""

    key: str
    """Stored with what this one runs."""

    def ended(self, key: str) -> AbstractContextManager[bool]:
        """Whether the one of a key has ended; while this is so, nobody else finds the same."""


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
            values["message"] = message
        with unit_of_work(self.engine) as session:
            changed = session.execute(update(Job).where(Job.id == self.job_id).values(**values))
            if isinstance(changed, CursorResult) and changed.rowcount == 0:
                raise NotFound(say("job.session_deleted"))

    def remember(self, **arguments: Any) -> None:
        """Keep facts with the task that its next attempt needs."""
        self.arguments = {**self.arguments, **arguments}
        with unit_of_work(self.engine) as session:
            session.execute(update(Job).where(Job.id == self.job_id).values(arguments=self.arguments))


Handler = Callable[[JobContext], str]
"""Does one kind of task; returns what to say when it is done. A further attempt starts again."""


@dataclass(frozen=True)
class JobDone:
    """Sent to subscribers when a task ends."""

    job_id: str
    session_id: str
    kind: str
    status: str
    message: str


def run_job(
    engine: Engine, settings: Settings, job_id: str, handler: Handler, runner: str = ""
) -> JobDone | None:
    """Run one queued task to its end in this process, for a runner of this key; None when it is gone or taken.

    A failure is written to the row in words; it never escapes.
    """
    with unit_of_work(engine) as session:
        # Of several that want it, one sees it queued.
        job = session.get(Job, job_id, with_for_update=True)
        if job is None or job.status != "queued":
            return None
        clinic_id = session.scalars(
            select(MotionSession.clinic_id).where(MotionSession.id == job.session_id)
        ).one()
        attempt = int(job.arguments.get("attempt", 0)) + 1
        job.arguments = {**job.arguments, "attempt": attempt, "runner": runner}
        job.status = "running"
        job.message = ""
        context = JobContext(
            engine, settings, job.id, job.session_id, Subject.system(clinic_id), job.arguments, attempt
        )
        kind = job.kind
    try:
        message = handler(context)
    except MemoryError:
        logger.warning("task %s (%s) failed: MemoryError", job_id, kind)
        status, message = (
            "failed",
            say("job.memory", limit_bytes=settings.job_memory_bytes),
        )
    except (TelemotionError, EstimationError) as error:
        status, message = "failed", error.message
        logger.warning("task %s (%s) failed: %s", job_id, kind, type(error).__name__)
    except Exception:
        logger.exception("task %s (%s) failed", job_id, kind)
        status, message = (
            "failed",
            say("job.internal"),
        )
    else:
        status = "complete"
    _finish(engine, context, kind, status, message)
    return JobDone(job_id, context.session_id, kind, status, message)


def _finish(engine: Engine, context: JobContext, kind: str, status: str, message: str) -> None:
    with unit_of_work(engine) as session:
        job = session.get(Job, context.job_id)
        if job is not None and job.arguments.get("attempt") != context.attempt:
            # Another attempt runs: this one was taken for ended.
            return
        after_commit(session, partial(remove_file, context.settings, context.arguments))
        if job is None:
            return
        job.status, job.message = status, message
        if status == "complete":
            job.progress = 1.0
            return
        _waits_no_more(session, job, message)
        result_id = context.arguments.get("result_id")
        result = session.get(Result, result_id) if isinstance(result_id, str) else None
        if result is not None and result.status == "running":
            result.status, result.message = "failed", message


def _waits_no_more(session: Session, job: Job, message: str) -> None:
    """End a session that waits for a task which has failed for good: it must not wait for ever."""
    owner = session.get(MotionSession, job.session_id)
    if owner is not None and owner.state == "closing":
        owner.state, owner.state_reason = "failed", say("job.analysis_failed", reason=message)


def _work(emit: processes.Emit, settings: Settings, job_id: str, handler: Handler, runner: str) -> None:
    logs.configure(settings)
    engine = engines.create(settings)
    emit(run_job(engine, settings, job_id, handler, runner))
    engine.dispose()


class JobRunner:
    """Takes queued tasks in fair order and runs each in a child process.

    Parameters
    ----------
    settings : Settings
        How many at once, and how much memory each may take.
    handlers : mapping of kind to Handler
        Module-level functions (they are sent to the child by name).
    runners : Runners, optional
        Where the queue is shared.
    """

    def __init__(
        self,
        engine: Engine,
        settings: Settings,
        handlers: Mapping[str, Handler],
        runners: Runners | None = None,
    ) -> None:
        self._engine = engine
        self._settings = settings
        self._handlers = dict(handlers)
        self._runners = runners
        self._looked_s = self._swept_s = time.monotonic()
        self._noted = 0
        self._queue = FairQueue(settings.job_workers)
        self._children: dict[str, processes.Child] = {}
        self._attendants: set[threading.Thread] = set()
        self._subscribers: list[Callable[[JobDone], None]] = []
        self._wake = threading.Event()
        self._stopping = threading.Event()
        self._lock = threading.Lock()
        self._thread: threading.Thread | None = None

    def subscribe(self, callback: Callable[[JobDone], None]) -> None:
        """Call `callback` from one of the runner's threads whenever a task ends."""
        self._subscribers.append(callback)

    def start(self) -> None:
        """Queue again what was running when the service ended, then begin to work."""
        self._take_up()
        self._thread = threading.Thread(target=self._run, name="jobs", daemon=True)
        self._thread.start()

    def wake(self) -> None:
        """Look for tasks now instead of at the next poll."""
        self._wake.set()

    def stop(self) -> None:
        """Stop; tasks in progress are ended and taken up again at the next start."""
        self._stopping.set()
        self._wake.set()
        with self._lock:
            children = list(self._children.values())
        for child in children:
            child.end()
        for thread in [self._thread, *self._attendants]:
            if thread is not None:
                thread.join(10.0)
        self._thread = None

    def _run(self) -> None:
        while not self._stopping.is_set():
            try:
                if self._runners is not None and time.monotonic() - self._looked_s > LOOK_S:
                    self._take_up()
                self._sweep_when_due()
                has_begun = self._begin_next()
            except Exception:
                logger.exception("the task queue stumbled; it goes on")
                has_begun = False
            if not has_begun:
                self._wake.wait(POLL_S)
                self._wake.clear()

    def _sweep_when_due(self) -> None:
        """Remove files that nobody needs, and copy into the register what was ended for good on other machines."""
        if time.monotonic() - self._swept_s < SWEEP_S:
            return
        self._swept_s = time.monotonic()
        remove_orphans(self._engine, self._settings, SWEEP_S)
        self._noted = note_ended(self._engine, ended.path_of(self._settings), self._noted)

    def _take_up(self) -> None:
        """Queue again what ran where nobody runs it any more."""
        self._looked_s = time.monotonic()
        with read_only(self._engine) as session:
            running = session.execute(select(Job.id, Job.arguments).where(Job.status == "running")).all()
        for job_id, arguments in running:
            with self._has_ended(job_id, arguments.get("runner", "")) as has_ended:
                if has_ended:
                    with unit_of_work(self._engine) as session:
                        job = session.get(Job, job_id)
                        if job is not None and job.status == "running":
                            self._interrupted(session, job)

    def _has_ended(self, job_id: str, key: str) -> AbstractContextManager[bool]:
        if self._runners is None or key in ("", self._runners.key):
            return contextlib.nullcontext(job_id not in self._children)
        return self._runners.ended(key)

    def _begin_next(self) -> bool:
        """Begin one task if there is one and a place for it."""
        with read_only(self._engine) as session:
            waiting = self._queue.take(session)
        if waiting is None:
            return False
        thread = threading.Thread(target=self._attend, args=(waiting,), name="job", daemon=True)
        self._attendants.add(thread)
        thread.start()
        return True

    def _attend(self, waiting: Waiting) -> None:
        done = None
        try:
            done = self._run_one(waiting)
        except Exception:
            logger.exception("task %s could not be run", waiting.job_id)
            # Not at once again: whatever hindered it may last.
            self._stopping.wait(POLL_S)
        finally:
            self._queue.done(waiting)
            self._attendants.discard(threading.current_thread())
            self._wake.set()
        if done is not None:
            self._report(done)

    def _run_one(self, waiting: Waiting) -> JobDone | None:
        job_id = waiting.job_id
        handler = self._handlers.get(waiting.kind)
        if handler is None:
            with unit_of_work(self._engine) as session:
                job = session.get_one(Job, job_id)
                job.status, job.message = "failed", say("job.unknown_kind", kind=waiting.kind)
                after_commit(session, partial(remove_file, self._settings, job.arguments))
            return None
        memory_bytes = self._settings.job_memory_bytes
        with self._lock:
            if self._stopping.is_set():
                return None
            child = self._children[job_id] = processes.Child(
                _work,
                self._settings,
                job_id,
                handler,
                self._runners.key if self._runners is not None else "",
                memory_bytes=memory_bytes,
                name="job",
            )
        try:
            done: JobDone | None = next(child.results(), None)
        except processes.ChildDied:
            if self._stopping.is_set():
                return None
            logger.error("the process of task %s died", job_id)
            done = self._worker_died(job_id)
        finally:
            self._children.pop(job_id, None)
            child.end()
        return done

    def _worker_died(self, job_id: str) -> JobDone | None:
        with unit_of_work(self._engine) as session:
            job = session.get(Job, job_id)
            if job is None:
                return None
            self._interrupted(session, job)
            if job.status != "failed":
                return None
            return JobDone(job.id, job.session_id, job.kind, job.status, job.message)

    def _interrupted(self, session: Session, job: Job) -> None:
        """Queue a task again, unless that was tried often enough."""
        if job.is_retryable and int(job.arguments.get("attempt", 0)) < MAX_ATTEMPTS:
            job.status, job.progress, job.message = "queued", 0.0, say("job.interrupted")
        elif job.status != "queued":
            job.status = "failed"
            job.message = say("job.given_up")
            _waits_no_more(session, job, job.message)
            after_commit(session, partial(remove_file, self._settings, job.arguments))

    def _report(self, done: JobDone) -> None:
        for callback in self._subscribers:
            try:
                callback(done)
            except Exception:
                logger.exception("a subscriber of the task queue failed")
