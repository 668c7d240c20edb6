"""What is compared between conditions: every measure that both have, with the statistics of its kind."""

import math

import pytest
from scipy import stats

from app.kinds.walk.history import changes_between
from app.kinds.walk.schemas import BalanceOut, FootOut, WalkContent, WalkMeasure


def measure(
    name: str,
    value: float,
    unit: str = "m",
    *,
    sigma: float = 0.01,
    spread: float | None = 0.04,
    count: int = 16,
) -> WalkMeasure:
    return WalkMeasure(measure=name, value=value, sigma=sigma, spread=spread, count=count, unit=unit)


def walk(shift: float = 0.0, *, has_shoes: bool = True, systematic_m: float = 0.01) -> WalkContent:
    """Return a walk of which every measure is larger by `shift`."""
    feet = [
        FootOut(
            side=side,
            measures=[
                measure("stride_length", 1.1 + shift),
                measure("circumduction", 0.03 + shift),
                measure("swing_time", 0.4 + shift, "s"),
                measure("stride_time_variation", 0.05 + shift, "1", spread=None),
            ],
            footholds=[],
            strides=[],
            path_m=[],
            curves=[],
        )
        for side in ("left", "right")
    ]
    balance = BalanceOut(
        mass_kg=80.0,
        apart_m=0.18,
        apart_source="measured",
        measures=[
            measure("weight_on_left", 0.4 + shift, "1"),
            measure("centre_to_left", -0.02 + shift, sigma=systematic_m),
            measure("centre_sway", 0.05 + shift),
            measure("margin", -0.1 + shift),
            measure("external_work", 0.6 + shift, "J/kg/m"),
        ],
        time_s=[],
        centre_m=[],
        centre_sigma_m=[],
        pressure_m=[],
        margin_m=[],
        support=[],
    )
    return WalkContent(
        feet=feet,
        both=[measure("double_support", 0.2 + shift, "s"), measure("step_width", 0.15 + shift)],
        asymmetry=[measure("stride_length", 0.1 + shift, "1", spread=None)],
        turn_count=0,
        bout_count=1,
        reasons=[],
        has_step_width=True,
        balance=balance if has_shoes else None,
    )


def test_every_measure_of_a_walk_on_shoes_is_compared() -> None:
    found = {(one.measure, one.foot): one for one in changes_between([walk()], [walk(0.02)])}
    assert set(found) == {
        *(
            (name, foot)
            for name in ("stride_length", "circumduction", "swing_time", "stride_time_variation")
            for foot in ("left", "right")
        ),
        *((name, "both") for name in ("double_support", "step_width", "stride_length_asymmetry")),
        *(
            (name, "both")
            for name in ("weight_on_left", "centre_to_left", "centre_sway", "margin", "external_work")
        ),
    }
    # Welch's test of two samples of 16 that scatter by 0.04, also where only the standard error 0.01 is known.
    expected = stats.ttest_ind_from_stats(0.02, 0.04, 16, 0.0, 0.04, 16, equal_var=False).pvalue
    for one in found.values():
        assert one.difference == pytest.approx(0.02)
        assert one.sigma == pytest.approx(0.01 * math.sqrt(2.0))
        assert one.p == pytest.approx(expected)
        assert one.method == "strides"
    assert found["external_work", "both"].unit == "J/kg/m"
    assert found["stride_length_asymmetry", "both"].a == pytest.approx(0.1)


def test_what_all_strides_have_alike_does_not_average_out() -> None:
    found = {one.measure: one for one in changes_between([walk(systematic_m=0.03)], [walk(0.02)])}
    assert found["centre_to_left"].sigma == pytest.approx(math.hypot(0.03, 0.01))
    assert found["centre_to_left"].p > found["centre_sway"].p


def test_what_one_condition_has_not_is_left_out_and_pairs_are_pairs() -> None:
    found = changes_between([walk(), walk(0.01)], [walk(0.02, has_shoes=False), walk(0.04, has_shoes=False)])
    assert "weight_on_left" not in {one.measure for one in found}
    # Differences of 0.02 and 0.03: the paired t over two.
    expected = stats.ttest_rel([0.02, 0.04], [0.0, 0.01]).pvalue
    for one in found:
        assert one.method == "pairs"
        assert one.count == 2
        assert one.p == pytest.approx(expected)
    one_has = changes_between([walk(), walk(has_shoes=False)], [walk(0.02), walk(0.02)])
    assert {one.method for one in one_has if one.measure == "centre_sway"} == {"strides"}
