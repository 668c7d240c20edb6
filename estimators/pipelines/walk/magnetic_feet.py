"""A walk with a magnetic source on one shoe: both feet in one frame, steps without a known distance at the start."""

from dataclasses import replace
from typing import Final

import numpy as np

from estimators import rotation
from estimators.conventions import Side
from estimators.errors import SetupError, ShapeError
from estimators.gait import FootTrajectory, RelativeFeet, relate_feet, step_measures, steps_inside
from estimators.magnetic import RelativeFlag
from estimators.pipelines._contract import SessionSetup
from estimators.pipelines.relative.smoothing import smooth_modules
from estimators.pipelines.relative.source import relative_source
from estimators.pipelines.walk.walk import Walk, course_of
from estimators.recording import ImuChunk
from estimators.sentences import say
from estimators.signals import interpolate_rotations

FEET: Final = ("foot_left", "foot_right")
_UNUSABLE: Final = int(
    RelativeFlag.INVALID | RelativeFlag.INERTIAL_ONLY | RelativeFlag.FAULT | RelativeFlag.GAP
)


def relative_feet(chunk: ImuChunk, setup: SessionSetup) -> RelativeFeet:
    """Find the pose of the right foot against the left one over a whole session, smoothed.

    Parameters
    ----------
    chunk : ImuChunk
        The whole session from tick 0, sensors in the order of the setup, coil states included.
    setup : SessionSetup
        Of the pipeline `relative_pose`, with `foot_left` and `foot_right`.

    Raises
    ------
    SetupError
        For a session without both feet.
    ShapeError
        For chunks that begin later, or without coil states.
    """
    if set(setup.placements) != set(FEET):
        raise SetupError(say("walk.feet_only"))
    if chunk.first_tick != 0 or chunk.coil_state is None:
        raise ShapeError("give the whole session from its first tick, with its coil states")
    source = setup.placements.index(relative_source(setup).source)
    found = smooth_modules([chunk], setup)[0]
    place, q, covariance, flags = found.position_m, found.q_source_sensor, found.covariance, found.flags
    sigma = np.sqrt(np.maximum(np.diagonal(covariance, axis1=1, axis2=2)[:, :3], 0.0)).max(axis=1)
    if setup.placements[source] == "foot_right":
        q = rotation.conjugate(q)
        place = -rotation.rotate(q, place)
    return RelativeFeet(chunk.time_s, place, q, sigma, (flags & _UNUSABLE) == 0)


def with_relative_feet(walk: Walk, relative: RelativeFeet) -> Walk:
    """Return the walk with both feet in one frame, and step width and lengths from it.

    Raises
    ------
    ShapeError
        When the source saw too few footholds.
    SetupError
        When only one foot was worn.
    """
    if set(walk.strides) != {"left", "right"}:
        raise SetupError(say("walk.feet_only"))
    left, right = walk.trajectories["left"], walk.trajectories["right"]
    holds = {side: strides.footholds for side, strides in walk.strides.items()}
    related = relate_feet(left, right, holds["left"], holds["right"], relative)
    frames, time_s = walk.frames, walk.frames.time_s
    turn = rotation.about_z(-course_of(walk.strides["left"]))
    points, q = frames.point_room_m.copy(), frames.q_room_segment.copy()
    names = frames.layout.points
    paths: dict[Side, FootTrajectory] = {"left": left, "right": related.right}
    for side, path in paths.items():
        column = names.index(f"foot_{side}")
        place = rotation.rotate(turn, path.position_m - left.position_m[0])
        points[:, column] = np.stack([np.interp(time_s, path.time_s, place[:, k]) for k in range(3)], axis=1)
        turned = rotation.multiply(turn, interpolate_rotations(path.time_s, path.q_world_sensor, time_s))
        q[:, frames.layout.segments.index(f"foot_{side}")] = rotation.multiply(
            turned, walk.strides[side].q_sensor_foot
        )
    # The middle between the feet at the start is the origin sideways.
    points[:, :, 1] -= 0.5 * (points[0, :, 1].min() + points[0, :, 1].max())
    return replace(
        walk,
        frames=replace(frames, point_room_m=points, q_room_segment=q),
        steps=step_measures(related.steps, 0.0, steps_inside(walk.strides, related.steps)),
    )


def apart_at_start(walk: Walk) -> float:
    """Return how far apart the feet stood at the start of a walk whose feet are related, across the course, m."""
    points, names = walk.frames.point_room_m, walk.frames.layout.points
    left, right = (points[0, names.index(f"foot_{side}"), 1] for side in ("left", "right"))
    return float(abs(left - right))
