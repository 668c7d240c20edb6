"""What following feet costs: off-line by length of the walk, and live by sensor.

Run with `python -m tests.benchmarks.bench_feet`. The real loop of tests/data/feet is repeated end to end.
"""

import time
from pathlib import Path

import numpy as np

from estimators.gait import FootTracker, smooth
from estimators.recording import ImuChunk, SensorSignals

FEET = Path(__file__).parents[1] / "data" / "feet"
RATE_HZ = 100.0


def walk(minutes: float) -> SensorSignals:
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


def main() -> None:
    """Print processor time."""
    smooth(walk(0.1))
    for minutes in (1, 10, 100):
        signals = walk(minutes)
        begin = time.process_time()
        smooth(signals)
        spent = time.process_time() - begin
        print(
            f"off-line, {minutes:>3} min at 100 Hz: {spent:7.2f} s, {60 * minutes / spent:6.0f} x real time"
        )
    signals = walk(1)
    tracker = FootTracker(4, 1.0 / RATE_HZ)
    shape = (4, *signals.gyroscope_radps.shape)
    chunk = ImuChunk(
        0,
        1.0 / RATE_HZ,
        np.ascontiguousarray(np.broadcast_to(signals.gyroscope_radps, shape)),
        np.ascontiguousarray(np.broadcast_to(signals.accelerometer_mps2, shape)),
        None,
        np.zeros(shape[:2], dtype=np.uint8),
    )
    begin = time.process_time()
    for start in range(0, chunk.tick_count, 10):
        tracker.update(chunk.ticks(start, start + 10))
    share = (time.process_time() - begin) / 60.0
    print(f"live, 4 sensors at 100 Hz in chunks of 10: {100 * share:.2f} % of a core")


if __name__ == "__main__":
    main()
