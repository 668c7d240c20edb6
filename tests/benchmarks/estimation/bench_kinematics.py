"""Rate of the arm's kinematics on one core: poses a second by each method, in one run.

Run: `python -m tests.benchmarks.estimation.bench_kinematics` from the root.
Ends with status 1 if forward kinematics by any of the methods makes fewer than `REQUIRED` poses a second.
A pose is elbow and wrist, position and orientation, of one arm at one instant; of `our arm` also the hand. The
last rows are what else a tick costs: joint angles back, and the whole live model of trunk and both arms.
"""

import argparse
import platform
import sys
import time
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))

import numpy as np

from estimators import rotation
from estimators.arm import ArmModel, BodyDimensions
from estimators.arm.published import (
    arm_chain,
    chain_dual_quaternions,
    chain_screw_axes,
    chain_transforms,
    check_chain,
    check_joints,
    five_joint_chain,
    joint_centres,
    two_link_joint_angles,
    two_link_pose,
)
from estimators.conventions import Placement
from tests.benchmarks.machine import processor

POSES = 100_000
REQUIRED = 2e6
UPPER_ARM_M, FOREARM_M = 0.30, 0.25
ONE_ARM: tuple[Placement, ...] = ("sternum", "upper_arm_right", "forearm_right")
SEVEN: tuple[Placement, ...] = (
    "sternum",
    "upper_arm_left",
    "forearm_left",
    "hand_left",
    "upper_arm_right",
    "forearm_right",
    "hand_right",
)


def runs() -> tuple[dict[str, Callable[[], object]], dict[str, Callable[[], object]]]:
    """Return forward kinematics, which must keep the limit, and the rest."""
    rng = np.random.default_rng(1)
    q1, q2 = rotation.normalize(rng.normal(size=(2, POSES, 4)))
    five, six = five_joint_chain(UPPER_ARM_M, FOREARM_M), check_chain(UPPER_ARM_M, FOREARM_M)
    five_joints = np.concatenate(
        (two_link_joint_angles(q1, q2)[0], np.full((POSES, 1), -0.5 * np.pi)), axis=1
    )
    six_joints = check_joints(q1, q2)
    body = BodyDimensions()
    ours, joints = arm_chain(body, "right"), rng.uniform(-2, 2, (POSES, 9))
    walk = np.cumsum(rng.normal(0, 0.05, (POSES, 7, 3)), axis=0)
    q = rotation.exp(walk)
    sigma, rate = np.full((POSES, 7, 3), 0.02), np.ones((POSES, 7, 3))
    one, seven = ArmModel(body, ONE_ARM, 0.01), ArmModel(body, SEVEN, 0.01)
    three = np.ascontiguousarray(q[:, :3])
    named = {name: np.ascontiguousarray(q[:, i]) for i, name in enumerate(SEVEN)}
    forward: dict[str, Callable[[], object]] = {
        "transforms of two modules": lambda: two_link_pose(q1, q2, UPPER_ARM_M, FOREARM_M),
        "Denavit-Hartenberg, five joints": lambda: chain_transforms(five, five_joints, (3, 6)),
        "Denavit-Hartenberg, six joints": lambda: chain_transforms(six, six_joints, (3, 6)),
        "dual quaternions, six joints": lambda: chain_dual_quaternions(six, six_joints, (3, 6)),
        "vector form, six joints": lambda: chain_screw_axes(six, six_joints, (3, 6)),
        "our arm, nine joints, matrices": lambda: chain_transforms(ours, joints, (3, 6, 9)),
        "our arm, nine joints, dual quaternions": lambda: chain_dual_quaternions(ours, joints, (3, 6, 9)),
    }
    rest: dict[str, Callable[[], object]] = {
        "five joint angles back (numpy)": lambda: two_link_joint_angles(q1, q2),
        "trunk and both arms, transforms (numpy)": lambda: joint_centres(named, body),
        "live model, trunk and one arm": lambda: one.evaluate(three, sigma_room_rad=sigma[:, :3]),
        "live model, trunk and both arms, hands": lambda: seven.evaluate(
            q, angular_velocity_room_radps=rate, sigma_room_rad=sigma
        ),
    }
    return forward, rest


def main() -> int:
    """Measure processor time in turns, so that a busy machine slows all alike; keep the best of each."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--rounds", type=int, default=7)
    rounds = parser.parse_args().rounds
    forward, rest = runs()
    best = dict.fromkeys((*forward, *rest), float("inf"))
    for _ in range(rounds):
        for label, run in (forward | rest).items():
            start = time.thread_time()
            run()
            best[label] = min(best[label], time.thread_time() - start)
    print(f"machine: {processor()}, Python {platform.python_version()}, one core, best of {rounds} rounds")
    print(f"{'':44}{'ns / pose':>12}{'million / s':>14}")
    for label, seconds in best.items():
        print(f"{label:44}{1e9 * seconds / POSES:12.0f}{1e-6 * POSES / seconds:14.2f}")
    slow = [label for label in forward if POSES / best[label] < REQUIRED]
    print(f"required: {REQUIRED:.0f} forward poses a second: " + (f"missed by {slow}" if slow else "met"))
    return 1 if slow else 0


if __name__ == "__main__":
    sys.exit(main())
