"""The goal of a prescription is what is to be done; rules of a template portion it."""

import pytest

from app.assessment.design.dose import Dose, dose_of
from estimators.guidance import StopRule


def done(dose: Dose, kinds: str) -> list[tuple[int, str]]:
    """Play repetitions, `v` valid and `p` partial; return after how many something was reached, and what."""
    valid = in_set = attempts = 0
    is_done, told = dose.is_done_before, []
    for number, kind in enumerate(kinds, start=1):
        valid, in_set, attempts = valid + (kind == "v"), in_set + (kind == "v"), attempts + 1
        reached = dose.reached(valid, in_set, attempts, is_done=is_done)
        if reached:
            told.append((number, reached))
            in_set = attempts = 0
            is_done = is_done or reached == "valid_count"
    return told


@pytest.mark.parametrize(
    ("prescribed", "rules", "told"),
    [
        pytest.param((6, 1), [], [(6, "valid_count")], id="no rule"),
        pytest.param((2, 3), [], [(2, "set"), (4, "set"), (6, "valid_count")], id="prescribed sets"),
        pytest.param(
            (6, 1), [StopRule("valid_count", 4)], [(4, "set"), (6, "valid_count")], id="a template's set"
        ),
        pytest.param((3, 1), [StopRule("valid_count", 10)], [(3, "valid_count")], id="a larger set"),
        pytest.param(
            (4, 1),
            [StopRule("valid_count", 3), StopRule("valid_count", 2)],
            [(2, "set"), (4, "valid_count")],
            id="the smaller one holds",
        ),
    ],
)
def test_only_the_goal_is_the_end(prescribed, rules, told) -> None:
    # What is added of one's own accord has no sets.
    assert done(dose_of(*prescribed, rules), "v" * 9) == told


def test_attempts_end_a_set_and_never_the_exercise() -> None:
    dose = dose_of(4, 1, [StopRule("attempt_count", 3), StopRule("limit", 1.0, channel="x")])
    assert dose.goal == 4
    assert done(dose, "vpppppvvpv") == [
        (3, "attempt_count"),
        (6, "attempt_count"),
        (9, "attempt_count"),
        (10, "valid_count"),
    ]


@pytest.mark.parametrize(
    ("done_today", "times", "before", "is_done_before"),
    [
        pytest.param(0, 0, 0, False, id="the first of the day"),
        pytest.param(4, 0, 4, False, id="begun before"),
        pytest.param(6, 0, 6, True, id="done before"),
        pytest.param(8, 1, 8, True, id="more than done before"),
        pytest.param(4, 2, 4, False, id="the morning's goes on"),
        pytest.param(6, 2, 0, False, id="the evening's begins"),
        pytest.param(9, 2, 3, False, id="the evening's goes on"),
        pytest.param(13, 2, 7, True, id="both done before"),
    ],
)
def test_a_session_goes_on_where_the_day_stands(done_today, times, before, is_done_before) -> None:
    dose = dose_of(6, 1, []).after(done_today, times)
    assert (dose.goal, dose.before, dose.is_done_before) == (6, before, is_done_before)
    told = [] if is_done_before else [(6 - before, "valid_count")]
    assert done(dose, "v" * 9) == told
