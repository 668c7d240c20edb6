"""One number of a walk: mean over strides, what it may be off, and how strides vary by themselves."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from estimators.recording import Float

_LEAST_FOR_SPREAD = 3
_ENOUGH, _PRIOR_STRIDES = 6, 4.0
_DEGREE: Final = np.deg2rad(1.0)

NATURAL_SHARE: Final = {
    "stride_length": 0.04,
    "stride_time": 0.03,
    "stance_time": 0.04,
    "swing_time": 0.05,
    "stance_share": 0.03,
    "speed": 0.05,
    "cadence": 0.03,
    "step_time": 0.04,
    "step_length": 0.05,
    "double_support": 0.10,
    "double_support_share": 0.10,
    "walk_ratio": 0.05,
    "clearance": 0.10,
}
"""How much strides vary, standard deviation over mean, before a walk has shown its own.

Healthy adults of 65 and more vary by 2 to 3 % in stride time, 3 to 4 % in stride length, 4 to 5 % in swing time and 4
to 6 % in speed; double support and what depends on small differences vary by more (Beauchet et al., Front Hum Neurosci
11 (2017) 353; Beauchet et al., Gerontology 55 (2009) 702-706; Almarwani et al., Gait Posture 44 (2016) 94-99). Rounded
up by us: patients vary more.
"""
NATURAL: Final = {
    "step_width": 0.02,
    "circumduction": 0.01,
    "contact_pitch": 2.0 * _DEGREE,
    "toe_off_pitch": 2.0 * _DEGREE,
    "toe_out": 2.0 * _DEGREE,
}
"""The same of what may be near zero, m and rad."""


@dataclass(frozen=True)
class Measure:
    """One number of a walk.

    Attributes
    ----------
    value : float
        Mean over the strides; NaN when there is none.
    sigma : float
        Of that mean: the standard error from the spread over strides and what the sensors leave uncertain, and
        `shared`, which no number of strides makes smaller. Of fewer than 6 strides the spread is not below
        what strides are known to vary.
    spread : float
        Standard deviation over strides (ddof 1); NaN below 3 strides.
    count : int
        Strides.
    shared : float
        One sigma of what is the same in every stride: events found late alike, foot axes, the feet's distance.
    """

    value: float
    sigma: float
    spread: float
    count: int
    unit: str
    shared: float = 0.0


def measure(
    values: Float, unit: str, sigma: Float | float = 0.0, shared: float = 0.0, name: str = ""
) -> Measure:
    """Average values of single strides that are known.

    Parameters
    ----------
    values : ndarray, shape (n,)
        NaN where it is not known.
    sigma : float or ndarray, shape (n,)
        Of each value by itself.
    shared : float
        Of all of them alike: no average makes it smaller.
    name : str
        A key of `NATURAL_SHARE` or `NATURAL`: one or two strides say nothing of how much they vary.
    """
    known = np.isfinite(values)
    count = int(np.count_nonzero(known))
    if count == 0:
        return Measure(float("nan"), float("nan"), float("nan"), 0, unit)
    chosen = values[known]
    each = np.broadcast_to(sigma, values.shape)[known]
    mean = float(chosen.mean())
    spread = float(chosen.std(ddof=1)) if count >= _LEAST_FOR_SPREAD else float("nan")
    varies = spread if np.isfinite(spread) else 0.0
    natural = NATURAL.get(name, NATURAL_SHARE.get(name, 0.0) * abs(mean))
    if natural and count < _ENOUGH:
        # A scaled inverse chi-squared prior of the variance, worth four strides; a walk that varies more has its own.
        squares = float(np.sum((chosen - mean) ** 2))
        pooled = float(np.sqrt((_PRIOR_STRIDES * natural**2 + squares) / (_PRIOR_STRIDES + count - 1)))
        varies = max(varies, pooled)
    sensors = float(np.sqrt(np.mean(each**2)))
    # The spread over strides already holds what the sensors add to each; with few strides only that is known.
    error = max(varies, sensors)
    total = float(np.hypot(error / np.sqrt(count), shared))
    return Measure(mean, total, spread, count, unit, shared)


def variation(values: Float, each: float = 0.0) -> Measure:
    """Return the coefficient of variation; `each` is what finding a value adds to its spread."""
    known = values[np.isfinite(values)]
    count = len(known)
    if count < _LEAST_FOR_SPREAD:
        return Measure(float("nan"), float("nan"), float("nan"), count, "1")
    share = float(known.std(ddof=1) / known.mean())
    sampling, found = share / np.sqrt(2.0 * (count - 1)), each / float(known.mean())
    return Measure(share, float(np.hypot(sampling, found)), float("nan"), count, "1", found)


def difference(left: Measure, right: Measure) -> Measure:
    """Return left less right over their mean."""
    mean = 0.5 * (left.value + right.value)
    value = (left.value - right.value) / mean if mean else float("nan")
    # What both feet share of it falls out of their difference; one foot may have it by itself, as a dropped foot does.
    own = [max(one.sigma**2 - one.shared**2, 0.0) for one in (left, right)]
    shared = max(left.shared, right.shared)
    sigma = float(np.sqrt(own[0] + own[1] + shared**2) / abs(mean)) if mean else float("nan")
    return Measure(value, sigma, float("nan"), min(left.count, right.count), "1")
