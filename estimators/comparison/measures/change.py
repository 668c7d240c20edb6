"""From which difference on a change is no chance, by test and retest."""

from collections.abc import Sequence
from typing import Final

import numpy as np
import scipy

FEWEST_SESSIONS: Final = 3


def detectable_change(session_means: Sequence[float]) -> float:
    """Return how far a next session must be from the mean of a person's own baseline to be a change.

    Parameters
    ----------
    session_means : sequence of float
        One mean each of k baseline sessions, at least a day apart with the sensors put on anew; NaN does not count.

    Returns
    -------
    float
        t_{0.975,k-1} s_B sqrt(1 + 1/k), in the unit of the measure; NaN for fewer than three. 50, 54 and 52 give 9.94.
        Five baselines or more are worth asking for: the factor on s_B falls from 4.97 (3) to 3.04 (5).

    Notes
    -----
    Weir 2005, J Strength Cond Res 19:231. The spread between repetitions of one session says nothing of the next.
    """
    values = np.array([value for value in session_means if np.isfinite(value)])
    count = len(values)
    if count < FEWEST_SESSIONS:
        return float("nan")
    quantile = float(scipy.special.stdtrit(count - 1, 0.975))
    return quantile * float(values.std(ddof=1)) * float(np.sqrt(1.0 + 1.0 / count))


def pooled_detectable_change(baselines: Sequence[Sequence[float]]) -> float:
    """Return the same for people in general: 1.96 sqrt(2) SEM, the SEM pooled over their baselines.

    Parameters
    ----------
    baselines : sequence of sequences of float
        Of each person the means of the baseline sessions; those with fewer than two do not count.

    Returns
    -------
    float
        NaN for fewer than two degrees of freedom in all. Of 50, 54 and 52 alone it is 5.54.
    """
    square, freedom = 0.0, 0
    for means in baselines:
        values = np.array([value for value in means if np.isfinite(value)])
        if len(values) > 1:
            square += float(np.sum((values - values.mean()) ** 2))
            freedom += len(values) - 1
    if freedom < FEWEST_SESSIONS - 1:
        return float("nan")
    return 1.96 * float(np.sqrt(2.0 * square / freedom))


__all__ = ["detectable_change", "pooled_detectable_change"]
