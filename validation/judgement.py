"""Judgement of all seeds by a few draws: an estimate with its 95 % interval, and the verdict against a limit.

A limit that the worst of twenty draws just meets is missed by the next twenty. Here a statistic of all seeds is
estimated (their median, or what nine seeds in ten reach), and a limit is met only when the whole interval meets it.
"""

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from scipy import stats

from estimators.recording import Float

Verdict = Literal["pass", "open", "short"]
"""`open`: the limit lies within the confidence interval, and these seeds do not decide."""
TAIL: Final = 0.025
"""Probability left out at either end of an interval."""


@dataclass(frozen=True)
class Estimate:
    """A statistic of all seeds as the drawn ones show it.

    Attributes
    ----------
    low, high : float
        Ends of the 95 % confidence interval, or, where the seeds are too few for one, the extremes drawn.
    """

    value: float
    low: float
    high: float

    def verdict(self, limit: float, *, at_most: bool) -> Verdict:
        """Hold the interval against a limit; an interval that is not a number never passes."""
        near, far = (self.low, self.high) if at_most else (-self.high, -self.low)
        edge = limit if at_most else -limit
        if far <= edge:
            return "pass"
        return "open" if near <= edge else "short"


def quantile(values: Float, share: float) -> Estimate:
    """Estimate a quantile over all seeds from its order statistics, whatever the distribution.

    Parameters
    ----------
    values : ndarray, shape (N,)
        One a seed, N > 0; infinite where nothing could be measured.
    share : float
        0.5 for the median, 0.9 for what nine seeds in ten stay below.

    Notes
    -----
    The number of draws below the quantile is binomial (David and Nagaraja, Order Statistics, 2003, section 7.1).
    """
    ordered = np.sort(values)
    count = len(ordered)
    below = stats.binom.cdf(np.arange(count), count, share)
    low = max(int(np.searchsorted(below, TAIL, side="right")), 1)
    high = min(int(np.searchsorted(below, 1.0 - TAIL)) + 1, count)
    middle = np.median(ordered) if share == 0.5 else ordered[int(np.ceil(share * count - 1e-9)) - 1]
    return Estimate(float(middle), float(ordered[low - 1]), float(ordered[high - 1]))


def mean(values: Float) -> Estimate:
    """Estimate a mean over batches of seeds with Student's interval; of one batch there is none.

    Parameters
    ----------
    values : ndarray, shape (N,)
        One a batch, N > 0.
    """
    middle, count = float(values.mean()), len(values)
    if count < 2 or not np.isfinite(middle):
        return Estimate(middle, middle, middle)
    half = float(stats.t.ppf(1.0 - TAIL, count - 1) * values.std(ddof=1) / np.sqrt(count))
    return Estimate(middle, middle - half, middle + half)
