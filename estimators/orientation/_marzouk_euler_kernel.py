"""The Euler-angle EKF of the arm-monitoring thesis (A8, corrected), compiled over sensors and ticks."""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import Scalars3, Scalars4, kernel, wrapped
from estimators.orientation import _marzouk_steps as steps
from estimators.orientation._contract import OrientationFlag
from estimators.orientation._marzouk_steps import prepare, set_heading, start_variance, store
from estimators.recording import Float

# Positions in the settings, after the shared ones; triples start at the number given.
_FIRST = steps.SHARED_SETTINGS
ANGLE_DRIFT, BIAS_DRIFT, ANGLE_VARIANCE, MOTION_SCALE_G = _FIRST, _FIRST + 3, _FIRST + 6, _FIRST + 9
SETTINGS = _FIRST + 10

ANGLES = steps.MEMORY
"""Roll, pitch and yaw follow the shared columns of the memory."""
MEMORY = ANGLES + 3

# Numba freezes globals, not attributes of modules.
_ANGLES = ANGLES
_HOLD, _BEGIN, _FILTER = steps.HOLD, steps.BEGIN, steps.FILTER
_RATE, _GRAVITY, _FIELD, _SAMPLE = steps.RATE, steps.GRAVITY, steps.FIELD, steps.SAMPLE
_GRAVITY_NORM, _HAS_FIELD, _GAP_VARIANCE = steps.GRAVITY_NORM, steps.HAS_FIELD, steps.GAP_VARIANCE
_STEP_S, _HEADING_KNOWN = steps.STEP_S, steps.HEADING_KNOWN
_SINGULAR = int(OrientationFlag.SINGULAR | OrientationFlag.HEADING_NOT_TRUSTED)
_STEEPEST = math.radians(85.0)
_UNKNOWN = math.pi * math.pi / 3.0
"""Variance of an angle that may be anything."""


@kernel("UniTuple(float64, 4)(float64, float64, float64)")
def quaternion(roll: float, pitch: float, yaw: float) -> Scalars4:
    """Return q_U_sensor of Rz(yaw) Ry(pitch) Rx(roll) (A7.1)."""
    cr, sr = math.cos(0.5 * roll), math.sin(0.5 * roll)
    cp, sp = math.cos(0.5 * pitch), math.sin(0.5 * pitch)
    cy, sy = math.cos(0.5 * yaw), math.sin(0.5 * yaw)
    return (
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    )


@kernel("UniTuple(float64, 3)(float64, float64, float64, float64)")
def euler(w: float, x: float, y: float, z: float) -> Scalars3:
    """Return roll, pitch and yaw of a unit quaternion (A7.2, A7.3)."""
    c13 = 2.0 * (x * z - w * y)
    return (
        math.atan2(2.0 * (y * z + w * x), w * w - x * x - y * y + z * z),
        -math.asin(min(max(c13, -1.0), 1.0)),
        math.atan2(2.0 * (x * y + w * z), w * w + x * x - y * y - z * z),
    )


@kernel("void(float64[::1], float64[:, ::1], int64, float64[:, ::1], float64[::1], float64[::1])")
def predict(e: Float, bias: Float, s: int, p: Float, sample: Float, settings: Float) -> None:
    """Carry the angles by the rate and the covariance by I + Ts A (A8.1 to A8.4).

    The page's P + Ts (A P + P A' + Qc) is kept positive by the term Ts^2 A P A' of the second order.
    Beyond 85 degrees of pitch, where roll and yaw are held, they are unknown.
    """
    step = settings[_STEP_S]
    ux, uy, uz = sample[_RATE] - bias[s, 0], sample[_RATE + 1] - bias[s, 1], sample[_RATE + 2] - bias[s, 2]
    cr, sr = math.cos(e[0]), math.sin(e[0])
    gap = sample[_GAP_VARIANCE]
    if abs(e[1]) > _STEEPEST:
        for i in range(0, 3, 2):
            for j in range(6):
                p[i, j] = p[j, i] = 0.0
            p[i, i] = _UNKNOWN
        e[1] += step * (uy * cr - uz * sr)
        # Which axis pitches is unknown with the roll.
        p[1, 1] += step * (settings[ANGLE_DRIFT + 1] + step * (uy * uy + uz * uz)) + gap
    else:
        cp, sp = math.cos(e[1]), math.sin(e[1])
        tangent, secant = sp / cp, 1.0 / cp
        across, along = uy * sr + uz * cr, uy * cr - uz * sr
        w01, w02 = step * sr * tangent, step * cr * tangent
        w11, w12 = step * cr, -step * sr
        w21, w22 = step * sr * secant, step * cr * secant
        f00, f01 = 1.0 + step * tangent * along, step * across * secant * secant
        f10 = -step * across
        f20, f21 = step * along * secant, step * across * tangent * secant
        e[0] += step * ux + w01 * uy + w02 * uz
        e[1] += step * along
        e[2] += w21 * uy + w22 * uz
        # Columns of F P, the last three first: they are the new covariance of angles and bias.
        for j in range(3, 6):
            a, b, c = p[0, j], p[1, j], p[2, j]
            bx, by, bz = p[3, j], p[4, j], p[5, j]
            p[0, j] = f00 * a + f01 * b - step * bx - w01 * by - w02 * bz
            p[1, j] = f10 * a + b - w11 * by - w12 * bz
            p[2, j] = f20 * a + f21 * b + c - w21 * by - w22 * bz
        # Then rows of the angle block: (F_angles P_angles - W P_bias,angles) F' with the old cross terms.
        p00, p01, p02, p11, p12, p22 = p[0, 0], p[0, 1], p[0, 2], p[1, 1], p[1, 2], p[2, 2]
        k00 = f00 * p00 + f01 * p01 - step * p[3, 0] - w01 * p[4, 0] - w02 * p[5, 0]
        k01 = f00 * p01 + f01 * p11 - step * p[3, 1] - w01 * p[4, 1] - w02 * p[5, 1]
        k02 = f00 * p02 + f01 * p12 - step * p[3, 2] - w01 * p[4, 2] - w02 * p[5, 2]
        k10 = f10 * p00 + p01 - w11 * p[4, 0] - w12 * p[5, 0]
        k11 = f10 * p01 + p11 - w11 * p[4, 1] - w12 * p[5, 1]
        k12 = f10 * p02 + p12 - w11 * p[4, 2] - w12 * p[5, 2]
        k20 = f20 * p00 + f21 * p01 + p02 - w21 * p[4, 0] - w22 * p[5, 0]
        k21 = f20 * p01 + f21 * p11 + p12 - w21 * p[4, 1] - w22 * p[5, 1]
        k22 = f20 * p02 + f21 * p12 + p22 - w21 * p[4, 2] - w22 * p[5, 2]
        drift = (
            step * settings[ANGLE_DRIFT],
            step * settings[ANGLE_DRIFT + 1],
            step * settings[ANGLE_DRIFT + 2],
        )
        p[0, 0] = f00 * k00 + f01 * k01 - step * p[0, 3] - w01 * p[0, 4] - w02 * p[0, 5] + drift[0] + gap
        p[0, 1] = p[1, 0] = f10 * k00 + k01 - w11 * p[0, 4] - w12 * p[0, 5]
        p[0, 2] = p[2, 0] = f20 * k00 + f21 * k01 + k02 - w21 * p[0, 4] - w22 * p[0, 5]
        p[1, 1] = f10 * k10 + k11 - w11 * p[1, 4] - w12 * p[1, 5] + drift[1] + gap
        p[1, 2] = p[2, 1] = f20 * k10 + f21 * k11 + k12 - w21 * p[1, 4] - w22 * p[1, 5]
        p[2, 2] = f20 * k20 + f21 * k21 + k22 - w21 * p[2, 4] - w22 * p[2, 5] + drift[2]
        p[2, 2] += gap * secant * secant
        for j in range(3, 6):
            p[j, 0], p[j, 1], p[j, 2] = p[0, j], p[1, j], p[2, j]
    for axis in range(3):
        p[3 + axis, 3 + axis] += step * settings[BIAS_DRIFT + axis]


@kernel("void(float64[:, ::1], float64[::1], int64, float64, float64)")
def absorb(p: Float, error: Float, i: int, innovation: float, variance: float) -> None:
    """Take the measurement of the angle `i` into `error` (6) and `p` (6, 6)."""
    h0, h1, h2, h3, h4, h5 = p[i, 0], p[i, 1], p[i, 2], p[i, 3], p[i, 4], p[i, 5]
    inverse = 1.0 / (p[i, i] + variance)
    step = inverse * (innovation - error[i])
    error[0] += h0 * step
    error[1] += h1 * step
    error[2] += h2 * step
    error[3] += h3 * step
    error[4] += h4 * step
    error[5] += h5 * step
    for j, h in enumerate((h0, h1, h2, h3, h4, h5)):
        # This order of products keeps the last bits symmetric.
        p[j, 0] -= inverse * (h * h0)
        p[j, 1] -= inverse * (h * h1)
        p[j, 2] -= inverse * (h * h2)
        p[j, 3] -= inverse * (h * h3)
        p[j, 4] -= inverse * (h * h4)
        p[j, 5] -= inverse * (h * h5)


@kernel(
    "void(float64[::1], float64[:, ::1], int64, float64[:, ::1], float64[::1], float64[::1], float64[::1])"
)
def correct(e: Float, bias: Float, s: int, p: Float, sample: Float, settings: Float, error: Float) -> None:
    """Correct by measured roll, pitch and tilt-compensated magnetic yaw (A4, A5, A8.5)."""
    sx, sy, sz = sample[_GRAVITY], sample[_GRAVITY + 1], sample[_GRAVITY + 2]
    weight = 1.0
    if settings[MOTION_SCALE_G] > 0.0:
        weight += ((sample[_GRAVITY_NORM] - 1.0) / settings[MOTION_SCALE_G]) ** 2
    for i in range(6):
        error[i] = 0.0
    held = abs(e[1]) > _STEEPEST
    across = sy * sy + sz * sz
    if not held:
        absorb(p, error, 0, wrapped(math.atan2(sy, sz) - e[0]), weight * settings[ANGLE_VARIANCE])
    absorb(p, error, 1, math.atan2(-sx, math.sqrt(across)) - e[1], weight * settings[ANGLE_VARIANCE + 1])
    if sample[_HAS_FIELD] > 0.0 and not held:
        mx, my, mz = sample[_FIELD], sample[_FIELD + 1], sample[_FIELD + 2]
        # P = m x s; the page's A5 lacks the norm of s.
        px, py, pz = my * sz - mz * sy, mz * sx - mx * sz, mx * sy - my * sx
        yaw = math.atan2(-px * sample[_GRAVITY_NORM], sy * pz - sz * py)
        absorb(p, error, 2, wrapped(yaw - e[2]), weight * settings[ANGLE_VARIANCE + 2])
    for i in range(3):
        e[i] += error[i]
        bias[s, i] += error[3 + i]


@kernel("void(float64[::1])")
def wrap(e: Float) -> None:
    """Bring the angles to their intervals; beyond the pole roll and yaw are half a turn further."""
    e[1] = wrapped(e[1])
    if abs(e[1]) > 0.5 * math.pi:
        e[1] = math.copysign(math.pi, e[1]) - e[1]
        e[0] += math.pi
        e[2] += math.pi
    e[0], e[2] = wrapped(e[0]), wrapped(e[2])


@kernel("UniTuple(float64, 3)(float64[::1], float64[:, ::1])")
def variances(e: Float, p: Float) -> Scalars3:
    """Return the variance of the rotation error about north, east and down.

    A small change of the angles turns by d_roll Rz Ry e_x + d_pitch Rz e_y + d_yaw e_z.
    """
    cp, sp, cy, sy = math.cos(e[1]), math.sin(e[1]), math.cos(e[2]), math.sin(e[2])
    n0, n1, d0 = cy * cp, sy * cp, -sp
    north = n0 * n0 * p[0, 0] - 2.0 * n0 * sy * p[0, 1] + sy * sy * p[1, 1]
    east = n1 * n1 * p[0, 0] + 2.0 * n1 * cy * p[0, 1] + cy * cy * p[1, 1]
    down = d0 * d0 * p[0, 0] + 2.0 * d0 * p[0, 2] + p[2, 2]
    return north, east, down


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
    """Filter K ticks of S sensors; `q`, `bias`, `covariance` (S, 6, 6), angles and counts are carried on."""
    sample = np.zeros(_SAMPLE)
    error = np.zeros(6)
    for s in range(quality.shape[0]):
        p = covariance[s]
        e = memory[s, _ANGLES:]
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
                e[0], e[1], e[2] = euler(q[s, 0], q[s, 1], q[s, 2], q[s, 3])
                variance = start_variance(s, memory, counters, settings)
                for i in range(3):
                    for j in range(6):
                        p[i, j] = p[j, i] = 0.0
                    p[i, i] = variance
            elif action != _HOLD:
                predict(e, bias, s, p, sample, settings)
                if action == _FILTER:
                    if sample[_HAS_FIELD] > 0.0 and not counters[s, _HEADING_KNOWN]:
                        q[s, 0], q[s, 1], q[s, 2], q[s, 3] = quaternion(e[0], e[1], e[2])
                        set_heading(s, q, sample, counters)
                        e[0], e[1], e[2] = euler(q[s, 0], q[s, 1], q[s, 2], q[s, 3])
                    correct(e, bias, s, p, sample, settings, error)
                wrap(e)
                q[s, 0], q[s, 1], q[s, 2], q[s, 3] = quaternion(e[0], e[1], e[2])
            north, east, down = variances(e, p)
            store(
                s,
                k,
                action,
                _SINGULAR if abs(e[1]) > _STEEPEST else 0,
                north,
                east,
                down,
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


__all__ = ["MEMORY", "SETTINGS", "run"]
