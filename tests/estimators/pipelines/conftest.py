"""Simulated sessions with gaps, and the folder on the path so that contract classes can be inherited."""

import sys
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from estimators import signals
from estimators.recording import ImuChunk, SampleQuality
from estimators.simulation import ArmScenario, Schedule, SimulatedSession, simulate_arm

sys.path.insert(0, str(Path(__file__).parent))


@cache
def simulated(**changes) -> SimulatedSession:
    given = {"schedule": Schedule(n_pose_s=6.0, repetitions=2), "errors": "nominal", "seed": 3}
    return simulate_arm(ArmScenario(**{**given, **changes}))


def with_gaps(chunk: ImuChunk, seed: int = 0) -> ImuChunk:
    """Lose stretches of single sensors, short ones bridged and flagged, long ones missing, after 7 s."""
    generator = np.random.default_rng(seed)
    gyroscope, accelerometer = chunk.gyroscope_radps.copy(), chunk.accelerometer_mps2.copy()
    magnetometer = None if chunk.magnetometer_t is None else chunk.magnetometer_t.copy()
    quality = chunk.quality.copy()
    for sensor in range(chunk.sensor_count):
        start = int(generator.integers(700, chunk.tick_count - 120))
        lost = slice(start, start + int(generator.integers(25, 90)))
        for values in (gyroscope, accelerometer, magnetometer):
            if values is not None:
                values[sensor, lost] = np.nan
        quality[sensor, lost] |= np.uint8(SampleQuality.MISSING)
        start = int(generator.integers(700, chunk.tick_count - 120))
        quality[sensor, start : start + 12] |= np.uint8(SampleQuality.BRIDGED)
    return replace(
        chunk,
        gyroscope_radps=gyroscope,
        accelerometer_mps2=accelerometer,
        magnetometer_t=magnetometer,
        quality=quality,
    )


@pytest.fixture(scope="session")
def simulate():
    return simulated


@pytest.fixture(scope="session")
def gaps():
    return with_gaps


@pytest.fixture(scope="session")
def session() -> SimulatedSession:
    return simulated()


@pytest.fixture(scope="session")
def ticks(session) -> ImuChunk:
    return signals.to_common_ticks(session.recording, 100.0)
