"""Live guidance along a template: phase with its uncertainty, attained size, repetitions counted as they end.

::

    ready = prepare_template(template, "right", reach_m=0.55)
    guide = Guide(ready, tick_s=0.01)
    chunk = guide.feed(*signals(trajectory(frames), ready))
"""

from estimators.guidance._bands import FREE, Knot, ToleranceCurve, tolerance_band
from estimators.guidance._contract import (
    KINDS,
    CountedRepetition,
    GuidanceChunk,
    GuidanceParameters,
    GuidanceTemplate,
    RepetitionKind,
)
from estimators.guidance._guide import Guide
from estimators.guidance._template import prepare_template, signals, steers

__all__ = [
    "FREE",
    "KINDS",
    "CountedRepetition",
    "GuidanceChunk",
    "GuidanceParameters",
    "GuidanceTemplate",
    "Guide",
    "Knot",
    "RepetitionKind",
    "ToleranceCurve",
    "prepare_template",
    "signals",
    "steers",
    "tolerance_band",
]
