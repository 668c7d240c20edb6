"""Repetitions that are planned one by one: what is particular about each is in the truth."""

import numpy as np
import pytest

from estimators.errors import SetupError
from estimators.simulation import ArmScenario, PlannedRepetition, Schedule, simulate_arm

PLAN = (
    PlannedRepetition(pause_s=0.5),
    PlannedRepetition(size=0.5),
    PlannedRepetition(stop_share=0.5, stop_s=1.0),
    PlannedRepetition(instead="abduction"),
    PlannedRepetition(lean_rad=0.3, pace=2.0),
)
ELBOW = "humerus_forearm_right_zxy_flexion"


@pytest.fixture(scope="module")
def made():
    schedule = Schedule(n_pose_s=2.0, repetitions=None, plan=PLAN)
    return simulate_arm(ArmScenario(errors="ideal", placements=("sternum",), schedule=schedule, seed=3)).truth


def cut(made, number, values):
    start, end = np.rint(made.repetitions_s[number] * 100).astype(int)
    return values[start:end]


def test_each_repetition_is_as_planned(made):
    assert len(made.repetitions_s) == len(PLAN)
    ranges = [np.ptp(cut(made, n, made.angle_rad(ELBOW))) for n in range(5)]
    assert ranges[1] / ranges[0] == pytest.approx(0.5, abs=0.08)
    leans = [cut(made, n, made.angle_rad("trunk_lean_forward_rad")).max() for n in range(5)]
    assert leans[4] - leans[0] == pytest.approx(0.3, abs=0.03)
    lasts = np.diff(made.repetitions_s, axis=1)[:, 0]
    assert lasts[2] - lasts[0] == pytest.approx(1.0, abs=0.4)
    assert lasts[4] < 0.75 * lasts[0]
    assert made.repetitions_s[1, 0] - made.repetitions_s[0, 1] == pytest.approx(0.5, abs=0.02)


def test_progress_goes_through_the_pieces(made):
    for number in (0, 1, 2, 4):
        # Bounds are on ticks, so the first may be just before.
        progress = cut(made, number, made.progress)[1:]
        assert np.isfinite(progress).all()
        assert (np.diff(progress) >= -1e-12).all()
        # Out, hold and back are three pieces.
        assert progress[0] == pytest.approx(0.0, abs=0.01)
        assert progress[-1] == pytest.approx(3.0, abs=0.01)
    stop = cut(made, 2, made.progress)
    assert 95 <= (np.abs(stop - 0.5) < 1e-9).sum() <= 105
    assert np.isnan(cut(made, 3, made.progress)).all()
    between = slice(
        *np.rint([made.repetitions_s[0, 1] * 100 + 1, made.repetitions_s[1, 0] * 100 - 1]).astype(int)
    )
    assert np.isnan(made.progress[between]).all()
    assert np.isnan(made.progress[: round(made.repetitions_s[0, 0] * 100) - 1]).all()


def test_plans_that_contradict_themselves_are_refused():
    with pytest.raises(SetupError):
        PlannedRepetition(instead="swimming")
    with pytest.raises(SetupError):
        PlannedRepetition(size=0.0)
    with pytest.raises(SetupError):
        simulate_arm(ArmScenario(schedule=Schedule(repetitions=3, plan=PLAN)))
