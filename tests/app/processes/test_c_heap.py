"""Memory of a process that lives for months."""

import os
import platform
import subprocess
import sys

import pytest

from app.processes.c_heap import ARENAS

pytestmark = pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="arenas and gaps are glibc's")


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

    shared = "from app.processes.c_heap import share_arenas; share_arenas()"
    assert arenas("") > ARENAS
    assert arenas(shared) == ARENAS


def test_what_lies_free_between_blocks_that_stay_is_given_back():
    code = """
import time
import psutil
from app.processes.c_heap import gives_back
process = psutil.Process()
resident = lambda: process.memory_info().rss
before = resident()
blocks = [bytearray(16_000) for _ in range(5000)]
filled = resident()
del blocks[: -1 : 2], blocks[: -1 : 2], blocks[: -1 : 2]
left = resident()
with gives_back(0.05):
    ends_s = time.monotonic() + 20.0
    while resident() - before > (filled - before) / 2 and time.monotonic() < ends_s:
        time.sleep(0.05)
    print((left - before) / (filled - before), (resident() - before) / (filled - before))
"""
    out = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout
    left, given_back = map(float, out.split())
    assert left > 0.9, "else this test shows nothing"
    assert given_back < 0.5
