"""A live pose is doubted by two looks in turn: what was wrong for some seconds only is no matter of the pose."""

import math

import numpy as np
import pytest

from estimators.calibration import Calibration
from estimators.pipelines import FrameLayout, Frames
from estimators.pipelines.arm.worn import WornCheck
from tests.estimators.calibration.test_facing import RIGHT, STEP_S, by_pose, moves, seen
from tests.said import codes

LOOK_S = 5.0


def told_after_s(from_s: float, until_s: float) -> tuple[float, Calibration] | None:
    """Return when a check answers, and what, where the chest sensor was back to front for that time only."""
    true = moves(RIGHT)
    wrong = seen(true, math.pi)
    time_s = STEP_S * np.arange(len(true.q_room_segment))
    is_wrong = (time_s >= from_s) & (time_s < until_s)
    q = np.where(is_wrong[:, None, None], wrong.q_room_segment, true.q_room_segment)
    place, angle = np.zeros((len(q), 0, 3)), np.zeros((len(q), 0))
    flags = np.zeros((len(q), len(RIGHT)), dtype=np.uint8)
    layout = FrameLayout(segments=RIGHT, points=(), angles=())
    whole = Frames(layout, 0, STEP_S, q, place, angle, angle, angle, flags, flags[:, :0])
    check = WornCheck(by_pose(RIGHT, math.pi, sternum=180.0))
    ticks = round(1.0 / STEP_S)
    for first in range(0, len(q), ticks):
        if (found := check.add(whole.ticks(first, first + ticks))) is not None:
            return (first + ticks) * STEP_S, found
    return None


@pytest.mark.parametrize("look", [2, 4])
def test_what_is_wrong_within_one_look_is_no_matter_of_the_pose(look: int) -> None:
    """It lasts for four seconds, twice what is needed to contradict a pose."""
    begun_s = look * LOOK_S
    assert told_after_s(begun_s, begun_s + 4.0) is None


def test_what_is_wrong_for_two_looks_in_turn_is_told_with_the_second() -> None:
    found = told_after_s(2.0 * LOOK_S, 12.0 * LOOK_S)
    assert found is not None
    after_s, calibration = found
    assert 4.0 * LOOK_S - 1.0 <= after_s <= 5.0 * LOOK_S
    assert codes(calibration.reasons)
