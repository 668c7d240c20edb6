"""How joints go together, and how alike repetitions are."""

from dataclasses import dataclass
from typing import Final

import numpy as np
import scipy
from numpy.typing import NDArray

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
    return interjoint_coordinations(first_rad[None], second_rad[None], rate_hz, floor_rad)[0]


def interjoint_coordinations(
    first_rad: Float, second_rad: Float, rate_hz: float, floor_rad: float
) -> list[Coordination | None]:
    """Return `interjoint_coordination` of several pairs of joints over the same ticks.

    Parameters
    ----------
    first_rad, second_rad : ndarray, shape (S, N)
        A pair a row.
    floor_rad : float
        As of `interjoint_coordination`.
    """
    samples = first_rad.shape[1]
    if samples < 8:
        return [None] * len(first_rad)
    is_known = np.isfinite(first_rad).all(axis=1) & np.isfinite(second_rad).all(axis=1)
    moves = np.minimum(np.ptp(first_rad, axis=1), np.ptp(second_rad, axis=1)) >= floor_rad
    used = np.flatnonzero(is_known & moves)
    largest = int(_LARGEST_LAG * samples)
    found: list[Coordination | None] = [None] * len(first_rad)
    for place, at_lags in zip(
        used.tolist(), _at_lags(first_rad[used], second_rad[used], largest), strict=True
    ):
        correlation = float(at_lags[largest])
        lag = int(np.nanargmax(at_lags)) - largest
        found[place] = Coordination(correlation, lag / rate_hz, 0.5 * (1.0 + abs(correlation)))
    return found


def _at_lags(first: Float, second: Float, largest: int) -> Float:
    """Return r of the first with the second `lag` samples later, where both are known, for all lags to the largest.

    Of pairs of shape (S, N) each, shape (S, 2 largest + 1).
    """
    count = first.shape[1]
    lags = np.arange(-largest, largest + 1)
    shared = count - np.abs(lags)
    # Where the second is later, the end of the first has no partner, and the beginning of the second.
    starts = np.stack([np.maximum(-lags, 0), np.maximum(lags, 0)])
    both = np.stack([first, second])
    both = both - both.mean(axis=2, keepdims=True)
    products = np.array(
        [
            scipy.signal.correlate(b, a)[count - 1 - largest : count + largest]
            for a, b in zip(*both, strict=True)
        ]
    ).reshape(-1, len(lags))
    sums, squares = (_over(values, starts, shared) for values in (both, both**2))
    spread = np.prod(squares - sums**2 / shared, axis=0)
    together = products - sums[0] * sums[1] / shared
    return np.where(spread > 0, together / np.sqrt(np.where(spread > 0, spread, 1.0)), np.nan)


def _over(values: Float, starts: NDArray[np.intp], counts: NDArray[np.intp]) -> Float:
    """Return sums of so many values of both joints, shape (2, S, N), from so many starts of each, shape (2, L)."""
    total = np.zeros((*values.shape[:2], values.shape[2] + 1))
    np.cumsum(values, axis=2, out=total[:, :, 1:])
    return np.stack(
        [own[:, start + counts] - own[:, start] for own, start in zip(total, starts, strict=True)]
    )


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
