"""Compiling what estimation needs before the first session, so that its first packet does not wait for it."""

import gc
import sys
from collections.abc import Iterator
from dataclasses import replace
from typing import Final

import numpy as np

from estimators import pipelines
from estimators.conventions import PLACEMENTS
from estimators.magnetic import coil_state
from estimators.pipelines import SessionSetup
from estimators.recording import ImuChunk

SWITCH_INTERVAL_S: Final = 5e-4


def warm_up() -> None:
    """Run the pipelines that live sessions use over moments of stillness, in a thread of the caller.

    The arm's calibrated and not; that of a magnetic source from its standstill through its first burst.
    """
    setup = SessionSetup(pipeline="arm", placements=PLACEMENTS, rate_hz=100.0)
    pipeline = pipelines.create(setup)
    for chunk in _still(len(PLACEMENTS), 400):
        pipeline.step(chunk)
    source = pipelines.create(SessionSetup("relative_pose", ("pelvis", "sternum"), 100.0))
    coil = 0
    for chunk in _still(2, 300):
        state = np.zeros((2, chunk.tick_count))
        state[0] = coil_state(coil, 1.3)
        frames = source.step(replace(chunk, coil_state=state))
        # What was asked for is fired in the next packet.
        coil = int(frames.scalar[:, frames.layout.scalars.index("source_ask_coil")].max())


def _still(sensors: int, ticks: int) -> Iterator[ImuChunk]:
    generator = np.random.default_rng(0)
    for start in range(0, ticks, 5):
        noise = 1e-3 * generator.standard_normal((3, sensors, 5, 3))
        yield ImuChunk(
            start,
            0.01,
            noise[0],
            noise[1] + np.array([0.0, 0.0, 9.81]),
            1e-3 * noise[2] + np.array([2e-5, 0.0, -4e-5]),
            np.zeros((sensors, 5), dtype=np.uint8),
        )


def prepare_process() -> None:
    """Set garbage collection and thread switching of this process for the live path.

    What was loaded at the start lives as long as the process: frozen, the collector does not walk it again.
    What live sessions make dies by reference counting; rarer collections of the rest are enough. Measured with
    50 sessions: the collector took half of the event loop's time, in pauses of a hundred milliseconds.

    Estimation releases the interpreter lock many times a packet. Each time a thread that encodes chunks may
    keep it for one switch interval; with the default of 5 ms that held the event loop up by tens of
    milliseconds.
    """
    gc.collect()
    gc.freeze()
    gc.set_threshold(20_000, 50, 1_000)
    sys.setswitchinterval(SWITCH_INTERVAL_S)
