"""The quaternion EKF of the arm-monitoring thesis (A9, corrected), compiled over sensors and ticks.

`LANES` sensors go through the equations at a time. What differs from sensor to sensor, the look at the samples and
the flags, is done one by one.
"""

import math

import numpy as np
from numba import types
from numpy.typing import NDArray

from estimators._kernels import Scalars3, Scalars4, kernel
from estimators._lanes import (
    LANES,
    LANES_TYPE,
    MASK_TYPE,
    QUATERNION_TYPE,
    VECTOR_TYPE,
    anywhere,
    at_least,
    at_most,
    chosen,
    column,
    in_lanes,
    put_column,
    spread,
)
from estimators.orientation import _marzouk_steps as steps
from estimators.orientation._contract import OrientationFlag
from estimators.orientation._lane_steps import (
    direction_lanes,
    multiply_lanes,
    put_quaternions,
    put_results,
    put_three,
    quaternions,
    three,
    turn_lanes,
)
from estimators.orientation._marzouk_quaternion_covariance import (
    UPPER,
    Upper,
    keep,
    lessened,
    loaded,
    predicted,
    quadratic,
    seen,
)
from estimators.orientation._marzouk_steps import prepare, set_heading, start_variance, store_flags
from estimators.recording import Float

# Positions in the settings, after the shared ones; triples start at the number given.
_FIRST = steps.SHARED_SETTINGS
RATE_VARIANCE, BIAS_DRIFT, ANGLE_VARIANCE = _FIRST, _FIRST + 3, _FIRST + 6
MOTION_SCALE_G, SINGULAR_WEIGHTING = _FIRST + 9, _FIRST + 10
SETTINGS = _FIRST + 11

# Numba freezes globals, not attributes of modules.
_COAST, _BEGIN, _FILTER = steps.COAST, steps.BEGIN, steps.FILTER
_RATE, _GRAVITY, _FIELD, _SAMPLE = steps.RATE, steps.GRAVITY, steps.FIELD, steps.SAMPLE
_GRAVITY_NORM, _HAS_FIELD, _GAP_VARIANCE = steps.GRAVITY_NORM, steps.HAS_FIELD, steps.GAP_VARIANCE
_STEP_S, _HEADING_KNOWN = steps.STEP_S, steps.HEADING_KNOWN
_SINGULAR = int(OrientationFlag.SINGULAR)
_HALF_ROOT = math.sqrt(0.5)
_GUARD = 1e-6
_SINGULAR_SINE = math.sin(math.radians(85.0))
_STEEP = 0.25
"""Squared cosine of the pitch (60 degrees) from which roll and yaw measurements lose weight."""


_ROW, _STATE = types.UniTuple(LANES_TYPE, 7), types.Tuple((UPPER, QUATERNION_TYPE, VECTOR_TYPE))
_L, _SETTINGS, _SAMPLES = LANES_TYPE, types.float64[::1], types.float64[:, ::1]
_ACTION, _SINE = _SAMPLE, _SAMPLE + 1
"""After a prepared sample: what is to be done with it, and the sine of the pitch reached."""
Row = tuple[float, float, float, float, float, float, float]
"""Sine and cosine of an angle, times any positive number; a length D; D times the angle's derivative by w, x, y, z."""
State = tuple[Upper, Scalars4, Scalars3]


@in_lanes(_STATE(_STATE, VECTOR_TYPE, _L, _SETTINGS))
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
    tw, tx, ty, tz = turn_lanes(rx, ry, rz)
    turned = multiply_lanes(w, x, y, z, tw, tx, ty, tz)
    return predicted(p, (a, hx, hy, hz), right, noise, drift), turned, (bx, by, bz)


@in_lanes(_L(_L, _L, _L, _L))
def steepness(w: float, x: float, y: float, z: float) -> float:
    """Return the factor of the variance of roll and yaw: as noisy as one over the cosine of a steep pitch."""
    c13 = 2.0 * (x * z - w * y)
    cosine_squared = 1.0 - c13 * c13
    return chosen(cosine_squared >= _STEEP, 1.0, _STEEP / at_least(cosine_squared, _GUARD))


@in_lanes(_ROW(_L, _L, _L, _L))
def roll_row(w: float, x: float, y: float, z: float) -> Row:
    """Return the row of the roll (A7.3 and A9.4, guarded at the singularity; see `absorb`)."""
    c23, c33 = 2.0 * (y * z + w * x), (w * w - x * x) - (y * y - z * z)
    length = 0.5 * at_least(c23 * c23 + c33 * c33, _GUARD)
    return c23, c33, length, x * c33 - w * c23, w * c33 + x * c23, z * c33 + y * c23, y * c33 - z * c23


@in_lanes(_ROW(_L, _L, _L, _L))
def pitch_row(w: float, x: float, y: float, z: float) -> Row:
    """Return the row of the pitch (A7.3 and A9.4, guarded at the singularity; see `absorb`)."""
    c13 = at_most(at_least(2.0 * (x * z - w * y), -1.0), 1.0)
    cosine = math.sqrt(1.0 - c13 * c13)
    return -c13, cosine, 0.5 * at_least(cosine, _GUARD), y + c13 * w, c13 * x - z, w + c13 * y, c13 * z - x


@in_lanes(_ROW(_L, _L, _L, _L))
def yaw_row(w: float, x: float, y: float, z: float) -> Row:
    """Return the row of the yaw (A7.3 and A9.4, guarded at the singularity; see `absorb`)."""
    c12, c11 = 2.0 * (x * y + w * z), (w * w + x * x) - (y * y + z * z)
    length = 0.5 * at_least(c11 * c11 + c12 * c12, _GUARD)
    return c12, c11, length, z * c11 - w * c12, y * c11 - x * c12, x * c11 + y * c12, w * c11 + z * c12


@in_lanes(QUATERNION_TYPE(_L, _L, _L, _L))
def renormalized(w: float, x: float, y: float, z: float) -> Scalars4:
    """Return a quaternion at unit norm; one that nearly is by a series exact to 1e-16."""
    off = (w * w + x * x) + (y * y + z * z) - 1.0
    scale = 1.0 - off * (1 / 2 - off * (3 / 8 - off * (5 / 16)))
    far = abs(off) > 1e-5
    if anywhere(far):
        scale = chosen(far, 1.0 / math.sqrt(off + 1.0), scale)
    return w * scale, x * scale, y * scale, z * scale


@in_lanes(_STATE(_STATE, _ROW, _L, _L, _L))
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
    found = direction_lanes(sine * now_cosine - cosine * now_sine, cosine * now_cosine + sine * now_sine)
    step = inverse * (length * found)
    turned = renormalized(w + g[0] * step, x + g[1] * step, y + g[2] * step, z + g[3] * step)
    return lessened(p, inverse, g), turned, (bx + g[4] * step, by + g[5] * step, bz + g[6] * step)


@in_lanes(_STATE(MASK_TYPE, _STATE, _STATE), inlined=False)
def either(mask: bool, yes: State, no: State) -> State:
    """Return one state where the mask is true and the other elsewhere."""
    a, b, c = yes
    d, e, f = no
    return (
        (
            chosen(mask, a[0], d[0]),
            chosen(mask, a[1], d[1]),
            chosen(mask, a[2], d[2]),
            chosen(mask, a[3], d[3]),
            chosen(mask, a[4], d[4]),
            chosen(mask, a[5], d[5]),
            chosen(mask, a[6], d[6]),
            chosen(mask, a[7], d[7]),
            chosen(mask, a[8], d[8]),
            chosen(mask, a[9], d[9]),
            chosen(mask, a[10], d[10]),
            chosen(mask, a[11], d[11]),
            chosen(mask, a[12], d[12]),
            chosen(mask, a[13], d[13]),
            chosen(mask, a[14], d[14]),
            chosen(mask, a[15], d[15]),
            chosen(mask, a[16], d[16]),
            chosen(mask, a[17], d[17]),
            chosen(mask, a[18], d[18]),
            chosen(mask, a[19], d[19]),
            chosen(mask, a[20], d[20]),
            chosen(mask, a[21], d[21]),
            chosen(mask, a[22], d[22]),
            chosen(mask, a[23], d[23]),
            chosen(mask, a[24], d[24]),
            chosen(mask, a[25], d[25]),
            chosen(mask, a[26], d[26]),
            chosen(mask, a[27], d[27]),
        ),
        (
            chosen(mask, b[0], e[0]),
            chosen(mask, b[1], e[1]),
            chosen(mask, b[2], e[2]),
            chosen(mask, b[3], e[3]),
        ),
        (
            chosen(mask, c[0], f[0]),
            chosen(mask, c[1], f[1]),
            chosen(mask, c[2], f[2]),
        ),
    )


@in_lanes(_STATE(_STATE, _SAMPLES, types.intp, types.boolean, _SETTINGS))
def correct(state: State, samples: Float, last: int, field: bool, settings: Float) -> State:
    """Correct by roll, pitch and tilt-compensated magnetic yaw, one after the other (A4, A5, A9.4)."""
    sx, sy, sz = three(samples, 0, last, _GRAVITY)
    norm = column(samples, (0, last, _GRAVITY_NORM))
    across = math.sqrt(sy * sy + sz * sz)
    weight = spread(1.0)
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
    if field:
        mx, my, mz = three(samples, 0, last, _FIELD)
        px, py, pz = my * sz - mz * sy, mz * sx - mx * sz, mx * sy - my * sx
        w, x, y, z = state[1]
        if weighted:
            yaw_variance *= steepness(w, x, y, z)
        # The page's A5 lacks the norm of s; without it the yaw is wrong whenever the arm is pushed.
        found = absorb(state, yaw_row(w, x, y, z), -px * norm, sy * pz - sz * py, yaw_variance)
        lacks = column(samples, (0, last, _HAS_FIELD)) <= 0.0
        state = either(lacks, state, found) if anywhere(lacks) else found
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
    samples = np.zeros((LANES, _SAMPLE + 2))
    flat = covariance.reshape(covariance.shape[0], 49)
    sensors = quality.shape[0]
    for first in range(0, sensors, LANES):
        end = min(first + LANES, sensors)
        last, beside = end - 1, end - 1 - first
        p = loaded(flat, first, last)
        for k in range(quality.shape[1]):
            ordinary, begun, field, unknown = True, False, False, False
            for s in range(first, end):
                sample = samples[s - first]
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
                sample[_ACTION] = action
                begun |= action == _BEGIN
                ordinary &= action == _FILTER
                if action == _FILTER and sample[_HAS_FIELD] > 0.0:
                    field = True
                    unknown |= counters[s, _HEADING_KNOWN] == 0
            if begun:
                keep(flat, first, last, p)
                for s in range(first, end):
                    if samples[s - first, _ACTION] == _BEGIN:
                        begin(s, covariance, memory, counters, settings)
                p = loaded(flat, first, last)
            before = p, quaternions(q, first, last), three(bias, first, last, 0)
            rate, gap_variance = three(samples, 0, beside, _RATE), column(samples, (0, beside, _GAP_VARIANCE))
            moved = predict(before, rate, gap_variance, settings)
            if unknown:
                put_quaternions(q, first, last, moved[1])
                for s in range(first, end):
                    sample = samples[s - first]
                    has = sample[_ACTION] == _FILTER and sample[_HAS_FIELD] > 0.0
                    if has and counters[s, _HEADING_KNOWN] == 0:
                        set_heading(s, q, sample, counters)
                moved = moved[0], quaternions(q, first, last), moved[2]
            state = correct(moved, samples, beside, field, settings)
            if not ordinary:
                action_here = column(samples, (0, beside, _ACTION))
                state = either((action_here >= _FILTER) & (action_here <= _FILTER), state, moved)
                state = either((action_here >= _COAST) & (action_here <= _FILTER), state, before)
            p, (w, x, y, z), offset = state
            put_quaternions(q, first, last, (w, x, y, z))
            put_three(bias, first, last, 0, offset)
            put_column(samples, (0, beside, _SINE), abs(2.0 * (x * z - w * y)))
            # Rotation error in U: twice the vector part of dq * conj(q).
            north = 4.0 * quadratic(p, -x, w, -z, y)
            east = 4.0 * quadratic(p, -y, z, w, -x)
            down = 4.0 * quadratic(p, -z, -y, x, w)
            # Rotation from north-east-down to east-north-up: half a turn about the line between x and y.
            w, x, y, z = _HALF_ROOT * w, _HALF_ROOT * x, _HALF_ROOT * y, _HALF_ROOT * z
            turned = -x - y, w + z, w - z, y - x
            put_results(
                q_earth_sensor, bias_out, sigma_rad, first, last, k, turned, offset, (east, north, down)
            )
            for s in range(first, end):
                sample = samples[s - first]
                own = _SINGULAR if sample[_SINE] > _SINGULAR_SINE else 0
                action = int(sample[_ACTION])
                store_flags(s, k, action, own, quality, settings, counters, sample, sigma_rad, flags)
        keep(flat, first, last, p)


__all__ = ["SETTINGS", "pitch_row", "roll_row", "run", "yaw_row"]
