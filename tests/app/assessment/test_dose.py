"""The goal of a prescription is what is to be done; rules of a template portion it."""

import pytest

from app.assessment.design.dose import Dose, dose_of
from estimators.guidance import StopRule


def done(dose: Dose, kinds: str) -> list[tuple[int, str]]:
    """Play repetitions, `v` valid and `p` partial; return after how many something was reached, and what."""
    valid = in_set = attempts = 0
    is_done, told = False, []
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
