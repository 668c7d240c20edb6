"""The models between which the data choose: how days hang together, and how far the level bends.

Each is a Gaussian model of the values of some days: a straight level, with a free step where a segment begins; the
day's own deviation, of variance S^2 and correlated from day to day; and a bend of the level (integrated Wiener
process, whose smoother is the cubic spline: Wahba 1978, J R Stat Soc B 40:364). All scale with S.
"""

from dataclasses import dataclass
from functools import lru_cache
from itertools import product
from typing import Final

import numpy as np

from estimators.recording import Float

CORRELATIONS: Final = ((0.0, 0.40), (0.2, 0.25), (0.4, 0.19), (0.6, 0.10), (0.75, 0.06))
"""Of neighbouring days, with their weights: 0.23 in the mean."""
BENDS: Final = ((0.0, 0.78), (0.1, 0.15), (0.3, 0.05), (1.0, 0.02))
"""How far the level leaves a straight line within a week, in S for each week to the power 3/2, with their weights."""
GAP_DAYS: Final = 10.0
"""Over a longer pause the level may have gone on with the calendar, or have waited for the next session."""
_WEEK_DAYS: Final = 7.0


@dataclass(frozen=True)
class Models:
    """K models of n days, ready for any number of series.

    Attributes
    ----------
    residual : ndarray, shape (K, n, n)
        y' residual y is the sum of squares that is left, in S^2.
    start, end, following : ndarray, shape (K, n)
        Weights of the values for the level of the first and of the last day, and for the value to come.
    change_variance, following_variance : ndarray, shape (K,)
        In S^2.
    log_weight : ndarray, shape (K,)
        Before the data, with what the likelihood has beside the sum of squares.
    """

    residual: Float
    start: Float
    end: Float
    following: Float
    change_variance: Float
    following_variance: Float
    log_weight: Float
    freedom: int


def models_of(
    times_days: Float, segments: Float, extra: Float, next_day: float, next_segment: float
) -> Models:
    """Return the models of some days.

    Parameters
    ----------
    times_days : ndarray, shape (n,)
        Ascending, at least four different ones.
    segments : ndarray, shape (n,)
        Ascending numbers; the level may step where they rise.
    extra : ndarray, shape (n,)
        Variance of a value beyond S^2, in S^2.
    next_day, next_segment : float
        Of the value to come.
    """
    return _cached(times_days.tobytes(), segments.tobytes(), extra.tobytes(), next_day, next_segment)


@lru_cache(maxsize=256)
def _cached(times: bytes, segments: bytes, extra: bytes, next_day: float, next_segment: float) -> Models:
    days = np.append(np.frombuffer(times), next_day)
    steps = np.append(np.frombuffer(segments), next_segment)
    return _build(days, steps, np.frombuffer(extra))


def _clocks(days: Float) -> list[Float]:
    """Return the weeks of each day by the calendar, and without long pauses where there are any."""
    gaps = np.diff(days)
    found = [(days - days[0]) / _WEEK_DAYS]
    if len(gaps) > 1 and gaps[:-1].max() > GAP_DAYS:
        usual = np.median(gaps[:-1])
        found.append(np.append(0.0, np.cumsum(np.where(gaps > GAP_DAYS, usual, gaps))) / _WEEK_DAYS)
    return found


def _build(days: Float, steps: Float, extra: Float) -> Models:
    """Build the models of all days but the last, which is the one to come."""
    count = len(days) - 1
    usual = max(float(np.median(np.diff(days[:-1]))), 1.0)
    rises = [(steps >= at).astype(np.float64) for at in np.unique(steps)[1:] if (steps[:-1] >= at).any()]
    clocks = _clocks(days)
    parts = [_of_clock(weeks, usual, rises, extra) for weeks in clocks]
    joined = [np.concatenate(one) for one in zip(*parts, strict=True)]
    joined[-1] = joined[-1] - np.log(len(clocks))
    residual, start, end, following, change_variance, following_variance, log_weight = joined
    return Models(
        residual,
        start,
        end,
        following,
        change_variance,
        following_variance,
        log_weight,
        freedom=count - 2 - len(rises),
    )


def _of_clock(weeks: Float, usual_days: float, rises: list[Float], extra: Float) -> tuple[Float, ...]:
    """Return the fields of `Models` by one clock, one line a model (universal kriging)."""
    count = len(weeks) - 1
    lag = np.abs(weeks[:, None] - weeks) * (_WEEK_DAYS / usual_days)
    short, long = np.minimum(weeks[:, None], weeks), np.maximum(weeks[:, None], weeks)
    bend = short**2 * (3.0 * long - short) / 6.0
    choices = list(product(CORRELATIONS, BENDS))
    by_correlation = {}
    for correlation, _ in CORRELATIONS:
        # Second differences see less of S the more days resemble each other, by the bracket; those of a clinic in which
        # few do are nearer to S itself.
        wider = (1.0 - 4.0 / 3.0 * correlation + correlation**2 / 3.0) ** -0.15
        alike = correlation**lag if correlation else np.eye(count + 1)
        np.fill_diagonal(alike, 1.0)
        by_correlation[correlation] = wider * alike
    own = np.array([by_correlation[correlation] for (correlation, _), _ in choices])
    curved = np.array([size for _, (size, _) in choices])[:, None, None] ** 2 * bend
    design = np.column_stack([np.ones(count + 1), weeks, *rises])
    # What a step adds is no change of the person.
    level = np.column_stack([np.ones(count + 1), weeks, *(np.zeros_like(one) for one in rises)])
    x = design[:count]
    known = (own + curved)[:, :count, :count] + np.diag(extra)
    inverse = np.linalg.inv(known)
    leaning = inverse @ x
    normal = x.T @ leaning
    normal_inverse = np.linalg.inv(normal)
    fit = normal_inverse @ np.swapaxes(leaning, 1, 2)
    residual = inverse - leaning @ fit

    def weights(at: Float, covariance: Float) -> Float:
        found: Float = at @ fit + (covariance[:, None, :] @ residual)[:, 0]
        return found

    def variance(at: Float, covariance: Float, alone: Float) -> Float:
        left = at - (covariance[:, None, :] @ leaning)[:, 0]
        seen = np.einsum("ki,kij,kj->k", covariance, inverse, covariance, optimize=True)
        return np.asarray(alone - seen + np.einsum("ki,kij,kj->k", left, normal_inverse, left, optimize=True))

    last = count - 1
    rise = curved[:, last, :count] - curved[:, 0, :count]
    with_next = (own + curved)[:, -1, :count]
    bent = curved[:, last, last] - 2.0 * curved[:, 0, last] + curved[:, 0, 0]
    log_weight = np.log([likely * bends for (_, likely), (_, bends) in choices])
    log_weight = log_weight - 0.5 * np.linalg.slogdet(known)[1] - 0.5 * np.linalg.slogdet(normal)[1]
    return (
        residual,
        weights(level[0], curved[:, 0, :count]),
        weights(level[last], curved[:, last, :count]),
        weights(design[-1], with_next),
        variance(level[last] - level[0], rise, bent),
        variance(design[-1], with_next, own[:, -1, -1] + curved[:, -1, -1]),
        log_weight,
    )
