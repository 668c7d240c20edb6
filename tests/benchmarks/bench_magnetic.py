"""Cost of relative pose by a magnetic source on one core: fields a second, and a live session at 120 Hz.

Run: `python -m tests.benchmarks.bench_magnetic` from the root, or `make bench-magnetic`.
Ends with status 1 if field and gradient of a coil are evaluated less often than `REQUIRED_FIELDS` a second, or if a
session at 120 Hz, tick by tick as it arrives, takes more than `REQUIRED_SHARE` of a core. Times are those of the
processor, best of several runs.
"""

import argparse
import platform
import sys
import time
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np

from estimators.magnetic import RelativeChunk, RelativePoseFilter, perpendicular_source, predict
from estimators.magnetic import _loop_kernel as kernel
from estimators.magnetic import _relative_layout as at
from estimators.simulation.coils import relative_motion, relative_scene, run_closed_loop

REQUIRED_FIELDS = 1e6
REQUIRED_SHARE = 0.01
POINTS, SECONDS, RATE_HZ = 100_000, 20.0, 120.0


def best(call: Callable[[], object], repetitions: int) -> float:
    """Return the least processor time of a call."""
    times = []
    for _ in range(repetitions):
        begin = time.process_time()
        call()
        times.append(time.process_time() - begin)
    return min(times)


def field_rates(repetitions: int) -> dict[str, float]:
    """Return evaluations a second: field and gradient of a loop, and prediction of a pulse with its Jacobian."""
    rng = np.random.default_rng(1)
    direction = rng.normal(size=(POINTS, 3))
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    points = np.ascontiguousarray(direction * rng.uniform(0.15, 0.8, (POINTS, 1)))
    q = rng.normal(size=(POINTS, 4))
    q /= np.linalg.norm(q, axis=1)[:, None]
    coil, current = np.arange(POINTS) % 3, np.ones(POINTS)
    rates = {}
    for name, source in (
        ("exact loop", perpendicular_source(0.06)),
        ("dipole", perpendicular_source(0.06).with_model("dipole")),
    ):
        field, gradient = np.empty((POINTS, 3)), np.empty((POINTS, 3, 3))
        loops = source.loops
        spent = best(lambda: kernel.coil_fields(loops, coil, current, points, field, gradient), repetitions)  # noqa: B023
        rates[f"{name}, field and gradient"] = POINTS / spent
    source = perpendicular_source(0.06)
    spent = best(lambda: predict(source, coil, current, points, q), repetitions)
    rates["exact loop, pulse and Jacobian in sensor axes"] = POINTS / spent
    return rates


def session_shares(repetitions: int) -> dict[str, float]:
    """Return shares of a core that a session takes, tick by tick and in packets of ten ticks."""
    source = perpendicular_source(0.06)
    scene = relative_scene(source, relative_motion("walk_leg", SECONDS, 1), SECONDS, RATE_HZ, seed=1)
    parameters = {"mounting_direction": tuple(scene.position_m[0].tolist())}
    _, samples = run_closed_loop(scene, RelativePoseFilter(source, scene.time_step_s, parameters), seed=1)
    whole = RelativeChunk(
        0,
        scene.time_step_s,
        samples[:, at.GYROSCOPE : at.GYROSCOPE + 3],
        samples[:, at.ACCELEROMETER : at.ACCELEROMETER + 3],
        samples[:, at.FIELD : at.FIELD + 3],
        samples[:, at.SOURCE_GYROSCOPE : at.SOURCE_GYROSCOPE + 3],
        samples[:, at.SOURCE_ACCELEROMETER : at.SOURCE_ACCELEROMETER + 3],
        samples[:, at.COIL].astype(np.int64),
        samples[:, at.CURRENT],
    )
    count = whole.tick_count

    def session(step: int) -> None:
        relative = RelativePoseFilter(source, scene.time_step_s, parameters)
        for start in range(0, count, step):
            relative.update(whole.ticks(start, min(count, start + step)))

    return {
        "a session, tick by tick": best(lambda: session(1), repetitions) / SECONDS,
        "a session, packets of 10 ticks": best(lambda: session(10), repetitions) / SECONDS,
    }


def main() -> int:
    """Print both tables; return 1 if a limit is missed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repetitions", type=int, default=5)
    repetitions = parser.parse_args().repetitions
    print(f"{platform.processor() or platform.machine()}, Python {platform.python_version()}, one core")
    rates, shares = field_rates(repetitions), session_shares(repetitions)
    print(f"\n{'fields':<48} {'1/s':>12} {'required':>12}")
    for name, rate in rates.items():
        required = f"{REQUIRED_FIELDS:,.0f}" if "gradient" in name else "-"
        print(f"{name:<48} {rate:>12,.0f} {required:>12}")
    print(f"\n{f'relative pose at {RATE_HZ:.0f} Hz':<48} {'% of a core':>12} {'required':>12}")
    for name, share in shares.items():
        required = f"<= {100 * REQUIRED_SHARE:.0f}" if "tick by tick" in name else "-"
        print(f"{name:<48} {100 * share:>12.2f} {required:>12}")
    kept = min(rate for name, rate in rates.items() if "gradient" in name) >= REQUIRED_FIELDS
    return 0 if kept and shares["a session, tick by tick"] <= REQUIRED_SHARE else 1


if __name__ == "__main__":
    sys.exit(main())
