"""A service that is killed leaves no worker behind that would write on."""

import multiprocessing
import os
import signal
import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing.connection import Connection

import pytest

from app.recordings.jobs import _start_worker


def worker_id() -> tuple[int, int]:
    return os.getpid(), os.nice(0)


def sleep_long() -> None:
    time.sleep(120)


def service(pipe: Connection) -> None:
    """A process with a busy worker, as the service has one."""
    pool = ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn"), initializer=_start_worker)
    pipe.send((worker_id(), pool.submit(worker_id).result()))
    pool.submit(sleep_long)
    time.sleep(120)


def is_alive(process_id: int) -> bool:
    try:
        with open(f"/proc/{process_id}/stat") as file:
            return file.read().rsplit(")", 1)[1].split()[0] != "Z"
    except FileNotFoundError:
        return False


@pytest.mark.slow
@pytest.mark.skipif(not os.path.isdir("/proc/self"), reason="reads /proc to see whether the worker lives")
def test_the_worker_dies_with_a_killed_service() -> None:
    here, there = multiprocessing.Pipe()
    process = multiprocessing.get_context("spawn").Process(target=service, args=(there,))
    process.start()
    assert here.poll(120)
    (_, parent_nice), (worker, worker_nice) = here.recv()
    assert worker_nice >= min(19, parent_nice + 10)
    assert is_alive(worker)
    os.kill(process.pid, signal.SIGKILL)
    process.join()
    deadline = time.monotonic() + 20
    while is_alive(worker) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not is_alive(worker)
    here.close()
    there.close()
