"""A sum of measures exists only where a therapist defined it, and hides none of its parts."""

from typing import Any

import pytest
from sqlalchemy import Engine

from app.assessment.design.compiled import mirrored_design
from app.assessment.design.weighted import offered_measures, weighted_sum
from app.assessment.presentation import repetition_comparison
from app.exercises.design import TemplateDesign, WeightDesign
from estimators.comparison import compare, measure_unit, measures_beside
from estimators.errors import SetupError
from tests.estimators.comparison.conftest import make_planar

from .templates.drawing import MAIN, planar_template, store_template

RANGE = f"range:{MAIN}"
SUM = [{"measure": RANGE, "weight": 1.0}, {"measure": "duration", "weight": -2.5}]


@pytest.fixture
def stored(engine: Engine, world: Any) -> tuple[str, str]:
    return store_template(engine, world, world.patient_id)


def draw(client: Any, stored: tuple[str, str], weights: list[dict[str, Any]]) -> Any:
    body = {"based_on": stored[1], "design": {"weights": weights}, "reason": "sum"}
    return client.post(f"/api/templates/{stored[0]}/versions", json=body)


def compared() -> Any:
    made = make_planar(noise_rad=0.001, sizes=[1.0, 0.9, 0.8], seed=2)
    template = planar_template()
    return template, compare(made.trajectory, template, "right", made.reach_m, repetitions=made.truth)


def test_what_is_offered_is_what_repetitions_have_in_their_units() -> None:
    template, result = compared()
    measures = {one.name: one.unit for one in result.repetitions[0].measures}
    assert set(measures_beside(template)) == set(measures)
    assert {name: measure_unit(name) for name in measures} == measures
    offered = {one.measure: one for one in offered_measures(template)}
    shown = repetition_comparison(result.repetitions[0], template).measures
    assert {one.measure: (one.label, one.unit, one.template_value) for one in shown} == {
        name: (one.label, one.unit, one.value) for name, one in offered.items()
    }
    with pytest.raises(SetupError):
        measure_unit("beauty")


def test_a_version_keeps_its_weights_and_its_copies_for_the_other_side_too(
    therapist: Any, stored: tuple[str, str]
) -> None:
    made = draw(therapist, stored, SUM)
    assert made.status_code == 201, made.text
    assert made.json()["design"]["weights"] == SUM
    assert therapist.get(f"/api/template-versions/{stored[1]}").json()["design"]["weights"] == []
    design = TemplateDesign.model_validate({"weights": SUM})
    across = mirrored_design(design, planar_template()).weights
    assert [one.measure for one in across] == [RANGE.replace("right", "left"), "duration"]


@pytest.mark.parametrize(
    "weights",
    [
        [{"measure": "beauty", "weight": 1.0}],
        [{"measure": RANGE, "weight": 0.0}],
        [*SUM, {"measure": RANGE, "weight": 1.0}],
        [{"measure": f"multiple_correlation:{MAIN}", "weight": 1.0}],
    ],
)
def test_what_is_no_part_of_a_sum_is_refused(
    therapist: Any, stored: tuple[str, str], weights: list[dict[str, Any]]
) -> None:
    answer = draw(therapist, stored, weights)
    assert answer.status_code == 422, answer.text
    assert "Part" in answer.json()["message"]


def test_a_repetition_without_a_part_is_not_summed_and_without_any_there_is_no_sum() -> None:
    template, result = compared()
    repetitions = [repetition_comparison(one, template) for one in result.repetitions]
    weights = [WeightDesign.model_validate(one) for one in SUM]
    whole = weighted_sum(weights, template, repetitions)
    assert whole is not None
    assert whole.count == 3
    assert whole.template_value == pytest.approx(sum(one.template_part or 0.0 for one in whole.parts))
    for one in repetitions[0].measures:
        if one.measure == RANGE:
            one.value = None
    fewer = weighted_sum(weights, template, repetitions)
    assert fewer is not None
    assert fewer.count == 2
    assert fewer.value == pytest.approx(sum(one.part or 0.0 for one in fewer.parts))
    for each in repetitions:
        for one in each.measures:
            if one.measure == RANGE:
                one.value = None
    none = weighted_sum(weights, template, repetitions)
    assert none is not None
    assert (none.value, none.uncertainty, none.count) == (None, None, 0)
    assert [one.value is None for one in none.parts] == [True, False]
    assert weighted_sum([], template, repetitions) is None
