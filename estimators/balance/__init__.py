"""Balance: the centre of mass, where it is going, and how far that is from the edge of the feet."""

from estimators.balance._both_feet import BothFeet, body_mass, combine_feet, standing, total_reaction
from estimators.balance._conditions import Change, Sample, compare_conditions
from estimators.balance._foot_distance import distance_between_feet
from estimators.balance._mass_centre import (
    PUBLISHED_CUTOFF_HZ,
    MassCentre,
    acceleration,
    integrate_twice,
    least_squares_mass_centre,
    momentum_anchor,
    pressure_only,
    published_mass_centre,
    vertical_mass_centre,
)
from estimators.balance._mass_centre_smoother import (
    LiveMassCentre,
    MassCentreParameters,
    smooth_mass_centre,
)
from estimators.balance._repeated_measures import Effect, repeated_measures
from estimators.balance._segmental import SegmentalMassCentre, segmental_mass_centre
from estimators.balance._segments import BodySegments, body_segments, mean_segments
from estimators.balance._stability import (
    StabilityMargin,
    base_of_support,
    extrapolated_mass_centre,
    margin_to_edge,
    sideways_margin,
    sole_corners,
    stability_margin,
)
from estimators.balance._stride_balance import StrideBalance, sole_middle, stride_balance
from estimators.balance._turning_feet import combine_turning_feet
from estimators.balance._walking_work import WalkingWork, walking_work
from estimators.balance._worn_mass_centre import (
    MASS_POINT,
    MASS_SCALARS,
    WornBodyParameters,
    WornMassCentre,
    has_mass_centre,
)

__all__ = [
    "MASS_POINT",
    "MASS_SCALARS",
    "PUBLISHED_CUTOFF_HZ",
    "BodySegments",
    "BothFeet",
    "Change",
    "Effect",
    "LiveMassCentre",
    "MassCentre",
    "MassCentreParameters",
    "Sample",
    "SegmentalMassCentre",
    "StabilityMargin",
    "StrideBalance",
    "WalkingWork",
    "WornBodyParameters",
    "WornMassCentre",
    "acceleration",
    "base_of_support",
    "body_mass",
    "body_segments",
    "combine_feet",
    "combine_turning_feet",
    "compare_conditions",
    "distance_between_feet",
    "extrapolated_mass_centre",
    "has_mass_centre",
    "integrate_twice",
    "least_squares_mass_centre",
    "margin_to_edge",
    "mean_segments",
    "momentum_anchor",
    "pressure_only",
    "published_mass_centre",
    "repeated_measures",
    "segmental_mass_centre",
    "sideways_margin",
    "smooth_mass_centre",
    "sole_corners",
    "sole_middle",
    "stability_margin",
    "standing",
    "stride_balance",
    "total_reaction",
    "vertical_mass_centre",
    "walking_work",
]
