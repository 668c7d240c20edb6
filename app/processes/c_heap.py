"""Memory that the C library holds for a process that lives for months."""

import ctypes
import os
import platform
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

_ARENA_MAX: Final = -8
"""`M_ARENA_MAX` of glibc's `malloc.h`."""
ARENAS: Final = 2
"""Of a process, unless whoever starts it says otherwise."""
GIVE_BACK_EVERY_S: Final = 60.0
_KEPT_BYTES: Final = 1 << 20
"""At the top of the heap: else the next block would ask the system at once."""


def share_arenas() -> None:
    """Let the C library's `malloc` have few arenas, where it is glibc's; before threads begin.

    Else most threads have one of their own, and what one of them has freed the others cannot use: a process that lives
    for months grows by the gaps in each.
    """
    is_said = "MALLOC_ARENA_MAX" in os.environ or "arena_max" in os.environ.get("GLIBC_TUNABLES", "")
    if _is_glibc() and not is_said:
        ctypes.CDLL(None).mallopt(_ARENA_MAX, ARENAS)


@contextmanager
def gives_back(every_s: float = GIVE_BACK_EVERY_S) -> Iterator[None]:
    """Give the machine what lies free in the C library's heap, now and then, as long as the context lasts.

    The stretches that are checked and stored are blocks of megabytes that live for a moment. Between what stays they
    leave gaps, which glibc keeps: after an hour of many sessions the process would hold what its worst moment needed.

    Parameters
    ----------
    every_s : float
        It takes milliseconds, tens on a busy machine. Its thread does not hold the interpreter; who asks for memory
        meanwhile may wait for it.
    """
    ended = threading.Event()

    def give_back() -> None:
        trim = ctypes.CDLL(None).malloc_trim
        while not ended.wait(every_s):
            trim(_KEPT_BYTES)

    if _is_glibc():
        threading.Thread(target=give_back, name="gives back memory", daemon=True).start()
    try:
        yield
    finally:
        ended.set()


def _is_glibc() -> bool:
    return platform.libc_ver()[0] == "glibc"
