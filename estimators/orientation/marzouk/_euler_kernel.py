"""The Euler-angle EKF of the arm-monitoring thesis (A8, corrected), compiled over sensors and ticks."""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import kernel, wrapped
from estimators.kernels import mirror
from estimators.orientation._contract import OrientationFlag
from estimators.orientation.marzouk import _steps as steps
from estimators.orientation.marzouk._angles import (
    attitude,
    doubled,
    euler,
    halves,
    moved,
    quaternion,
    variances,
    wrap,
)
from estimators.orientation.marzouk._covariance import ERRORS, UPPER, Errors, Upper, keep, lessened, loaded
from estimators.orientation.marzouk._steps import direction, prepare, set_heading, start_variance, store
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
_BOTH = f"Tuple(({UPPER}, {ERRORS}))"


@kernel(
    f"{_BOTH}({UPPER}, float64[::1], float64[:, ::1], int64, {ERRORS}, float64[::1], float64[::1])",
    inlined=True,
)
def predict(
    p: Upper, e: Float, bias: Float, s: int, half: Errors, sample: Float, settings: Float
) -> tuple[Upper, Errors]:
    """Carry the angles by the rate and the covariance by I + Ts A (A8.1 to A8.4); also return sines and cosines.

    The page's P + Ts (A P + P A' + Qc) is kept positive by the term Ts^2 A P A' of the second order.
    Beyond 85 degrees of pitch, where roll and yaw are held, they are unknown.
    """
    step = settings[_STEP_S]
    ux, uy, uz = sample[_RATE] - bias[s, 0], sample[_RATE + 1] - bias[s, 1], sample[_RATE + 2] - bias[s, 2]
    sr, cr, sp, cp, sy, cy = doubled(half)
    gap = sample[_GAP_VARIANCE]
    drift = (step * settings[BIAS_DRIFT], step * settings[BIAS_DRIFT + 1], step * settings[BIAS_DRIFT + 2])
    a00, a01, a02, a11, a12, a22 = p[:6]
    c00, c01, c02, c10, c11, c12, c20, c21, c22 = p[6:15]
    b00, b01, b02, b11, b12, b22 = p[15:]
    along = uy * cr - uz * sr
    if abs(e[1]) > _STEEPEST:
        by = step * along
        e[1] += by
        sp, cp = moved(sp, cp, by)
        # Which axis pitches is unknown with the roll.
        grown = a11 + step * (settings[ANGLE_DRIFT + 1] + step * (uy * uy + uz * uz)) + gap
        upper = (
            _UNKNOWN,
            0.0,
            0.0,
            grown,
            0.0,
            _UNKNOWN,
            0.0,
            0.0,
            0.0,
            c10,
            c11,
            c12,
            0.0,
            0.0,
            0.0,
            b00 + drift[0],
            b01,
            b02,
            b11 + drift[1],
            b12,
            b22 + drift[2],
        )
        return upper, (sr, cr, sp, cp, sy, cy)
    secant = 1.0 / cp
    tangent = sp * secant
    across = uy * sr + uz * cr
    w01, w02 = step * sr * tangent, step * cr * tangent
    w11, w12 = step * cr, -step * sr
    w21, w22 = step * sr * secant, step * cr * secant
    f00, f01 = 1.0 + step * tangent * along, step * across * secant * secant
    f10 = -step * across
    f20, f21 = step * along * secant, step * across * tangent * secant
    roll, pitch, yaw = step * ux + w01 * uy + w02 * uz, step * along, w21 * uy + w22 * uz
    e[0] += roll
    e[1] += pitch
    e[2] += yaw
    sr, cr = moved(sr, cr, roll)
    sp, cp = moved(sp, cp, pitch)
    sy, cy = moved(sy, cy, yaw)
    # G = F C of the angles alone, then N = G - W B: the new cross terms.
    g00, g01, g02 = f00 * c00 + f01 * c10, f00 * c01 + f01 * c11, f00 * c02 + f01 * c12
    g10, g11, g12 = f10 * c00 + c10, f10 * c01 + c11, f10 * c02 + c12
    g20 = f20 * c00 + f21 * c10 + c20
    g21 = f20 * c01 + f21 * c11 + c21
    g22 = f20 * c02 + f21 * c12 + c22
    n00 = g00 - (step * b00 + w01 * b01 + w02 * b02)
    n01 = g01 - (step * b01 + w01 * b11 + w02 * b12)
    n02 = g02 - (step * b02 + w01 * b12 + w02 * b22)
    n10 = g10 - (w11 * b01 + w12 * b02)
    n11 = g11 - (w11 * b11 + w12 * b12)
    n12 = g12 - (w11 * b12 + w12 * b22)
    n20 = g20 - (w21 * b01 + w22 * b02)
    n21 = g21 - (w21 * b11 + w22 * b12)
    n22 = g22 - (w21 * b12 + w22 * b22)
    # F A F' - N W' - W G'.
    k00, k01 = f00 * a00 + f01 * a01, f00 * a01 + f01 * a11
    k02 = f00 * a02 + f01 * a12
    k10, k11, k12 = f10 * a00 + a01, f10 * a01 + a11, f10 * a02 + a12
    k20 = f20 * a00 + f21 * a01 + a02
    k21 = f20 * a01 + f21 * a11 + a12
    k22 = f20 * a02 + f21 * a12 + a22
    upper = (
        f00 * k00
        + f01 * k01
        - (step * (n00 + g00) + w01 * (n01 + g01) + w02 * (n02 + g02))
        + (step * settings[ANGLE_DRIFT] + gap),
        f10 * k00 + k01 - (n01 * w11 + n02 * w12) - (step * g10 + w01 * g11 + w02 * g12),
        f20 * k00 + f21 * k01 + k02 - (n01 * w21 + n02 * w22) - (step * g20 + w01 * g21 + w02 * g22),
        f10 * k10 + k11 - (w11 * (n11 + g11) + w12 * (n12 + g12)) + (step * settings[ANGLE_DRIFT + 1] + gap),
        f20 * k10 + f21 * k11 + k12 - (n11 * w21 + n12 * w22) - (w11 * g21 + w12 * g22),
        f20 * k20
        + f21 * k21
        + k22
        - (w21 * (n21 + g21) + w22 * (n22 + g22))
        + (step * settings[ANGLE_DRIFT + 2] + gap * secant * secant),
        n00,
        n01,
        n02,
        n10,
        n11,
        n12,
        n20,
        n21,
        n22,
        b00 + drift[0],
        b01,
        b02,
        b11 + drift[1],
        b12,
        b22 + drift[2],
    )
    return upper, (sr, cr, sp, cp, sy, cy)


@kernel(f"{_BOTH}({UPPER}, {ERRORS}, {ERRORS}, float64, float64, float64)", inlined=True)
def absorb(
    p: Upper, error: Errors, h: Errors, own: float, innovation: float, variance: float
) -> tuple[Upper, Errors]:
    """Take the measurement of an angle into the error found so far; h is its column of `p`, `own` its part of both."""
    inverse = 1.0 / (own + variance)
    gain = inverse * innovation
    found = (
        error[0] + h[0] * gain,
        error[1] + h[1] * gain,
        error[2] + h[2] * gain,
        error[3] + h[3] * gain,
        error[4] + h[4] * gain,
        error[5] + h[5] * gain,
    )
    return lessened(p, inverse, h), found


@kernel(
    f"{UPPER}({UPPER}, float64[::1], float64[:, ::1], int64, {ERRORS}, float64[::1], float64[::1])",
    inlined=True,
)
def correct(p: Upper, e: Float, bias: Float, s: int, circle: Errors, sample: Float, settings: Float) -> Upper:
    """Correct by measured roll, pitch and tilt-compensated magnetic yaw (A4, A5, A8.5).

    The difference of a measured and a predicted angle is that of their complex numbers.
    """
    sr, cr, sp, cp, s_yaw, c_yaw = circle
    sx, sy, sz = sample[_GRAVITY], sample[_GRAVITY + 1], sample[_GRAVITY + 2]
    norm = sample[_GRAVITY_NORM]
    weight = 1.0
    if settings[MOTION_SCALE_G] > 0.0:
        push = (norm - 1.0) / settings[MOTION_SCALE_G]
        weight += push * push
    held = abs(e[1]) > _STEEPEST
    across = math.sqrt(sy * sy + sz * sz)
    error = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    if not held:
        innovation = direction(sy * cr - sz * sr, sz * cr + sy * sr)
        h = (p[0], p[1], p[2], p[6], p[7], p[8])
        p, error = absorb(p, error, h, p[0], innovation, weight * settings[ANGLE_VARIANCE])
    innovation = direction(-sx * cp - across * sp, across * cp - sx * sp)
    h = (p[1], p[3], p[4], p[9], p[10], p[11])
    p, error = absorb(p, error, h, p[3], innovation - error[1], weight * settings[ANGLE_VARIANCE + 1])
    if sample[_HAS_FIELD] > 0.0 and not held:
        mx, my, mz = sample[_FIELD], sample[_FIELD + 1], sample[_FIELD + 2]
        # P = m x s; the page's A5 lacks the norm of s.
        px, py, pz = my * sz - mz * sy, mz * sx - mx * sz, mx * sy - my * sx
        east, north = -px * norm, sy * pz - sz * py
        innovation = direction(east * c_yaw - north * s_yaw, north * c_yaw + east * s_yaw)
        h = (p[2], p[4], p[5], p[12], p[13], p[14])
        p, error = absorb(p, error, h, p[5], innovation - error[2], weight * settings[ANGLE_VARIANCE + 2])
    e[0] += error[0]
    e[1] += error[1]
    e[2] += error[2]
    bias[s, 0] += error[3]
    bias[s, 1] += error[4]
    bias[s, 2] += error[5]
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
    """Filter K ticks of S sensors; `q`, `bias`, `covariance` (S, 6, 6), angles and counts are carried on."""
    sample = np.zeros(_SAMPLE)
    for s in range(quality.shape[0]):
        kept = covariance[s]
        p = loaded(kept)
        e = memory[s, _ANGLES:]
        half = halves(e[0], e[1], e[2])
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
                half = halves(e[0], e[1], e[2])
                keep(kept, p)
                variance = start_variance(s, memory, counters, settings)
                for i in range(3):
                    for j in range(i, 6):
                        kept[i, j] = 0.0
                    kept[i, i] = variance
                p = loaded(kept)
            elif action != _HOLD:
                p, circle = predict(p, e, bias, s, half, sample, settings)
                if action == _FILTER:
                    if sample[_HAS_FIELD] > 0.0 and counters[s, _HEADING_KNOWN] == 0:
                        q[s, 0], q[s, 1], q[s, 2], q[s, 3] = quaternion(wrapped(e[0]), e[1], wrapped(e[2]))
                        set_heading(s, q, sample, counters)
                        e[0], e[1], e[2] = euler(q[s, 0], q[s, 1], q[s, 2], q[s, 3])
                        half = halves(e[0], e[1], e[2])
                        circle = doubled(half)
                    p = correct(p, e, bias, s, circle, sample, settings)
                if abs(e[0]) >= math.pi or abs(e[1]) > 0.5 * math.pi or abs(e[2]) >= math.pi:
                    wrap(e)
                half = halves(e[0], e[1], e[2])
                q[s, 0], q[s, 1], q[s, 2], q[s, 3] = attitude(half)
            north, east, down = variances(half, p)
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
        keep(kept, p)
        mirror(kept)


__all__ = ["MEMORY", "SETTINGS", "run"]
