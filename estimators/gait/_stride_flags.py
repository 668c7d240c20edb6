"""Which strides cannot be believed, and why."""

from enum import IntFlag

import numpy as np
from numpy.typing import NDArray

from estimators.gait.foot.trajectory import FootFlag, FootTrajectory
from estimators.recording import Float

_NEAR, _LONG_SHARE = 3, 1.6


class StrideFlag(IntFlag):
    """Why a stride is averaged into nothing; zero means sound."""

    SOUND = 0
    MISSING = 1
    """Samples are missing within it, in the stances at its ends or just before: more than one stride may lie there."""
    ALOFT = 2
    """The foot moved for so long without standing that its way is not known; that is no stride of walking."""
    LONG = 4
    """It took far longer than the strides around it: a stance between two strides was not found, or somebody halted."""
    SIDEWAYS = 8
    """The foot points more than 60 degrees away from where it went: a step aside, or back."""
    OUTSIDE = 16
    """Made before Record was pressed or after Stop: the way to the line, no part of the test."""


def long_strides(duration_s: Float, is_sound: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Find strides that take 1.6 times as long as the three before and the three after, shape (n,).

    Parameters
    ----------
    duration_s : ndarray, shape (n,)
        NaN where it is not known.
    is_sound : ndarray of bool, shape (n,)
        Strides that may tell how long others are.

    Notes
    -----
    Length says less: from stairs to the floor a sound stride doubles.
    """
    known = is_sound & np.isfinite(duration_s)
    found = np.zeros(len(duration_s), dtype=np.bool_)
    for k in np.flatnonzero(known).tolist():
        near = np.arange(max(0, k - _NEAR), min(len(known), k + _NEAR + 1))
        near = near[known[near] & (near != k)]
        if len(near) >= 2:
            found[k] = duration_s[k] > _LONG_SHARE * np.median(duration_s[near])
    return found


def missing_samples(
    trajectory: FootTrajectory, rests: list[tuple[int, int]]
) -> tuple[Float, NDArray[np.bool_]]:
    """Find the strides in which samples were lost for longer than can be interpolated.

    Parameters
    ----------
    rests : list of (int, int)
        Half-open stretches of samples in which the foot rests; a stride lies between two of them.

    Returns
    -------
    missing_s : ndarray, shape (n,)
        Missing from the start of the stance before a stride to the start of the one that ends it.
    is_doubtful : ndarray of bool, shape (n,)
        Whether samples are missing anywhere from the end of the stance before the last to the end of the stance
        after: the first stance after a gap does not yet tell the attitude well enough for a length.
    """
    lost = (trajectory.flags & FootFlag.INVALID) != 0
    step_s = np.diff(trajectory.time_s, append=trajectory.time_s[-1])
    gone = np.concatenate([[0.0], np.cumsum(step_s * lost)])
    count = np.concatenate([[0], np.cumsum(lost)])
    starts = np.array([rest[0] for rest in rests], dtype=np.int64)
    stops = np.array([0] + [rest[1] for rest in rests], dtype=np.int64)
    return np.diff(gone[starts]), np.asarray(count[stops[2:]] > count[stops[:-2]])
