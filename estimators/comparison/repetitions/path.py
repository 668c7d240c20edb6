"""A movement as a path: walked in steps of one length, so that rest, holds and pace vanish."""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Final

import numpy as np
import scipy

from estimators.comparison.repetitions.cycles_kernel import turning_points, walk
from estimators.recording import Float

_FINE, _COARSE = 0.07, 0.15
"""Shares of the movement's size between two points of the path: as fine as the calm parts are calm."""
_CALM_S: Final = 0.3
_NO_CALM: Final = 0.25
"""Share of the size: where nothing is calmer than this, nobody ever rests."""
_DIMENSIONS: Final = 5
_SLOWER: Final = 3.0
"""Times as long as usual: what is slower is a stay, what is not is on the way."""


@dataclass(frozen=True)
class Path:
    """A movement in steps of one length.

    Attributes
    ----------
    points : ndarray, shape (M, D)
    place : ndarray, shape (M,)
        Sample at which each was reached.
    last : float
        The last sample.
    size : float
        How far the movement goes, in units of the posture.
    summed : ndarray, shape (N + 1, D)
        Sum of the postures before each sample, in the coordinates of the points.
    """

    points: Float
    place: Float
    last: float
    size: float
    summed: Float

    @cached_property
    def stay(self) -> Float:
        """Samples spent at each point, shape (M,)."""
        return np.diff(self.place, append=self.last)

    @cached_property
    def usual_stay(self) -> float:
        """Samples that a step of the path usually takes."""
        return float(np.median(self.stay))

    @property
    def slow(self) -> float:
        """Samples from which on a step of the path is a stay, not on the way."""
        return _SLOWER * self.usual_stay

    def is_stay(self, first: int, last: int) -> bool:
        """Whether somebody stays anywhere between two points."""
        return bool(self.stay[first : last + 1].max() >= self.slow)


def smoothed(values: Float, step_s: float) -> tuple[Float, float]:
    """Smooth a posture no more than its own pace allows.

    Parameters
    ----------
    values : ndarray, shape (N, D)
        Without gaps.

    Returns
    -------
    values : ndarray, shape (N, D)
    smoothing_s : float
        Standard deviation of the smoothing: of slow movements a tremor vanishes, of fast ones nothing may.
    """
    centred = values - np.median(values, axis=0)
    _, _, axes = np.linalg.svd(centred[:: max(1, len(centred) // 2000)], full_matrices=False)
    main = scipy.ndimage.gaussian_filter1d(centred @ axes[0], 0.03 / step_s)
    smoothing_s = float(np.clip(0.35 * _rise_s(main, step_s), 0.02, 0.10))
    return scipy.ndimage.gaussian_filter1d(values, smoothing_s / step_s, axis=0, mode="nearest"), smoothing_s


def _rise_s(signal: Float, step_s: float) -> float:
    """How long the signal usually takes for the middle three fifths of its way from one turn to the next."""
    low, high = np.percentile(signal, (3, 97))
    reversal = 0.35 * (high - low)
    turns = turning_points(np.ascontiguousarray(signal), reversal).tolist()
    rises = []
    for a, b in pairwise(turns):
        if b > a:
            share = (signal[a : b + 1] - signal[a]) / (signal[b] - signal[a] or 1.0)
            rises.append(((share > 0.2) & (share < 0.8)).sum() * step_s)
    return float(np.median(rises)) if rises else 0.1


def path_of(values: Float, step_s: float) -> Path | None:
    """Walk a smoothed movement; None where nothing moves.

    Parameters
    ----------
    values : ndarray, shape (N, D)
    """
    speed = np.linalg.norm(np.diff(values, axis=0), axis=1)
    if speed.sum() <= 0:
        return None
    # Weighted by the way done: how long somebody rests has no say in how far the movement goes.
    centre = (values[1:] * speed[:, None]).sum(axis=0) / speed.sum()
    away = np.linalg.norm(values[1:] - centre, axis=1)
    order = np.argsort(away)
    size = 2.0 * float(away[order][np.searchsorted(np.cumsum(speed[order]), 0.6 * speed.sum())])
    offset = values - centre
    if offset.shape[1] > 1:
        _, spread, axes = np.linalg.svd(offset * np.sqrt(np.append(speed, 0.0))[:, None], full_matrices=False)
        used = np.flatnonzero(np.cumsum(spread**2) <= 0.995 * (spread**2).sum())[: _DIMENSIONS - 1]
        offset = offset @ axes[: len(used) + 1].T
    points, place = walk(np.ascontiguousarray(offset), _step(offset, size, step_s))
    if len(points) <= 3:
        return None
    summed = np.concatenate([np.zeros((1, offset.shape[1])), np.cumsum(offset, axis=0)])
    return Path(points, place, len(values) - 1.0, size, summed)


def _step(offset: Float, size: float, step_s: float) -> float:
    """Distance of successive points: beyond what a tremor does while somebody rests."""
    window = max(3, round(_CALM_S / step_s))
    reach = scipy.ndimage.maximum_filter1d(offset, window, axis=0) - scipy.ndimage.minimum_filter1d(
        offset, window, axis=0
    )
    calm = float(np.percentile(np.linalg.norm(reach, axis=1), 10)) / size
    return size * (float(np.clip(1.1 * calm, _FINE, _COARSE)) if calm < _NO_CALM else _FINE)
