"""Guidance without the sensors of its main channel says so first, and counts nothing."""

from types import SimpleNamespace

import numpy as np

from app.live.guidance.desk import GuidanceDesk
from app.live.guidance.taken_up import TakenUp
from estimators.guidance import CuePace
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


def desk(told: list) -> GuidanceDesk:
    guidance = SimpleNamespace(ready=ready(), valid_share=0.8, rules=(), stops=(), pace=CuePace())
    return GuidanceDesk(
        SimpleNamespace(guidance=guidance, dose=None),
        0.01,
        TakenUp(),
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
