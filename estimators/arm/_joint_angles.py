"""ISB joint angles of shoulder, elbow, wrist and trunk from segment orientations, and back.

Wu et al. (2005), J. Biomech. 38:981-992. ISB axes in our segment axes (x forward, y left, z up) are
X = x, Y = z, Z = -y, for both sides; left rotations are first mirrored in the sagittal plane, so that the
same movement has the same sign on both sides. With elementary rotations about *our* axes::

    thorax to humerus  Y-X-Y   R = Rz(plane of elevation) Rx(-elevation) Rz(axial rotation)
    humerus to forearm Z-X-Y   R = Ry(-flexion) Rx(-carrying) Rz(pronation)
    forearm to hand    Z-X-Y   R = Ry(-flexion) Rx(deviation) Rz(rotation)
    room to thorax     Z-X-Y   R = Ry(lean forward) Rx(lean to the right) Rz(turn to the left)

All angles are zero in the anatomical position. ISB gives elevation as a negative rotation about X; it is
reported positive. Carrying is positive when the forearm points away from the body (valgus).
"""

from collections.abc import Mapping
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from estimators import rotation
from estimators.arm._angle_kernel import (
    AXIAL_CENTRE_RAD,
    FLEXION_CENTRE_RAD,
    PLANE_CENTRE_RAD,
    PRONATION_CENTRE_RAD,
    REACH_RAD,
    REFERENCE_STEP_S,
    SINGULAR_MARGIN_RAD,
)
from estimators.arm._names import angle_name
from estimators.conventions import SIDES, Side

Float = NDArray[np.float64]


class SignConvention(NamedTuple):
    """One row of the sign table: `column` (with `{side}`) grows when `movement` is made."""

    column: str
    movement: str
    zero: str


SIGN_TABLE: Final = (
    SignConvention(
        "thorax_humerus_{side}_yxy_plane_of_elevation",
        "the raised arm goes from the side to the front",
        "arm raised in the frontal plane (abduction); +90 degrees is flexion",
    ),
    SignConvention("thorax_humerus_{side}_yxy_elevation", "the arm is raised", "arm along the trunk"),
    SignConvention(
        "thorax_humerus_{side}_yxy_axial_rotation", "internal rotation", "none beyond the plane of elevation"
    ),
    SignConvention("humerus_forearm_{side}_zxy_flexion", "the elbow is bent", "straight elbow"),
    SignConvention(
        "humerus_forearm_{side}_zxy_carrying", "the forearm moves away from the body", "forearm in line"
    ),
    SignConvention(
        "humerus_forearm_{side}_zxy_pronation", "pronation", "palm forward; +90 degrees is the N-pose"
    ),
    SignConvention("forearm_hand_{side}_zxy_flexion", "the hand bends toward the palm", "hand in line"),
    SignConvention("forearm_hand_{side}_zxy_deviation", "the hand bends toward the little finger", "in line"),
    SignConvention("forearm_hand_{side}_zxy_rotation", "the hand turns as in pronation", "none"),
    SignConvention("trunk_lean_forward_rad", "the trunk leans forward", "upright"),
    SignConvention("trunk_lean_lateral_rad", "the trunk leans to the right", "upright"),
    SignConvention("trunk_axial_rotation_rad", "the trunk turns to the left", "facing forward"),
)


def mirrored(q: ArrayLike) -> Float:
    """Mirror rotations in the sagittal plane (y to -y), shape (..., 4): left becomes right and back."""
    return np.multiply(np.asarray(q, dtype=np.float64), [1.0, -1.0, 1.0, -1.0])


def _sided(q: Float, side: Side) -> Float:
    return mirrored(q) if side == "left" else q


def shoulder_from_angles(plane: ArrayLike, elevation: ArrayLike, axial: ArrayLike, side: Side) -> Float:
    """Return `q_thorax_humerus`, shape (..., 4), of Y-X-Y angles in radians, each shape (...)."""
    raised = rotation.multiply(rotation.about_z(plane), rotation.about_x(np.negative(elevation)))
    return _sided(rotation.multiply(raised, rotation.about_z(axial)), side)


def elbow_from_angles(flexion: ArrayLike, carrying: ArrayLike, pronation: ArrayLike, side: Side) -> Float:
    """Return `q_humerus_forearm`, shape (..., 4), of Z-X-Y angles in radians, each shape (...)."""
    bent = rotation.multiply(rotation.about_y(np.negative(flexion)), rotation.about_x(np.negative(carrying)))
    return _sided(rotation.multiply(bent, rotation.about_z(pronation)), side)


def wrist_from_angles(flexion: ArrayLike, deviation: ArrayLike, turn: ArrayLike, side: Side) -> Float:
    """Return `q_forearm_hand`, shape (..., 4), of Z-X-Y angles in radians, each shape (...)."""
    bent = rotation.multiply(rotation.about_y(np.negative(flexion)), rotation.about_x(deviation))
    return _sided(rotation.multiply(bent, rotation.about_z(turn)), side)


def trunk_from_angles(forward: ArrayLike, right: ArrayLike, turn_left: ArrayLike) -> Float:
    """Return `q_room_thorax`, shape (..., 4), of Z-X-Y angles in radians, each shape (...)."""
    leant = rotation.multiply(rotation.about_y(forward), rotation.about_x(right))
    return rotation.multiply(leant, rotation.about_z(turn_left))


def shoulder_angles(q_thorax_humerus: ArrayLike, side: Side) -> Float:
    """Return plane of elevation, elevation (0 to pi) and axial rotation, shape (..., 3), each tick by itself.

    Near elevation 0 and pi plane and axial rotation are arbitrary: see `continuous_shoulder_angles`.
    """
    m = rotation.to_matrix(_sided(np.asarray(q_thorax_humerus, dtype=np.float64), side))
    plane = np.arctan2(-m[..., 0, 2], m[..., 1, 2])
    elevation = np.arctan2(np.hypot(m[..., 0, 2], m[..., 1, 2]), m[..., 2, 2])
    axial = np.arctan2(-m[..., 2, 0], -m[..., 2, 1])
    return np.stack((plane, elevation, axial), axis=-1)


def _zxy(q: Float) -> tuple[Float, Float, Float]:
    m = rotation.to_matrix(q)
    forward = np.arctan2(m[..., 0, 2], m[..., 2, 2])
    across = np.arctan2(-m[..., 1, 2], np.hypot(m[..., 1, 0], m[..., 1, 1]))
    return forward, across, np.arctan2(m[..., 1, 0], m[..., 1, 1])


def elbow_angles(q_humerus_forearm: ArrayLike, side: Side) -> Float:
    """Return flexion, carrying and pronation, shape (..., 3), principal values in (-pi, pi]."""
    forward, across, turn = _zxy(_sided(np.asarray(q_humerus_forearm, dtype=np.float64), side))
    return np.stack((-forward, -across, turn), axis=-1)


def wrist_angles(q_forearm_hand: ArrayLike, side: Side) -> Float:
    """Return flexion, deviation and rotation, shape (..., 3), principal values in (-pi, pi]."""
    forward, across, turn = _zxy(_sided(np.asarray(q_forearm_hand, dtype=np.float64), side))
    return np.stack((-forward, across, turn), axis=-1)


def trunk_angles(q_room_thorax: ArrayLike) -> Float:
    """Return lean forward, lean to the right and turn to the left, shape (..., 3)."""
    return np.stack(_zxy(np.asarray(q_room_thorax, dtype=np.float64)), axis=-1)


def is_shoulder_singular(elevation_rad: ArrayLike) -> NDArray[np.bool_]:
    """Return where plane of elevation and axial rotation cannot be distinguished, shape (...)."""
    elevation = np.asarray(elevation_rad, dtype=np.float64)
    return np.asarray(np.minimum(elevation, np.pi - elevation) < SINGULAR_MARGIN_RAD)


def near(angle: float, previous: float, centre: float) -> float:
    """Return the turn of `angle` closest to `previous`; of `centre` when that is unknown or far off."""
    if np.isfinite(previous):
        candidate = _nearest(angle, previous)
        if abs(candidate - centre) <= REACH_RAD:
            return candidate
    return _nearest(angle, centre)


def _nearest(angle: float, wanted: float) -> float:
    turn = 2.0 * np.pi
    return float(angle + turn * np.floor((wanted - angle) / turn + 0.5))


def continuous_shoulder_angles(
    q_thorax_humerus: Float, side: Side, time_step_s: float, previous: Float | None = None
) -> Float:
    """Return Y-X-Y angles that do not jump where an arm can go, shape (K, 3), for consecutive ticks, shape (K, 4).

    Outside the singular zone these are the exact angles, unwrapped. Inside it the plane of elevation moves
    from its last value toward the instantaneous one with a weight that falls to zero at the singularity, and
    axial rotation takes up the rest: the sum (arm down) or difference (arm up) of both stays exact. NaN
    in, NaN out; the value before a gap stays the reference.

    Parameters
    ----------
    q_thorax_humerus : ndarray, shape (K, 4)
    previous : ndarray, shape (3,), optional
        Angles at the tick before.
    """
    m = rotation.to_matrix(_sided(q_thorax_humerus, side))
    exact = shoulder_angles(q_thorax_humerus, side)
    total = np.arctan2(m[:, 1, 0] - m[:, 0, 1], m[:, 0, 0] + m[:, 1, 1])
    difference = np.arctan2(m[:, 1, 0] + m[:, 0, 1], m[:, 0, 0] - m[:, 1, 1])
    memory = np.full(3, np.nan) if previous is None else np.array(previous, dtype=np.float64)
    result = np.full_like(exact, np.nan)
    for k in range(exact.shape[0]):
        plane, elevation, axial = exact[k]
        if np.isnan(elevation):
            continue
        margin = min(elevation, np.pi - elevation)
        if margin < SINGULAR_MARGIN_RAD:
            held = memory[0] if np.isfinite(memory[0]) else PLANE_CENTRE_RAD
            ratio = margin / SINGULAR_MARGIN_RAD
            weight = 1.0 - (1.0 - ratio**2 * (3.0 - 2.0 * ratio)) ** (time_step_s / REFERENCE_STEP_S)
            moved = held + weight * (_nearest(plane, held) - held)
            plane = near(moved, moved, PLANE_CENTRE_RAD)
            axial = total[k] - plane if elevation < 0.5 * np.pi else plane - difference[k]
        else:
            plane = near(plane, memory[0], PLANE_CENTRE_RAD)
        memory = np.array([plane, elevation, near(axial, memory[2], AXIAL_CENTRE_RAD)])
        result[k] = memory
    return result


def continuous_hinge_angles(angles_rad: Float, previous: Float | None = None) -> Float:
    """Unwrap elbow or wrist angles of consecutive ticks, shape (K, 3), from `previous`, shape (3,)."""
    memory = np.full(3, np.nan) if previous is None else np.array(previous, dtype=np.float64)
    result = np.array(angles_rad, dtype=np.float64)
    for k in range(result.shape[0]):
        if np.isnan(result[k]).any():
            continue
        result[k, 0] = near(result[k, 0], memory[0], FLEXION_CENTRE_RAD)
        result[k, 2] = near(result[k, 2], memory[2], PRONATION_CENTRE_RAD)
        memory = result[k]
    return result


def segments_from_angles(
    columns: Mapping[str, ArrayLike], sides: tuple[Side, ...] = SIDES
) -> dict[str, Float]:
    """Return the orientation of every arm segment that named joint angles describe.

    Parameters
    ----------
    columns : mapping of column name to array, shape (...)
        Joint angles and `trunk_*_rad` scalars in radians; missing ones are zero.

    Returns
    -------
    dict of Placement to ndarray, shape (..., 4)
        `q_room_segment` of sternum and of upper arm, forearm and hand of each side.
    """
    shape = np.broadcast_shapes(*(np.shape(values) for values in columns.values())) if columns else ()

    def get(name: str) -> Float:
        return np.broadcast_to(np.asarray(columns.get(name, 0.0), dtype=np.float64), shape)

    def three(joint: str, side: Side, *parts: str) -> tuple[Float, Float, Float]:
        first, second, third = (get(angle_name(joint, side, part)) for part in parts)
        return first, second, third

    thorax = trunk_from_angles(
        get("trunk_lean_forward_rad"), get("trunk_lean_lateral_rad"), get("trunk_axial_rotation_rad")
    )
    segments: dict[str, Float] = {"sternum": thorax}
    for side in sides:
        plane, elevation, axial = three(
            "thorax_humerus", side, "yxy_plane_of_elevation", "yxy_elevation", "yxy_axial_rotation"
        )
        upper_arm = rotation.multiply(thorax, shoulder_from_angles(plane, elevation, axial, side))
        flexion, carrying, pronation = three(
            "humerus_forearm", side, "zxy_flexion", "zxy_carrying", "zxy_pronation"
        )
        forearm = rotation.multiply(upper_arm, elbow_from_angles(flexion, carrying, pronation, side))
        bend, deviation, turn = three("forearm_hand", side, "zxy_flexion", "zxy_deviation", "zxy_rotation")
        hand = rotation.multiply(forearm, wrist_from_angles(bend, deviation, turn, side))
        segments |= {f"upper_arm_{side}": upper_arm, f"forearm_{side}": forearm, f"hand_{side}": hand}
    return segments
