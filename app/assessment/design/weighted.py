"""The therapist's weighted sum of measures: defined with a version of a template, shown with all its parts.

Measures have different units and no common scale, so the service weighs nothing by itself. What a therapist weighed is
summed within each repetition, so that the spread of the sum is that of the whole, whatever its parts have in common.
"""

import math
from collections.abc import Sequence

import numpy as np

from app.assessment.presentation import measure_shown, number
from app.assessment.schemas import RepetitionComparison, WeightedPart, WeightedSum
from app.errors import InvalidInput
from app.exercises.design import TemplateDesign, WeightDesign
from app.exercises.schemas import TemplateMeasure
from estimators.comparison import Template, measure_label, measures_beside
from estimators.sentences import say


def offered_measures(template: Template) -> list[TemplateMeasure]:
    """Return the measures of which a sum may be made, in the units that people read."""
    found = []
    for name in measures_beside(template):
        unit, factor = measure_shown(name)
        value = number(template.measures.get(name, math.nan), factor)
        found.append(TemplateMeasure(measure=name, label=measure_label(name), unit=unit, value=value))
    return found


def check_weights(design: TemplateDesign, template: Template) -> None:
    """Raise `InvalidInput` for a part that is no measure, stands there twice or weighs nothing."""
    offered = set(measures_beside(template))
    for place, one in enumerate(design.weights):
        if one.measure not in offered or not one.weight:
            raise InvalidInput(say("design.weight", number=place + 1), field=f"design.weights.{place}")
        offered.remove(one.measure)


def weighted_sum(
    weights: Sequence[WeightDesign], template: Template, repetitions: Sequence[RepetitionComparison]
) -> WeightedSum | None:
    """Return the sum over the retained repetitions that have every part; None where the therapist defined none.

    Parameters
    ----------
    weights : sequence of WeightDesign
        Named for the side of `template`.
    """
    if not weights:
        return None
    rows = [
        {measure.measure: measure.value for measure in one.measures}
        for one in repetitions
        if one.repetition.is_kept
    ]
    names = [one.measure for one in weights]
    values = np.array([[_or_nan(row.get(name)) for name in names] for row in rows]).reshape(-1, len(names))
    whole = values[np.isfinite(values).all(axis=1)]
    # Without a whole repetition each part is still shown as far as it is known.
    means = _mean(whole) if len(whole) else _mean(values)
    parts = [_part(one, mean, template) for one, mean in zip(weights, means, strict=True)]
    sums = whole @ np.array([one.weight for one in weights])
    of_template = [part.template_part for part in parts]
    return WeightedSum(
        value=float(sums.mean()) if len(sums) else None,
        uncertainty=float(sums.std(ddof=1)) if len(sums) > 1 else None,
        count=len(sums),
        template_value=None if None in of_template else sum(one for one in of_template if one is not None),
        parts=parts,
    )


def _mean(values: np.ndarray) -> list[float]:
    return [float(np.mean(known)) if len(known := one[np.isfinite(one)]) else math.nan for one in values.T]


def _part(one: WeightDesign, mean: float, template: Template) -> WeightedPart:
    unit, factor = measure_shown(one.measure)
    own = number(template.measures.get(one.measure, math.nan), factor)
    return WeightedPart(
        measure=one.measure,
        label=measure_label(one.measure),
        unit=unit,
        weight=one.weight,
        value=number(mean),
        part=number(one.weight * mean),
        template_value=own,
        template_part=None if own is None else one.weight * own,
    )


def _or_nan(value: float | None) -> float:
    return math.nan if value is None else value
