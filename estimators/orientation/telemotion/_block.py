"""The Kalman filter of our own estimator, once a block: prediction, and what the block measured."""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import exponential, kernel, multiply, normalized
from estimators.orientation.telemotion._layout import (
    BIAS,
    BIAS_DRIFT,
    COUNT,
    DELAY,
    FIELD,
    FIELD_COUNT,
    GAIN,
    GAP_SPEED_VARIANCE,
    GAP_TURN_VARIANCE,
    GRAVITY,
    GRAVITY_COUNT,
    IRON,
    MEAN_FORCE,
    MEAN_RATE,
    POSITION,
    POSITION_NOISE,
    POSITION_PRIOR,
    RATE_NOISE,
    RATE_NOISE_PER_RATE,
    REST_S,
    REST_SPEED,
    SPEED_NOISE,
    START,
    START_SHARE,
    STATES,
    STEP_S,
    SUM_DELAY,
    SUM_FIELD,
    SUM_FORCE,
    SUM_GAIN,
    SUM_RATE2,
    SUM_ROTATION,
    TURN,
    VELOCITY,
)
from estimators.orientation.telemotion._samples import rest_variance
from estimators.recording import Float

_DIAGONAL = STATES + 1
_T0, _T1, _T2 = STATES * TURN, STATES * (TURN + 1), STATES * (TURN + 2)
_V0, _V1, _V2 = STATES * VELOCITY, STATES * (VELOCITY + 1), STATES * (VELOCITY + 2)
_P0, _P1, _P2 = STATES * POSITION, STATES * (POSITION + 1), STATES * (POSITION + 2)
_GRAVITY_AVERAGE = 70.0
"""Blocks at rest over which the norm of gravity is averaged at most."""


@kernel("void(float64[::1], float64[::1], float64[::1], float64)")
def predict(p: Float, memory: Float, settings: Float, ticks: float) -> None:
    """Carry the covariance over a block of `ticks`: P <- F P F' + Q (house note, 5.3, 5.4).

    turn += Phi_b bias + Phi_K gain; velocity -= [s x] turn; position += time velocity; the rest stays.
    Only the first nine rows of F differ from the identity, so only these rows and columns are touched.
    The covariance is flat here and below, so that the compiler sees that rows do not overlap.
    """
    step_s = settings[STEP_S]
    time_s = ticks * step_s
    sx, sy, sz = memory[SUM_FORCE], memory[SUM_FORCE + 1], memory[SUM_FORCE + 2]
    for j in range(STATES):
        p[_P0 + j] += time_s * p[_V0 + j]
        p[_P1 + j] += time_s * p[_V1 + j]
        p[_P2 + j] += time_s * p[_V2 + j]
        tx, ty, tz = p[_T0 + j], p[_T1 + j], p[_T2 + j]
        p[_V0 + j] += sz * ty - sy * tz
        p[_V1 + j] += sx * tz - sz * tx
        p[_V2 + j] += sy * tx - sx * ty
    for c in range(3):
        x = -step_s * memory[SUM_ROTATION + c]
        y = -step_s * memory[SUM_ROTATION + 3 + c]
        z = -step_s * memory[SUM_ROTATION + 6 + c]
        row = STATES * (BIAS + c)
        for j in range(STATES):
            source = p[row + j]
            p[_T0 + j] += x * source
            p[_T1 + j] += y * source
            p[_T2 + j] += z * source
    for c in range(9):
        x = step_s * memory[SUM_GAIN + c]
        y = step_s * memory[SUM_GAIN + 9 + c]
        z = step_s * memory[SUM_GAIN + 18 + c]
        row = STATES * (GAIN + c)
        for j in range(STATES):
            source = p[row + j]
            p[_T0 + j] += x * source
            p[_T1 + j] += y * source
            p[_T2 + j] += z * source
    for i in range(BIAS):
        row = STATES * i
        for a in range(3):
            p[row + POSITION + a] += time_s * p[row + VELOCITY + a]
        tx, ty, tz = p[row + TURN], p[row + TURN + 1], p[row + TURN + 2]
        p[row + VELOCITY] += sz * ty - sy * tz
        p[row + VELOCITY + 1] += sx * tz - sz * tx
        p[row + VELOCITY + 2] += sy * tx - sx * ty
        for a in range(3):
            total = 0.0
            for c in range(3):
                total -= memory[SUM_ROTATION + 3 * a + c] * p[row + BIAS + c]
            for c in range(9):
                total += memory[SUM_GAIN + 9 * a + c] * p[row + GAIN + c]
            p[row + TURN + a] += step_s * total
    turning = settings[RATE_NOISE] + settings[RATE_NOISE_PER_RATE] * memory[SUM_RATE2] / ticks
    for a in range(3):
        p[_DIAGONAL * (TURN + a)] += turning * time_s + memory[GAP_TURN_VARIANCE + a]
        p[_DIAGONAL * (VELOCITY + a)] += settings[SPEED_NOISE] * time_s + memory[GAP_SPEED_VARIANCE + a]
        p[_DIAGONAL * (POSITION + a)] += settings[POSITION_NOISE] * time_s
        p[_DIAGONAL * (BIAS + a)] += settings[BIAS_DRIFT] * time_s
    for i in range(BIAS):
        for j in range(i + 1, STATES):
            p[STATES * j + i] = p[STATES * i + j]


@kernel("void(float64[::1], float64[::1], float64[:, ::1], int64[:, ::1], float64[:, ::1], int64)")
def absorb(p: Float, error: Float, rows: Float, index: NDArray[np.int64], value: Float, entries: int) -> None:
    """Take three scalar measurements, one after the other, into `error` and `p`.

    Parameters
    ----------
    p : ndarray, shape (STATES * STATES,)
    error : ndarray, shape (STATES,)
    rows : ndarray, shape (5, STATES)
        Room for the three gains; then, three each, the innovations and the variances. These become the
        innovation left over its variance, and one over this variance: what a backward pass needs.
    index, value : ndarray, shape (3, 8)
        The first `entries` hold where the row of a measurement is not zero, and what is there.
    entries : int

    Notes
    -----
    The gains are found in turn and the covariance is changed in one pass, which is three times as fast as
    three passes. The order of the products keeps it symmetric to the last bit.
    """
    first, second, third = rows[0], rows[1], rows[2]
    innovation, variance = rows[3], rows[4]
    inverse = (1.0, 1.0, 1.0)
    for m in range(3):
        gain, where, what = rows[m], index[m], value[m]
        for i in range(STATES):
            gain[i] = 0.0
        for e in range(entries):
            source, factor = p[STATES * where[e] : STATES * where[e] + STATES], what[e]
            for i in range(STATES):
                gain[i] += factor * source[i]
        for earlier in range(m):
            known = rows[earlier]
            factor = 0.0
            for e in range(entries):
                factor += what[e] * known[where[e]]
            factor *= inverse[earlier]
            for i in range(STATES):
                gain[i] -= factor * known[i]
        total, expected = variance[m], 0.0
        for e in range(entries):
            total += what[e] * gain[where[e]]
            expected += what[e] * error[where[e]]
        one = 1.0 / total
        inverse = (
            one if m == 0 else inverse[0],
            one if m == 1 else inverse[1],
            one if m == 2 else inverse[2],
        )
        step = one * (innovation[m] - expected)
        innovation[m], variance[m] = step, one
        for i in range(STATES):
            error[i] += gain[i] * step
    one, two, three = inverse
    for i in range(STATES):
        row = p[STATES * i : STATES * i + STATES]
        x, y, z = first[i], second[i], third[i]
        for j in range(STATES):
            row[j] -= one * (x * first[j]) + two * (y * second[j]) + three * (z * third[j])


@kernel("void(float64[::1], float64[::1], float64)")
def move(memory: Float, settings: Float, ticks: float) -> None:
    """Carry nominal velocity and position; at rest learn the norm of gravity."""
    time_s = ticks * settings[STEP_S]
    if memory[REST_S] > 1.0:
        norm = math.sqrt(memory[MEAN_FORCE] ** 2 + memory[MEAN_FORCE + 1] ** 2 + memory[MEAN_FORCE + 2] ** 2)
        memory[GRAVITY_COUNT] = min(memory[GRAVITY_COUNT] + 1.0, _GRAVITY_AVERAGE)
        memory[GRAVITY] += (norm - memory[GRAVITY]) / memory[GRAVITY_COUNT]
    for a in range(3):
        change = memory[SUM_FORCE + a]
        if a == 2:
            change -= memory[GRAVITY] * time_s
        memory[POSITION + a] += time_s * (memory[VELOCITY + a] + 0.5 * change)
        memory[VELOCITY + a] += change


@kernel(
    "void(float64[::1], float64[::1], float64[:, ::1], float64[::1], float64[::1], float64[::1], int64[:, ::1],"
    "float64[:, ::1], float64, boolean)"
)
def hold_place(
    p: Float,
    error: Float,
    rows: Float,
    bias: Float,
    memory: Float,
    settings: Float,
    index: NDArray[np.int64],
    value: Float,
    ticks: float,
    rest: bool,
) -> None:
    """Weigh specific force: the sensor stays near one place; at rest, neither moves nor turns (5.5, 5.8)."""
    time_s = ticks * settings[STEP_S]
    for a in range(3):
        index[a, 0], value[a, 0] = POSITION + a, 1.0
        rows[3, a], rows[4, a] = -memory[POSITION + a], settings[POSITION_PRIOR] / time_s
    absorb(p, error, rows, index, value, 1)
    if not rest:
        return
    for a in range(3):
        index[a, 0] = VELOCITY + a
        rows[3, a], rows[4, a] = -memory[VELOCITY + a], settings[REST_SPEED] / time_s
    absorb(p, error, rows, index, value, 1)
    variance = rest_variance(p, bias, memory, settings, time_s)
    for a in range(3):
        index[a, 0] = BIAS + a
        rows[3, a], rows[4, a] = memory[MEAN_RATE + a] - bias[a], variance
    absorb(p, error, rows, index, value, 1)


@kernel(
    "void(float64[::1], float64[::1], float64[:, ::1], float64[::1], int64[:, ::1], float64[:, ::1], int64[::1],"
    "float64)"
)
def see_field(
    p: Float,
    error: Float,
    rows: Float,
    memory: Float,
    index: NDArray[np.int64],
    value: Float,
    counts: NDArray[np.int64],
    variance: float,
) -> None:
    """Take the mean field of the block, all three components (house note, 5.9, in the start frame).

    mean R (m - iron) = FIELD + share START + [FIELD x] turn + R iron + delay mean R (w x m) + noise.
    """
    per_field, per_sample = 1.0 / counts[FIELD_COUNT], 1.0 / counts[COUNT]
    share = memory[START_SHARE]
    bx, by, bz = memory[FIELD], memory[FIELD + 1], memory[FIELD + 2]
    index[0, 0], value[0, 0], index[0, 1], value[0, 1] = TURN + 1, -bz, TURN + 2, by
    index[1, 0], value[1, 0], index[1, 1], value[1, 1] = TURN, bz, TURN + 2, -bx
    index[2, 0], value[2, 0], index[2, 1], value[2, 1] = TURN, -by, TURN + 1, bx
    for a in range(3):
        index[a, 2], value[a, 2] = FIELD + a, 1.0
        index[a, 3], value[a, 3] = DELAY, memory[SUM_DELAY + a] * per_field
        for c in range(3):
            index[a, 4 + c], value[a, 4 + c] = IRON + c, memory[SUM_ROTATION + 3 * a + c] * per_sample
        index[a, 7], value[a, 7] = START + a, share
        rows[3, a] = memory[SUM_FIELD + a] * per_field - memory[FIELD + a] - share * memory[START + a]
        rows[4, a] = variance
    absorb(p, error, rows, index, value, 8 if share > 0.0 else 7)


@kernel("void(float64[::1], float64[::1], float64[::1], float64[::1])")
def inject(q: Float, bias: Float, memory: Float, error: Float) -> None:
    """Move the error into the estimate and clear it (house note, 5.11)."""
    tw, tx, ty, tz = exponential(error[TURN], error[TURN + 1], error[TURN + 2])
    w, x, y, z = multiply(tw, tx, ty, tz, q[0], q[1], q[2], q[3])
    q[0], q[1], q[2], q[3] = normalized(w, x, y, z)
    for i in range(VELOCITY, STATES):
        if i < BIAS or i >= GAIN:
            memory[i] += error[i]
    for a in range(3):
        bias[a] += error[BIAS + a]
    for i in range(STATES):
        error[i] = 0.0


__all__ = ["absorb", "hold_place", "inject", "move", "predict", "see_field"]
