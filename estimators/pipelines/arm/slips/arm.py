"""One stretch of movement as a chain of links: what neighbours say of each other's turns."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from estimators import rotation
from estimators.body import BodyDimensions
from estimators.conventions import SIDES, Placement
from estimators.pipelines.arm.slips.chain import PELVIS_SENSOR_M, Link, links, shoulder_m
from estimators.pipelines.arm.slips.motion import Motion
from estimators.recording import Float

_LONG_AXIS = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class Lever:
    """A place that a turn of a segment about its proximal joint has to move.

    Attributes
    ----------
    lever_m : ndarray, shape (3,)
        From that joint to the place, in the segment's axes.
    velocity_mps : ndarray, shape (K, 3)
        Measured against the proximal joint's frame, in the room, less what the proximal segment's own turn gives:
        that of the segment against its neighbour times the lever, but for what speed the stretch began with.
    """

    lever_m: Float
    velocity_mps: Float


class Chain:
    """A stretch of movement of trunk and arms."""

    def __init__(self, motion: Motion, body: BodyDimensions) -> None:
        self.motion, self._body = motion, body
        self.step_s = motion.step_s
        self.links = links(motion.names, body)

    def samples(self, duration_s: float) -> int:
        """Return a duration as a number of ticks."""
        return round(duration_s / self.step_s)

    def posture(self, name: Placement) -> Float:
        """Return the orientation of a segment in the room, shape (K, 4)."""
        return self.motion.q_room_segment[:, self.motion.names.index(name)]

    def rate(self, name: Placement | None) -> Float:
        """Return the turning rate of a sensor in the room, shape (K, 3); of one that is not worn, zero."""
        if name is None:
            return np.zeros((len(self.motion.time_s), 3))
        return self.motion.rate_room_radps[:, self.motion.names.index(name)]

    @cached_property
    def _velocity(self) -> Float:
        return np.cumsum(self.motion.acceleration_room_mps2, axis=0) * self.step_s

    def velocity(self, name: Placement) -> Float:
        """Return the integral of a sensor's acceleration, shape (K, 3), m/s."""
        return np.asarray(self._velocity[:, self.motion.names.index(name)])

    def between(self, proximal: Placement | None, distal: Placement) -> Float:
        """Return the posture of one segment seen from another, or from the room, shape (K, 4)."""
        q = self.posture(distal)
        return q if proximal is None else rotation.multiply(rotation.conjugate(self.posture(proximal)), q)

    def neighbours(self, link: Link) -> list[Float]:
        """Return what all others say of where the segment should be: postures to be found again.

        Of a segment between two worn ones the distal neighbour seen from the proximal one, of the last of an arm how
        its neighbour stands, of the trunk both upper arms. Empty where nobody can say.
        """
        if link.side is None:
            uppers = [one for one in self.links.values() if one.name.startswith("upper_arm")]
            return [self.between(link.proximal, one.name) for one in uppers]
        if link.distal is not None:
            return [self.between(link.proximal, link.distal)]
        if link.proximal is None:
            return []
        return [self.between(self.links[link.proximal].proximal, link.proximal)]

    def is_whole(self, link: Link, first: int, stop: int) -> bool:
        """Say whether a segment and its neighbours were measured all the time between two ticks."""
        names = [name for name in (link.name, link.proximal, link.distal) if name is not None]
        return all(bool(np.isfinite(self.posture(name)[max(first, 0) : stop]).all()) for name in names)

    def twist(self, link: Link, against: Placement | None) -> Float:
        """Return the turn about the segment's long axis against another's turn, summed up, shape (K,), rad."""
        axis = rotation.rotate(self.posture(link.name), _LONG_AXIS)
        rate = np.sum((self.rate(link.name) - self.rate(against)) * axis, axis=1)
        return np.cumsum(np.nan_to_num(rate)) * self.step_s

    def levers(self, link: Link) -> list[Lever]:
        """Return the places that a turn of the segment against its proximal neighbour has to move."""
        turning = self.rate(link.proximal)

        def swung(rate: Float, posture: Float, lever_m: Float) -> Float:
            return np.cross(rate, rotation.rotate(posture, lever_m))

        own, base = self.posture(link.name), np.zeros_like(turning)
        if link.proximal is not None:
            base = self.velocity(link.proximal) + swung(
                turning, self.posture(link.proximal), self._to_joint(link)
            )
        found = [Lever(link.sensor_m, self.velocity(link.name) - base - swung(turning, own, link.sensor_m))]
        if link.side is None:
            ends = [
                (self.links[upper], shoulder_m(side, self._body))
                for side in SIDES
                for upper in self.links
                if upper == f"upper_arm_{side}"
            ]
        else:
            ends = [] if link.distal is None else [(self.links[link.distal], link.end_m)]
        for end, lever_m in ends:
            joint = self.velocity(end.name) - swung(self.rate(end.name), self.posture(end.name), end.sensor_m)
            found.append(Lever(lever_m, joint - base - swung(turning, own, lever_m)))
        return found

    def _to_joint(self, link: Link) -> Float:
        """Return the way from the proximal neighbour's sensor to the joint with this segment, in its axes."""
        if link.proximal == "pelvis":
            return -PELVIS_SENSOR_M
        assert link.proximal is not None
        before = self.links[link.proximal]
        if before.side is None:
            assert link.side is not None
            return shoulder_m(link.side, self._body) - before.sensor_m
        return before.end_m - before.sensor_m
