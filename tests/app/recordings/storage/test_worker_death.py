"""A service that is killed leaves no child behind that would write on; a child cannot take the machine's memory."""

import multiprocessing
import os
import signal
import time
from multiprocessing.connection import Connection

import pytest

from app import processes
from app.processes import Child, ChildDied, Emit
from tests.patience import PATIENCE_S

MEMORY_BYTES = 2 << 30


def about_itself(emit: Emit) -> None:
    emit((os.getpid(), os.nice(0)))
    time.sleep(120)


def service(pipe: Connection) -> None:
    """A process with a busy child, as the service has one."""
    results = Child(about_itself, memory_bytes=MEMORY_BYTES, name="busy").results()
    pipe.send((os.nice(0), next(results)))
    time.sleep(120)


def is_alive(process_id: int) -> bool:
    try:
        with open(f"/proc/{process_id}/stat") as file:
            return file.read().rsplit(")", 1)[1].split()[0] != "Z"
    except FileNotFoundError:
        return False


@pytest.mark.slow
@pytest.mark.skipif(not os.path.isdir("/proc/self"), reason="reads /proc to see whether the child lives")
def test_the_worker_dies_with_a_killed_service() -> None:
    here, there = multiprocessing.Pipe()
    process = multiprocessing.get_context("spawn").Process(target=service, args=(there,))
    process.start()
    assert here.poll(120)
    parent_nice, (child, child_nice) = here.recv()
    assert child_nice >= min(19, parent_nice + 10)
    assert is_alive(child)
    os.kill(process.pid, signal.SIGKILL)
    process.join()
    deadline = time.monotonic() + PATIENCE_S
    while is_alive(child) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not is_alive(child)
    here.close()
    there.close()


def greedy(emit: Emit) -> None:
    try:
        emit(len(bytearray(MEMORY_BYTES)))
    except MemoryError:
        emit("refused")


def crash(emit: Emit) -> None:
    emit("first")
    os._exit(9)


def test_a_child_gets_so_much_memory_and_no_more() -> None:
    processes.prepare()
    assert list(Child(greedy, memory_bytes=MEMORY_BYTES, name="greedy").results()) == ["refused"]


def test_a_child_that_dies_is_noticed() -> None:
    results = Child(crash, memory_bytes=MEMORY_BYTES, name="crash").results()
    assert next(results) == "first"
    with pytest.raises(ChildDied):
        next(results)
