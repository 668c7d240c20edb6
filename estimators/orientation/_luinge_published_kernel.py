"""Luinge and Veltink's filter in its published structure, signs and dimensions corrected (A4), compiled.

Kept for parity with earlier work: the error lives in the sensor frame without being turned with it (E-5),
only the diagonal blocks of the covariance are carried (E-6), and the predicted acceleration is taken for
independent of the orientation (E-7). The consistent form is in `_luinge_kernel`.
"""

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import Scalars3, kernel, multiply, rotate_back
from estimators.orientation import _strapdown_steps as steps
from estimators.orientation._contract import OrientationFlag
from estimators.orientation._strapdown_kernel import begin, turn_by_rate
from estimators.orientation._strapdown_steps import (
    force_without_acceleration,
    keep_acceleration,
    prepare,
    store,
    tell,
    turn,
)
from estimators.recording import Float

# Numba freezes globals, not attributes of modules.
_HOLD, _BEGIN, _FILTER = steps.HOLD, steps.BEGIN, steps.FILTER
_FORCE, _SAMPLE = steps.FORCE, steps.SAMPLE
_GAP_VARIANCE, _INNOVATION = steps.GAP_VARIANCE, steps.INNOVATION
_STEP_S, _RATE_VARIANCE, _BIAS_VARIANCE = steps.STEP_S, steps.RATE_VARIANCE, steps.BIAS_VARIANCE
_ACCELERATION_GAIN, _GRAVITY, _UNKNOWN = steps.ACCELERATION_GAIN, steps.GRAVITY, steps.UNKNOWN
_NO_HEADING = int(OrientationFlag.HEADING_NOT_TRUSTED)

# Positions in the settings after the shared ones and those of the consistent form.
FORCE_VARIANCE, CHANGE_VARIANCE = steps.SHARED_SETTINGS + 4, steps.SHARED_SETTINGS + 5
SETTINGS = steps.SHARED_SETTINGS + 6

SPREAD = steps.MEMORY
"""Columns of the memory with Q_a, the covariance of the acceleration: xx xy xz yy yz zz, sensor frame."""


@kernel("void(float64, float64, float64, float64[:, ::1])")
def skew(x: float, y: float, z: float, out: Float) -> None:
    """Write the cross-product matrix of a vector."""
    out[0, 0] = out[1, 1] = out[2, 2] = 0.0
    out[0, 1], out[0, 2], out[1, 2] = -z, y, -x
    out[1, 0], out[2, 0], out[2, 1] = z, -y, x


@kernel("void(float64[:, ::1], float64[:, ::1])")
def invert(m: Float, out: Float) -> None:
    """Write the inverse of a symmetric 3 x 3 matrix."""
    a, b, c, d, e, f = m[0, 0], m[0, 1], m[0, 2], m[1, 1], m[1, 2], m[2, 2]
    c00, c01, c02 = d * f - e * e, c * e - b * f, b * e - c * d
    scale = 1.0 / (a * c00 + b * c01 + c * c02)
    out[0, 0], out[0, 1], out[0, 2] = scale * c00, scale * c01, scale * c02
    out[1, 1], out[1, 2], out[2, 2] = (
        scale * (a * f - c * c),
        scale * (b * c - a * e),
        scale * (a * d - b * b),
    )
    out[1, 0], out[2, 0], out[2, 1] = out[0, 1], out[0, 2], out[1, 2]


@kernel("void(float64[:, ::1], float64[::1], float64[::1])")
def predict_blocks(p: Float, sample: Float, settings: Float) -> None:
    """Block covariances of A4.5, from the diagonal blocks of the last step alone."""
    step = settings[_STEP_S]
    noise = settings[_RATE_VARIANCE] * step * step + sample[_GAP_VARIANCE]
    for i in range(3):
        for j in range(3):
            offset = p[3 + i, 3 + j]
            p[i, j] += step * step * offset
            p[i, 3 + j] = p[3 + j, i] = -step * offset
    for i in range(3):
        p[i, i] += noise
        p[3 + i, 3 + i] += settings[_BIAS_VARIANCE]


@kernel("void(int64, float64[:, ::1], float64[:, ::1], float64[:, ::1], float64[::1], float64[:, :, ::1])")
def keep_spread(s: int, q: Float, p: Float, memory: Float, settings: Float, work: Float) -> None:
    """Keep Q_a = g^2 [Z x] Q_theta [Z x]' + sigma_A^2 I of the acceleration just measured (A4.9)."""
    gravity = settings[_GRAVITY]
    vx, vy, vz = rotate_back(q[s, 0], q[s, 1], q[s, 2], q[s, 3], 0.0, 0.0, gravity)
    cross = work[0]
    skew(vx, vy, vz, cross)
    column = 0
    for i in range(3):
        for j in range(i, 3):
            total = settings[FORCE_VARIANCE] if i == j else 0.0
            for a in range(3):
                for b in range(3):
                    total += cross[i, a] * p[a, b] * cross[j, b]
            memory[s, SPREAD + column] = total
            column += 1


@kernel(
    "void(float64[:, ::1], float64[:, ::1], int64, float64[:, ::1], float64[:, ::1], float64[::1],"
    "float64[::1], float64[:, :, ::1], float64[:, ::1])"
)
def correct(
    q: Float,
    bias: Float,
    s: int,
    p: Float,
    memory: Float,
    sample: Float,
    settings: Float,
    work: Float,
    gain: Float,
) -> None:
    """Difference the two verticals in the sensor frame and take out the errors (A4.2 to A4.9)."""
    c, innovation_covariance, inverse = work[1], work[2], work[3]
    w, x, y, z = q[s, 0], q[s, 1], q[s, 2], q[s, 3]
    gravity, share = settings[_GRAVITY], settings[_ACCELERATION_GAIN]
    ex, ey, ez = force_without_acceleration(s, q, memory, sample, settings)
    ux, uy, uz = rotate_back(w, x, y, z, ex, ey, ez)
    scale = 1.0 / (ux * ux + uy * uy + uz * uz) ** 0.5
    vx, vy, vz = rotate_back(w, x, y, z, 0.0, 0.0, 1.0)
    innovation = (ux * scale - vx, uy * scale - vy, uz * scale - vz)
    # C = -[(Z + a/g) x]; predicted acceleration in the sensor frame is what was taken from the force.
    skew(
        -(vx + (sample[_FORCE] - ux) / gravity),
        -(vy + (sample[_FORCE + 1] - uy) / gravity),
        -(vz + (sample[_FORCE + 2] - uz) / gravity),
        c,
    )
    for i in range(3):
        for j in range(6):
            gain[j, i] = c[i, 0] * p[0, j] + c[i, 1] * p[1, j] + c[i, 2] * p[2, j]
    # S = C P C' + (c_a^2 Q_a + (sigma_w^2 + sigma_A^2) I) / g^2
    white = (settings[CHANGE_VARIANCE] + settings[FORCE_VARIANCE]) / gravity**2
    column = 0
    for i in range(3):
        for j in range(i, 3):
            value = gain[0, i] * c[j, 0] + gain[1, i] * c[j, 1] + gain[2, i] * c[j, 2]
            value += share * share * memory[s, SPREAD + column] / gravity**2
            if i == j:
                value += white
            innovation_covariance[i, j] = innovation_covariance[j, i] = value
            column += 1
    invert(innovation_covariance, inverse)
    for i in range(3):
        sample[_INNOVATION + 2 * i] = innovation[i]
        sample[_INNOVATION + 2 * i + 1] = 1.0 / innovation_covariance[i, i]
    error = work[4]
    for a in range(6):
        total = 0.0
        for i in range(3):
            for j in range(3):
                total += gain[a, i] * inverse[i, j] * innovation[j]
        error[a // 3, a % 3] = total
        for b in range(a, 6):
            total = 0.0
            for i in range(3):
                for j in range(3):
                    total += gain[a, i] * inverse[i, j] * gain[b, j]
            p[a, b] -= total
            p[b, a] = p[a, b]
    tw, tx, ty, tz = turn(-error[0, 0], -error[0, 1], -error[0, 2])
    q[s, 0], q[s, 1], q[s, 2], q[s, 3] = multiply(w, x, y, z, tw, tx, ty, tz)
    for axis in range(3):
        bias[s, axis] -= error[1, axis]
    keep_acceleration(s, q, memory, sample, settings)
    keep_spread(s, q, p, memory, settings, work)


@kernel("float64(float64[:, ::1], UniTuple(float64, 3))")
def quadratic(p: Float, v: Scalars3) -> float:
    """Return v' P v over the attitude block."""
    total = 0.0
    for i in range(3):
        for j in range(3):
            total += v[i] * p[i, j] * v[j]
    return total


@kernel("void(int64, float64[:, ::1], float64[:, ::1], float64[:, ::1])")
def see(s: int, q: Float, p: Float, seen: Float) -> None:
    """Write the variances of the orientation error about the earth axes, the diagonal of R P R'.

    As the error is not turned with the sensor, its covariance takes tilt for heading and claims to know where
    the sensor faces: unknown is told instead.
    """
    w, x, y, z = q[s, 0], q[s, 1], q[s, 2], q[s, 3]
    # The earth axes in the sensor frame are the rows of R.
    seen[0, 0] = quadratic(p, rotate_back(w, x, y, z, 1.0, 0.0, 0.0))
    seen[1, 1] = quadratic(p, rotate_back(w, x, y, z, 0.0, 1.0, 0.0))
    seen[2, 2] = _UNKNOWN


@kernel(
    "void(float64[:, :, ::1], float64[:, :, ::1], float64[:, :, ::1], uint8[:, ::1], float64[::1],"
    "float64[:, ::1], float64[:, ::1], float64[:, :, ::1], float64[:, ::1], int64[:, ::1],"
    "float64[:, :, ::1], float64[:, :, ::1], float64[:, :, ::1], uint8[:, ::1], float64[:, :, ::1])"
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
    details: Float,
) -> None:
    """Filter K ticks of S sensors; `q`, `bias`, `covariance` (S, 6, 6, sensor frame) and more are carried on."""
    sample = np.zeros(_SAMPLE)
    work, gain, seen = np.zeros((5, 3, 3)), np.zeros((6, 3)), np.zeros((6, 6))
    for s in range(quality.shape[0]):
        p = covariance[s]
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
                begin(s, p, memory, counters, settings)
                # This covariance is in the sensor frame.
                p[2, 2] = p[0, 0]
                for column in range(6):
                    diagonal = column == 0 or column == 3 or column == 5
                    memory[s, SPREAD + column] = settings[FORCE_VARIANCE] if diagonal else 0.0
            elif action != _HOLD:
                turn_by_rate(q, bias, s, sample, settings)
                predict_blocks(p, sample, settings)
                if action == _FILTER:
                    correct(q, bias, s, p, memory, sample, settings, work, gain)
            see(s, q, p, seen)
            store(
                s,
                k,
                action,
                _NO_HEADING,
                quality,
                settings,
                q,
                bias,
                seen,
                counters,
                sample,
                q_earth_sensor,
                bias_out,
                sigma_rad,
                flags,
            )
            if details.shape[0] > 0:
                tell(s, k, 3, action, memory, sample, details)


__all__ = ["CHANGE_VARIANCE", "FORCE_VARIANCE", "SETTINGS", "run"]
