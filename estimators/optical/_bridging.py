"""Samples that were interpolated over lost packets: how much less they tell than measured ones."""

import numpy as np
from numpy.typing import NDArray

from estimators.recording import Float

_AROUND_S = 1.0
_LEAST_SAMPLES = 20


def bridging_noise(
    values: Float, bridged: NDArray[np.bool_], sigma: float, time_step_s: float
) -> tuple[Float, int]:
    """Return how many times noisier than measured each sample is, and the number of bridges.

    Parameters
    ----------
    values : ndarray, shape (K, 3)
        Rates or forces; NaN where even a bridge was too long.
    bridged : ndarray of bool, shape (K,)
        Samples that were drawn straight between measured ones.
    sigma : float
        Noise of a measured sample.

    Returns
    -------
    noise : ndarray, shape (K,)
        1 where measured.
    count : int

    Notes
    -----
    What a straight line over g samples misses is measured on the recording itself: the measured samples within a second
    are compared with the line between those half a bridge to both sides. The errors of one bridge are alike, so that
    their sum grows with g, and not with its root: the variance of a sample counts g times.
    """
    noise = np.ones(len(values))
    edges = np.flatnonzero(np.diff(np.concatenate([[0], bridged.astype(np.int8), [0]]))).reshape(-1, 2)
    measured = np.isfinite(values).all(axis=1) & ~bridged
    around = round(_AROUND_S / time_step_s)
    whole: dict[int, float] = {}
    for start, stop in edges.tolist():
        half = (stop - start + 2) // 2
        missed = _missed(values, measured, half, slice(max(0, start - around), stop + around))
        if missed is None:
            if half not in whole:
                found = _missed(values, measured, half, slice(0, len(values)))
                # Nothing to learn from: the size of the signal itself.
                whole[half] = float(np.nanstd(values)) if found is None else found
            missed = whole[half]
        noise[start:stop] = np.sqrt(1.0 + (stop - start) * (missed / sigma) ** 2)
    return noise, len(edges)


def _missed(values: Float, measured: NDArray[np.bool_], half: int, part: slice) -> float | None:
    x, good = values[part], measured[part]
    if len(x) <= 2 * half:
        return None
    whole = good[half:-half] & good[: -2 * half] & good[2 * half :]
    if whole.sum() < _LEAST_SAMPLES:
        return None
    off = (x[half:-half] - 0.5 * (x[: -2 * half] + x[2 * half :]))[whole]
    return float(np.sqrt(np.mean(off**2)))
