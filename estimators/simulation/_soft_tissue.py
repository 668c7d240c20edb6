"""Skin that moves over the bone: a sensor turns against its segment as the body moves."""

from collections.abc import Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

from estimators.conventions import PLACEMENTS, Placement, Side
from estimators.simulation.arm.kinematics import Scalar, Turn, compose, turn_about

Float = NDArray[np.float64]

_DRIVERS: Final[dict[str, tuple[str, str]]] = {
    "sternum": ("elevation", "lean_forward"),
    "shoulder": ("elevation", "hike"),
    "upper_arm": ("flexion", "elevation"),
    "forearm": ("pronation", "flexion"),
    "hand": ("wrist_flexion", "pronation"),
    "thigh": ("knee_flexion", "hip_flexion"),
    "shank": ("ankle_flexion", "knee_flexion"),
}
"""Which coordinates move the skin under a sensor: the muscles below it, and the joint next to it."""
_NEUTRAL_RAD: Final = {"pronation": 0.5 * np.pi}
"""Where a coordinate is in the N-pose, if not zero: there the skin is where the sensor was put on."""


def soft_tissue_turn(
    placement: Placement, coordinates: Mapping[str, Scalar], acting_side: Side, largest_rad: float, seed: int
) -> Turn | None:
    """Return the turn of the skin in its segment over time.

    Parameters
    ----------
    coordinates : mapping of str to Scalar
        Of the body, by name (`acting_flexion`, `other_flexion`, `lean_forward`, ...).
    acting_side : Side
        Which arm is the acting one.
    largest_rad : float
        No turn is larger; it is reached when both coordinates are at their worst.

    Returns
    -------
    Turn or None
        None where nothing moves the skin (head, pelvis and feet).

    Notes
    -----
    Two turns about perpendicular axes drawn once a sensor, each the sine of its coordinate against the N-pose:
    they vanish there, are largest with the joint at a right angle and depend on the posture alone, like a
    muscle that bulges. The house's model.
    """
    part, _, side = placement.rpartition("_")
    part = part if side in ("left", "right") else placement
    if largest_rad == 0.0 or part not in _DRIVERS:
        return None
    role = "other" if side in ("left", "right") and side != acting_side else "acting"
    rng = np.random.default_rng([seed, 14, PLACEMENTS.index(placement)])
    first = rng.normal(size=3)
    first /= np.linalg.norm(first)
    second = np.cross(first, rng.normal(size=3))
    second /= np.linalg.norm(second)
    share = rng.uniform(0.25, 0.75)
    # Sizes add up at worst, so they share the largest turn between them.
    sizes = (share * largest_rad, (1.0 - share) * largest_rad)
    turns = []
    for axis, size, name in zip((first, second), sizes, _DRIVERS[part], strict=True):
        driver = coordinates[name] if name in coordinates else coordinates[f"{role}_{name}"]
        turns.append(turn_about(axis, _bulge(driver, _NEUTRAL_RAD.get(name, 0.0), size)))
    return compose(turns[0], turns[1])


def _bulge(driver: Scalar, neutral_rad: float, size: float) -> Scalar:
    sine, cosine = np.sin(driver.value - neutral_rad), np.cos(driver.value - neutral_rad)
    return Scalar(
        size * sine,
        size * cosine * driver.rate,
        size * (cosine * driver.acceleration - sine * driver.rate**2),
    )
