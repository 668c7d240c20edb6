"""The loop of the tracker fusion over samples, and its backward smoother; compiled."""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import kernel, multiply, rotate_back, step
from estimators.kernels.attitudes import attitude_matrix, turn_between
from estimators.kernels.backward import step_back
from estimators.kernels.matrices import matrix_multiply, multiply_turned
from estimators.magnetic.tracker import fusion_layout as at
from estimators.magnetic.tracker.fusion_fix import fix_noise, start, use_fix
from estimators.magnetic.tracker.fusion_kernel import (
    inject,
    predict,
    propagate,
    relative_rate,
)
from estimators.recording import Float

_P, _V, _Q, _BA, _BG = at.POSITION, at.VELOCITY, at.ATTITUDE, at.FORCE_BIAS, at.RATE_BIAS
_XI, _PHI, _BM = at.FILTER_ERROR, at.SOURCE_ERROR, at.SOURCE_FORCE_BIAS
_EP, _EV, _ET, _EA, _EG, _EXI, _EPHI, _EM = (
    at.E_POSITION,
    at.E_VELOCITY,
    at.E_ATTITUDE,
    at.E_FORCE,
    at.E_RATE,
    at.E_FILTER,
    at.E_SOURCE_FILTER,
    at.E_SOURCE_FORCE,
)
_NOMINAL, _ERRORS, _LAST, _SUM = at.NOMINAL, at.ERRORS, at.LAST, at.SUM_RATE
_TICK, _STARTED, _STILL, _STREAK = at.TICK, at.STARTED, at.STILL, at.STREAK
_GM, _FIX_P, _FIX_Q, _HELD = at.SOURCE_ATTITUDE, at.FIX_POSITION, at.FIX_ATTITUDE, at.FILTER_ATTITUDE
_STILL_RATE = at.STILL_RATE
_O_P, _O_Q, _O_WP, _O_WV, _O_WQ, _O_COV, _O_NIS, _O_STATUS = (
    at.O_POSITION,
    at.O_ATTITUDE,
    at.O_WORLD_POSITION,
    at.O_WORLD_VELOCITY,
    at.O_WORLD_ATTITUDE,
    at.O_COVARIANCE,
    at.O_NIS,
    at.O_STATUS,
)
_INVALID, _RESTART, _GAP, _T = at.INVALID, at.RESTART, at.GAP, at.TIME_STEP


@kernel("void(float64[::1], float64[::1], float64[:, ::1], float64[::1])")
def report(nominal: Float, m: Float, p: Float, out: Float) -> None:
    """Write pose and covariance in the source frame (position: source axes; orientation: sensor axes)."""
    place = rotate_back(m[0], m[1], m[2], m[3], nominal[_P], nominal[_P + 1], nominal[_P + 2])
    q = multiply(m[0], -m[1], -m[2], -m[3], nominal[_Q], nominal[_Q + 1], nominal[_Q + 2], nominal[_Q + 3])
    sign = 1.0 if q[0] >= 0.0 else -1.0
    turn = np.zeros((6, 6))
    r, own, pose, left = np.empty((3, 3)), np.empty((3, 3)), np.empty((6, 6)), np.empty((6, 6))
    attitude_matrix(m, r)
    attitude_matrix(nominal[_Q : _Q + 4], own)
    for i in range(3):
        out[_O_P + i], out[_O_WP + i], out[_O_WV + i] = place[i], nominal[_P + i], nominal[_V + i]
        for j in range(3):
            turn[i, j], turn[3 + i, 3 + j] = r[j, i], own[j, i]
    for i in range(4):
        out[_O_Q + i] = sign * q[i]
        out[_O_WQ + i] = nominal[_Q + i]
    for i in range(6):
        for j in range(6):
            pose[i, j] = p[i if i < 3 else _ET + i - 3, j if j < 3 else _ET + j - 3]
    matrix_multiply(turn, pose, left)
    multiply_turned(left, turn, pose)
    for i in range(6):
        for j in range(6):
            out[_O_COV + 6 * i + j] = 0.5 * (pose[i, j] + pose[j, i])


@kernel(
    "void(float64[:, ::1], float64[::1], float64[::1], float64[:, ::1], float64[::1], int64[::1], float64[:, ::1])"
)
def run(
    samples: Float,
    settings: Float,
    nominal: Float,
    p: Float,
    memory: Float,
    counters: NDArray[np.int64],
    out: Float,
) -> None:
    """Take samples; the arrays of the filter change in place."""
    work, a, nis = np.empty((3, _ERRORS, _ERRORS)), np.empty((_ERRORS, _ERRORS)), np.empty(1)
    white = np.empty((6, 6))
    last = memory[_LAST : _LAST + _HELD]
    for k in range(samples.shape[0]):
        row, status, total = samples[k].copy(), 0, 0.0
        for i in range(_HELD):
            total += row[i]
        if not math.isfinite(total):
            # The last sample is held; what was missed is found out by the next fixes.
            status |= _GAP
            for i in range(_HELD):
                row[i] = last[i] if counters[_TICK] > 0 else 0.0
            if counters[_TICK] == 0:
                row[_GM] = 1.0
        nis[0] = math.nan
        if counters[_STARTED] > 0:
            propagate(nominal, last, row[:_HELD], settings, a)
            rate = relative_rate(nominal, last, row[:_HELD], settings[_T])
            fix_noise(row, settings, rate, white)
            predict(p, a, nominal, row[_GM : _GM + 4], settings, white, work)
            status |= use_fix(row, settings, nominal, p, counters, work[0], nis)
        elif row[0] ** 2 + row[1] ** 2 + row[2] ** 2 < settings[_STILL_RATE] ** 2:
            counters[_STILL] += 1
            for i in range(3):
                memory[_SUM + i] += row[i]
        else:
            counters[_STILL] = 0
            for i in range(3):
                memory[_SUM + i] = 0.0
        fixed = math.isfinite(row[_FIX_P]) and math.isfinite(row[_FIX_Q])
        if fixed and (counters[_STARTED] == 0 or counters[_STREAK] >= 3):
            start(row, settings, nominal, p, memory, counters)
            status |= _RESTART
        if counters[_STARTED] == 0:
            status |= _INVALID
        for i in range(_HELD):
            last[i] = row[i]
        report(nominal, row[_GM : _GM + 4], p, out[k])
        out[k, _O_NIS], out[k, _O_STATUS] = nis[0], float(status)
        counters[_TICK] += 1


@step("void(float64[::1], float64[::1], float64[::1])")
def difference(a: Float, b: Float, error: Float) -> None:
    """Write the error that, put into b, gives a."""
    error[:] = 0.0
    turn_between(a[_Q : _Q + 4], b[_Q : _Q + 4], error[_ET : _ET + 3])
    for i in range(3):
        error[_EP + i], error[_EV + i] = a[_P + i] - b[_P + i], a[_V + i] - b[_V + i]
        error[_EA + i] = a[_BA + i] - b[_BA + i]
        error[_EG + i], error[_EM + i] = a[_BG + i] - b[_BG + i], a[_BM + i] - b[_BM + i]
        error[_EXI + i], error[_EPHI + i] = a[_XI + i] - b[_XI + i], a[_PHI + i] - b[_PHI + i]


@kernel(
    "void(float64[:, ::1], boolean[::1], float64[:, ::1], float64[:, :, ::1], float64[::1], float64[:, ::1],"
    "float64[:, :, ::1])"
)
def backward(
    samples: Float,
    restarted: NDArray[np.bool_],
    nominal: Float,
    covariance: Float,
    settings: Float,
    smoothed: Float,
    smoothed_covariance: Float,
) -> None:
    """Run backward over the filter's states (Rauch-Tung-Striebel; page C4 2.4, with the a priori covariance)."""
    count, n = len(samples), _ERRORS
    a, prior, work, white = np.empty((n, n)), np.empty((n, n)), np.empty((3, n, n)), np.zeros((6, 6))
    error, moved, state = np.empty(n), np.empty(n), np.empty(_NOMINAL)
    for k in range(count - 1, -1, -1):
        smoothed[k, :] = nominal[k]
        smoothed_covariance[k, :, :] = covariance[k]
        if k == count - 1 or restarted[k + 1] or covariance[k, _EP, _EP] <= 0.0:
            continue
        state[:] = nominal[k]
        prior[:, :] = covariance[k]
        propagate(state, samples[k, :_HELD], samples[k + 1, :_HELD], settings, a)
        # What the white errors are worth here says nothing of the tick before.
        predict(prior, a, state, samples[k + 1, _GM : _GM + 4], settings, white, work)
        difference(smoothed[k + 1], state, error)
        if step_back(smoothed_covariance[k], a, prior, smoothed_covariance[k + 1], error, moved, work):
            inject(smoothed[k], moved)
