"""The error-state EKF that replaces the thesis' filter (A9m), compiled over sensors and ticks."""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import exponential, kernel, multiply, normalized, rotate, rotate_back
from estimators.orientation import _marzouk_steps as steps
from estimators.orientation._marzouk_steps import prepare, set_heading, start_variance, store
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
    "void(float64[:, ::1], float64[:, ::1], float64[:, :, ::1], int64, float64[::1], float64[::1],"
    "float64[:, ::1])"
)
def predict(
    q: Float, bias: Float, covariance: Float, s: int, sample: Float, settings: Float, work: Float
) -> None:
    """Turn by the rate; F = [[dR', -Ts I], [0, I]] on the error in the sensor frame (A9m.1)."""
    p = covariance[s]
    step = settings[_STEP_S]
    tw, tx, ty, tz = exponential(
        (sample[_RATE] - bias[s, 0]) * step,
        (sample[_RATE + 1] - bias[s, 1]) * step,
        (sample[_RATE + 2] - bias[s, 2]) * step,
    )
    # Rows of dR' are columns of dR.
    d = work[0:3]
    d[0, 0], d[0, 1], d[0, 2] = rotate(tw, tx, ty, tz, 1.0, 0.0, 0.0)
    d[1, 0], d[1, 1], d[1, 2] = rotate(tw, tx, ty, tz, 0.0, 1.0, 0.0)
    d[2, 0], d[2, 1], d[2, 2] = rotate(tw, tx, ty, tz, 0.0, 0.0, 1.0)
    turned, cross = work[3:6], work[6:9]
    for i in range(3):
        for j in range(3):
            turned[i, j] = d[i, 0] * p[0, j] + d[i, 1] * p[1, j] + d[i, 2] * p[2, j]
            cross[i, j] = d[i, 0] * p[0, 3 + j] + d[i, 1] * p[1, 3 + j] + d[i, 2] * p[2, 3 + j]
    noise = settings[RATE_VARIANCE] * step * step + sample[_GAP_VARIANCE]
    for i in range(3):
        for j in range(i, 3):
            value = turned[i, 0] * d[j, 0] + turned[i, 1] * d[j, 1] + turned[i, 2] * d[j, 2]
            value += step * (step * p[3 + i, 3 + j] - cross[i, j] - cross[j, i])
            if i == j:
                value += noise
            p[i, j] = p[j, i] = value
    for i in range(3):
        for j in range(3):
            p[i, 3 + j] = p[3 + j, i] = cross[i, j] - step * p[3 + i, 3 + j]
    for i in range(3):
        p[3 + i, 3 + i] += step * settings[BIAS_DRIFT]
    w, x, y, z = multiply(q[s, 0], q[s, 1], q[s, 2], q[s, 3], tw, tx, ty, tz)
    q[s, 0], q[s, 1], q[s, 2], q[s, 3] = normalized(w, x, y, z)


@kernel("void(float64[:, ::1], float64[::1], float64[::1], float64, float64, float64, float64, float64)")
def absorb(
    p: Float, error: Float, ph: Float, h0: float, h1: float, h2: float, innovation: float, variance: float
) -> None:
    """Take one scalar measurement of the attitude error, row (h, 0), into `error` (6) and `p` (6, 6)."""
    for i in range(6):
        ph[i] = h0 * p[i, 0] + h1 * p[i, 1] + h2 * p[i, 2]
    inverse = 1.0 / (h0 * ph[0] + h1 * ph[1] + h2 * ph[2] + variance)
    step = inverse * (innovation - (h0 * error[0] + h1 * error[1] + h2 * error[2]))
    for i in range(6):
        error[i] += ph[i] * step
        for j in range(6):
            p[i, j] -= inverse * (ph[i] * ph[j])


@kernel("void(float64[:, ::1], float64[:, ::1], int64, float64[::1])")
def inject(q: Float, bias: Float, s: int, error: Float) -> None:
    """Move the error into the estimate and clear it (A9m.4)."""
    tw, tx, ty, tz = exponential(error[0], error[1], error[2])
    w, x, y, z = multiply(q[s, 0], q[s, 1], q[s, 2], q[s, 3], tw, tx, ty, tz)
    q[s, 0], q[s, 1], q[s, 2], q[s, 3] = normalized(w, x, y, z)
    for i in range(3):
        bias[s, i] += error[3 + i]
        error[i] = error[3 + i] = 0.0


@kernel(
    "void(float64[:, ::1], float64[:, ::1], float64[:, :, ::1], int64, float64[::1], float64[::1],"
    "int64[:, ::1], float64[:, ::1])"
)
def correct(
    q: Float,
    bias: Float,
    covariance: Float,
    s: int,
    sample: Float,
    settings: Float,
    counters: NDArray[np.int64],
    work: Float,
) -> None:
    """Correct inclination by gravity (A9m.2), then heading alone by the field (A9m.3)."""
    p = covariance[s]
    error, ph = work[9], work[10]
    for i in range(6):
        error[i] = 0.0
    norm = sample[_GRAVITY_NORM]
    vx, vy, vz = rotate_back(q[s, 0], q[s, 1], q[s, 2], q[s, 3], 0.0, 0.0, 1.0)
    variance = settings[GRAVITY_VARIANCE] + settings[PUSH_WEIGHT] * (norm - 1.0) ** 2
    # Three equally uncertain rows of [v x], taken one by one, are the joint update.
    absorb(p, error, ph, 0.0, -vz, vy, sample[_GRAVITY] / norm - vx, variance)
    absorb(p, error, ph, vz, 0.0, -vx, sample[_GRAVITY + 1] / norm - vy, variance)
    absorb(p, error, ph, -vy, vx, 0.0, sample[_GRAVITY + 2] / norm - vz, variance)
    inject(q, bias, s, error)
    if sample[_HAS_FIELD] == 0.0:
        return
    if not counters[s, _HEADING_KNOWN]:
        set_heading(s, q, sample, counters)
    w, x, y, z = q[s, 0], q[s, 1], q[s, 2], q[s, 3]
    north, east, _ = rotate(w, x, y, z, sample[_FIELD], sample[_FIELD + 1], sample[_FIELD + 2])
    innovation = -math.atan2(east, north)
    variance = settings[HEADING_VARIANCE]
    if abs(sample[_FIELD_NORM] - 1.0) > settings[_FIELD_TOLERANCE]:
        variance *= settings[FIELD_PENALTY]
    vx, vy, vz = rotate_back(w, x, y, z, 0.0, 0.0, 1.0)
    absorb(p, error, ph, vx, vy, vz, innovation, variance)
    inject(q, bias, s, error)


@kernel("float64(float64[:, ::1], float64, float64, float64)")
def quadratic(p: Float, x: float, y: float, z: float) -> float:
    """Return v' P v over the attitude block."""
    diagonal = x * x * p[0, 0] + y * y * p[1, 1] + z * z * p[2, 2]
    return float(diagonal + 2.0 * (x * y * p[0, 1] + x * z * p[0, 2] + y * z * p[1, 2]))


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
    """Filter K ticks of S sensors; states `q`, `bias`, `covariance` (S, 6, 6) and counts are carried on."""
    sample = np.zeros(_SAMPLE)
    work = np.zeros((11, 6))
    for s in range(quality.shape[0]):
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
                covariance[s, :3, :] = 0.0
                covariance[s, :, :3] = 0.0
                variance = start_variance(s, memory, counters, settings)
                for i in range(3):
                    covariance[s, i, i] = variance
            elif action != _HOLD:
                predict(q, bias, covariance, s, sample, settings, work)
                if action == _FILTER:
                    correct(q, bias, covariance, s, sample, settings, counters, work)
            w, x, y, z = q[s, 0], q[s, 1], q[s, 2], q[s, 3]
            # Rows of R_US: the axes of U in the sensor frame.
            nx, ny, nz = rotate_back(w, x, y, z, 1.0, 0.0, 0.0)
            ex, ey, ez = rotate_back(w, x, y, z, 0.0, 1.0, 0.0)
            dx, dy, dz = rotate_back(w, x, y, z, 0.0, 0.0, 1.0)
            p = covariance[s]
            store(
                s,
                k,
                action,
                0,
                quadratic(p, nx, ny, nz),
                quadratic(p, ex, ey, ez),
                quadratic(p, dx, dy, dz),
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
