"""The service opens before everything is compiled; sessions of a kind that is not ready wait, and nobody else."""

import asyncio
import contextlib
import subprocess
import sys
import threading
import time

import psutil
import pytest

from app.errors import Unavailable
from app.live import warmup
from app.live.warmup import ENGINE, FIRST, GUIDANCE, Kind, Readiness, code_of, usual
from estimators.pipelines import SessionSetup
from tests.benchmarks.crash import is_alive
from tests.patience import PATIENCE_S

ARM = SessionSetup("arm", ("sternum", "upper_arm_right", "forearm_right"), 100.0)
GAIT = SessionSetup("gait", ("foot_left", "foot_right"), 100.0)
OTHER = SessionSetup("arm", ("sternum", "upper_arm_right"), 100.0, orientation="vqf")


class Held:
    """Prepares a kind when it is let go."""

    def __init__(self) -> None:
        self.begun: list[Kind] = []
        self.may_end: dict[Kind, threading.Event] = {}

    def __call__(self, kind: Kind) -> None:
        self.begun.append(kind)
        self.gate(kind).wait(PATIENCE_S)

    def gate(self, kind: Kind) -> threading.Event:
        return self.may_end.setdefault(kind, threading.Event())


async def ready_for(ready: Readiness, setup: SessionSetup) -> None:
    while not ready.is_ready(setup):
        with contextlib.suppress(Unavailable):
            await ready.require(setup)


def test_a_session_waits_for_its_own_kind_only(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(warmup, "PATIENCE_S", 0.05)
    held = Held()

    async def story() -> None:
        ready = Readiness(held)
        await ready.begin()
        with pytest.raises(Unavailable, match="prepared") as refused:
            await ready.require(ARM)
        assert refused.value.details["reason"] == "preparing"
        assert not ready.is_ready(ARM)
        # Another estimator is begun at once, not after the usual kinds.
        held.gate(code_of(OTHER)).set()
        await ready.require(OTHER)
        held.gate(FIRST).set()
        await ready_for(ready, ARM)
        with pytest.raises(Unavailable):
            await ready.require(GAIT)
        for kind in usual():
            held.gate(kind).set()
        await ready_for(ready, GAIT)
        ready.end()

    asyncio.run(story())
    assert held.begun[0] == FIRST
    assert len(held.begun) == len(set(held.begun))


def test_only_who_is_guided_waits_for_guidance(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(warmup, "PATIENCE_S", 0.05)
    held = Held()
    held.gate(FIRST).set()

    async def story() -> None:
        ready = Readiness(held)
        await ready.begin()
        await ready.require(ARM)
        assert not ready.is_guiding
        with pytest.raises(Unavailable, match="prepared"):
            await ready.require_guidance()
        held.gate(GUIDANCE).set()
        while not ready.is_guiding:
            with contextlib.suppress(Unavailable):
                await ready.require_guidance()
        for kind in usual():
            held.gate(kind).set()
        ready.end()

    asyncio.run(story())
    assert held.begun[:3] == [FIRST, ENGINE, GUIDANCE]


def test_nobody_waits_for_what_takes_many_sessions_together(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(warmup, "PATIENCE_S", 0.05)
    held = Held()
    held.gate(FIRST).set()

    async def story() -> None:
        ready = Readiness(held)
        assert not ready.is_preparing_engine, (
            "where nothing is prepared what is missing is loaded at its first use"
        )
        await ready.begin()
        await ready.require(ARM)
        assert ready.is_preparing_engine
        for kind in usual():
            held.gate(kind).set()
        await ready.usual_ready()
        assert not ready.is_preparing_engine
        ready.end()

    asyncio.run(story())


def test_others_wait_for_those_who_come_back_unless_somebody_asks() -> None:
    held = Held()
    for kind in usual():
        held.gate(kind).set()

    async def story() -> None:
        ready = Readiness(held)
        await ready.begin(others_after_s=PATIENCE_S)
        await ready_for(ready, ARM)
        await asyncio.sleep(0.05)
        assert held.begun == [FIRST, ENGINE]
        await ready_for(ready, GAIT)
        assert held.begun == [FIRST, ENGINE, code_of(GAIT)]
        ready.end()
        again = Readiness(held)
        await again.begin(others_after_s=0.01)
        await again.usual_ready()
        assert all(map(again.is_ready, (ARM, GAIT)))

    asyncio.run(story())
    assert held.begun[3:] == usual()


def test_what_cannot_be_prepared_speaks_for_itself_later(monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(kind: Kind) -> None:
        raise RuntimeError("broken")

    async def story() -> None:
        ready = Readiness(fails)
        await ready.begin()
        await ready.require(ARM)
        ready.end()

    asyncio.run(story())


COUNT = """
from dataclasses import replace

from app.live.warmup import ENGINE, FIRST, warm_up
from estimators import pipelines, signals
from estimators.compiling import Kernel
from estimators.simulation import demonstration_scenario, simulate_arm

def ready():
    return {f"{one.py_func.__module__}.{one.py_func.__name__}" for one in Kernel.made if one.overloads}

warm_up(FIRST)
before = ready()
made = simulate_arm(demonstration_scenario("mild_stroke", "reaching", repetitions=1))
setup = replace(made.setup, calibration=None)
pipeline = pipelines.create(setup)
worn = replace(made.recording, sensors={name: made.recording.sensors[name] for name in setup.placements})
chunk = signals.to_common_ticks(worn, setup.rate_hz)
for start in range(0, 600, 5):
    pipeline.step(chunk.ticks(start, start + 5))
pipeline.calibrate(chunk.ticks(300, 600))
for start in range(600, chunk.tick_count, 5):
    pipeline.step(chunk.ticks(start, min(start + 5, chunk.tick_count)))
rest = sorted(ready() - before)
warm_up(ENGINE)
print(len(ready()), rest)
"""

MOST_KERNELS = 16
"""15 when this was written, of 78."""


@pytest.mark.slow
def test_a_live_arm_needs_few_kernels_and_no_more_once_it_streams() -> None:
    done = subprocess.run([sys.executable, "-c", COUNT], capture_output=True, text=True, check=True)
    count, rest = done.stdout.strip().split(" ", 1)
    assert rest == "[]"
    assert int(count) <= MOST_KERNELS


def test_what_compiles_ends_with_the_service_that_is_killed() -> None:
    child = (
        "from app.live import warmup; import time; warmup._end_with_parent();"
        "print('on', flush=True); time.sleep(60)"
    )
    parent = (
        "import subprocess, sys, time;"
        f"made = subprocess.Popen([sys.executable, '-c', {child!r}]); print(made.pid, flush=True); time.sleep(60)"
    )
    with subprocess.Popen([sys.executable, "-c", parent], stdout=subprocess.PIPE, text=True) as service:
        assert service.stdout is not None
        compiling = psutil.Process(int(service.stdout.readline()))
        assert service.stdout.readline() == "on\n"
        service.kill()
        until = time.monotonic() + PATIENCE_S
        while is_alive(compiling) and time.monotonic() < until:
            time.sleep(0.1)
        is_left = is_alive(compiling)
    assert not is_left
