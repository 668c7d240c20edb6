"""Feet: when they stand, where they go, and what a walk looks like in numbers.

::

    trajectory = smooth(recording.sensors["foot_left"])        # off-line
    strides = find_strides(trajectory, "left")
    print(summarise({"left": strides}).feet["left"]["stride_length"])
    released = FootTracker(2, 0.01).update(chunk)              # live, up to 0.96 s old

Sensors may sit anywhere on the shoe, any way round. Without a magnetometer the heading of the world is that of the
first sample, for each foot its own.
"""

from estimators.gait._common_course import CommonCourse, average_path, relate_by_course
from estimators.gait._guided_tests import GUIDED_KINDS, GuidedKind, GuidedTest, guided_test
from estimators.gait._live_steps import USUAL_APART_M, LiveSteps, LiveStepTracker
from estimators.gait._placement import Placement, Steps, foot_placement, steps_in_one_world
from estimators.gait._related_feet import RelatedFeet, RelativeFeet, relate_feet
from estimators.gait._rests import Footholds
from estimators.gait._stance import Stance, find_stance
from estimators.gait._stride_flags import StrideFlag
from estimators.gait._strides import Strides, find_strides
from estimators.gait._summary import (
    GaitSummary,
    measure_steps,
    steady,
    step_measures,
    steps_inside,
    summarise,
    turns,
)
from estimators.gait.foot.live import FootChunk, FootTracker
from estimators.gait.foot.parameters import FootParameters, foot_parameters
from estimators.gait.foot.trajectory import FootFlag, FootTrajectory, smooth
from estimators.gait.walk.carried import carried_foot, without_carried
from estimators.gait.walk.measured import Measure, measure
from estimators.gait.walk.rolling import rolled_s

__all__ = [
    "GUIDED_KINDS",
    "USUAL_APART_M",
    "CommonCourse",
    "FootChunk",
    "FootFlag",
    "FootParameters",
    "FootTracker",
    "FootTrajectory",
    "Footholds",
    "GaitSummary",
    "GuidedKind",
    "GuidedTest",
    "LiveStepTracker",
    "LiveSteps",
    "Measure",
    "Placement",
    "RelatedFeet",
    "RelativeFeet",
    "Stance",
    "Steps",
    "StrideFlag",
    "Strides",
    "average_path",
    "carried_foot",
    "find_stance",
    "find_strides",
    "foot_parameters",
    "foot_placement",
    "guided_test",
    "measure",
    "measure_steps",
    "relate_by_course",
    "relate_feet",
    "rolled_s",
    "smooth",
    "steady",
    "step_measures",
    "steps_in_one_world",
    "steps_inside",
    "summarise",
    "turns",
    "without_carried",
]
