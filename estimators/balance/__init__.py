"""Balance: the centre of mass, where it is going, and how far that is from the edge of the feet."""

from estimators.balance._both_feet import BothFeet, body_mass, combine_feet, standing, total_reaction
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

__all__ = [
    "PUBLISHED_CUTOFF_HZ",
    "BothFeet",
    "LiveMassCentre",
    "MassCentre",
    "MassCentreParameters",
    "acceleration",
    "body_mass",
    "combine_feet",
    "distance_between_feet",
    "integrate_twice",
    "least_squares_mass_centre",
    "momentum_anchor",
    "pressure_only",
    "published_mass_centre",
    "smooth_mass_centre",
    "standing",
    "total_reaction",
    "vertical_mass_centre",
]
