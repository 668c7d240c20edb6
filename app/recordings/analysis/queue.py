"""Which task is next: clinics take turns, inside a clinic whoever asked for tasks, inside these the oldest.

A clinic may fill all workers but one, so that another clinic's task never waits for the end of somebody's long one.
"""

import threading
from dataclasses import dataclass
from datetime import datetime
from itertools import count

from sqlalchemy import bindparam, func, select
from sqlalchemy.orm import Session

from app.recordings.models import Job, MotionSession

# Asked several times a second for as long as the service runs, and so built once (see `app.patients.access`).
_IS_WAITING = (Job.status == "queued") & Job.id.not_in(bindparam("running", expanding=True))
_GROUPS = (
    select(MotionSession.clinic_id, Job.created_by, func.min(Job.created_at))
    .join(MotionSession, MotionSession.id == Job.session_id)
    .where(_IS_WAITING)
    .group_by(MotionSession.clinic_id, Job.created_by)
)
_OLDEST_OF_GROUP = (
    select(Job.id, Job.kind)
    .join(MotionSession, MotionSession.id == Job.session_id)
    .where(
        _IS_WAITING,
        MotionSession.clinic_id == bindparam("clinic_id"),
        Job.created_by == bindparam("asked_by"),
    )
    .order_by(Job.created_at, Job.id)
    .limit(1)
)


@dataclass(frozen=True)
class Waiting:
    """A queued task.

    Attributes
    ----------
    asked_by : str
        Account or device that asked for it.
    """

    job_id: str
    kind: str
    clinic_id: str
    asked_by: str


class FairQueue:
    """Chooses tasks, from any thread.

    Parameters
    ----------
    workers : int
        Tasks at once.
    """

    def __init__(self, workers: int) -> None:
        self._workers = workers
        self._running: dict[str, Waiting] = {}
        self._turn = count(1)
        self._last_turn: dict[tuple[str, ...], int] = {}
        self._lock = threading.Lock()

    def take(self, session: Session) -> Waiting | None:
        """Return the task to begin now, which counts as running until `done`; None when there is none or no place."""
        with self._lock:
            if len(self._running) >= self._workers:
                return None
            found = self._next(session)
            if found is not None:
                turn = next(self._turn)
                self._last_turn[(found.clinic_id,)] = turn
                self._last_turn[(found.clinic_id, found.asked_by)] = turn
                self._running[found.job_id] = found
            return found

    def done(self, waiting: Waiting) -> None:
        """Note that a task runs no more."""
        with self._lock:
            self._running.pop(waiting.job_id, None)

    def _next(self, session: Session) -> Waiting | None:
        running = list(self._running)
        rows = session.execute(_GROUPS, {"running": running}).all()
        groups: list[tuple[str, str, datetime]] = [(row[0], row[1], row[2]) for row in rows]
        most = max(1, self._workers - 1)
        at_work = [running.clinic_id for running in self._running.values()]
        may_begin = [group for group in groups if at_work.count(group[0]) < most]
        if not may_begin:
            return None

        def place(group: tuple[str, str, datetime]) -> tuple[int, int, datetime]:
            clinic_id, asked_by, oldest = group
            last = self._last_turn.get
            return last((clinic_id,), 0), last((clinic_id, asked_by), 0), oldest

        clinic_id, asked_by, _ = min(may_begin, key=place)
        group = {"running": running, "clinic_id": clinic_id, "asked_by": asked_by}
        job = session.execute(_OLDEST_OF_GROUP, group).one()
        return Waiting(job.id, job.kind, clinic_id, asked_by)
