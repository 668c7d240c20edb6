"""Rate of the orientation estimators beside the `vqf` package, in one run on one core.

Run: `python -m tests.benchmarks.estimation.bench_kernels` from the root.
Ends with status 1 if one takes more than `LIMIT` times what the package takes for a sensor sample in batch.
Published filters are to reach `PUBLISHED_RATE` times the samples a second of the package, and our own filter as many;
what each reaches is printed beside that and decides nothing.
The chunk column is the live case: seventeen nine-axis sensors, five ticks a call.
"""

import argparse
import platform
import sys
import time
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))

import numpy as np
from vqf import VQF

from estimators import orientation, rotation
from estimators.conventions import GRAVITY_MPS2
from estimators.recording import ImuChunk
from tests.benchmarks.machine import processor

SENSORS = 17
TICKS = 6000
CHUNK_TICKS = 5
STEP_S = 0.01
LIMIT = 2.0
PUBLISHED_RATE = 0.6
OWN_RATE = 1.0
OWN = "telemotion"
YARDSTICK = "vqf"
"""Our form of the package's own method, of whose rate nothing more is asked."""


def network(*, consistent: bool = False) -> ImuChunk:
    """Seventeen sensors that turn and shake all the time.

    Gravity and field do not turn with them, which no sensor measures: filters are kept in their rarer branches. With
    `consistent` they do.
    """
    rng = np.random.default_rng(1)
    shape = (SENSORS, TICKS, 3)
    time_s = np.arange(TICKS)[:, None] * STEP_S
    rate = rng.uniform(0.5, 2.0, (SENSORS, 1, 3)) * np.sin(time_s * rng.uniform(1.0, 4.0, (SENSORS, 1, 3)))
    gravity, earth_field = np.array([0.0, 0.0, GRAVITY_MPS2]), np.array([0.0, 20e-6, -45e-6])
    if consistent:
        back = np.empty((SENSORS, TICKS, 4))
        back[:, 0] = (1.0, 0.0, 0.0, 0.0)
        turns = rotation.exp(-rate * STEP_S)
        for k in range(1, TICKS):
            back[:, k] = rotation.multiply(turns[:, k], back[:, k - 1])
        gravity, earth_field = rotation.rotate(back, gravity), rotation.rotate(back, earth_field)
    force = gravity + 0.5 * rng.standard_normal(shape)
    field = earth_field + 0.5e-6 * rng.standard_normal(shape)
    return ImuChunk(0, STEP_S, rate, force, field, np.zeros(shape[:2], dtype=np.uint8))


def package_batch(chunk: ImuChunk) -> None:
    """The yardstick: every sensor in one call of the package, units converted beforehand."""
    assert chunk.magnetometer_t is not None
    for s in range(SENSORS):
        VQF(STEP_S).updateBatch(
            chunk.gyroscope_radps[s], chunk.accelerometer_mps2[s], chunk.magnetometer_t[s]
        )


def batch(name: str) -> Callable[[ImuChunk], None]:
    """All ticks of all sensors in one call."""
    return lambda chunk: _ignore(orientation.create(name, SENSORS, STEP_S).update(chunk))


def in_chunks(name: str) -> Callable[[ImuChunk], None]:
    """As a live session calls it."""

    def run(chunk: ImuChunk) -> None:
        estimator = orientation.create(name, SENSORS, STEP_S)
        for start in range(0, TICKS, CHUNK_TICKS):
            estimator.update(chunk.ticks(start, start + CHUNK_TICKS))

    return run


def _ignore(_: object) -> None:
    return None


def main() -> int:
    """Measure processor time in turns, so that a busy machine slows all alike; keep the best of each."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--consistent", action="store_true", help="gravity and field turn with the sensors")
    given = parser.parse_args()
    rounds = given.rounds
    chunk = network(consistent=given.consistent)
    runs: dict[str, Callable[[ImuChunk], None]] = {"vqf package, batch": package_batch}
    for name in orientation.available():
        runs[f"{name}, batch"] = batch(name)
        runs[f"{name}, {SENSORS} x {CHUNK_TICKS} chunks"] = in_chunks(name)
    best = dict.fromkeys(runs, float("inf"))
    for _ in range(rounds):
        for label, run in runs.items():
            start = time.thread_time()
            run(chunk)
            best[label] = min(best[label], time.thread_time() - start)
    samples = SENSORS * TICKS
    yardstick = best["vqf package, batch"]
    print(f"machine: {processor()}, Python {platform.python_version()}, one core, best of {rounds} rounds")
    print(f"{'':44}{'ns / sample':>12}{'samples / s':>14}{'cost':>8}{'us / chunk':>12}")
    failed = []
    for label, seconds in best.items():
        ratio = seconds / yardstick
        per_chunk = f"{1e6 * seconds * CHUNK_TICKS / TICKS:12.0f}" if label.endswith("chunks") else ""
        print(f"{label:44}{1e9 * seconds / samples:12.0f}{samples / seconds:14.0f}{ratio:8.2f}{per_chunk}")
        if label.endswith("batch") and ratio > LIMIT:
            failed.append(label)
    print(
        f"required: batch within {LIMIT:g} times the package: " + (f"missed by {failed}" if failed else "met")
    )
    _tell_rates(best, yardstick)
    return 1 if failed else 0


def _tell_rates(best: dict[str, float], yardstick: float) -> None:
    """Print what is asked of the rate of each filter in batch beside what it reaches."""
    print(
        "rate in batch, times the samples a second of the package (above 1 is faster than it):"
        f" wanted of published filters {PUBLISHED_RATE:g}, of our own {OWN_RATE:g}"
    )
    for name in orientation.available():
        wanted = OWN_RATE if name == OWN else PUBLISHED_RATE
        if name != YARDSTICK:
            reached = yardstick / best[f"{name}, batch"]
            verdict = "reached" if reached >= wanted else "NOT reached"
            print(f"  {name:30} wanted {wanted:4.2f}   ours {reached:4.2f}   {verdict}")


if __name__ == "__main__":
    sys.exit(main())
