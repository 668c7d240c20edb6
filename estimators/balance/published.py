"""Published ways to the centre of mass, and the parts of ours: for experiments and tests."""

from estimators.balance._both_feet import standing, total_reaction
from estimators.balance._repeated_measures import Effect, repeated_measures
from estimators.balance._stability import extrapolated_mass_centre, margin_to_edge, sideways_margin
from estimators.balance._walking_work import WalkingWork, walking_work
from estimators.balance.mass_centre._published import (
    least_squares_mass_centre,
    momentum_anchor,
    pressure_only,
    published_mass_centre,
    vertical_mass_centre,
)
from estimators.balance.mass_centre._segmental import SegmentalMassCentre, segmental_mass_centre
from estimators.balance.mass_centre._segments import body_segments, mean_segments
from estimators.balance.mass_centre._smoother import LiveMassCentre

__all__ = [
    "Effect",
    "LiveMassCentre",
    "SegmentalMassCentre",
    "WalkingWork",
    "body_segments",
    "extrapolated_mass_centre",
    "least_squares_mass_centre",
    "margin_to_edge",
    "mean_segments",
    "momentum_anchor",
    "pressure_only",
    "published_mass_centre",
    "repeated_measures",
    "segmental_mass_centre",
    "sideways_margin",
    "standing",
    "total_reaction",
    "vertical_mass_centre",
    "walking_work",
]
