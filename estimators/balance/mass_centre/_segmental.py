"""Centre of mass of a body from the orientations of up to seventeen worn sensors."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from estimators import rotation
from estimators.balance.mass_centre._body_levers import (
    HEEL_BEHIND_ANKLE,
    HIP_HALF_WIDTH_PER_STATURE,
    stand_in_of,
)
from estimators.balance.mass_centre._segments import (
    FOOT_PER_STATURE,
    HEAD_PER_STATURE,
    SHANK_PER_STATURE,
    THIGH_PER_STATURE,
    BodySegments,
)
from estimators.body import ANKLE_HEIGHT_PER_STATURE, BodyDimensions
from estimators.conventions import PLACEMENTS, SIDES
from estimators.errors import SetupError, ShapeError
from estimators.recording import Float


@dataclass(frozen=True)
class SegmentalMassCentre:
    """Centre of mass over K ticks, room frame.

    Attributes
    ----------
    position_m : ndarray, shape (K, 3)
    parts_m : dict of str to ndarray, shape (K, 3)
        Centre of each part, `shank_left` say.
    joints_m : dict of str to ndarray, shape (K, 3)
    assumed : tuple of str
        Segments without a sensor, which moved with their neighbour.
    """

    position_m: Float
    parts_m: dict[str, Float]
    joints_m: dict[str, Float]
    mass_share: dict[str, float]
    assumed: tuple[str, ...]


def segmental_mass_centre(
    q_room_segment: Mapping[str, Float],
    segments: BodySegments,
    body: BodyDimensions | None = None,
    *,
    hip_m: Float | None = None,
    stands_on_floor: bool = True,
) -> SegmentalMassCentre:
    """Return the centre of mass of a body whose segments' orientations are known.

    Parameters
    ----------
    q_room_segment : mapping of placement to ndarray, shape (K, 4)
        Any of the seventeen; at least sternum or pelvis. `shoulder_*` moves nothing but its joint.
    body : BodyDimensions, optional
        The patient's lengths; legs and head follow from the stature.
    hip_m : ndarray, shape (K, 3), optional
        Where the middle of the hips is. Without it the result is above the room's origin horizontally.
    stands_on_floor : bool
        Without `hip_m`: put the lower foot on the floor at z = 0.

    Raises
    ------
    SetupError
        If neither sternum nor pelvis is worn, or a placement is unknown.
    ShapeError
        If the series differ in length.

    Notes
    -----
    `c = sum of m_j c_j` over the parts (Schepers 2009, equation 4.7).
    """
    dimensions = body or BodyDimensions()
    q, assumed = _complete(q_room_segment)
    ticks = next(iter(q.values())).shape[0]
    stature, down = dimensions.stature_m, _DOWN
    hip = np.zeros((ticks, 3)) if hip_m is None else np.asarray(hip_m, dtype=np.float64)
    joints: dict[str, Float] = {"hip": hip}
    parts: dict[str, Float] = {}

    def along(name: str, vector: Float) -> Float:
        return rotation.rotate(q[name], vector)

    def hang(limb: tuple[_Limb, ...], start: Float, side: str) -> Float:
        for link in limb:
            end = start + along(f"{link.part}_{side}", link.length_m * down)
            parts[f"{link.part}_{side}"] = start + segments.centre_share[link.part] * (end - start)
            joints[f"{link.joint}_{side}"] = start = end
        return start

    trunk, base = _trunk(q, segments, dimensions.trunk_m, hip)
    parts |= trunk
    joints["neck"] = base
    head_m = HEAD_PER_STATURE * stature
    parts["head"] = base + along("head", -(1.0 - segments.centre_share["head"]) * head_m * down)
    arm, leg = _limbs(dimensions)
    for side in SIDES:
        sign = 1.0 if side == "left" else -1.0
        outward = np.array([0.0, sign, 0.0])
        shoulder = base + along(f"shoulder_{side}", 0.5 * dimensions.shoulder_width_m * outward)
        joints[f"shoulder_{side}"] = shoulder
        hang(arm, shoulder, side)
        start = hip + along("pelvis", HIP_HALF_WIDTH_PER_STATURE * stature * outward)
        joints[f"hip_{side}"] = start
        start = hang(leg, start, side)
        foot_m = FOOT_PER_STATURE * stature
        ahead = (segments.centre_share["foot"] - HEEL_BEHIND_ANKLE) * foot_m
        below = 0.5 * ANKLE_HEIGHT_PER_STATURE * stature
        parts[f"foot_{side}"] = start + along(f"foot_{side}", np.array([ahead, 0.0, -below]))
    if hip_m is None and stands_on_floor:
        lower = np.minimum(joints["ankle_left"][:, 2], joints["ankle_right"][:, 2])
        lift = np.zeros((ticks, 3))
        lift[:, 2] = ANKLE_HEIGHT_PER_STATURE * stature - lower
        joints = {name: point + lift for name, point in joints.items()}
        parts = {name: point + lift for name, point in parts.items()}
    masses = segments.masses()
    position = np.zeros((ticks, 3))
    for name, share in masses.items():
        position = position + share * parts[name]
    return SegmentalMassCentre(position, parts, joints, masses, assumed)


_DOWN = np.array([0.0, 0.0, -1.0])


def _trunk(
    q: dict[str, Float], segments: BodySegments, trunk_m: float, hip_m: Float
) -> tuple[dict[str, Float], Float]:
    """Return the centres of the trunk's three parts and the neck, from the hips up.

    The trunk bends between pelvis and thorax: its middle has the mean orientation of both.
    """
    middle = rotation.slerp(q["pelvis"], q["sternum"], np.full(len(hip_m), 0.5))
    parts: dict[str, Float] = {}
    base = hip_m
    for turn, part, share in (
        (q["pelvis"], "lower_trunk", segments.trunk_share[2]),
        (middle, "middle_trunk", segments.trunk_share[1]),
        (q["sternum"], "upper_trunk", segments.trunk_share[0]),
    ):
        length = share * trunk_m
        base = base + rotation.rotate(turn, -length * _DOWN)
        parts[part] = base + rotation.rotate(turn, segments.centre_share[part] * length * _DOWN)
    return parts, base


@dataclass(frozen=True)
class _Limb:
    """One part of a limb: hangs from its joint along -z of its own frame."""

    part: str
    joint: str
    length_m: float


def _limbs(body: BodyDimensions) -> tuple[tuple[_Limb, ...], tuple[_Limb, ...]]:
    """Return the parts of an arm and of a leg, from the trunk outwards."""
    arm = (
        _Limb("upper_arm", "elbow", body.upper_arm_m),
        _Limb("forearm", "wrist", body.forearm_m),
        # The table's hand ends at the knuckle of the middle finger.
        _Limb("hand", "knuckle", 0.5 * body.hand_m),
    )
    leg = (
        _Limb("thigh", "knee", THIGH_PER_STATURE * body.stature_m),
        _Limb("shank", "ankle", SHANK_PER_STATURE * body.stature_m),
    )
    return arm, leg


def _complete(given: Mapping[str, Float]) -> tuple[dict[str, Float], tuple[str, ...]]:
    """Give every segment an orientation; those without a sensor move with their neighbour."""
    unknown = [name for name in given if name not in PLACEMENTS]
    if unknown:
        raise SetupError(f"unknown placement {', '.join(unknown)}; known are {', '.join(PLACEMENTS)}")
    if "sternum" not in given and "pelvis" not in given:
        raise SetupError("a centre of mass needs a sensor on the sternum or the pelvis")
    shapes = {np.shape(q) for q in given.values()}
    if len(shapes) != 1 or next(iter(shapes))[1:] != (4,):
        raise ShapeError(f"orientations must all have one shape (K, 4); got {sorted(map(str, shapes))}")
    result = {name: np.asarray(q, dtype=np.float64) for name, q in given.items()}
    assumed = []

    def orientation(name: str) -> Float:
        if name not in result:
            found = orientation(stand_in_of(name))
            assumed.append(name)
            if name.startswith("foot"):
                # A foot is level when nothing else is known of it.
                x_axis = rotation.rotate(found, np.array([1.0, 0.0, 0.0]))
                found = rotation.about_z(np.arctan2(x_axis[:, 1], x_axis[:, 0]))
            result[name] = found
        return result[name]

    for name in PLACEMENTS:
        orientation(name)
    return result, tuple(name for name in PLACEMENTS if name in assumed)
