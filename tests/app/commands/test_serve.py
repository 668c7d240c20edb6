"""The start of the service."""

import gc
import os
import platform
import subprocess
import sys

import pytest

from app.commands.serve import ARENAS, imported_for_good


def test_imports_are_not_looked_through_and_the_collector_works_afterwards():
    frozen = gc.get_freeze_count()
    try:
        with imported_for_good():
            assert not gc.isenabled()
        assert gc.isenabled()
        assert gc.get_freeze_count() > frozen
        with pytest.raises(ImportError), imported_for_good():
            raise ImportError
        assert gc.isenabled()
    finally:
        gc.unfreeze()


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="arenas are glibc's")
def test_threads_share_where_they_take_memory_from():
    code = """
import ctypes, threading
{before}
libc = ctypes.CDLL(None)
libc.fdopen.restype = ctypes.c_void_p
all_there = threading.Barrier(8)
def take():
    libc.malloc(5000)
    all_there.wait()
threads = [threading.Thread(target=take) for _ in range(8)]
for one in threads: one.start()
for one in threads: one.join()
out = ctypes.c_void_p(libc.fdopen(1, b"w"))
libc.malloc_info(0, out)
libc.fflush(out)
"""

    def arenas(before: str) -> int:
        script = [sys.executable, "-c", code.replace("{before}", before)]
        said = {"MALLOC_ARENA_MAX", "GLIBC_TUNABLES"}
        environment = {name: value for name, value in os.environ.items() if name not in said}
        out = subprocess.run(script, check=True, capture_output=True, text=True, env=environment).stdout
        return out.count("<heap nr=")

    shared = "from app.commands.serve import share_arenas; share_arenas()"
    assert arenas("") > ARENAS
    assert arenas(shared) == ARENAS
