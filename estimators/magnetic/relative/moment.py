"""Whether the coils are as strong as stated, from the pulses of a session; compiled (own, after Friedland 1969).

A source whose moment is off by a share g seems nearer or farther by about g / 3 of the distance, and every pulse and
every burst agrees with that: no single residual tells. What does tell is movement, which the accelerometers measure
in metres. The error of the filter is V g with V known at every moment: the dynamics carry it along, every correction
changes it by V -= K s with s = H V - y (y the predicted field: the direct effect of g on a pulse). So the innovations
hold g s beside their noise, and g follows by least squares without a state of its own (separate-bias estimation,
Friedland, IEEE Transactions on Automatic Control 14, 1969, 359-367).
"""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import step
from estimators.kernels.matrices import cholesky, solve
from estimators.magnetic.relative import layout as at
from estimators.recording import Float

_V, _SCORE, _INFORMATION, _WRONG = at.SENSITIVITY, at.MOMENT_SCORE, at.MOMENT_INFORMATION, at.MOMENT_WRONG
_LIMIT, _KEEP, _TICK, _ALARM_UNTIL, _O_COV = (
    at.MOMENT_LIMIT,
    at.MOMENT_KEEP,
    at.TICK,
    at.ALARM_UNTIL,
    at.O_COVARIANCE,
)
_POSE_ERRORS = at.POSE_ERRORS
_SURE, _DOUBTFUL = 4.0, 2.0
"""Sigmas from which on the moment is called wrong, and below which it is no more."""


@step("void(float64[:, ::1], float64[::1], float64[::1])")
def carry_sensitivity(phi: Float, settings: Float, memory: Float) -> None:
    """Carry V over a step by the transition of the errors; what was learnt of g fades slowly."""
    n = phi.shape[0]
    carried = np.zeros(n)
    for i in range(n):
        for k in range(n):
            if phi[i, k] != 0.0:
                carried[i] += phi[i, k] * memory[_V + k]
    for i in range(n):
        memory[_V + i] = carried[i]
    memory[_SCORE] *= settings[_KEEP]
    memory[_INFORMATION] *= settings[_KEEP]


@step(
    "void(float64[:, ::1], float64[:, ::1], float64[:, ::1], float64[:, ::1], float64[::1], float64[::1],"
    "float64[::1])"
)
def learn_moment(
    p: Float, h: Float, r: Float, gain: Float, innovation: Float, own: Float, memory: Float
) -> None:
    """Learn from a correction, before P is changed; `own` (m,) is the direct effect of g on what was predicted."""
    n, m = p.shape[0], h.shape[0]
    s, c, ph = np.empty(m), np.empty((m, m)), np.empty(n)
    for a in range(m):
        s[a] = -own[a]
        for k in range(n):
            s[a] += h[a, k] * memory[_V + k]
        for i in range(n):
            ph[i] = 0.0
        for k in range(n):
            if h[a, k] != 0.0:
                for i in range(n):
                    ph[i] += p[i, k] * h[a, k]
        for b in range(m):
            total = r[b, a]
            for k in range(n):
                if h[b, k] != 0.0:
                    total += h[b, k] * ph[k]
            c[b, a] = total
    for i in range(n):
        for a in range(m):
            memory[_V + i] -= gain[i, a] * s[a]
    if not cholesky(c):
        return
    weighted = s.copy()
    solve(c, weighted)
    for a in range(m):
        memory[_SCORE] += weighted[a] * innovation[a]
        memory[_INFORMATION] += weighted[a] * s[a]


@step("void(float64[::1], float64[::1], int64[::1], float64[::1])")
def judge_moment(settings: Float, memory: Float, counters: NDArray[np.int64], out: Float) -> None:
    """Raise the alarm while the moment is surely not the stated one, and widen what is given by what that does."""
    information = memory[_INFORMATION]
    if not information > 0.0:
        return
    share = memory[_SCORE] / information
    sigmas = abs(memory[_SCORE]) / math.sqrt(information)
    if sigmas > _SURE and abs(share) > settings[_LIMIT]:
        memory[_WRONG] = 1.0
    elif sigmas < _DOUBTFUL:
        memory[_WRONG] = 0.0
    if memory[_WRONG] == 0.0:
        return
    counters[_ALARM_UNTIL] = max(counters[_ALARM_UNTIL], counters[_TICK] + 1)
    variance = share * share + 1.0 / information
    column = _O_COV
    for i in _POSE_ERRORS:
        a = memory[_V + i]
        for j in _POSE_ERRORS:
            out[column] += variance * a * memory[_V + j]
            column += 1
