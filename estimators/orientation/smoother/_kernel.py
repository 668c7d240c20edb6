"""The Kalman filter of our own smoother: forward over the blocks of a session, and back."""

from typing import Final

import numba
import numpy as np
from numba import types
from numpy.typing import NDArray

from estimators._kernels import kernel
from estimators.kernels import VOID, Record, record, step
from estimators.kernels import rows as rows_of
from estimators.orientation.telemotion._block import (
    ENTRIES,
    INNOVATION,
    VARIANCE,
    absorb,
    field_rows,
    predict,
)
from estimators.orientation.telemotion._records import (
    BIAS,
    FIELD,
    GAIN,
    IRON,
    OFFSET,
    POSITION,
    SETTINGS,
    START,
    STATES,
    SUMS,
    TURN,
    VELOCITY,
    WEIGHT,
)
from estimators.recording import Float

GROUPS = 4
"""Measurements that a block can have, three components each: place, speed and bias at rest, field."""
RETAINED_INNOVATION, RETAINED_INVERSE, RETAINED = 3 * STATES, 3 * STATES + 3, 3 * STATES + 6
"""What is retained of a measurement: three gains, innovations left over their variance, one over variance."""
TURN_X, TURN_Y, TURN_XY, TURN_NORTH, VARIANCES = range(5)
"""Variances of a block: of the turn about x and y, their covariance, of the turn about z with the estimated north."""

FACTS: Final = record(
    [
        ("is_at_rest", "i8"),
        ("field_variance", "f8"),  # zero: the block has no field
        ("share", "f8"),  # of the start place in the field
        ("iron_variance", "f8"),
        ("rate_variance", "f8"),
        ("rate", "f8", 3),  # mean raw rate
        ("step", "f8", 3),  # from where the nominal turn arrives to where the next block begins
        ("iron_step", "f8", 3),
    ]
)
"""What is known about a block beside its sums."""

_F1, _F2, _F3 = types.float64[::1], types.float64[:, ::1], types.float64[:, :, ::1]
_SETTINGS = numba.from_dtype(SETTINGS)


@step()
def _measured(
    group: int,
    sums: Record,
    facts: Record,
    nominal: Float,
    settings: Record,
    rows: Float,
    index: NDArray[np.int64],
    value: Float,
) -> int:
    """Set a measurement for `absorb`; return how many entries its rows have, 0 if there is none."""
    time_s = sums.count * settings.step_s
    if group == 3:
        if facts.field_variance <= 0.0:
            return 0
        per_field = 1.0 / sums.field_count
        field_rows(sums, nominal[FIELD : FIELD + 3], facts.share, index, value)
        for a in range(3):
            expected = nominal[FIELD + a] + facts.share * nominal[START + a]
            rows[INNOVATION, a] = sums.sum_field[a] * per_field - expected
            rows[VARIANCE, a] = facts.field_variance
        return ENTRIES
    if group > 0 and not facts.is_at_rest:
        return 0
    for a in range(3):
        value[a, 0], rows[INNOVATION, a] = 1.0, 0.0
        if group == 0:
            index[a, 0], rows[VARIANCE, a] = POSITION + a, settings.position_prior / time_s
        elif group == 1:
            index[a, 0], rows[VARIANCE, a] = VELOCITY + a, settings.rest_speed / time_s
        else:
            index[a, 0], rows[VARIANCE, a] = BIAS + a, facts.rate_variance
            rows[INNOVATION, a] = facts.rate[a] - nominal[BIAS + a]
    return 1


@step()
def _carry(error: Float, sums: Record, gravity: float, ticks: float, step_s: float) -> None:
    """Carry the error over a block; its velocity and position are whole, their nominal values being zero."""
    time_s = ticks * step_s
    sx, sy, sz = sums.sum_force[0], sums.sum_force[1], sums.sum_force[2]
    tx, ty, tz = error[TURN], error[TURN + 1], error[TURN + 2]
    push = (sx, sy, sz - gravity * time_s)
    bent = (sz * ty - sy * tz, sx * tz - sz * tx, sy * tx - sx * ty)
    for a in range(3):
        error[POSITION + a] += time_s * (error[VELOCITY + a] + 0.5 * push[a])
        error[VELOCITY + a] += push[a] + bent[a]
        for c in range(3):
            error[VELOCITY + a] -= step_s * sums.sum_rotation[3 * a + c] * error[OFFSET + c]
        turned = 0.0
        for c in range(3):
            turned -= sums.sum_rotation[3 * a + c] * error[BIAS + c]
        for c in range(9):
            turned += sums.sum_gain[9 * a + c] * error[GAIN + c]
        error[TURN + a] += step_s * turned
    error[VELOCITY + 2] -= time_s * error[WEIGHT]


@step()
def _carry_back(table: Float, first: int, sums: Record, ticks: float, step_s: float) -> None:
    """Multiply the vector that begins at `first` by F' of `predict`."""
    time_s = ticks * step_s
    turn, bias, gain = first + TURN, first + BIAS, first + GAIN
    sx, sy, sz = sums.sum_force[0], sums.sum_force[1], sums.sum_force[2]
    for a in range(3):
        scaled = step_s * table[turn + a]
        for c in range(3):
            table[bias + c] -= sums.sum_rotation[3 * a + c] * scaled
        for c in range(9):
            table[gain + c] += sums.sum_gain[9 * a + c] * scaled
    vx, vy, vz = table[first + VELOCITY], table[first + VELOCITY + 1], table[first + VELOCITY + 2]
    for a in range(3):
        pushed = step_s * table[first + VELOCITY + a]
        for c in range(3):
            table[first + OFFSET + c] -= sums.sum_rotation[3 * a + c] * pushed
    table[first + WEIGHT] -= time_s * vz
    for a in range(3):
        table[first + VELOCITY + a] += time_s * table[first + POSITION + a]
    table[turn] += sy * vz - sz * vy
    table[turn + 1] += sz * vx - sx * vz
    table[turn + 2] += sx * vy - sy * vx


@kernel(VOID(rows_of(SUMS), rows_of(FACTS), _F1, _F1, _F1, types.float64, _SETTINGS, _F2, _F2, _F3))
def forward(
    sums: NDArray[np.void],
    facts: NDArray[np.void],
    nominal: Float,
    error: Float,
    p: Float,
    gravity: float,
    settings: Record,
    means: Float,
    covariances: Float,
    retained: Float,
) -> None:
    """Filter the error along the nominal trajectory, and keep what the way back needs.

    Parameters
    ----------
    sums, facts : ndarray of SUMS and of FACTS, shape (B,)
    nominal : ndarray, shape (STATES,)
    error, p : ndarray, shape (STATES,) and (STATES * STATES,)
        Prior of the error; left as they are after the last block.
    means, covariances : ndarray, shape (B, STATES) and (B, STATES * STATES)
        Filled: the prediction for each block, before its measurements.
    retained : ndarray, shape (B, GROUPS, RETAINED)
    """
    rows = np.zeros((VARIANCE + 1, STATES))
    index, value = np.zeros((3, ENTRIES), dtype=np.int64), np.zeros((3, ENTRIES))
    for block in range(sums.shape[0]):
        known, one = facts[block], sums[block]
        _carry(error, one, gravity, float(one.count), settings.step_s)
        predict(p, one, settings, float(one.count))
        for a in range(3):
            error[IRON + a] += known.iron_step[a]
            p[(STATES + 1) * (IRON + a)] += known.iron_variance
        for i in range(STATES):
            means[block, i] = error[i]
        for i in range(STATES * STATES):
            covariances[block, i] = p[i]
        for group in range(GROUPS):
            entries = _measured(group, one, known, nominal, settings, rows, index, value)
            if entries == 0:
                continue
            absorb(p, error, rows, index, value, entries)
            for m in range(3):
                for i in range(STATES):
                    retained[block, group, STATES * m + i] = rows[m, i]
                retained[block, group, RETAINED_INNOVATION + m] = rows[INNOVATION, m]
                retained[block, group, RETAINED_INVERSE + m] = rows[VARIANCE, m]
        for a in range(3):
            error[TURN + a] -= known.step[a]


@step("float64(float64[::1], float64[::1], float64[::1])")
def _squared(big: Float, left: Float, right: Float) -> float:
    """Return left' big right."""
    total = 0.0
    for i in range(STATES):
        inner = 0.0
        for j in range(STATES):
            inner += big[STATES * i + j] * right[j]
        total += left[i] * inner
    return total


@step("void(float64[::1], float64[::1], float64[::1], float64, int64[::1], float64[::1], int64)")
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


@kernel(VOID(rows_of(SUMS), rows_of(FACTS), _F1, _SETTINGS, _F2, _F2, _F3, _F2, _F1, _F2, types.boolean))
def backward(
    sums: NDArray[np.void],
    facts: NDArray[np.void],
    nominal: Float,
    settings: Record,
    means: Float,
    covariances: Float,
    retained: Float,
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
    variances : ndarray, shape (B, VARIANCES)
        Filled if `uncertain`.

    Notes
    -----
    Per measurement, in reverse: lambda <- lambda - H' (k' lambda + e / S), Lambda <- (I - k H)' Lambda
    (I - k H) + H' H / S; the smoothed error is x - P lambda with covariance P - P Lambda P.
    """
    rows = np.zeros((VARIANCE + 1, STATES))
    index, value = np.zeros((3, ENTRIES), dtype=np.int64), np.zeros((3, ENTRIES))
    big, product = np.zeros(STATES * STATES), np.zeros(STATES)
    level = nominal[FIELD] ** 2 + nominal[FIELD + 1] ** 2
    by_east = nominal[FIELD + 1] / level if level > 0.0 else 0.0
    by_north = -nominal[FIELD] / level if level > 0.0 else 0.0
    look_x, look_y, look_north = np.zeros(STATES), np.zeros(STATES), np.zeros(STATES)
    for i in range(STATES):
        adjoint[i] = 0.0
    for block in range(sums.shape[0] - 1, -1, -1):
        known, one = facts[block], sums[block]
        for group in range(GROUPS - 1, -1, -1):
            entries = _measured(group, one, known, nominal, settings, rows, index, value)
            if entries == 0:
                continue
            for m in range(2, -1, -1):
                gain, inverse = (
                    retained[block, group, STATES * m : STATES * (m + 1)],
                    retained[block, group, RETAINED_INVERSE + m],
                )
                total = 0.0
                for i in range(STATES):
                    total += gain[i] * adjoint[i]
                total = inverse * total + retained[block, group, RETAINED_INNOVATION + m]
                for e in range(entries):
                    adjoint[index[m, e]] -= value[m, e] * total
                if uncertain:
                    _widen(big, product, gain, inverse, index[m], value[m], entries)
        p = covariances[block]
        for i in range(STATES):
            total = means[block, i]
            row = p[STATES * i : STATES * i + STATES]
            for j in range(STATES):
                total -= row[j] * adjoint[j]
            smooth[block, i] = total
        if uncertain:
            for i in range(STATES):
                look_x[i], look_y[i] = p[STATES * TURN + i], p[STATES * (TURN + 1) + i]
                look_north[i] = (
                    p[STATES * (TURN + 2) + i]
                    + by_east * p[STATES * FIELD + i]
                    + by_north * p[STATES * (FIELD + 1) + i]
                )
            variances[block, TURN_X] = look_x[TURN] - _squared(big, look_x, look_x)
            variances[block, TURN_Y] = look_y[TURN + 1] - _squared(big, look_y, look_y)
            variances[block, TURN_XY] = look_x[TURN + 1] - _squared(big, look_x, look_y)
            own = look_north[TURN + 2] + by_east * look_north[FIELD] + by_north * look_north[FIELD + 1]
            variances[block, TURN_NORTH] = own - _squared(big, look_north, look_north)
        _carry_back(adjoint, 0, one, float(one.count), settings.step_s)
        if uncertain:
            for _ in range(2):  # F' Lambda F: the rows, transpose, the rows again
                for i in range(STATES):
                    _carry_back(big, STATES * i, one, float(one.count), settings.step_s)
                for i in range(STATES):
                    for j in range(i):
                        big[STATES * i + j], big[STATES * j + i] = big[STATES * j + i], big[STATES * i + j]
