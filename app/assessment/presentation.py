"""From the library's numbers to what people read: names, degrees, and None where nothing was measured.

Here is the one place where radians become degrees. Keys of measures (`RepetitionMeasure.measure`) are those of
`estimators.measures`; `multiple_correlation:` and `repetition_rms:`, of all repetitions together, are stored as
repetition 0.

The main measure of an exercise is ``range:<primary angle>``.
"""

import math
from collections.abc import Sequence
from typing import Final

import numpy as np

from app.assessment.schemas import MeasureValue, RepetitionComparison
from app.exercises.design import PhaseDesign
from app.exercises.schemas import PhaseCurve, RepetitionOut
from estimators.comparison import (
    ComparisonResult,
    Measure,
    Repetition,
    RepetitionResult,
    Template,
    channel_label,
    channel_unit,
    measure_label,
    measure_unit,
)
from estimators.recording import Float

_SHOWN: Final[dict[str, tuple[str, float]]] = {
    "rad": ("deg", 180.0 / math.pi),
    "rad/s": ("deg/s", 180.0 / math.pi),
}


_OF_ONE: Final = {"joint_lag": ("ms", 1000.0)}
"""Measures that are too small for the unit of their kind."""


def shown_unit(unit: str) -> tuple[str, float]:
    """Return the unit that people read and the factor to it."""
    return _SHOWN.get(unit, (unit, 1.0))


def number(value: float, factor: float = 1.0) -> float | None:
    """Return a finite number for JSON, or None."""
    return float(value) * factor if math.isfinite(value) else None


def curve_values(values: Float, factor: float) -> list[float | None]:
    """Return one curve over 101 phases for JSON, rounded to what a screen can show."""
    return [round(value * factor, 5) if math.isfinite(value) else None for value in values.tolist()]


def repetition_out(repetition: Repetition) -> RepetitionOut:
    """Return a repetition as clients see it."""
    return RepetitionOut(
        number=repetition.number,
        start_s=repetition.start_s,
        end_s=repetition.end_s,
        is_kept=repetition.is_kept,
        reason=repetition.reason,
        counted=repetition.counted,
    )


def phase_curves_out(template: Template, repetitions: Sequence[Float]) -> list[PhaseCurve]:
    """Return each measured channel of a template with its band and the repetitions' curves.

    Parameters
    ----------
    repetitions : sequence of ndarray, shape (101, C)
        In the template's channels.
    """
    curves = []
    for column, channel in enumerate(template.channels):
        if not np.isfinite(template.mean[:, column]).any():
            continue
        unit, factor = shown_unit(channel_unit(channel))
        mean = template.mean[:, column]
        curves.append(
            PhaseCurve(
                channel=channel,
                label=channel_label(channel),
                unit=unit,
                mean=curve_values(mean, factor),
                low=curve_values(mean - template.below[:, column], factor),
                high=curve_values(mean + template.above[:, column], factor),
                width=curve_values(template.tolerance[:, column], factor),
                is_judged=bool(template.counts[column]),
                repetitions=[curve_values(curve[:, column], factor) for curve in repetitions],
            )
        )
    return curves


def phases_out(template: Template) -> list[PhaseDesign]:
    """Return the phases that the therapist named."""
    return [PhaseDesign(name=one.name, start=one.start, end=one.end) for one in template.phases]


def measure_shown(name: str) -> tuple[str, float]:
    """Return the unit that people read a measure of a repetition in, and the factor to it."""
    return _OF_ONE.get(name) or shown_unit(measure_unit(name))


def measure_out(measure: Measure, template: Template) -> MeasureValue:
    """Return a measure as clients see it, beside the template's own value."""
    unit, factor = _OF_ONE.get(measure.name) or shown_unit(measure.unit)
    return MeasureValue(
        measure=measure.name,
        label=measure_label(measure.name),
        value=number(measure.value, factor),
        unit=unit,
        uncertainty=number(measure.uncertainty, factor),
        count=measure.count,
        template_value=number(template.measures.get(measure.name, math.nan), factor),
        group=measure.group,
        note=measure.note,
    )


def repetition_comparison(result: RepetitionResult, template: Template) -> RepetitionComparison:
    """Return one repetition beside the template."""
    return RepetitionComparison(
        repetition=repetition_out(result.repetition),
        measures=[measure_out(measure, template) for measure in result.measures],
        outside_band={
            channel: [(int(a), int(b)) for a, b in spans] for channel, spans in result.outside.items()
        },
        warp_template_phase=[round(phase, 3) for phase in result.warp_template_phase.tolist()],
    )


def summary_out(result: ComparisonResult, template: Template) -> list[MeasureValue]:
    """Return the summary over the accepted repetitions."""
    return [measure_out(measure, template) for measure in result.summary]
