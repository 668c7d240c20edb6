"""The Kalman filter of our own smoother: forward over the blocks of a session, and back."""

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import kernel
from estimators.orientation.smoother._sweep import SUMS
from estimators.orientation.telemotion._block import absorb, predict
from estimators.orientation.telemotion._layout import (
    BIAS,
    DELAY,
    FIELD,
    GAIN,
    IRON,
    MEMORY,
    POSITION,
    POSITION_PRIOR,
    REST_SPEED,
    START,
    STATES,
    STEP_S,
    SUM_DELAY,
    SUM_FIELD,
    SUM_FORCE,
    SUM_GAIN,
    SUM_ROTATION,
    TURN,
    VELOCITY,
)
from estimators.recording import Float

GROUPS = 4
"""Measurements that a block can have, three components each: place, speed and bias at rest, field."""
KEPT = 3 * (STATES + 2)
"""What is kept of a measurement: three gains, innovations left over their variance, one over variance."""

# Columns of what is known about a block beside its sums.
(TICKS, FIELD_TICKS, AT_REST, FIELD_VARIANCE, SHARE, IRON_VARIANCE, RATE, STEP, IRON_STEP, RATE_VARIANCE) = (
    0,
    1,
    2,
    3,
    4,
    5,
    6,
    9,
    12,
    15,
)
FACTS = 16


@kernel(
    "int64(int64, float64[::1], float64[::1], float64[::1], float64[::1], float64[:, ::1], int64[:, ::1],"
    "float64[:, ::1])"
)
def _measured(
    group: int,
    memory: Float,
    facts: Float,
    nominal: Float,
    settings: Float,
    rows: Float,
    index: NDArray[np.int64],
    value: Float,
) -> int:
    """Set a measurement for `absorb`; return how many entries its rows have, 0 if there is none."""
    time_s = facts[TICKS] * settings[STEP_S]
    if group == 3:
        if facts[FIELD_VARIANCE] <= 0.0:
            return 0
        per_field, per_sample = 1.0 / facts[FIELD_TICKS], 1.0 / facts[TICKS]
        bx, by, bz = nominal[FIELD], nominal[FIELD + 1], nominal[FIELD + 2]
        index[0, 0], value[0, 0], index[0, 1], value[0, 1] = TURN + 1, -bz, TURN + 2, by
        index[1, 0], value[1, 0], index[1, 1], value[1, 1] = TURN, bz, TURN + 2, -bx
        index[2, 0], value[2, 0], index[2, 1], value[2, 1] = TURN, -by, TURN + 1, bx
        for a in range(3):
            index[a, 2], value[a, 2] = FIELD + a, 1.0
            index[a, 3], value[a, 3] = DELAY, memory[SUM_DELAY + a] * per_field
            for c in range(3):
                index[a, 4 + c] = IRON + c
                value[a, 4 + c] = memory[SUM_ROTATION + 3 * a + c] * per_sample
            index[a, 7], value[a, 7] = START + a, facts[SHARE]
            expected = nominal[FIELD + a] + facts[SHARE] * nominal[START + a]
            rows[3, a] = memory[SUM_FIELD + a] * per_field - expected
            rows[4, a] = facts[FIELD_VARIANCE]
        return 8
    if group > 0 and facts[AT_REST] == 0.0:
        return 0
    for a in range(3):
        value[a, 0], rows[3, a] = 1.0, 0.0
        if group == 0:
            index[a, 0], rows[4, a] = POSITION + a, settings[POSITION_PRIOR] / time_s
        elif group == 1:
            index[a, 0], rows[4, a] = VELOCITY + a, settings[REST_SPEED] / time_s
        else:
            index[a, 0], rows[4, a] = BIAS + a, facts[RATE_VARIANCE]
            rows[3, a] = facts[RATE + a] - nominal[BIAS + a]
    return 1


@kernel("void(float64[::1], float64[::1], float64, float64, float64)")
def _carry(error: Float, memory: Float, gravity: float, ticks: float, step_s: float) -> None:
    """Carry the error over a block; its velocity and position are whole, their nominal values being zero."""
    time_s = ticks * step_s
    sx, sy, sz = memory[SUM_FORCE], memory[SUM_FORCE + 1], memory[SUM_FORCE + 2]
    tx, ty, tz = error[TURN], error[TURN + 1], error[TURN + 2]
    push = (sx, sy, sz - gravity * time_s)
    bent = (sz * ty - sy * tz, sx * tz - sz * tx, sy * tx - sx * ty)
    for a in range(3):
        error[POSITION + a] += time_s * (error[VELOCITY + a] + 0.5 * push[a])
        error[VELOCITY + a] += push[a] + bent[a]
        turned = 0.0
        for c in range(3):
            turned -= memory[SUM_ROTATION + 3 * a + c] * error[BIAS + c]
        for c in range(9):
            turned += memory[SUM_GAIN + 9 * a + c] * error[GAIN + c]
        error[TURN + a] += step_s * turned


@kernel("void(float64[::1], int64, float64[::1], float64, float64)")
def _carry_back(table: Float, first: int, memory: Float, ticks: float, step_s: float) -> None:
    """Multiply the vector that begins at `first` by F' of `predict`."""
    time_s = ticks * step_s
    turn, bias, gain = first + TURN, first + BIAS, first + GAIN
    sx, sy, sz = memory[SUM_FORCE], memory[SUM_FORCE + 1], memory[SUM_FORCE + 2]
    for a in range(3):
        scaled = step_s * table[turn + a]
        for c in range(3):
            table[bias + c] -= memory[SUM_ROTATION + 3 * a + c] * scaled
        for c in range(9):
            table[gain + c] += memory[SUM_GAIN + 9 * a + c] * scaled
    vx, vy, vz = table[first + VELOCITY], table[first + VELOCITY + 1], table[first + VELOCITY + 2]
    for a in range(3):
        table[first + VELOCITY + a] += time_s * table[first + POSITION + a]
    table[turn] += sy * vz - sz * vy
    table[turn + 1] += sz * vx - sx * vz
    table[turn + 2] += sx * vy - sy * vx


@kernel(
    "void(float64[:, ::1], float64[:, ::1], float64[::1], float64[::1], float64[::1], float64, float64[::1],"
    "float64[:, ::1], float64[:, ::1], float64[:, :, ::1])"
)
def forward(
    sums: Float,
    facts: Float,
    nominal: Float,
    error: Float,
    p: Float,
    gravity: float,
    settings: Float,
    means: Float,
    covariances: Float,
    kept: Float,
) -> None:
    """Filter the error along the nominal trajectory, and keep what the way back needs.

    Parameters
    ----------
    sums, facts : ndarray, shape (B, SUMS) and (B, FACTS)
    nominal : ndarray, shape (STATES,)
    error, p : ndarray, shape (STATES,) and (STATES * STATES,)
        Prior of the error; left as they are after the last block.
    means, covariances : ndarray, shape (B, STATES) and (B, STATES * STATES)
        Filled: the prediction for each block, before its measurements.
    kept : ndarray, shape (B, GROUPS, KEPT)
    """
    memory, rows = np.zeros(MEMORY), np.zeros((5, STATES))
    index, value = np.zeros((3, 8), dtype=np.int64), np.zeros((3, 8))
    for block in range(sums.shape[0]):
        known = facts[block]
        for i in range(SUMS):
            memory[SUM_ROTATION + i] = sums[block, i]
        _carry(error, memory, gravity, known[TICKS], settings[STEP_S])
        predict(p, memory, settings, known[TICKS])
        for a in range(3):
            error[IRON + a] += known[IRON_STEP + a]
            p[(STATES + 1) * (IRON + a)] += known[IRON_VARIANCE]
        for i in range(STATES):
            means[block, i] = error[i]
        for i in range(STATES * STATES):
            covariances[block, i] = p[i]
        for group in range(GROUPS):
            entries = _measured(group, memory, known, nominal, settings, rows, index, value)
            if entries == 0:
                continue
            absorb(p, error, rows, index, value, entries)
            for m in range(3):
                for i in range(STATES):
                    kept[block, group, STATES * m + i] = rows[m, i]
                kept[block, group, 3 * STATES + m] = rows[3, m]
                kept[block, group, 3 * STATES + 3 + m] = rows[4, m]
        for a in range(3):
            error[TURN + a] -= known[STEP + a]


@kernel("float64(float64[::1], float64[::1], float64[::1])")
def _squared(big: Float, left: Float, right: Float) -> float:
    """Return left' big right."""
    total = 0.0
    for i in range(STATES):
        inner = 0.0
        for j in range(STATES):
            inner += big[STATES * i + j] * right[j]
        total += left[i] * inner
    return total


@kernel("void(float64[::1], float64[::1], float64[::1], float64, int64[::1], float64[::1], int64)")
def _widen(
    big: Float,
    product: Float,
    gain: Float,
    one: float,
    index: NDArray[np.int64],
    value: Float,
    entries: int,
) -> None:
    """Carry Lambda back over one scalar measurement whose gain is `gain * one`."""
    whole = 0.0
    for i in range(STATES):
        inner = 0.0
        for j in range(STATES):
            inner += big[STATES * i + j] * gain[j]
        product[i] = inner * one
        whole += gain[i] * product[i]
    whole = whole * one + one
    for e in range(entries):
        row, factor = STATES * index[e], value[e]
        for j in range(STATES):
            big[row + j] -= factor * product[j]
            big[STATES * j + index[e]] -= factor * product[j]
        for f in range(entries):
            big[row + index[f]] += whole * factor * value[f]


@kernel(
    "void(float64[:, ::1], float64[:, ::1], float64[::1], float64[::1], float64[:, ::1], float64[:, ::1],"
    "float64[:, :, ::1], float64[:, ::1], float64[::1], float64[:, ::1], boolean)"
)
def backward(
    sums: Float,
    facts: Float,
    nominal: Float,
    settings: Float,
    means: Float,
    covariances: Float,
    kept: Float,
    smooth: Float,
    adjoint: Float,
    variances: Float,
    uncertain: bool,
) -> None:
    """Smooth the errors (modified Bryson-Frazier; house note, 6.1); no covariance is inverted.

    Parameters
    ----------
    smooth : ndarray, shape (B, STATES)
        Filled: the error at the end of each block, before the step to the next.
    adjoint : ndarray, shape (STATES,)
        Filled: the adjoint before the first block; the smoothed start is the prior less its covariance
        times this.
    variances : ndarray, shape (B, 4)
        Filled if `uncertain`: of the turn about x and y, their covariance, and of the turn about z with
        that of the estimated north.

    Notes
    -----
    Per measurement, in reverse: lambda <- lambda - H' (k' lambda + e / S), Lambda <- (I - k H)' Lambda
    (I - k H) + H' H / S; the smoothed error is x - P lambda with covariance P - P Lambda P.
    """
    memory, rows = np.zeros(MEMORY), np.zeros((5, STATES))
    index, value = np.zeros((3, 8), dtype=np.int64), np.zeros((3, 8))
    big, product = np.zeros(STATES * STATES), np.zeros(STATES)
    level = nominal[FIELD] ** 2 + nominal[FIELD + 1] ** 2
    by_east = nominal[FIELD + 1] / level if level > 0.0 else 0.0
    by_north = -nominal[FIELD] / level if level > 0.0 else 0.0
    looks = np.zeros((4, STATES))
    for i in range(STATES):
        adjoint[i] = 0.0
    for block in range(sums.shape[0] - 1, -1, -1):
        known = facts[block]
        for i in range(SUMS):
            memory[SUM_ROTATION + i] = sums[block, i]
        for group in range(GROUPS - 1, -1, -1):
            entries = _measured(group, memory, known, nominal, settings, rows, index, value)
            if entries == 0:
                continue
            for m in range(2, -1, -1):
                gain, one = (
                    kept[block, group, STATES * m : STATES * (m + 1)],
                    kept[block, group, 3 * STATES + 3 + m],
                )
                total = 0.0
                for i in range(STATES):
                    total += gain[i] * adjoint[i]
                total = one * total + kept[block, group, 3 * STATES + m]
                for e in range(entries):
                    adjoint[index[m, e]] -= value[m, e] * total
                if uncertain:
                    _widen(big, product, gain, one, index[m], value[m], entries)
        p = covariances[block]
        for i in range(STATES):
            total = means[block, i]
            row = p[STATES * i : STATES * i + STATES]
            for j in range(STATES):
                total -= row[j] * adjoint[j]
            smooth[block, i] = total
        if uncertain:
            for i in range(STATES):
                looks[0, i], looks[1, i] = p[STATES * TURN + i], p[STATES * (TURN + 1) + i]
                looks[2, i] = (
                    p[STATES * (TURN + 2) + i]
                    + by_east * p[STATES * FIELD + i]
                    + by_north * p[STATES * (FIELD + 1) + i]
                )
            variances[block, 0] = looks[0, TURN] - _squared(big, looks[0], looks[0])
            variances[block, 1] = looks[1, TURN + 1] - _squared(big, looks[1], looks[1])
            variances[block, 2] = looks[0, TURN + 1] - _squared(big, looks[0], looks[1])
            own = looks[2, TURN + 2] + by_east * looks[2, FIELD] + by_north * looks[2, FIELD + 1]
            variances[block, 3] = own - _squared(big, looks[2], looks[2])
        _carry_back(adjoint, 0, memory, known[TICKS], settings[STEP_S])
        if uncertain:
            for _ in range(2):  # F' Lambda F: the rows, transpose, the rows again
                for i in range(STATES):
                    _carry_back(big, STATES * i, memory, known[TICKS], settings[STEP_S])
                for i in range(STATES):
                    for j in range(i):
                        big[STATES * i + j], big[STATES * j + i] = big[STATES * j + i], big[STATES * i + j]


__all__ = ["FACTS", "GROUPS", "KEPT", "backward", "forward"]
