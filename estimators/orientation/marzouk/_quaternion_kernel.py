"""The quaternion EKF of the arm-monitoring thesis (A9, corrected), compiled over sensors and ticks."""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import Scalars3, Scalars4, kernel, multiply
from estimators.kernels import far_direction, mirror, turn
from estimators.orientation._contract import OrientationFlag
from estimators.orientation.marzouk import _steps as steps
from estimators.orientation.marzouk._quaternion_covariance import (
    QUATERNION,
    UPPER,
    VECTOR,
    Upper,
    keep,
    lessened,
    loaded,
    predicted,
    quadratic,
    seen,
)
from estimators.orientation.marzouk._steps import direction, prepare, set_heading, start_variance, store
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


_ROW, _STATE = "UniTuple(float64, 7)", f"Tuple(({UPPER}, {QUATERNION}, {VECTOR}))"
_SETTINGS = "float64[::1]"
Row = tuple[float, float, float, float, float, float, float]
"""Sine and cosine of an angle, times any positive number; a length D; D times the angle's derivative by w, x, y, z."""
State = tuple[Upper, Scalars4, Scalars3]


@kernel(f"{_STATE}({_STATE}, {VECTOR}, float64, {_SETTINGS})", inlined=True)
def predict(state: State, rate: Scalars3, gap_variance: float, settings: Float) -> State:
    """Turn by the rate and carry the covariance, Phi P Phi' + Ts Qc (A9.1 to A9.3)."""
    step = settings[_STEP_S]
    p, (w, x, y, z), (bx, by, bz) = state
    rx = (rate[0] - bx) * step
    ry = (rate[1] - by) * step
    rz = (rate[2] - bz) * step
    # Upper left block of Phi: a + (r x) structure; Omega^2 = -|u|^2 I.
    a = 1.0 - (rx * rx + ry * ry + rz * rz) / 8.0
    hx, hy, hz = 0.5 * rx, 0.5 * ry, 0.5 * rz
    # Upper right block -Ts/2 (I + Ts/4 Omega) Xi: columns q (0, e) (1, r/4) of e = e_x, e_y, e_z.
    half = -0.5 * step
    hw, hx2, hy2, hz2 = half * w, half * x, half * y, half * z
    kx, ky, kz = 0.5 * hx, 0.5 * hy, 0.5 * hz
    right = (
        -hx2 - kx * hw + kz * hy2 - ky * hz2,
        -hy2 - ky * hw + kx * hz2 - kz * hx2,
        -hz2 - kz * hw + ky * hx2 - kx * hy2,
        hw - kx * hx2 + kz * hz2 + ky * hy2,
        -hz2 - ky * hx2 - kx * hy2 + kz * hw,
        hy2 - kz * hx2 - kx * hz2 - ky * hw,
        hz2 - kx * hy2 - ky * hx2 - kz * hw,
        hw - ky * hy2 + kz * hz2 + kx * hx2,
        -hx2 - kz * hy2 - ky * hz2 + kx * hw,
        -hy2 - kx * hz2 - kz * hx2 + ky * hw,
        hx2 - ky * hz2 - kz * hy2 - kx * hw,
        hw - kz * hz2 + ky * hy2 + kx * hx2,
    )
    gap = 0.25 * gap_variance
    quarter = 0.25 * step * step
    nx = quarter * settings[RATE_VARIANCE] + gap
    ny = quarter * settings[RATE_VARIANCE + 1] + gap
    nz = quarter * settings[RATE_VARIANCE + 2] + gap
    # Xi diag(n) Xi' by rows, Xi = columns q (0, e).
    ww, xx, yy, zz = w * w, x * x, y * y, z * z
    nxx, nyy, nzz = nx * x, ny * y, nz * z
    nxw, nyw, nzw = nx * w, ny * w, nz * w
    noise = (
        nxx * x + nyy * y + nzz * z,
        -nxx * w + nyy * z - nzz * y,
        -nxx * z - nyy * w + nzz * x,
        nxx * y - nyy * x - nzz * w,
        nx * ww + ny * zz + nz * yy,
        nxw * z - nyw * z - nz * x * y,
        -nxw * y - ny * x * z + nzw * y,
        nx * zz + ny * ww + nz * xx,
        -nx * y * z + nyw * x - nzw * x,
        nx * yy + ny * xx + nz * ww,
    )
    drift = (
        step * settings[BIAS_DRIFT],
        step * settings[BIAS_DRIFT + 1],
        step * settings[BIAS_DRIFT + 2],
    )
    tw, tx, ty, tz = turn(rx, ry, rz)
    turned = multiply(w, x, y, z, tw, tx, ty, tz)
    return predicted(p, (a, hx, hy, hz), right, noise, drift), turned, (bx, by, bz)


@kernel("float64(float64, float64, float64, float64)", inlined=True)
def steepness(w: float, x: float, y: float, z: float) -> float:
    """Return the factor of the variance of roll and yaw: as noisy as one over the cosine of a steep pitch."""
    c13 = 2.0 * (x * z - w * y)
    cosine_squared = 1.0 - c13 * c13
    return 1.0 if cosine_squared >= _STEEP else _STEEP / max(cosine_squared, _GUARD)


@kernel(f"{_ROW}(float64, float64, float64, float64)", inlined=True)
def roll_row(w: float, x: float, y: float, z: float) -> Row:
    """Return the row of the roll (A7.3 and A9.4, guarded at the singularity; see `absorb`)."""
    c23, c33 = 2.0 * (y * z + w * x), (w * w - x * x) - (y * y - z * z)
    length = 0.5 * max(c23 * c23 + c33 * c33, _GUARD)
    return c23, c33, length, x * c33 - w * c23, w * c33 + x * c23, z * c33 + y * c23, y * c33 - z * c23


@kernel(f"{_ROW}(float64, float64, float64, float64)", inlined=True)
def pitch_row(w: float, x: float, y: float, z: float) -> Row:
    """Return the row of the pitch (A7.3 and A9.4, guarded at the singularity; see `absorb`)."""
    c13 = min(max(2.0 * (x * z - w * y), -1.0), 1.0)
    cosine = math.sqrt(1.0 - c13 * c13)
    return -c13, cosine, 0.5 * max(cosine, _GUARD), y + c13 * w, c13 * x - z, w + c13 * y, c13 * z - x


@kernel(f"{_ROW}(float64, float64, float64, float64)", inlined=True)
def yaw_row(w: float, x: float, y: float, z: float) -> Row:
    """Return the row of the yaw (A7.3 and A9.4, guarded at the singularity; see `absorb`)."""
    c12, c11 = 2.0 * (x * y + w * z), (w * w + x * x) - (y * y + z * z)
    length = 0.5 * max(c11 * c11 + c12 * c12, _GUARD)
    return c12, c11, length, z * c11 - w * c12, y * c11 - x * c12, x * c11 + y * c12, w * c11 + z * c12


@kernel(f"{QUATERNION}(float64, float64, float64, float64)", inlined=True)
def renormalized(w: float, x: float, y: float, z: float) -> Scalars4:
    """Return a quaternion at unit norm; one that nearly is by a series exact to 1e-16."""
    off = (w * w + x * x) + (y * y + z * z) - 1.0
    scale = 1.0 - off * (1 / 2 - off * (3 / 8 - off * (5 / 16)))
    if abs(off) > 1e-5:
        scale = 1.0 / math.sqrt(off + 1.0)
    return w * scale, x * scale, y * scale, z * scale


@kernel(f"{_STATE}({_STATE}, {_ROW}, float64, float64, float64)", inlined=True)
def absorb(state: State, row: Row, sine: float, cosine: float, variance: float) -> State:
    """Correct by an angle measured as sine and cosine (times any positive number).

    The rows of A9.4 are right along the unit sphere only. Their part along q says that the norm were measured, which
    it is not; left in, it makes a heading without magnetometer look known. Those here lack it.
    """
    p, (w, x, y, z), (bx, by, bz) = state
    now_sine, now_cosine, length, h0, h1, h2, h3 = row
    g = seen(p, (h0, h1, h2, h3))
    # Row and gain over the length save its division: 1 / S = inverse length^2.
    inverse = 1.0 / ((h0 * g[0] + h1 * g[1]) + (h2 * g[2] + h3 * g[3]) + variance * length * length)
    # The difference of two angles is that of their complex numbers; it comes within half a turn.
    across, along = sine * now_cosine - cosine * now_sine, cosine * now_cosine + sine * now_sine
    found = direction(across, along) if abs(across) < 0.125 * along else far_direction(across, along)
    step = inverse * (length * found)
    turned = renormalized(w + g[0] * step, x + g[1] * step, y + g[2] * step, z + g[3] * step)
    return lessened(p, inverse, g), turned, (bx + g[4] * step, by + g[5] * step, bz + g[6] * step)


@kernel(f"{_STATE}({_STATE}, float64[::1], {_SETTINGS})", inlined=True)
def correct(state: State, sample: Float, settings: Float) -> State:
    """Correct by roll, pitch and tilt-compensated magnetic yaw, one after the other (A4, A5, A9.4)."""
    sx, sy, sz = sample[_GRAVITY], sample[_GRAVITY + 1], sample[_GRAVITY + 2]
    norm = sample[_GRAVITY_NORM]
    across = math.sqrt(sy * sy + sz * sz)
    weight = 1.0
    if settings[MOTION_SCALE_G] > 0.0:
        push = (norm - 1.0) / settings[MOTION_SCALE_G]
        weight += push * push
    roll_variance = weight * settings[ANGLE_VARIANCE]
    pitch_variance = weight * settings[ANGLE_VARIANCE + 1]
    yaw_variance = weight * settings[ANGLE_VARIANCE + 2]
    weighted = settings[SINGULAR_WEIGHTING] > 0.0
    w, x, y, z = state[1]
    if weighted:
        roll_variance *= steepness(w, x, y, z)
    state = absorb(state, roll_row(w, x, y, z), sy, sz, roll_variance)
    w, x, y, z = state[1]
    state = absorb(state, pitch_row(w, x, y, z), -sx, across, pitch_variance)
    if sample[_HAS_FIELD] > 0.0:
        mx, my, mz = sample[_FIELD], sample[_FIELD + 1], sample[_FIELD + 2]
        px, py, pz = my * sz - mz * sy, mz * sx - mx * sz, mx * sy - my * sx
        w, x, y, z = state[1]
        if weighted:
            yaw_variance *= steepness(w, x, y, z)
        # The page's A5 lacks the norm of s; without it the yaw is wrong whenever the arm is pushed.
        state = absorb(state, yaw_row(w, x, y, z), -px * norm, sy * pz - sz * py, yaw_variance)
    return state


@kernel("void(int64, float64[:, :, ::1], float64[:, ::1], int64[:, ::1], float64[::1])")
def begin(s: int, covariance: Float, memory: Float, counters: NDArray[np.int64], settings: Float) -> None:
    """Set the start covariance, apart from that of the offset; a turn by d moves the quaternion by d/2."""
    p = covariance[s]
    p[:4, :] = 0.0
    p[:, :4] = 0.0
    variance = 0.25 * start_variance(s, memory, counters, settings)
    for i in range(4):
        p[i, i] = variance


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
    for s in range(quality.shape[0]):
        p = loaded(covariance[s])
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
                keep(covariance[s], p)
                begin(s, covariance, memory, counters, settings)
                p = loaded(covariance[s])
            elif action != _HOLD:
                state = p, (q[s, 0], q[s, 1], q[s, 2], q[s, 3]), (bias[s, 0], bias[s, 1], bias[s, 2])
                rate = sample[_RATE], sample[_RATE + 1], sample[_RATE + 2]
                state = predict(state, rate, sample[_GAP_VARIANCE], settings)
                if action == _FILTER:
                    if sample[_HAS_FIELD] > 0.0 and counters[s, _HEADING_KNOWN] == 0:
                        q[s, 0], q[s, 1], q[s, 2], q[s, 3] = state[1]
                        set_heading(s, q, sample, counters)
                        state = state[0], (q[s, 0], q[s, 1], q[s, 2], q[s, 3]), state[2]
                    state = correct(state, sample, settings)
                p = state[0]
                q[s, 0], q[s, 1], q[s, 2], q[s, 3] = state[1]
                bias[s, 0], bias[s, 1], bias[s, 2] = state[2]
            w, x, y, z = q[s, 0], q[s, 1], q[s, 2], q[s, 3]
            store(
                s,
                k,
                action,
                _SINGULAR if abs(2.0 * (x * z - w * y)) > _SINGULAR_SINE else 0,
                # Rotation error in U: twice the vector part of dq * conj(q).
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
        keep(covariance[s], p)
        mirror(covariance[s])


__all__ = ["SETTINGS", "pitch_row", "roll_row", "run", "yaw_row"]
