"""One check of a stretch of a stream, and the process that runs the checks of all live sessions.

A check of 17 sensors takes a tenth of a second of plain Python. In a thread of the service it would hold the
interpreter that frames need; so it runs in a process of its own, of low priority and bounded memory.

What a check knows of a stream are hundreds of small arrays a sensor. The service holds them as the bytes in which they
come and go: unpacked there, each check would take time from the frames and leave gaps in the memory.
"""

import logging
import multiprocessing
import os
import pickle
import resource
import threading
import time
from collections.abc import Callable, Collection
from concurrent.futures import CancelledError, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from typing import Final, NamedTuple

from app.errors import Unavailable
from estimators.calibration import Finding, RecordingCheck
from estimators.recording import Float, ImuChunk
from estimators.sentences import say

logger = logging.getLogger(__name__)

NICENESS: Final = 10
MEMORY_BYTES: Final = 4 << 30
"""Address space of the process: what it imports takes one gigabyte of it, a check some megabytes."""


class Checked(NamedTuple):
    """What a check found.

    Attributes
    ----------
    known : bytes
        What is known of the whole stream now: a packed `RecordingCheck`.
    clip_levels : ndarray, shape (S, 2, 2, 3)
        As of `RecordingCheck`.
    cost_s : float
        Processor time that it took.
    """

    known: bytes
    findings: list[Finding]
    clip_levels: Float
    cost_s: float


Check = Callable[[bytes, ImuChunk, Collection[str]], Checked]


def check(known: bytes, chunk: ImuChunk, gone: Collection[str] = ()) -> Checked:
    """Look for readings that cannot be right.

    Parameters
    ----------
    known : bytes
        Of what came before; see `packed`.
    chunk : ImuChunk
        What came since.
    gone : collection of str
        Sensors to begin again with.
    """
    began_s = time.thread_time()
    state: RecordingCheck = pickle.loads(known)  # noqa: S301 - a check of this service packed it
    for name in gone:
        state.forget(name)
    state.add(chunk)
    # A sensor that sends nothing is reported as lost by the health of the link.
    found = [finding for finding in state.findings if finding.code != "no_data"]
    return Checked(packed(state), found, state.clip_levels, time.thread_time() - began_s)


def packed(state: RecordingCheck) -> bytes:
    """Return what a check knows as the service holds it."""
    return pickle.dumps(state, pickle.HIGHEST_PROTOCOL)


class CheckProcess:
    """Runs `check` in one process, started with the first check and again when it has died.

    It is spawned, not forked: no socket and no lock of the service is in it. It ends with the service, also when that
    is killed.
    """

    def __init__(self) -> None:
        self._pool: ProcessPoolExecutor | None = None
        self._lock = threading.Lock()
        self._is_closed = False

    def __call__(self, known: bytes, chunk: ImuChunk, gone: Collection[str] = ()) -> Checked:
        """Have a stretch checked; waits, so call it in a thread.

        Raises
        ------
        BrokenProcessPool
            The process has died; the next call starts another one.
        Unavailable
            The service is stopping.
        """
        with self._lock:
            if self._is_closed:
                raise _stopping()
            if self._pool is None:
                self._pool = ProcessPoolExecutor(
                    1, mp_context=multiprocessing.get_context("spawn"), initializer=_begin
                )
            pool = self._pool
        try:
            return pool.submit(check, known, chunk, gone).result()
        except (RuntimeError, CancelledError) as error:
            with self._lock:
                if self._is_closed:
                    raise _stopping() from error
                if self._pool is pool and isinstance(error, BrokenProcessPool):
                    self._end()
            raise

    @property
    def process_ids(self) -> list[int]:
        """Of the process that runs; empty before the first check and after the end."""
        pool = self._pool
        return [] if pool is None else list(pool._processes or {})

    def close(self) -> None:
        """End the process and check nothing more."""
        with self._lock:
            self._is_closed = True
            self._end()

    def _end(self) -> None:
        pool, self._pool = self._pool, None
        if pool is not None:
            for process in list((pool._processes or {}).values()):
                process.terminate()
            pool.shutdown(wait=False, cancel_futures=True)


def _stopping() -> Unavailable:
    return Unavailable(say("live.stopping"), reason="stopping")


def _begin() -> None:
    """Lower priority and memory of the process, and tie its life to its parent's."""
    os.nice(NICENESS)
    hard = resource.getrlimit(resource.RLIMIT_AS)[1]
    most = MEMORY_BYTES if hard == resource.RLIM_INFINITY else min(MEMORY_BYTES, hard)
    resource.setrlimit(resource.RLIMIT_AS, (most, hard))
    parent = multiprocessing.parent_process()

    def leave_with_parent() -> None:
        if parent is not None:
            parent.join()
        os._exit(1)

    threading.Thread(target=leave_with_parent, name="leave-with-parent", daemon=True).start()
