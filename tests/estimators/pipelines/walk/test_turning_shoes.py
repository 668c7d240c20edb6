"""Two instrumented shoes on a course that turns: steps and balance against the simulator's truth."""

from dataclasses import replace

import numpy as np
import pytest

from estimators import pipelines
from estimators.conventions import SHOE_PLACEMENTS, SIDES
from estimators.pipelines import BodyDimensions, SessionSetup
from estimators.recording import Recording
from estimators.simulation import Bout, Leg, gait_preset, simulate_gait


@pytest.mark.slow
@pytest.mark.parametrize("apart_m", [0.18, None])
def test_a_walk_that_turns_has_steps_and_balance(apart_m):
    preset = gait_preset("stroke", 1)
    there = Leg(5, turn_rad=np.pi, length_scale=0.4)
    course = (Bout((Leg(8), there, Leg(8))),)
    walked = simulate_gait(replace(preset, rate_hz=100.0, course=course))
    recording = Recording({name: walked.recording.sensors[name] for name in SHOE_PLACEMENTS}, 100.0)
    setup = SessionSetup(
        "gait", SHOE_PLACEMENTS, 100.0, feet_apart_m=apart_m, body=BodyDimensions(stature_m=1.8)
    )
    walk = pipelines.analyse_walk(recording, setup)
    assert walk.summary.turn_count == 1
    shoes = pipelines.analyse_shoes(recording, setup, walk)
    assert shoes.apart_m == pytest.approx(0.18, abs=0.03)
    truth = walked.truth
    turned = _turn_between(shoes.centre.position_m, truth.com.position)
    found, true = (values[:, :2] - values[:, :2].mean(axis=0) for values in (turned, truth.com.position))
    # Straight walks are required to 20 mm; a turn costs a little of that.
    assert np.sqrt(np.mean((found - true) ** 2)) < 0.03
    steps = pipelines.with_shoes(walk, shoes).steps
    assert steps["step_width"].count >= 6
    assert steps["step_width"].value == pytest.approx(0.18, abs=2.5 * steps["step_width"].sigma)
    # The paretic left leg takes the shorter steps, in every direction of the room.
    assert steps["step_length_left"].value < steps["step_length_right"].value - 0.03
    aside = shoes.feet.aside(shoes.centre.position_m)
    walking = ~shoes.feet.is_standing
    # The centre of mass stays between the feet all along, also on the way back.
    assert np.abs(aside[walking]).max() < 0.15
    forward = shoes.feet.ahead(shoes.centre.velocity_mps)
    assert forward[walking].mean() > 0.3
    for side in SIDES:
        stands = shoes.shoes[side].contact.core.mean(axis=1).astype(int)
        own = shoes.feet.aside(shoes.feet.pose[side].heel_m)[stands[1:-1]]
        assert (own > 0.0).mean() > 0.8 if side == "left" else (own < 0.0).mean() > 0.8


def _turn_between(found, true):
    """Return the found places turned so that they lie best over the true ones."""
    a, b = (values[:, :2] - values[:, :2].mean(axis=0) for values in (found, true))
    angle = np.arctan2(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), np.sum(a * b))
    c, s = np.cos(angle), np.sin(angle)
    assert abs(angle) < 0.1
    return np.column_stack([c * found[:, 0] - s * found[:, 1], s * found[:, 0] + c * found[:, 1]])
