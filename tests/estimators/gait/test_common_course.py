"""Feet related on courses that turn."""

from dataclasses import replace

import numpy as np
import pytest

from estimators import pipelines
from estimators.errors import ShapeError
from estimators.gait import average_path, relate_by_course, steps_in_one_world
from estimators.pipelines import SessionSetup
from estimators.recording import Recording
from estimators.simulation import Bout, Leg, gait_preset, simulate_gait

WIDTH_M, STEP_M, STEP_S = 0.14, 0.55, 0.6


def footholds(turn_rad, count=25, uneven_m=0.0, seed=1, scatter_m=0.0):
    """Place footholds beside a path that turns by so much over its middle third, in turn right and left."""
    rng = np.random.default_rng(seed)
    found = {True: [], False: []}
    times = {True: [], False: []}
    place, course = np.zeros(2), 0.0
    for k in range(2 * count):
        is_left = k % 2 == 0
        if 2 * count // 3 <= k < 4 * count // 3:
            course += turn_rad / (2 * count / 3)
        length = STEP_M + (uneven_m if is_left else -uneven_m) if k > 1 else 0.0
        place = place + length * np.array([np.cos(course), np.sin(course)])
        aside = 0.5 * WIDTH_M * (1.0 if is_left else -1.0)
        spot = place + aside * np.array([-np.sin(course), np.cos(course)])
        found[is_left].append(spot + scatter_m * rng.normal(size=2))
        times[is_left].append(k * STEP_S)
    return [np.array(part) for part in (found[True], times[True], found[False], times[False])]


def own_world(points, time_s, start_rad, drift_radps):
    """Return footholds as a foot with another heading that drifts gives them."""
    turn = start_rad + drift_radps * 0.5 * (time_s[1:] + time_s[:-1])
    steps = np.diff(points, axis=0)
    c, s = np.cos(turn), np.sin(turn)
    turned = np.column_stack([c * steps[:, 0] - s * steps[:, 1], s * steps[:, 0] + c * steps[:, 1]])
    return np.concatenate([np.zeros((1, 2)), np.cumsum(turned, axis=0)])


@pytest.mark.parametrize("turn_rad", [0.0, 1.6, -3.1])
@pytest.mark.parametrize("uneven_m", [0.0, 0.06])
def test_worlds_that_turn_and_drift_are_laid_over_each_other(turn_rad, uneven_m):
    left, left_s, right, right_s = footholds(turn_rad, uneven_m=uneven_m)
    other = own_world(right, right_s, 0.7, 3e-4)
    found = relate_by_course(left, left_s, other, right_s, WIDTH_M)
    assert np.linalg.norm(found.right_m - right, axis=1).max() < 0.04
    steps = steps_in_one_world(left, left_s, found.right_m, right_s)
    assert np.mean(steps.width_m) == pytest.approx(
        np.mean(steps_in_one_world(left, left_s, right, right_s).width_m), abs=0.01
    )
    assert 0.01 < found.step_sigma_m < 0.05
    # Turning the whole right world changes nothing.
    again = relate_by_course(left, left_s, own_world(other, right_s, -2.0, 0.0), right_s, WIDTH_M)
    np.testing.assert_allclose(again.right_m, found.right_m, atol=2e-3)


def test_scatter_stays_within_what_is_said():
    worst = []
    for seed in range(6):
        left, left_s, right, right_s = footholds(2.0, seed=seed, scatter_m=0.02)
        found = relate_by_course(left, left_s, own_world(right, right_s, -0.4, -2e-4), right_s, WIDTH_M)
        ours = steps_in_one_world(left, left_s, found.right_m, right_s).width_m.mean()
        true = steps_in_one_world(left, left_s, right, right_s).width_m.mean()
        worst.append((ours - true) / found.step_sigma_m)
    assert np.sqrt(np.mean(np.square(worst))) < 1.6


def test_too_little_is_refused():
    left, left_s, right, right_s = footholds(0.0, count=3)
    with pytest.raises(ShapeError, match="footholds"):
        relate_by_course(left, left_s, right, right_s, WIDTH_M)
    left, left_s, right, right_s = footholds(0.0, count=8)
    with pytest.raises(ShapeError, match="shorter"):
        relate_by_course(0.1 * left, left_s, 0.1 * right, right_s, WIDTH_M)


def test_the_shared_path_runs_between_the_feet():
    left, left_s, right, right_s = footholds(1.6)
    moments = np.arange(5.0, 24.0, 0.1)
    path, course = average_path(left, left_s, right, right_s, moments)
    assert np.abs(np.interp(1.0, moments, course)) < 0.05
    assert course[-1] == pytest.approx(1.6, abs=0.1)
    assert np.abs(path[moments < 8.0, 1]).max() < 0.03


def test_a_walk_that_turns_has_steps():
    preset = gait_preset("turns", 1)
    walked = simulate_gait(
        replace(
            preset, rate_hz=100.0, course=(Bout((Leg(8), Leg(5, turn_rad=3.1, length_scale=0.5), Leg(8))),)
        )
    )
    sensors = walked.recording.sensors
    recording = Recording({f"foot_{s}": sensors[f"heel_{s}"] for s in ("left", "right")}, 100.0)
    truth = {side: foot.foothold_m for side, foot in walked.truth.feet.items()}
    apart = float(np.linalg.norm(truth["left"][0] - truth["right"][0]))
    setup = SessionSetup("gait", ("foot_left", "foot_right"), 100.0, feet_apart_m=apart)
    found = pipelines.analyse_walk(recording, setup)
    assert found.summary.turn_count == 1
    width = found.steps["step_width"]
    assert width.count >= 5
    assert width.value == pytest.approx(preset.walk.step_width_m, abs=3.0 * width.sigma)
    assert 0.01 < width.sigma < 0.04
    unknown = pipelines.analyse_walk(recording, replace(setup, feet_apart_m=None))
    assert unknown.steps is None
