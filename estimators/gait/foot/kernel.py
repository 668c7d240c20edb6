"""The foot filter, compiled: the way there over the samples of a foot, and the way back.

The smoother is that of Bryson and Frazier: the way back carries an adjoint vector and needs no inverse, so it costs
a tenth of the way there. For the same linear model it equals the smoother of Rauch, Tung and Striebel, eq. (16)
of the method page, which is the twin in the tests.
"""

from typing import NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from estimators._kernels import kernel
from estimators.gait.foot import layout as at
from estimators.gait.foot.measured_kernel import measured_rows, surprise
from estimators.gait.foot.step_kernel import correct, matrix_of, move, spread_on
from estimators.kernels import VOID, bundle, step
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


class FootTicks(NamedTuple):
    """K samples of a foot.

    Attributes
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
    rate_variance : ndarray, shape (K, 3)
        Noise density squared of the gyroscope, eq. (12).
    field : ndarray, shape (K, 3) or (0, 3)
        Magnetic field, sensor axes, any unit; read where `bits` has HEADING.
    """

    step_s: Float
    gyroscope_radps: Float
    accelerometer_mps2: Float
    sigma_mps: Float
    bits: NDArray[np.uint8]
    force_variance: Float
    rate_variance: Float
    field: Float


class FootState(NamedTuple):
    """Memory, (MEMORY,), state, (STATE,), and covariance, (ERRORS, ERRORS): carried on in place."""

    memory: Float
    x: Float
    p: Float


class Trace(NamedTuple):
    """What the way there leaves for the way back, K samples leading.

    Attributes
    ----------
    prior, prior_p : ndarray, shapes (K, STATE), (K, ERRORS, ERRORS)
        State and covariance before the measurements.
    steps : ndarray, shape (K, STEP)
    row_count : ndarray of int64, shape (K,)
    rows, gains, ratios : ndarray, shapes (K, MOST_ROWS, ERRORS) twice, (K, MOST_ROWS)
        Of each scalar measurement its row, gain and innovation over innovation variance.
    posterior : ndarray, shape (K, STATE)
    spread : ndarray, shape (K, 6)
        Variances of position and attitude error after the measurements.
    """

    prior: Float
    prior_p: Float
    steps: Float
    row_count: NDArray[np.int64]
    rows: Float
    gains: Float
    ratios: Float
    posterior: Float
    spread: Float


_ROW, _TABLE, _CUBE, _WHOLE = (
    types.float64[::1],
    types.float64[:, ::1],
    types.float64[:, :, ::1],
    types.int64[::1],
)
_SAMPLES = bundle(FootTicks, _ROW, _TABLE, _TABLE, _ROW, types.uint8[::1], _ROW, _TABLE, _TABLE)
_STATE = bundle(FootState, _ROW, _ROW, _TABLE)
_TRACE = bundle(Trace, _TABLE, _CUBE, _TABLE, _WHOLE, _CUBE, _CUBE, _TABLE, _TABLE, _TABLE)


@step()
def _predict(
    k: int, samples: FootTicks, settings: Float, state: FootState, taken: Float, scratch: Float
) -> None:
    """Go on to sample k, or begin there, and write the step into `taken`."""
    memory, x = state.memory, state.x
    last = memory[_ACC : _ACC + 3]
    if memory[_STARTED] > 0.0:
        h = samples.step_s[k]
        memory[_SINCE] += h
        for i in range(3):
            last[i] = 0.5 * (last[i] + samples.accelerometer_mps2[k, i])
        move(x, samples.gyroscope_radps[k], memory, h, taken)
        spread_on(taken, state.p, samples.rate_variance[k], samples.force_variance[k], settings, scratch)
    else:
        matrix_of(x[_Q], x[_Q + 1], x[_Q + 2], x[_Q + 3], taken)
        taken[_FORCE:] = 0.0
        # Marks for the way back that the state begins here.
        taken[_H] = -1.0
        memory[_STARTED] = 1.0
    for i in range(3):
        memory[_GYRO + i] = samples.gyroscope_radps[k, i]
        last[i] = samples.accelerometer_mps2[k, i]


@step()
def _is_believed(
    sigma_mps: float, settings: Float, state: FootState, rows: Float, residual: Float, variance: Float
) -> bool:
    """Say whether a stance fits what is known, and remember one that does."""
    memory = state.memory
    doubtful = 0.0 < memory[_BELIEVED] * settings[_S_GATE_RATIO] < sigma_mps
    doubtful = doubtful and memory[_SINCE] < settings[_S_GATE_TIME]
    if doubtful and surprise(state.p, rows, residual, variance) > settings[_S_GATE]:
        return False
    is_new = memory[_SINCE] > _RUN_S or memory[_BELIEVED] == 0.0
    if is_new or sigma_mps < memory[_BELIEVED]:
        memory[_BELIEVED] = sigma_mps
    memory[_SINCE] = 0.0
    return True


@step()
def _absorb(row: Float, innovation: float, variance: float, p: Float, error: Float, gain: Float) -> float:
    """Take one scalar measurement; returns innovation over its variance, with the gain filled."""
    total = variance
    for i in range(_N):
        value = 0.0
        for j in range(_N):
            value += p[i, j] * row[j]
        gain[i] = value
        total += value * row[i]
        innovation -= row[i] * error[i]
    ratio = innovation / total
    # Joseph's form with the optimal gain and one scalar: P - (P h)(P h)^T / s, symmetric by itself.
    for i in range(_N):
        scaled = gain[i] / total
        error[i] += gain[i] * ratio
        for j in range(_N):
            p[i, j] -= scaled * gain[j]
    for i in range(_N):
        gain[i] /= total
    return ratio


@step()
def _stand_on(settings: Float, memory: Float, prior_m: float, height_m: float) -> None:
    """Remember the height of the floor, which follows where the ground is not flat."""
    if memory[_FLOOR_KNOWN] == 0.0:
        memory[_FLOOR] = height_m
        memory[_FLOOR_KNOWN] = 1.0
    elif settings[_S_FLAT] == 0.0:
        d = memory[_FLOOR] - prior_m
        weight = 0.0
        if abs(d) < settings[_S_HEIGHT_GATE]:
            weight = (1.0 + (d / settings[_S_HEIGHT_SCALE]) ** 2) ** -2
        memory[_FLOOR] = weight * memory[_FLOOR] + (1.0 - weight) * height_m


@kernel(VOID(_SAMPLES, _ROW, _STATE, _TRACE))
def forward(samples: FootTicks, settings: Float, state: FootState, trace: Trace) -> None:
    """Run the filter over K samples, with settings of shape (SETTINGS,); carry the state on and leave the trace."""
    memory, x, p = state.memory, state.x, state.p
    matrix, scratch = np.empty(9), np.empty(_N)
    residual, variance = np.empty(at.MOST_ROWS), np.empty(at.MOST_ROWS)
    error = np.empty(_N)
    for k in range(samples.step_s.shape[0]):
        _predict(k, samples, settings, state, trace.steps[k], scratch)
        trace.prior[k] = x
        trace.prior_p[k] = p
        seen = samples.bits[k]
        count = 0
        if seen:
            rate, sigma_mps, rows = samples.gyroscope_radps[k], samples.sigma_mps[k], trace.rows[k]
            field = samples.field[k] if seen & _HEADING else matrix[:3]
            count = measured_rows(
                seen, rate, field, x, sigma_mps, memory, settings, matrix, rows, residual, variance
            )
            if seen & _STANCE and not _is_believed(sigma_mps, settings, state, rows, residual, variance):
                count = 0
                seen = 0
                samples.bits[k] = 0
            error[:] = 0.0
            for m in range(count):
                trace.ratios[k, m] = _absorb(rows[m], residual[m], variance[m], p, error, trace.gains[k, m])
            if count:
                correct(trace.prior[k], error, x)
            if seen & _HEIGHT:
                _stand_on(settings, memory, trace.prior[k, _P + 2], x[_P + 2])
        trace.row_count[k] = count
        trace.posterior[k] = x
        for i in range(3):
            trace.spread[k, i] = p[i, i]
            trace.spread[k, 3 + i] = p[_EQ + i, _EQ + i]


@kernel(VOID(types.int64, types.int64, types.int64, _TRACE, _ROW, _TABLE))
def backward(first: int, wanted: int, stop: int, trace: Trace, adjoint: Float, smooth: Float) -> None:
    """Smooth the recorded samples `[first, stop)`, from the last to the first.

    Parameters
    ----------
    first, wanted, stop : int
        States are written for `[first, wanted)`; further ones only tell these what came later.
    trace : Trace
        As `forward` left it.
    adjoint : ndarray, shape (ERRORS,)
        What later samples say; zeros at the end of what is known. Input and output.
    smooth : ndarray, shape (wanted - first, STATE)
        Output.
    """
    error = np.empty(_N)
    for k in range(stop - 1, first - 1, -1):
        for m in range(trace.row_count[k] - 1, -1, -1):
            scale = trace.ratios[k, m]
            for i in range(_N):
                scale -= trace.gains[k, m, i] * adjoint[i]
            for i in range(_N):
                adjoint[i] += trace.rows[k, m, i] * scale
        if k < wanted:
            for i in range(_N):
                value = 0.0
                for j in range(_N):
                    value += trace.prior_p[k, i, j] * adjoint[j]
                error[i] = value
            correct(trace.prior[k], error, smooth[k - first])
        taken = trace.steps[k]
        h = taken[_H]
        if h < 0.0:
            # Nothing later says where the foot was before a new start; biases and contact point go on.
            adjoint[:_EBG] = 0.0
            continue
        wx = 0.5 * h * adjoint[0] + adjoint[_EV]
        wy = 0.5 * h * adjoint[1] + adjoint[_EV + 1]
        wz = 0.5 * h * adjoint[2] + adjoint[_EV + 2]
        fx, fy, fz = taken[_FORCE], taken[_FORCE + 1], taken[_FORCE + 2]
        for i in range(3):
            adjoint[_EBG + i] -= h * (
                taken[i] * adjoint[_EQ] + taken[3 + i] * adjoint[_EQ + 1] + taken[6 + i] * adjoint[_EQ + 2]
            )
            adjoint[_EBA + i] -= h * (taken[i] * wx + taken[3 + i] * wy + taken[6 + i] * wz)
        adjoint[_EQ] += h * (fy * wz - fz * wy)
        adjoint[_EQ + 1] += h * (fz * wx - fx * wz)
        adjoint[_EQ + 2] += h * (fx * wy - fy * wx)
        for i in range(3):
            adjoint[_EV + i] += h * adjoint[i]
