"""Points of interest of stored results: where they are, how well that is known, how fast they move."""

from dataclasses import dataclass
from typing import Final, cast

import numpy as np
from sqlalchemy import func, select
from sqlalchemy.orm import Session

from app.recordings.models import Result, SignalChunk
from app.recordings.signals.chunks import frames_stream
from estimators.arm import arm_points, point_covariance, point_motion
from estimators.body import BodyDimensions
from estimators.conventions import Placement
from estimators.orientation import OrientationFlag
from estimators.pipelines import Frames
from estimators.recording import Float

MAX_POINTS: Final = 2000
_INVALID: Final = np.uint8(OrientationFlag.INVALID)


@dataclass(frozen=True)
class DescribedPoints:
    """Points of consecutive ticks.

    Attributes
    ----------
    position_m, velocity_mps, acceleration_mps2, sigma_m : ndarray, shape (K, P, 3)
        Room axes; NaN in gaps, before the calibration, and of sigma where the method tells none.
    """

    names: tuple[str, ...]
    position_m: Float
    velocity_mps: Float
    acceleration_mps2: Float
    sigma_m: Float


def described(frames: Frames, body: BodyDimensions) -> DescribedPoints:
    """Return elbow, wrist and hand of each arm with uncertainty, velocity and acceleration.

    Parameters
    ----------
    frames : Frames
        Consecutive ticks.
    body : BodyDimensions
        Of the setup the frames were made with.

    Notes
    -----
    Held values of a gap are no movement: they are left out. Uncertainty of the mounting on the body is not in sigma.
    """
    layout = frames.layout
    names = tuple(name for name in arm_points(layout.segments) if name in layout.points)
    shape = (frames.tick_count, len(names), 3)
    if not names or not frames.tick_count:
        return DescribedPoints(names, *(np.full(shape, np.nan) for _ in range(4)))
    q = frames.q_room_segment.copy()
    q[(frames.segment_flags & _INVALID) != 0] = np.nan
    # Before the calibration the orientations are those of the sensors; points tell that they mean nothing.
    columns = [layout.points.index(name) for name in names]
    q[np.isnan(frames.point_room_m[:, columns]).all(axis=(1, 2))] = np.nan
    motion = point_motion(q, layout.segments, body, frames.time_step_s, points=names)
    sigma = np.full(shape, np.nan)
    if frames.segment_sigma_rad is not None:
        placements = cast(tuple[Placement, ...], layout.segments)
        found = point_covariance(q, placements, body, frames.segment_sigma_rad, points=names)
        sigma = np.sqrt(np.diagonal(found.covariance_m2, axis1=-2, axis2=-1))
    return DescribedPoints(names, motion.position_m, motion.velocity_mps, motion.acceleration_mps2, sigma)


def ticks_between(
    session: Session, result: Result, step_s: float, start_s: float | None, end_s: float | None
) -> tuple[int, int]:
    """Return first tick and end of what a result holds of the half-open session time `[start_s, end_s)`.

    Ticks are those that are stored, `step_s` apart.
    """
    first = 0 if start_s is None else int(np.ceil(start_s / step_s - 1e-6))
    stop = result_ticks(session, result)
    if end_s is not None:
        stop = min(stop, int(np.ceil(end_s / step_s - 1e-6)))
    return first, stop


def result_ticks(session: Session, result: Result) -> int:
    """Return the end of the last chunk of a result, in ticks that are stored."""
    end = session.scalar(
        select(func.max(SignalChunk.sequence + SignalChunk.ticks)).where(
            SignalChunk.session_id == result.session_id, SignalChunk.stream == frames_stream(result.id)
        )
    )
    return int(end or 0) // result.stride
