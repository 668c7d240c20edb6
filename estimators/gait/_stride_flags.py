"""Which strides cannot be believed, and why."""

from enum import IntFlag

import numpy as np
from numpy.typing import NDArray

from estimators.gait._foot_trajectory import FootFlag, FootTrajectory
from estimators.recording import Float


class StrideFlag(IntFlag):
    """Why a stride is averaged into nothing; zero means sound."""

    SOUND = 0
    MISSING = 1
    """Samples are missing within it, in the stances at its ends or just before: more than one stride may lie there."""
    ALOFT = 2
    """The foot moved for so long without standing that its way is not known; that is no stride of walking."""


def missing_samples(
    trajectory: FootTrajectory, rests: list[tuple[int, int]]
) -> tuple[Float, NDArray[np.bool_]]:
    """Find the strides in which samples were lost for longer than can be interpolated.

    Parameters
    ----------
    trajectory : FootTrajectory
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


__all__ = ["StrideFlag", "missing_samples"]
