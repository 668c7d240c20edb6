"""Alignment in time: dynamic time warping with a band, timing and shape apart.

The warp says *when* the patient did what the template does (timing); what is left after it is *how*
(shape). Sakoe and Chiba 1978, symmetric form P = 0: the weight of a step is the number of samples it
advances in both series, so the cost is symmetric and comes out per sample.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.compiling import compiled
from estimators.errors import ShapeError
from estimators.recording import Float

BAND = 0.20
"""Half width of the Sakoe-Chiba band as a share of the series. The method page proposes 10 percent, which
holds for healthy movers; a hesitation of a quarter of the movement, common after stroke, would then be
counted as wrong shape, so timing and shape would no longer be apart."""

STRAY_PENALTY = 0.002
"""Cost, in squared units of the scale, of walking at the edge of the band: only decides where the series are
so flat that the data cannot, as in a rest, and keeps the warp there on the diagonal."""


@dataclass(frozen=True)
class Alignment:
    """How one series follows another.

    Attributes
    ----------
    rms : float
        Root mean square difference per channel after warping, in units of the scale.
    first_index, second_index : ndarray of int, shape (L,)
        The warping path, from (0, 0) to the two ends.
    warp : ndarray, shape (N,)
        For each sample of the first series the matching position in the second, 0 to M - 1; never
        decreases.
    """

    rms: float
    first_index: NDArray[np.int64]
    second_index: NDArray[np.int64]
    warp: Float

    @property
    def timing_deviation(self) -> float:
        """Mean distance of the warp from constant pace, as a share of the series."""
        samples = len(self.warp)
        if samples < 2:
            return 0.0
        pace = np.linspace(0.0, self.warp[-1], samples)
        return float(np.mean(np.abs(self.warp - pace)) / max(self.warp[-1], 1.0))


def local_cost_numpy(first: Float, second: Float) -> Float:
    """Mean squared difference over the channels that both samples have, shape (N, M); zero if none."""
    difference = first[:, None, :] - second[None, :, :]
    both = np.isfinite(difference)
    count = both.sum(axis=2)
    total = np.where(both, difference, 0.0)
    return np.asarray((total * total).sum(axis=2) / np.maximum(count, 1))


def accumulate_numpy(cost: Float, band: int, stray: float) -> Float:
    """Numpy twin of `accumulate`: the test oracle."""
    rows, columns = cost.shape
    total = np.full((rows, columns), np.inf)
    for i in range(rows):
        centre = i * (columns - 1) / max(rows - 1, 1)
        for j in range(columns):
            offset = abs(j - centre)
            if offset > band:
                continue
            here = cost[i, j] + stray * (offset / band) ** 2
            if i == 0 and j == 0:
                total[i, j] = 2.0 * here
                continue
            options = [
                total[i - 1, j - 1] + 2.0 * here if i and j else np.inf,
                total[i - 1, j] + here if i else np.inf,
                total[i, j - 1] + here if j else np.inf,
            ]
            total[i, j] = min(options)
    return total


@compiled("float64[:,::1](float64[:,::1], float64[:,::1])", error_model="python")
def local_cost(first: Float, second: Float) -> Float:  # pragma: no cover
    """Mean squared difference over the channels that both samples have, shape (N, M); zero if none."""
    rows, columns, channels = first.shape[0], second.shape[0], first.shape[1]
    cost = np.empty((rows, columns))
    for i in range(rows):
        for j in range(columns):
            total = 0.0
            count = 0
            for c in range(channels):
                difference = first[i, c] - second[j, c]
                if np.isfinite(difference):
                    total += difference * difference
                    count += 1
            cost[i, j] = total / count if count > 0 else 0.0
    return cost


@compiled("float64[:,::1](float64[:,::1], int64, float64)", error_model="python")
def accumulate(cost: Float, band: int, stray: float) -> Float:  # pragma: no cover
    """Accumulate the symmetric warping cost inside the band; infinite outside."""
    rows, columns = cost.shape
    total = np.full((rows, columns), np.inf)
    slope = (columns - 1) / max(rows - 1, 1)
    for i in range(rows):
        centre = i * slope
        low = max(0, int(np.ceil(centre - band)))
        high = min(columns - 1, int(np.floor(centre + band)))
        for j in range(low, high + 1):
            offset = abs(j - centre) / band
            here = cost[i, j] + stray * offset * offset
            if i == 0 and j == 0:
                total[i, j] = 2.0 * here
                continue
            best = np.inf
            if i > 0 and j > 0:
                best = total[i - 1, j - 1] + 2.0 * here
            if i > 0:
                best = min(best, total[i - 1, j] + here)
            if j > 0:
                best = min(best, total[i, j - 1] + here)
            total[i, j] = best
    return total


@compiled("Tuple((int64[::1], int64[::1]))(float64[:,::1])", error_model="python")
def backtrack(total: Float) -> tuple[NDArray[np.int64], NDArray[np.int64]]:  # pragma: no cover
    """Walk the cheapest path back; a tie goes to the diagonal.

    Parameters
    ----------
    total : ndarray, shape (N, M)
        From `accumulate`.

    Returns
    -------
    first, second : ndarray of int, shape (L,)
        The path from (0, 0) to the two ends.
    """
    i, j = total.shape[0] - 1, total.shape[1] - 1
    first = np.empty(i + j + 1, dtype=np.int64)
    second = np.empty(i + j + 1, dtype=np.int64)
    at = i + j
    first[at], second[at] = i, j
    while i > 0 or j > 0:
        diagonal = total[i - 1, j - 1] if i > 0 and j > 0 else np.inf
        up = total[i - 1, j] if i > 0 else np.inf
        left = total[i, j - 1] if j > 0 else np.inf
        # At an edge nothing else leads on, whatever the cost of the way.
        if i > 0 and j > 0 and diagonal <= up and diagonal <= left:
            i, j = i - 1, j - 1
        elif j == 0 or (i > 0 and up <= left):
            i -= 1
        else:
            j -= 1
        at -= 1
        first[at], second[at] = i, j
    return first[at:].copy(), second[at:].copy()


def align(first: Float, second: Float, scale: Float, band: float = BAND) -> Alignment:
    """Warp the first series onto the second.

    Parameters
    ----------
    first : ndarray, shape (N, C)
        NaN where a channel is unknown; such a channel does not count at that pair of samples.
    second : ndarray, shape (M, C)
    scale : ndarray, shape (C,)
        One unit of difference per channel, for instance the tolerance; NaN leaves a channel out.
    band : float
        Half width of the band as a share of the second series.

    Raises
    ------
    ShapeError
        If the channels differ or a series has fewer than two samples.
    """
    if (
        first.ndim != 2
        or second.ndim != 2
        or first.shape[1:] != second.shape[1:]
        or scale.shape != first.shape[1:]
    ):
        raise ShapeError(
            f"cannot align {first.shape} with {second.shape} in units {scale.shape}: channels differ"
        )
    if first.shape[0] < 2 or second.shape[0] < 2:
        raise ShapeError("each series needs at least two samples to be aligned")
    used = np.isfinite(scale) & (scale > 0)
    cost = local_cost(
        np.ascontiguousarray(first[:, used] / scale[used]),
        np.ascontiguousarray(second[:, used] / scale[used]),
    )
    width = max(2, round(band * second.shape[0]))
    first_index, second_index = backtrack(accumulate(cost, width, STRAY_PENALTY))
    return Alignment(
        rms=_path_rms(cost, first_index, second_index),
        first_index=first_index,
        second_index=second_index,
        warp=_warp(first_index, second_index, first.shape[0]),
    )


def _path_rms(cost: Float, first_index: NDArray[np.int64], second_index: NDArray[np.int64]) -> float:
    """Symmetric per-sample cost of a path, as a root."""
    weight = np.ones(len(first_index))
    weight[1:] = np.diff(first_index) + np.diff(second_index)
    weight[0] = 2.0
    return float(np.sqrt(np.sum(weight * cost[first_index, second_index]) / weight.sum()))


def _warp(from_index: NDArray[np.int64], to_index: NDArray[np.int64], samples: int) -> Float:
    """Mean matched position for each sample: a staircase made into a function that never decreases."""
    count = np.bincount(from_index, minlength=samples)
    mean = np.bincount(from_index, weights=to_index.astype(np.float64), minlength=samples) / count
    mean[0], mean[-1] = to_index[0], to_index[-1]
    return np.asarray(mean)


def apply(alignment: Alignment, first: Float, samples: int) -> Float:
    """Bring the first series onto the time of the second.

    Parameters
    ----------
    first : ndarray, shape (N, C)
    samples : int
        Length M of the second series.

    Returns
    -------
    ndarray, shape (M, C)
        The first series at the positions matched with each sample of the second; NaN stays NaN.
    """
    back = _warp(alignment.second_index, alignment.first_index, samples)
    low = np.floor(back).astype(int)
    high = np.minimum(low + 1, first.shape[0] - 1)
    share = (back - low)[:, None]
    # A share of zero must not let a NaN neighbour in.
    blended = first[low] * (1 - share) + first[high] * share
    return np.asarray(np.where(share > 0, blended, first[low]))


def resample(time_s: Float, values: Float, samples: int) -> Float:
    """Resample evenly from the first to the last time; gaps stay NaN.

    Parameters
    ----------
    time_s : ndarray, shape (N,)
    values : ndarray, shape (N, C)

    Returns
    -------
    ndarray, shape (samples, C)
    """
    if len(time_s) < 2:
        raise ShapeError("a repetition of fewer than two samples cannot be resampled")
    target = np.linspace(time_s[0], time_s[-1], samples)
    right = np.clip(np.searchsorted(time_s, target, side="left"), 1, len(time_s) - 1)
    left = right - 1
    share = ((target - time_s[left]) / (time_s[right] - time_s[left]))[:, None]
    blended = values[left] * (1 - share) + values[right] * share
    return np.asarray(np.where(share <= 0, values[left], np.where(share >= 1, values[right], blended)))
