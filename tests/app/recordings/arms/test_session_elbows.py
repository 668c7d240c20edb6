"""Uploads and closed sessions without compasses: the elbows correct what the mounting rule only supposed."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from app.kinds.arm.elbows import with_elbows
from estimators import pipelines, signals
from estimators.pipelines import SessionSetup
from estimators.recording import ImuChunk
from estimators.simulation import ArmScenario, Schedule, SimulatedSession, simulate_arm
from tests.said import codes

POSE_S = (2.0, 6.0)


def session(*, has_magnetometer: bool) -> SimulatedSession:
    scenario = ArmScenario(
        exercise="drinking",
        placements=("sternum", "upper_arm_right", "forearm_right"),
        schedule=Schedule(n_pose_s=7.0, repetitions=3),
        has_magnetometer=has_magnetometer,
        seed=3,
    )
    return simulate_arm(scenario)


def pieces(made: SimulatedSession, length: int = 777) -> Iterator[ImuChunk]:
    chunk = signals.to_common_ticks(made.recording, made.setup.rate_hz)
    for start in range(0, chunk.tick_count, length):
        yield chunk.ticks(start, min(start + length, chunk.tick_count))


def posed(made: SimulatedSession) -> SessionSetup:
    return pipelines.run(made.recording, made.setup, POSE_S)[1]


@pytest.mark.slow
def test_pieces_tell_what_the_whole_recording_tells() -> None:
    made = session(has_magnetometer=False)
    before = posed(made)
    assert before.calibration is not None
    assert pipelines.elbows_to_refine(before) == ("right",)
    _, whole = pipelines.run(made.recording, made.setup, POSE_S, elbows_from_movement=True)
    found = with_elbows(before, POSE_S, pieces(made))
    assert found.calibration is not None
    assert whole.calibration is not None
    assert found.calibration.method == whole.calibration.method == "n_pose, elbows"
    assert found.constrain_joint_headings
    for placement, offset in whole.calibration.heading_offset_rad.items():
        assert found.calibration.heading_offset_rad[placement] == pytest.approx(offset, abs=np.radians(0.5))
    assert "calibration.elbow_measured" in codes(found.calibration.reasons)
    # Once is enough.
    assert with_elbows(found, POSE_S, pieces(made)) is found


def test_what_compasses_or_movements_told_is_left_alone() -> None:
    made = session(has_magnetometer=True)
    before = posed(made)
    assert with_elbows(before, POSE_S, pieces(made)) is before
    assert before.calibration is not None
    offsets = {"upper_arm_right": 0.1, "forearm_right": 0.2}
    by_movement = replace(before.calibration, method="functional", heading_offset_rad=offsets)  # type: ignore[arg-type]
    moved = replace(before, calibration=by_movement)
    assert with_elbows(moved, POSE_S, pieces(made)) is moved
