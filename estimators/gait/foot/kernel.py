"""The foot filter, compiled: the way there over the samples of a foot, and the way back.

The smoother is that of Bryson and Frazier: the way back carries an adjoint vector and needs no inverse, so it costs
a tenth of the way there. For the same linear model it equals the smoother of Rauch, Tung and Striebel, eq. (16)
of the method page, which is the twin in the tests.
"""

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import kernel
from estimators.gait.foot import layout as at
from estimators.gait.foot.measured_kernel import measured_rows, surprise
from estimators.gait.foot.step_kernel import correct, matrix_of, move, spread_on
from estimators.recording import Float

_N = at.ERRORS
_P, _Q = at.P, at.Q
_EV, _EQ, _EBG, _EBA = at.E_V, at.E_Q, at.E_GYROSCOPE_BIAS, at.E_ACCELEROMETER_BIAS
_GYRO, _ACC, _STARTED = at.LAST_GYROSCOPE, at.LAST_ACCELEROMETER, at.STARTED
_STANCE, _HEIGHT, _HEADING = at.STANCE, at.HEIGHT, at.HEADING
_FLOOR, _FLOOR_KNOWN = at.FLOOR, at.FLOOR_KNOWN
_S_HEIGHT_SCALE, _S_HEIGHT_GATE, _S_FLAT = at.S_HEIGHT_SCALE, at.S_HEIGHT_GATE, at.S_FLAT
_SINCE, _BELIEVED = at.SINCE, at.BELIEVED_SIGMA
_S_GATE, _S_GATE_RATIO, _S_GATE_TIME = at.S_GATE, at.S_GATE_RATIO, at.S_GATE_TIME
_RUN_S = 0.1
_FORCE, _H = at.STEP_FORCE, at.STEP_TIME


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
            move(x, gyroscope_radps[k], memory, h, step)
            spread_on(step, p, rate_variance[k], force_variance[k], settings, scratch)
        else:
            matrix_of(x[_Q], x[_Q + 1], x[_Q + 2], x[_Q + 3], step)
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
            count = measured_rows(
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
                    doubtful = surprise(p, rows[k], residual, variance) > settings[_S_GATE]
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
                correct(prior[k], error, x)
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
            correct(prior[k], error, smooth[k - first])
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
