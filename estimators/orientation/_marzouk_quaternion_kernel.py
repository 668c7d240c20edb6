"""The quaternion EKF of the arm-monitoring thesis (A9, corrected), compiled over sensors and ticks."""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import exponential, kernel, multiply, normalized, wrapped
from estimators.orientation import _marzouk_steps as steps
from estimators.orientation._contract import OrientationFlag
from estimators.orientation._marzouk_steps import prepare, set_heading, start_variance, store
from estimators.recording import Float

# Positions in the settings, after the shared ones; triples start at the number given.
_FIRST = steps.SHARED_SETTINGS
RATE_VARIANCE, BIAS_DRIFT, ANGLE_VARIANCE = _FIRST, _FIRST + 3, _FIRST + 6
MOTION_SCALE_G, SINGULAR_WEIGHTING = _FIRST + 9, _FIRST + 10
SETTINGS = _FIRST + 11

# Numba freezes globals, not attributes of modules.
_HOLD, _BEGIN, _FILTER = steps.HOLD, steps.BEGIN, steps.FILTER
_RATE, _GRAVITY, _FIELD, _SAMPLE = steps.RATE, steps.GRAVITY, steps.FIELD, steps.SAMPLE
_GRAVITY_NORM, _HAS_FIELD, _GAP_VARIANCE = steps.GRAVITY_NORM, steps.HAS_FIELD, steps.GAP_VARIANCE
_STEP_S, _HEADING_KNOWN = steps.STEP_S, steps.HEADING_KNOWN
_SINGULAR = int(OrientationFlag.SINGULAR)
_GUARD = 1e-6
_SINGULAR_SINE = math.sin(math.radians(85.0))
_STEEP = 0.25
"""Squared cosine of the pitch (60 degrees) from which roll and yaw measurements lose weight."""


@kernel(
    "void(float64[:, ::1], float64[:, ::1], float64[:, :, ::1], int64, float64[::1], float64[::1],"
    "float64[:, ::1])"
)
def predict(
    q: Float, bias: Float, covariance: Float, s: int, sample: Float, settings: Float, work: Float
) -> None:
    """Turn by the rate and carry the covariance, Phi P Phi' + Ts Qc (A9.1 to A9.3)."""
    p = covariance[s]
    step = settings[_STEP_S]
    w, x, y, z = q[s, 0], q[s, 1], q[s, 2], q[s, 3]
    rx = (sample[_RATE] - bias[s, 0]) * step
    ry = (sample[_RATE + 1] - bias[s, 1]) * step
    rz = (sample[_RATE + 2] - bias[s, 2]) * step
    # Upper left block of Phi: a + (r x) structure; Omega^2 = -|u|^2 I.
    a = 1.0 - (rx * rx + ry * ry + rz * rz) / 8.0
    hx, hy, hz = 0.5 * rx, 0.5 * ry, 0.5 * rz
    phi, xi = work[0:4], work[4:8]
    phi[0, 0], phi[0, 1], phi[0, 2], phi[0, 3] = a, -hx, -hy, -hz
    phi[1, 0], phi[1, 1], phi[1, 2], phi[1, 3] = hx, a, hz, -hy
    phi[2, 0], phi[2, 1], phi[2, 2], phi[2, 3] = hy, -hz, a, hx
    phi[3, 0], phi[3, 1], phi[3, 2], phi[3, 3] = hz, hy, -hx, a
    xi[0, 0], xi[0, 1], xi[0, 2] = -x, -y, -z
    xi[1, 0], xi[1, 1], xi[1, 2] = w, -z, y
    xi[2, 0], xi[2, 1], xi[2, 2] = z, w, -x
    xi[3, 0], xi[3, 1], xi[3, 2] = -y, x, w
    # Upper right block: -Ts/2 (I + Ts/4 Omega) Xi.
    right = work[8:12]
    for c in range(3):
        v0, v1, v2, v3 = xi[0, c], xi[1, c], xi[2, c], xi[3, c]
        right[0, c] = -0.5 * step * (v0 + 0.5 * (-hx * v1 - hy * v2 - hz * v3))
        right[1, c] = -0.5 * step * (v1 + 0.5 * (hx * v0 + hz * v2 - hy * v3))
        right[2, c] = -0.5 * step * (v2 + 0.5 * (hy * v0 - hz * v1 + hx * v3))
        right[3, c] = -0.5 * step * (v3 + 0.5 * (hz * v0 + hy * v1 - hx * v2))
    left, cross = work[12:16], work[16:20]
    for i in range(4):
        for j in range(4):
            left[i, j] = (
                phi[i, 0] * p[0, j] + phi[i, 1] * p[1, j] + phi[i, 2] * p[2, j] + phi[i, 3] * p[3, j]
            ) + (right[i, 0] * p[4, j] + right[i, 1] * p[5, j] + right[i, 2] * p[6, j])
        for j in range(3):
            cross[i, j] = (
                phi[i, 0] * p[0, 4 + j]
                + phi[i, 1] * p[1, 4 + j]
                + phi[i, 2] * p[2, 4 + j]
                + phi[i, 3] * p[3, 4 + j]
            ) + (right[i, 0] * p[4, 4 + j] + right[i, 1] * p[5, 4 + j] + right[i, 2] * p[6, 4 + j])
    gap = 0.25 * sample[_GAP_VARIANCE]
    quarter = 0.25 * step * step
    noise_x = quarter * settings[RATE_VARIANCE] + gap
    noise_y = quarter * settings[RATE_VARIANCE + 1] + gap
    noise_z = quarter * settings[RATE_VARIANCE + 2] + gap
    for i in range(4):
        for j in range(i, 4):
            value = (
                left[i, 0] * phi[j, 0]
                + left[i, 1] * phi[j, 1]
                + left[i, 2] * phi[j, 2]
                + left[i, 3] * phi[j, 3]
            ) + (cross[i, 0] * right[j, 0] + cross[i, 1] * right[j, 1] + cross[i, 2] * right[j, 2])
            value += (
                noise_x * xi[i, 0] * xi[j, 0] + noise_y * xi[i, 1] * xi[j, 1] + noise_z * xi[i, 2] * xi[j, 2]
            )
            p[i, j] = p[j, i] = value
        for j in range(3):
            p[i, 4 + j] = p[4 + j, i] = cross[i, j]
    for axis in range(3):
        p[4 + axis, 4 + axis] += step * settings[BIAS_DRIFT + axis]
    turn = exponential(rx, ry, rz)
    turned = multiply(w, x, y, z, turn[0], turn[1], turn[2], turn[3])
    for i in range(4):
        q[s, i] = turned[i]


@kernel("UniTuple(float64, 6)(int64, float64, float64, float64, float64)")
def angle_row(
    which: int, w: float, x: float, y: float, z: float
) -> tuple[float, float, float, float, float, float]:
    """Return the angle, its row of the measurement matrix and the squared cosine of the pitch.

    `which` is 0 for roll, 1 for pitch, 2 for yaw (A7.3 and A9.4, guarded at the singularity).
    """
    c13 = 2.0 * (x * z - w * y)
    cosine_squared = 1.0 - c13 * c13
    if which == 0:
        c23, c33 = 2.0 * (y * z + w * x), w * w - x * x - y * y + z * z
        f = 2.0 / max(c23 * c23 + c33 * c33, _GUARD)
        return (
            math.atan2(c23, c33),
            f * x * c33,
            f * (w * c33 + 2.0 * x * c23),
            f * (z * c33 + 2.0 * y * c23),
            f * y * c33,
            cosine_squared,
        )
    if which == 1:
        f = 2.0 / max(math.sqrt(max(cosine_squared, 0.0)), _GUARD)
        return -math.asin(min(max(c13, -1.0), 1.0)), f * y, -f * z, f * w, -f * x, cosine_squared
    c11, c12 = w * w + x * x - y * y - z * z, 2.0 * (x * y + w * z)
    f = 2.0 / max(c11 * c11 + c12 * c12, _GUARD)
    return (
        math.atan2(c12, c11),
        f * z * c11,
        f * y * c11,
        f * (x * c11 + 2.0 * y * c12),
        f * (w * c11 + 2.0 * z * c12),
        cosine_squared,
    )


@kernel(
    "void(float64[:, ::1], float64[:, ::1], float64[:, :, ::1], int64, float64[::1], float64[::1],"
    "float64[:, ::1])"
)
def correct(
    q: Float, bias: Float, covariance: Float, s: int, sample: Float, settings: Float, work: Float
) -> None:
    """Correct by roll, pitch and tilt-compensated magnetic yaw, one after the other (A4, A5, A9.4)."""
    p = covariance[s]
    sx, sy, sz = sample[_GRAVITY], sample[_GRAVITY + 1], sample[_GRAVITY + 2]
    weight = 1.0
    if settings[MOTION_SCALE_G] > 0.0:
        weight += ((sample[_GRAVITY_NORM] - 1.0) / settings[MOTION_SCALE_G]) ** 2
    ph = work[0]
    ph_bias = work[1]
    for which in range(3):
        if which == 0:
            measured = math.atan2(sy, sz)
        elif which == 1:
            measured = math.atan2(-sx, math.sqrt(sy * sy + sz * sz))
        else:
            if sample[_HAS_FIELD] == 0.0:
                break
            mx, my, mz = sample[_FIELD], sample[_FIELD + 1], sample[_FIELD + 2]
            px, py, pz = my * sz - mz * sy, mz * sx - mx * sz, mx * sy - my * sx
            # The page's A5 lacks the norm of s; without it the yaw is wrong whenever the arm is pushed.
            measured = math.atan2(-px * sample[_GRAVITY_NORM], sy * pz - sz * py)
        angle, h0, h1, h2, h3, cosine_squared = angle_row(which, q[s, 0], q[s, 1], q[s, 2], q[s, 3])
        # The rows are right along the unit sphere only. Their part along q says that the norm were measured,
        # which it is not; left in, it makes a heading without magnetometer look known.
        radial = h0 * q[s, 0] + h1 * q[s, 1] + h2 * q[s, 2] + h3 * q[s, 3]
        h0, h1, h2, h3 = (
            h0 - radial * q[s, 0],
            h1 - radial * q[s, 1],
            h2 - radial * q[s, 2],
            h3 - radial * q[s, 3],
        )
        variance = weight * settings[ANGLE_VARIANCE + which]
        if which != 1 and settings[SINGULAR_WEIGHTING] > 0.0:
            # Roll and yaw of a nearly vertical x axis are as noisy as one over the cosine of the pitch.
            variance *= max(1.0, _STEEP / max(cosine_squared, _GUARD))
        for i in range(4):
            ph[i] = h0 * p[i, 0] + h1 * p[i, 1] + h2 * p[i, 2] + h3 * p[i, 3]
        for i in range(3):
            ph_bias[i] = h0 * p[4 + i, 0] + h1 * p[4 + i, 1] + h2 * p[4 + i, 2] + h3 * p[4 + i, 3]
        inverse = 1.0 / (h0 * ph[0] + h1 * ph[1] + h2 * ph[2] + h3 * ph[3] + variance)
        step = inverse * wrapped(measured - angle)
        w, x, y, z = normalized(
            q[s, 0] + ph[0] * step, q[s, 1] + ph[1] * step, q[s, 2] + ph[2] * step, q[s, 3] + ph[3] * step
        )
        q[s, 0], q[s, 1], q[s, 2], q[s, 3] = w, x, y, z
        for i in range(3):
            bias[s, i] += ph_bias[i] * step
        # K H P = (P h)(P h)' / S is symmetric to the last bit.
        for i in range(4):
            for j in range(4):
                p[i, j] -= inverse * (ph[i] * ph[j])
            for j in range(3):
                change = inverse * (ph[i] * ph_bias[j])
                p[i, 4 + j] -= change
                p[4 + j, i] -= change
        for i in range(3):
            for j in range(3):
                p[4 + i, 4 + j] -= inverse * (ph_bias[i] * ph_bias[j])


@kernel("float64(float64[:, ::1], float64, float64, float64, float64)")
def quadratic(p: Float, g0: float, g1: float, g2: float, g3: float) -> float:
    """Return g' P g over the quaternion block."""
    first = g0 * (g0 * p[0, 0] + 2.0 * (g1 * p[0, 1] + g2 * p[0, 2] + g3 * p[0, 3]))
    second = g1 * (g1 * p[1, 1] + 2.0 * (g2 * p[1, 2] + g3 * p[1, 3]))
    return float(first + second + g2 * (g2 * p[2, 2] + 2.0 * g3 * p[2, 3]) + g3 * g3 * p[3, 3])


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
    """Filter K ticks of S sensors; states `q`, `bias`, `covariance` (S, 7, 7) and counts are carried on."""
    sample = np.zeros(_SAMPLE)
    work = np.zeros((20, 4))
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
                covariance[s, :4, :] = 0.0
                covariance[s, :, :4] = 0.0
                # A turn by d moves the quaternion by d/2.
                variance = 0.25 * start_variance(s, memory, counters, settings)
                for i in range(4):
                    covariance[s, i, i] = variance
            elif action != _HOLD:
                predict(q, bias, covariance, s, sample, settings, work)
                if action == _FILTER:
                    if sample[_HAS_FIELD] > 0.0 and not counters[s, _HEADING_KNOWN]:
                        set_heading(s, q, sample, counters)
                    correct(q, bias, covariance, s, sample, settings, work)
            w, x, y, z = q[s, 0], q[s, 1], q[s, 2], q[s, 3]
            own = _SINGULAR if abs(2.0 * (x * z - w * y)) > _SINGULAR_SINE else 0
            # Rotation error in U: twice the vector part of dq * conj(q).
            p = covariance[s]
            store(
                s,
                k,
                action,
                own,
                4.0 * quadratic(p, -x, w, -z, y),
                4.0 * quadratic(p, -y, z, w, -x),
                4.0 * quadratic(p, -z, -y, x, w),
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
