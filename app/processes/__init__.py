"""Child processes: work that must neither slow live sessions nor take the machine's memory.

A child is forked from a server process that has imported everything once, so it begins in milliseconds and its
memory is given back when it ends. It has low priority, may allocate so much and no more, is the first that the
system kills when memory runs out, and ends with the service, also when that is killed, so that no orphan writes on.
"""

import contextlib
import multiprocessing
import os
import resource
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from multiprocessing import forkserver
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, Final

from app.errors import Unavailable
from estimators.sentences import say

_PRELOADED: Final = ("app.processes.lower_priority", "app.tables")
_context = multiprocessing.get_context("forkserver")
_context.set_forkserver_preload(list(_PRELOADED))

Emit = Callable[[Any], None]


class ChildDied(Exception):
    """A child ended before its work was done: killed, out of memory, or crashed."""


def prepare(modules: Sequence[str] = ()) -> None:
    """Start the process that children are forked from; it imports while the service goes on. Starting twice is once.

    Parameters
    ----------
    modules : sequence of str
        Where the functions are that children will run.
    """
    _context.set_forkserver_preload([*_PRELOADED, *modules])
    forkserver.ensure_running()


class Child:
    """A function at work in a process of its own.

    Parameters
    ----------
    work : callable(emit, ...)
        Of a module, not nested: it is sent by name. What it gives to `emit` comes out of `results`.
    *arguments
        Must be picklable.
    memory_bytes : int
        Most that it may allocate; beyond it `MemoryError` is raised in it.
    """

    def __init__(self, work: Callable[..., None], *arguments: Any, memory_bytes: int, name: str) -> None:
        self._pipe, theirs = _context.Pipe(duplex=False)
        self._process = _context.Process(
            target=_enter, args=(theirs, memory_bytes, work, arguments), name=name, daemon=True
        )
        try:
            # Waits for the imports of the server process.
            self._process.start()
        except (OSError, EOFError) as error:
            self._pipe.close()
            raise Unavailable(say("service.no_process")) from error
        finally:
            theirs.close()

    @property
    def process_id(self) -> int | None:
        """The system's number of the process."""
        return self._process.pid

    def results(self) -> Iterator[Any]:
        """Yield what the work emits; the work waits while nobody reads.

        Raises
        ------
        ChildDied
            The process ended before its work did.
        """
        try:
            while (item := self._pipe.recv())[0]:
                yield item[1]
        except (EOFError, OSError) as error:
            raise ChildDied from error
        finally:
            self.end()

    def end(self) -> None:
        """End the process now, whatever it does."""
        self._process.kill()
        self._process.join()
        # Whoever waits for results wakes up: the other end is gone.


def _enter(
    pipe: Connection, memory_bytes: int, work: Callable[..., None], arguments: tuple[Any, ...]
) -> None:
    """Run in the child: give up what it must not have, then work."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _end_with_parent()
    if sys.platform == "linux":
        # Data, not address space: compiled code and mapped libraries reserve much that they never touch.
        resource.setrlimit(resource.RLIMIT_DATA, (memory_bytes, memory_bytes))
        with contextlib.suppress(OSError):
            Path("/proc/self/oom_score_adj").write_text("1000")
    work(lambda item: pipe.send((True, item)), *arguments)
    pipe.send((False, None))


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()

    def leave() -> None:
        if parent is not None:
            parent.join()
        os._exit(1)

    threading.Thread(target=leave, name="end-with-parent", daemon=True).start()


__all__ = ["Child", "ChildDied", "Emit", "prepare"]
