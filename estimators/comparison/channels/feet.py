"""The channels of a foot that walks: how it is tilted, how high it is and how fast it goes forward."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from estimators.comparison._contract import Trajectory
from estimators.comparison.channels.names import foot_channels
from estimators.conventions import Side
from estimators.errors import ShapeError
from estimators.orientation._contract import OrientationFlag
from estimators.pipelines._contract import Frames
from estimators.recording import Float
from estimators.rotation import rotate

_MOVED_M: Final = 0.05
"""Between two footholds nearer than this nobody went anywhere: forward is then where the toes point."""
HEIGHT_SIGMA_M: Final = 0.0042
SPEED_SIGMA_MPS: Final = 0.03
"""Standard deviations of height and forward speed, which no estimate states. The height is measured from two
footholds, each known to 3 mm as a foot creeps and rolls in stance (`gait.find_strides`). Against exact truth the
speed of simulated strides differs by 0.031 m/s at the worst phase, root mean square, and their height by 2 mm."""


@dataclass(frozen=True)
class Stood:
    """Where and when a foot stood, in order; n of them.

    Attributes
    ----------
    start_s, stop_s : ndarray, shape (n,)
        First and last moment at rest, session time.
    position_m : ndarray, shape (n, 3)
        Of the foot's point, room axes of the frames.
    """

    start_s: Float
    stop_s: Float
    position_m: Float

    def __post_init__(self) -> None:
        if self.position_m.shape != (len(self.start_s), 3) or self.stop_s.shape != self.start_s.shape:
            raise ShapeError(
                f"{len(self.start_s)} beginnings, {len(self.stop_s)} ends, places {self.position_m.shape}"
            )


def foot_trajectory(frames: Frames, stood: Mapping[Side, Stood]) -> Trajectory:
    """Return the channels of the feet of a walk, `foot_channels` of each side.

    Parameters
    ----------
    frames : Frames
        Of a walk: segments and points `foot_left` and `foot_right`, x of a foot to its toes, z of the room up.
    stood : mapping of Side to Stood
        Of the same walk; feet without two footholds are left out.

    Returns
    -------
    Trajectory
        Pitch of the foot against the level floor, toes up positive, rad. Height of its point above the straight line
        in time between the footholds before and after, m: on a ramp or stairs the line rises as well. Forward speed,
        m/s: along the way from the foothold before to the one after.
    """
    time_s = frames.time_s
    names: list[str] = []
    columns: list[Float] = []
    sigmas: list[Float] = []
    valid: list[NDArray[np.bool_]] = []
    for side, holds in stood.items():
        if len(holds.start_s) < 2:
            continue
        segment = frames.layout.segments.index(f"foot_{side}")
        place = frames.point_room_m[:, frames.layout.points.index(f"foot_{side}")]
        ahead = rotate(frames.q_room_segment[:, segment], np.array([1.0, 0.0, 0.0]))
        pitch = np.arctan2(ahead[:, 2], np.hypot(ahead[:, 0], ahead[:, 1]))
        moments = np.stack([holds.start_s, holds.stop_s], axis=1).ravel()
        floor = np.interp(time_s, moments, np.repeat(holds.position_m[:, 2], 2))
        speed = np.sum(
            np.gradient(place[:, :2], frames.time_step_s, axis=0) * _ways(time_s, holds, ahead), axis=1
        )
        names.extend(foot_channels(side))
        columns.extend([pitch, place[:, 2] - floor, speed])
        tilt = np.full(len(time_s), np.nan)
        if frames.segment_sigma_rad is not None:
            tilt = np.hypot(*frames.segment_sigma_rad[:, segment, :2].T) / np.sqrt(2.0)
        sigmas.extend([tilt, np.full(len(time_s), HEIGHT_SIGMA_M), np.full(len(time_s), SPEED_SIGMA_MPS)])
        tracked = (frames.segment_flags[:, segment] & np.uint8(OrientationFlag.INVALID)) == 0
        valid.extend([tracked] * 3)
    values = np.stack(columns, axis=1) if columns else np.zeros((len(time_s), 0))
    return Trajectory(
        time_s=time_s,
        channels=tuple(names),
        values=values,
        sigma=np.stack(sigmas, axis=1) if sigmas else values,
        valid=np.isfinite(values)
        & (np.stack(valid, axis=1) if valid else np.zeros(values.shape, dtype=np.bool_)),
    )


def _ways(time_s: Float, holds: Stood, ahead: Float) -> Float:
    """Return the level direction in which each tick's stride goes, unit vectors, shape (N, 2)."""
    step = np.diff(holds.position_m[:, :2], axis=0)
    length = np.linalg.norm(step, axis=1)
    # The line of a stride is that of the foot from the middle of one stance to the middle of the next.
    middle_s = 0.5 * (holds.start_s + holds.stop_s)
    stride = np.clip(np.searchsorted(middle_s, time_s, side="right") - 1, 0, len(step) - 1)
    way = step[stride] / np.maximum(length, _MOVED_M)[stride, None]
    pointing = ahead[:, :2] / np.maximum(np.linalg.norm(ahead[:, :2], axis=1), 1e-9)[:, None]
    found: Float = np.where((length < _MOVED_M)[stride, None], pointing, way)
    return found
