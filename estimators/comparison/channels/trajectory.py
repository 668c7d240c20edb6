"""A session's frames as comparisons see them: every channel with its uncertainty, and where it is valid."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from estimators.comparison._contract import Trajectory
from estimators.comparison.measures.places import place_sigma
from estimators.orientation._contract import OrientationFlag
from estimators.pipelines._contract import FrameLayout, Frames
from estimators.recording import Float
from estimators.rotation import conjugate, rotate

_LEANING: Final = ("thigh", "shank")
_HAND_SPEED: Final = "hand_speed_"
UNUSABLE: Final = np.uint8(OrientationFlag.INVALID | OrientationFlag.SINGULAR)
"""Bits of an angle that says nothing about the posture."""


def trajectory(frames: Frames) -> Trajectory:
    """Collect the channels of a session that comparisons use.

    Parameters
    ----------
    frames : Frames
        Consecutive ticks of one session, for instance from `estimators.pipelines.concatenate`.

    Returns
    -------
    Trajectory
        Every angle, every scalar, then every point as `<point>.x|y|z` in the room frame, m; then of worn thighs and
        shanks `<segment>_lean_forward_rad`, how far the upper end leans ahead in the segment's own x-z plane, rad. A
        value is valid when it is finite and its sensors were tracked; an angle also not where its sequence is singular,
        because there the number says nothing about the posture. Sigma of elbow, wrist and hand is that of their place
        relative to the shoulder.
    """
    layout = frames.layout
    points = tuple(f"{point}.{axis}" for point in layout.points for axis in "xyz")
    point_values = frames.point_room_m.reshape(frames.tick_count, -1)
    values = np.concatenate([frames.angle_rad, frames.scalar, point_values], axis=1)
    sigma = np.full_like(values, np.nan)
    sigma[:, : len(layout.angles)] = frames.angle_sigma_rad
    if frames.segment_sigma_rad is not None:
        sigma[:, len(layout.angles) + len(layout.scalars) :] = place_sigma(frames, frames.segment_sigma_rad)
    valid = np.isfinite(values)
    valid[:, : len(layout.angles)] &= (frames.angle_flags & UNUSABLE) == 0
    tracked = (frames.segment_flags & np.uint8(OrientationFlag.INVALID)) == 0
    for column, name in enumerate((*layout.scalars, *points), start=len(layout.angles)):
        needed = [layout.segments.index(s) for s in segments_behind(name) if s in layout.segments]
        if needed:
            valid[:, column] &= tracked[:, needed].all(axis=1)
    legs = leaning_segments(layout)
    if legs:
        lean = legs_forward(frames, legs)
        values = np.concatenate([values, lean], axis=1)
        sigma = np.concatenate([sigma, np.full_like(lean, np.nan)], axis=1)
        valid = np.concatenate([valid, np.isfinite(lean) & tracked[:, legs]], axis=1)
    return Trajectory(
        time_s=frames.time_s,
        channels=(
            *layout.angles,
            *layout.scalars,
            *points,
            *(leaning_channel(layout.segments[column]) for column in legs),
        ),
        values=values,
        sigma=sigma,
        valid=valid,
        unseated=_unseated(frames, valid.shape[1]),
    )


def _unseated(frames: Frames, columns: int) -> NDArray[np.bool_] | None:
    """Return which channels are off by a sensor that turned in its strap, shape (N, C)."""
    if frames.slipped is None or not frames.slipped.any():
        return None
    layout = frames.layout
    segment, angle, point = frames.slipped_parts
    found = np.zeros((frames.tick_count, columns), dtype=np.bool_)
    found[:, : len(layout.angles)] = angle
    for column, name in enumerate(layout.scalars, start=len(layout.angles)):
        behind = segments_behind(name)
        if name.startswith(_HAND_SPEED):
            # How a sensor on the arm is twisted about the limb does not change where the hand goes.
            hand, behind = f"hand_{'left' if '_left' in name else 'right'}", behind[:1]
            if hand in layout.points:
                found[:, column] = point[:, layout.points.index(hand)]
        needed = [layout.segments.index(s) for s in behind if s in layout.segments]
        found[:, column] |= segment[:, needed].any(axis=1)
    first = len(layout.angles) + len(layout.scalars)
    found[:, first : first + 3 * len(layout.points)] = np.repeat(point, 3, axis=1)
    return found


def leaning_segments(layout: FrameLayout) -> list[int]:
    """Return the columns of thighs and shanks among the segments."""
    return [column for column, name in enumerate(layout.segments) if name.startswith(_LEANING)]


def leaning_channel(segment: str) -> str:
    """Return the channel that says how far a thigh or shank leans ahead."""
    return f"{segment}_lean_forward_rad"


def legs_forward(frames: Frames, legs: list[int]) -> Float:
    """Return how far the upper ends of these segments lean ahead in their own x-z plane, shape (K, L), rad."""
    up = rotate(conjugate(frames.q_room_segment[:, legs]), np.array([0.0, 0.0, 1.0]))
    return np.arctan2(-up[..., 0], up[..., 2])


def segments_behind(channel: str) -> tuple[str, ...]:
    """Segments whose loss makes a scalar or point untrue."""
    if channel.startswith("trunk_"):
        return ("sternum",)
    side = "left" if "_left" in channel else "right" if "_right" in channel else ""
    if not side:
        return ("sternum",)
    chain = ["sternum", f"upper_arm_{side}", f"forearm_{side}", f"hand_{side}"]
    if channel.startswith("shoulder_"):
        return tuple(chain[:1])
    if channel.startswith("elbow_"):
        return tuple(chain[:2])
    if channel.startswith("wrist_"):
        return tuple(chain[:3])
    return tuple(chain)
