"""A body's centre of mass as a sum of vectors fixed in its segments.

Every part hangs from a chain of segments, so its place is a sum of vectors that segments turn; weighed by mass, all
chains together are one vector a segment: `c = hip + sum of R_s b_s`. The same holds for the ankles.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from estimators.balance.mass_centre._segments import (
    FOOT_PER_STATURE,
    HEAD_PER_STATURE,
    SHANK_PER_STATURE,
    THIGH_PER_STATURE,
    BodySegments,
)
from estimators.body import ANKLE_HEIGHT_PER_STATURE, BodyDimensions
from estimators.conventions import PLACEMENTS, SIDES
from estimators.recording import Float

HIP_HALF_WIDTH_PER_STATURE = 0.05
HEEL_BEHIND_ANKLE = 0.25
"""Part of the foot's length."""
MIDDLE_TRUNK: Final = "middle_trunk"
STAND_IN: Final = {
    "pelvis": "sternum",
    "sternum": "pelvis",
    "head": "sternum",
    "shoulder": "sternum",
    "upper_arm": "sternum",
    "forearm": "upper_arm",
    "hand": "forearm",
    "thigh": "pelvis",
    "shank": "thigh",
    "foot": "shank",
}
"""With which segment one without a sensor moves; the limb's on its own side."""

Levers = dict[str, Float]


@dataclass(frozen=True)
class BodyLevers:
    """Vectors in segment axes, metres, from the middle of the hips.

    Attributes
    ----------
    mass : dict of str to ndarray, shape (3,)
        Sum to the centre of mass. Segments are the seventeen placements and `MIDDLE_TRUNK`, which has the mean
        orientation of pelvis and sternum.
    ankle : dict of Side to dict of str to ndarray
        Sum to each ankle.
    """

    mass: Levers
    ankle: dict[str, Levers]
    ankle_height_m: float


def body_levers(segments: BodySegments, body: BodyDimensions) -> BodyLevers:
    """Return the levers of a body.

    Notes
    -----
    `c = sum of m_j c_j` (Schepers 2009, equation 4.7) with the chain of `segmental_mass_centre`, sums exchanged.
    """
    stature = body.stature_m
    share, masses = segments.centre_share, segments.masses()
    up = np.array([0.0, 0.0, 1.0])
    total: Levers = {name: np.zeros(3) for name in (*PLACEMENTS, MIDDLE_TRUNK)}

    def weigh(part: str, place: Levers) -> None:
        for name, vector in place.items():
            total[name] = total[name] + masses[part] * vector

    base: Levers = {}
    for name, part, length in (
        ("pelvis", "lower_trunk", segments.trunk_share[2]),
        (MIDDLE_TRUNK, "middle_trunk", segments.trunk_share[1]),
        ("sternum", "upper_trunk", segments.trunk_share[0]),
    ):
        long = length * body.trunk_m * up
        weigh(part, base | {name: (1.0 - share[part]) * long})
        base = base | {name: long}
    weigh("head", base | {"head": (1.0 - share["head"]) * HEAD_PER_STATURE * stature * up})
    ankle: dict[str, Levers] = {}
    for side in SIDES:
        outward = np.array([0.0, 1.0 if side == "left" else -1.0, 0.0])
        arm = base | {f"shoulder_{side}": 0.5 * body.shoulder_width_m * outward}
        # The table's hand ends at the knuckle of the middle finger.
        lengths = (("upper_arm", body.upper_arm_m), ("forearm", body.forearm_m), ("hand", 0.5 * body.hand_m))
        leg: Levers = {"pelvis": HIP_HALF_WIDTH_PER_STATURE * stature * outward}
        bones = (("thigh", THIGH_PER_STATURE * stature), ("shank", SHANK_PER_STATURE * stature))
        for chain, parts in ((arm, lengths), (leg, bones)):
            for part, length in parts:
                name = f"{part}_{side}"
                weigh(name, chain | {name: -share[part] * length * up})
                chain[name] = -length * up
        ankle[side] = leg
        ahead = (share["foot"] - HEEL_BEHIND_ANKLE) * FOOT_PER_STATURE * stature
        below = 0.5 * ANKLE_HEIGHT_PER_STATURE * stature
        weigh(f"foot_{side}", leg | {f"foot_{side}": np.array([ahead, 0.0, -below])})
    return BodyLevers(total, ankle, ANKLE_HEIGHT_PER_STATURE * stature)


def stand_in_of(name: str) -> str:
    """Return the segment with which one without a sensor moves."""
    part, _, side = name.rpartition("_")
    if side not in SIDES:
        return STAND_IN[name]
    own = f"{STAND_IN[part]}_{side}"
    return own if own in PLACEMENTS else STAND_IN[part]
