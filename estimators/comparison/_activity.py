"""How long somebody moved, for exercises that have no repetitions to count."""

from typing import Final

import numpy as np

from estimators.orientation._contract import OrientationFlag
from estimators.pipelines._contract import Frames

_STEP_S: Final = 0.2
"""Turns are taken over this long: the noise of the orientation, a tenth of a degree, is then 0.01 rad/s."""
_MOVING_RADPS: Final = 0.2
"""About 11 degrees a second. Breathing and holding a posture stay below; slow exercises are well above."""


def moving_time(frames: Frames, start_s: float | None = None, end_s: float | None = None) -> float:
    """Return how long any worn segment was turning.

    Parameters
    ----------
    frames : Frames
        Consecutive ticks of one session.
    start_s, end_s : float, optional
        Half-open stretch of the session to look at.

    Returns
    -------
    float
        In seconds; times in which no segment was tracked do not count.
    """
    inside = np.ones(frames.tick_count, dtype=bool)
    if start_s is not None:
        inside &= frames.time_s >= start_s
    if end_s is not None:
        inside &= frames.time_s < end_s
    stride = max(1, round(_STEP_S / frames.time_step_s))
    rows = np.flatnonzero(inside)[::stride]
    if len(rows) < 2:
        return 0.0
    q = frames.q_room_segment[rows]
    tracked = (frames.segment_flags[rows] & np.uint8(OrientationFlag.INVALID)) == 0
    tracked &= np.isfinite(q).all(axis=2)
    share = np.clip(np.abs(np.sum(q[1:] * q[:-1], axis=2)), 0.0, 1.0)
    step_s = np.diff(frames.time_s[rows])[:, None]
    speed_radps = 2.0 * np.arccos(share) / step_s
    # Across a gap in the recording nobody knows what was done.
    known = tracked[1:] & tracked[:-1] & (step_s < 2.0 * _STEP_S)
    moving = (known & (speed_radps > _MOVING_RADPS)).any(axis=1)
    return float(step_s[moving].sum())
