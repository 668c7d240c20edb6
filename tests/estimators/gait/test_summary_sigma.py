"""Uncertainties of means: what errs alike in every stride does not average out."""

from dataclasses import replace

import numpy as np
import pytest
from foot_walk import foot_walk

from estimators.gait import find_strides, measure_steps, smooth, summarise


@pytest.fixture(scope="module")
def feet():
    return {
        side: find_strides(smooth(foot_walk(strides=12, noise=1.0, seed=seed).signals), side)
        for seed, side in enumerate(("left", "right"))
    }


def test_events_found_late_alike_do_not_average_out(feet):
    found = summarise(feet).feet["left"]
    assert found["stride_time"].sigma < 0.02
    for name in ("swing_time", "stance_time"):
        assert found[name].sigma > 0.04
    assert found["stance_share"].sigma > 0.03
    assert found["stride_time_variation"].sigma > 0.005


def test_asymmetry_keeps_what_one_foot_may_have_by_itself(feet):
    left = feet["left"]
    late = replace(left, swing_s=left.swing_s + 0.03)
    found = summarise({"left": late, "right": feet["right"]}).asymmetry["swing_time"]
    assert abs(found.value) < 2.0 * found.sigma


def test_step_width_knows_how_well_two_worlds_are_related():
    random = np.random.default_rng(4)
    errors = []
    for _ in range(200):
        left, right = (
            np.stack([1.2 * np.arange(9) + start, 0.02 * random.standard_normal(9)], axis=1)
            for start in (0.0, 0.6)
        )
        time = np.arange(9) * 1.1
        right[:, 0] -= right[0, 0]
        found = measure_steps(left, time, right, time + 0.5, np.array([0.0, -0.1]))["step_width"]
        errors.append((found.value - 0.1) / found.sigma)
    assert 0.5 < np.std(errors) < 1.3
