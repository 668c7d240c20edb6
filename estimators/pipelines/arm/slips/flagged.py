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
    slips : sequence of Slip

    Returns
    -------
    Frames
        From `time_s` of each slip on, its segment is flagged `FLAG` and its sigma holds the turn; sigmas of joint
        angles are those that follow, and angles that depend on it are flagged too. The same object where no slip lies
        before its end.
    """
    times = frames.time_s
    past = [one for one in slips if frames.tick_count and times[-1] >= one.time_s - _QUICK_S]
    if not past or frames.segment_sigma_rad is None or not frames.layout.angles:
        return frames
    variance, flags = frames.segment_sigma_rad**2, frames.segment_flags.copy()
    model = ArmModel(setup.body, setup.placements, frames.time_step_s)
    columns = [frames.layout.angles.index(name) for name in model.angles]
    off = np.zeros((frames.tick_count, len(columns)))
    for slip in past:
        s = frames.layout.segments.index(slip.placement)
        after = times >= slip.time_s - _QUICK_S
        floor = max(slip.sigma_rad, _FLOOR_RAD) ** 2
        turned = rotation.rotate(frames.q_room_segment[after, s], np.array(slip.turn_rad))
        variance[after, s] += turned**2 + floor
        flags[after, s] |= FLAG
        # By how much each angle would be another one if the sensor sat as before: a twist leaves flexion as it is.
        seated = frames.q_room_segment.copy()
        seated[after, s] = rotation.multiply(seated[after, s], rotation.exp(-np.array(slip.turn_rad)))
        changed = _angles(model, seated, frames) - _angles(model, frames.q_room_segment, frames)
        changed = np.remainder(changed + np.pi, 2.0 * np.pi) - np.pi
        off += np.where(np.abs(changed) > _NOTHING_RAD, changed**2 + floor, 0.0)
    angle_sigma, angle_flags = frames.angle_sigma_rad.copy(), frames.angle_flags.copy()
    angle_sigma[:, columns] = np.sqrt(angle_sigma[:, columns] ** 2 + off)
    grown = np.zeros(angle_flags.shape, dtype=bool)
    grown[:, columns] = off > _GROWN_RAD**2 + _FLOOR_RAD**2
    angle_flags[grown] |= FLAG
    return replace(
        frames,
        segment_sigma_rad=np.sqrt(variance),
        segment_flags=flags,
        angle_sigma_rad=angle_sigma,
        angle_flags=angle_flags,
    )


def _angles(model: ArmModel, q_room_segment: Float, frames: Frames) -> Float:
    return model.evaluate(q_room_segment, segment_flags=frames.segment_flags).angle_rad


__all__ = ["FLAG", "with_slips"]
