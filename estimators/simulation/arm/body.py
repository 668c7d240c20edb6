"""The moving body: coordinates over time to exact orientation and path of every segment."""

from dataclasses import dataclass
from itertools import accumulate

import numpy as np
from numpy.typing import NDArray

from estimators.arm import model_lengths
from estimators.body import BodyDimensions
from estimators.conventions import Side
from estimators.simulation.arm.exercises import ACTING_LEG, ARM_COORDINATES, COORDINATES, LEG_COORDINATES
from estimators.simulation.arm.kinematics import (
    X_AXIS,
    Y_AXIS,
    Z_AXIS,
    Path,
    Scalar,
    Turn,
    at_rest,
    carried,
    compose,
    mirror,
    turn_about,
)
from estimators.simulation.arm.timeline import Sinusoids, Timeline, sway

Float = NDArray[np.float64]

HIP_HALF_WIDTH_M = 0.085
THIGH_PER_STATURE = 0.245
SHANK_PER_STATURE = 0.246
"""Drillis and Contini (1966), as in `estimators.body`; the rest of the leg is the height of the ankle."""

_STILL: tuple[str, ...] = (
    "pelvis",
    "head",
    "thigh_left",
    "shank_left",
    "foot_left",
    "thigh_right",
    "shank_right",
    "foot_right",
)


@dataclass(frozen=True)
class SegmentMotion:
    """One segment over time: turn in the room and path of its origin (proximal joint)."""

    turn: Turn
    origin: Path


@dataclass(frozen=True)
class MovingBody:
    """A person performing a timeline; `at` gives any instants, so each sensor may have its own clock.

    Attributes
    ----------
    timeline : Timeline
        Columns are `COORDINATES`, written for an acting right side.
    side : Side
        The acting side; `left` mirrors everything.
    sway_rad : float
        RMS wander of head, pelvis and legs against room or thorax.
    """

    body: BodyDimensions
    timeline: Timeline
    side: Side
    sway_rad: float
    seed: int

    def coordinates(self, time_s: Float) -> dict[str, Scalar]:
        """Return every coordinate at `time_s`, shape (N,), by its name in `COORDINATES`."""
        return dict(zip(COORDINATES, self.timeline.at(time_s), strict=True))

    def at(self, time_s: Float) -> dict[str, SegmentMotion]:
        """Return all seventeen segments at `time_s`, shape (N,)."""
        values = self.coordinates(time_s)
        samples = time_s.shape[0]
        hip_height, trunk, half_width, _, upper_arm, forearm, _ = model_lengths(self.body)
        sign = 1.0 if self.side == "right" else -1.0
        hip = at_rest((0.0, 0.0, hip_height), samples)
        thorax = _sequence(
            (Y_AXIS, values["lean_forward"]),
            (X_AXIS, values["lean_right"].scaled(sign)),
            (Z_AXIS, values["turn_left"].scaled(sign)),
        )
        neck = carried(hip, thorax, (0.0, 0.0, trunk))
        result: dict[str, SegmentMotion] = {"sternum": SegmentMotion(thorax, hip)}
        other: Side = "left" if self.side == "right" else "right"
        for side, role in ((self.side, "acting"), (other, "other")):
            arm = {name: values[f"{role}_{name}"] for name in ARM_COORDINATES}
            is_left = side == "left"
            clavicle = compose(thorax, _sided(turn_about(X_AXIS, arm["hike"].scaled(-1.0)), is_left))
            shoulder = carried(neck, clavicle, (0.0, half_width if is_left else -half_width, 0.0))
            humerus = compose(thorax, _sided(_shoulder(arm), is_left))
            elbow = carried(shoulder, humerus, (0.0, 0.0, -upper_arm))
            lower = compose(humerus, _sided(_elbow(arm), is_left))
            wrist = carried(elbow, lower, (0.0, 0.0, -forearm))
            palm = compose(lower, _sided(_wrist(arm), is_left))
            result[f"shoulder_{side}"] = SegmentMotion(clavicle, neck)
            result[f"upper_arm_{side}"] = SegmentMotion(humerus, shoulder)
            result[f"forearm_{side}"] = SegmentMotion(lower, elbow)
            result[f"hand_{side}"] = SegmentMotion(palm, wrist)
        return result | self._rest(time_s, thorax, neck, values)

    def _rest(
        self, time_s: Float, thorax: Turn, neck: Path, values: dict[str, Scalar]
    ) -> dict[str, SegmentMotion]:
        """Head, pelvis and legs: still but for their sway, and for what the legs do."""
        samples, stature = time_s.shape[0], self.body.stature_m
        hip_height = float(model_lengths(self.body)[0])
        turns = {}
        for number, name in enumerate(_STILL):
            # Seeded by role, not by side, so that a mirrored person sways mirrored.
            role = _STILL.index(_swapped(name)) if self.side == "left" else number
            wander: Sinusoids = sway((0, 1, 2), self.sway_rad, np.random.default_rng([self.seed, 5, role]))
            x, y, z = wander.at(time_s)
            turns[name] = _sided(_sequence((Y_AXIS, y), (X_AXIS, x), (Z_AXIS, z)), self.side == "left")
        hip = at_rest((0.0, 0.0, hip_height), samples)
        result = {
            "pelvis": SegmentMotion(turns["pelvis"], hip),
            "head": SegmentMotion(compose(thorax, turns["head"]), neck),
        }
        thigh_m, shank_m = THIGH_PER_STATURE * stature, SHANK_PER_STATURE * stature
        for side, outward in (("left", HIP_HALF_WIDTH_M), ("right", -HIP_HALF_WIDTH_M)):
            hip_joint = at_rest((0.0, outward, hip_height), samples)
            swaying = [turns[f"{part}_{side}"] for part in ("thigh", "shank", "foot")]
            thigh, shank, foot = self._moved_leg(side, values, swaying)
            knee = carried(hip_joint, thigh, (0.0, 0.0, -thigh_m))
            ankle = carried(knee, shank, (0.0, 0.0, -shank_m))
            result[f"thigh_{side}"] = SegmentMotion(thigh, hip_joint)
            result[f"shank_{side}"] = SegmentMotion(shank, knee)
            result[f"foot_{side}"] = SegmentMotion(foot, ankle)
        return result

    def _moved_leg(self, side: str, values: dict[str, Scalar], swaying: list[Turn]) -> list[Turn]:
        """Thigh, shank and foot in the room, of segments that sway, and of the leg's coordinates."""
        if not self.timeline.posture[:, ACTING_LEG.start :].any():
            return swaying
        role = "acting" if side == self.side else "other"
        leg = {name: values[f"{role}_{name}"] for name in LEG_COORDINATES}
        joints = (
            _sequence(
                (Y_AXIS, leg["hip_flexion"].scaled(-1.0)),
                (X_AXIS, leg["hip_abduction"].scaled(-1.0)),
                (Z_AXIS, leg["hip_rotation"]),
            ),
            turn_about(Y_AXIS, leg["knee_flexion"]),
            turn_about(Y_AXIS, leg["ankle_flexion"].scaled(-1.0)),
        )
        bones = list(accumulate((_sided(joint, side == "left") for joint in joints), compose))
        return [compose(bone, sway_of) for bone, sway_of in zip(bones, swaying, strict=True)]


def _swapped(name: str) -> str:
    if name.endswith("_left"):
        return name.removesuffix("left") + "right"
    return name.removesuffix("right") + "left" if name.endswith("_right") else name


def _sequence(*steps: tuple[Float, Scalar]) -> Turn:
    turn = turn_about(*steps[0])
    for axis, angle in steps[1:]:
        turn = compose(turn, turn_about(axis, angle))
    return turn


def _sided(turn: Turn, is_left: bool) -> Turn:
    return mirror(turn) if is_left else turn


def _shoulder(arm: dict[str, Scalar]) -> Turn:
    return _sequence((Z_AXIS, arm["plane"]), (X_AXIS, arm["elevation"].scaled(-1.0)), (Z_AXIS, arm["axial"]))


def _elbow(arm: dict[str, Scalar]) -> Turn:
    return _sequence(
        (Y_AXIS, arm["flexion"].scaled(-1.0)),
        (X_AXIS, arm["carrying"].scaled(-1.0)),
        (Z_AXIS, arm["pronation"]),
    )


def _wrist(arm: dict[str, Scalar]) -> Turn:
    return _sequence(
        (Y_AXIS, arm["wrist_flexion"].scaled(-1.0)),
        (X_AXIS, arm["wrist_deviation"]),
        (Z_AXIS, arm["wrist_rotation"]),
    )
