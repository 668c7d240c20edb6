"""The ghost's arm: one skin over five bones, so that nothing overlaps and shines through at the joints.

Bones: upper arm; forearm without, with half of and with all of its turn (pronation twists a real forearm along
its length, too); hand.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from app.viewer.figure.limbs import forearm_shape, hand_shape, upper_arm_shape
from app.viewer.figure.proportions import REFERENCE_STATURE_M
from app.viewer.figure.surface import Mesh, Shape, inflated, lowered, polygonise, smooth_union
from app.viewer.pose import SEGMENTS, PoseTrack
from estimators import rotation
from estimators.body import BodyDimensions
from estimators.conventions import SIDES, Side
from estimators.recording import Float

Float32 = NDArray[np.float32]

BONES: Final = 5
_LARGER_M: Final = 0.0035
"""The ghost's skin lies this far outside, so that it does not flicker where it meets the patient's."""


@dataclass(frozen=True)
class SkinnedLimb:
    """A limb hanging straight down in the anatomical position, with the B bones it follows.

    Attributes
    ----------
    mesh : Mesh
        Origin at the shoulder or the hip.
    weights : ndarray of float32, shape (V, B)
        Share of each bone in each vertex; rows sum to one.
    joints_m : ndarray of float32, shape (B, 3)
        Where the bones begin.
    """

    mesh: Mesh
    weights: Float32
    joints_m: Float32


@lru_cache(maxsize=32)
def skinned_arm(body: BodyDimensions, side: Side) -> SkinnedLimb:
    """Return the arm of a person."""
    wide = body.stature_m / REFERENCE_STATURE_M
    elbow, wrist = -body.upper_arm_m, -body.upper_arm_m - body.forearm_m
    shape = smooth_union(
        [
            upper_arm_shape(body, wide),
            lowered(forearm_shape(body, wide), elbow),
            lowered(hand_shape(body), wrist),
        ],
        0.010 * wide,
    )
    low = wrist - 1.08 * body.hand_m
    mesh = polygonise(
        skin_outside(shape, wide),
        (-0.08 * wide, -0.09 * wide, low),
        (0.09 * wide, 0.12 * wide, 0.07 * wide),
        0.0078 * wide,
    )
    height = mesh.vertices_m[:, 2].astype(np.float64)
    below_elbow = ramp(elbow + 0.030 * wide - height, 0.060 * wide)
    in_hand = ramp(wrist + 0.020 * wide - height, 0.040 * wide)
    along = np.clip((elbow - height) / body.forearm_m, 0.0, 1.0)
    turn = [
        np.clip(1.0 - 2.0 * along, 0.0, 1.0),
        1.0 - np.abs(2.0 * along - 1.0),
        np.clip(2.0 * along - 1.0, 0.0, 1.0),
    ]
    in_forearm = below_elbow * (1.0 - in_hand)
    weights = np.stack(
        [1.0 - below_elbow, *(in_forearm * share for share in turn), below_elbow * in_hand], axis=1
    )
    joints = np.array([[0, 0, 0], *([[0, 0, elbow]] * 3), [0, 0, wrist]], dtype=np.float32)
    return SkinnedLimb(mesh if side == "left" else mesh.mirrored(), weights.astype(np.float32), joints)


def bone_track(track: PoseTrack, body: BodyDimensions, side: Side) -> tuple[Float32, Float32]:
    """Return where the bones are, relative to the middle of the hips.

    Returns
    -------
    wxyz : ndarray of float32, shape (K, 5, 4)
    position_m : ndarray of float32, shape (K, 5, 3)
    """

    def local(segment: str) -> Float:
        return track.wxyz[:, SEGMENTS.index(segment)].astype(np.float64)

    thorax = local("sternum")
    upper = rotation.multiply(thorax, local(f"upper_arm_{side}"))
    bend, turn = _swing_and_turn(local(f"forearm_{side}"))
    bent = rotation.multiply(upper, bend)
    half = rotation.multiply(bent, rotation.about_z(0.5 * turn))
    forearm = rotation.multiply(bent, rotation.about_z(turn))
    hand = rotation.multiply(forearm, local(f"hand_{side}"))
    shoulder = rotation.rotate(thorax, track.shoulder_m[:, SIDES.index(side)].astype(np.float64))
    elbow = shoulder + rotation.rotate(upper, np.array([0.0, 0.0, -body.upper_arm_m]))
    wrist = elbow + rotation.rotate(forearm, np.array([0.0, 0.0, -body.forearm_m]))
    wxyz = np.stack([upper, bent, half, forearm, hand], axis=1)
    position = np.stack([shoulder, elbow, elbow, elbow, wrist], axis=1)
    return wxyz.astype(np.float32), position.astype(np.float32)


def hand_points_m(track: PoseTrack, body: BodyDimensions, side: Side) -> Float:
    """Return where the end of the hand is, the thumb and what the palm faces, so that a turn of the hand counts.

    Returns
    -------
    ndarray, shape (K, 3, 3)
        Relative to the middle of the hips.
    """
    wxyz, position = bone_track(track, body, side)
    middle = -0.5 * body.hand_m
    own = np.array(
        [[0.0, 0.0, -body.hand_m], [0.0, 0.5 * body.hand_m, middle], [0.5 * body.hand_m, 0.0, middle]]
    )
    turned: Float = rotation.rotate(wxyz[:, -1:].astype(np.float64), own)
    return position[:, -1:] + turned


def _swing_and_turn(q: Float) -> tuple[Float, Float]:
    """Split rotations, shape (K, 4), into a bend and, before it, a turn about z in radians, shape (K,)."""
    turn = 2.0 * np.arctan2(q[:, 3], q[:, 0])
    turn = (turn + np.pi) % (2.0 * np.pi) - np.pi
    return rotation.multiply(q, rotation.about_z(-turn)), np.unwrap(turn)


def skin_outside(shape: Shape, wide: float) -> Shape:
    """Return the ghost's skin over a shape of the figure."""
    return inflated(shape, _LARGER_M * wide)


def ramp(value: Float, width: float) -> Float:
    """Return how far a value is on its way from 0 to a width, 0 to 1, without corners."""
    share = np.clip(value / width, 0.0, 1.0)
    smooth: Float = share * share * (3.0 - 2.0 * share)
    return smooth
