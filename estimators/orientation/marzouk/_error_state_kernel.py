"""The error-state EKF that replaces the thesis' filter (A9m), compiled over sensors and ticks.

The page carries the attitude error in the sensor frame, theta; here it is in the earth frame U, xi = R theta. The
noise is the same on all axes, so this is the same filter, and there F of A9m.1 needs no turning, of gravity's rows
[v x] two are left that read one state each (the third is zero), and the heading's row is the third axis. As
the error sits in U it is the covariance there that outlives an injection unchanged.
"""

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import kernel, multiply, rotate
from estimators.kernels import mirror, turn
from estimators.orientation.marzouk import _steps as steps
from estimators.orientation.marzouk._covariance import (
    UPPER,
    Upper,
    keep,
    lessened,
    loaded,
    predicted,
    turned_by_rate,
)
from estimators.orientation.marzouk._steps import direction, prepare, set_heading, start_variance, store
from estimators.recording import Float

# Positions in the settings, after the shared ones.
_FIRST = steps.SHARED_SETTINGS
RATE_VARIANCE, BIAS_DRIFT, GRAVITY_VARIANCE, PUSH_WEIGHT, HEADING_VARIANCE, FIELD_PENALTY = range(
    _FIRST, _FIRST + 6
)
SETTINGS = _FIRST + 6

# Numba freezes globals, not attributes of modules.
_HOLD, _BEGIN, _FILTER = steps.HOLD, steps.BEGIN, steps.FILTER
_RATE, _GRAVITY, _FIELD, _SAMPLE = steps.RATE, steps.GRAVITY, steps.FIELD, steps.SAMPLE
_GRAVITY_NORM, _FIELD_NORM = steps.GRAVITY_NORM, steps.FIELD_NORM
_HAS_FIELD, _GAP_VARIANCE = steps.HAS_FIELD, steps.GAP_VARIANCE
_STEP_S, _HEADING_KNOWN, _FIELD_TOLERANCE = steps.STEP_S, steps.HEADING_KNOWN, steps.FIELD_TOLERANCE


@kernel(
    f"{UPPER}(float64[:, ::1], float64[:, ::1], {UPPER}, int64, float64[::1], float64[::1])", inlined=True
)
def predict(q: Float, bias: Float, p: Upper, s: int, sample: Float, settings: Float) -> Upper:
    """Turn by the rate; F of A9m.1 on the error in the earth frame."""
    step = settings[_STEP_S]
    (w, x, y, z), turned = turned_by_rate(
        (q[s, 0], q[s, 1], q[s, 2], q[s, 3]),
        sample[_RATE] - bias[s, 0],
        sample[_RATE + 1] - bias[s, 1],
        sample[_RATE + 2] - bias[s, 2],
        step,
    )
    q[s, 0], q[s, 1], q[s, 2], q[s, 3] = w, x, y, z
    noise = settings[RATE_VARIANCE] * step * step + sample[_GAP_VARIANCE]
    drift = step * settings[BIAS_DRIFT]
    return predicted(p, turned, (noise, 0.0, 0.0, noise, 0.0, noise), (drift, drift, drift))


@kernel(
    f"{UPPER}(float64[:, ::1], float64[:, ::1], {UPPER}, int64, float64[::1], float64[::1], int64[:, ::1])",
    inlined=True,
)
def correct(
    q: Float,
    bias: Float,
    p: Upper,
    s: int,
    sample: Float,
    settings: Float,
    counters: NDArray[np.int64],
) -> Upper:
    """Correct inclination by gravity (A9m.2), then heading alone by the field (A9m.3)."""
    norm = sample[_GRAVITY_NORM]
    scale = 1.0 / norm
    w, x, y, z = q[s, 0], q[s, 1], q[s, 2], q[s, 3]
    gx, gy, _ = rotate(w, x, y, z, sample[_GRAVITY], sample[_GRAVITY + 1], sample[_GRAVITY + 2])
    push = norm - 1.0
    variance = settings[GRAVITY_VARIANCE] + settings[PUSH_WEIGHT] * push * push
    # Measured gravity in the earth frame is (-xi_y, xi_x, 1): two equally uncertain rows, one by one.
    h = (p[1], p[3], p[4], p[9], p[10], p[11])
    inverse = 1.0 / (h[1] + variance)
    gain = -gx * scale * inverse
    e0, e1, e2, e3, e4, e5 = h[0] * gain, h[1] * gain, h[2] * gain, h[3] * gain, h[4] * gain, h[5] * gain
    p = lessened(p, inverse, h)
    h = (p[0], p[1], p[2], p[6], p[7], p[8])
    inverse = 1.0 / (h[0] + variance)
    gain = (gy * scale - e0) * inverse
    tw, tx, ty, tz = turn(e0 + h[0] * gain, e1 + h[1] * gain, e2 + h[2] * gain)
    w, x, y, z = multiply(tw, tx, ty, tz, w, x, y, z)
    b0, b1, b2 = (
        bias[s, 0] + (e3 + h[3] * gain),
        bias[s, 1] + (e4 + h[4] * gain),
        bias[s, 2] + (e5 + h[5] * gain),
    )
    p = lessened(p, inverse, h)
    if sample[_HAS_FIELD] != 0.0:
        if counters[s, _HEADING_KNOWN] == 0:
            q[s, 0], q[s, 1], q[s, 2], q[s, 3] = w, x, y, z
            set_heading(s, q, sample, counters)
            w, x, y, z = q[s, 0], q[s, 1], q[s, 2], q[s, 3]
        north, east, _ = rotate(w, x, y, z, sample[_FIELD], sample[_FIELD + 1], sample[_FIELD + 2])
        variance = settings[HEADING_VARIANCE]
        if abs(sample[_FIELD_NORM] - 1.0) > settings[_FIELD_TOLERANCE]:
            variance *= settings[FIELD_PENALTY]
        h = (p[2], p[4], p[5], p[12], p[13], p[14])
        inverse = 1.0 / (h[2] + variance)
        gain = -direction(east, north) * inverse
        tw, tx, ty, tz = turn(h[0] * gain, h[1] * gain, h[2] * gain)
        w, x, y, z = multiply(tw, tx, ty, tz, w, x, y, z)
        b0, b1, b2 = b0 + h[3] * gain, b1 + h[4] * gain, b2 + h[5] * gain
        p = lessened(p, inverse, h)
    q[s, 0], q[s, 1], q[s, 2], q[s, 3] = w, x, y, z
    bias[s, 0], bias[s, 1], bias[s, 2] = b0, b1, b2
    return p


@kernel(
    "void(float64[:, :, ::1], float64[:, :, ::1], float64[:, :, ::1], uint8[:, ::1], float64[::1],"
    "float64[:, ::1], float64[:, ::1], float64[:, :, ::1], float64[:, ::1], int64[:, ::1],"
    "float64[:, :, ::1], float64[:, :, ::1], float64[:, :, ::1], uint8[:, ::1])"
)
def run(
    gyroscope_radps: Float,
    accelerometer_mps2: Float,
    magnetometer_t: Float,
    quality: NDArray[np.uint8],
    settings: Float,
    q: Float,
    bias: Float,
    covariance: Float,
    memory: Float,
    counters: NDArray[np.int64],
    q_earth_sensor: Float,
    bias_out: Float,
    sigma_rad: Float,
    flags: NDArray[np.uint8],
) -> None:
    """Filter K ticks of S sensors; states `q`, `bias`, `covariance` (S, 6, 6, earth frame) and more are carried on."""
    sample = np.zeros(_SAMPLE)
    for s in range(quality.shape[0]):
        kept = covariance[s]
        for k in range(quality.shape[1]):
            action = prepare(
                s,
                k,
                gyroscope_radps,
                accelerometer_mps2,
                magnetometer_t,
                quality,
                settings,
                q,
                memory,
                counters,
                sample,
            )
            if action == _BEGIN:
                variance = start_variance(s, memory, counters, settings)
                for i in range(3):
                    for j in range(i, 6):
                        kept[i, j] = 0.0
                    kept[i, i] = variance
            elif action != _HOLD:
                p = predict(q, bias, loaded(kept), s, sample, settings)
                if action == _FILTER:
                    p = correct(q, bias, p, s, sample, settings, counters)
                keep(kept, p)
            store(
                s,
                k,
                action,
                0,
                kept[0, 0],
                kept[1, 1],
                kept[2, 2],
                quality,
                settings,
                q,
                bias,
                counters,
                sample,
                q_earth_sensor,
                bias_out,
                sigma_rad,
                flags,
            )
        mirror(kept)


__all__ = ["SETTINGS", "run"]
