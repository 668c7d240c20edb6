"""One person under two conditions, or before and after: paired over recordings, or over strides."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy

from estimators.balance._repeated_measures import repeated_measures
from estimators.errors import ShapeError


@dataclass(frozen=True)
class Sample:
    """A measure of one recording: mean over its strides, their standard deviation and their number."""

    mean: float
    spread: float
    count: int


@dataclass(frozen=True)
class Change:
    """What a condition changes in one measure.

    Attributes
    ----------
    difference, sigma : float
        B less A and its standard error.
    p : float
        Probability of a difference at least as large by chance; NaN where it cannot be determined.
    effect : float
        Difference in units of its standard deviation (over pairs, or over strides).
    count : int
        Pairs of recordings, or strides of both conditions together.
    """

    mean_a: float
    mean_b: float
    difference: float
    sigma: float
    p: float
    effect: float
    count: int
    method: Literal["pairs", "strides"]


def compare_conditions(a: Sequence[Sample], b: Sequence[Sample]) -> Change:
    """Compare one measure between two conditions.

    Parameters
    ----------
    a, b : sequence of Sample
        Recordings of each condition, in order; as many of both and two at least are taken as pairs.

    Returns
    -------
    Change
        With pairs, the repeated-measures model: its F(1, n - 1) is the square of the paired t. Otherwise all strides of
        a condition are one sample, and Welch's test compares the two.

    Raises
    ------
    ShapeError
        If a condition has no value that is known.
    """
    known_a, known_b = ([one for one in side if np.isfinite(one.mean)] for side in (a, b))
    if not known_a or not known_b:
        raise ShapeError("a condition has no value of this measure")
    if len(a) == len(b) >= 2 and len(known_a) == len(a) and len(known_b) == len(b):
        table = np.array([[one.mean, two.mean] for one, two in zip(a, b, strict=True)])
        apart = table[:, 1] - table[:, 0]
        spread = float(apart.std(ddof=1))
        p = repeated_measures(table, ("condition",))[0].p_corrected if spread > 0.0 else float("nan")
        mean_a, mean_b = (float(v) for v in table.mean(axis=0))
        effect = float(apart.mean()) / spread if spread > 0.0 else float("nan")
        return Change(
            mean_a, mean_b, mean_b - mean_a, spread / np.sqrt(len(apart)), p, effect, len(apart), "pairs"
        )
    one, two = _pooled(known_a), _pooled(known_b)
    difference = two.mean - one.mean
    with np.errstate(invalid="ignore", divide="ignore"):
        variances = np.array([part.spread**2 / max(part.count, 1) for part in (one, two)])
        sigma = float(np.sqrt(variances.sum()))
        freedoms = np.array([max(part.count - 1, 0) for part in (one, two)])
        degrees = float(variances.sum() ** 2 / np.sum(variances**2 / freedoms))
        p = float(2.0 * scipy.stats.t.sf(abs(difference) / sigma, degrees)) if sigma > 0.0 else float("nan")
        effect = float(difference / np.sqrt(0.5 * (one.spread**2 + two.spread**2)))
    return Change(one.mean, two.mean, difference, sigma, p, effect, one.count + two.count, "strides")


def _pooled(samples: Sequence[Sample]) -> Sample:
    """Put the strides of several recordings together."""
    counts = np.array([max(one.count, 1) for one in samples], dtype=np.float64)
    means = np.array([one.mean for one in samples])
    total = counts.sum()
    mean = float(counts @ means / total)
    within = np.array([one.spread**2 * (one.count - 1) if one.count > 1 else 0.0 for one in samples])
    between = counts * (means - mean) ** 2
    spread = float(np.sqrt((within.sum() + between.sum()) / (total - 1.0))) if total > 1.0 else float("nan")
    if not np.isfinite(spread):
        spread = float("nan")
    return Sample(mean, spread, int(total))
