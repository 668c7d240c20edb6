"""Steps that borrow their arrays: the caller's stay as they were, nothing leaks, and making an array is refused."""

import sys

import numpy as np
import pytest
from numba.core.errors import TypingError

from estimators.kernels import borrowing
from estimators.orientation._screen import _judge
from estimators.orientation.telemotion._kernel import follow, run
from estimators.recording import Float


@borrowing("float64(float64[::1])")
def _sum_of_rest(values: Float) -> float:
    rest, total = values[1:], 0.0
    for i in range(len(rest)):
        total += rest[i]
    return total


@borrowing("float64(float64[::1])")
def _makes_one(values: Float) -> float:
    made = np.zeros(3)
    made[0] = values[0]
    return float(made[0])


def test_arrays_that_are_lent_come_back() -> None:
    values = np.arange(4.0)
    users = sys.getrefcount(values)
    assert [_sum_of_rest(values) for _ in range(100)] == [6.0] * 100
    assert sys.getrefcount(values) == users


def test_a_step_that_makes_an_array_is_refused() -> None:
    with pytest.raises(TypingError):
        _makes_one(np.ones(3))


def test_what_runs_for_every_live_sample_counts_no_references() -> None:
    """These were half of the screening and a fifth of the filter; only `run`, which makes the room, counts any."""
    for borrower in (_judge, follow):
        assert borrower.targetoptions["_nrt"] is False
    assert "_nrt" not in run.targetoptions
