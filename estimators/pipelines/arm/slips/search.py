"""The search for sensors that turned in their strap, over a whole session in bounded memory."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from estimators.conventions import Placement
from estimators.pipelines._contract import Frames, SessionSetup
from estimators.pipelines.arm.slips.arm import Chain
from estimators.pipelines.arm.slips.chain import Link, links
from estimators.pipelines.arm.slips.evidence import Proof, jumped, turned_on_the_spot, twisted_alone
from estimators.pipelines.arm.slips.motion import RATE_HZ, Motion, motion_of
from estimators.pipelines.arm.slips.posture import AFTER_S, BEFORE_S, GAP_S, Postures, Shift
from estimators.recording import ImuChunk

_EVERY_S: Final = 1.0
_STRETCH_S: Final = 180.0
_LONG_AXIS_SHARE: Final = 0.9
_CLEARLY: Final = 3.0
"""Otherwise both are named, as a doubt between two: see `in_doubt`."""
_SAME_S: Final = 2.5
_LEAST_RATE_HZ: Final = 0.8 * RATE_HZ


@dataclass(frozen=True)
class Slip:
    """A sensor that turned on its segment, and stayed so.

    Attributes
    ----------
    time_s : float
        Session time of the middle of the turn.
    turn_rad : (float, float, float)
        Rotation vector in the axes of the segment: how far it seems to have turned since.
    sigma_rad : float
        How well each component is known.
    """

    placement: Placement
    time_s: float
    turn_rad: tuple[float, float, float]
    sigma_rad: float

    @property
    def angle_rad(self) -> float:
        """How far it turned."""
        return float(np.linalg.norm(self.turn_rad))


class SlipSearch:
    """Looks for slips while a session goes by; memory holds some minutes of it.

    A slip is named where two things agree: for many seconds after it the segment is off where it was in the same
    posture of its neighbours, and it came there by a quick turn that its neighbours did not share, as joints and levers
    would need. What a movement explains as well is not named: a forearm without a sensor on the hand that turns about
    its long axis pronates, and an upper arm without one on the trunk that tilts was raised.

    Parameters
    ----------
    setup : SessionSetup
        With the calibration in force.
    from_s : float
        Session time from which the sensors are worn as they were calibrated.
    """

    def __init__(self, setup: SessionSetup, from_s: float = 0.0) -> None:
        self._setup, self._from_s = setup, from_s
        found = links(setup.placements, setup.body)
        self._names = tuple(
            name for name in setup.placements if name in found or (name == "pelvis" and "sternum" in found)
        )
        is_mounted = setup.calibration is not None and bool(setup.calibration.q_sensor_segment)
        self._watches = is_mounted and setup.rate_hz >= _LEAST_RATE_HZ and bool(found)
        self._parts: list[Motion] = []
        self._looked_s = from_s
        self._since_s: dict[Placement, float] = dict.fromkeys(found, from_s)
        self.found: list[Slip] = []
        """By time within a stretch of some minutes."""

    def add(self, frames: Frames, chunk: ImuChunk) -> None:
        """Take the next ticks: frames as the arm pipeline gave them, and the samples that they were made of."""
        if not self._watches or not frames.tick_count or frames.time_s[-1] < self._from_s:
            return
        part = motion_of(frames, chunk, self._setup, self._names).after(self._from_s)
        if not len(part.time_s):
            return
        self._parts.append(part)
        if part.time_s[-1] - self._parts[0].time_s[0] > _STRETCH_S:
            self._look(float(part.time_s[-1]) - AFTER_S)

    def finish(self) -> tuple[Slip, ...]:
        """Look at what is left and return all slips, earliest first."""
        if self._parts:
            self._look(float(self._parts[-1].time_s[-1]) - GAP_S)
        return tuple(sorted(self.found, key=lambda one: one.time_s))

    def _look(self, until_s: float) -> None:
        """Search up to a moment, and forget what no later moment is compared with."""
        motion = Motion.join(self._parts)
        if len(motion.time_s) > 2:
            chain = Chain(motion, self._setup.body)
            moments = np.arange(self._looked_s + _EVERY_S, until_s, _EVERY_S)
            for link in chain.links.values():
                for slip in list(self._of_link(chain, link, moments)):
                    self.found.append(slip)
                    self._since_s[slip.placement] = max(self._since_s[slip.placement], slip.time_s + GAP_S)
            self._looked_s = float(moments[-1]) if len(moments) else self._looked_s
        self._parts = [motion.after(until_s - BEFORE_S - GAP_S)]

    def _of_link(
        self, chain: Chain, link: Link, moments: "np.ndarray[tuple[int], np.dtype[np.float64]]"
    ) -> Iterator[Slip]:
        postures, since_s = Postures(chain, link), self._since_s[link.name]
        shifts = [
            (float(moment_s), shift)
            for moment_s in moments
            if (shift := postures.shift(float(moment_s), since_s)) is not None
        ]
        # The clearest first: beside a slip part of what is compared lies on its other side.
        shifts.sort(key=lambda one: one[1].spread_rad / one[1].size_rad)
        taken: list[float] = []
        for moment_s, shift in shifts:
            if any(abs(moment_s - one) < AFTER_S for one in taken):
                continue
            proof = _evidence(chain, link, moment_s, shift)
            if proof is not None:
                taken.append(moment_s)
                x, y, z = (float(v) for v in shift.turn_rad)
                at_s = float(chain.motion.time_s[proof.tick])
                yield Slip(link.name, at_s, (x, y, z), shift.spread_rad)


def _evidence(chain: Chain, link: Link, moment_s: float, shift: Shift) -> Proof | None:
    """Return what proves a shift to be a slip."""
    tick = int(np.searchsorted(chain.motion.time_s, moment_s))
    is_twist = abs(shift.turn_rad[2]) > _LONG_AXIS_SHARE * shift.size_rad and link.side is not None
    if is_twist and not link.is_hand and link.distal is None:
        # It reads as a pronation, or as a turn of the whole arm.
        return None
    if not is_twist:
        # Somebody who leans on the elbow raises the upper arm, too; a worn trunk would feel that.
        has_base = link.proximal is not None or link.side is None
        return turned_on_the_spot(chain, link, tick, shift) if has_base else None
    proof = twisted_alone(chain, link, tick, shift)
    if proof is None or link.name.startswith("upper_arm"):
        return proof
    # A wrist that is twisted does not say which side of it slipped: who jumped out of the movement did.
    other = link.proximal if link.is_hand else link.distal
    assert other is not None
    turn_rad = float(shift.turn_rad[2])
    own, others = jumped(chain, link.name, proof.tick, turn_rad), jumped(chain, other, proof.tick, -turn_rad)
    return None if others > _CLEARLY * own else proof


def in_doubt(slips: Sequence[Slip]) -> list[tuple[Slip, ...]]:
    """Put slips together of which only one is meant: both sides of a joint at the same moment."""
    found: list[tuple[Slip, ...]] = []
    for slip in slips:
        last = found[-1] if found else ()
        is_same = any(_are_rivals(slip, one) for one in last)
        found[-1:] = [(*last, slip)] if is_same else [*found[-1:], (slip,)]
    return found


def _are_rivals(one: Slip, other: Slip) -> bool:
    part, _, side = one.placement.partition("_")
    its_part, _, its_side = other.placement.partition("_")
    return (
        {part, its_part} == {"forearm", "hand"}
        and side == its_side
        and abs(one.time_s - other.time_s) < _SAME_S
    )


def find_slips(
    frames: Sequence[Frames], chunks: Sequence[ImuChunk], setup: SessionSetup, from_s: float = 0.0
) -> tuple[Slip, ...]:
    """Return the slips of a whole session, earliest first; see `SlipSearch`.

    Parameters
    ----------
    frames : sequence of Frames
        Of the arm pipeline.
    chunks : sequence of ImuChunk
        The samples of the same ticks, one for each.
    setup : SessionSetup
        With the calibration in force.
    from_s : float
        Session time from which the sensors are worn as they were calibrated: the end of the pose.
    """
    search = SlipSearch(setup, from_s)
    for part, chunk in zip(frames, chunks, strict=True):
        search.add(part, chunk)
    return search.finish()
