"""Input and output of our own filter: reading a tick, and corrections that enter gradually."""

import math

import numpy as np

from estimators._kernels import multiply, normalized
from estimators.kernels import Record, borrowing, turn
from estimators.orientation._strapdown_steps import Ticks
from estimators.recording import Float, SampleQuality

_SAMPLE_MISSING = int(SampleQuality.MISSING)
_SAMPLE_SATURATED = int(SampleQuality.SATURATED)
_MICROTESLA = 1e6
_SAME = 1e-6
_NEAR_CLIP = 1e-3
_CLIP_SAMPLES = 6
_EDGE = 0.02
_LEAST_RANGE = (0.5, 18.0)
"""Smaller values, rad/s and m/s^2, are no device's limit: the smallest ranges are 245 deg/s and 2 g."""


@borrowing()
def shown(memory: Record, q: Float, out: Float) -> None:
    """Set `out` to Exp(OFFSET) CORRECTION q."""
    w, x, y, z = multiply(
        memory.correction[0],
        memory.correction[1],
        memory.correction[2],
        memory.correction[3],
        q[0],
        q[1],
        q[2],
        q[3],
    )
    ox, oy, oz = memory.offset[0], memory.offset[1], memory.offset[2]
    size = ox * ox + oy * oy + oz * oz
    if size > 0.0:
        tw, tx, ty, tz = turn(ox, oy, oz)
        w, x, y, z = multiply(tw, tx, ty, tz, w, x, y, z)
    out[0], out[1], out[2], out[3] = normalized(w, x, y, z)


@borrowing()
def keep_shown(memory: Record, q: Float, before: Float) -> None:
    """Choose OFFSET so that the output stays at `before` although the estimate has been corrected."""
    c = memory.correction
    w, x, y, z = multiply(c[0], c[1], c[2], c[3], q[0], q[1], q[2], q[3])
    w, x, y, z = multiply(before[0], before[1], before[2], before[3], w, -x, -y, -z)
    if w < 0.0:
        w, x, y, z = -w, -x, -y, -z
    sine = math.sqrt(x * x + y * y + z * z)
    scale = 2.0 * math.atan2(sine, w) / sine if sine > 1e-12 else 2.0
    memory.offset[0], memory.offset[1], memory.offset[2] = scale * x, scale * y, scale * z


@borrowing()
def take_back(memory: Record, settings: Record) -> None:
    """Let the output approach the estimate for one tick."""
    size = math.sqrt(memory.offset[0] ** 2 + memory.offset[1] ** 2 + memory.offset[2] ** 2)
    if size == 0.0:
        return
    keep = 1.0 - min(settings.return_gain * size, settings.return_step) / size
    if size < 1e-7:
        keep = 0.0
    for a in range(3):
        memory.offset[a] *= keep


@borrowing()
def at_clip(memory: Record, largest: float, kind: int) -> bool:
    """Learn the clip level of the gyroscope (`kind` 0) or accelerometer (1); say whether it is touched.

    A device that clips shows its largest value again and again, to the last bit; one that does not hardly
    ever shows it twice. A larger value later proves the level wrong.
    """
    known = memory.largest[kind]
    if largest > known * (1.0 + _SAME):
        near = memory.near_largest[kind] + memory.at_largest[kind]
        memory.near_largest[kind] = near if largest < known * (1.0 + _EDGE) else 0
        memory.largest[kind] = largest
        memory.at_largest[kind] = 1
        if largest > memory.clip_level[kind] * (1.0 + _NEAR_CLIP):
            memory.clip_level[kind] = np.inf
    elif largest > known * (1.0 - _SAME):
        memory.at_largest[kind] += 1
        if memory.at_largest[kind] >= max(_CLIP_SAMPLES, memory.near_largest[kind]):
            memory.clip_level[kind] = known
    elif largest > known * (1.0 - _EDGE):
        memory.near_largest[kind] += 1
    return bool(largest >= memory.clip_level[kind] * (1.0 - _NEAR_CLIP))


@borrowing()
def largest_of(vector: Float) -> float:
    """Return the size of the largest component."""
    return float(max(abs(vector[0]), abs(vector[1]), abs(vector[2])))


@borrowing()
def read(ticks: Ticks, s: int, k: int, sample: Record, memory: Record) -> bool:
    """Put one tick into `sample`; say whether gyroscope and accelerometer can be used."""
    quality = ticks.quality[s, k]
    usable = (quality & _SAMPLE_MISSING) == 0
    squares = turning = 0.0
    for a in range(3):
        sample.rate[a] = ticks.gyroscope_radps[s, k, a]
        sample.force[a] = ticks.accelerometer_mps2[s, k, a]
        turning += sample.rate[a] ** 2
        squares += sample.force[a] ** 2
        usable &= math.isfinite(sample.rate[a]) and math.isfinite(sample.force[a])
    sample.has_field = 0
    if ticks.magnetometer_t.shape[0] > 0:
        total = 0.0
        for a in range(3):
            sample.field[a] = _MICROTESLA * ticks.magnetometer_t[s, k, a]
            total += sample.field[a] ** 2
        if math.isfinite(total) and total > 0.0:
            sample.has_field = 1
    sample.saturated = 1 if quality & _SAMPLE_SATURATED else 0
    # Interpolated values are none of the device's; a level is learnt also where it is known to be one.
    if (quality | _SAMPLE_SATURATED) == _SAMPLE_SATURATED and (
        (turning > _LEAST_RANGE[0] ** 2 and at_clip(memory, largest_of(sample.rate), 0))
        or (squares > _LEAST_RANGE[1] ** 2 and at_clip(memory, largest_of(sample.force), 1))
    ):
        sample.saturated = 1
    return bool(usable and squares > 0.0)
