"""Strapdown, prediction, marker update and backward smoothing (Roetenberg 2006, chapter 4, corrected), compiled."""

import math

import numpy as np

from estimators._kernels import Scalars3, Scalars4, exponential, kernel, multiply, normalized, rotate
from estimators.kernels import step
from estimators.kernels.attitudes import turn_between, turn_in_world
from estimators.kernels.backward import step_back
from estimators.kernels.matrices import (
    cholesky,
    joseph,
    matrix_multiply,
    multiply_turned,
    solve,
    solve_rows,
    symmetrise,
)
from estimators.optical import _layout as at
from estimators.optical._heading import doubt_heading
from estimators.recording import Float

_P, _V, _Q, _BA, _BG, _R = (
    at.POSITION,
    at.VELOCITY,
    at.ATTITUDE,
    at.FORCE_BIAS,
    at.RATE_BIAS,
    at.LEVER,
)
_EP, _EV, _ET, _EA, _EG, _ER = at.E_POSITION, at.E_VELOCITY, at.E_ATTITUDE, at.E_FORCE, at.E_RATE, at.E_LEVER
_GYR, _ACC, _MARKER, _DELAY, _SAMPLE = at.GYROSCOPE, at.ACCELEROMETER, at.MARKER, at.DELAY, at.SAMPLE
_STREAK, _COASTING, _RECOVER_COUNT = at.STREAK, at.COASTING, at.RECOVER_COUNT
_T, _G, _FORCE, _RATE, _SIGMA = at.TIME_STEP, at.GRAVITY, at.FORCE_SIGMA, at.RATE_SIGMA, at.MARKER_SIGMA
_FORCE_WALK, _RATE_WALK, _GATE, _RECOVER = at.FORCE_WALK, at.RATE_WALK, at.GATE, at.RECOVER_TICKS
_O_A, _O_NIS, _O_STATE, _O_GROWTH, _O_INNOVATION, _O_SIGMA = (
    at.O_ACCELERATION,
    at.O_NIS,
    at.O_STATE,
    at.O_GROWTH,
    at.O_INNOVATION,
    at.O_SIGMA,
)
_COASTED, _MEASURED, _REJECTED = float(at.COASTED), float(at.MEASURED), float(at.REJECTED)
_RECOVERED = float(at.RECOVERED)


@step()
def _force_in_room(q: Scalars4, sample: Float, b: Float) -> Scalars3:
    """Return the specific force of a sample, less its bias, in room axes."""
    x, y, z = sample[_ACC] - b[_BA], sample[_ACC + 1] - b[_BA + 1], sample[_ACC + 2] - b[_BA + 2]
    return rotate(q[0], q[1], q[2], q[3], x, y, z)


@kernel("void(float64[::1], float64[::1], float64[::1], float64[::1], float64[:, ::1])")
def predict_state(nominal: Float, before: Float, now: Float, settings: Float, phi: Float) -> None:
    """Carry the state over a step between two samples; write the transition (page 2.2).

    Rates and forces are taken as linear between the samples: the turn has the coning term, each force is turned by
    its own attitude before they are averaged. The page's midpoint of held samples costs 14 mm/s^2 at 7 rad/s.
    """
    t = settings[_T]
    w = np.empty(3)
    early, late = np.empty(3), np.empty(3)
    for i in range(3):
        early[i], late[i] = before[_GYR + i] - nominal[_BG + i], now[_GYR + i] - nominal[_BG + i]
        w[i] = 0.5 * t * (early[i] + late[i])
    c = t * t / 12.0
    turn = exponential(
        w[0] + c * (early[1] * late[2] - early[2] * late[1]),
        w[1] + c * (early[2] * late[0] - early[0] * late[2]),
        w[2] + c * (early[0] * late[1] - early[1] * late[0]),
    )
    q = (nominal[_Q], nominal[_Q + 1], nominal[_Q + 2], nominal[_Q + 3])
    after = multiply(q[0], q[1], q[2], q[3], turn[0], turn[1], turn[2], turn[3])
    after = normalized(after[0], after[1], after[2], after[3])
    first, second = _force_in_room(q, before, nominal), _force_in_room(after, now, nominal)
    a = (0.5 * (first[0] + second[0]), 0.5 * (first[1] + second[1]), 0.5 * (first[2] + second[2]))
    for i in range(phi.shape[0]):
        for j in range(phi.shape[0]):
            phi[i, j] = 1.0 if i == j else 0.0
    half = exponential(0.5 * w[0], 0.5 * w[1], 0.5 * w[2])
    m = multiply(q[0], q[1], q[2], q[3], half[0], half[1], half[2], half[3])
    h = 0.5 * t * t
    for j in range(3):
        column = rotate(
            m[0], m[1], m[2], m[3], 1.0 if j == 0 else 0.0, 1.0 if j == 1 else 0.0, 1.0 if j == 2 else 0.0
        )
        for i in range(3):
            phi[_EV + i, _EA + j] = -t * column[i]
            phi[_EP + i, _EA + j] = -h * column[i]
            phi[_ET + i, _EG + j] = -t * column[i]
        phi[_EP + j, _EV + j] = t
    # -[f_G x] of the global attitude error
    phi[_EV, _ET + 1], phi[_EV, _ET + 2] = t * a[2], -t * a[1]
    phi[_EV + 1, _ET], phi[_EV + 1, _ET + 2] = -t * a[2], t * a[0]
    phi[_EV + 2, _ET], phi[_EV + 2, _ET + 1] = t * a[1], -t * a[0]
    for i in range(3):
        for j in range(3):
            phi[_EP + i, _ET + j] = 0.5 * t * phi[_EV + i, _ET + j]
    for i in range(3):
        g = settings[_G] if i == 2 else 0.0
        nominal[_P + i] += t * nominal[_V + i] + t * t * ((2.0 * first[i] + second[i]) / 6.0 - 0.5 * g)
        nominal[_V + i] += t * (a[i] - g)
    nominal[_Q], nominal[_Q + 1], nominal[_Q + 2], nominal[_Q + 3] = after


@step("void(float64[:, ::1], float64[:, ::1], float64[::1], float64[::1], float64[::1], float64[:, ::1])")
def predict_covariance(p: Float, phi: Float, before: Float, now: Float, settings: Float, work: Float) -> None:
    """Replace P by Phi P Phi^T + Q; the noisier of both samples counts."""
    t = settings[_T]
    # Phi is mostly zero and `multiply` passes zeros over: Phi (Phi P)^T, for P is symmetric.
    matrix_multiply(phi, p, work)
    n = p.shape[0]
    for i in range(n):
        for j in range(i):
            work[i, j], work[j, i] = work[j, i], work[i, j]
    matrix_multiply(phi, work, p)
    force = (settings[_FORCE] * max(before[at.FORCE_NOISE], now[at.FORCE_NOISE])) ** 2
    rate = (settings[_RATE] * max(before[at.RATE_NOISE], now[at.RATE_NOISE])) ** 2
    for i in range(3):
        p[_EP + i, _EP + i] += force * t**4 / 4.0
        p[_EP + i, _EV + i] += force * t**3 / 2.0
        p[_EV + i, _EP + i] += force * t**3 / 2.0
        p[_EV + i, _EV + i] += force * t * t
        p[_ET + i, _ET + i] += rate * t * t
        p[_EA + i, _EA + i] += settings[_FORCE_WALK] ** 2 * t
        p[_EG + i, _EG + i] += settings[_RATE_WALK] ** 2 * t
    symmetrise(p)


@step("void(float64[::1], float64[::1])")
def inject(nominal: Float, error: Float) -> None:
    """Add an error (true minus estimate) to the nominal state."""
    for i in range(3):
        nominal[_P + i] += error[_EP + i]
        nominal[_V + i] += error[_EV + i]
        nominal[_BA + i] += error[_EA + i]
        nominal[_BG + i] += error[_EG + i]
        nominal[_R + i] += error[_ER + i]
    turn_in_world(nominal[_Q : _Q + 4], error[_ET : _ET + 3])


@step("void(float64[::1], float64[::1], float64[::1])")
def difference(a: Float, b: Float, out: Float) -> None:
    """Write the error that, added to b, gives a."""
    for i in range(3):
        out[_EP + i], out[_EV + i] = a[_P + i] - b[_P + i], a[_V + i] - b[_V + i]
        out[_EA + i], out[_EG + i] = a[_BA + i] - b[_BA + i], a[_BG + i] - b[_BG + i]
        out[_ER + i] = a[_R + i] - b[_R + i]
    turn_between(a[_Q : _Q + 4], b[_Q : _Q + 4], out[_ET : _ET + 3])


@step(
    "float64(float64[::1], float64[:, ::1], float64[::1], float64[::1], float64, float64[:, ::1], float64[::1])"
)
def update_marker(
    nominal: Float, p: Float, row: Float, settings: Float, gate: float, work: Float, seen: Float
) -> float:
    """Correct by a marker (page 2.3); return its normalised innovation squared, negative when it was shut out;
    write the innovation to `seen`.

    Its frame may lie beside the tick: the marker is then expected where velocity, acceleration and turn take it.
    """
    n = p.shape[0]
    h, gain, r, s = np.zeros((3, n)), np.empty((n, 3)), np.zeros((3, 3)), np.empty((3, 3))
    innovation, error = np.empty(3), np.empty(n)
    d, b = row[_DELAY], nominal
    turn = exponential(
        d * (row[_GYR] - b[_BG]), d * (row[_GYR + 1] - b[_BG + 1]), d * (row[_GYR + 2] - b[_BG + 2])
    )
    m = multiply(b[_Q], b[_Q + 1], b[_Q + 2], b[_Q + 3], turn[0], turn[1], turn[2], turn[3])
    lever = rotate(m[0], m[1], m[2], m[3], b[_R], b[_R + 1], b[_R + 2])
    a = rotate(
        b[_Q],
        b[_Q + 1],
        b[_Q + 2],
        b[_Q + 3],
        row[_ACC] - b[_BA],
        row[_ACC + 1] - b[_BA + 1],
        row[_ACC + 2] - b[_BA + 2],
    )
    for i in range(3):
        moved = d * b[_V + i] + 0.5 * d * d * (a[i] - (settings[_G] if i == 2 else 0.0))
        innovation[i] = row[_MARKER + i] - b[_P + i] - moved - lever[i]
        seen[i] = innovation[i]
        r[i, i] = settings[_SIGMA] ** 2
        h[i, _EP + i] = 1.0
        h[i, _EV + i] = d
    h[0, _ET + 1], h[0, _ET + 2] = lever[2], -lever[1]
    h[1, _ET], h[1, _ET + 2] = -lever[2], lever[0]
    h[2, _ET], h[2, _ET + 1] = lever[1], -lever[0]
    for j in range(3):
        column = rotate(
            m[0], m[1], m[2], m[3], 1.0 if j == 0 else 0.0, 1.0 if j == 1 else 0.0, 1.0 if j == 2 else 0.0
        )
        for i in range(3):
            h[i, _ER + j] = column[i]
    multiply_turned(p, h, gain)
    matrix_multiply(h, gain, s)
    for i in range(3):
        for j in range(3):
            s[i, j] += r[i, j]
    if not cholesky(s):
        return -1.0
    whitened = innovation.copy()
    solve(s, whitened)
    nis = float(innovation[0] * whitened[0] + innovation[1] * whitened[1] + innovation[2] * whitened[2])
    if nis > gate:
        return -nis
    solve_rows(s, gain)
    for i in range(n):
        error[i] = gain[i, 0] * innovation[0] + gain[i, 1] * innovation[1] + gain[i, 2] * innovation[2]
    inject(nominal, error)
    joseph(p, h, r, gain, work)
    return nis


@step("void(float64[::1], float64[::1], float64[:, ::1], float64[::1], float64[::1])")
def describe(row: Float, nominal: Float, p: Float, settings: Float, out: Float) -> None:
    """Write acceleration and sigmas of a state."""
    b = nominal
    a = rotate(
        b[_Q],
        b[_Q + 1],
        b[_Q + 2],
        b[_Q + 3],
        row[_ACC] - b[_BA],
        row[_ACC + 1] - b[_BA + 1],
        row[_ACC + 2] - b[_BA + 2],
    )
    out[_O_A], out[_O_A + 1], out[_O_A + 2] = a[0], a[1], a[2] - settings[_G]
    for i in range(p.shape[0]):
        out[_O_SIGMA + i] = math.sqrt(max(p[i, i], 0.0))


@kernel(
    "void(float64[:, ::1], float64[::1], float64[::1], float64[:, ::1], float64[::1], float64[:, ::1],"
    "float64[:, :, ::1], float64[:, ::1])"
)
def run(
    samples: Float,
    settings: Float,
    nominal: Float,
    p: Float,
    memory: Float,
    states: Float,
    covariances: Float,
    out: Float,
) -> None:
    """Filter K samples; write the state after each, and the covariance when there is room for K of them.

    Markers that are shut out for long show that the filter is wrong, not they: its covariance then grows until the
    last of them is credible, and the growth is written for the way back.
    """
    n = p.shape[0]
    phi, work = np.empty((n, n)), np.empty((n, n))
    for k in range(len(samples)):
        row = samples[k]
        if math.isfinite(memory[_GYR]):
            predict_state(nominal, memory, row, settings, phi)
            doubt_heading(phi, p, settings)
            predict_covariance(p, phi, memory, row, settings, work)
        out[k, _O_NIS], out[k, _O_STATE], out[k, _O_GROWTH] = math.nan, _COASTED, 1.0
        memory[_COASTING] += 1.0
        if math.isfinite(row[_MARKER] + row[_MARKER + 1] + row[_MARKER + 2]):
            nis = update_marker(nominal, p, row, settings, settings[_GATE], work, out[k, _O_INNOVATION:])
            out[k, _O_NIS], out[k, _O_STATE] = abs(nis), _MEASURED if nis >= 0.0 else _REJECTED
            memory[_STREAK] += 1.0
            if nis < 0.0 and memory[_STREAK] >= _RECOVER_COUNT and memory[_COASTING] >= settings[_RECOVER]:
                growth = max(1.0, -nis / 3.0)
                for i in range(n):
                    for j in range(n):
                        p[i, j] *= growth
                nis = update_marker(nominal, p, row, settings, math.inf, work, out[k, _O_INNOVATION:])
                out[k, _O_STATE], out[k, _O_GROWTH] = _RECOVERED, growth
            if nis >= 0.0:
                memory[_STREAK] = memory[_COASTING] = 0.0
        for i in range(_SAMPLE):
            memory[i] = row[i]
        for i in range(len(nominal)):
            states[k, i] = nominal[i]
        describe(row, nominal, p, settings, out[k])
        if len(covariances):
            for i in range(n):
                for j in range(n):
                    covariances[k, i, j] = p[i, j]


@kernel(
    "void(float64[:, ::1], float64[::1], float64[:, ::1], float64[:, :, ::1], float64[:, ::1], float64[::1],"
    "float64[:, ::1], boolean)"
)
def backward(
    samples: Float,
    settings: Float,
    states: Float,
    covariances: Float,
    out: Float,
    later: Float,
    later_covariance: Float,
    is_last: bool,
) -> None:
    """Rauch-Tung-Striebel with the a priori covariance, differences on the manifold (page 2.4, E5, E6).

    `samples` has one row more than `states` unless they are the last; `later` is the smoothed state after them and
    becomes that of their first. `states` and `out` are overwritten by the smoothed.
    """
    n = covariances.shape[1]
    phi, prior, work = np.empty((n, n)), np.empty((n, n)), np.empty((3, n, n))
    state, error, moved = np.empty(states.shape[1]), np.empty(n), np.empty(n)
    growth = out[len(states), _O_GROWTH] if not is_last else 1.0
    for k in range(len(states) - 1, -1, -1):
        p = covariances[k]
        if not (is_last and k == len(states) - 1):
            for i in range(len(state)):
                state[i] = states[k, i]
            predict_state(state, samples[k], samples[k + 1], settings, phi)
            doubt_heading(phi, p, settings)
            prior[:, :] = p
            predict_covariance(prior, phi, samples[k], samples[k + 1], settings, work[0])
            for i in range(n):
                for j in range(n):
                    prior[i, j] *= growth
            difference(later, state, error)
            if step_back(p, phi, prior, later_covariance, error, moved, work):
                inject(states[k], moved)
        growth = out[k, _O_GROWTH]
        for i in range(len(later)):
            later[i] = states[k, i]
        for i in range(n):
            for j in range(n):
                later_covariance[i, j] = p[i, j]
        describe(samples[k], states[k], p, settings, out[k])
