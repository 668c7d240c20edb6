"""The trend of series over days: change since the baseline, its interval, and how likely it is above zero."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import scipy

from estimators.errors import ShapeError
from estimators.progress._models import Models, models_of
from estimators.progress._scatter import Scatter, scatter_of, second_differences
from estimators.recording import Float

WINDOW_DAYS: Final = 56.0
"""Eight weeks: what lies before is another time."""
FEWEST_DAYS: Final = 4
"""Of fewer only the values are shown."""
UNUSUAL: Final = 0.01
"""Two-sided: a last day this unlikely by the days before it is an unusual one, and changes nothing yet."""
LASTING: Final = 0.9
"""A change that is said must be at least this likely without the last day: one good day is no change."""
ALONE: Final = 0.99
"""Where the days before the last are too few to say anything, it must be at least this likely by all of them."""
_MOST_EXTRA: Final = 25.0
_LEAST_EXTRA: Final = 0.25


@dataclass(frozen=True)
class Trends:
    """What is known of M series.

    Attributes
    ----------
    first : int
        Index of the first day of the window: the baseline.
    start, end : ndarray, shape (M,)
        Level of the first and of the last day of the window, in the unit of the series; NaN of fewer than four days.
    change, half_width : ndarray, shape (M,)
        Change of the level since the baseline without steps where a segment begins, and half its 95 % interval.
    probability : ndarray, shape (M,)
        That the change is above zero.
    lasts : ndarray of bool, shape (M,)
        Whether the direction is at least 90 % likely without the last day, too; of four days alone whether it is 99 %.
    scatter : ndarray, shape (M,)
        Standard error of measurement S, shrunk to the prior.
    unusual : ndarray of bool, shape (M,)
        The last day is; it is then left out of all that is said above but `scatter`.
    expected : ndarray, shape (M,)
        What the days before let expect of the last one.
    """

    first: int
    start: Float
    end: Float
    change: Float
    half_width: Float
    probability: Float
    lasts: np.ndarray
    scatter: Float
    unusual: np.ndarray
    expected: Float


def trends(
    times_days: Float,
    values: Float,
    errors: Float | None = None,
    segments: Float | None = None,
    priors: Scatter | Sequence[Scatter] | None = None,
    window_days: float = WINDOW_DAYS,
) -> Trends:
    """Judge the change of series that share their days.

    Parameters
    ----------
    times_days : ndarray, shape (N,)
        Strictly ascending: one value a day.
    values : ndarray, shape (M, N)
    errors : ndarray, shape (M, N), optional
        What the repetitions say of each value, one standard deviation; NaN where they say nothing.
    segments : ndarray, shape (N,), optional
        Numbers that rise where the series breaks (another estimator, template, placement): the level may step there.

    Notes
    -----
    A mixture over `estimators.progress._models`, weighted by marginal likelihood: S^2 is integrated out against its
    inverse chi-square prior, so that each model gives a Student distribution (O'Hagan and Forster, Bayesian Inference,
    chapter 11), and what the repetitions say is the least that its scale may be.
    """
    times = np.asarray(times_days, dtype=np.float64)
    series = np.atleast_2d(np.asarray(values, dtype=np.float64))
    if times.ndim != 1 or series.shape[1] != len(times) or (len(times) > 1 and np.diff(times).min() <= 0.0):
        raise ShapeError("days must ascend strictly, with one value of each series a day")
    rows = len(series)
    first = int(np.searchsorted(times, times[-1] - window_days)) if len(times) else 0
    times, series = times[first:], series[:, first:]
    wide = np.zeros_like(series) if errors is None else np.atleast_2d(errors)[:, first:]
    wide = np.where(np.isfinite(wide), wide, 0.0)
    parts = np.zeros(len(times)) if segments is None else np.asarray(segments, dtype=np.float64)[first:]
    given = priors if isinstance(priors, Sequence) else [priors or Scatter(0.0, 0.0)] * rows
    least = np.sqrt(np.mean(wide**2, axis=1)) if len(times) else np.zeros(rows)
    variance, freedom = second_differences(times, series, parts)
    scatter = np.array(
        [scatter_of(float(variance[k]), freedom, given[k], float(least[k])) for k in range(rows)]
    )
    found = [np.full(rows, np.nan) for _ in range(6)]
    flags = [np.zeros(rows, dtype=np.bool_) for _ in range(2)]
    if len(times) >= FEWEST_DAYS:
        extra = _extra(wide, scatter)
        for row in np.unique(extra, axis=0):
            same = np.flatnonzero((extra == row).all(axis=1))
            some = _judged(times, series[same], parts, row, least[same], [given[int(k)] for k in same])
            for into, out in zip((*found, *flags), some, strict=True):
                into[same] = out
    start, end, change, half_width, probability, expected = found
    return Trends(first, start, end, change, half_width, probability, flags[0], scatter, flags[1], expected)


def _extra(errors: Float, scatter: Float) -> Float:
    """Return by how much each value is less certain than the usual one, in S^2; what is little is nothing."""
    usual = np.median(errors**2, axis=1, keepdims=True)
    square = np.where(scatter > 0.0, scatter, np.inf)[:, None] ** 2
    more = np.clip((errors**2 - usual) / square, 0.0, _MOST_EXTRA)
    return np.where(more < _LEAST_EXTRA, 0.0, np.round(more, 2))


def _said_by(one: "_Mixture") -> list[Float]:
    """Return start, end, change, half width and, last, the probability of a change above zero."""
    return [one.mean(one.models.start), one.mean(one.models.end), *one.change()]


def _judged(
    times: Float, series: Float, segments: Float, extra: Float, least: Float, priors: Sequence[Scatter]
) -> tuple[np.ndarray, ...]:
    """Return start, end, change, half width, probability, expected, lasting and unusual of series that share models."""
    whole = _Mixture(models_of(times, segments, extra, times[-1] + 1.0, segments[-1]), series, least, priors)
    values = _said_by(whole)
    above = values[-1]
    rows = len(series)
    if len(times) <= FEWEST_DAYS or whole.models.freedom < FEWEST_DAYS - 2:
        alone = np.maximum(above, 1.0 - above) >= ALONE
        return (*values, np.full(rows, np.nan), alone, np.zeros(rows, dtype=np.bool_))
    models = models_of(times[:-1], segments[:-1], extra[:-1], float(times[-1]), float(segments[-1]))
    before = _Mixture(models, series[:, :-1], least, priors)
    expected, tail = before.following(series[:, -1])
    # Where a segment begins with the last day, nothing can be expected of it.
    unusual = (tail < UNUSUAL) & bool(segments[-1] == segments[-2])
    earlier = _said_by(before)
    above_before = earlier[-1]
    likely = np.where(above >= 0.5, above_before, 1.0 - above_before)
    said = [np.where(unusual, old, new) for old, new in zip(earlier, values, strict=True)]
    return (*said, expected, unusual | (likely >= LASTING), unusual)


class _Mixture:
    """The Student distributions of some models, with the weights that series give them."""

    def __init__(self, models: Models, series: Float, least: Float, priors: Sequence[Scatter]) -> None:
        self.models, self.series = models, series
        known = np.array([one.freedom for one in priors])
        before = np.array([one.freedom * one.variance for one in priors])
        left = np.einsum("mi,kij,mj->km", series, models.residual, series, optimize=True)
        # What is exactly straight leaves the rounding of its values.
        nothing = (1e-9 * np.abs(series).max(axis=1)) ** 2 + 1e-300
        square = np.maximum(left, 0.0) + before + nothing
        self.freedom = known + models.freedom
        self.scale2 = np.maximum(square / self.freedom, least**2)
        weight = models.log_weight[:, None] - 0.5 * self.freedom * np.log(square)
        weight = np.exp(weight - weight.max(axis=0))
        self.weight = weight / weight.sum(axis=0)

    def mean(self, weights: Float) -> Float:
        """Return the mean of what has these weights of the values."""
        found: Float = np.sum(self.weight * (weights @ self.series.T), axis=0)
        return found

    def change(self) -> tuple[Float, Float, Float]:
        """Return mean, half of the 95 % interval and the probability to be above zero."""
        middles = (self.models.end - self.models.start) @ self.series.T
        widths = np.sqrt(self.scale2 * self.models.change_variance[:, None])
        mean = np.sum(self.weight * middles, axis=0)
        above = np.sum(self.weight * scipy.special.stdtr(self.freedom, middles / widths), axis=0)
        low, high = np.zeros_like(mean), 50.0 * widths.max(axis=0) + np.ptp(middles, axis=0)
        for _ in range(28):
            half = 0.5 * (low + high)
            inside = np.sum(
                self.weight
                * (
                    scipy.special.stdtr(self.freedom, (mean + half - middles) / widths)
                    - scipy.special.stdtr(self.freedom, (mean - half - middles) / widths)
                ),
                axis=0,
            )
            low, high = np.where(inside < 0.95, half, low), np.where(inside < 0.95, high, half)
        return mean, high, above

    def following(self, value: Float) -> tuple[Float, Float]:
        """Return what is expected of the next value, and how likely one as far from it is."""
        middles = self.models.following @ self.series.T
        widths = np.sqrt(self.scale2 * self.models.following_variance[:, None])
        below = np.sum(self.weight * scipy.special.stdtr(self.freedom, (value - middles) / widths), axis=0)
        return np.sum(self.weight * middles, axis=0), 2.0 * np.minimum(below, 1.0 - below)
