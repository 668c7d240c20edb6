"""The foot filter, compiled: strapdown, error covariance, stance measurements, and the way back.

The smoother is that of Bryson and Frazier: the way back carries an adjoint vector and needs no inverse, so it costs
a tenth of the way there. For the same linear model it equals the smoother of Rauch, Tung and Striebel, eq. (16)
of the method page, which is the twin in the tests.
"""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import exponential, kernel, multiply, normalized, rotate, wrapped
from estimators.conventions import GRAVITY_MPS2
from estimators.gait import _foot_layout as at
from estimators.recording import Float

_G = GRAVITY_MPS2
_N = at.ERRORS
_S = at.STATE
_POSITION_DENSITY2 = 1e-10
_P, _V, _Q, _BG, _BA, _R = at.P, at.V, at.Q, at.GYROSCOPE_BIAS, at.ACCELEROMETER_BIAS, at.PIVOT
_EV, _EQ, _EBG, _EBA, _ER = at.E_V, at.E_Q, at.E_GYROSCOPE_BIAS, at.E_ACCELEROMETER_BIAS, at.E_PIVOT
_GYRO, _ACC, _STARTED = at.LAST_GYROSCOPE, at.LAST_ACCELEROMETER, at.STARTED
_STANCE, _STANDSTILL, _HEIGHT, _HEADING = at.STANCE, at.STANDSTILL, at.HEIGHT, at.HEADING
_FLOOR, _FLOOR_KNOWN = at.FLOOR, at.FLOOR_KNOWN
_F_HEADING, _F_STRENGTH = at.FIELD_HEADING, at.FIELD_STRENGTH
_F_VERTICAL, _F_KNOWN = at.FIELD_VERTICAL, at.FIELD_KNOWN
_S_STANDSTILL, _S_FLAT = at.S_STANDSTILL, at.S_FLAT
_S_HEIGHT_SIGMA, _S_HEIGHT_SCALE, _S_HEIGHT_GATE = at.S_HEIGHT_SIGMA, at.S_HEIGHT_SCALE, at.S_HEIGHT_GATE
_S_PIVOT, _S_BG, _S_BA = at.S_PIVOT_DENSITY2, at.S_GYROSCOPE_BIAS_DENSITY2, at.S_ACCELEROMETER_BIAS_DENSITY2
_S_FIELD_SIGMA, _S_FIELD_TOLERANCE = at.S_FIELD_SIGMA, at.S_FIELD_TOLERANCE
_SINCE, _BELIEVED = at.SINCE, at.BELIEVED_SIGMA
_S_GATE, _S_GATE_RATIO, _S_GATE_TIME = at.S_GATE, at.S_GATE_RATIO, at.S_GATE_TIME
_RUN_S = 0.1
_M, _FORCE, _H = at.STEP_MATRIX, at.STEP_FORCE, at.STEP_TIME


@kernel("void(float64, float64, float64, float64, float64[::1])")
def _matrix(w: float, x: float, y: float, z: float, out: Float) -> None:
    """Write the rotation matrix of a quaternion, row by row, at the start of `out`."""
    out[0] = 1.0 - 2.0 * (y * y + z * z)
    out[1] = 2.0 * (x * y - w * z)
    out[2] = 2.0 * (x * z + w * y)
    out[3] = 2.0 * (x * y + w * z)
    out[4] = 1.0 - 2.0 * (x * x + z * z)
    out[5] = 2.0 * (y * z - w * x)
    out[6] = 2.0 * (x * z - w * y)
    out[7] = 2.0 * (y * z + w * x)
    out[8] = 1.0 - 2.0 * (x * x + y * y)


@kernel("void(float64[::1], float64[::1], float64[::1])")
def _correct(x: Float, error: Float, out: Float) -> None:
    """Write the state moved by an error."""
    for i in range(3):
        out[_P + i] = x[_P + i] + error[i]
        out[_V + i] = x[_V + i] + error[_EV + i]
        out[_BG + i] = x[_BG + i] + error[_EBG + i]
        out[_BA + i] = x[_BA + i] + error[_EBA + i]
        out[_R + i] = x[_R + i] + error[_ER + i]
    tw, tx, ty, tz = exponential(error[_EQ], error[_EQ + 1], error[_EQ + 2])
    qw, qx, qy, qz = multiply(tw, tx, ty, tz, x[_Q], x[_Q + 1], x[_Q + 2], x[_Q + 3])
    out[_Q], out[_Q + 1], out[_Q + 2], out[_Q + 3] = normalized(qw, qx, qy, qz)


@kernel("void(float64[::1], float64[:, ::1], float64[::1], float64, float64[::1], float64[::1])")
def _spread(step: Float, p: Float, rate_variance: Float, force_variance: float, s: Float, w: Float) -> None:
    """Carry the covariance over one step, eq. (9) and (10), by blocks: P <- F P F^T + Q."""
    h = step[_H]
    fx, fy, fz = step[_FORCE], step[_FORCE + 1], step[_FORCE + 2]
    for side in range(2):
        for j in range(_N):
            if side == 0:
                for i in range(15):
                    w[i] = p[i, j]
            else:
                for i in range(15):
                    w[i] = p[j, i]
            tx, ty, tz = w[_EQ], w[_EQ + 1], w[_EQ + 2]
            cx = -h * (fy * tz - fz * ty)
            cy = -h * (fz * tx - fx * tz)
            cz = -h * (fx * ty - fy * tx)
            for i in range(3):
                row = 3 * i
                pushed = cx if i == 0 else (cy if i == 1 else cz)
                turned = 0.0
                for k in range(3):
                    pushed -= h * step[row + k] * w[_EBA + k]
                    turned -= h * step[row + k] * w[_EBG + k]
                position = w[i] + h * w[_EV + i] + 0.5 * h * pushed
                if side == 0:
                    p[i, j] = position
                    p[_EV + i, j] = w[_EV + i] + pushed
                    p[_EQ + i, j] = w[_EQ + i] + turned
                else:
                    p[j, i] = position
                    p[j, _EV + i] = w[_EV + i] + pushed
                    p[j, _EQ + i] = w[_EQ + i] + turned
    for i in range(_N):
        for j in range(i):
            p[j, i] = p[i, j]
    for i in range(3):
        p[i, i] += force_variance * h * h * h / 3.0 + _POSITION_DENSITY2 * h
        p[_EV + i, _EV + i] += force_variance * h
        p[_EBG + i, _EBG + i] += s[_S_BG] * h
        p[_EBA + i, _EBA + i] += s[_S_BA] * h
        p[_ER + i, _ER + i] += s[_S_PIVOT] * h
        for j in range(3):
            total = 0.0
            for k in range(3):
                total += step[3 * i + k] * rate_variance[k] * step[3 * j + k]
            p[_EQ + i, _EQ + j] += total * h


@kernel("void(float64[::1], float64[::1], float64[::1], float64, float64[::1])")
def _move(x: Float, gyroscope: Float, memory: Float, h: float, step: Float) -> None:
    """Carry the state over one step, eq. (7) and (8), and write what the step looked like."""
    wx = 0.5 * (memory[_GYRO] + gyroscope[0]) - x[_BG]
    wy = 0.5 * (memory[_GYRO + 1] + gyroscope[1]) - x[_BG + 1]
    wz = 0.5 * (memory[_GYRO + 2] + gyroscope[2]) - x[_BG + 2]
    hw, hx, hy, hz = exponential(0.5 * h * wx, 0.5 * h * wy, 0.5 * h * wz)
    mw, mx, my, mz = multiply(x[_Q], x[_Q + 1], x[_Q + 2], x[_Q + 3], hw, hx, hy, hz)
    qw, qx, qy, qz = multiply(mw, mx, my, mz, hw, hx, hy, hz)
    _matrix(mw, mx, my, mz, step)
    step[_H] = h
    force = rotate(
        mw,
        mx,
        my,
        mz,
        memory[_ACC] - x[_BA],
        memory[_ACC + 1] - x[_BA + 1],
        memory[_ACC + 2] - x[_BA + 2],
    )
    for i in range(3):
        step[_FORCE + i] = force[i]
        acceleration = force[i] - (_G if i == 2 else 0.0)
        x[_P + i] += x[_V + i] * h + 0.5 * acceleration * h * h
        x[_V + i] += acceleration * h
    x[_Q], x[_Q + 1], x[_Q + 2], x[_Q + 3] = normalized(qw, qx, qy, qz)


@kernel(
    "int64(int64, float64[::1], float64[::1], float64[::1], float64, float64[::1], float64[::1], float64[::1],"
    " float64[:, ::1], float64[::1], float64[::1])"
)
def _rows(
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
    _matrix(x[_Q], x[_Q + 1], x[_Q + 2], x[_Q + 3], matrix)
    rate = (gyroscope[0] - x[_BG], gyroscope[1] - x[_BG + 1], gyroscope[2] - x[_BG + 2])
    if bits & _STANCE:
        # eq. (13): the contact point stands, so the sensor moves with omega x r.
        bx = rate[1] * x[_R + 2] - rate[2] * x[_R + 1]
        by = rate[2] * x[_R] - rate[0] * x[_R + 2]
        bz = rate[0] * x[_R + 1] - rate[1] * x[_R]
        u = rotate(x[_Q], x[_Q + 1], x[_Q + 2], x[_Q + 3], bx, by, bz)
        for i in range(3):
            rows[count, :] = 0.0
            rows[count, _EV + i] = 1.0
            after, before = (i + 1) % 3, (i + 2) % 3
            # [u] has u_before to the right of the diagonal with a minus sign, cyclically.
            rows[count, _EQ + after] = -u[before]
            rows[count, _EQ + before] = u[after]
            m0, m1, m2 = matrix[3 * i], matrix[3 * i + 1], matrix[3 * i + 2]
            rows[count, _ER] = -(m1 * rate[2] - m2 * rate[1])
            rows[count, _ER + 1] = -(m2 * rate[0] - m0 * rate[2])
            rows[count, _ER + 2] = -(m0 * rate[1] - m1 * rate[0])
            residual[count] = u[i] - x[_V + i]
            variance[count] = sigma_mps * sigma_mps
            count += 1
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
        b = rotate(x[_Q], x[_Q + 1], x[_Q + 2], x[_Q + 3], field[0], field[1], field[2])
        strength = math.sqrt(b[0] * b[0] + b[1] * b[1] + b[2] * b[2])
        heading = math.atan2(b[1], b[0])
        if memory[_F_KNOWN] == 0.0:
            memory[_F_KNOWN] = 1.0
            memory[_F_HEADING] = heading
            memory[_F_STRENGTH] = strength
            memory[_F_VERTICAL] = b[2]
        else:
            limit = s[_S_FIELD_TOLERANCE] * memory[_F_STRENGTH]
            is_alike = abs(strength - memory[_F_STRENGTH]) < limit and abs(b[2] - memory[_F_VERTICAL]) < limit
            if is_alike:
                rows[count, :] = 0.0
                rows[count, _EQ + 2] = 1.0
                residual[count] = wrapped(memory[_F_HEADING] - heading)
                variance[count] = s[_S_FIELD_SIGMA] ** 2
                count += 1
    return count


@kernel("float64(float64[:, ::1], float64[:, ::1], float64[::1], float64[::1])")
def _surprise(p: Float, rows: Float, residual: Float, variance: Float) -> float:
    """Return the squared innovation of the first three measurements over its covariance."""
    s = np.empty(6)
    for a in range(3):
        for b in range(a + 1):
            total = variance[a] if a == b else 0.0
            for i in range(_N):
                if rows[a, i] != 0.0:
                    value = 0.0
                    for j in range(_N):
                        value += p[i, j] * rows[b, j]
                    total += rows[a, i] * value
            s[a * (a + 1) // 2 + b] = total
    # Cholesky's square root, row by row: |L^-1 y|^2
    l00 = math.sqrt(s[0])
    l10 = s[1] / l00
    l11 = math.sqrt(s[2] - l10 * l10)
    l20 = s[3] / l00
    l21 = (s[4] - l20 * l10) / l11
    l22 = math.sqrt(s[5] - l20 * l20 - l21 * l21)
    e0 = residual[0] / l00
    e1 = (residual[1] - l10 * e0) / l11
    e2 = (residual[2] - l20 * e0 - l21 * e1) / l22
    return float(e0 * e0 + e1 * e1 + e2 * e2)


@kernel(
    "void(float64[::1], float64[:, ::1], float64[:, ::1], float64[::1], uint8[::1], float64[::1],"
    " float64[::1], float64[:, ::1], float64[:, ::1], float64[::1], float64[::1], float64[:, ::1],"
    " float64[::1], float64[:, ::1], float64[:, :, ::1], float64[:, ::1], int64[::1], float64[:, :, ::1],"
    " float64[:, :, ::1], float64[:, ::1], float64[:, ::1], float64[:, ::1])"
)
def forward(
    step_s: Float,
    gyroscope_radps: Float,
    accelerometer_mps2: Float,
    sigma_mps: Float,
    bits: NDArray[np.uint8],
    force_variance: Float,
    settings: Float,
    rate_variance: Float,
    field: Float,
    memory: Float,
    x: Float,
    p: Float,
    scratch: Float,
    prior: Float,
    prior_p: Float,
    steps: Float,
    row_count: NDArray[np.int64],
    rows: Float,
    gains: Float,
    ratios: Float,
    posterior: Float,
    spread: Float,
) -> None:
    """Run the filter over K samples.

    Parameters
    ----------
    step_s : ndarray, shape (K,)
        Since the sample before.
    gyroscope_radps, accelerometer_mps2 : ndarray, shape (K, 3)
    sigma_mps : ndarray, shape (K,)
        Standard deviation of the contact point's velocity in stance.
    bits : ndarray of uint8, shape (K,)
        What is measured: STANCE, STANDSTILL, HEIGHT, HEADING. Set to zero where a stance is not believed.
    force_variance : ndarray, shape (K,)
        Noise density squared of specific force, eq. (11).
    settings : ndarray, shape (SETTINGS,)
    rate_variance : ndarray, shape (K, 3)
        Noise density squared of the gyroscope, eq. (12).
    field : ndarray, shape (K, 3) or (0, 3)
        Magnetic field, sensor axes, any unit; read where `bits` has HEADING.
    memory, x, p : ndarray
        Memory, state and covariance; input and output.
    scratch : ndarray, shape (ERRORS,)
    prior, prior_p, steps, row_count, rows, gains, ratios : ndarray
        Records for the way back: state and covariance before the measurements, the step, and for each scalar
        measurement its row, gain and innovation over innovation variance.
    posterior : ndarray, shape (K, STATE)
    spread : ndarray, shape (K, 6)
        Variances of position and attitude error after the measurements.
    """
    matrix = np.empty(9)
    residual = np.empty(at.MOST_ROWS)
    variance = np.empty(at.MOST_ROWS)
    error = np.empty(_N)
    gyroscope_last = memory[_GYRO : _GYRO + 3]
    accelerometer_last = memory[_ACC : _ACC + 3]
    for k in range(step_s.shape[0]):
        step = steps[k]
        if memory[_STARTED] > 0.0:
            h = step_s[k]
            memory[_SINCE] += h
            for i in range(3):
                accelerometer_last[i] = 0.5 * (accelerometer_last[i] + accelerometer_mps2[k, i])
            _move(x, gyroscope_radps[k], memory, h, step)
            _spread(step, p, rate_variance[k], force_variance[k], settings, scratch)
        else:
            _matrix(x[_Q], x[_Q + 1], x[_Q + 2], x[_Q + 3], step)
            step[_FORCE:] = 0.0
            # Marks for the way back that the state begins here.
            step[_H] = -1.0
            memory[_STARTED] = 1.0
        for i in range(3):
            gyroscope_last[i] = gyroscope_radps[k, i]
            accelerometer_last[i] = accelerometer_mps2[k, i]
        prior[k] = x
        prior_p[k] = p
        seen = bits[k]
        count = 0
        if seen:
            here = field[k] if seen & _HEADING else matrix[:3]
            count = _rows(
                seen,
                gyroscope_radps[k],
                here,
                x,
                sigma_mps[k],
                memory,
                settings,
                matrix,
                rows[k],
                residual,
                variance,
            )
            if seen & _STANCE:
                doubtful = 0.0 < memory[_BELIEVED] * settings[_S_GATE_RATIO] < sigma_mps[k]
                if doubtful and memory[_SINCE] < settings[_S_GATE_TIME]:
                    doubtful = _surprise(p, rows[k], residual, variance) > settings[_S_GATE]
                    if doubtful:
                        count = 0
                        seen = 0
                        bits[k] = 0
                if seen:
                    is_new = memory[_SINCE] > _RUN_S or memory[_BELIEVED] == 0.0
                    if is_new or sigma_mps[k] < memory[_BELIEVED]:
                        memory[_BELIEVED] = sigma_mps[k]
                    memory[_SINCE] = 0.0
            error[:] = 0.0
            for m in range(count):
                row, gain = rows[k, m], gains[k, m]
                innovation = residual[m]
                total = variance[m]
                for i in range(_N):
                    value = 0.0
                    for j in range(_N):
                        value += p[i, j] * row[j]
                    gain[i] = value
                    total += value * row[i]
                    innovation -= row[i] * error[i]
                ratio = innovation / total
                ratios[k, m] = ratio
                # Joseph's form with the optimal gain and one scalar: P - (P h)(P h)^T / s, symmetric by itself.
                for i in range(_N):
                    scaled = gain[i] / total
                    error[i] += gain[i] * ratio
                    for j in range(_N):
                        p[i, j] -= scaled * gain[j]
                for i in range(_N):
                    gain[i] /= total
            if count:
                _correct(prior[k], error, x)
            if seen & _HEIGHT:
                if memory[_FLOOR_KNOWN] == 0.0:
                    memory[_FLOOR] = x[_P + 2]
                    memory[_FLOOR_KNOWN] = 1.0
                elif settings[_S_FLAT] == 0.0:
                    d = memory[_FLOOR] - prior[k, _P + 2]
                    weight = 0.0
                    if abs(d) < settings[_S_HEIGHT_GATE]:
                        weight = (1.0 + (d / settings[_S_HEIGHT_SCALE]) ** 2) ** -2
                    memory[_FLOOR] = weight * memory[_FLOOR] + (1.0 - weight) * x[_P + 2]
        row_count[k] = count
        posterior[k] = x
        for i in range(3):
            spread[k, i] = p[i, i]
            spread[k, 3 + i] = p[_EQ + i, _EQ + i]


@kernel(
    "void(int64, int64, int64, float64[:, ::1], float64[:, :, ::1], float64[:, ::1], int64[::1],"
    " float64[:, :, ::1], float64[:, :, ::1], float64[:, ::1], float64[::1], float64[:, ::1])"
)
def backward(
    first: int,
    wanted: int,
    stop: int,
    prior: Float,
    prior_p: Float,
    steps: Float,
    row_count: NDArray[np.int64],
    rows: Float,
    gains: Float,
    ratios: Float,
    adjoint: Float,
    smooth: Float,
) -> None:
    """Smooth the recorded samples `[first, stop)`, from the last to the first.

    Parameters
    ----------
    first, wanted, stop : int
        States are written for `[first, wanted)`; further ones only tell these what came later.
    prior, prior_p, steps, row_count, rows, gains, ratios : ndarray
        As `forward` left them.
    adjoint : ndarray, shape (ERRORS,)
        What later samples say; zeros at the end of what is known. Input and output.
    smooth : ndarray, shape (wanted - first, STATE)
        Output.
    """
    error = np.empty(_N)
    for k in range(stop - 1, first - 1, -1):
        for m in range(row_count[k] - 1, -1, -1):
            scale = ratios[k, m]
            for i in range(_N):
                scale -= gains[k, m, i] * adjoint[i]
            for i in range(_N):
                adjoint[i] += rows[k, m, i] * scale
        if k < wanted:
            for i in range(_N):
                value = 0.0
                for j in range(_N):
                    value += prior_p[k, i, j] * adjoint[j]
                error[i] = value
            _correct(prior[k], error, smooth[k - first])
        step = steps[k]
        h = step[_H]
        if h < 0.0:
            # Nothing later says where the foot was before a new start; biases and contact point go on.
            adjoint[:_EBG] = 0.0
            continue
        wx = 0.5 * h * adjoint[0] + adjoint[_EV]
        wy = 0.5 * h * adjoint[1] + adjoint[_EV + 1]
        wz = 0.5 * h * adjoint[2] + adjoint[_EV + 2]
        fx, fy, fz = step[_FORCE], step[_FORCE + 1], step[_FORCE + 2]
        for i in range(3):
            adjoint[_EBG + i] -= h * (
                step[i] * adjoint[_EQ] + step[3 + i] * adjoint[_EQ + 1] + step[6 + i] * adjoint[_EQ + 2]
            )
            adjoint[_EBA + i] -= h * (step[i] * wx + step[3 + i] * wy + step[6 + i] * wz)
        adjoint[_EQ] += h * (fy * wz - fz * wy)
        adjoint[_EQ + 1] += h * (fz * wx - fx * wz)
        adjoint[_EQ + 2] += h * (fx * wy - fy * wx)
        for i in range(3):
            adjoint[_EV + i] += h * adjoint[i]


__all__ = ["backward", "forward"]
