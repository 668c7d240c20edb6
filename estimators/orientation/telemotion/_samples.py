"""Steps of our own filter at every sample: turn by the rate, sum up the block, notice rest."""

import math

from estimators._kernels import Scalars4, multiply, normalized, rotate
from estimators.kernels import Record, borrowing, turn
from estimators.orientation.telemotion._records import BIAS, STATES
from estimators.recording import Float

_REST_MEAN_RATE = math.radians(3.0)
"""A mean rate above this is a slow turn and not the bias of a usable gyroscope."""
CLIP_SHARE = 0.25
"""What a gyroscope at its limit misses, as a share of that: a swing cut off at three quarters of its peak."""
_MOST_DOUBT = 1000.0
"""So that a bias that has jumped is found again within a minute of rest."""


@borrowing("UniTuple(float64, 4)(float64, float64, float64)")
def to_vertical(x: float, y: float, z: float) -> Scalars4:
    """Return the smallest rotation that turns a vector, of any length but zero, to the z axis."""
    norm = math.sqrt(x * x + y * y + z * z)
    if norm == 0.0:
        return 1.0, 0.0, 0.0, 0.0
    w = 1.0 + z / norm
    if w < 1e-9:
        return 0.0, 1.0, 0.0, 0.0
    return normalized(w, y / norm, -x / norm, 0.0)


@borrowing()
def watch_rest(memory: Record, sample: Record, settings: Record) -> None:
    """Carry the exponential means and variances of rate and force, and how long they have been still."""
    gain = settings.rest_gain
    rate_step = force_step = mean_rate = 0.0
    for axis in range(3):
        d = sample.rate[axis] - memory.mean_rate[axis]
        memory.mean_rate[axis] += gain * d
        rate_step += d * d
        d = sample.force[axis] - memory.mean_force[axis]
        memory.mean_force[axis] += gain * d
        force_step += d * d
        mean_rate += memory.mean_rate[axis] ** 2
    memory.rate_spread = (1.0 - gain) * (memory.rate_spread + gain * rate_step)
    memory.force_spread = (1.0 - gain) * (memory.force_spread + gain * force_step)
    still = (
        memory.rate_spread < settings.rest_rate
        and memory.force_spread < settings.rest_force
        and mean_rate < _REST_MEAN_RATE**2
        and memory.clipped == 0
    )
    memory.rest_s = memory.rest_s + settings.step_s if still else 0.0


@borrowing()
def begin_rest(memory: Record, sample: Record) -> None:
    """Let the means start at this sample."""
    for axis in range(3):
        memory.mean_rate[axis] = sample.rate[axis]
        memory.mean_force[axis] = sample.force[axis]
    memory.rate_spread = memory.force_spread = memory.rest_s = 0.0


@borrowing()
def rest_variance(p: Float, memory: Record, settings: Record, time_s: float) -> float:
    """Return the variance of a block's mean rate at rest as a measurement of the bias; learn how a rest sways.

    A person's rest is none of the device's: standing sways to and fro, which averages out, and an arm held up
    sinks, which does not, but contradicts a bias that is known.
    """
    sure_s = max(settings.rest_sure_s, time_s)
    gain = time_s / min(max(memory.rest_s - settings.rest_minimum_s, time_s), sure_s)
    sway = squares = 0.0
    known = settings.rest_surprise
    for a in range(3):
        d = memory.mean_rate[a] - memory.rest_mean[a]
        memory.rest_mean[a] += gain * d
        sway += d * d
        squares += (memory.rest_mean[a] - memory.bias[a]) ** 2
        known += p[(STATES + 1) * (BIAS + a)]
    if gain < 1.0:  # the first block of a rest begins the mean
        memory.rest_sway += time_s / sure_s * (sway - memory.rest_sway)
    doubt = 1.0 + min((squares / known) ** 2, _MOST_DOUBT)
    return float(doubt * (settings.rest_bias + settings.rest_sway_s * memory.rest_sway) / time_s)


@borrowing()
def integrate(
    memory: Record,
    sums: Record,
    sample: Record,
    settings: Record,
) -> None:
    """Turn the attitude by one sample and add the sample to the sums of its block (house note, 5.1, 5.2).

    Sums, R being the attitude after the sample and w the corrected rate: R; R[:, a] times the raw rate
    (how gain errors turn the attitude); specific force in the start frame over time; field minus hard
    iron, undone by its delay; and w x field, how the delay shows.

    Notes
    -----
    A sample is the mean over the interval before it, so force is rotated by the attitude half a sample
    earlier: with fast turns this alone takes a tenth from the inclination error.
    """
    step_s = settings.step_s
    gx, gy, gz = sample.rate[0], sample.rate[1], sample.rate[2]
    wx = gx - memory.bias[0] + memory.gain[0] * gx + memory.gain[3] * gy + memory.gain[6] * gz
    wy = gy - memory.bias[1] + memory.gain[1] * gx + memory.gain[4] * gy + memory.gain[7] * gz
    wz = gz - memory.bias[2] + memory.gain[2] * gx + memory.gain[5] * gy + memory.gain[8] * gz
    tw, tx, ty, tz = turn(wx * step_s, wy * step_s, wz * step_s)
    w, x, y, z = multiply(memory.q[0], memory.q[1], memory.q[2], memory.q[3], tw, tx, ty, tz)
    w, x, y, z = normalized(w, x, y, z)
    memory.q[0], memory.q[1], memory.q[2], memory.q[3] = w, x, y, z
    r00, r01, r02 = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)
    r10, r11, r12 = 2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)
    r20, r21, r22 = 2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)
    rows = ((r00, r01, r02), (r10, r11, r12), (r20, r21, r22))
    half = 0.5 * step_s
    ax, ay = sample.force[0] - memory.force_offset[0], sample.force[1] - memory.force_offset[1]
    az = sample.force[2] - memory.force_offset[2]
    fx = step_s * (ax - half * (wy * az - wz * ay))
    fy = step_s * (ay - half * (wz * ax - wx * az))
    fz = step_s * (az - half * (wx * ay - wy * ax))
    for i in range(3):
        a, b, c = rows[i]
        sums.sum_rotation[3 * i] += a
        sums.sum_rotation[3 * i + 1] += b
        sums.sum_rotation[3 * i + 2] += c
        for k in range(3):
            g = sample.rate[k]
            sums.sum_gain[9 * i + 3 * k] += a * g
            sums.sum_gain[9 * i + 3 * k + 1] += b * g
            sums.sum_gain[9 * i + 3 * k + 2] += c * g
        sums.sum_force[i] += a * fx + b * fy + c * fz
    sums.sum_rate2 += wx * wx + wy * wy + wz * wz
    sums.count += 1
    if sample.has_field:
        mx = sample.field[0] - memory.iron[0]
        my = sample.field[1] - memory.iron[1]
        mz = sample.field[2] - memory.iron[2]
        cx, cy, cz = wy * mz - wz * my, wz * mx - wx * mz, wx * my - wy * mx
        mx, my, mz = mx - memory.delay * cx, my - memory.delay * cy, mz - memory.delay * cz
        for i in range(3):
            a, b, c = rows[i]
            sums.sum_field[i] += a * mx + b * my + c * mz
            sums.sum_delay[i] += a * cx + b * cy + c * cz
        sums.field_count += 1
    if sample.saturated:
        # The error is the same for the whole time at the limit: it grows with its square, 2 n - 1 a step.
        memory.clipped += 1
        growth = (2.0 * memory.clipped - 1.0) * step_s * step_s
        largest = max(abs(sample.rate[0]), abs(sample.rate[1]), abs(sample.rate[2]))
        unseen = max(settings.clip_rate, (CLIP_SHARE * largest) ** 2)
        for axis in range(3):
            sums.gap_turn_variance[axis] += unseen * growth
            sums.gap_speed_variance[axis] += settings.clip_force * growth
    else:
        memory.clipped = 0


@borrowing()
def clear_sums(sums: Record) -> None:
    """Begin a block."""
    sums.sum_rotation[:] = 0.0
    sums.sum_gain[:] = 0.0
    for vector in (
        sums.sum_force,
        sums.sum_field,
        sums.sum_delay,
        sums.gap_turn_variance,
        sums.gap_speed_variance,
    ):
        vector[:] = 0.0
    sums.sum_rate2 = 0.0
    sums.count = sums.field_count = 0


@borrowing()
def level(memory: Record) -> None:
    """Turn attitude and sums so that the mean specific force since the start points up."""
    tw, tx, ty, tz = to_vertical(memory.sum_force[0], memory.sum_force[1], memory.sum_force[2])
    w, x, y, z = multiply(tw, tx, ty, tz, memory.q[0], memory.q[1], memory.q[2], memory.q[3])
    memory.q[0], memory.q[1], memory.q[2], memory.q[3] = normalized(w, x, y, z)
    for vector in (memory.sum_force, memory.sum_field, memory.start_speed, memory.start_lever):
        vector[0], vector[1], vector[2] = rotate(tw, tx, ty, tz, vector[0], vector[1], vector[2])
