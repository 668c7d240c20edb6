"""A thread that never holds the interpreter's lock and takes the packets of one pool whenever it is asked to.

A compiled call in a Python thread gives the lock back, but its return waits until the event loop lets go of it, several
milliseconds when there is much to do. So the thread stays in compiled code: it waits at a pipe for a request, places
and estimates what the request names, and answers at another pipe, which the event loop watches. Meanwhile the loop
reads and writes sockets.
"""

import contextlib
import ctypes
import os
import select
import sys
import threading
import weakref
from collections.abc import Callable
from typing import Final

import numpy as np
from numba import types
from numpy.typing import NDArray

from app.network.placing.kernel import NETWORK, PACKETS, PLACED, place
from app.network.placing.slot import ITEM, Network, Packets, Placed
from estimators.compiling import compiled
from estimators.kernels import VOID, rows
from estimators.pipelines.arm.pooled_kernel import ROWS, TABLES, WORK, step_arms
from estimators.pipelines.arm.rows import ArmRows, ArmTables, ArmWork
from estimators.pipelines.pooled import COLUMNS, STRETCH, Columns

COUNT, JOURNAL, FRAME_ROWS, REQUESTS, ANSWERS, IS_ANSWERED = range(6)
"""Places of what a request says: packets, which journal holds them, rows of frames a session has; of the pipes, and
whether there is an answer."""
GIVES_WAY: Final = 5
"""Added to the niceness of the threads, which thereby weigh a third of the event loop's where cores are scarce."""
Take = Callable[[NDArray[np.int64], NDArray[np.uint8]], None]
"""Takes what is asked for, as `take_arms` does with a pool's arrays."""
_libc: Final = ctypes.PyDLL(None)
"""Its calls hold the interpreter's lock. A thread that releases it for one byte waits a switch interval for it."""
_libc.read.argtypes = _libc.write.argtypes = (ctypes.c_int, ctypes.c_void_p, ctypes.c_size_t)
_libc.read.restype = _libc.write.restype = ctypes.c_ssize_t
_read: Final = types.ExternalFunction("read", types.intp(types.int32, types.voidptr, types.uintp))
_write: Final = types.ExternalFunction("write", types.intp(types.int32, types.voidptr, types.uintp))


@compiled(
    VOID(
        types.int64[::1],
        types.uint8[::1],
        rows(ITEM),
        rows(STRETCH),
        PACKETS,
        PACKETS,
        NETWORK,
        PLACED,
        ROWS,
        TABLES,
        WORK,
        COLUMNS,
    )
)
def take_arms(
    request: NDArray[np.int64],
    byte: NDArray[np.uint8],
    items: NDArray[np.void],
    stretches: NDArray[np.void],
    even: Packets,
    odd: Packets,
    network: Network,
    placed: Placed,
    r: ArmRows,
    tables: ArmTables,
    work: ArmWork,
    columns: Columns,
) -> None:
    """Take what is asked for until the pipe of requests is closed; at once and only once where there is none.

    One kernel for both, because what it calls is large, and is linked into each kernel that calls it.

    Parameters
    ----------
    request : ndarray of int64
        By the places above; without pipes `REQUESTS` is negative.
    byte : ndarray of uint8, shape (1,)
        What comes and goes through the pipes.
    even, odd : Packets
        Of the two journals.
    items : ndarray of ITEM
    stretches : ndarray of STRETCH
    network, placed
        As of `place`.
    r, tables, work, columns
        As of `step_arms`.
    """
    while True:
        if request[REQUESTS] >= 0:
            found = _read(np.int32(request[REQUESTS]), byte.ctypes, np.uintp(1))
            if found == 0:
                return
            if found < 0:
                # Interrupted.
                continue
        count = request[COUNT]
        packets = even if request[JOURNAL] == 0 else odd
        place(items, count, packets, network, placed, request[FRAME_ROWS])
        for n in range(count):
            one, item = stretches[n], items[n]
            one.slot, one.first_tick, one.ticks = item.slot, item.first_tick, item.ticks
            one.signals_at, one.quality_at, one.tick_at = item.signals_at, item.quality_at, item.tick_at
        step_arms(stretches, count, placed.signals, placed.quality, r, tables, work, columns)
        if request[REQUESTS] < 0:
            return
        request[IS_ANSWERED] = 1
        while _write(np.int32(request[ANSWERS]), byte.ctypes, np.uintp(1)) < 0:
            pass


def asked(count: int, journal: int, frame_rows: int) -> NDArray[np.int64]:
    """Return a request without pipes: the first `count` items, from a journal (0 or 1)."""
    return np.array([count, journal, frame_rows, -1, -1, 0])


class StepThread:
    """Takes packets for a pool in a thread of its own; `ask` and `wait` alternate.

    Parameters
    ----------
    take : callable
        Called in the thread with what is asked for and a byte; it returns when the pipe of requests is closed.
    """

    def __init__(self, take: Take) -> None:
        requests, self._asking = os.pipe()
        self.answers, answering = os.pipe()
        """File descriptor that can be read once there is an answer."""
        self._request = np.array([0, 0, 0, requests, answering, 0])
        self._said = self._request.data
        os.set_blocking(self.answers, False)
        self._poll = select.poll()
        self._poll.register(self.answers, select.POLLIN)
        self._byte = ctypes.create_string_buffer(b"\1", 1)
        self._errors: list[Exception] = []
        # The thread holds arrays, never the pool: where a pool is forgotten the pipes are closed, and its thread ends.
        self._close_asking, self._close_answers = (
            weakref.finalize(self, os.close, end) for end in (self._asking, self.answers)
        )
        self._close_asking.atexit = self._close_answers.atexit = False
        self._thread = threading.Thread(
            target=_serve, args=(take, self._request, self._errors), name="pool-step", daemon=True
        )
        self._thread.start()

    @property
    def has_answered(self) -> bool:
        """Whether `wait` will return at once; costs no system call."""
        return self._said[IS_ANSWERED] != 0

    def ask(self, count: int, journal: int, frame_rows: int) -> None:
        """Let the first `count` items be taken from a journal (0 or 1)."""
        self._request[:REQUESTS] = count, journal, frame_rows
        self._said[IS_ANSWERED] = 0
        if _libc.write(self._asking, self._byte, 1) != 1:
            raise BrokenPipeError("a pool's thread has ended")

    def wait(self) -> None:
        """Wait for the answer, without the interpreter's lock; raises what the compiled code raised."""
        while (found := _libc.read(self.answers, self._byte, 1)) < 0:
            self._poll.poll()
        if self._errors:
            raise self._errors.pop()
        if not found:
            raise BrokenPipeError("a pool's thread has ended")

    def close(self) -> None:
        """Let the thread end; only while nothing is asked for."""
        self._close_asking()
        self._thread.join()
        self._close_answers()


def _give_way() -> None:
    """Let the event loop go first where both want a core: it holds the interpreter's lock when it asks.

    Woken with the same priority, this thread would take the loop's core, and everything else would wait for it.
    """
    if sys.platform != "linux":
        # It ranks single threads; elsewhere all stay equal.
        return
    own = threading.get_native_id()
    with contextlib.suppress(OSError):
        os.setpriority(os.PRIO_PROCESS, own, os.getpriority(os.PRIO_PROCESS, own) + GIVES_WAY)


def _serve(take: Take, request: NDArray[np.int64], errors: list[Exception]) -> None:
    requests, answering = int(request[REQUESTS]), int(request[ANSWERS])
    byte = np.zeros(1, dtype=np.uint8)
    try:
        _give_way()
        while True:
            try:
                take(request, byte)
                return
            except Exception as error:
                errors.append(error)
                request[IS_ANSWERED] = 1
                os.write(answering, b"\1")
    finally:
        os.close(requests)
        os.close(answering)
        # Behind both: whoever has asked meanwhile finds out that there is nobody.
        request[IS_ANSWERED] = 1
