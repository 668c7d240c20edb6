"""Step width and length of a walk whose course turns."""

from collections.abc import Mapping
from typing import Final

import numpy as np

from estimators.conventions import Side
from estimators.errors import ShapeError
from estimators.gait import (
    Footholds,
    Measure,
    Strides,
    relate_by_course,
    step_measures,
    steps_in_one_world,
    steps_inside,
)
from estimators.recording import Float

_TURN_RAD: Final = 0.35
"""A stride that turns by more than 20 degrees is not averaged into the steps of straight walking."""


def turning_steps(
    strides: Mapping[Side, Strides], holds: Mapping[Side, Footholds], apart_m: float
) -> Mapping[str, Measure] | None:
    """Measure steps of feet with one inertial sensor each; None where they cannot be related.

    Parameters
    ----------
    holds : mapping of Side to Footholds
        Their footholds, or the first of them.
    apart_m : float
        Distance of the feet at the start, measured.
    """
    left, right = holds["left"], holds["right"]
    try:
        course = relate_by_course(
            left.position_m, left.quietest_s, right.position_m, right.quietest_s, apart_m
        )
    except ShapeError:
        return None
    return steps_on_course(
        strides, left.position_m, left.quietest_s, course.right_m, right.quietest_s, course.step_sigma_m
    )


def steps_on_course(
    strides: Mapping[Side, Strides],
    left_m: Float,
    left_s: Float,
    right_m: Float,
    right_s: Float,
    sigma_m: float,
) -> Mapping[str, Measure]:
    """Measure the straight steps of feet in one world.

    Parameters
    ----------
    strides : mapping of Side to Strides
        Tell which steps turn.
    left_m, right_m : ndarray, shape (n, 2 or 3) and (m, 2 or 3)
        Their footholds.
    left_s, right_s : ndarray, shape (n,) and (m,)
    sigma_m : float
        One sigma of where the feet are against each other.
    """
    steps = steps_in_one_world(left_m, left_s, right_m, right_s)
    turned = [
        strides["left" if is_left else "right"].turn_rad[number - 1]
        for is_left, number in zip(steps.is_left, steps.foothold, strict=True)
    ]
    return step_measures(
        steps, sigma_m, (np.abs(np.array(turned)) < _TURN_RAD) & steps_inside(strides, steps)
    )
