"""Proportions of the figure: what the measured body dimensions leave open, from stature."""

from typing import Final

from app.exercises.models import Posture
from estimators.body import HIP_HEIGHT_PER_STATURE, BodyDimensions

REFERENCE_STATURE_M: Final = 1.70
# Heights of knee and ankle as shares of stature: Drillis and Contini (1966), see `estimators.body`.
KNEE_SHARE, ANKLE_SHARE = 0.285, 0.039


def hip_height_m(body: BodyDimensions, posture: Posture = "standing") -> float:
    """Return the height of the hip centres above the floor; of who sits upright, that of the knees."""
    return (KNEE_SHARE if posture == "seated" else HIP_HEIGHT_PER_STATURE) * body.stature_m


def neck_height_m(body: BodyDimensions) -> float:
    """Return the height of the base of the neck (the origin of the head) above the hips."""
    return body.trunk_m + 0.02 * body.stature_m / REFERENCE_STATURE_M


def leg_lengths_m(body: BodyDimensions) -> tuple[float, float, float]:
    """Return lengths of thigh and shank and the height of the ankle."""
    return (
        (HIP_HEIGHT_PER_STATURE - KNEE_SHARE) * body.stature_m,
        (KNEE_SHARE - ANKLE_SHARE) * body.stature_m,
        ANKLE_SHARE * body.stature_m,
    )


def hip_half_width_m(body: BodyDimensions) -> float:
    """Return half the distance between the hip centres."""
    return 0.047 * body.stature_m
