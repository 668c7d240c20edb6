"""What is not known about the mounting is in the sigma of segments and joint angles."""

from dataclasses import replace

import numpy as np
import pytest

from estimators import rotation, signals
from estimators.pipelines import SessionSetup, create
from estimators.simulation import ArmScenario, Schedule, simulate_arm

PLACEMENTS = ("sternum", "upper_arm_right", "forearm_right")
MOUNTING = (0.01, 0.02, 0.1)
UNUSABLE = 1 | 4 | 128
"""INVALID, CONVERGING, SINGULAR."""


def test_sigma_of_the_mounting_is_added_in_the_room(session, ticks):
    first = create(session.setup)
    first.step(ticks.ticks(0, 600))
    known = replace(first.calibrate(ticks.ticks(300, 600)), mounting_sigma_rad={})
    doubted = replace(known, mounting_sigma_rad={"upper_arm_right": MOUNTING})
    assert (
        SessionSetup.from_dict(replace(session.setup, calibration=doubted).to_dict()).calibration == doubted
    )
    plain, more = (
        create(replace(session.setup, calibration=found)).step(ticks.ticks(0, 900))
        for found in (known, doubted)
    )
    s = session.setup.placements.index("upper_arm_right")
    added = more.segment_sigma_rad[:, s] ** 2 - plain.segment_sigma_rad[:, s] ** 2
    turn = rotation.to_matrix(plain.q_room_segment[:, s])
    np.testing.assert_allclose(added, np.einsum("kij,j->ki", turn**2, np.square(MOUNTING)), atol=1e-10)
    pronation = plain.layout.angles.index("humerus_forearm_right_zxy_pronation")
    # In the pose the arm hangs: the turn of the upper arm about itself is the forearm's.
    apart = more.angle_sigma_rad[400, pronation] ** 2 - plain.angle_sigma_rad[400, pronation] ** 2
    assert apart > 0.5 * MOUNTING[2] ** 2


@pytest.mark.slow
@pytest.mark.parametrize(("has_magnetometer", "least"), [(True, 0.85), (False, 0.8)])
def test_joint_angles_lie_within_their_sigma(has_magnetometer, least):
    """Sensors put on by hand, one standing pose: 1.96 sigma of an angle must hold most of its errors."""
    inside = {}
    for seed, exercise in enumerate(("drinking", "abduction", "flexion", "reaching", "pronation")):
        session = simulate_arm(
            ArmScenario(
                exercise=exercise,
                placements=PLACEMENTS,
                schedule=Schedule(n_pose_s=6.0, repetitions=2),
                seed=seed,
                has_magnetometer=has_magnetometer,
            )
        )
        chunk = signals.to_common_ticks(session.recording, 100.0)
        pipeline = create(session.setup)
        pipeline.step(chunk.ticks(0, 500))
        pipeline.calibrate(chunk.ticks(200, 500))
        frames = pipeline.step(chunk.ticks(500, chunk.tick_count))
        truth = session.truth.frames
        for column, name in enumerate(frames.layout.angles):
            exact = truth.angle_rad[500 : 500 + frames.tick_count, truth.layout.angles.index(name)]
            error = np.remainder(frames.angle_rad[:, column] - exact + np.pi, 2.0 * np.pi) - np.pi
            sound = ((frames.angle_flags[:, column] & UNUSABLE) == 0) & np.isfinite(error)
            inside.setdefault(name, []).append(
                np.abs(error[sound]) < 1.96 * frames.angle_sigma_rad[sound, column]
            )
    for name, parts in inside.items():
        assert np.concatenate(parts).mean() >= least, name
