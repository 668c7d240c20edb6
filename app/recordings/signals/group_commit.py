"""The one writer of signals: many sessions, one transaction every tenth of a second.

A live session hands over packets, frames and events from any thread and never waits for the disk. They
gather in chunks of about one second, of more where there are many sessions; a writer thread packs those that
are due in compiled code and commits them together, one statement a table. Chunks of different sessions end at
moments spread over that time: a commit takes few. Only then does a session learn which packets are durable,
and only those may be acknowledged to its gateway, which keeps and repeats the rest: a crash loses nothing
acknowledged.

Back-pressure, said plainly. What waits is bounded in bytes, in total and per session. When full:

- packets are refused with `Unavailable`; nothing is dropped silently, the packet stays unacknowledged and
  the gateway sends it again (metric `packets_refused`);
- frames are refused first, at half the bound, because they can be estimated again from the packets
  (`append_frames` returns False; metric `frame_ticks_refused`).

Exactly once. A sequence that is stored or waits to be is not taken twice (`append_packet` returns False,
metric `packets_duplicate`); the ledger of a session is read back from its chunks after a restart, so
packets sent again after a crash are recognised. Chunks are idempotent on (session, stream, sequence).

A session whose rows cannot be written (it was deleted, say) fails alone: the group is then committed
session by session, the failing one is reported to its `on_failure` and takes no more data.
"""

import logging
import threading
import time
from collections.abc import Callable, Set
from concurrent.futures import Future
from itertools import chain, count
from operator import attrgetter
from typing import Any, Final

from sqlalchemy import Engine
from sqlalchemy.exc import DBAPIError, IntegrityError, SQLAlchemyError

from app.database.unit_of_work import read_only
from app.errors import Conflict, TelemotionError, Unavailable
from app.network.packet_run import PacketRun
from app.network.ranges import SequenceRanges
from app.network.raw_packet import RawPacket
from app.recordings.signals.buffers import (
    Batch,
    DurableCallback,
    FailureCallback,
    OpenSession,
    event_row,
    tell,
)
from app.recordings.signals.checkpoints import Checkpoint
from app.recordings.signals.chunks import check_packet
from app.recordings.signals.metrics import WriterMetrics
from app.recordings.signals.rows import AlreadyStoredError, write_batch, write_batches
from app.recordings.signals.store import Standing, read_standing
from estimators.pipelines._contract import Frames
from estimators.sentences import say

logger = logging.getLogger(__name__)

COMMIT_INTERVAL_S: Final = 0.1
CHUNK_S: Final = 1.0
LONGEST_CHUNK_S: Final = 2.0
"""A gateway keeps what is not acknowledged, and its page says when that is for too long (`NOT_STORED_AFTER_S`)."""
SESSIONS_A_SECOND: Final = 125
"""Whose chunks end within a second: what a session costs to commit depends little on how long its chunk is."""
COMMIT_BYTES: Final = 32 * 1024 * 1024
QUEUE_BYTES: Final = 256 * 1024 * 1024
SESSION_BYTES: Final = 32 * 1024 * 1024
_LONGEST_PAUSE_S: Final = 5.0
_GOLDEN: Final = 0.6180339887498949


class GroupCommitWriter:
    """Stores what live sessions produce; safe to call from any thread and from the event loop.

    Parameters
    ----------
    commit_interval_s : float
        Longest time between commits while something is due.
    chunk_s : float
        A chunk is closed when its first item is this old; acknowledgements follow one commit later. Where more than
        `SESSIONS_A_SECOND` are open, it takes in proportion longer, up to `LONGEST_CHUNK_S`.
    commit_bytes, queue_bytes, session_bytes : int
        Commit early above the first, a session above an eighth of the last; refuse above the others (see the
        module text).
    """

    def __init__(
        self,
        engine: Engine,
        *,
        commit_interval_s: float = COMMIT_INTERVAL_S,
        chunk_s: float = CHUNK_S,
        commit_bytes: int = COMMIT_BYTES,
        queue_bytes: int = QUEUE_BYTES,
        session_bytes: int = SESSION_BYTES,
    ) -> None:
        self._engine = engine
        self._commit_interval_s = commit_interval_s
        self._chunk_s = chunk_s
        self._commit_bytes = commit_bytes
        self._queue_bytes = queue_bytes
        self._session_bytes = session_bytes
        self._sessions: dict[str, OpenSession] = {}
        # Entered as it is, the lock costs no call of Python; packets come a thousand a second.
        self._mutex = threading.RLock()
        self._lock = threading.Condition(self._mutex)
        self._thread: threading.Thread | None = None
        self._stopping = False
        self._opened = count()
        self.metrics = WriterMetrics()

    def start(self) -> None:
        """Start the writer thread."""
        if self._thread is None:
            self._stopping = False
            self._thread = threading.Thread(target=self._run, name="group-commit", daemon=True)
            self._thread.start()

    def close(self, timeout_s: float = 30.0) -> None:
        """Commit everything that waits and stop; called last in the lifespan."""
        with self._lock:
            self._stopping = True
            self._lock.notify_all()
        if self._thread is not None:
            self._thread.join(timeout_s)
            self._thread = None

    def open_session(
        self,
        session_id: str,
        on_durable: DurableCallback | None = None,
        on_failure: FailureCallback | None = None,
        standing: Standing | None = None,
    ) -> SequenceRanges:
        """Make a session known and return what is stored of it; reads the database, so not on the event loop.

        Opening again replaces the callbacks and keeps everything else.

        Parameters
        ----------
        on_durable : callable(SequenceRanges)
            Called from the writer thread after each commit, with the whole durable set (a copy).
        on_failure : callable(TelemotionError)
            Called once from the writer thread when the session's rows cannot be written.
        standing : Standing, optional
            What is stored of it, where that was read already.
        """
        with self._lock:
            known = self._sessions.get(session_id)
            if known is not None and known.failure is None:
                known.on_durable, known.on_failure = on_durable, on_failure
                return known.durable.copy()
        if standing is None:
            with read_only(self._engine) as reader:
                standing = read_standing(reader, session_id)
        durable = standing.durable.copy()
        opened = OpenSession(
            session_id=session_id,
            seen=durable.copy(),
            durable=durable,
            on_durable=on_durable,
            on_failure=on_failure,
            next_chunk=standing.next_chunk,
            # Multiples of the golden ratio lie evenly, however many there are.
            head_start=next(self._opened) * _GOLDEN % 1.0,
            strides=standing.strides,
        )
        with self._lock:
            known = self._sessions.get(session_id)
            if known is not None and known.failure is None:
                # Another thread was faster; its buffer may hold packets already.
                known.on_durable, known.on_failure = on_durable, on_failure
                return known.durable.copy()
            self._sessions[session_id] = opened
        return durable.copy()

    def append_packet(self, session_id: str, packet: RawPacket) -> bool:
        """Take one packet; True when it is new, False when it is stored or waiting already.

        Raises
        ------
        Unavailable
            The queue is full: stop reading from this gateway for a moment; do not acknowledge the packet.
        Conflict
            The session is not open here, or failed.
        """
        check_packet(packet)
        size = len(packet.payload) + 128
        with self._mutex:
            session = self._open(session_id)
            if packet.sequence in session.seen:
                self.metrics.packets_duplicate += 1
                return False
            self._make_sure_there_is_room(session, size)
            session.add_packet(packet, size)
            self._count_queued(session, size)
            return True

    def append_run(self, session_id: str, run: PacketRun, came_s: float) -> int:
        """Take packets that came one after the other, the first at a monotonic time; return how many are new.

        Raises as `append_packet`.
        """
        size = run.size + 128 * len(run.messages)
        with self._mutex:
            session = self._open(session_id)
            if run.first_sequence <= session.seen.highest:
                return sum([self.append_packet(session_id, packet) for packet in run.packets()])
            self._make_sure_there_is_room(session, size)
            session.add_run(run, size, came_s)
            self._count_queued(session, size)
            return len(run.messages)

    def has_room(self, session_id: str) -> bool:
        """Whether packets and frames of a session are taken, with room to spare."""
        session = self._sessions.get(session_id)
        return (
            session is not None
            and session.failure is None
            and not self._stopping
            and self.metrics.queued_bytes < self._queue_bytes // 4
            and session.waiting_bytes < self._session_bytes // 4
        )

    def append_frames(self, session_id: str, result_id: str, frames: Frames) -> bool:
        """Take frames of a result, all ticks of them; False when they were refused because the queue is half full.

        Stored are those that the stride of the result keeps.
        """
        size = (
            frames.q_room_segment.nbytes + frames.point_room_m.nbytes + 2 * frames.angle_rad.nbytes
        ) // 2 + 256
        with self._mutex:
            session = self._open(session_id)
            if (
                self.metrics.queued_bytes + size > self._queue_bytes // 2
                or session.waiting_bytes + size > self._session_bytes // 2
            ):
                self.metrics.frame_ticks_refused += frames.tick_count
                return False
            session.add_frames(result_id, frames, size)
            self._count_queued(session, size)
            return True

    def add_checkpoint(self, session_id: str, made: Callable[[], Checkpoint]) -> None:
        """Take where a session stands after all that it gave so far; committed with the last of it, never before.

        Parameters
        ----------
        made : callable()
            Makes what is stored; called in the writer's thread.
        """
        with self._mutex:
            self._open(session_id).checkpoint = made

    def add_event(
        self,
        session_id: str,
        kind: str,
        time_s: float,
        *,
        duration_s: float = 0.0,
        placement: str | None = None,
        text: str = "",
        details: dict[str, Any] | None = None,
    ) -> None:
        """Put an event on the session's time line; events are few and never refused."""
        row = event_row(session_id, kind, time_s, duration_s, placement, text, details)
        with self._lock:
            session = self._open(session_id)
            session.events.append(row)
            session.is_urgent = True
            self._lock.notify()

    def flush(self, session_id: str) -> Future[SequenceRanges]:
        """Close the session's open chunks now; the future gives the durable set once they are committed."""
        future: Future[SequenceRanges] = Future()
        with self._lock:
            session = self._open(session_id)
            session.is_urgent = True
            session.waiting.append(future)
            self._lock.notify()
        return future

    def stored_ranges(self, session_id: str) -> SequenceRanges:
        """Return which sequences of an open session are committed."""
        with self._lock:
            return self._open(session_id).durable.copy()

    def trouble(self) -> str | None:
        """Return in words why what waits is not being stored; None when all is well."""
        with self._lock:
            failing = sum(session.repeat is not None for session in self._sessions.values())
            is_running = self._thread is not None and self._thread.is_alive()
        if failing:
            return f"The last commit of {failing} sessions failed; it is tried again."
        return None if is_running else "The thread that commits is not running."

    def close_session(self, session_id: str) -> None:
        """Forget a session; what waits is still committed. Await `flush` first to know that it was."""
        with self._lock:
            session = self._sessions.get(session_id)
            if session is None:
                return
            if session.failure is not None or session.is_empty:
                del self._sessions[session_id]
            else:
                session.is_urgent = True
                session.is_closing = True
                self._lock.notify()

    def _open(self, session_id: str) -> OpenSession:
        session = self._sessions.get(session_id)
        if session is None:
            raise Conflict(say("stored.not_open"))
        if session.failure is not None:
            raise Conflict(say("stored.failed", reason=session.failure.message))
        if self._stopping:
            raise Unavailable(say("stored.stopping"), retry_after_s=5)
        return session

    def _make_sure_there_is_room(self, session: OpenSession, size: int) -> None:
        if (
            self.metrics.queued_bytes + size > self._queue_bytes
            or session.waiting_bytes + size > self._session_bytes
        ):
            self.metrics.packets_refused += 1
            raise Unavailable(
                say("stored.behind"),
                retry_after_s=1,
                reason="store_behind",
            )

    def _count_queued(self, session: OpenSession, size: int) -> None:
        if session.size >= self._session_bytes // 8:
            # Faster than life: stored now, before its frames are refused.
            session.is_urgent = True
        metrics = self.metrics
        metrics.queued_bytes += size
        if metrics.queued_bytes > metrics.queued_bytes_highest:
            metrics.queued_bytes_highest = metrics.queued_bytes
        if metrics.queued_bytes >= self._commit_bytes:
            self._lock.notify()

    def _run(self) -> None:
        next_commit_s = time.monotonic() + self._commit_interval_s
        while True:
            with self._lock:
                while not self._stopping and not self._is_pressing():
                    remaining_s = next_commit_s - time.monotonic()
                    if remaining_s <= 0:
                        break
                    self._lock.wait(remaining_s)
                stopping = self._stopping
                batches = self._take_due(everything=stopping)
            if batches:
                self._commit(batches)
            next_commit_s = time.monotonic() + self._commit_interval_s
            if stopping:
                with self._lock:
                    if all(session.is_empty for session in self._sessions.values()):
                        return
                time.sleep(0.05)

    def _is_full(self) -> bool:
        """Whether enough waits to commit early; what failed before waits for its own time."""
        ready = sum(s.size for s in self._sessions.values() if s.repeat is None)
        return ready >= self._commit_bytes

    def _is_pressing(self) -> bool:
        return self._is_full() or any(s.waiting and s.repeat is None for s in self._sessions.values())

    def _take_due(self, *, everything: bool) -> list[tuple[OpenSession, Batch]]:
        now_s = time.monotonic()
        crowded_s = min(len(self._sessions) / SESSIONS_A_SECOND, LONGEST_CHUNK_S)
        chunk_s = max(self._chunk_s, crowded_s)
        due = [one for one in self._sessions.values() if one.is_due(now_s, chunk_s, everything=everything)]
        if self._is_full():
            due += self._largest(set(map(id, due)))
        return [(one, one.take()) for one in due]

    def _largest(self, taken: Set[int]) -> list[OpenSession]:
        """Return sessions that are committed before they are due: all at once would be due together from then on."""
        left = sorted(
            (one for one in self._sessions.values() if id(one) not in taken and one.repeat is None),
            key=attrgetter("size"),
        )
        waiting, found = sum(one.size for one in left), []
        while waiting > self._commit_bytes // 2:
            found.append(left.pop())
            waiting -= found[-1].size
        return found

    def _commit(self, batches: list[tuple[OpenSession, Batch]]) -> None:
        started_s = time.monotonic()
        batches = [(session, batch) for session, batch in batches if self._is_encoded(session, batch)]
        try:
            with self._engine.begin() as connection:
                write_batches(connection, [(session.session_id, batch) for session, batch in batches])
        except AlreadyStoredError:
            # The answer to an earlier commit was lost, or another process stores one of these sessions.
            for session, batch in batches:
                self._commit_alone(session, batch)
        except (SQLAlchemyError, TelemotionError) as error:
            self.metrics.commit_failures += 1
            logger.warning("group commit failed, trying session by session: %s", type(error).__name__)
            for session, batch in batches:
                self._commit_alone(session, batch)
        else:
            for session, batch in batches:
                self._report_durable(session, batch)
        self.metrics.commits += 1
        self.metrics.last_commit_s = time.monotonic() - started_s
        self.metrics.longest_commit_s = max(self.metrics.longest_commit_s, self.metrics.last_commit_s)

    def _is_encoded(self, session: OpenSession, batch: Batch) -> bool:
        """Make the session's chunks; one that cannot be encoded fails alone."""
        try:
            session.next_chunk = batch.encode(session.next_chunk)
        except (ValueError, OverflowError, TelemotionError) as error:
            logger.exception("a session's data cannot be encoded")
            self._fail(session, batch, Conflict(say("stored.not_encoded", error=type(error).__name__)))
        return batch.is_encoded

    def _commit_alone(self, session: OpenSession, batch: Batch) -> None:
        try:
            with self._engine.begin() as connection:
                write_batch(connection, session.session_id, batch)
        except IntegrityError:
            self._fail(session, batch, Conflict(say("stored.session_gone")))
        except DBAPIError as error:
            # Locked, disk full, connection lost: nothing is lost while memory allows; repeat it, unchanged.
            with self._lock:
                session.attempts += 1
                session.repeat = batch
                pause_s = min(self._commit_interval_s * 2**session.attempts, _LONGEST_PAUSE_S)
                session.repeat_at_s = time.monotonic() + pause_s
            logger.error("storing a session failed (attempt %d): %s", session.attempts, type(error).__name__)
        except (SQLAlchemyError, TelemotionError) as error:
            message = error.message if isinstance(error, TelemotionError) else say("stored.refused")
            self._fail(session, batch, Conflict(message))
        else:
            self._report_durable(session, batch)

    def _report_durable(self, session: OpenSession, batch: Batch) -> None:
        with self._lock:
            session.attempts = 0
            session.durable.update(batch.ranges)
            self.metrics.queued_bytes -= batch.size
            self.metrics.packets_stored += sum([int(chunk.scale["packets"]) for _, chunk in batch.raw])
            self.metrics.frame_ticks_stored += sum([chunk.ticks for _, chunk in batch.frames])
            chunks = [chunk for _, chunk in chain(batch.raw, batch.frames)]
            self.metrics.chunks_written += len(chunks)
            self.metrics.bytes_written += sum([len(chunk.data) for chunk in chunks])
            durable = session.durable.copy()
            if session.is_closing and session.is_empty:
                self._sessions.pop(session.session_id, None)
        if session.on_durable is not None and batch.raw:
            tell(session.on_durable, durable)
        for future in batch.waiting:
            if future.set_running_or_notify_cancel():
                future.set_result(durable)

    def _fail(self, session: OpenSession, batch: Batch, error: TelemotionError) -> None:
        with self._lock:
            self.metrics.queued_bytes -= batch.size + session.size
            waiting = batch.waiting + session.drop(error)
            self.metrics.sessions_failed += 1
        logger.error("a session can no longer be stored: %s", error.message)
        if session.on_failure is not None:
            tell(session.on_failure, error)
        for future in waiting:
            if future.set_running_or_notify_cancel():
                future.set_exception(error)
