"""What goes into our own filter and out of it: reading a tick, and corrections that enter gradually."""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import exponential, kernel, multiply, normalized
from estimators.orientation.telemotion._layout import (
    AT_LARGEST,
    CLIP_LEVEL,
    CORRECTION,
    FORCE,
    HAS_FIELD,
    LARGEST,
    MAGNETIC,
    OFFSET,
    RATE,
    RETURN_GAIN,
    RETURN_STEP,
    SATURATED,
)
from estimators.recording import Float, SampleQuality

_SAMPLE_MISSING = int(SampleQuality.MISSING)
_SAMPLE_SATURATED = int(SampleQuality.SATURATED)
_MICROTESLA = 1e6
_SAME = 1e-6
_NEAR_CLIP = 1e-3
_CLIP_SAMPLES = 6
_LEAST_RANGE = (4.0, 18.0)
"""Smaller values, rad/s and m/s^2, are no device's limit: the smallest ranges are 245 deg/s and 2 g."""
_SMALL_OFFSET = 1e-8
"""Squared angle below which half of it is its sine, to 1e-13."""


@kernel("void(float64[::1], float64[::1], float64[::1])")
def shown(memory: Float, q: Float, out: Float) -> None:
    """Set `out` to Exp(OFFSET) CORRECTION q."""
    w, x, y, z = multiply(
        memory[CORRECTION],
        memory[CORRECTION + 1],
        memory[CORRECTION + 2],
        memory[CORRECTION + 3],
        q[0],
        q[1],
        q[2],
        q[3],
    )
    ox, oy, oz = memory[OFFSET], memory[OFFSET + 1], memory[OFFSET + 2]
    size = ox * ox + oy * oy + oz * oz
    if size > 0.0:
        if size < _SMALL_OFFSET:
            tw, tx, ty, tz = 1.0, 0.5 * ox, 0.5 * oy, 0.5 * oz
        else:
            tw, tx, ty, tz = exponential(ox, oy, oz)
        w, x, y, z = multiply(tw, tx, ty, tz, w, x, y, z)
    out[0], out[1], out[2], out[3] = normalized(w, x, y, z)


@kernel("void(float64[::1], float64[::1], float64[::1])")
def keep_shown(memory: Float, q: Float, before: Float) -> None:
    """Choose OFFSET so that the output stays at `before` although the estimate has been corrected."""
    c = memory[CORRECTION : CORRECTION + 4]
    w, x, y, z = multiply(c[0], c[1], c[2], c[3], q[0], q[1], q[2], q[3])
    w, x, y, z = multiply(before[0], before[1], before[2], before[3], w, -x, -y, -z)
    if w < 0.0:
        w, x, y, z = -w, -x, -y, -z
    sine = math.sqrt(x * x + y * y + z * z)
    scale = 2.0 * math.atan2(sine, w) / sine if sine > 1e-12 else 2.0
    memory[OFFSET], memory[OFFSET + 1], memory[OFFSET + 2] = scale * x, scale * y, scale * z


@kernel("void(float64[::1], float64[::1])")
def take_back(memory: Float, settings: Float) -> None:
    """Let the output approach the estimate for one tick."""
    size = math.sqrt(memory[OFFSET] ** 2 + memory[OFFSET + 1] ** 2 + memory[OFFSET + 2] ** 2)
    if size == 0.0:
        return
    keep = 1.0 - min(settings[RETURN_GAIN] * size, settings[RETURN_STEP]) / size
    if size < 1e-7:
        keep = 0.0
    for a in range(3):
        memory[OFFSET + a] *= keep


@kernel("boolean(float64[::1], int64[::1], float64[::1], int64)")
def at_clip(memory: Float, counts: NDArray[np.int64], sample: Float, kind: int) -> bool:
    """Learn the clip level of the gyroscope (`kind` 0) or accelerometer (1); say whether it is touched.

    A device that clips shows its largest value again and again, to the last bit; one that does not hardly
    ever shows it twice. A larger value later proves the level wrong.
    """
    largest = 0.0
    for a in range(3):
        largest = max(largest, abs(sample[3 * kind + a]))
    known = memory[LARGEST + kind]
    if largest > known * (1.0 + _SAME):
        memory[LARGEST + kind] = largest
        counts[AT_LARGEST + kind] = 1
        if largest > memory[CLIP_LEVEL + kind] * (1.0 + _NEAR_CLIP):
            memory[CLIP_LEVEL + kind] = np.inf
    elif largest > known * (1.0 - _SAME):
        counts[AT_LARGEST + kind] += 1
        if counts[AT_LARGEST + kind] >= _CLIP_SAMPLES:
            memory[CLIP_LEVEL + kind] = known
    return bool(largest >= memory[CLIP_LEVEL + kind] * (1.0 - _NEAR_CLIP))


@kernel(
    "boolean(int64, int64, float64[:, :, ::1], float64[:, :, ::1], float64[:, :, ::1], int64, float64[::1],"
    "float64[::1], int64[::1])"
)
def read(
    s: int,
    k: int,
    gyroscope_radps: Float,
    accelerometer_mps2: Float,
    magnetometer_t: Float,
    quality: int,
    sample: Float,
    memory: Float,
    counts: NDArray[np.int64],
) -> bool:
    """Put one tick into `sample`; say whether gyroscope and accelerometer can be used."""
    usable = (quality & _SAMPLE_MISSING) == 0
    squares = turning = 0.0
    for a in range(3):
        sample[RATE + a] = gyroscope_radps[s, k, a]
        sample[FORCE + a] = accelerometer_mps2[s, k, a]
        turning += sample[RATE + a] ** 2
        squares += sample[FORCE + a] ** 2
        usable &= math.isfinite(sample[RATE + a]) and math.isfinite(sample[FORCE + a])
    sample[HAS_FIELD] = 0.0
    if magnetometer_t.shape[0] > 0:
        total = 0.0
        for a in range(3):
            sample[MAGNETIC + a] = _MICROTESLA * magnetometer_t[s, k, a]
            total += sample[MAGNETIC + a] ** 2
        if math.isfinite(total) and total > 0.0:
            sample[HAS_FIELD] = 1.0
    sample[SATURATED] = 1.0 if quality & _SAMPLE_SATURATED else 0.0
    # Interpolated values are none of the device's; a level is learnt also where it is known to be one.
    if (quality | _SAMPLE_SATURATED) == _SAMPLE_SATURATED and (
        (turning > _LEAST_RANGE[0] ** 2 and at_clip(memory, counts, sample, 0))
        or (squares > _LEAST_RANGE[1] ** 2 and at_clip(memory, counts, sample, 1))
    ):
        sample[SATURATED] = 1.0
    return bool(usable and squares > 0.0)


__all__ = ["keep_shown", "read", "shown", "take_back"]
