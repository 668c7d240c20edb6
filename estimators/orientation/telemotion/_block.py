"""The Kalman filter of our own estimator, once a block: prediction, and what the block measured."""

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import exponential, multiply, normalized
from estimators.kernels import Record, borrowing
from estimators.orientation.telemotion._records import (
    BIAS,
    DELAY,
    FIELD,
    GAIN,
    IRON,
    OFFSET,
    POSITION,
    START,
    STATES,
    TURN,
    VELOCITY,
    WEIGHT,
)
from estimators.orientation.telemotion._samples import rest_variance
from estimators.recording import Float

_DIAGONAL = STATES + 1
_T0, _T1, _T2 = STATES * TURN, STATES * (TURN + 1), STATES * (TURN + 2)
_V0, _V1, _V2 = STATES * VELOCITY, STATES * (VELOCITY + 1), STATES * (VELOCITY + 2)
_P0, _P1, _P2 = STATES * POSITION, STATES * (POSITION + 1), STATES * (POSITION + 2)
INNOVATION, VARIANCE, ERROR, BEFORE, ROWS = 3, 4, 5, 6, 7
"""Rows of the room that `absorb` works in, after its three gains; the filter keeps its error and the attitude
shown before there."""
_FIRST, _SECOND, _FIELD, _DELAY, _IRON, _START, ENTRIES = 0, 1, 2, 3, 4, 7, 8
"""Entries of the row of one component of the field: two of the turn, one each, hard iron's three, the start."""


@borrowing()
def predict(p: Float, sums: Record, settings: Record, ticks: float) -> None:
    """Carry the covariance over a block of `ticks`: P <- F P F' + Q (house note, 5.3, 5.4).

    turn += Phi_b bias + Phi_K gain; velocity -= [s x] turn; position += time velocity; the rest stays.
    Only the first nine rows of F differ from the identity, so only these rows and columns are touched.
    The covariance is flat here and below, so that the compiler sees that rows do not overlap.
    """
    step_s = settings.step_s
    time_s = ticks * step_s
    sx, sy, sz = sums.sum_force[0], sums.sum_force[1], sums.sum_force[2]
    for j in range(STATES):
        p[_P0 + j] += time_s * p[_V0 + j]
        p[_P1 + j] += time_s * p[_V1 + j]
        p[_P2 + j] += time_s * p[_V2 + j]
        tx, ty, tz = p[_T0 + j], p[_T1 + j], p[_T2 + j]
        p[_V0 + j] += sz * ty - sy * tz
        p[_V1 + j] += sx * tz - sz * tx
        p[_V2 + j] += sy * tx - sx * ty
    for c in range(3):
        x = -step_s * sums.sum_rotation[c]
        y = -step_s * sums.sum_rotation[3 + c]
        z = -step_s * sums.sum_rotation[6 + c]
        row, offset = STATES * (BIAS + c), STATES * (OFFSET + c)
        for j in range(STATES):
            source, pushed = p[row + j], p[offset + j]
            p[_T0 + j] += x * source
            p[_T1 + j] += y * source
            p[_T2 + j] += z * source
            p[_V0 + j] += x * pushed
            p[_V1 + j] += y * pushed
            p[_V2 + j] += z * pushed
    for c in range(9):
        x = step_s * sums.sum_gain[c]
        y = step_s * sums.sum_gain[9 + c]
        z = step_s * sums.sum_gain[18 + c]
        row = STATES * (GAIN + c)
        for j in range(STATES):
            source = p[row + j]
            p[_T0 + j] += x * source
            p[_T1 + j] += y * source
            p[_T2 + j] += z * source
    for j in range(STATES):
        p[_V2 + j] -= time_s * p[STATES * WEIGHT + j]
    # Of these rows only what stands above the diagonal: the rest is copied from there.
    for i in range(BIAS):
        row = STATES * i
        for a in range(3):
            p[row + POSITION + a] += time_s * p[row + VELOCITY + a]
        if i >= POSITION:
            continue
        tx, ty, tz = p[row + TURN], p[row + TURN + 1], p[row + TURN + 2]
        p[row + VELOCITY] += sz * ty - sy * tz
        p[row + VELOCITY + 1] += sx * tz - sz * tx
        p[row + VELOCITY + 2] += sy * tx - sx * ty - time_s * p[row + WEIGHT]
        for a in range(3):
            total = 0.0
            for c in range(3):
                total += sums.sum_rotation[3 * a + c] * p[row + OFFSET + c]
            p[row + VELOCITY + a] -= step_s * total
        if i >= VELOCITY:
            continue
        for a in range(3):
            total = 0.0
            for c in range(3):
                total -= sums.sum_rotation[3 * a + c] * p[row + BIAS + c]
            for c in range(9):
                total += sums.sum_gain[9 * a + c] * p[row + GAIN + c]
            p[row + TURN + a] += step_s * total
    turning = settings.rate_noise + settings.rate_noise_per_rate * sums.sum_rate2 / ticks
    for a in range(3):
        p[_DIAGONAL * (TURN + a)] += turning * time_s + sums.gap_turn_variance[a]
        p[_DIAGONAL * (VELOCITY + a)] += settings.speed_noise * time_s + sums.gap_speed_variance[a]
        p[_DIAGONAL * (POSITION + a)] += settings.position_noise * time_s
        p[_DIAGONAL * (BIAS + a)] += settings.bias_drift * time_s
    for i in range(BIAS):
        for j in range(i + 1, STATES):
            p[STATES * j + i] = p[STATES * i + j]


@borrowing("void(float64[::1], float64[::1], float64[:, ::1], int64[:, ::1], float64[:, ::1], int64)")
def absorb(p: Float, error: Float, rows: Float, index: NDArray[np.int64], value: Float, entries: int) -> None:
    """Take three scalar measurements, one after the other, into `error` and `p`.

    Parameters
    ----------
    p : ndarray, shape (STATES * STATES,)
    error : ndarray, shape (STATES,)
    rows : ndarray, shape (VARIANCE + 1 or more, STATES)
        Room for the three gains; then, three each, the innovations and the variances. These become the
        innovation left over its variance, and one over this variance: what a backward pass needs.
    index, value : ndarray, shape (3, ENTRIES)
        The first `entries` hold where the row of a measurement is not zero, and what is there.

    Notes
    -----
    The gains are found in turn and the covariance is changed in one pass, which is three times as fast as
    three passes. The order of the products keeps it symmetric to the last bit.
    """
    first, second, third = rows[0], rows[1], rows[2]
    innovation, variance = rows[INNOVATION], rows[VARIANCE]
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


@borrowing()
def move(memory: Record, settings: Record, ticks: float) -> None:
    """Carry nominal velocity and position."""
    time_s = ticks * settings.step_s
    for a in range(3):
        change = memory.sum_force[a]
        if a == 2:
            change -= memory.gravity * time_s
        memory.position[a] += time_s * (memory.velocity[a] + 0.5 * change)
        memory.velocity[a] += change


@borrowing()
def hold_place(
    p: Float,
    error: Float,
    rows: Float,
    memory: Record,
    settings: Record,
    index: NDArray[np.int64],
    value: Float,
    ticks: float,
    rest: bool,
) -> None:
    """Weigh specific force: the sensor stays near one place; at rest, neither moves nor turns (5.5, 5.8)."""
    time_s = ticks * settings.step_s
    if memory.rested and not rest:
        for a in range(3):
            p[_DIAGONAL * (VELOCITY + a)] += settings.leaving_speed
    memory.rested = rest
    for a in range(3):
        index[a, 0], value[a, 0] = POSITION + a, 1.0
        rows[INNOVATION, a], rows[VARIANCE, a] = -memory.position[a], settings.position_prior / time_s
    absorb(p, error, rows, index, value, 1)
    if not rest:
        return
    for a in range(3):
        index[a, 0] = VELOCITY + a
        rows[INNOVATION, a], rows[VARIANCE, a] = -memory.velocity[a], settings.rest_speed / time_s
    absorb(p, error, rows, index, value, 1)
    variance = rest_variance(p, memory, settings, time_s)
    for a in range(3):
        index[a, 0] = BIAS + a
        rows[INNOVATION, a], rows[VARIANCE, a] = memory.mean_rate[a] - memory.bias[a], variance
    absorb(p, error, rows, index, value, 1)


@borrowing()
def field_rows(sums: Record, field: Float, share: float, index: NDArray[np.int64], value: Float) -> None:
    """Fill the rows of a block's mean field: where the three components depend on the error, and how much."""
    per_field, per_sample = 1.0 / sums.field_count, 1.0 / sums.count
    bx, by, bz = field[0], field[1], field[2]
    index[0, _FIRST], value[0, _FIRST], index[0, _SECOND], value[0, _SECOND] = TURN + 1, -bz, TURN + 2, by
    index[1, _FIRST], value[1, _FIRST], index[1, _SECOND], value[1, _SECOND] = TURN, bz, TURN + 2, -bx
    index[2, _FIRST], value[2, _FIRST], index[2, _SECOND], value[2, _SECOND] = TURN, -by, TURN + 1, bx
    for a in range(3):
        index[a, _FIELD], value[a, _FIELD] = FIELD + a, 1.0
        index[a, _DELAY], value[a, _DELAY] = DELAY, sums.sum_delay[a] * per_field
        for c in range(3):
            index[a, _IRON + c] = IRON + c
            value[a, _IRON + c] = sums.sum_rotation[3 * a + c] * per_sample
        index[a, _START], value[a, _START] = START + a, share


@borrowing()
def see_field(
    p: Float,
    error: Float,
    rows: Float,
    memory: Record,
    index: NDArray[np.int64],
    value: Float,
    variance: float,
) -> None:
    """Take the mean field of the block, all three components (house note, 5.9, in the start frame).

    mean R (m - iron) = FIELD + share START + [FIELD x] turn + R iron + delay mean R (w x m) + noise.
    """
    per_field, share = 1.0 / memory.field_count, memory.start_share
    field_rows(memory, memory.field, share, index, value)
    for a in range(3):
        rows[INNOVATION, a] = memory.sum_field[a] * per_field - memory.field[a] - share * memory.start[a]
        rows[VARIANCE, a] = variance
    absorb(p, error, rows, index, value, ENTRIES if share > 0.0 else _START)


@borrowing()
def inject(memory: Record, error: Float) -> None:
    """Move the error into the estimate and clear it (house note, 5.11)."""
    tw, tx, ty, tz = exponential(error[TURN], error[TURN + 1], error[TURN + 2])
    w, x, y, z = multiply(tw, tx, ty, tz, memory.q[0], memory.q[1], memory.q[2], memory.q[3])
    memory.q[0], memory.q[1], memory.q[2], memory.q[3] = normalized(w, x, y, z)
    for a in range(3):
        memory.velocity[a] += error[VELOCITY + a]
        memory.position[a] += error[POSITION + a]
        memory.bias[a] += error[BIAS + a]
        memory.field[a] += error[FIELD + a]
        memory.iron[a] += error[IRON + a]
        memory.start[a] += error[START + a]
        memory.force_offset[a] += error[OFFSET + a]
    for i in range(9):
        memory.gain[i] += error[GAIN + i]
    memory.delay += error[DELAY]
    memory.gravity += error[WEIGHT]
    for i in range(STATES):
        error[i] = 0.0
