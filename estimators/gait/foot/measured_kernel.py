"""Measurements of the foot filter at a sample, compiled: stance, standstill, height and heading as scalar rows."""

import math

import numpy as np

from estimators._kernels import Scalars3, rotate, wrapped
from estimators.gait.foot import layout as at
from estimators.gait.foot.step_kernel import matrix_of
from estimators.kernels import step
from estimators.recording import Float

_N = at.ERRORS
_P, _V, _Q, _BG, _R = at.P, at.V, at.Q, at.GYROSCOPE_BIAS, at.PIVOT
_EV, _EQ, _EBG, _ER = at.E_V, at.E_Q, at.E_GYROSCOPE_BIAS, at.E_PIVOT
_STANCE, _STANDSTILL, _HEIGHT, _HEADING = at.STANCE, at.STANDSTILL, at.HEIGHT, at.HEADING
_FLOOR, _FLOOR_KNOWN = at.FLOOR, at.FLOOR_KNOWN
_F_HEADING, _F_STRENGTH = at.FIELD_HEADING, at.FIELD_STRENGTH
_F_VERTICAL, _F_KNOWN = at.FIELD_VERTICAL, at.FIELD_KNOWN
_S_STANDSTILL, _S_FLAT = at.S_STANDSTILL, at.S_FLAT
_S_HEIGHT_SIGMA, _S_HEIGHT_SCALE, _S_HEIGHT_GATE = at.S_HEIGHT_SIGMA, at.S_HEIGHT_SCALE, at.S_HEIGHT_GATE
_S_FIELD_SIGMA, _S_FIELD_TOLERANCE = at.S_FIELD_SIGMA, at.S_FIELD_TOLERANCE


@step()
def _stance_rows(
    x: Float, rate: Scalars3, sigma_mps: float, matrix: Float, rows: Float, residual: Float, variance: Float
) -> None:
    """Write eq. (13): the contact point stands, so the sensor moves with omega x r."""
    bx = rate[1] * x[_R + 2] - rate[2] * x[_R + 1]
    by = rate[2] * x[_R] - rate[0] * x[_R + 2]
    bz = rate[0] * x[_R + 1] - rate[1] * x[_R]
    u = rotate(x[_Q], x[_Q + 1], x[_Q + 2], x[_Q + 3], bx, by, bz)
    for i in range(3):
        rows[i, :] = 0.0
        rows[i, _EV + i] = 1.0
        after, before = (i + 1) % 3, (i + 2) % 3
        # [u] has u_before to the right of the diagonal with a minus sign, cyclically.
        rows[i, _EQ + after] = -u[before]
        rows[i, _EQ + before] = u[after]
        m0, m1, m2 = matrix[3 * i], matrix[3 * i + 1], matrix[3 * i + 2]
        rows[i, _ER] = -(m1 * rate[2] - m2 * rate[1])
        rows[i, _ER + 1] = -(m2 * rate[0] - m0 * rate[2])
        rows[i, _ER + 2] = -(m0 * rate[1] - m1 * rate[0])
        residual[i] = u[i] - x[_V + i]
        variance[i] = sigma_mps * sigma_mps


@step()
def _heading_seen(x: Float, field: Float, memory: Float, tolerance: float) -> float:
    """Return how far the field points off where it first did; NaN where it is the first or another field."""
    b = rotate(x[_Q], x[_Q + 1], x[_Q + 2], x[_Q + 3], field[0], field[1], field[2])
    strength = math.sqrt(b[0] * b[0] + b[1] * b[1] + b[2] * b[2])
    heading = math.atan2(b[1], b[0])
    if memory[_F_KNOWN] == 0.0:
        memory[_F_KNOWN] = 1.0
        memory[_F_HEADING] = heading
        memory[_F_STRENGTH] = strength
        memory[_F_VERTICAL] = b[2]
        return math.nan
    limit = tolerance * memory[_F_STRENGTH]
    if abs(strength - memory[_F_STRENGTH]) < limit and abs(b[2] - memory[_F_VERTICAL]) < limit:
        return wrapped(memory[_F_HEADING] - heading)
    return math.nan


@step(
    "int64(int64, float64[::1], float64[::1], float64[::1], float64, float64[::1], float64[::1], float64[::1],"
    " float64[:, ::1], float64[::1], float64[::1])"
)
def measured_rows(
    bits: int,
    gyroscope: Float,
    field: Float,
    x: Float,
    sigma_mps: float,
    memory: Float,
    s: Float,
    matrix: Float,
    rows: Float,
    residual: Float,
    variance: Float,
) -> int:
    """Write what is measured at this sample as independent scalars; returns how many."""
    count = 0
    matrix_of(x[_Q], x[_Q + 1], x[_Q + 2], x[_Q + 3], matrix)
    rate = (gyroscope[0] - x[_BG], gyroscope[1] - x[_BG + 1], gyroscope[2] - x[_BG + 2])
    if bits & _STANCE:
        _stance_rows(x, rate, sigma_mps, matrix, rows, residual, variance)
        count = 3
    if bits & _STANDSTILL:
        for i in range(3):
            rows[count, :] = 0.0
            rows[count, _EBG + i] = 1.0
            residual[count] = rate[i]
            variance[count] = s[_S_STANDSTILL] * s[_S_STANDSTILL]
            count += 1
    if bits & _HEIGHT and memory[_FLOOR_KNOWN] > 0.0:
        # eq. (15)
        d = memory[_FLOOR] - x[_P + 2]
        if abs(d) < s[_S_HEIGHT_GATE] or s[_S_FLAT] > 0.0:
            loose = 1.0 if s[_S_FLAT] > 0.0 else 1.0 + (d / s[_S_HEIGHT_SCALE]) ** 2
            rows[count, :] = 0.0
            rows[count, 2] = 1.0
            residual[count] = d
            variance[count] = (s[_S_HEIGHT_SIGMA] * loose) ** 2
            count += 1
    if bits & _HEADING:
        off = _heading_seen(x, field, memory, s[_S_FIELD_TOLERANCE])
        if not math.isnan(off):
            rows[count, :] = 0.0
            rows[count, _EQ + 2] = 1.0
            residual[count] = off
            variance[count] = s[_S_FIELD_SIGMA] ** 2
            count += 1
    return count


@step("float64(float64[:, ::1], float64[:, ::1], float64[::1], float64[::1])")
def surprise(p: Float, rows: Float, residual: Float, variance: Float) -> float:
    """Return the squared innovation of the first three measurements over its covariance."""
    s = np.empty((3, 3))
    for a in range(3):
        for b in range(a + 1):
            total = variance[a] if a == b else 0.0
            for i in range(_N):
                if rows[a, i] != 0.0:
                    value = 0.0
                    for j in range(_N):
                        value += p[i, j] * rows[b, j]
                    total += rows[a, i] * value
            s[a, b] = total
    # Cholesky's square root, row by row: |L^-1 y|^2
    l00 = math.sqrt(s[0, 0])
    l10 = s[1, 0] / l00
    l11 = math.sqrt(s[1, 1] - l10 * l10)
    l20 = s[2, 0] / l00
    l21 = (s[2, 1] - l20 * l10) / l11
    l22 = math.sqrt(s[2, 2] - l20 * l20 - l21 * l21)
    e0 = residual[0] / l00
    e1 = (residual[1] - l10 * e0) / l11
    e2 = (residual[2] - l20 * e0 - l21 * e1) / l22
    return float(e0 * e0 + e1 * e1 + e2 * e2)
