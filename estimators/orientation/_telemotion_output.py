"""What goes into our own filter and out of it: reading a tick, and corrections that enter gradually."""

import math

from estimators._kernels import exponential, kernel, multiply, normalized
from estimators.orientation._telemotion_layout import (
    CORRECTION,
    FORCE,
    HAS_FIELD,
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


@kernel(
    "boolean(int64, int64, float64[:, :, ::1], float64[:, :, ::1], float64[:, :, ::1], int64, float64[::1])"
)
def read(
    s: int,
    k: int,
    gyroscope_radps: Float,
    accelerometer_mps2: Float,
    magnetometer_t: Float,
    quality: int,
    sample: Float,
) -> bool:
    """Put one tick into `sample`; say whether gyroscope and accelerometer can be used."""
    usable = (quality & _SAMPLE_MISSING) == 0
    squares = 0.0
    for a in range(3):
        sample[RATE + a] = gyroscope_radps[s, k, a]
        sample[FORCE + a] = accelerometer_mps2[s, k, a]
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
    return bool(usable and squares > 0.0)


__all__ = ["keep_shown", "read", "shown", "take_back"]
