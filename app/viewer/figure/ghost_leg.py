"""The ghost's leg: one skin over thigh, shank and foot."""

from functools import lru_cache

import numpy as np

from app.viewer.figure.ghost_arm import Float32, SkinnedLimb, ramp, skin_outside
from app.viewer.figure.limbs import shank_shape, shoe_shape, thigh_shape
from app.viewer.figure.proportions import REFERENCE_STATURE_M, hip_half_width_m, leg_lengths_m
from app.viewer.figure.surface import lowered, polygonise, smooth_union
from app.viewer.pose import SEGMENTS, PoseTrack
from estimators import rotation
from estimators.body import BodyDimensions
from estimators.conventions import Side
from estimators.recording import Float

_TOES_M = 0.18
"""From the ankle to the end of the shoe, at the reference stature."""


@lru_cache(maxsize=32)
def skinned_leg(body: BodyDimensions, side: Side) -> SkinnedLimb:
    """Return the leg of a person; its mesh hangs from the hip joint."""
    wide = body.stature_m / REFERENCE_STATURE_M
    thigh, shank, foot = leg_lengths_m(body)
    knee, ankle = -thigh, -thigh - shank
    shape = smooth_union(
        [
            thigh_shape(body, wide),
            lowered(shank_shape(body, wide), knee),
            lowered(shoe_shape(body, wide), ankle),
        ],
        0.015 * wide,
    )
    mesh = polygonise(
        skin_outside(shape, wide),
        (-0.14 * wide, -0.14 * wide, ankle - foot - 0.03 * wide),
        (0.25 * wide, 0.14 * wide, 0.12 * wide),
        0.0125 * wide,
    )
    height = mesh.vertices_m[:, 2].astype(np.float64)
    below_knee = ramp(knee + 0.045 * wide - height, 0.090 * wide)
    in_foot = ramp(ankle + 0.050 * wide - height, 0.040 * wide)
    weights = np.stack([1.0 - below_knee, below_knee * (1.0 - in_foot), below_knee * in_foot], axis=1)
    joints = np.array([[0, 0, 0], [0, 0, knee], [0, 0, ankle]], dtype=np.float32)
    return SkinnedLimb(mesh if side == "left" else mesh.mirrored(), weights.astype(np.float32), joints)


def leg_bones(track: PoseTrack, body: BodyDimensions, side: Side) -> tuple[Float32, Float32]:
    """Return where thigh, shank and foot are, relative to the middle of the hips.

    Returns
    -------
    wxyz : ndarray of float32, shape (K, 3, 4)
    position_m : ndarray of float32, shape (K, 3, 3)
    """
    pelvis = track.wxyz[:, SEGMENTS.index("pelvis")].astype(np.float64)
    turned, places = [pelvis], [rotation.rotate(pelvis, hip_joint_m(body, side))]
    for segment, length in zip(("thigh", "shank", "foot"), (*leg_lengths_m(body)[:2], 0.0), strict=True):
        own = track.wxyz[:, SEGMENTS.index(f"{segment}_{side}")].astype(np.float64)
        turned.append(rotation.multiply(turned[-1], own))
        places.append(places[-1] + rotation.rotate(turned[-1], np.array([0.0, 0.0, -length])))
    wxyz, position = np.stack(turned[1:], axis=1), np.stack(places[:3], axis=1)
    return wxyz.astype(np.float32), position.astype(np.float32)


def hip_joint_m(body: BodyDimensions, side: Side) -> Float:
    """Return where the hip joint is in the pelvis."""
    return np.array([0.0, (1.0 if side == "left" else -1.0) * hip_half_width_m(body), 0.0])


def foot_points_m(track: PoseTrack, body: BodyDimensions, side: Side) -> Float:
    """Return where ankle, toes and knee are, relative to the middle of the hips, shape (K, 3, 3)."""
    wxyz, position = (part.astype(np.float64) for part in leg_bones(track, body, side))
    wide = body.stature_m / REFERENCE_STATURE_M
    toes = np.array([_TOES_M * wide, 0.0, -leg_lengths_m(body)[2]])
    return np.stack(
        [position[:, 2], position[:, 2] + rotation.rotate(wxyz[:, 2], toes), position[:, 1]], axis=1
    )
