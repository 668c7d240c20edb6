"""Points of interest of stored results: where they are, how well that is known, how fast they move."""

from dataclasses import dataclass
from typing import Final, cast

import numpy as np
from sqlalchemy import func, select
from sqlalchemy.orm import Session

from app.accounts.subject import Subject
from app.recordings import repository
from app.recordings.models import Result, SignalChunk
from app.recordings.point_schemas import PointCurve, PointsOut
from app.recordings.signals.chunks import frames_stream
from app.recordings.signals.store import read_frames
from estimators.arm import ACCELERATION_WINDOW_S, arm_points, point_covariance, point_motion
from estimators.body import BodyDimensions
from estimators.conventions import Placement
from estimators.orientation import OrientationFlag
from estimators.pipelines import Frames, SessionSetup
from estimators.recording import Float

MAX_POINTS: Final = 2000
_PIECE_S: Final = 60.0
"""Results are read piece by piece, so that an hour needs no more memory than a minute."""
_INVALID: Final = np.uint8(OrientationFlag.INVALID)


@dataclass(frozen=True)
class DescribedPoints:
    """Points of consecutive ticks.

    Attributes
    ----------
    names : tuple of str
    position_m, velocity_mps, acceleration_mps2, sigma_m : ndarray, shape (K, P, 3)
        Room axes; NaN in gaps, before the calibration, and of sigma where the method tells none.
    """

    names: tuple[str, ...]
    position_m: Float
    velocity_mps: Float
    acceleration_mps2: Float
    sigma_m: Float

    def ticks(self, index: slice) -> "DescribedPoints":
        """Return some of the ticks."""
        return DescribedPoints(
            self.names,
            self.position_m[index],
            self.velocity_mps[index],
            self.acceleration_mps2[index],
            self.sigma_m[index],
        )


def described(frames: Frames, body: BodyDimensions) -> DescribedPoints:
    """Return elbow, wrist and hand of each arm with uncertainty, velocity and acceleration.

    Parameters
    ----------
    frames : Frames
        Consecutive ticks at full rate.
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


def points_of(
    session: Session,
    subject: Subject,
    session_id: str,
    result_id: str | None,
    start_s: float | None,
    end_s: float | None,
    max_points: int,
) -> PointsOut:
    """Return the points of a result over the half-open session time `[start_s, end_s)`.

    Parameters
    ----------
    session : Session
    subject : Subject
    session_id : str
    result_id : str, optional
        The main result by default.
    start_s, end_s : float, optional
    max_points : int
        Of every curve; every n-th tick is taken. Speed and acceleration are found at full rate.

    Raises
    ------
    NotFound
        No such session or result.
    """
    found = repository.get_session(
        session, subject, session_id, action="session.points", details={"result": result_id or "main"}
    )
    result = repository.result_of(session, found, result_id)
    setup = SessionSetup.from_dict(result.setup)
    step_s = 1.0 / setup.rate_hz
    first, stop = ticks_between(session, result, step_s, start_s, end_s)
    stride = max(1, -(-(stop - first) // max_points))
    # What a derivative looks at to both sides.
    margin = round(ACCELERATION_WINDOW_S / step_s)
    length = max(1, round(_PIECE_S / step_s))
    times: list[float] = []
    parts: list[DescribedPoints] = []
    for begin in range(first, stop, length):
        end = min(begin + length, stop)
        frames = read_frames(session, result.id, max(0, begin - margin) * step_s, (end + margin) * step_s)
        at = begin - frames.first_tick
        wanted = slice(
            max(0, at) + (-max(begin, frames.first_tick) % stride), end - frames.first_tick, stride
        )
        if frames.tick_count and wanted.start < wanted.stop:
            parts.append(described(frames, setup.body).ticks(wanted))
            times += [round(float(t), 4) for t in frames.time_s[wanted]]
    names = parts[0].names if parts else ()
    return PointsOut(
        result_id=result.id, time_s=times, points=[_curve(name, parts, p) for p, name in enumerate(names)]
    )


def ticks_between(
    session: Session, result: Result, step_s: float, start_s: float | None, end_s: float | None
) -> tuple[int, int]:
    """Return first tick and end of what a result holds of the half-open session time `[start_s, end_s)`."""
    first = 0 if start_s is None else int(np.ceil(start_s / step_s - 1e-6))
    stop = result_ticks(session, result)
    if end_s is not None:
        stop = min(stop, int(np.ceil(end_s / step_s - 1e-6)))
    return first, stop


def result_ticks(session: Session, result: Result) -> int:
    """Return the end of the last chunk of a result, in ticks."""
    end = session.scalar(
        select(func.max(SignalChunk.sequence + SignalChunk.ticks)).where(
            SignalChunk.session_id == result.session_id, SignalChunk.stream == frames_stream(result.id)
        )
    )
    return int(end or 0)


def _curve(name: str, parts: list[DescribedPoints], column: int) -> PointCurve:
    position, velocity, acceleration, sigma = (
        np.concatenate([getattr(part, field)[:, column] for part in parts])
        for field in ("position_m", "velocity_mps", "acceleration_mps2", "sigma_m")
    )
    return PointCurve(
        name=name,
        position_m=[_plain(values) for values in position.T],
        sigma_m=[_plain(values) for values in sigma.T],
        speed_mps=_plain(np.linalg.norm(velocity, axis=1)),
        acceleration_mps2=_plain(np.linalg.norm(acceleration, axis=1)),
    )


def _plain(values: Float) -> list[float | None]:
    return [round(float(v), 5) if np.isfinite(v) else None for v in values]


__all__ = ["MAX_POINTS", "DescribedPoints", "described", "points_of", "result_ticks", "ticks_between"]
