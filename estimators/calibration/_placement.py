"""Sensors that sit on another segment or another way round than they should, named to the person."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from estimators import rotation
from estimators.calibration._contract import Calibration
from estimators.calibration._mounting import N_POSE_TURN_RAD, OUTWARD_HEADING_RAD
from estimators.calibration._rest import wrapped
from estimators.conventions import Placement, Side
from estimators.errors import CalibrationError
from estimators.recording import Float
from estimators.sentences import CATALOGUE, say

PlacementCode = Literal["swapped_sides", "swapped_segments", "turned", "moved_since"]
_TURNED_RAD: Final = math.radians(125.0)
"""Nearer to half a turn than to a quarter."""
_MOVED_RAD: Final = math.radians(35.0)
_HORIZONTAL: Final = 0.5
_BUSIER: Final = 1.3
_HANDED: Final = 0.5


@dataclass(frozen=True)
class PlacementFinding:
    """Something about where or how sensors sit.

    Attributes
    ----------
    code : str
        One of `PlacementCode`, for programs.
    text : str
        Which sensor, and what to do, for people.
    """

    code: PlacementCode
    placements: tuple[Placement, ...]
    text: str


class MisplacedError(CalibrationError):
    """Sensors sit on the wrong segment, so nothing can be found."""

    def __init__(self, findings: Sequence[PlacementFinding]) -> None:
        super().__init__(CATALOGUE.together([finding.text for finding in findings]))
        self.findings = tuple(findings)


def check_segments(
    side: Side, upper_rates: Iterable[Float], forearm_rates: Iterable[Float]
) -> tuple[PlacementFinding, ...]:
    """Say when upper arm and forearm seem swapped: bending the elbow and turning the palm turn the forearm.

    Parameters
    ----------
    upper_rates, forearm_rates : iterable of ndarray, shape (N, 3)
        Of both movements, rad/s.
    """
    upper, fore = (_power(rates) for rates in (upper_rates, forearm_rates))
    if upper <= _BUSIER**2 * fore:
        return ()
    pair: tuple[Placement, ...] = (
        ("upper_arm_left", "forearm_left") if side == "left" else ("upper_arm_right", "forearm_right")
    )
    text = say("placement.segments_swapped", where=list(pair))
    return (PlacementFinding("swapped_segments", pair, text),)


def _power(rates: Iterable[Float]) -> float:
    together = np.concatenate(list(rates))
    return float(np.nanmean(np.sum(together**2, axis=1)))


def check_sides(raised: Mapping[Side, tuple[Float, Float]]) -> tuple[PlacementFinding, ...]:
    """Say when an arm that was raised forward and sideways is the other one.

    Parameters
    ----------
    raised : mapping of Side to (forward, sideways)
        Axes of the two movements in one earth frame.

    Notes
    -----
    Forward both arms turn about the patient's right (-y), sideways the right one about backward (-x) and the
    left one about forward (+x): forward x sideways points down on the right and up on the left, whatever the
    patient faces and without a compass.
    """
    wrong: list[Side] = []
    for side, (forward, sideways) in raised.items():
        upward = float(np.cross(forward, sideways)[2])
        if upward * (1.0 if side == "left" else -1.0) < -_HANDED:
            wrong.append(side)
    if not wrong:
        return ()
    both = len(wrong) == 2
    text = say("placement.arms_swapped") if both else say("placement.wrong_arm", side=wrong[0])
    parts: dict[Side, tuple[Placement, ...]] = {
        "left": ("upper_arm_left", "forearm_left"),
        "right": ("upper_arm_right", "forearm_right"),
    }
    return (PlacementFinding("swapped_sides", tuple(p for side in wrong for p in parts[side]), text),)


def check_mounting(found: Calibration, previous: Calibration | None = None) -> tuple[PlacementFinding, ...]:
    """Say which sensors are turned by half a turn against the mounting rule or against last time.

    Parameters
    ----------
    found : Calibration
        Sensors whose heading was *assumed* by the rule tell nothing against it and are left out.
    previous : Calibration, optional
        Of the same patient, remembered.

    Returns
    -------
    tuple of PlacementFinding
        The calibration copes with a turned sensor; people should know, for it may be the wrong one.
    """
    assumed = set(found.heading_offset_rad) if "pose" in found.method else set()
    turned = {
        placement
        for placement, q in found.q_sensor_segment.items()
        if placement not in assumed and abs(off_rule(placement, np.array(q)) or 0.0) > _TURNED_RAD
    }
    findings: list[PlacementFinding] = []
    for placement in [p for p in found.q_sensor_segment if p in turned]:
        other = twin(placement)
        if other in turned and placement.endswith("left"):
            text = say("placement.twins_swapped", where=[placement, other])
            findings.append(PlacementFinding("swapped_sides", (placement, other), text))
        elif other not in turned:
            text = say("placement.half_turn", where=[placement])
            findings.append(PlacementFinding("turned", (placement,), text))
    named = {p for finding in findings for p in finding.placements}
    known = {} if previous is None else previous.q_sensor_segment
    for placement, q in found.q_sensor_segment.items():
        if placement in named or placement not in known:
            continue
        away = float(rotation.angle_between(np.array(q), np.array(known[placement])))
        if away > _TURNED_RAD:
            text = say("placement.half_turn_since", where=[placement])
            findings.append(PlacementFinding("turned", (placement,), text))
        elif away > _MOVED_RAD:
            text = say("placement.moved_since", where=[placement], angle_rad=away)
            findings.append(PlacementFinding("moved_since", (placement,), text))
    return tuple(findings)


def off_rule(placement: Placement, q_sensor_segment: Float) -> float | None:
    """Return how far the z axis of a sensor is turned off its outward heading while the N-pose is held.

    Counter-clockwise, rad; None where the axis is too steep to tell.
    """
    outward = rotation.rotate(rotation.conjugate(q_sensor_segment), [0.0, 0.0, 1.0])
    outward = rotation.rotate(rotation.about_z(N_POSE_TURN_RAD.get(placement, 0.0)), outward)
    if math.hypot(outward[0], outward[1]) < _HORIZONTAL:
        return None
    return wrapped(math.atan2(outward[1], outward[0]) - OUTWARD_HEADING_RAD[placement])


def twin(placement: Placement) -> Placement | None:
    """Return the placement on the other side; None in the middle."""
    for name in OUTWARD_HEADING_RAD:
        if name != placement and name.rpartition("_")[0] == placement.rpartition("_")[0] != "":
            return name
    return None
