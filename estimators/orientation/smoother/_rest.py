"""Rests of a whole session: how much each tells of the gyroscope's bias."""

import math

import numpy as np
from numpy.typing import NDArray

from estimators.orientation.telemotion import _records as at
from estimators.recording import Float

_SWAY_RADPS, _UNSEEN_S = math.radians(0.5), 0.75
"""How far a person's sway is taken to move the mean rate of half a second, as if seen for so long."""
_HALF_SECOND = 0.5
_MOST_DOUBT = 1000.0


class Rests:
    """Blocks at rest.

    A person's rest is none of the device's. Standing sways to and fro, which averages out: what the mean rate
    of half a second sways about that of `rest_sure_s` widens it. An arm held up sinks, which does not average
    out, but contradicts the bias that the rest of the session shows: such a rest is doubted.

    Parameters
    ----------
    facts : ndarray of FACTS, shape (B,)
        Rest and mean raw rate of the blocks.
    """

    def __init__(self, facts: NDArray[np.void], settings: np.void) -> None:
        self._settings = settings
        self._block_s = settings["block_ticks"] * settings["step_s"]
        at_rest = facts["is_at_rest"] > 0
        edges = np.flatnonzero(np.diff(np.concatenate(([False], at_rest, [False])).astype(np.int8)))
        runs = edges.reshape(-1, 2)
        self._mean = np.zeros((len(facts), 3))
        squares = np.zeros(len(facts))
        short = max(1, round(_HALF_SECOND / self._block_s))
        long = max(short, round(settings["rest_sure_s"] / self._block_s))
        for begin, end in runs:
            rate = facts["rate"][begin:end]
            self._mean[begin:end] = _running_mean(rate, long)
            squares[begin:end] = ((_running_mean(rate, short) - self._mean[begin:end]) ** 2).sum(axis=1)
        self._variance = np.full(len(facts), np.inf)
        sway = _both_ways(squares[at_rest], self._block_s, settings["rest_sure_s"])
        stated = settings["rest_bias"] + settings["rest_sway_s"] * sway
        self._variance[at_rest] = stated / self._block_s

    def variance(self, bias_radps: Float, known_variance: Float) -> Float:
        """Return the variance of each block's mean rate as a measurement of the bias, (rad/s)^2.

        Parameters
        ----------
        bias_radps : ndarray, shape (B, 3)
            What the pass before found.
        known_variance : ndarray, shape (B,)
            Of that, its three components together; infinite at first.
        """
        off = ((self._mean - bias_radps) ** 2).sum(axis=1)
        doubt = (off / (self._settings["rest_surprise"] + known_variance)) ** 2
        return np.asarray(self._variance * (1.0 + np.minimum(doubt, _MOST_DOUBT)))

    def known(self, covariances: Float, final: Float) -> Float:
        """Return how well each block's bias is known at least: the variance from what came before, or from all.

        `final` is the covariance after the last block; until then the bias drifts.
        """
        columns = (at.STATES + 1) * (at.BIAS + np.arange(3))
        before = covariances[:, columns].sum(axis=1)
        left_s = self._block_s * np.arange(len(before))[::-1]
        after = final[columns].sum() + 3.0 * self._settings["bias_drift"] * left_s
        return np.asarray(np.minimum(before, after))


def _running_mean(rate: Float, width: int) -> Float:
    """Return the mean of `width` neighbours, fewer at the ends."""
    sums = np.vstack((np.zeros(3), np.cumsum(rate, axis=0)))
    places = np.arange(len(rate))
    low = np.maximum(places - width // 2, 0)
    high = np.minimum(places + (width + 1) // 2, len(rate))
    return np.asarray((sums[high] - sums[low]) / (high - low)[:, None])


def _both_ways(squares: Float, step_s: float, time_constant_s: float) -> Float:
    """Return the mean square near each block, both ways, from what all of them show."""
    gain = min(step_s / time_constant_s, 1.0)
    whole = (_UNSEEN_S * _SWAY_RADPS**2 + step_s * float(squares.sum())) / (_UNSEEN_S + step_s * len(squares))
    total = np.zeros(len(squares))
    for order in (slice(None), slice(None, None, -1)):
        level, out = whole, np.empty(len(squares))
        for i, value in enumerate(squares[order]):
            level += gain * (value - level)
            out[i] = level
        total += 0.5 * out[order]
    return total
