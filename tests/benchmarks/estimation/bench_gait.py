"""What following feet costs: off-line by length of the walk, live by sensor and with load cells.

Run: `make bench-gait`, or `python -m tests.benchmarks.estimation.bench_gait` from the root. Ends with status 1 if a
limit is missed. Off-line the real loop of tests/data/feet is repeated end to end; live a simulated walk on two
instrumented shoes is. Processor time, so that other work on the machine counts little.
"""

import platform
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from estimators.conventions import SHOE_PLACEMENTS, SIDES, Placement
from estimators.gait import FootTracker, find_strides, smooth, summarise
from estimators.pipelines import SessionSetup, create
from estimators.pipelines.pooled import STRETCH
from estimators.pipelines.walk.pool import WalkPool
from estimators.recording import Float, ImuChunk, SensorSignals
from estimators.simulation import Bout, Leg, gait_preset, simulate_gait
from tests.benchmarks.machine import processor

FEET = Path(__file__).parents[2] / "data" / "feet"
RATE_HZ = 100.0
CHUNK_TICKS = 5
SESSIONS = 20
SHOES: tuple[Placement, ...] = SHOE_PLACEMENTS
FEET_WORN: tuple[Placement, ...] = ("foot_left", "foot_right")
LIVE_LIMIT, OFF_LINE_LIMIT_S, GROWTH_LIMIT = 0.01, 5.0, 1.5


def loop(minutes: float) -> SensorSignals:
    """Repeat the loop at 100 Hz; the joints are jumps of a foot at rest."""
    content = np.load(FEET / "xio_short_walk.npz")
    even = np.arange(0.0, content["time_s"][-1], 1.0 / RATE_HZ)
    parts = [
        np.stack([np.interp(even, content["time_s"], content[name][:, i]) for i in range(3)], axis=1)
        for name in ("gyroscope_radps", "accelerometer_mps2")
    ]
    samples = round(60.0 * minutes * RATE_HZ)
    gyroscope, force = (np.resize(part, (samples, 3)) for part in parts)
    return SensorSignals(np.arange(samples) / RATE_HZ, gyroscope, force)


def shoes() -> ImuChunk:
    """Walk about a minute on two instrumented shoes: inertial signals and loads of heel and forefoot."""
    scenario = replace(gait_preset("centre_of_mass"), rate_hz=RATE_HZ, course=(Bout((Leg(70),)),))
    sensors = simulate_gait(scenario).recording.sensors
    worn = [sensors[name] for name in SHOES]
    gyroscope = np.stack([sensor.gyroscope_radps for sensor in worn])
    return ImuChunk(
        0,
        1.0 / RATE_HZ,
        gyroscope,
        np.stack([sensor.accelerometer_mps2 for sensor in worn]),
        None,
        np.zeros(gyroscope.shape[:2], dtype=np.uint8),
        force_n=np.stack([sensor.force_n for sensor in worn if sensor.force_n is not None]),
        moment_nm=np.stack([sensor.moment_nm for sensor in worn if sensor.moment_nm is not None]),
    )


def spent_s(job: Callable[[], object]) -> float:
    """Return the processor time of a job, the least of three runs."""
    times = []
    for _ in range(3):
        begin = time.process_time()
        job()
        times.append(time.process_time() - begin)
    return min(times)


def follow(chunk: ImuChunk) -> None:
    """Follow all sensors as the service does, chunk by chunk."""
    tracker = FootTracker(chunk.sensor_count, chunk.time_step_s)
    for start in range(0, chunk.tick_count, CHUNK_TICKS):
        tracker.update(chunk.ticks(start, start + CHUNK_TICKS))


def pipeline(chunk: ImuChunk, names: tuple[Placement, ...]) -> None:
    """Run the gait pipeline of a session, chunk by chunk."""
    session = create(SessionSetup(pipeline="gait", placements=names, rate_hz=RATE_HZ, feet_apart_m=0.18))
    for start in range(0, chunk.tick_count, CHUNK_TICKS):
        session.step(chunk.ticks(start, start + CHUNK_TICKS))


class Turns:
    """The same walk of many sessions, as a pool takes it: a turn has a chunk of each."""

    def __init__(self, chunk: ImuChunk, names: tuple[Placement, ...]) -> None:
        self._setup = SessionSetup(pipeline="gait", placements=names, rate_hz=RATE_HZ, feet_apart_m=0.18)
        self._carried: dict[str, slice] = {}
        self._turns: list[tuple[NDArray[np.void], Float, NDArray[np.uint8], Float]] = []
        for start in range(0, chunk.tick_count, CHUNK_TICKS):
            part = chunk.ticks(start, min(start + CHUNK_TICKS, chunk.tick_count))
            signals = np.stack([part.gyroscope_radps, part.accelerometer_mps2]).ravel()
            quality, carried = np.ascontiguousarray(part.quality).ravel(), np.empty(0)
            if part.force_n is not None and part.moment_nm is not None:
                self._carried = {"force_n": slice(0, 3), "moment_nm": slice(3, 6)}
                carried = np.concatenate([part.force_n, part.moment_nm], axis=2).ravel()
            number, stretches = np.arange(SESSIONS), np.zeros(SESSIONS, dtype=STRETCH)
            stretches["slot"], stretches["first_tick"] = number, start
            stretches["ticks"], stretches["tick_at"] = part.tick_count, number * CHUNK_TICKS
            stretches["signals_at"], stretches["quality_at"] = number * len(signals), number * len(quality)
            many = (np.tile(values, SESSIONS) for values in (signals, quality, carried))
            self._turns.append((stretches, *many))

    def take(self) -> None:
        """Take all of them in a new pool."""
        sessions = [create(self._setup) for _ in range(SESSIONS)]
        pool = WalkPool(sessions[0], 2, SESSIONS, SESSIONS * CHUNK_TICKS, self._carried)
        for slot, session in enumerate(sessions):
            pool.join(slot, session)
        for stretches, *samples in self._turns:
            pool.step(stretches, SESSIONS, *samples)


def feet_only(chunk: ImuChunk) -> ImuChunk:
    """Leave one inertial sensor a foot."""
    rows = [0, 2]
    return replace(
        chunk,
        gyroscope_radps=chunk.gyroscope_radps[rows],
        accelerometer_mps2=chunk.accelerometer_mps2[rows],
        quality=chunk.quality[rows],
        force_n=None,
        moment_nm=None,
    )


def main() -> int:
    """Print the table; 1 when a limit is missed."""
    print(f"{processor()}, Python {platform.python_version()}")
    missed = 0
    smooth(loop(0.1))
    rates = []
    print("off-line, one foot at 100 Hz, there and back twice   processor s   of real time")
    for minutes in (1, 10, 100):
        signals = loop(minutes)
        spent = spent_s(lambda signals=signals: smooth(signals))
        rates.append(spent / minutes)
        print(f"  {minutes:>3} min {spent:52.2f} {spent / (0.6 * minutes):13.3f} %")
    growth = rates[2] / rates[0]
    missed += growth > GROWTH_LIMIT
    print(f"  a minute of 100 against a minute of 1: {growth:.2f} times (limit {GROWTH_LIMIT})")
    ten = loop(10)

    def both() -> None:
        summarise({side: find_strides(smooth(ten), side) for side in SIDES})

    spent = spent_s(both)
    missed += spent > OFF_LINE_LIMIT_S
    print(f"  10 min, both feet with strides and summary: {spent:.2f} s (limit {OFF_LINE_LIMIT_S:.0f} s)")
    chunk = shoes()
    feet = feet_only(chunk)
    length_s = chunk.tick_count * chunk.time_step_s
    print(f"live at 100 Hz in chunks of {CHUNK_TICKS}, {length_s:.0f} s of walking          of a core")
    for name, job, sessions in (
        ("four inertial sensors", lambda: follow(chunk), 1),
        ("gait pipeline, one sensor a foot", lambda: pipeline(feet, FEET_WORN), 1),
        (f"a session of {SESSIONS} in a pool, one sensor a foot", Turns(feet, FEET_WORN).take, SESSIONS),
        ("gait pipeline, two shoes: four inertial, four force", lambda: pipeline(chunk, SHOES), 1),
        (f"a session of {SESSIONS} in a pool, two shoes", Turns(chunk, SHOES).take, SESSIONS),
    ):
        share = spent_s(job) / length_s / sessions
        missed += share > LIVE_LIMIT
        print(f"  {name:<52} {100 * share:11.2f} %   (limit {100 * LIVE_LIMIT:.0f} %)")
    return min(missed, 1)


if __name__ == "__main__":
    sys.exit(main())
