"""Joints that move one way only: where elbow, knee and upper arm went, against where they can go."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from estimators import rotation
from estimators.conventions import SIDES, Placement, Side
from estimators.recording import Float

LEAST_S: Final = 2.0
LEAST_SHARE: Final = 0.1
"""So long and so often must a joint be where it cannot be: what skin and a hasty movement do is over sooner."""
BENT_RAD: Final = math.radians(30.0)
"""Bent less, a joint shows no direction: arms rest bent by 10 to 20 degrees, and elbows stretch beyond by 15."""
_FURTHEST_RAD: Final[Mapping[str, float]] = {"elbow": math.radians(168.0), "knee": math.radians(172.0)}
"""No joint bends so far: 150 and 155 degrees are the most."""
_BACKWARD_RAD: Final = math.radians(95.0)
_AROUND_RAD: Final = math.radians(45.0)
_RAISED_RAD: Final = (math.radians(65.0), math.radians(140.0))
"""An upper arm goes back to 60 degrees; raised higher than the other, its direction tells little."""
_HANGING_RAD: Final = math.radians(65.0)
_ACROSS_RAD: Final = math.radians(80.0)
_BEHIND_RAD: Final = math.radians(-130.0)
"""A raised right arm lies between these directions in the trunk, 0 forward and +90 degrees left."""
_DOWN: Final = np.array([0.0, 0.0, -1.0])

Bones = Literal["elbow", "knee"]


@dataclass(frozen=True)
class Hinge:
    """A joint that bends one way."""

    joint: Bones
    side: Side
    upper: Placement
    lower: Placement


def _hinge(joint: Bones, side: Side) -> Hinge:
    left = side == "left"
    if joint == "elbow":
        pair: tuple[Placement, Placement] = (
            ("upper_arm_left", "forearm_left") if left else ("upper_arm_right", "forearm_right")
        )
    else:
        pair = ("thigh_left", "shank_left") if left else ("thigh_right", "shank_right")
    return Hinge(joint, side, *pair)


HINGES: Final = tuple(_hinge(joint, side) for joint in ("elbow", "knee") for side in SIDES)


@dataclass(frozen=True, eq=False)
class Bending:
    """Where a joint bent.

    Attributes
    ----------
    bent_s : float
        How long it was bent.
    wrong_s : float
        Of that, how long backward, or further than it can.
    bend_rad : ndarray, shape (N,)
        Of the samples in which it was bent: by how much.
    direction_rad : ndarray, shape (N,)
        Of the same: off the direction in which it can bend, about the long axis of the upper segment, positive to
        the left.
    """

    hinge: Hinge
    bent_s: float
    wrong_s: float
    bend_rad: Float
    direction_rad: Float

    @property
    def is_wrong(self) -> bool:
        """Whether it was where it cannot be, long and often enough."""
        return self.wrong_s >= max(LEAST_S, LEAST_SHARE * self.bent_s)

    @property
    def mean_rad(self) -> float:
        """Mean direction; samples bent far count most."""
        weight = np.sin(self.bend_rad)
        total = np.sum(weight * np.exp(1j * self.direction_rad))
        return math.atan2(float(total.imag), float(total.real))

    def share_around(self, direction_rad: float) -> float:
        """Return the share of samples within 45 degrees of a direction; 0 without any."""
        if not len(self.direction_rad):
            return 0.0
        away = np.abs(np.angle(np.exp(1j * (self.direction_rad - direction_rad))))
        return float(np.mean(away < _AROUND_RAD))

    @property
    def furthest_wrong_rad(self) -> float:
        """The flexion that no joint can have, as it reads: negative when bent backward; NaN where there is none."""
        if not self.wrong_s:
            return math.nan
        reads = self.bend_rad * np.sign(np.cos(self.direction_rad))
        worst = float(np.percentile(reads, 2.0))
        return worst if worst < -BENT_RAD / 2.0 else float(np.percentile(reads, 98.0))


@dataclass(frozen=True, eq=False)
class Raising:
    """Where an upper arm was raised to.

    Attributes
    ----------
    raised_s : float
        How long it was raised above the height to which it can go back.
    wrong_s : float
        Of that, how long it pointed behind the back or through the trunk.
    hanging_s : float
        Of that, how long it hung down in the room: then the trunk leaned.
    """

    side: Side
    raised_s: float
    wrong_s: float
    hanging_s: float

    @property
    def is_wrong(self) -> bool:
        """Whether it was where it cannot be, long and often enough."""
        return self.wrong_s >= max(LEAST_S, LEAST_SHARE * self.raised_s)

    @property
    def is_of_trunk(self) -> bool:
        """Whether rather the trunk than the arm was where it cannot be."""
        return self.is_wrong and self.hanging_s > 0.5 * self.wrong_s


def bent(hinge: Hinge, q_upper: Float, q_lower: Float, step_s: float) -> Bending:
    """Return how a joint bent.

    Parameters
    ----------
    q_upper, q_lower : ndarray, shape (N, 4)
        Segments in one frame, NaN where unknown.
    step_s : float
        Between samples.
    """
    limb = rotation.rotate(rotation.conjugate(q_upper), rotation.rotate(q_lower, _DOWN))
    known = np.isfinite(limb).all(axis=1)
    limb = limb[known]
    bend = np.arccos(np.clip(-limb[:, 2], -1.0, 1.0))
    forward = 1.0 if hinge.joint == "elbow" else -1.0
    direction = np.arctan2(forward * limb[:, 1], forward * limb[:, 0])
    is_bent = bend > BENT_RAD
    too_far = bend > _FURTHEST_RAD[hinge.joint]
    backward = is_bent & ~too_far & (np.abs(direction) > _BACKWARD_RAD)
    wrong_s = step_s * float(np.count_nonzero(backward | too_far))
    bent_s = step_s * float(np.count_nonzero(is_bent))
    return Bending(hinge, bent_s, wrong_s, bend[is_bent], direction[is_bent])


def raised(side: Side, q_trunk: Float, q_upper: Float, step_s: float) -> Raising:
    """Return where an upper arm was raised to.

    Parameters
    ----------
    q_trunk, q_upper : ndarray, shape (N, 4)
        Segments in one frame, z up, NaN where unknown.
    step_s : float
        Between samples.
    """
    in_room = rotation.rotate(q_upper, _DOWN)
    arm = rotation.rotate(rotation.conjugate(q_trunk), in_room)
    known = np.isfinite(arm).all(axis=1)
    arm, in_room = arm[known], in_room[known]
    elevation = np.arccos(np.clip(-arm[:, 2], -1.0, 1.0))
    across = arm[:, 1] if side == "right" else -arm[:, 1]
    direction = np.arctan2(across, arm[:, 0])
    is_raised = (elevation > _RAISED_RAD[0]) & (elevation < _RAISED_RAD[1])
    wrong = is_raised & ((direction > _ACROSS_RAD) | (direction < _BEHIND_RAD))
    hanging = wrong & (-in_room[:, 2] > math.cos(_HANGING_RAD))
    raised_s, wrong_s, hanging_s = (
        step_s * float(np.count_nonzero(one)) for one in (is_raised, wrong, hanging)
    )
    return Raising(side, raised_s, wrong_s, hanging_s)


def bendings(names: Sequence[str], q_room_segment: Float, step_s: float) -> tuple[Bending, ...]:
    """Return how every joint bent whose two segments are worn; segments shape (N, G, 4) in the order of `names`."""
    return tuple(
        bent(
            one, q_room_segment[:, names.index(one.upper)], q_room_segment[:, names.index(one.lower)], step_s
        )
        for one in HINGES
        if one.upper in names and one.lower in names
    )


def raisings(names: Sequence[str], q_room_segment: Float, step_s: float) -> tuple[Raising, ...]:
    """Return where every worn upper arm was raised to, seen from the chest; empty where it is not worn: people turn.

    From the pelvis nothing is judged: the chest turns over it by more than an arm can be raised beyond the side.
    """
    if "sternum" not in names:
        return ()
    q_trunk = q_room_segment[:, names.index("sternum")]
    return tuple(
        raised(side, q_trunk, q_room_segment[:, names.index(f"upper_arm_{side}")], step_s)
        for side in SIDES
        if f"upper_arm_{side}" in names
    )
