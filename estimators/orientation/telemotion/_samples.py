"""What our own filter does with every sample: turn by the rate, sum up the block, notice rest."""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import Scalars4, exponential, kernel, multiply, normalized, rotate
from estimators.orientation.telemotion._layout import (
    BIAS,
    CLIP_FORCE,
    CLIP_RATE,
    CLIPPED,
    COUNT,
    DELAY,
    FIELD_COUNT,
    FORCE,
    FORCE_SPREAD,
    GAIN,
    GAP_SPEED_VARIANCE,
    GAP_TURN_VARIANCE,
    HAS_FIELD,
    IRON,
    MAGNETIC,
    MEAN_FORCE,
    MEAN_RATE,
    RATE,
    RATE_SPREAD,
    REST_BIAS,
    REST_FORCE,
    REST_GAIN,
    REST_MEAN,
    REST_MINIMUM_S,
    REST_RATE,
    REST_S,
    REST_SURE_S,
    REST_SURPRISE,
    REST_SWAY,
    REST_SWAY_S,
    SATURATED,
    START_LEVER,
    START_SPEED,
    STATES,
    STEP_S,
    SUM_DELAY,
    SUM_FIELD,
    SUM_FORCE,
    SUM_GAIN,
    SUM_RATE2,
    SUM_ROTATION,
)
from estimators.recording import Float

_REST_MEAN_RATE = math.radians(3.0)
"""A mean rate above this is a slow turn and not the bias of a usable gyroscope."""
CLIP_SHARE = 0.25
"""What a gyroscope at its limit misses, as a share of that: a swing cut off at three quarters of its peak."""
_MOST_DOUBT = 1000.0
"""So that a bias that has jumped is found again within a minute of rest."""


@kernel("UniTuple(float64, 4)(float64, float64, float64)")
def to_vertical(x: float, y: float, z: float) -> Scalars4:
    """Return the smallest rotation that turns a vector, of any length but zero, to the z axis."""
    norm = math.sqrt(x * x + y * y + z * z)
    if norm == 0.0:
        return 1.0, 0.0, 0.0, 0.0
    w = 1.0 + z / norm
    if w < 1e-9:
        return 0.0, 1.0, 0.0, 0.0
    return normalized(w, y / norm, -x / norm, 0.0)


@kernel("void(float64[::1], int64[::1], float64[::1], float64[::1])")
def watch_rest(memory: Float, counts: NDArray[np.int64], sample: Float, settings: Float) -> None:
    """Carry the exponential means and variances of rate and force, and how long they have been still."""
    gain = settings[REST_GAIN]
    rate_step = force_step = mean_rate = 0.0
    for axis in range(3):
        d = sample[RATE + axis] - memory[MEAN_RATE + axis]
        memory[MEAN_RATE + axis] += gain * d
        rate_step += d * d
        d = sample[FORCE + axis] - memory[MEAN_FORCE + axis]
        memory[MEAN_FORCE + axis] += gain * d
        force_step += d * d
        mean_rate += memory[MEAN_RATE + axis] ** 2
    memory[RATE_SPREAD] = (1.0 - gain) * (memory[RATE_SPREAD] + gain * rate_step)
    memory[FORCE_SPREAD] = (1.0 - gain) * (memory[FORCE_SPREAD] + gain * force_step)
    still = (
        memory[RATE_SPREAD] < settings[REST_RATE]
        and memory[FORCE_SPREAD] < settings[REST_FORCE]
        and mean_rate < _REST_MEAN_RATE**2
        and counts[CLIPPED] == 0
    )
    memory[REST_S] = memory[REST_S] + settings[STEP_S] if still else 0.0


@kernel("void(float64[::1], float64[::1])")
def begin_rest(memory: Float, sample: Float) -> None:
    """Let the means start at this sample."""
    for axis in range(3):
        memory[MEAN_RATE + axis] = sample[RATE + axis]
        memory[MEAN_FORCE + axis] = sample[FORCE + axis]
    memory[RATE_SPREAD] = memory[FORCE_SPREAD] = memory[REST_S] = 0.0


@kernel("float64(float64[::1], float64[::1], float64[::1], float64[::1], float64)")
def rest_variance(p: Float, bias: Float, memory: Float, settings: Float, time_s: float) -> float:
    """Return the variance of a block's mean rate at rest as a measurement of the bias; learn how a rest sways.

    A person's rest is none of the device's: standing sways to and fro, which averages out, and an arm held up
    sinks, which does not, but contradicts a bias that is known.
    """
    sure_s = max(settings[REST_SURE_S], time_s)
    gain = time_s / min(max(memory[REST_S] - settings[REST_MINIMUM_S], time_s), sure_s)
    sway = squares = 0.0
    known = settings[REST_SURPRISE]
    for a in range(3):
        d = memory[MEAN_RATE + a] - memory[REST_MEAN + a]
        memory[REST_MEAN + a] += gain * d
        sway += d * d
        squares += (memory[REST_MEAN + a] - bias[a]) ** 2
        known += p[(STATES + 1) * (BIAS + a)]
    if gain < 1.0:  # the first block of a rest begins the mean
        memory[REST_SWAY] += time_s / sure_s * (sway - memory[REST_SWAY])
    doubt = 1.0 + min((squares / known) ** 2, _MOST_DOUBT)
    return float(doubt * (settings[REST_BIAS] + settings[REST_SWAY_S] * memory[REST_SWAY]) / time_s)


@kernel("void(float64[::1], float64[::1], float64[::1], int64[::1], float64[::1], float64[::1])")
def integrate(
    q: Float,
    bias: Float,
    memory: Float,
    counts: NDArray[np.int64],
    sample: Float,
    settings: Float,
) -> None:
    """Turn the attitude by one sample and add the sample to the sums of its block (house note, 5.1, 5.2).

    Sums, R being the attitude after the sample and w the corrected rate: R; R[:, a] times the raw rate
    (how gain errors turn the attitude); specific force in the start frame over time; field minus hard
    iron, taken back by its delay; and w x field, how the delay shows.

    Notes
    -----
    A sample is the mean over the interval before it, so force is rotated by the attitude half a sample
    earlier: with fast turns this alone takes a tenth from the inclination error.
    """
    step_s = settings[STEP_S]
    gx, gy, gz = sample[RATE], sample[RATE + 1], sample[RATE + 2]
    wx = gx - bias[0] + memory[GAIN] * gx + memory[GAIN + 3] * gy + memory[GAIN + 6] * gz
    wy = gy - bias[1] + memory[GAIN + 1] * gx + memory[GAIN + 4] * gy + memory[GAIN + 7] * gz
    wz = gz - bias[2] + memory[GAIN + 2] * gx + memory[GAIN + 5] * gy + memory[GAIN + 8] * gz
    tw, tx, ty, tz = exponential(wx * step_s, wy * step_s, wz * step_s)
    w, x, y, z = multiply(q[0], q[1], q[2], q[3], tw, tx, ty, tz)
    w, x, y, z = normalized(w, x, y, z)
    q[0], q[1], q[2], q[3] = w, x, y, z
    r00, r01, r02 = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)
    r10, r11, r12 = 2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)
    r20, r21, r22 = 2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)
    rows = ((r00, r01, r02), (r10, r11, r12), (r20, r21, r22))
    half = 0.5 * step_s
    ax, ay, az = sample[FORCE], sample[FORCE + 1], sample[FORCE + 2]
    fx = step_s * (ax - half * (wy * az - wz * ay))
    fy = step_s * (ay - half * (wz * ax - wx * az))
    fz = step_s * (az - half * (wx * ay - wy * ax))
    for i in range(3):
        a, b, c = rows[i]
        memory[SUM_ROTATION + 3 * i] += a
        memory[SUM_ROTATION + 3 * i + 1] += b
        memory[SUM_ROTATION + 3 * i + 2] += c
        column = SUM_GAIN + 9 * i
        for k in range(3):
            g = sample[RATE + k]
            memory[column + 3 * k] += a * g
            memory[column + 3 * k + 1] += b * g
            memory[column + 3 * k + 2] += c * g
        memory[SUM_FORCE + i] += a * fx + b * fy + c * fz
    memory[SUM_RATE2] += wx * wx + wy * wy + wz * wz
    counts[COUNT] += 1
    if sample[HAS_FIELD] > 0.0:
        mx = sample[MAGNETIC] - memory[IRON]
        my = sample[MAGNETIC + 1] - memory[IRON + 1]
        mz = sample[MAGNETIC + 2] - memory[IRON + 2]
        cx, cy, cz = wy * mz - wz * my, wz * mx - wx * mz, wx * my - wy * mx
        delay = memory[DELAY]
        mx, my, mz = mx - delay * cx, my - delay * cy, mz - delay * cz
        for i in range(3):
            a, b, c = rows[i]
            memory[SUM_FIELD + i] += a * mx + b * my + c * mz
            memory[SUM_DELAY + i] += a * cx + b * cy + c * cz
        counts[FIELD_COUNT] += 1
    if sample[SATURATED] > 0.0:
        # The error is the same for the whole time at the limit: it grows with its square, 2 n - 1 a step.
        counts[CLIPPED] += 1
        growth = (2.0 * counts[CLIPPED] - 1.0) * step_s * step_s
        largest = max(abs(sample[RATE]), abs(sample[RATE + 1]), abs(sample[RATE + 2]))
        unseen = max(settings[CLIP_RATE], (CLIP_SHARE * largest) ** 2)
        for axis in range(3):
            memory[GAP_TURN_VARIANCE + axis] += unseen * growth
            memory[GAP_SPEED_VARIANCE + axis] += settings[CLIP_FORCE] * growth
    else:
        counts[CLIPPED] = 0


@kernel("void(float64[::1], int64[::1])")
def clear_sums(memory: Float, counts: NDArray[np.int64]) -> None:
    """Begin a block."""
    for i in range(SUM_ROTATION, GAP_SPEED_VARIANCE + 3):
        memory[i] = 0.0
    counts[COUNT] = counts[FIELD_COUNT] = 0


@kernel("void(float64[::1], float64[::1], int64[::1])")
def level(q: Float, memory: Float, counts: NDArray[np.int64]) -> None:
    """Turn attitude and sums so that the mean specific force since the start points up."""
    tw, tx, ty, tz = to_vertical(memory[SUM_FORCE], memory[SUM_FORCE + 1], memory[SUM_FORCE + 2])
    w, x, y, z = multiply(tw, tx, ty, tz, q[0], q[1], q[2], q[3])
    q[0], q[1], q[2], q[3] = normalized(w, x, y, z)
    for first in (SUM_FORCE, SUM_FIELD, START_SPEED, START_LEVER):
        x, y, z = rotate(tw, tx, ty, tz, memory[first], memory[first + 1], memory[first + 2])
        memory[first], memory[first + 1], memory[first + 2] = x, y, z


__all__ = [
    "CLIP_SHARE",
    "begin_rest",
    "clear_sums",
    "integrate",
    "level",
    "rest_variance",
    "to_vertical",
    "watch_rest",
]
