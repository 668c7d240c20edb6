"""Signals of cameras and modules on common ground: even grids, equal windows, correlation over what both have."""

import numpy as np
import scipy
from numpy.typing import NDArray

from estimators.errors import ComparisonError, ShapeError
from estimators.recording import Float
from estimators.sentences import say

HALF_WIDTH_S = 0.05
"""Half the window through which accelerations are compared."""
_GHOST_M = 0.03


def triangle(values: Float, reach: int) -> Float:
    """See the columns of values, shape (K, C), through a triangle of +-reach samples; its ends are not whole."""
    weights = 1.0 - np.abs(np.arange(-reach, reach + 1)) / reach
    weights /= weights.sum()
    return np.column_stack([np.convolve(column, weights, mode="same") for column in values.T])


def step_of(time_s: Float, values: Float, what: str) -> float:
    if time_s.ndim != 1 or values.shape != (len(time_s), 3):
        raise ShapeError(f"{what} need shape (N, 3) with N times, not {values.shape} and {time_s.shape}")
    if len(time_s) < 10 or not np.isfinite(time_s).all() or not (np.diff(time_s) > 0.0).all():
        raise ComparisonError(say("markers.uneven"))
    return float(np.median(np.diff(time_s)))


def evenly(time_s: Float, values: Float, step_s: float) -> tuple[Float, Float]:
    """Put values on an even grid; NaN where frames are lost. Nothing is drawn across a gap."""
    grid = time_s[0] + np.arange(int((time_s[-1] - time_s[0]) / step_s + 1.5)) * step_s
    return grid, np.column_stack([linear(time_s, column, grid, 1.6 * step_s) for column in values.T])


def linear(time_s: Float, values: Float, at_s: Float, longest_s: float) -> Float:
    right = np.clip(np.searchsorted(time_s, at_s), 1, len(time_s) - 1)
    apart = time_s[right] - time_s[right - 1]
    part = (at_s - time_s[right - 1]) / apart
    # A sample that is met exactly does not need its neighbour.
    early, late = values[right - 1], values[right]
    found = np.where(part < 1e-6, early, np.where(part > 1 - 1e-6, late, (1.0 - part) * early + part * late))
    return np.asarray(
        np.where((apart > longest_s) | (part < -1e-6) | (part > 1 + 1e-6), np.nan, found), dtype=np.float64
    )


def correlations(a: Float, b: Float, least: int) -> tuple[Float, NDArray[np.int64], Float]:
    """Correlate a[i + lag] with b[i] over what both have, for every lag; NaN where that is too little."""
    size = scipy.fft.next_fast_len(len(a) + len(b))
    masks = [np.isfinite(x).astype(np.float64) for x in (a, b)]
    filled = [np.where(m > 0, x, 0.0) - m * np.nanmean(x) for x, m in zip((a, b), masks, strict=True)]

    def product(x: Float, y: Float) -> Float:
        return np.asarray(scipy.fft.irfft(scipy.fft.rfft(x, size) * np.conj(scipy.fft.rfft(y, size)), size))

    count = np.round(product(masks[0], masks[1]))
    usable = count >= max(least, 10)
    many = np.where(usable, count, 1.0)
    mean_a, mean_b = product(filled[0], masks[1]) / many, product(masks[0], filled[1]) / many
    var_a = product(filled[0] ** 2, masks[1]) / many - mean_a**2
    var_b = product(masks[0], filled[1] ** 2) / many - mean_b**2
    floor = 1e-4 * min(np.nanvar(a), np.nanvar(b))
    usable &= (var_a > floor) & (var_b > floor) & (floor > 0.0)
    below = np.sqrt(np.where(usable, var_a * var_b, 1.0))
    score = np.where(usable, (product(filled[0], filled[1]) / many - mean_a * mean_b) / below, np.nan)
    lags = np.arange(size, dtype=np.int64)
    lags[lags >= len(a)] -= size
    return score, lags, count


def without_ghosts(marker_m: Float) -> Float:
    """Hide frames that are far from the middle of the five around them: one would outweigh a second of movement."""
    present = np.flatnonzero(np.isfinite(marker_m).all(axis=1))
    if len(present) < 5:
        return marker_m
    seen = marker_m[present]
    around = np.lib.stride_tricks.sliding_window_view(seen, 5, axis=0)
    far = np.zeros(len(seen), dtype=np.bool_)
    far[2:-2] = np.linalg.norm(seen[2:-2] - np.median(around, axis=-1), axis=1) > _GHOST_M
    cleaned = marker_m.copy()
    cleaned[present[far]] = np.nan
    return cleaned


def repetition(residual: Float) -> float:
    """Return how many samples of a residual count as one: one plus twice its positive early correlation."""
    r = residual - residual.mean()
    size = scipy.fft.next_fast_len(2 * len(r))
    spectrum = np.abs(scipy.fft.rfft(r, size)) ** 2
    rho = np.asarray(scipy.fft.irfft(spectrum, size))[: max(2, len(r) // 4)]
    if not rho[0] > 0.0:
        return 1.0
    rho = rho / rho[0]
    negative = np.flatnonzero(rho < 0.05)
    stop = int(negative[0]) if len(negative) else len(rho)
    return float(1.0 + 2.0 * rho[1:stop].sum())
