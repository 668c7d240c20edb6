"""Lost samples: what our own filter shows inside a gap, and how it fills the gap once it is over."""

import math

import numpy as np

from estimators._kernels import exponential, multiply, normalized
from estimators.kernels import Record, borrowing
from estimators.recording import Float

_CURVE_S = 0.014
"""How long a change of rate goes on, on average, after the last sample (house note, 4.5)."""
_MEAN_SHARE = 0.15
"""Part of the error of a filled gap that goes with the rate itself, against its change (4.4)."""
_UNSEEN_S = 0.1
"""A gap this long may hide a change of rate as large as the spread of the rate before it."""


@borrowing()
def _turn_coast(memory: Record, gx: float, gy: float, gz: float, step_s: float) -> None:
    """Turn the shown attitude by one raw rate."""
    wx = gx - memory.bias[0] + memory.gain[0] * gx + memory.gain[3] * gy + memory.gain[6] * gz
    wy = gy - memory.bias[1] + memory.gain[1] * gx + memory.gain[4] * gy + memory.gain[7] * gz
    wz = gz - memory.bias[2] + memory.gain[2] * gx + memory.gain[5] * gy + memory.gain[8] * gz
    tw, tx, ty, tz = exponential(wx * step_s, wy * step_s, wz * step_s)
    q = memory.coast
    w, x, y, z = multiply(q[0], q[1], q[2], q[3], tw, tx, ty, tz)
    q[0], q[1], q[2], q[3] = normalized(w, x, y, z)


@borrowing()
def coast(memory: Record, sample: Record, usable: bool, ticks: float, step_s: float) -> None:
    """Turn the shown attitude inside a gap: by the given sample, or by the last rate and its change (4.5)."""
    if usable:
        _turn_coast(memory, sample.rate[0], sample.rate[1], sample.rate[2], step_s)
        return
    curve = max(_CURVE_S / step_s, 0.5)
    reach = curve * (1.0 - math.exp(-(ticks - 0.5) / curve))
    _turn_coast(
        memory,
        memory.last_rate[0] + reach * memory.slope_rate[0],
        memory.last_rate[1] + reach * memory.slope_rate[1],
        memory.last_rate[2] + reach * memory.slope_rate[2],
        step_s,
    )


@borrowing()
def store_field(into: Float, sample: Record) -> None:
    """Store the field of a sample; without one its first component is NaN."""
    for a in range(3):
        into[a] = sample.field[a]
    if not sample.has_field:
        into[0] = np.nan


@borrowing()
def remember(memory: Record, sample: Record) -> None:
    """Store a measured sample and its difference from the one before."""
    for a in range(3):
        memory.slope_rate[a] = sample.rate[a] - memory.last_rate[a]
        memory.slope_force[a] = sample.force[a] - memory.last_force[a]
        memory.last_rate[a] = sample.rate[a]
        memory.last_force[a] = sample.force[a]
    store_field(memory.last_field, sample)


@borrowing()
def went_on(last: Float, slope: Float, second: Float, now: Float, sloped: bool, gap: int) -> None:
    """Make the first sample after a gap the last one measured, with its slope."""
    for a in range(3):
        slope[a] = now[a] - second[a] if sloped else (second[a] - last[a]) / (gap + 1.0)
        last[a] = second[a]


@borrowing()
def _between(
    last: Float, slope: Float, after: Float, now: Float, sloped: bool, t: float, length: float, out: Float
) -> None:
    """Write the cubic Hermite at `t` of a gap, with the slopes of the samples outside it, or of the chord."""
    late = t * t * (3.0 - 2.0 * t)
    rise_last, rise_after = t * (1.0 - t) ** 2 * length, -t * t * (1.0 - t) * length
    for a in range(3):
        first, second = last[a], after[a]
        slope_after = now[a] - second if sloped else (second - first) / length
        out[a] = first + late * (second - first) + rise_last * slope[a] + rise_after * slope_after


@borrowing()
def filled(memory: Record, now: Record, place: int, gap: float, sloped: bool, sample: Record) -> None:
    """Make sample `place` of `gap` between the last one and the one set aside (house note, 4.3).

    Gyroscope and accelerometer by a cubic, the field by the chord.
    """
    length = gap + 1.0
    t = place / length
    _between(memory.last_rate, memory.slope_rate, memory.after_rate, now.rate, sloped, t, length, sample.rate)
    _between(
        memory.last_force, memory.slope_force, memory.after_force, now.force, sloped, t, length, sample.force
    )
    sample.saturated = 0
    sample.has_field = math.isfinite(memory.last_field[0]) and math.isfinite(memory.after_field[0])
    for a in range(3):
        first, second = memory.last_field[a], memory.after_field[a]
        sample.field[a] = first + t * (second - first) if sample.has_field else 0.0


@borrowing()
def after_gap(memory: Record, sample: Record) -> None:
    """Make the sample that was set aside when the gap ended."""
    # Component by component here as elsewhere in this filter: assigning arrays costs a start fifty more compilations.
    for a in range(3):
        sample.rate[a] = memory.after_rate[a]
        sample.force[a] = memory.after_force[a]
        sample.field[a] = memory.after_field[a]
    sample.saturated = 0
    sample.has_field = math.isfinite(memory.after_field[0])


@borrowing()
def set_aside(memory: Record, sample: Record) -> None:
    """Store the first sample after a gap until the next gives its slope."""
    for a in range(3):
        memory.after_rate[a] = sample.rate[a]
        memory.after_force[a] = sample.force[a]
    store_field(memory.after_field, sample)


@borrowing()
def doubt_filling(memory: Record, now: Record, sloped: bool, settings: Record, gap: float) -> None:
    """Add the error of a filled gap to the block's noise (house note, 4.4).

    Two terms more than there: a gap may hide a swing whose ends look alike, so half the spread of the rate
    before it in full once it is `_UNSEEN_S` long; and half of how far the curve leaves the chord.
    """
    length = gap + 1.0
    time_s = length * settings.step_s
    share = settings.gap_share
    unseen = 0.25 * memory.rate_spread / 3.0 * min(time_s / _UNSEEN_S, 1.0) ** 2
    for a in range(3):
        first, second = memory.last_rate[a], memory.after_rate[a]
        slope_after = now.rate[a] - second if sloped else (second - first) / length
        bulge = length / 8.0 * (memory.slope_rate[a] - slope_after)
        rate_variance = share * ((second - first) ** 2 + (_MEAN_SHARE * (second + first)) ** 2)
        rate_variance += unseen + 0.25 * bulge * bulge
        memory.gap_turn_variance[a] += rate_variance * time_s * time_s
        first, second = memory.last_force[a], memory.after_force[a]
        memory.gap_speed_variance[a] += share * ((second - first) * time_s) ** 2


@borrowing()
def gap_variance(memory: Record, ticks: float, share: float, step_s: float) -> float:
    """Return the variance per axis that a gap of `ticks` has added to the shown attitude."""
    time_s = ticks * step_s
    squares = 0.0
    for a in range(3):
        squares += memory.last_rate[a] ** 2 + (_CURVE_S / step_s * memory.slope_rate[a]) ** 2
    return share * time_s * time_s * squares
