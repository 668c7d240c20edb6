"""Channels that stop at the end of their range, known by how values pile up there."""

import math
from dataclasses import replace
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from estimators.conventions import GRAVITY_MPS2
from estimators.recording import Float, ImuChunk, SampleQuality

LEAST_RATE_RANGE_RADPS: Final = math.radians(30.0)
LEAST_FORCE_RANGE_MPS2: Final = 1.5 * GRAVITY_MPS2
"""No device has a smaller range: peaks below it are peaks."""
_STRETCH_TICKS: Final = 10_000

_TOP: Final = 0.995
"""Values this near the largest count as one level: calibration turns and scales what a device cut off, so that its
levels differ by some thousandths from sample to sample."""
_MARKED: Final = 0.99
"""From here on a sample is taken for cut off once a level is known."""
_BELOW: Final = 0.97
"""Down to here values thin out toward a peak that is not cut off."""
_BANDS: Final = (_TOP - _BELOW) / (1.0 - _TOP)
_COARSE: Final = 1e-6
"""Of the largest: values that differ by less are one number of a device."""
_TIMES: Final = 6.0
"""So many times what the bands below hold is no peak: at the top of a swing it is three and a half times."""
_FEWEST: Final = 8
_SAME_RANGE: Final = 0.9
"""All axes of a device have one range but for their calibration: where one reaches beyond, no other is cut off."""
_SHORT: Final = 3
"""Samples: a soft peak that stays at the top for longer thins out below it, which is counted."""
_FEWEST_PEAKS: Final = 4
_REPEATS: Final = 0.02
"""Of the largest: a machine repeats what stands beside its peaks to so much; beside what a device cuts off of the
movement of a person it is different each time."""
_FLAT: Final = 0.1
"""Of the way down beside a peak of three samples: a soft one rises by a third of it in its middle."""
_LONGEST_RAD: Final = 2.0 * np.pi
_LONGEST_S: Final = 0.5
"""A limb cannot turn round and round, nor be pushed that hard for so long: a steady turn, or a device at rest."""
_MOST: Final = 2_000


class ClipWatch:
    """Finds the levels at which the axes of one device are cut off; feed it the whole recording, stretch by stretch.

    Parameters
    ----------
    least : float
        No device of this kind has a smaller range: peaks below it are peaks.
    is_rate : bool
        A gyroscope, rad/s; otherwise an accelerometer.
    known : ndarray, shape (2, 3), optional
        `levels` found in what came before; each holds until a larger value shows that it was none.
    """

    def __init__(self, least: float, *, is_rate: bool, known: Float | None = None) -> None:
        self._least, self._is_rate = least, is_rate
        self._known = np.full(6, np.inf) if known is None else np.array(known, dtype=np.float64).reshape(6)
        self._tops = np.where(np.isfinite(self._known), self._known / _MARKED, 0.0)
        self._values: list[Float] = [np.empty(0) for _ in range(6)]
        self._steps = np.full(6, np.inf)
        """Between two numbers that a channel can give, as far as it was seen."""
        self._peaks: list[Float] = [np.empty((0, 5)) for _ in range(6)]
        """Of each channel its peaks, see `_peaks`."""

    def add(self, values: Float, time_step_s: float) -> None:
        """Take a stretch, shape (N, 3); NaN where a sample is missing. Rows that only repeat the one before are one."""
        sound = np.array(np.isfinite(values).all(axis=1))
        whole = np.flatnonzero(sound)
        sound[1:] &= np.asarray(values[1:] != values[:-1]).any(axis=1)
        at = np.flatnonzero(sound)
        # Where most rows stand more than once a sample is all of its rows.
        peaked = at if 2 * np.count_nonzero(np.diff(at) > 1) > at.size else whole
        for channel in range(6):
            column = (1.0 if channel < 3 else -1.0) * values[:, channel % 3]
            top = float(column[at].max(initial=0.0))
            if top < max(self._least, _BELOW * float(self._tops[channel])):
                continue
            self._tops[channel] = top = max(top, float(self._tops[channel]))
            gaps = np.diff(np.unique(column[at]))
            self._steps[channel] = gaps[gaps > _COARSE * top].min(initial=self._steps[channel])
            edge, floor = self._bands(channel)
            chosen = at[column[at] >= floor]
            chosen = chosen[~self._lasting(column, top, time_step_s)[chosen]]
            retained = np.concatenate((self._values[channel], column[chosen]))
            self._values[channel] = retained[retained >= floor][:_MOST]
            peaks = np.concatenate((self._peaks[channel], _peaks(column[peaked], edge)))
            self._peaks[channel] = peaks[peaks[:, 0] >= edge][:_MOST]

    def _bands(self, channel: int) -> tuple[float, float]:
        """Return from where on values are at the top, and down to where those below it are counted.

        Of a device with few numbers the top is the highest of them, and a band each of the others.
        """
        top, step = float(self._tops[channel]), float(self._steps[channel])
        if step <= (1.0 - _TOP) * top or not math.isfinite(step):
            return _TOP * top, _BELOW * top
        return top - 0.5 * step, top - (0.5 + _BANDS) * step

    def _lasting(self, column: Float, top: float, step_s: float) -> NDArray[np.bool_]:
        """Return which samples lie in a run at the top that lasts longer than a limb can."""
        is_top = np.concatenate(([False], column >= _TOP * top, [False]))
        edges = np.flatnonzero(np.diff(is_top.astype(np.int8)))
        long = np.zeros(len(column), dtype=np.bool_)
        for start, stop in zip(edges[::2], edges[1::2], strict=True):
            lasts_s = (stop - start) * step_s
            if lasts_s * top > _LONGEST_RAD if self._is_rate else lasts_s > _LONGEST_S:
                long[start:stop] = True
        return long

    @property
    def largest(self) -> float:
        """The largest magnitude of an axis so far."""
        return float(self._tops.max())

    @property
    def level(self) -> float | None:
        """The lowest level at which an axis is cut off; None if none is."""
        lowest = float(self.levels.min())
        return lowest / _MARKED if np.isfinite(lowest) else None

    @property
    def levels(self) -> Float:
        """Levels from which an axis is cut off, shape (2, 3), for its positive and negative side; infinite if not."""
        tops = self._tops
        holds = (_TOP * tops <= self._known / _MARKED) & (tops >= _SAME_RANGE * tops.max())
        levels = np.where(holds, self._known, np.inf)
        known = np.where(holds & np.isfinite(self._known), self._known, 0.0)
        for channel, values in enumerate(self._values):
            top = float(values.max(initial=0.0))
            if top < max(self._least, _SAME_RANGE * float(self._tops.max())):
                continue
            piled = int(np.count_nonzero(values >= self._bands(channel)[0]))
            below = (len(values) - piled) / _BANDS
            is_level = piled >= max(_FEWEST, _TIMES * (below + 1.0))
            if is_level and not _repeat(self._peaks[channel], top):
                levels[channel] = max(_MARKED * top, known[channel])
        return levels.reshape(2, 3)


def _peaks(column: Float, edge: float) -> Float:
    """Return the stretches of a channel from `edge` on, shape (P, 5).

    Of each its lowest value, the values before and after it, its length, and how far its middle rises above its ends.
    """
    edges = np.flatnonzero(np.diff(np.concatenate(([False], column >= edge, [False])).astype(np.int8)))
    starts, stops = edges[::2], edges[1::2]
    inside = (starts > 0) & (stops < column.size)
    starts, stops = starts[inside], stops[inside]
    ends = 0.5 * (column[starts] + column[stops - 1])
    lowest = np.minimum(column[starts], column[stops - 1])
    rises = column[(starts + stops) // 2] - ends
    return np.stack((lowest, column[starts - 1], column[stops], stops - starts, rises), axis=1)


def _repeat(peaks: Float, top: float) -> bool:
    """Return whether a channel comes to its top as a machine does that repeats exactly, and is not flat there."""
    if len(peaks) < _FEWEST_PEAKS:
        return False
    lowest, before, after, length, rises = peaks.T
    usual = float(np.median(length))
    if usual > _SHORT:
        return False
    is_same = all(float(np.median(np.abs(one - np.median(one)))) < _REPEATS * top for one in (before, after))
    is_flat = usual == _SHORT and float(np.median(rises / (lowest - 0.5 * (before + after)))) < _FLAT
    return is_same and not is_flat


def at_levels(values: Float, levels: Float) -> NDArray[np.bool_]:
    """Return which samples, shape (..., 3) to (...), touch the levels of `ClipWatch`."""
    return np.asarray(((values >= levels[0]) | (-values >= levels[1])).any(axis=-1))


def mark_clipped(chunk: ImuChunk) -> ImuChunk:
    """Return a whole session with SATURATED where values pile up at the end of a range that nobody declared.

    Parameters
    ----------
    chunk : ImuChunk
        The same one is returned where nothing is cut off.
    """
    quality = chunk.quality.copy()
    edges = [*range(0, chunk.tick_count, _STRETCH_TICKS), chunk.tick_count]
    for s in range(chunk.sensor_count):
        for values, least, is_rate in (
            (chunk.gyroscope_radps[s], LEAST_RATE_RANGE_RADPS, True),
            (chunk.accelerometer_mps2[s], LEAST_FORCE_RANGE_MPS2, False),
        ):
            watch = ClipWatch(least, is_rate=is_rate)
            for start, stop in pairwise(edges):
                watch.add(values[start:stop], chunk.time_step_s)
            quality[s, at_levels(values, watch.levels)] |= np.uint8(SampleQuality.SATURATED)
    return chunk if (quality == chunk.quality).all() else replace(chunk, quality=quality)
