"""Uncertainties of means: what errs alike in every stride does not average out."""

from dataclasses import replace

import numpy as np
import pytest
from foot_walk import foot_walk

from estimators.gait import find_strides, measure, measure_steps, smooth, summarise


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


@pytest.mark.parametrize("count", [1, 2, 5])
def test_few_strides_state_what_strides_vary_and_cover_the_truth(count):
    random = np.random.default_rng(10 + count)
    off = []
    for _ in range(2000):
        # Lengths of 1.2 m that vary by 4 %, each measured to 5 mm.
        found = measure(1.2 + 0.048 * random.standard_normal(count), "m", 0.005, name="stride_length")
        off.append(abs(found.value - 1.2) / found.sigma)
    # Two sigma hold 95 %, the sensors alone would hold 16 % of single strides.
    assert np.mean(np.array(off) < 2.0) > 0.92


def test_a_walk_of_few_strides_that_vary_more_has_its_own_spread_and_a_long_one_has_no_prior():
    wild = np.array([0.8, 1.2, 1.6])
    assert measure(wild, "m", name="stride_length").sigma == pytest.approx(wild.std(ddof=1) / np.sqrt(3.0))
    even = np.full(6, 1.2)
    assert measure(even, "m", 0.01, name="stride_length").sigma == pytest.approx(0.01 / np.sqrt(6.0))
    assert measure(even[:5], "m", 0.01, name="stride_length").sigma > 0.01
