"""Experiments with arms, feet, orientation and guidance: nothing is grossly wrong with one seed."""

import numpy as np
import pytest

from tests.validation import one_seed
from tests.validation.test_magnetic_experiments import NAMES as OTHERS
from validation import Figure, FigureResult

NAMES = [name for name in one_seed.SIMULATED if name not in OTHERS]


@pytest.mark.slow("experiments of minutes, skipped where they passed before")
@pytest.mark.parametrize("name", NAMES)
def test_nothing_is_grossly_wrong(name):
    one_seed.check(name)


@pytest.mark.parametrize(
    ("value", "limit", "at_most", "expected"),
    [
        (1.9, 1.0, True, False),
        (2.1, 1.0, True, True),
        (0.6, 1.0, False, False),
        (0.4, 1.0, False, True),
        (-0.6, -1.0, True, False),
        (-0.4, -1.0, True, True),
        (-1.9, -1.0, False, False),
        (-2.1, -1.0, False, True),
        (0.1, 0.0, True, True),
        (np.nan, None, True, True),
        (9.9, None, True, False),
    ],
)
def test_what_is_beyond_twice_its_limit_is_amiss(value, limit, at_most, expected):
    assert (
        one_seed.amiss(FigureResult(Figure("x", "1", limit, at_most=at_most), np.array([value]))) is expected
    )


def test_of_what_is_timed_only_that_it_was_measured_counts():
    timed = FigureResult(Figure("x", "s", 1.0), np.array([9.0]))
    assert not one_seed.amiss(timed, is_timed=True)
    assert one_seed.amiss(FigureResult(Figure("x", "s", 1.0), np.array([np.nan])), is_timed=True)
