"""Guidance without the sensors of its main channel says so first, and counts nothing."""

from types import SimpleNamespace

import numpy as np
import pytest

from app.assessment.design.dose import Dose
from app.live.guidance.controller import GuidanceController
from app.live.guidance.resume_state import ResumeState
from estimators.guidance import CountedRepetition, CuePace
from estimators.pipelines import FrameLayout, Frames
from tests.estimators.guidance.conftest import ready
from tests.said import codes


def frames(angles: tuple[str, ...]) -> Frames:
    count = len(angles)
    return Frames(
        layout=FrameLayout(segments=("sternum",), points=(), angles=angles),
        first_tick=0,
        time_step_s=0.01,
        q_room_segment=np.tile([1.0, 0.0, 0.0, 0.0], (5, 1, 1)),
        point_room_m=np.zeros((5, 0, 3)),
        angle_rad=np.zeros((5, count)),
        angle_sigma_rad=np.full((5, count), 0.01),
        scalar=np.zeros((5, 0)),
        segment_flags=np.zeros((5, 1), np.uint8),
        angle_flags=np.zeros((5, count), np.uint8),
    )


def desk(told: list, dose: Dose | None = None) -> GuidanceController:
    guidance = SimpleNamespace(ready=ready(), valid_share=0.8, rules=(), stops=(), pace=CuePace())
    return GuidanceController(
        SimpleNamespace(guidance=guidance, dose=dose),
        0.01,
        ResumeState(),
        lambda kind, time_s, *, text="", details=None: told.append((kind, text)),
        lambda message: None,
    )


def test_a_main_channel_that_no_sensor_gives_is_said_once_and_first():
    told: list = []
    guided = desk(told)
    for _ in range(3):
        guided.see(frames(("thorax_humerus_right_yxy_elevation",)), is_counting=True, is_live=True)
    assert [(kind, codes(text)) for kind, text in told] == [("guidance_failed", ["guided.main_not_measured"])]
    assert told[0][1].parameters["channel"] == "elbow_flexion"
    assert guided.message.status == "failed"


def test_a_main_channel_that_is_worn_is_followed():
    told: list = []
    guided = desk(told)
    guided.see(frames((ready().main,)), is_counting=True, is_live=True)
    assert told == []
    assert guided.is_following


def repetition(number: int, kind: str = "valid") -> CountedRepetition:
    return CountedRepetition(kind, number, 100 * number, 100 * number + 50, (1.0,), 0.0, 1.0)


def count_up(guided: GuidanceController, numbers: range) -> None:
    for number in numbers:
        guided._count(repetition(number), float(number), number + 0.5)


@pytest.mark.parametrize("before", [0, 2], ids=["within the session", "in an earlier one"])
def test_it_goes_on_to_count_when_the_goal_of_the_day_is_reached(before) -> None:
    told: list = []
    guided = desk(told, Dose(goal=2, set_valid=2, before=before))
    if not before:
        count_up(guided, range(1, 3))
        assert (guided.obey("resume").counts.valid, guided.message.cause) == (2, "")
        assert [kind for kind, _ in told].count("guidance_stop") == 1
    first = guided.message.counts.valid
    count_up(guided, range(3, 10))
    # Of her own accord: nothing holds her up, and nothing is left out.
    assert guided.obey("resume").counts.valid == first + 7
    assert guided.message.status != "stopped"
    assert [kind for kind, _ in told].count("guidance_stop") == (0 if before else 1)
