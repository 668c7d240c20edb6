"""By how much one session differs from another while nothing changes: the standard error of measurement."""

from dataclasses import dataclass
from typing import Final

import numpy as np
import scipy

from estimators.errors import ShapeError
from estimators.recording import Float

FEWEST_SESSIONS: Final = 4
"""With fewer there is a single second difference, or none."""
_FEWEST_PEOPLE: Final = 5
_MOST_FREEDOM: Final = 20.0
"""A prior never counts for more sessions than these: people differ, whatever few of them showed."""
_SMALLEST_SHARE: Final = 1e-3
"""Of the median: a variance of nothing has no logarithm."""


@dataclass(frozen=True, slots=True)
class Scatter:
    """What is known of a variance before a person's own sessions: scaled inverse chi-square.

    Attributes
    ----------
    variance : float
        Scale, in the square of the unit of the measure.
    freedom : float
        For how many sessions it counts; 0: nothing is known.
    people : int
        From how many it was learnt; 0 of what was published.
    """

    variance: float
    freedom: float
    people: int = 0


NO_PRIOR: Final = Scatter(0.0, 0.0)


def second_differences(
    times_days: Float, values: Float, segments: Float | None = None
) -> tuple[Float, float]:
    """Return the variance between sessions that no straight trend can inflate, and its degrees of freedom.

    Parameters
    ----------
    times_days : ndarray, shape (N,)
        Ascending.
    values : ndarray, shape (N,) or (M, N)
        Of M series at the same times.
    segments : ndarray, shape (N,), optional
        Triples across the border of two segments do not count.

    Returns
    -------
    variance : ndarray, shape () or (M,)
        Square of the standard error of measurement; NaN without a single triple.
    freedom : float

    Notes
    -----
    Of each three neighbours the middle one less the line through the other two, y_i - a y_(i-1) - b y_(i+1), has
    variance S^2 (1 + a^2 + b^2); Gasser, Sroka and Jennen-Steinmetz 1986, Biometrika 73:625. At even times its square
    is (y_(i-1) - 2 y_i + y_(i+1))^2 / 6. Freedom by Satterthwaite, as the triples of even times overlap.
    """
    times = np.asarray(times_days, dtype=np.float64)
    series = np.asarray(values, dtype=np.float64)
    if times.ndim != 1 or series.shape[-1] != len(times):
        raise ShapeError(f"times of shape {times.shape} do not fit values of shape {series.shape}")
    inner = np.arange(1, len(times) - 1)
    if segments is not None:
        inner = inner[np.asarray(segments)[inner - 1] == np.asarray(segments)[inner + 1]]
    if not len(inner):
        return np.full(series.shape[:-1], np.nan), 0.0
    whole = times[inner + 1] - times[inner - 1]
    before = np.where(whole > 0.0, (times[inner + 1] - times[inner]) / np.where(whole > 0.0, whole, 1.0), 0.5)
    after = 1.0 - before
    left = series[..., inner] - before * series[..., inner - 1] - after * series[..., inner + 1]
    variance = np.mean(left**2 / (1.0 + before**2 + after**2), axis=-1)
    count = len(inner)
    overlap = count + 2 * max(count - 1, 0) * (2.0 / 3.0) ** 2 + 2 * max(count - 2, 0) / 36.0
    return variance, count**2 / overlap


def learn_scatter(variances: Float, freedoms: Float) -> Scatter:
    """Return what the people of a clinic say of the next one, by empirical Bayes.

    Parameters
    ----------
    variances, freedoms : ndarray, shape (P,)
        Of each person, from `second_differences`.

    Returns
    -------
    Scatter
        `NO_PRIOR` of fewer than five people.

    Notes
    -----
    With S^2 of people inverse chi-square the variances over its scale follow F; scale and freedom from mean and
    variance of their logarithms: Smyth 2004, Stat Appl Genet Mol Biol 3(1):3, section 6.2.
    """
    known = np.isfinite(variances) & (freedoms > 0.0) & (variances >= 0.0)
    found, freedom = np.asarray(variances)[known], np.asarray(freedoms)[known]
    if len(found) < _FEWEST_PEOPLE or not (found > 0.0).any():
        return NO_PRIOR
    found = np.maximum(found, _SMALLEST_SHARE * np.median(found[found > 0.0]))
    half = 0.5 * freedom
    logs = np.log(found) - scipy.special.digamma(half) + np.log(half)
    beyond = float(logs.var(ddof=1) - scipy.special.polygamma(1, half).mean())
    own = _MOST_FREEDOM
    if beyond > scipy.special.polygamma(1, 0.5 * _MOST_FREEDOM):
        own = 2.0 * _inverse_trigamma(beyond)
    scale = float(np.exp(logs.mean() + scipy.special.digamma(0.5 * own) - np.log(0.5 * own)))
    return Scatter(scale, own, len(found))


def _inverse_trigamma(value: float) -> float:
    """Solve trigamma(x) = value by Newton on its reciprocal, which is nearly straight."""
    x = 0.5 + 1.0 / value
    for _ in range(50):
        now = float(scipy.special.polygamma(1, x))
        step = now * (1.0 - now / value) / float(scipy.special.polygamma(2, x))
        x += step
        if abs(step) < 1e-9 * x:
            break
    return x


def scatter_of(variance: float, freedom: float, prior: Scatter, error: float = 0.0) -> float:
    """Return the standard error of measurement of one person: the own one shrunk to that of the clinic.

    Parameters
    ----------
    variance, freedom : float
        From `second_differences`.
    error : float
        What the repetitions of a session alone say, one standard deviation of their mean: never less than this.

    Returns
    -------
    float
        In the unit of the measure; NaN where nothing is known.
    """
    known = freedom if np.isfinite(variance) else 0.0
    if known + prior.freedom <= 0.0:
        return float("nan")
    shrunk = (known * (variance if known else 0.0) + prior.freedom * prior.variance) / (known + prior.freedom)
    return float(max(np.sqrt(shrunk), error))


def detectable_change(scatter: float) -> float:
    """Return by how much two single sessions differ in one of twenty cases without any change: 1.96 sqrt(2) S.

    Notes
    -----
    Weir 2005, J Strength Cond Res 19:231.
    """
    return 1.96 * float(np.sqrt(2.0)) * scatter
