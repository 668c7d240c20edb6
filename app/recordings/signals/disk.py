"""How much each clinic has stored, and that it may store so much and no more.

Signals are nearly all of a database; they are added up by clinic, at most every few minutes, off the live path. Files
that arrive by upload, and those that wait for their task, are on the same disk and count as well. Uploads may use less
than live sessions: a share of the clinic's quota, and some of the disk, stay free for packets that arrive live.
"""

import shutil
import threading
import time
from collections.abc import Callable
from types import TracebackType
from typing import Final

from sqlalchemy import Engine, func, select

from app.database.unit_of_work import read_only
from app.errors import QuotaReached, Unavailable
from app.recordings.files_in_passing import file_of, upload_folder
from app.recordings.models import Job, MotionSession, SignalChunk
from app.settings import Settings
from estimators.sentences import say

COUNTED_EVERY_S: Final = 300.0
LIVE_SHARE: Final = 0.1
"""Share of a clinic's quota that uploads leave free for live sessions."""


class DiskUse:
    """Signals stored and files waiting, by clinic.

    Parameters
    ----------
    settings : Settings
        What a clinic may store, and what stays free of the disk.
    clock : callable
        Monotonic seconds.
    """

    def __init__(
        self, engine: Engine, settings: Settings, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._engine = engine
        self._settings = settings
        self._most_bytes = settings.clinic_disk_bytes
        self._clock = clock
        self._counted: dict[str, tuple[float, int]] = {}
        self._arriving: set[Room] = set()
        self._lock = threading.Lock()

    def check(self, clinic_id: str) -> None:
        """Refuse to store more for a clinic that has used up what it may; blocks on the database.

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
        """Return how much a clinic has on the disk: signals as counted some minutes ago at most, and files."""
        with self._lock:
            return self._used(clinic_id, self._most_bytes - 1)

    def _grow(self, arriving: "Room", size_bytes: int, arrived_bytes: int) -> None:
        """Hold room for so many bytes in all, of which some are on the disk already; see `Room`."""
        most = int(self._most_bytes * (1.0 - LIVE_SHARE))
        folder = upload_folder(self._settings)
        with self._lock:
            self._arriving.discard(arriving)
            used = self._used(arriving.clinic_id, most - size_bytes)
            if used + size_bytes > most:
                raise QuotaReached(
                    say("stored.no_room", size_bytes=size_bytes, used_bytes=used, limit_bytes=most),
                    size_bytes=size_bytes,
                    used_bytes=used,
                    limit_bytes=most,
                )
            others = sum(max(0, one.size_bytes - one.arrived_bytes) for one in self._arriving)
            free = shutil.disk_usage(folder).free - others
            if free - (size_bytes - arrived_bytes) < self._settings.disk_reserve_bytes:
                raise Unavailable(say("stored.disk_reserve"), retry_after_s=60)
            arriving.size_bytes, arriving.arrived_bytes = size_bytes, arrived_bytes
            self._arriving.add(arriving)

    def _release(self, arriving: "Room", *, is_waiting: bool) -> None:
        with self._lock:
            if arriving in self._arriving:
                self._arriving.remove(arriving)
                if is_waiting and (counted := self._counted.get(arriving.clinic_id)):
                    self._counted[arriving.clinic_id] = (counted[0], counted[1] + arriving.size_bytes)

    def _used(self, clinic_id: str, enough_bytes: int) -> int:
        """Return what is used; counted again where that is long ago, or more than what would be enough."""
        arriving = [one for one in self._arriving if one.clinic_id == clinic_id]
        arriving_bytes = sum(one.size_bytes for one in arriving)
        at_s, counted = self._counted.get(clinic_id, (-COUNTED_EVERY_S, 0))
        # A clinic that is refused has perhaps just deleted something.
        if self._clock() - at_s < COUNTED_EVERY_S and counted + arriving_bytes <= enough_bytes:
            return counted + arriving_bytes
        counted = self._count(clinic_id, {one.name for one in arriving})
        self._counted[clinic_id] = (self._clock(), counted)
        return counted + arriving_bytes

    def _count(self, clinic_id: str, arriving: set[str]) -> int:
        """Add up what the clinic has in the database and in files that wait, without those that arrive."""
        with read_only(self._engine) as session:
            total = session.scalar(
                select(func.coalesce(func.sum(func.length(SignalChunk.data)), 0))
                .join(MotionSession, MotionSession.id == SignalChunk.session_id)
                .where(MotionSession.clinic_id == clinic_id)
            )
            waiting = session.scalars(
                select(Job.arguments)
                .join(MotionSession, MotionSession.id == Job.session_id)
                .where(MotionSession.clinic_id == clinic_id, Job.status.in_(("queued", "running")))
            ).all()
        size = int(total or 0)
        for arguments in waiting:
            path = file_of(self._settings, arguments)
            if path is not None and path.name not in arriving and path.exists():
                size += path.stat().st_size
        return size


class Room:
    """Room on the disk for one file that arrives; taken and grown inside a `with` statement, which ends it.

    Parameters
    ----------
    clinic_id : str
        Whose quota it uses.

    Attributes
    ----------
    name : str
        Of the file in `upload_folder` once it waits for its task.
    size_bytes : int
        What is held.
    arrived_bytes : int
        How much of that is on the disk.
    """

    def __init__(self, disk: DiskUse, clinic_id: str) -> None:
        self._disk = disk
        self.clinic_id = clinic_id
        self.name = ""
        self.size_bytes = self.arrived_bytes = 0

    def take(self, name: str, announced_bytes: int) -> None:
        """Hold room for a file that begins to arrive; blocks on the database.

        Parameters
        ----------
        announced_bytes : int
            0 where the sender does not say; the room then grows with what arrives.

        Raises
        ------
        QuotaReached
            The clinic has no room for it.
        Unavailable
            The disk has none.
        """
        self.name = name
        self._disk._grow(self, max(announced_bytes, 1), 0)

    def grow(self, arrived_bytes: int) -> None:
        """Say how much has arrived, before it is written; hold more where less was announced.

        Raises
        ------
        QuotaReached, Unavailable
            As in `take`.
        """
        self._disk._grow(self, max(arrived_bytes, self.size_bytes), arrived_bytes)

    def __enter__(self) -> "Room":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._disk._release(self, is_waiting=error is None)
