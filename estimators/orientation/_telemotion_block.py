"""The Kalman filter of our own estimator, once a block: prediction, and what the block measured."""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import exponential, kernel, multiply, normalized
from estimators.orientation._telemotion_layout import (
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
    REST_BIAS,
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
from estimators.recording import Float

_GRAVITY_AVERAGE = 70.0
"""Blocks at rest over which the norm of gravity is averaged at most."""


@kernel("void(float64[:, ::1], float64[::1], float64[::1], float64)")
def predict(p: Float, memory: Float, settings: Float, ticks: float) -> None:
    """Carry the covariance over a block of `ticks`: P <- F P F' + Q (house note, 5.3, 5.4).

    turn += Phi_b bias + Phi_K gain; velocity -= [s x] turn; position += time velocity; the rest stays.
    Only the first nine rows of F differ from the identity, so only these rows and columns are touched.
    """
    step_s = settings[STEP_S]
    time_s = ticks * step_s
    sx, sy, sz = memory[SUM_FORCE], memory[SUM_FORCE + 1], memory[SUM_FORCE + 2]
    for j in range(STATES):
        for a in range(3):
            p[POSITION + a, j] += time_s * p[VELOCITY + a, j]
        tx, ty, tz = p[TURN, j], p[TURN + 1, j], p[TURN + 2, j]
        p[VELOCITY, j] += sz * ty - sy * tz
        p[VELOCITY + 1, j] += sx * tz - sz * tx
        p[VELOCITY + 2, j] += sy * tx - sx * ty
    for a in range(3):
        for c in range(3):
            factor = -step_s * memory[SUM_ROTATION + 3 * a + c]
            for j in range(STATES):
                p[TURN + a, j] += factor * p[BIAS + c, j]
        for c in range(9):
            factor = step_s * memory[SUM_GAIN + 9 * a + c]
            for j in range(STATES):
                p[TURN + a, j] += factor * p[GAIN + c, j]
    for i in range(BIAS):
        for a in range(3):
            p[i, POSITION + a] += time_s * p[i, VELOCITY + a]
        tx, ty, tz = p[i, TURN], p[i, TURN + 1], p[i, TURN + 2]
        p[i, VELOCITY] += sz * ty - sy * tz
        p[i, VELOCITY + 1] += sx * tz - sz * tx
        p[i, VELOCITY + 2] += sy * tx - sx * ty
        for a in range(3):
            total = 0.0
            for c in range(3):
                total -= memory[SUM_ROTATION + 3 * a + c] * p[i, BIAS + c]
            for c in range(9):
                total += memory[SUM_GAIN + 9 * a + c] * p[i, GAIN + c]
            p[i, TURN + a] += step_s * total
    turning = settings[RATE_NOISE] + settings[RATE_NOISE_PER_RATE] * memory[SUM_RATE2] / ticks
    for a in range(3):
        p[TURN + a, TURN + a] += turning * time_s + memory[GAP_TURN_VARIANCE + a]
        p[VELOCITY + a, VELOCITY + a] += settings[SPEED_NOISE] * time_s + memory[GAP_SPEED_VARIANCE + a]
        p[POSITION + a, POSITION + a] += settings[POSITION_NOISE] * time_s
        p[BIAS + a, BIAS + a] += settings[BIAS_DRIFT] * time_s
    for i in range(BIAS):
        for j in range(i + 1, STATES):
            p[j, i] = p[i, j]


@kernel(
    "void(float64[:, ::1], float64[::1], float64[::1], int64[::1], float64[::1], int64, float64, float64)"
)
def absorb(
    p: Float,
    error: Float,
    gain: Float,
    index: NDArray[np.int64],
    value: Float,
    entries: int,
    innovation: float,
    variance: float,
) -> None:
    """Take one scalar measurement into `error` and `p`; its row holds `value` at `index`."""
    for i in range(STATES):
        gain[i] = 0.0
    for e in range(entries):
        row, factor = index[e], value[e]
        for i in range(STATES):
            gain[i] += factor * p[row, i]
    total, expected = variance, 0.0
    for e in range(entries):
        total += value[e] * gain[index[e]]
        expected += value[e] * error[index[e]]
    inverse = 1.0 / total
    step = inverse * (innovation - expected)
    for i in range(STATES):
        error[i] += gain[i] * step
        for j in range(STATES):
            p[i, j] -= inverse * (gain[i] * gain[j])


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
    "void(float64[:, ::1], float64[::1], float64[::1], float64[::1], float64[::1], float64[::1], int64[::1],"
    "float64[::1], float64, boolean)"
)
def hold_place(
    p: Float,
    error: Float,
    gain: Float,
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
    value[0] = 1.0
    for a in range(3):
        index[0] = POSITION + a
        absorb(p, error, gain, index, value, 1, -memory[POSITION + a], settings[POSITION_PRIOR] / time_s)
    if not rest:
        return
    for a in range(3):
        index[0] = VELOCITY + a
        absorb(p, error, gain, index, value, 1, -memory[VELOCITY + a], settings[REST_SPEED] / time_s)
    for a in range(3):
        index[0] = BIAS + a
        absorb(p, error, gain, index, value, 1, memory[MEAN_RATE + a] - bias[a], settings[REST_BIAS] / time_s)


@kernel(
    "void(float64[:, ::1], float64[::1], float64[::1], float64[::1], int64[::1], float64[::1], int64[::1],"
    "float64)"
)
def see_field(
    p: Float,
    error: Float,
    gain: Float,
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
    for a in range(3):
        if a == 0:
            index[0], value[0], index[1], value[1] = TURN + 1, -bz, TURN + 2, by
        elif a == 1:
            index[0], value[0], index[1], value[1] = TURN, bz, TURN + 2, -bx
        else:
            index[0], value[0], index[1], value[1] = TURN, -by, TURN + 1, bx
        index[2], value[2] = FIELD + a, 1.0
        index[3], value[3] = DELAY, memory[SUM_DELAY + a] * per_field
        for c in range(3):
            index[4 + c], value[4 + c] = IRON + c, memory[SUM_ROTATION + 3 * a + c] * per_sample
        index[7], value[7] = START + a, share
        entries = 8 if share > 0.0 else 7
        residual = memory[SUM_FIELD + a] * per_field - memory[FIELD + a] - share * memory[START + a]
        absorb(p, error, gain, index, value, entries, residual, variance)


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
