"""One step of the foot filter, compiled: the state and its error covariance from one sample to the next."""

from estimators._kernels import exponential, multiply, normalized, rotate, step
from estimators.conventions import GRAVITY_MPS2
from estimators.gait.foot import layout as at
from estimators.recording import Float

_G = GRAVITY_MPS2
_N = at.ERRORS
_POSITION_DENSITY2 = 1e-10
_P, _V, _Q, _BG, _BA, _R = at.P, at.V, at.Q, at.GYROSCOPE_BIAS, at.ACCELEROMETER_BIAS, at.PIVOT
_EV, _EQ, _EBG, _EBA, _ER = at.E_V, at.E_Q, at.E_GYROSCOPE_BIAS, at.E_ACCELEROMETER_BIAS, at.E_PIVOT
_GYRO, _ACC = at.LAST_GYROSCOPE, at.LAST_ACCELEROMETER
_S_PIVOT, _S_BG, _S_BA = at.S_PIVOT_DENSITY2, at.S_GYROSCOPE_BIAS_DENSITY2, at.S_ACCELEROMETER_BIAS_DENSITY2
_FORCE, _H = at.STEP_FORCE, at.STEP_TIME


@step("void(float64, float64, float64, float64, float64[::1])")
def matrix_of(w: float, x: float, y: float, z: float, out: Float) -> None:
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


@step("void(float64[::1], float64[::1], float64[::1])")
def correct(x: Float, error: Float, out: Float) -> None:
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


@step("void(float64[::1], float64[:, ::1], float64[::1], float64, float64[::1], float64[::1])")
def spread_on(step: Float, p: Float, rate_variance: Float, force_variance: float, s: Float, w: Float) -> None:
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


@step("void(float64[::1], float64[::1], float64[::1], float64, float64[::1])")
def move(x: Float, gyroscope: Float, memory: Float, h: float, step: Float) -> None:
    """Carry the state over one step, eq. (7) and (8), and write what the step looked like."""
    wx = 0.5 * (memory[_GYRO] + gyroscope[0]) - x[_BG]
    wy = 0.5 * (memory[_GYRO + 1] + gyroscope[1]) - x[_BG + 1]
    wz = 0.5 * (memory[_GYRO + 2] + gyroscope[2]) - x[_BG + 2]
    hw, hx, hy, hz = exponential(0.5 * h * wx, 0.5 * h * wy, 0.5 * h * wz)
    mw, mx, my, mz = multiply(x[_Q], x[_Q + 1], x[_Q + 2], x[_Q + 3], hw, hx, hy, hz)
    qw, qx, qy, qz = multiply(mw, mx, my, mz, hw, hx, hy, hz)
    matrix_of(mw, mx, my, mz, step)
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
