"""Which worn sensor stands next to which along an arm, and where on their bones they usually sit."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from estimators.body import BodyDimensions
from estimators.conventions import SIDES, Placement, Side
from estimators.recording import Float

_UPPER_ARM: Final = 0.60
_FOREARM: Final = 0.80
_HAND: Final = 0.40
_STERNUM: Final = 0.80
"""Share of the length of the segment at which its sensor sits. A third of it more or less changes what a turn must move
by as much, and what is asked here is whether the sensors moved at all."""
_SKIN_M: Final = 0.04
_CHEST_M: Final = 0.10


@dataclass(frozen=True)
class Link:
    """One worn segment with its neighbours.

    Attributes
    ----------
    side : Side or None
        None for the trunk.
    proximal, distal : Placement or None
        Worn neighbours towards and away from the trunk.
    sensor_m : ndarray, shape (3,)
        From the joint with the proximal neighbour to the sensor, in the segment's axes.
    end_m : ndarray, shape (3,)
        From that joint to the joint with the distal neighbour.
    """

    name: Placement
    side: Side | None
    proximal: Placement | None
    distal: Placement | None
    sensor_m: Float
    end_m: Float

    @property
    def is_hand(self) -> bool:
        """Whether it is the last of its arm: only its twist is bounded by a joint."""
        return self.name.startswith("hand")


def links(placements: Sequence[Placement], body: BodyDimensions) -> dict[Placement, Link]:
    """Return the worn segments of trunk and arms whose sensor may be found to have turned.

    Parameters
    ----------
    placements : sequence of Placement
        Worn sensors.
    body : BodyDimensions
        Metres between joint centres.

    Returns
    -------
    dict of Placement to Link
        Without head, shoulders, pelvis and legs.
    """
    worn = set(placements)
    found: dict[Placement, Link] = {}
    if "sternum" in worn:
        pelvis: Placement | None = "pelvis" if "pelvis" in worn else None
        chest = np.array([_CHEST_M, 0.0, _STERNUM * body.trunk_m])
        found["sternum"] = Link("sternum", None, pelvis, None, chest, np.zeros(3))
    for side in SIDES:
        out = 1.0 if side == "left" else -1.0
        upper: Placement = "upper_arm_left" if side == "left" else "upper_arm_right"
        fore: Placement = "forearm_left" if side == "left" else "forearm_right"
        hand: Placement = "hand_left" if side == "left" else "hand_right"
        chain: tuple[Placement | None, ...] = ("sternum", upper, fore, hand, None)
        lengths = (body.upper_arm_m, body.forearm_m, body.hand_m)
        seats = (
            np.array([0.0, out * _SKIN_M, -_UPPER_ARM * body.upper_arm_m]),
            np.array([-_SKIN_M, 0.0, -_FOREARM * body.forearm_m]),
            np.array([-0.5 * _SKIN_M, 0.0, -_HAND * body.hand_m]),
        )
        for i, name in enumerate((upper, fore, hand)):
            if name in worn:
                before, after = chain[i], chain[i + 2]
                found[name] = Link(
                    name,
                    side,
                    before if before in worn else None,
                    after if after in worn else None,
                    seats[i],
                    np.array([0.0, 0.0, -lengths[i]]),
                )
    return found


def shoulder_m(side: Side, body: BodyDimensions) -> Float:
    """Return the shoulder's centre from the hips' in the axes of the trunk, shape (3,)."""
    return np.array([0.0, (0.5 if side == "left" else -0.5) * body.shoulder_width_m, body.trunk_m])


PELVIS_SENSOR_M: Final = np.array([_CHEST_M, 0.0, 0.05])
"""From the hips' centre to the sensor on the pelvis, in its axes."""
