"""How sensors are expected to sit: the z axis, printed on the case, points away from the body."""

import math
from typing import Final

from estimators.conventions import Placement

OUTWARD_HEADING_RAD: Final[dict[Placement, float]] = {
    "head": 0.0,
    "sternum": 0.0,
    "pelvis": 0.0,
    "foot_left": 0.0,
    "foot_right": 0.0,
    **dict.fromkeys(
        ("shoulder_left", "upper_arm_left", "forearm_left", "hand_left", "thigh_left", "shank_left"),
        math.pi / 2,
    ),
    **dict.fromkeys(
        ("shoulder_right", "upper_arm_right", "forearm_right", "hand_right", "thigh_right", "shank_right"),
        -math.pi / 2,
    ),
}
"""Where the sensor's z axis points in the N-pose, as a heading in the room (0 forward, +90 degrees left).

Head, sternum, pelvis: on the front, facing forward. Arms and legs: on the outer side, facing sideways;
the hand sensor lies on the back of the hand, which faces outward while the palm touches the thigh. Foot: on
the instep, whose slope faces forward and up.
"""

FACING_ORDER: Final[tuple[Placement, ...]] = (
    "sternum",
    "pelvis",
    "upper_arm_right",
    "upper_arm_left",
    "head",
    "thigh_right",
    "thigh_left",
    "forearm_right",
    "forearm_left",
    "hand_right",
    "hand_left",
    "shank_right",
    "shank_left",
    "foot_right",
    "foot_left",
    "shoulder_right",
    "shoulder_left",
)
"""Which sensor tells where the patient faces: the first one worn that can."""

N_POSE_TURN_RAD: Final[dict[Placement, float]] = {
    "forearm_right": math.pi / 2,
    "hand_right": math.pi / 2,
    "forearm_left": -math.pi / 2,
    "hand_left": -math.pi / 2,
}
"""Turn of the segment frame about z in the N-pose, against the anatomical position."""
PUT_ON_RAD: Final = math.radians(4.0)
"""How well people put a sensor on a limb by the mounting rule, about the limb."""
