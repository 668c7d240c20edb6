"""How long it takes to compare ten minutes with 60 repetitions of both arms with a template, on one core.

Run: `python -m tests.benchmarks.bench_comparison` from the root. Ends with status 1 above `LIMIT_S`.
The movement is made, not estimated: what is timed is finding, aligning and measuring the repetitions.
"""

import argparse
import platform
import sys
import time
from dataclasses import replace
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np

from estimators.comparison import Trajectory, build_template, compare, mirror_trajectory
from tests.benchmarks.machine import processor
from tests.estimators.comparison.conftest import Planar, make_planar

LIMIT_S = 2.0
REPETITIONS = 60
ROUNDS = 3


def both_arms() -> tuple[Planar, Trajectory]:
    """Return the right arm as made, and both arms in one trajectory: the left one a mirror of the right."""
    right = make_planar(repetitions=REPETITIONS, out_s=2.5, hold_s=0.5, rest_s=4.5, noise_rad=0.002)
    left = mirror_trajectory(right.trajectory)
    own = [column for column, name in enumerate(left.channels) if "_left" in name]
    together = replace(
        right.trajectory,
        channels=(*right.trajectory.channels, *(left.channels[column] for column in own)),
        values=np.concatenate([right.trajectory.values, left.values[:, own]], axis=1),
        sigma=np.concatenate([right.trajectory.sigma, left.sigma[:, own]], axis=1),
        valid=np.concatenate([right.trajectory.valid, left.valid[:, own]], axis=1),
    )
    return right, together


def measure() -> list[float]:
    """Return how long each round took, s; the first compiles what is not in the cache."""
    right, together = both_arms()
    template = build_template(right.trajectory, right.truth[:5], "right", right.reach_m, right.primary)
    took = []
    for _ in range(ROUNDS + 1):
        begun = time.perf_counter()
        results = [compare(together, template, side, right.reach_m) for side in ("right", "left")]
        took.append(time.perf_counter() - begun)
        counts = [len(one.repetitions) for one in results]
        if counts != [REPETITIONS, REPETITIONS]:
            raise SystemExit(f"found {counts} repetitions instead of {REPETITIONS} in each arm")
    return took[1:]


def main() -> int:
    """Print the times beside the limit."""
    argparse.ArgumentParser(description=__doc__.splitlines()[0]).parse_args()
    took = measure()
    print(f"{platform.python_version()} on {processor()}")
    print(f"10 minutes, {REPETITIONS} repetitions, 2 arms: median {np.median(took):.2f} s of {LIMIT_S} s")
    print("rounds: " + ", ".join(f"{one:.2f} s" for one in took))
    return int(np.median(took) > LIMIT_S)


if __name__ == "__main__":
    sys.exit(main())
