"""One check of a stretch of a stream, and the process that runs the checks of all live sessions.

A check of 17 sensors takes a tenth of a second of plain Python. In a thread of the service it would hold the
interpreter that frames need; so it runs in a process of its own, of low priority and bounded memory.
"""

import logging
import multiprocessing
import os
import resource
import threading
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from typing import Final, NamedTuple

import numpy as np

from app.errors import Unavailable
from app.sentences import say
from estimators.calibration import Finding, Hemisphere, check_plausibility
from estimators.recording import Float, ImuChunk

logger = logging.getLogger(__name__)

NICENESS: Final = 10
MEMORY_BYTES: Final = 4 << 30
"""Address space of the process: what it imports takes one gigabyte of it, a check some megabytes."""
_MOVED_MPS2: Final = 1.0
"""Spread of the specific force: turned by some six degrees, whatever the gyroscope says."""


class Checked(NamedTuple):
    """What a check found.

    Attributes
    ----------
    findings : list of Finding
    moved : list of str
        Sensors that moved within the newest ticks.
    cost_s : float
        Processor time that it took.
    """

    findings: list[Finding]
    moved: list[str]
    cost_s: float


Check = Callable[[ImuChunk, tuple[str, ...], Hemisphere, int, bool], Checked]


def check(
    chunk: ImuChunk, names: tuple[str, ...], hemisphere: Hemisphere, newest_ticks: int, at_rest: bool
) -> Checked:
    """Look for readings that cannot be right.

    Parameters
    ----------
    chunk : ImuChunk
        The last seconds.
    names : tuple of str
        Placements in the order of the chunk.
    hemisphere : {"north", "south", "unknown"}
    newest_ticks : int
        Movement is looked for among so many ticks at the end.
    at_rest : bool
        Whether a stretch in which nothing moved is worth a check.
    """
    began_s = time.thread_time()
    newest = chunk.ticks(max(0, chunk.tick_count - newest_ticks), chunk.tick_count)
    moved = [
        name
        for name, force in zip(names, newest.accelerometer_mps2, strict=True)
        if _spread(force) > _MOVED_MPS2
    ]
    found: list[Finding] = []
    if moved or at_rest:
        # A sensor that sends nothing is told as lost by the health of the link.
        found = [
            finding
            for finding in check_plausibility(chunk, names, hemisphere=hemisphere)
            if finding.code != "no_data"
        ]
    return Checked(found, moved, time.thread_time() - began_s)


def _spread(force_mps2: Float) -> float:
    """Return how much a sensor's specific force varied, all axes together; 0 where nothing came."""
    sound = force_mps2[np.isfinite(force_mps2).all(axis=1)]
    return float(np.sqrt(sound.var(axis=0).sum())) if len(sound) else 0.0


class CheckProcess:
    """Runs `check` in one process, started with the first check and again when it has died.

    It is spawned, not forked: no socket and no lock of the service is in it. It ends with the service, also when that
    is killed.
    """

    def __init__(self) -> None:
        self._pool: ProcessPoolExecutor | None = None
        self._lock = threading.Lock()
        self._is_closed = False

    def __call__(
        self,
        chunk: ImuChunk,
        names: tuple[str, ...],
        hemisphere: Hemisphere,
        newest_ticks: int,
        at_rest: bool,
    ) -> Checked:
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
                raise Unavailable(say("live.stopping"), reason="stopping")
            if self._pool is None:
                self._pool = ProcessPoolExecutor(
                    1, mp_context=multiprocessing.get_context("spawn"), initializer=_begin
                )
            pool = self._pool
        try:
            return pool.submit(check, chunk, names, hemisphere, newest_ticks, at_rest).result()
        except BrokenProcessPool:
            with self._lock:
                if self._pool is pool:
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


__all__ = ["Check", "CheckProcess", "Checked", "check"]
