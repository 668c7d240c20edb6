"""Check of a standing pose by the session's movements: whether the patient faced as assumed, and stood as asked."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from estimators import rotation
from estimators.calibration._contract import Calibration
from estimators.calibration._mounting import FACING_ORDER
from estimators.calibration._placement import off_rule, twin
from estimators.calibration._rest import wrapped
from estimators.calibration.movement.one_way_joints import LEAST_S, Bending, Raising, bendings, raisings
from estimators.conventions import Placement
from estimators.recording import Float
from estimators.sentences import say

_OFF_RAD: Final = math.radians(70.0)
"""Less is how differently people let their arms hang, and what a compass near iron is off by."""
_HALF_TURN_RAD: Final = math.radians(150.0)
_TURNED_SIGMA_RAD: Final = math.radians(12.0)
"""How well a bent elbow tells a turn that is not half a turn: arms hang turned by so much."""
_AGREED: Final = 0.85
_STILL_WRONG: Final = 0.03
_WITNESS_RAD: Final = math.radians(30.0)
_ON_THE_BACK: Final = ("head", "pelvis")
"""Worn in front or on the back: their printed sides are no witnesses."""
_HINT: Final = "calibration.faces_away"
"""What the pose alone said of the same."""
CONTRADICTED_SCORE: Final = 0.3
"""In force, because the segments are shown; its angles are not to be used."""
JUDGED: Final = (
    "placement.back_to_front",
    "placement.faced_away",
    "placement.elbow_impossible",
    "placement.knee_impossible",
    "placement.arm_behind",
    "placement.bent_aside",
    "placement.arm_unclear",
    "placement.trunk_backward",
)
"""Codes of the reasons that movements give against a standing pose."""


@dataclass(frozen=True)
class Postures:
    """Segments of a session under the calibration to be judged, a few times a second.

    Attributes
    ----------
    names : tuple of str
        Of the segments.
    q_room_segment : ndarray, shape (N, G, 4)
        NaN where a segment was not tracked, or its heading has drifted.
    """

    names: tuple[str, ...]
    q_room_segment: Float
    step_s: float

    def turned(self, shared: Sequence[str], turn_rad: float) -> "Postures":
        """Return the postures that follow when the patient faced elsewhere in the pose.

        Parameters
        ----------
        shared : sequence of str
            Segments that share the heading of their compasses.
        turn_rad : float
            From where the patient was assumed to face, counter-clockwise.
        """
        q, columns = self.q_room_segment.copy(), [self.names.index(name) for name in shared]
        back, on = rotation.about_z(-turn_rad), rotation.about_z(turn_rad)
        q[:, columns] = rotation.multiply(back, rotation.multiply(q[:, columns], on))
        return replace(self, q_room_segment=q)


def judged_by_movement(found: Calibration, postures: Postures) -> Calibration:
    """Return what is left of a calibration by a standing pose after the movements that followed.

    Parameters
    ----------
    found : Calibration
        By a standing pose; others measured the joints and are returned as they are.

    Returns
    -------
    Calibration
        The same object where elbows, knees and upper arms went where they can. Where elbow or knee bent another way
        and another direction of the patient makes all of them possible, the calibration with that direction. Where
        that does not, or nothing else speaks for it, `contradicted` names the sensors whose angles mean nothing.

    Notes
    -----
    A wrong direction of the patient by d goes into every mounting: a segment reads `R_z(-d) q R_z(d)`, and the
    forearm seems to leave the upper arm in a direction that is off by -d. So bent elbows show d. But an elbow that was
    bent in the pose, and is stretched afterwards, seems to bend backward too. The direction is therefore turned only
    where something else says the same: sensors that by the mounting rule face so, or upper arms that would have been
    raised behind the back.
    """
    if "pose" not in found.method or found.contradicted:
        return found
    shared = [p for p in found.q_sensor_segment if p not in found.heading_offset_rad and p in postures.names]
    seen = _Seen.of(postures)
    if not seen.wrong_joints and not seen.wrong_arms and not seen.aside_joints:
        return found
    turn_rad = seen.turn(shared)
    if turn_rad is not None and _is_confirmed(found, postures, seen, shared, turn_rad):
        return _turned(found, shared, turn_rad)
    return _contradicted(found, seen, shared)


def has_impossible(postures: Postures) -> bool:
    """Say whether anything was where it cannot be, for however short: whether it is worth to be judged."""
    seen = _Seen.of(postures)
    aside = any(abs(one.mean_rad) > _OFF_RAD for one in seen.joints if one.bent_s)
    return aside or any(one.wrong_s for one in seen.joints) or any(one.wrong_s for one in seen.arms)


@dataclass(frozen=True)
class _Seen:
    """How joints bent and where arms were raised."""

    joints: tuple[Bending, ...]
    arms: tuple[Raising, ...]

    @classmethod
    def of(cls, postures: Postures) -> "_Seen":
        given = postures.names, postures.q_room_segment, postures.step_s
        return cls(bendings(*given), raisings(*given))

    @property
    def wrong_joints(self) -> list[Bending]:
        return [one for one in self.joints if one.is_wrong]

    @property
    def wrong_arms(self) -> list[Raising]:
        return [one for one in self.arms if one.is_wrong]

    def telling(self, shared: Sequence[Placement]) -> list[Bending]:
        """Return the joints that show where the patient faces."""
        pairs = [one for one in self.joints if {one.hinge.upper, one.hinge.lower} <= set(shared)]
        return [one for one in pairs if one.bent_s >= LEAST_S]

    @property
    def aside_joints(self) -> list[Bending]:
        """Return joints that bent far to the side, always in one direction."""
        long = [one for one in self.joints if one.bent_s >= LEAST_S and one not in self.wrong_joints]
        return [
            one for one in long if abs(one.mean_rad) > _OFF_RAD and one.share_around(one.mean_rad) >= _AGREED
        ]

    def turn(self, shared: Sequence[Placement]) -> float | None:
        """Return from where to where the direction of the patient must turn; None where joints do not agree on one."""
        telling = self.telling(shared)
        if not telling:
            return None
        total = sum(one.bent_s * complex(math.cos(one.mean_rad), math.sin(one.mean_rad)) for one in telling)
        turn_rad = math.atan2(total.imag, total.real)
        if abs(turn_rad) < _OFF_RAD:
            return None
        if abs(turn_rad) > _HALF_TURN_RAD:
            turn_rad = math.pi
        return turn_rad if all(one.share_around(turn_rad) >= _AGREED for one in telling) else None


def _is_confirmed(
    found: Calibration, postures: Postures, seen: _Seen, shared: Sequence[Placement], turn_rad: float
) -> bool:
    """Say whether everything fits with the patient turned, and something beside the joints says so."""
    after = _Seen.of(postures.turned(shared, turn_rad))
    if after.wrong_joints or any(
        one.wrong_s > _STILL_WRONG * one.raised_s + LEAST_S / 2 for one in after.arms
    ):
        return False
    for_it, against = _witnesses(found, shared, turn_rad)
    has_raised = any(f"upper_arm_{one.side}" in shared for one in seen.wrong_arms)
    return has_raised if for_it <= against else has_raised or bool(seen.telling(shared))


def _witnesses(found: Calibration, shared: Sequence[Placement], turn_rad: float) -> tuple[int, int]:
    """Count sensors that by the mounting rule say that the patient faces so, and as was assumed."""
    implied = {
        p: off for p in shared if (off := off_rule(p, np.array(found.q_sensor_segment[p]))) is not None
    }
    reference = _reference(found, shared)
    pair = () if reference is None else (reference, twin(reference))
    others = [off for p, off in implied.items() if p not in pair and p not in _ON_THE_BACK]
    for_it = sum(abs(wrapped(off - turn_rad)) < _WITNESS_RAD for off in others)
    return for_it, sum(abs(off) < _WITNESS_RAD for off in others)


def _reference(found: Calibration, shared: Sequence[Placement]) -> Placement | None:
    """Return the sensor that showed where the patient faces; None where movements or several did."""
    for placement in FACING_ORDER:
        if placement in shared:
            off = off_rule(placement, np.array(found.q_sensor_segment[placement]))
            if off is not None and abs(off) < _WITNESS_RAD:
                return placement
    return None


def _turned(found: Calibration, shared: Sequence[Placement], turn_rad: float) -> Calibration:
    """Return the calibration of a patient who faced elsewhere."""
    is_half = turn_rad == math.pi
    mounted, sigma = dict(found.q_sensor_segment), dict(found.mounting_sigma_rad)
    for name in shared:
        w, x, y, z = rotation.positive(rotation.multiply(np.array(mounted[name]), rotation.about_z(turn_rad)))
        mounted[name] = (float(w), float(x), float(y), float(z))
        if name in sigma and not is_half:
            about_x, about_y, about_z = sigma[name]
            sigma[name] = (about_x, about_y, math.hypot(about_z, _TURNED_SIGMA_RAD))
    reference = _reference(found, shared)
    where = list(shared) if reference is None else [reference]
    reason = (
        say("placement.back_to_front", where=where)
        if is_half
        else say("placement.faced_away", where=where, angle_rad=abs(turn_rad), sigma_rad=_TURNED_SIGMA_RAD)
    )
    return replace(
        found,
        q_sensor_segment=mounted,
        mounting_sigma_rad=sigma,
        facing_rad=wrapped(found.facing_rad + turn_rad),
        heading_offset_rad={p: wrapped(turn + turn_rad) for p, turn in found.heading_offset_rad.items()},
        method=f"{found.method}, facing",
        reasons=(*(one for one in found.reasons if getattr(one, "code", "") != _HINT), reason),
    )


def _contradicted(found: Calibration, seen: _Seen, shared: Sequence[Placement]) -> Calibration:
    """Return the calibration without trust in what the movements contradict."""
    doubted: set[Placement] = set()
    reasons: list[str] = []
    aside = seen.aside_joints
    for one in (*seen.wrong_joints, *aside):
        reasons.append(_objection(one, one in aside, _suspects(found, shared, one.hinge.upper)))
        doubted |= _limb(one.hinge.upper, found)
    # Arms are judged from the chest alone.
    trunk: Placement = "sternum"
    if any(arm.is_of_trunk for arm in seen.wrong_arms):
        reasons.append(say("placement.trunk_backward", where=[trunk]))
        doubted.add(trunk)
    for arm in seen.wrong_arms:
        if arm.is_of_trunk:
            continue
        upper: Placement = "upper_arm_left" if arm.side == "left" else "upper_arm_right"
        if not _limb(upper, found) & doubted:
            where = [trunk, *(one for one in _suspects(found, shared, upper) if one != trunk)]
            reasons.append(say("placement.arm_behind", side=arm.side, where=where))
        doubted |= _limb(upper, found)
    if doubted & set(shared) and not _witnesses(found, shared, math.pi)[1]:
        # Nothing but the sensor in doubt says where the patient faced.
        doubted |= set(shared)
    return replace(
        found,
        contradicted=tuple(p for p in found.q_sensor_segment if p in doubted),
        reasons=(*found.reasons, *reasons),
        score=min(found.score, CONTRADICTED_SCORE),
    )


def _objection(one: Bending, is_aside: bool, where: list[Placement]) -> str:
    """Say what is wrong with a joint."""
    side, reads_rad = one.hinge.side, one.furthest_wrong_rad
    if is_aside:
        return say("placement.bent_aside", side=side, angle_rad=abs(one.mean_rad), where=where)
    if one.hinge.joint == "elbow":
        return say("placement.elbow_impossible", side=side, angle_rad=reads_rad, where=where)
    return say("placement.knee_impossible", side=side, angle_rad=reads_rad, where=where)


def _suspects(found: Calibration, shared: Sequence[Placement], upper: Placement) -> list[Placement]:
    """Return sensors of which one may be back to front."""
    reference = _reference(found, shared) if upper in shared else None
    limb = [
        p for p in found.q_sensor_segment if p in _limb(upper, found) and not p.startswith(("hand", "foot"))
    ]
    return limb if reference is None or reference in limb else [reference, *limb]


def _limb(upper: Placement, found: Calibration) -> set[Placement]:
    """Return the worn sensors of a limb, by that of its upper segment."""
    parts = ("upper_arm", "forearm", "hand") if upper.startswith("upper_arm") else ("thigh", "shank", "foot")
    side = upper.rpartition("_")[2]
    return {p for p in found.q_sensor_segment if p in {f"{part}_{side}" for part in parts}}
