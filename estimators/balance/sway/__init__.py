"""Standing on a trunk sensor: how much somebody sways, with uncertainty; eyes closed over open; functional reach."""

from estimators.balance.sway._measures import (
    SHORTEST_S,
    Ellipse,
    Reach,
    Trial,
    reach,
    romberg_ratio,
    sway_ellipse,
    sway_measures,
)
from estimators.balance.sway._posture import posture, sway_acceleration
from estimators.balance.sway._spectrum import SwayMeasure, SwaySpectrum

__all__ = [
    "SHORTEST_S",
    "Ellipse",
    "Reach",
    "SwayMeasure",
    "SwaySpectrum",
    "Trial",
    "posture",
    "reach",
    "romberg_ratio",
    "sway_acceleration",
    "sway_ellipse",
    "sway_measures",
]
