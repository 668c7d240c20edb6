"""How joints go together, and how alike repetitions are."""

from dataclasses import dataclass
from typing import Final

import numpy as np
import scipy

from estimators.errors import ShapeError
from estimators.recording import Float

_LARGEST_LAG: Final = 0.25
"""Share of the stroke."""


@dataclass(frozen=True)
class Coordination:
    """How two joints move together in one stroke.

    Attributes
    ----------
    correlation : float
        Pearson's r at no lag.
    lag_s : float
        Lag of the largest r; positive where the second joint follows the first.
    common_share : float
        Share of the first principal component of both, each scaled to its own spread.
    """

    correlation: float
    lag_s: float
    common_share: float


def interjoint_coordination(
    first_rad: Float, second_rad: Float, rate_hz: float, floor_rad: float
) -> Coordination | None:
    """Return how two joints move together in an outward stroke.

    Parameters
    ----------
    first_rad, second_rad : ndarray, shape (N,)
    rate_hz : float
    floor_rad : float
        Range below which a joint does not take part.

    Returns
    -------
    Coordination, or None
        None where the range of a joint is below the floor, or with gaps.

    Notes
    -----
    Cirstea and Levin 2000, Brain 123:940. Two sines an eighth of a period apart have r = 0.7071 and share 0.8536.
    """
    if first_rad.shape != second_rad.shape or first_rad.ndim != 1:
        raise ShapeError(f"two joints of shapes {first_rad.shape} and {second_rad.shape}; both must be (N,)")
    both = np.stack([first_rad, second_rad])
    if len(first_rad) < 8 or not np.isfinite(both).all() or np.ptp(both, axis=1).min() < floor_rad:
        return None
    largest = int(_LARGEST_LAG * len(first_rad))
    at_lags = _at_lags(first_rad, second_rad, largest)
    correlation = float(at_lags[largest])
    lag = int(np.nanargmax(at_lags)) - largest
    return Coordination(correlation, lag / rate_hz, 0.5 * (1.0 + abs(correlation)))


def _at_lags(first: Float, second: Float, largest: int) -> Float:
    """Return r of the first with the second `lag` samples later, where both are known, for all lags to the largest."""
    count = len(first)
    a, b = first - first.mean(), second - second.mean()
    lags = np.arange(-largest, largest + 1)
    shared = count - np.abs(lags)
    products = scipy.signal.correlate(b, a)[count - 1 + lags]
    # Where the second is later, the end of the first has no partner, and the beginning of the second.
    starts = (np.maximum(-lags, 0), np.maximum(lags, 0))
    sums: list[Float] = []
    squares: list[Float] = []
    for values, start in zip((a, b), starts, strict=True):
        for power, found in ((1, sums), (2, squares)):
            total = np.concatenate([[0.0], np.cumsum(values**power)])
            found.append(total[start + shared] - total[start])
    spread = np.prod([square - part**2 / shared for square, part in zip(squares, sums, strict=True)], axis=0)
    together = products - sums[0] * sums[1] / shared
    return np.where(spread > 0, together / np.sqrt(np.where(spread > 0, spread, 1.0)), np.nan)


@dataclass(frozen=True)
class MultipleCorrelation:
    """How alike several curves are.

    Attributes
    ----------
    value : float
        0 to 1; NaN where it is undefined, which is not zero.
    rms, extent : float
        Root mean square distance of the curves from their mean, and the range of that mean, in the unit of the curves:
        what to say where the value is undefined, and beside it always.
    """

    value: float
    rms: float
    extent: float

    @property
    def is_defined(self) -> bool:
        """False where the curves differ more from each other than the movement goes."""
        return bool(np.isfinite(self.value))


def multiple_correlation(curves: Float) -> MultipleCorrelation:
    """Return the coefficient of multiple correlation of N curves of F phases, shape (N, F).

    Parameters
    ----------
    curves : ndarray, shape (N, F)
        At least two, without gaps.

    Returns
    -------
    MultipleCorrelation

    Raises
    ------
    ShapeError
        If there are fewer than two curves or phases, or gaps.

    Notes
    -----
    Kadaba et al. 1989, J Orthop Res 7:849: sqrt(1 - [sum (Y - Y_f)^2 / F(N-1)] / [sum (Y - Y)^2 / (NF-1)]). Where the
    radicand is negative it is undefined (Roislien et al. 2012, Gait Posture 36:98): sines 0.25 above and below their
    mean have 0.88255 for F = 100, 0.75 above and below have none.
    """
    if curves.ndim != 2 or min(curves.shape) < 2 or not np.isfinite(curves).all():
        raise ShapeError(f"curves of shape {curves.shape}; two or more of two or more phases, without gaps")
    count, phases = curves.shape
    mean = curves.mean(axis=0)
    apart = float(np.sum((curves - mean) ** 2))
    total = float(np.sum((curves - curves.mean()) ** 2)) / (count * phases - 1)
    radicand = 1.0 - apart / (phases * (count - 1)) / total if total > 0 else float("nan")
    return MultipleCorrelation(
        value=float(np.sqrt(radicand)) if radicand >= 0 else float("nan"),
        rms=float(np.sqrt(apart / curves.size)),
        extent=float(np.ptp(mean)),
    )


__all__ = ["Coordination", "MultipleCorrelation", "interjoint_coordination", "multiple_correlation"]
