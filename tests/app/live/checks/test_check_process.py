"""Checks of the first seconds run in a process of their own: niced, bounded, replaced, ended."""

import os
import resource
import signal
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.errors import Unavailable
from app.live.checks.plausibility import MEMORY_BYTES, NICENESS, CheckProcess, check, packed
from estimators.calibration import RecordingCheck
from estimators.recording import ImuChunk
from tests.patience import PATIENCE_S

NAMES = ("upper_arm_right", "forearm_right")
NOTHING = packed(RecordingCheck(NAMES))


@pytest.fixture(scope="module")
def in_g() -> ImuChunk:
    """Two sensors at rest, the second with an accelerometer in g."""
    generator = np.random.default_rng(5)
    force = np.zeros((2, 500, 3)) + [0.0, 0.0, 9.81] + 2e-2 * generator.normal(size=(2, 500, 3))
    force[1] /= 9.80665
    return ImuChunk(
        0, 0.01, 4e-3 * generator.normal(size=(2, 500, 3)), force, None, np.zeros((2, 500), np.uint8)
    )


@pytest.fixture(scope="module")
def process() -> Iterator[CheckProcess]:
    process = CheckProcess()
    yield process
    process.close()


def is_gone(pid: int) -> bool:
    deadline = time.monotonic() + PATIENCE_S
    while time.monotonic() < deadline:
        state = Path(f"/proc/{pid}/stat")
        if not state.exists() or state.read_text().rpartition(")")[2].split()[0] == "Z":
            return True
        time.sleep(0.02)
    return False


def test_it_finds_what_a_thread_finds_at_low_priority_without_sockets(
    process: CheckProcess, in_g: ImuChunk
) -> None:
    assert process.process_ids == [], "it costs nothing before the first check"
    found = process(NOTHING, in_g)
    assert found.findings == check(NOTHING, in_g).findings
    assert [finding.code for finding in found.findings] == ["accelerometer_unit"]
    assert found.cost_s > 0.0
    later = replace(in_g, first_tick=in_g.tick_count)
    assert process(found.known, later).findings == found.findings, "what was known is not forgotten"
    (pid,) = process.process_ids
    assert pid != os.getpid()
    assert os.getpriority(os.PRIO_PROCESS, pid) == min(19, os.getpriority(os.PRIO_PROCESS, 0) + NICENESS)
    assert resource.prlimit(pid, resource.RLIMIT_AS)[0] <= MEMORY_BYTES
    opened = [os.readlink(one) for one in Path(f"/proc/{pid}/fd").iterdir()]
    assert not [name for name in opened if name.startswith("socket:")]


def test_a_check_under_way_when_the_service_stops_has_not_failed(in_g: ImuChunk) -> None:
    process = CheckProcess()
    process(NOTHING, in_g)
    (pid,) = process.process_ids
    os.kill(pid, signal.SIGSTOP)
    with ThreadPoolExecutor(1) as thread:
        checking = thread.submit(process, NOTHING, in_g)
        while not checking.running():
            time.sleep(0.01)
        time.sleep(0.1)
        process.close()
        os.kill(pid, signal.SIGCONT)
        with pytest.raises(Unavailable):
            checking.result(PATIENCE_S)


def test_it_comes_back_when_it_has_died_and_ends_for_good(process: CheckProcess, in_g: ImuChunk) -> None:
    process(NOTHING, in_g)
    (first,) = process.process_ids
    os.kill(first, signal.SIGKILL)
    assert is_gone(first)
    with pytest.raises(BrokenProcessPool):
        process(NOTHING, in_g)
    assert process(NOTHING, in_g).findings
    (second,) = process.process_ids
    assert second != first
    process.close()
    assert is_gone(second)
    with pytest.raises(Unavailable):
        process(NOTHING, in_g)
