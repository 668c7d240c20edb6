"""Lost samples: what our own filter shows inside a gap, and how it fills the gap once it is over."""

import math

import numpy as np

from estimators._kernels import exponential, kernel, multiply, normalized
from estimators.orientation.telemotion._layout import (
    AFTER_SAMPLE,
    COAST,
    GAIN,
    GAP_SHARE,
    GAP_SPEED_VARIANCE,
    GAP_TURN_VARIANCE,
    HAS_FIELD,
    LAST_SAMPLE,
    RATE,
    RATE_SPREAD,
    SAMPLE,
    SLOPE,
    STEP_S,
)
from estimators.recording import Float

_CURVE_S = 0.014
"""How long a change of rate goes on, on average, after the last sample (house note, 4.5)."""
_MEAN_SHARE = 0.15
"""Part of the error of a filled gap that goes with the rate itself, against its change (4.4)."""
_UNSEEN_S = 0.1
"""A gap this long may hide a change of rate as large as the spread of the rate before it."""


@kernel("void(float64[::1], float64[::1], float64, float64, float64, float64)")
def _turn_coast(memory: Float, bias: Float, gx: float, gy: float, gz: float, step_s: float) -> None:
    """Turn the shown attitude by one raw rate."""
    wx = gx - bias[0] + memory[GAIN] * gx + memory[GAIN + 3] * gy + memory[GAIN + 6] * gz
    wy = gy - bias[1] + memory[GAIN + 1] * gx + memory[GAIN + 4] * gy + memory[GAIN + 7] * gz
    wz = gz - bias[2] + memory[GAIN + 2] * gx + memory[GAIN + 5] * gy + memory[GAIN + 8] * gz
    tw, tx, ty, tz = exponential(wx * step_s, wy * step_s, wz * step_s)
    q = memory[COAST : COAST + 4]
    w, x, y, z = multiply(q[0], q[1], q[2], q[3], tw, tx, ty, tz)
    q[0], q[1], q[2], q[3] = normalized(w, x, y, z)


@kernel("void(float64[::1], float64[::1], float64[::1], boolean, float64, float64)")
def coast(memory: Float, bias: Float, sample: Float, usable: bool, ticks: float, step_s: float) -> None:
    """Turn the shown attitude inside a gap: by the given sample, or by the last rate and its change (4.5)."""
    if usable:
        _turn_coast(memory, bias, sample[RATE], sample[RATE + 1], sample[RATE + 2], step_s)
        return
    curve = max(_CURVE_S / step_s, 0.5)
    reach = curve * (1.0 - math.exp(-(ticks - 0.5) / curve))
    _turn_coast(
        memory,
        bias,
        memory[LAST_SAMPLE] + reach * memory[SLOPE],
        memory[LAST_SAMPLE + 1] + reach * memory[SLOPE + 1],
        memory[LAST_SAMPLE + 2] + reach * memory[SLOPE + 2],
        step_s,
    )


@kernel("void(float64[::1], float64[::1])")
def remember(memory: Float, sample: Float) -> None:
    """Keep a measured sample and its difference from the one before."""
    for i in range(6):
        memory[SLOPE + i] = sample[i] - memory[LAST_SAMPLE + i]
    for i in range(9):
        memory[LAST_SAMPLE + i] = sample[i]
    if sample[HAS_FIELD] == 0.0:
        memory[LAST_SAMPLE + 6] = np.nan


@kernel("void(float64[::1], float64[::1], int64, float64, boolean, float64[::1])")
def filled(memory: Float, now: Float, place: int, gap: float, sloped: bool, sample: Float) -> None:
    """Make sample `place` of `gap` between LAST_SAMPLE and AFTER_SAMPLE (house note, 4.3).

    Gyroscope and accelerometer by the cubic Hermite with the slopes of the samples outside (of the chord
    where there is none), the field by the chord.
    """
    length = gap + 1.0
    t = place / length
    late = t * t * (3.0 - 2.0 * t)
    rise_last, rise_after = t * (1.0 - t) ** 2 * length, -t * t * (1.0 - t) * length
    for i in range(SAMPLE):
        sample[i] = 0.0
    for i in range(6):
        first, second = memory[LAST_SAMPLE + i], memory[AFTER_SAMPLE + i]
        slope_after = now[i] - second if sloped else (second - first) / length
        sample[i] = first + late * (second - first) + rise_last * memory[SLOPE + i] + rise_after * slope_after
    if math.isfinite(memory[LAST_SAMPLE + 6]) and math.isfinite(memory[AFTER_SAMPLE + 6]):
        for i in range(6, 9):
            first, second = memory[LAST_SAMPLE + i], memory[AFTER_SAMPLE + i]
            sample[i] = first + t * (second - first)
        sample[HAS_FIELD] = 1.0


@kernel("void(float64[::1], float64[::1])")
def after_gap(memory: Float, sample: Float) -> None:
    """Make the sample that was set aside when the gap ended."""
    for i in range(SAMPLE):
        sample[i] = 0.0
    for i in range(9):
        sample[i] = memory[AFTER_SAMPLE + i]
    if math.isfinite(memory[AFTER_SAMPLE + 6]):
        sample[HAS_FIELD] = 1.0


@kernel("void(float64[::1], float64[::1])")
def set_aside(memory: Float, sample: Float) -> None:
    """Keep the first sample after a gap until the next gives its slope."""
    for i in range(9):
        memory[AFTER_SAMPLE + i] = sample[i]
    if sample[HAS_FIELD] == 0.0:
        memory[AFTER_SAMPLE + 6] = np.nan


@kernel("void(float64[::1], float64[::1], boolean, float64[::1], float64)")
def doubt_filling(memory: Float, now: Float, sloped: bool, settings: Float, gap: float) -> None:
    """Add the error of a filled gap to the block's noise (house note, 4.4).

    Two terms more than there: a gap may hide a swing whose ends look alike, so half the spread of the rate
    before it counts, in full once it is `_UNSEEN_S` long; and half of how far the curve leaves the chord.
    """
    length = gap + 1.0
    time_s = length * settings[STEP_S]
    share = settings[GAP_SHARE]
    unseen = 0.25 * memory[RATE_SPREAD] / 3.0 * min(time_s / _UNSEEN_S, 1.0) ** 2
    for a in range(3):
        first, second = memory[LAST_SAMPLE + a], memory[AFTER_SAMPLE + a]
        slope_after = now[a] - second if sloped else (second - first) / length
        bulge = length / 8.0 * (memory[SLOPE + a] - slope_after)
        rate_variance = share * ((second - first) ** 2 + (_MEAN_SHARE * (second + first)) ** 2)
        rate_variance += unseen + 0.25 * bulge * bulge
        memory[GAP_TURN_VARIANCE + a] += rate_variance * time_s * time_s
        first, second = memory[LAST_SAMPLE + 3 + a], memory[AFTER_SAMPLE + 3 + a]
        memory[GAP_SPEED_VARIANCE + a] += share * ((second - first) * time_s) ** 2


@kernel("float64(float64[::1], float64, float64, float64)")
def gap_variance(memory: Float, ticks: float, share: float, step_s: float) -> float:
    """Return the variance per axis that a gap of `ticks` has added to the shown attitude."""
    time_s = ticks * step_s
    squares = 0.0
    for a in range(3):
        squares += memory[LAST_SAMPLE + a] ** 2 + (_CURVE_S / step_s * memory[SLOPE + a]) ** 2
    return share * time_s * time_s * squares


__all__ = [
    "after_gap",
    "coast",
    "doubt_filling",
    "filled",
    "gap_variance",
    "remember",
    "set_aside",
]
