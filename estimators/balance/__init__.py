"""Balance: the centre of mass, where it is going, and how far that is from the edge of the feet."""

from estimators.balance._both_feet import BothFeet, body_mass, combine_feet
from estimators.balance._conditions import Change, Sample, compare_conditions
from estimators.balance._foot_distance import distance_between_feet
from estimators.balance._stability import StabilityMargin, base_of_support, sole_corners, stability_margin
from estimators.balance._stride_balance import StrideBalance, sole_middle, stride_balance
from estimators.balance._turning_feet import combine_turning_feet
from estimators.balance.mass_centre._published import MassCentre
from estimators.balance.mass_centre._segments import BodySegments
from estimators.balance.mass_centre._smoother import MassCentreParameters, smooth_mass_centre
from estimators.balance.mass_centre._worn import (
    MASS_POINT,
    MASS_SCALARS,
    WornBodyParameters,
    WornMassCentre,
    has_mass_centre,
)

__all__ = [
    "MASS_POINT",
    "MASS_SCALARS",
    "BodySegments",
    "BothFeet",
    "Change",
    "MassCentre",
    "MassCentreParameters",
    "Sample",
    "StabilityMargin",
    "StrideBalance",
    "WornBodyParameters",
    "WornMassCentre",
    "base_of_support",
    "body_mass",
    "combine_feet",
    "combine_turning_feet",
    "compare_conditions",
    "distance_between_feet",
    "has_mass_centre",
    "smooth_mass_centre",
    "sole_corners",
    "sole_middle",
    "stability_margin",
    "stride_balance",
]
