"""The stance statistic and its moving percentile, compiled.

Both address samples by their place in the whole record, so that a buffer of the live filter gives the same
bits as the whole record.
"""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import kernel, step
from estimators.conventions import GRAVITY_MPS2
from estimators.gait.foot import layout as at
from estimators.recording import Float

_STANCE, _STANDSTILL, _HEIGHT = at.STANCE, at.STANDSTILL, at.HEIGHT
# Constants of `decide` and of `noise_densities`, in the order they read them.
RATIO, FLOOR, LIMIT, STILL, SIGMA_FLOOR, SIGMA_SLOPE, SIGMA_EXPONENT, SHARE, RESTLESS, CONTRAST, DECIDE = (
    range(11)
)
SHOCK, SHOCK_DENSITY, FORCE_DENSITY, FORCE_JERK, CLIP, CLIP_DENSITY, RATE_DENSITY, RATE_JERK = range(8)
GAP_FORCE, GAP_RATE, NOISE = 8, 9, 10
CUT_RATE, CUT_FORCE = 16, 128
"""Bits of a sample that is marked as cut off: `CUT_RATE` of the first axis, shifted by one for each further axis."""
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


@step("void(float64[::1], int64, int64, int64, int64, int64, int64, float64, float64[::1])")
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
            retained = 0
            for grid in range(low, high + 1):
                t = statistic[grid * stride - origin]
                if retained == needed and t >= sorted_low[retained - 1]:
                    continue
                at = retained if retained < needed else retained - 1
                while at > 0 and sorted_low[at - 1] > t:
                    sorted_low[at] = sorted_low[at - 1]
                    at -= 1
                sorted_low[at] = t
                retained = min(retained + 1, needed)
            floor = int(position)
            value = sorted_low[floor]
            if floor + 1 < retained:
                value += (position - floor) * (sorted_low[floor + 1] - value)
            done = centre
        reference[k - origin] = value


@step("void(float64[::1], int64, int64, int64, int64, int64, int64, float64[::1])")
def moving_highest(
    statistic: Float, origin: int, first: int, stop: int, stride: int, before: int, after: int, highest: Float
) -> None:
    """Write the highest T around each sample, over the window of `moving_percentile`, whose arguments it takes."""
    samples = statistic.shape[0]
    done = -1
    value = 0.0
    for k in range(first, stop):
        centre = k // stride
        if centre != done:
            low = max(centre - before, (origin + stride - 1) // stride)
            high = min(centre + after, (origin + samples - 1) // stride)
            value = 0.0
            for grid in range(low, high + 1):
                value = max(value, statistic[grid * stride - origin])
            done = centre
        highest[k - origin] = value


@step("void(float64[::1], boolean[::1], int64, int64, int64, boolean[::1])")
def local_minimum(
    statistic: Float, allowed: NDArray[np.bool_], first: int, stop: int, half: int, found: NDArray[np.bool_]
) -> None:
    """Write which allowed samples `[first, stop)` have the lowest T, the earliest of equals, within `half` samples.

    Parameters
    ----------
    statistic : ndarray, shape (N,)
    allowed, found : ndarray of bool, shape (N,)
        Input and output.
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


@kernel(
    "void(float64[::1], int64, int64, int64, int64, int64, int64, int64, float64[::1], float64[::1],"
    " float64[::1], uint8[::1])"
)
def decide(
    statistic: Float,
    origin: int,
    first: int,
    stop: int,
    stride: int,
    before: int,
    after: int,
    alone: int,
    settings: Float,
    reference: Float,
    sigma_mps: Float,
    bits: NDArray[np.uint8],
) -> None:
    """Decide which of the samples `[first, stop)` of a record are stance, eq. (3) to (6) of the method page.

    Own: where T is not small, the foot must move far more before or after, as a runner's does; a foot on a pedal,
    a leg that swings from a chair and a shaken sensor have a lowest T as well, and never stand.

    Parameters
    ----------
    statistic : ndarray, shape (N,)
        T of the record's samples `origin` to `origin + N - 1`.
    origin, first, stop, stride, before, after : int
        As `moving_percentile` takes them.
    alone : int
        As `local_minimum` takes it.
    settings : ndarray, shape (DECIDE,)
    reference, sigma_mps : ndarray, shape (stop - first,)
        Output: the floored low percentile of T, and the contact point's standard deviation of velocity.
    bits : ndarray of uint8, shape (stop - first,)
        Output: STANCE, STANDSTILL and HEIGHT.
    """
    samples = statistic.shape[0]
    lowest, highest = np.empty(samples), np.empty(samples)
    moving_percentile(statistic, origin, first, stop, stride, before, after, settings[SHARE], lowest)
    moving_highest(statistic, origin, first, stop, stride, before, after, highest)
    allowed = np.zeros(samples, dtype=np.bool_)
    for i in range(stop - first):
        k = first - origin + i
        t = statistic[k]
        reference[i] = max(lowest[k], settings[FLOOR])
        sigma_mps[i] = settings[SIGMA_FLOOR] + settings[SIGMA_SLOPE] * t ** settings[SIGMA_EXPONENT]
        allowed[k] = t < settings[RATIO] * reference[i] and t < settings[LIMIT]
        if t > settings[RESTLESS] and settings[CONTRAST] * t > highest[k]:
            allowed[k] = False
        bits[i] = 0
        if allowed[k]:
            bits[i] = _STANCE | _STANDSTILL if t < settings[STILL] else _STANCE
    found = np.zeros(samples, dtype=np.bool_)
    local_minimum(statistic, allowed, first - origin, stop - origin, alone, found)
    for i in range(stop - first):
        if found[first - origin + i]:
            bits[i] |= _HEIGHT


@kernel(
    "void(float64[:, ::1], float64[:, ::1], float64[::1], uint8[::1], int64, int64, float64[::1], float64[::1],"
    " float64[:, ::1])"
)
def noise_densities(
    gyroscope_radps: Float,
    accelerometer_mps2: Float,
    gap_root: Float,
    cut_off: NDArray[np.uint8],
    first: int,
    stop: int,
    settings: Float,
    force_variance: Float,
    rate_variance: Float,
) -> None:
    """Write the noise densities squared of the samples `[first, stop)`, eq. (11) and (12) of the method page.

    Parameters
    ----------
    gyroscope_radps, accelerometer_mps2 : ndarray, shape (N, 3)
        The outermost samples are their own neighbours.
    gap_root : ndarray, shape (N,) or (0,)
        Root of the length of the gap that a sample was filled into over the scale; none: all were measured.
    cut_off : ndarray of uint8, shape (N,) or (0,)
        Bits `CUT_RATE` and `CUT_FORCE` of samples that are marked, in addition to what is beyond the declared levels.
    settings : ndarray, shape (NOISE,)
    force_variance : ndarray, shape (stop - first,)
        Output, (m/s)^2/s.
    rate_variance : ndarray, shape (stop - first, 3)
        Output, rad^2/s.
    """
    last = gyroscope_radps.shape[0] - 1
    for i in range(stop - first):
        k = first + i
        before, after = max(k - 1, 0), min(k + 1, last)
        filled = gap_root[k] if gap_root.shape[0] else 0.0
        cut = 0
        if cut_off.shape[0]:
            for j in range(before, after + 1):
                cut |= cut_off[j]
        is_shock = cut & CUT_FORCE != 0
        jerk2 = 0.0
        for axis in range(3):
            level, turning = 0.0, 0.0
            for j in range(before, after + 1):
                level = max(level, abs(accelerometer_mps2[j, axis]))
                turning = max(turning, abs(gyroscope_radps[j, axis]))
            is_shock = is_shock or level > settings[SHOCK]
            change = 0.5 * (accelerometer_mps2[after, axis] - accelerometer_mps2[before, axis])
            jerk2 += change * change
            is_cut = turning > settings[CLIP] or cut & (CUT_RATE << axis) != 0
            density = settings[CLIP_DENSITY] if is_cut else settings[RATE_DENSITY]
            density = max(density, settings[GAP_RATE] * filled)
            change = 0.5 * (gyroscope_radps[after, axis] - gyroscope_radps[before, axis])
            rate_variance[i, axis] = density * density + (settings[RATE_JERK] * change) ** 2
        density = settings[SHOCK_DENSITY] if is_shock else settings[FORCE_DENSITY]
        density = max(density, settings[GAP_FORCE] * filled)
        force_variance[i] = density * density + settings[FORCE_JERK] ** 2 * jerk2
