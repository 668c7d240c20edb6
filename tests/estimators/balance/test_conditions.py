"""Two conditions of one person: paired over recordings, and over strides."""

import math

import numpy as np
import pytest
from scipy import stats

from estimators.balance import Sample, compare_conditions
from estimators.errors import ShapeError


def test_pairs_give_the_paired_t_test() -> None:
    rng = np.random.default_rng(2)
    open_eyes = rng.normal(1.2, 0.05, 6)
    closed = open_eyes - 0.04 + rng.normal(0.0, 0.02, 6)
    found = compare_conditions(
        [Sample(v, 0.03, 20) for v in open_eyes.tolist()], [Sample(v, 0.03, 20) for v in closed.tolist()]
    )
    assert found.method == "pairs"
    assert found.count == 6
    assert found.difference == pytest.approx(float(np.mean(closed - open_eyes)))
    assert found.p == pytest.approx(float(stats.ttest_rel(closed, open_eyes).pvalue))


def test_strides_of_single_walks_give_welchs_test() -> None:
    rng = np.random.default_rng(3)
    one, two = rng.normal(1.2, 0.05, 14), rng.normal(1.1, 0.09, 20)
    a, b = (Sample(float(v.mean()), float(v.std(ddof=1)), len(v)) for v in (one, two))
    found = compare_conditions([a], [b])
    expected = stats.ttest_ind(two, one, equal_var=False)
    assert found.method == "strides"
    assert found.p == pytest.approx(float(expected.pvalue))
    # Parts of one condition put together are the condition.
    parts = [Sample(float(v.mean()), float(v.std(ddof=1)), len(v)) for v in (two[:8], two[8:])]
    assert compare_conditions([a], parts).p == pytest.approx(found.p)
    assert compare_conditions([b], [a]).difference == pytest.approx(-found.difference)


def test_what_is_not_known_is_said() -> None:
    with pytest.raises(ShapeError, match="no value"):
        compare_conditions([Sample(math.nan, math.nan, 0)], [Sample(1.0, 0.1, 5)])
    same = compare_conditions([Sample(1.0, 0.1, 1), Sample(1.0, 0.1, 1)], [Sample(1.0, 0.1, 1)] * 2)
    assert math.isnan(same.p)
    assert same.difference == 0.0
