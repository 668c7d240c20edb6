"""The stance statistic and its moving percentile, compiled.

Both address samples by their place in the whole record, so that a buffer of the live filter gives the same
bits as the whole record.
"""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import kernel
from estimators.conventions import GRAVITY_MPS2
from estimators.recording import Float

_G = GRAVITY_MPS2
_GRID_MOST = 512


@kernel("void(float64[:, ::1], float64[:, ::1], int64, int64, int64, float64, float64, float64[::1])")
def stance_statistic(
    gyroscope_radps: Float,
    accelerometer_mps2: Float,
    first: int,
    stop: int,
    half: int,
    gyroscope_scale: float,
    accelerometer_scale: float,
    statistic: Float,
) -> None:
    """Write T for the samples `[first, stop)` of the arrays given, eq. (2) of the method page.

    Parameters
    ----------
    gyroscope_radps, accelerometer_mps2 : ndarray, shape (N, 3)
    first, stop : int
    half : int
        Samples on either side of the centred window, which is cut at the ends of the arrays.
    gyroscope_scale, accelerometer_scale : float
        rad/s and m/s^2.
    statistic : ndarray, shape (N,)
        Output; other samples are left alone.
    """
    samples = gyroscope_radps.shape[0]
    for k in range(first, stop):
        low = max(0, k - half)
        high = min(samples, k + half + 1)
        turning = 0.0
        square = 0.0
        x = 0.0
        y = 0.0
        z = 0.0
        for i in range(low, high):
            for axis in range(3):
                turning += gyroscope_radps[i, axis] * gyroscope_radps[i, axis]
                square += accelerometer_mps2[i, axis] * accelerometer_mps2[i, axis]
            x += accelerometer_mps2[i, 0]
            y += accelerometer_mps2[i, 1]
            z += accelerometer_mps2[i, 2]
        count = float(high - low)
        mean_square = (x * x + y * y + z * z) / (count * count)
        spread = max(0.0, square / count - mean_square)
        off_gravity = math.sqrt(mean_square) - _G
        statistic[k] = math.sqrt(
            turning / count / (gyroscope_scale * gyroscope_scale)
            + (spread + off_gravity * off_gravity) / (accelerometer_scale * accelerometer_scale)
        )


@kernel("void(float64[::1], int64, int64, int64, int64, int64, int64, float64, float64[::1])")
def moving_percentile(
    statistic: Float,
    origin: int,
    first: int,
    stop: int,
    stride: int,
    before: int,
    after: int,
    share: float,
    reference: Float,
) -> None:
    """Write the low percentile of T around each sample, eq. (3) without its floor.

    Parameters
    ----------
    statistic : ndarray, shape (N,)
        T of the record's samples `origin` to `origin + N - 1`.
    origin, first, stop : int
        In the whole record; `[first, stop)` are written.
    stride : int
        Every so many-th sample of the whole record is looked at, and the percentile is held between them.
    before, after : int
        Half-windows in multiples of the stride; cut at the ends of the array.
    share : float
        Percentile / 100, interpolated linearly.
    reference : ndarray, shape (N,)
        Output.
    """
    samples = statistic.shape[0]
    sorted_low = np.empty(_GRID_MOST)
    done = -1
    value = 0.0
    for k in range(first, stop):
        centre = k // stride
        if centre != done:
            low = max(centre - before, (origin + stride - 1) // stride)
            high = min(centre + after, (origin + samples - 1) // stride)
            high = min(high, low + _GRID_MOST - 1)
            count = high - low + 1
            position = share * (count - 1)
            needed = min(count, int(position) + 2)
            kept = 0
            for grid in range(low, high + 1):
                t = statistic[grid * stride - origin]
                if kept == needed and t >= sorted_low[kept - 1]:
                    continue
                at = kept if kept < needed else kept - 1
                while at > 0 and sorted_low[at - 1] > t:
                    sorted_low[at] = sorted_low[at - 1]
                    at -= 1
                sorted_low[at] = t
                kept = min(kept + 1, needed)
            floor = int(position)
            value = sorted_low[floor]
            if floor + 1 < kept:
                value += (position - floor) * (sorted_low[floor + 1] - value)
            done = centre
        reference[k - origin] = value


@kernel("void(float64[::1], boolean[::1], int64, int64, int64, boolean[::1])")
def local_minimum(
    statistic: Float, allowed: NDArray[np.bool_], first: int, stop: int, half: int, found: NDArray[np.bool_]
) -> None:
    """Write which allowed samples `[first, stop)` have the lowest T, the earliest of equals, within `half` samples.

    Parameters
    ----------
    statistic : ndarray, shape (N,)
    allowed, found : ndarray of bool, shape (N,)
        Input and output.
    first, stop, half : int
    """
    samples = statistic.shape[0]
    for k in range(first, stop):
        is_lowest = allowed[k]
        if is_lowest:
            for i in range(max(0, k - half), min(samples, k + half + 1)):
                if statistic[i] < statistic[k] or (i < k and statistic[i] == statistic[k]):
                    is_lowest = False
                    break
        found[k] = is_lowest


__all__ = ["local_minimum", "moving_percentile", "stance_statistic"]
