"""Measures of movement with their undefined cases: of one stroke, between joints, between curves, between sessions."""

from estimators.comparison.measures.coordination import (
    Coordination,
    MultipleCorrelation,
    interjoint_coordination,
    multiple_correlation,
)
from estimators.comparison.measures.paths import Superposition, superimpose
from estimators.comparison.measures.strokes import (
    log_dimensionless_jerk,
    outward_stroke,
    time_to_peak_speed,
    units_per_metre,
)
from estimators.comparison.measures.symmetry import symmetry_angle, symmetry_ratio

__all__ = [
    "Coordination",
    "MultipleCorrelation",
    "Superposition",
    "interjoint_coordination",
    "log_dimensionless_jerk",
    "multiple_correlation",
    "outward_stroke",
    "superimpose",
    "symmetry_angle",
    "symmetry_ratio",
    "time_to_peak_speed",
    "units_per_metre",
]
