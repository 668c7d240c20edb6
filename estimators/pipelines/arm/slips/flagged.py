"""Frames after a slip: what depends on the sensor says so, and is as uncertain as the sensor has become."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from estimators import rotation
from estimators.arm import ArmModel
from estimators.orientation import OrientationFlag
from estimators.pipelines._contract import Frames, SessionSetup
from estimators.pipelines.arm.slips.search import Slip
from estimators.recording import Float

FLAG: Final = np.uint8(OrientationFlag.CONVERGING | OrientationFlag.HEADING_NOT_TRUSTED)
"""As before a calibration: the orientation is that of a sensor of which nobody knows how it sits."""
_FLOOR_RAD: Final = math.radians(3.0)
_GROWN_RAD: Final = math.radians(4.0)
"""An angle that is off by more depends on what slipped; of a sensor that only twisted, flexion does not."""
_NOTHING_RAD: Final = 1e-9
_MOVED_M: Final = 0.02
"""A point that is off by more depends on what slipped: four degrees of an upper arm or a forearm."""
_HANGING: Final = ("elbow", "wrist", "hand")
_QUICK_S: Final = 0.4
"""A slip has begun so long before its middle, at most."""


def with_slips(frames: Frames, setup: SessionSetup, slips: Sequence[Slip]) -> Frames:
    """Return frames whose sigmas and flags hold after slips.

    Parameters
    ----------
    frames : Frames
        Of the arm pipeline, any stretch of the session.
    setup : SessionSetup
        Of that pipeline.

    Returns
    -------
    Frames
        From `time_s` of each slip on, its segment is flagged `FLAG` and its sigma holds the turn; sigmas of joint
        angles are those that follow, and angles that depend on it are flagged too. `slipped` says the same, and which
        points it moves as seen from the shoulder. The same object where no slip lies before its end.

    Notes
    -----
    Turns of one sensor add up, one after the other. Those of several sensors are taken as independent: of rivals only
    one is meant, see `in_doubt`.
    """
    times = frames.time_s
    past = [one for one in slips if frames.tick_count and times[-1] >= one.time_s - _QUICK_S]
    if not past or frames.segment_sigma_rad is None or not frames.layout.angles:
        return frames
    variance, flags = frames.segment_sigma_rad**2, frames.segment_flags.copy()
    layout, model = frames.layout, ArmModel(setup.body, setup.placements, frames.time_step_s)
    columns = [layout.angles.index(name) for name in model.angles]
    off = np.zeros((frames.tick_count, len(columns)))
    slipped, grown, moved = (part.copy() for part in frames.slipped_parts)
    measured = _posture(model, frames.q_room_segment, frames)
    for placement in dict.fromkeys(slip.placement for slip in past):
        s = layout.segments.index(placement)
        turn_rad, floor = _turn_since(frames.time_s, [slip for slip in past if slip.placement == placement])
        after = floor > 0
        turned = rotation.rotate(frames.q_room_segment[after, s], turn_rad[after])
        variance[after, s] += turned**2 + floor[after, None]
        flags[after, s] |= FLAG
        slipped[after, s] = True
        # By how much each angle would be another one if the sensor sat as before: a twist leaves flexion as it is.
        seated = frames.q_room_segment.copy()
        seated[after, s] = rotation.multiply(seated[after, s], rotation.exp(-turn_rad[after]))
        angle_rad, place_m = _posture(model, seated, frames)
        changed = np.remainder(angle_rad - measured[0] + np.pi, 2.0 * np.pi) - np.pi
        off += np.where(np.abs(changed) > _NOTHING_RAD, changed**2 + floor[:, None], 0.0)
        moved |= np.linalg.norm(place_m - measured[1], axis=2) > _MOVED_M
    angle_sigma, angle_flags = frames.angle_sigma_rad.copy(), frames.angle_flags.copy()
    angle_sigma[:, columns] = np.sqrt(angle_sigma[:, columns] ** 2 + off)
    grown[:, columns] |= off > _GROWN_RAD**2 + _FLOOR_RAD**2
    angle_flags[grown] |= FLAG
    return replace(
        frames,
        segment_sigma_rad=np.sqrt(variance),
        segment_flags=flags,
        angle_sigma_rad=angle_sigma,
        angle_flags=angle_flags,
        slipped=np.concatenate([slipped, grown, moved], axis=1),
    )


def _turn_since(times: Float, slips: Sequence[Slip]) -> tuple[Float, Float]:
    """Return how far one sensor has turned by each tick, shape (K, 3), and the variance of that, 0 before a slip."""
    turn, variance = np.tile([1.0, 0.0, 0.0, 0.0], (len(times), 1)), np.zeros(len(times))
    for slip in sorted(slips, key=lambda one: one.time_s):
        after = times >= slip.time_s - _QUICK_S
        turn[after] = rotation.multiply(turn[after], rotation.exp(np.array(slip.turn_rad)))
        variance[after] += max(slip.sigma_rad, _FLOOR_RAD) ** 2
    return rotation.log(turn), variance


def _posture(model: ArmModel, q_room_segment: Float, frames: Frames) -> tuple[Float, Float]:
    """Return joint angles in the order of the model, and the points of the layout as seen from their shoulder."""
    found, points = model.evaluate(q_room_segment, segment_flags=frames.segment_flags), frames.layout.points
    place_m = np.zeros(frames.point_room_m.shape)
    for column, name in enumerate(points):
        joint, _, side = name.partition("_")
        if joint in _HANGING:
            shoulder = found.point_room_m[:, model.points.index(f"shoulder_{side}")]
            place_m[:, column] = found.point_room_m[:, model.points.index(name)] - shoulder
    return found.angle_rad, place_m
