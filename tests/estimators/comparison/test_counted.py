"""A comparison of repetitions that were counted live: which they are, their bounds, and faults of some of them."""

from dataclasses import replace

import pytest

from estimators.comparison import (
    Repetition,
    build_template,
    compare,
    comparison_from_bytes,
    comparison_to_bytes,
)
from estimators.comparison.repetitions import counted_repetitions
from tests.estimators.comparison.conftest import make_planar


def counted_in(made, kinds):
    """The true ones as they are known live: a little later."""
    return [
        replace(one, start_s=one.start_s + 0.2, end_s=one.end_s + 0.2, counted=kind, is_kept=kind != "wrong")
        for one, kind in zip(made.truth, kinds, strict=True)
    ]


def test_bounds_are_those_of_the_recording_where_it_is_the_same_repetition():
    counted = [Repetition(1, 2.2, 5.2, counted="valid"), Repetition(2, 7.0, 10.0, counted="partial")]
    bounds = counted_repetitions(counted, [Repetition(1, 2.0, 5.0), Repetition(2, 4.0, 8.0)])
    assert [(one.start_s, one.end_s) for one in bounds] == [(2.0, 5.0), (7.0, 10.0)]
    assert [one.counted for one in bounds] == ["valid", "partial"]
    assert counted_repetitions(counted, []) == counted


def test_what_was_counted_is_compared_and_the_small_ones_are_named():
    shown = make_planar(noise_rad=0.002)
    template = build_template(shown.trajectory, shown.truth, "right", shown.reach_m, shown.primary)
    made = make_planar(sizes=[1.0, 0.5, 1.0, 0.5], noise_rad=0.002, seed=2)
    kinds = ["valid", "partial", "valid", "partial"]
    result = compare(made.trajectory, template, "right", made.reach_m, counted=counted_in(made, kinds))
    assert [one.repetition.counted for one in result.repetitions] == kinds
    # Half as large as the others: whoever looks for likeness alone leaves them out.
    assert all(one.repetition.is_kept for one in result.repetitions)
    for one, truth in zip(result.repetitions, made.truth, strict=True):
        assert one.repetition.start_s == pytest.approx(truth.start_s, abs=0.25)
    assert any("Repetitions 2 and 4 were smaller" in text for text in result.findings)
    stored = comparison_from_bytes(comparison_to_bytes(result))
    assert [one.repetition for one in stored.repetitions] == [one.repetition for one in result.repetitions]


def test_another_movement_is_left_out():
    shown = make_planar(noise_rad=0.002)
    template = build_template(shown.trajectory, shown.truth, "right", shown.reach_m, shown.primary)
    counted = counted_in(shown, ["valid", "wrong", "valid", "valid", "valid"])
    result = compare(shown.trajectory, template, "right", shown.reach_m, counted=counted)
    assert [one.repetition.is_kept for one in result.repetitions] == [True, False, True, True, True]
