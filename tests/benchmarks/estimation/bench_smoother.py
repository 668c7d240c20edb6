"""How much faster than real time our smoother is, one core: `python -m tests.benchmarks.estimation.bench_smoother`.

Seventeen sensors at 100 Hz, two simulated arms repeated to that number. Exit code 1 below 100 times real time.
"""

import resource
import sys
import time

import numpy as np

from estimators import orientation, signals
from estimators.recording import ImuChunk
from estimators.simulation import ArmScenario, Schedule, simulate_arm

SENSORS, REQUIRED = 17, 100.0


def network(duration_s: float) -> ImuChunk:
    """Return a chunk of 17 sensors on moving arms, among magnetic errors of an ordinary room."""
    schedule = Schedule(duration_s=duration_s, repetitions=None)
    session = simulate_arm(ArmScenario(both_arms=True, schedule=schedule, seed=1))
    chunk = signals.to_common_ticks(session.recording, 100.0)
    rows = np.arange(SENSORS) % chunk.sensor_count
    field = chunk.magnetometer_t
    return ImuChunk(
        0,
        chunk.time_step_s,
        chunk.gyroscope_radps[rows],
        chunk.accelerometer_mps2[rows],
        None if field is None else field[rows],
        chunk.quality[rows],
    )


def main(duration_s: float = 300.0) -> int:
    """Measure and print; return the exit code."""
    chunk = network(duration_s)
    orientation.smooth("telemotion_smoother", chunk.ticks(0, 500))
    before = time.process_time()
    orientation.smooth("telemotion_smoother", chunk)
    spent_s = time.process_time() - before
    times = chunk.tick_count * chunk.time_step_s / spent_s
    peak_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(
        f"{SENSORS} sensors, {duration_s:.0f} s at 100 Hz: {spent_s:.2f} s of one core, {times:.0f} times real time"
    )
    print(f"required {REQUIRED:.0f}; largest memory of the process {peak_mb:.0f} MB")
    return 0 if times >= REQUIRED else 1


if __name__ == "__main__":
    sys.exit(main(float(sys.argv[1]) if len(sys.argv) > 1 else 300.0))
