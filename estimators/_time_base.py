"""Where common ticks fall between the samples of one sensor."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from estimators.recording import Float, SampleQuality

ON_THE_TICK = 0.05
"""A sensor whose samples all lie this close to ticks (in ticks) is even: it is taken as it is."""
_GAP_FACTOR = 1.5
"""Samples farther apart than this many usual intervals have lost something between them."""
_LEAST_SPACING = 0.5
"""Of a usual interval: samples that lie closer have a slope of noise, whatever divides it."""
_AVERAGING_FACTOR = 1.5
"""A sensor this much faster than the ticks is averaged over each tick instead of picked at it."""


class TimeBase:
    """Where the ticks fall between the samples of one sensor.

    Parameters
    ----------
    position : ndarray, shape (N,)
        Time of each sample in ticks from the first tick.
    bridge_ticks : float
        Longest missing stretch to interpolate across.
    """

    def __init__(self, position: Float, ticks: int, bridge_ticks: float, tick_s: float = 0.01) -> None:
        self._tick_s = tick_s
        nearest = np.rint(position)
        even = bool((np.abs(position - nearest) <= ON_THE_TICK).all() and (np.diff(nearest) > 0).all())
        self.position = nearest if even else position
        self.at = np.arange(ticks, dtype=np.float64)
        usual = float(np.median(np.diff(self.position))) if position.size > 1 else 1.0
        last = position.size - 1
        before = np.searchsorted(self.position, self.at, side="right") - 1
        self.before = np.clip(before, 0, last)
        self.after = np.minimum(self.before + 1, last)
        since = np.abs(self.at - self.position[self.before])
        until = np.abs(self.position[self.after] - self.at)
        self.on_sample = since == 0.0
        spacing = self.position[self.after] - self.position[self.before]
        gap = (spacing > _GAP_FACTOR * usual) & ~self.on_sample
        outside = (self.at < self.position[0] - ON_THE_TICK) | (self.at > self.position[-1] + ON_THE_TICK)
        self.missing = outside | (gap & (spacing - usual > bridge_ticks + 1e-6))
        # Half a usual interval from a sample is as near as any tick of an uneven sensor may be.
        self.bridged = gap & ~self.missing & (np.minimum(since, until) > 0.5 * usual)
        self.averaging = usual < 1.0 / _AVERAGING_FACTOR

    def take(self, values: Float, *, curved: bool = False) -> Float:
        """Return the values at the ticks, shape (K, 3), NaN where missing.

        Across a gap they follow the chord, or if `curved` a cubic (`bridge`).
        """
        if self.averaging:
            taken = _mean_over_ticks(self.position, values, self.at)
        else:
            taken = interpolate(self.position, values, self.at)
            taken[self.on_sample] = values[self.before[self.on_sample]]
            if curved and self.bridged.any():
                taken[self.bridged] = self._curve(values)
        taken[self.missing] = np.nan
        return taken

    def _curve(self, values: Float) -> Float:
        """Return the values at the bridged ticks, shape (bridged, 3), by the slopes of the samples outside."""
        left, right = self.before[self.bridged], self.after[self.bridged]
        last = self.position.size - 1
        earlier, later = np.maximum(left - 1, 0), np.minimum(right + 1, last)
        length = (self.position[right] - self.position[left])[:, None]
        usual = float(np.median(np.diff(self.position)))
        shortest, longest = _LEAST_SPACING * usual, _GAP_FACTOR * usual

        def slope(first: NDArray[np.intp], second: NDArray[np.intp]) -> Float:
            """Of the samples beside the gap, unless that is the end of the record, another gap, or they coincide."""
            apart = (self.position[second] - self.position[first])[:, None]
            known = (apart >= shortest) & (apart <= longest)
            return np.where(known, (values[second] - values[first]) / np.where(known, apart, 1.0), np.nan)

        share = (self.at[self.bridged][:, None] - self.position[left][:, None]) / length
        return bridge(
            values[left],
            slope(earlier, left),
            values[right],
            slope(right, later),
            length,
            share,
            self._tick_s * length,
        )

    def quality(self, clipped: NDArray[np.bool_]) -> NDArray[np.uint8]:
        """Return `SampleQuality` bits per tick, given which samples were at their clip level."""
        touched = clipped[self.before] | (clipped[self.after] & ~self.on_sample)
        if self.averaging:
            averaged = np.rint(self.position[clipped]).astype(np.intp)
            touched[averaged[averaged < touched.size]] = True
        quality = np.where(touched & ~self.missing, int(SampleQuality.SATURATED), 0)
        quality |= np.where(self.bridged, int(SampleQuality.BRIDGED), 0)
        quality |= np.where(self.missing, int(SampleQuality.MISSING), 0)
        return quality.astype(np.uint8)


def _mean_over_ticks(position: Float, values: Float, at: Float) -> Float:
    """Return the mean of the line through the samples over `[at - 1/2, at + 1/2]`, shape (K, 3)."""
    steps = np.diff(position)[:, None]
    areas = np.concatenate((np.zeros((1, values.shape[1])), 0.5 * (values[1:] + values[:-1]) * steps))
    integral = np.cumsum(areas, axis=0)

    def integrated(to: Float) -> Float:
        i = np.clip(np.searchsorted(position, to, side="right") - 1, 0, position.size - 2)
        ahead = (to - position[i])[:, None]
        slope = (values[i + 1] - values[i]) / (position[i + 1] - position[i])[:, None]
        return np.asarray(integral[i] + ahead * (values[i] + 0.5 * slope * ahead))

    start = np.clip(at - 0.5, position[0], position[-1])
    stop = np.clip(at + 0.5, position[0], position[-1])
    width = np.maximum(stop - start, 1e-12)[:, None]
    return np.asarray((integrated(stop) - integrated(start)) / width)


def bridge(
    start: Float,
    start_slope: Float,
    end: Float,
    end_slope: Float,
    length: ArrayLike,
    share: ArrayLike,
    length_s: ArrayLike,
) -> Float:
    """Return the cubic Hermite curve between two samples at `share` of the `length` between them.

    Parameters
    ----------
    start, end : ndarray
        The samples on both sides of a gap.
    start_slope, end_slope : ndarray
        Change per unit of `length` of the samples before `start` and after `end`; NaN: unknown, as the chord's.
    length, share, length_s : array_like
        Length of the gap in that unit, places in it from 0 to 1, and its length in seconds.

    Notes
    -----
    On recordings of arm-like movement the cubic leaves a third of the chord's attitude error over 50 ms, two
    thirds over 0.1 s, and more than the chord from 0.15 s on, where the slopes tell nothing any more: between
    0.05 and 0.15 s they give way to the chord's.
    """
    t, ticks = np.asarray(share, dtype=np.float64), np.asarray(length, dtype=np.float64)
    chord = (end - start) / ticks
    trust = np.clip(1.5 - np.asarray(length_s, dtype=np.float64) / 0.1, 0.0, 1.0)
    first = np.where(np.isfinite(start_slope), chord + trust * (start_slope - chord), chord)
    second = np.where(np.isfinite(end_slope), chord + trust * (end_slope - chord), chord)
    late = t * t * (3.0 - 2.0 * t)
    reach = t * (1.0 - t) * ticks
    return np.asarray(start + late * (end - start) + reach * ((1.0 - t) * first - t * second))


def interpolate(time_s: ArrayLike, values: ArrayLike, new_time_s: ArrayLike) -> Float:
    """Interpolate linearly, shape (N, C) to (K, C); the ends are held beyond the first and last sample."""
    time, table = np.asarray(time_s, dtype=np.float64), np.asarray(values, dtype=np.float64)
    at = np.asarray(new_time_s, dtype=np.float64)
    return np.stack([np.interp(at, time, column) for column in table.T], axis=-1)
