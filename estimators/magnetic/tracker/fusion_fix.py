"""Steps of the tracker fusion at a fix: its noise, its rows, and the start from one; compiled."""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import kernel, multiply, normalized, rotate, step
from estimators.kernels.attitudes import attitude_matrix, turn_between
from estimators.kernels.matrices import joseph, matrix_multiply, multiply_turned, symmetrise
from estimators.magnetic.relative.update import innovate
from estimators.magnetic.tracker import fusion_layout as at
from estimators.magnetic.tracker.fusion_kernel import inject
from estimators.recording import Float

_P, _V, _Q, _BG, _XI, _PHI = (
    at.POSITION,
    at.VELOCITY,
    at.ATTITUDE,
    at.RATE_BIAS,
    at.FILTER_ERROR,
    at.SOURCE_ERROR,
)
_EP, _EV, _ET, _EA, _EG, _EQ, _EXI, _EPHI, _EM = (
    at.E_POSITION,
    at.E_VELOCITY,
    at.E_ATTITUDE,
    at.E_FORCE,
    at.E_RATE,
    at.E_FIX_POSITION,
    at.E_FILTER,
    at.E_SOURCE_FILTER,
    at.E_SOURCE_FORCE,
)
_GM, _SAID, _FIX_P, _FIX_Q, _FIX_COV = (
    at.SOURCE_ATTITUDE,
    at.FILTER_ATTITUDE,
    at.FIX_POSITION,
    at.FIX_ATTITUDE,
    at.FIX_COVARIANCE,
)
_FIX_V, _EFFECT = at.FIX_VELOCITY, at.FIX_EFFECT
_FLOOR_P, _FLOOR_A, _XI_SIGMA, _MOTION = (
    at.FLOOR_POSITION,
    at.FLOOR_ATTITUDE,
    at.FILTER_SIGMA,
    at.BURST_MOTION,
)
_LAW_P, _LAW_R, _LAW_A = at.FIX_POSITION_SIGMA, at.FIX_DISTANCE, at.FIX_ATTITUDE_SIGMA
_GATE, _FIX_GATE, _USE_PSI, _USE_XI = at.GATE, at.FIX_GATE, at.USE_FIX_ATTITUDE, at.USE_FILTER_ATTITUDE
_STARTED, _STILL, _STREAK, _RESTARTED = at.STARTED, at.STILL, at.STREAK, at.RESTARTED
_SINCE, _FORCE_START, _RATE_START, _RATE = at.SINCE_ATTITUDE, at.FORCE_START, at.RATE_START, at.RATE_SIGMA

_NOTHING = 1e-16
"""What is left of the measurement noise beside the states that carry it (erratum E3)."""
_LEAST_STILL = 20
_START_VELOCITY, _RESTART_VELOCITY = 0.05, 0.5
"""Sigmas of the velocity (m/s) at a first burst, for which one stands, and at one in motion."""


@step("void(float64[::1], float64[:, ::1], float64[:, ::1], float64[::1])")
def fix_axes(sample: Float, source: Float, sensor: Float, q: Float) -> None:
    """Write the attitudes of source and sensor in the world as a fix has them: matrices (3, 3), quaternion (4,)."""
    attitude_matrix(sample[_GM : _GM + 4], source)
    product = multiply(
        sample[_GM],
        sample[_GM + 1],
        sample[_GM + 2],
        sample[_GM + 3],
        sample[_FIX_Q],
        sample[_FIX_Q + 1],
        sample[_FIX_Q + 2],
        sample[_FIX_Q + 3],
    )
    q[0], q[1], q[2], q[3] = normalized(product[0], product[1], product[2], product[3])
    attitude_matrix(q, sensor)


@step("void(float64[::1], float64[::1], float64, float64[:, ::1])")
def fix_noise(sample: Float, settings: Float, rate: float, noise: Float) -> None:
    """Write the covariance of a fix in world axes, (6, 6): its own with the floors, else the law of the page (2.2).

    The law: a sigma that grows with the fourth power of the distance. Zeros without a fix. A fix that does not say
    what the velocity does to it was solved as if nothing moved: what turns by `rate` in a burst is added (own; feature
    18). Position and orientation of a fix are one measurement, correlated by up to 0.95 (page C5 2.7): all of its
    covariance counts.
    """
    noise[:, :] = 0.0
    if not (math.isfinite(sample[_FIX_P]) and math.isfinite(sample[_FIX_Q])):
        return
    r = math.sqrt(sample[_FIX_P] ** 2 + sample[_FIX_P + 1] ** 2 + sample[_FIX_P + 2] ** 2)
    turn = 0.0 if math.isfinite(sample[_EFFECT]) else rate * settings[_MOTION]
    moved = turn * r
    place, angle = settings[_FLOOR_P], settings[_FLOOR_A]
    if math.isfinite(sample[_FIX_COV]):
        frame, given, left = np.zeros((6, 6)), np.empty((6, 6)), np.empty((6, 6))
        source, sensor, q = np.empty((3, 3)), np.empty((3, 3)), np.empty(4)
        fix_axes(sample, source, sensor, q)
        for i in range(3):
            for j in range(3):
                frame[i, j], frame[3 + i, 3 + j] = source[i, j], sensor[i, j]
        for i in range(6):
            for j in range(6):
                given[i, j] = sample[_FIX_COV + 6 * i + j]
        matrix_multiply(frame, given, left)
        multiply_turned(left, frame, noise)
    else:
        place, angle = settings[_LAW_P] * max(1.0, (r / settings[_LAW_R]) ** 4), settings[_LAW_A]
    for i in range(3):
        noise[i, i] += place * place + moved * moved
        noise[3 + i, 3 + i] += angle * angle + turn * turn
    symmetrise(noise)


@step("void(float64[::1], float64[:, ::1])")
def velocity_effect(sample: Float, effect: Float) -> None:
    """Write what an error of the velocity does to a fix, world axes, (6, 3); zeros where it does not say."""
    effect[:, :] = 0.0
    if not math.isfinite(sample[_EFFECT]):
        return
    source, sensor, q, given = np.empty((3, 3)), np.empty((3, 3)), np.empty(4), np.empty((3, 3))
    left = np.empty((3, 3))
    fix_axes(sample, source, sensor, q)
    for block in range(2):
        for i in range(3):
            for j in range(3):
                given[i, j] = sample[_EFFECT + 9 * block + 3 * i + j]
        matrix_multiply(source if block == 0 else sensor, given, left)
        multiply_turned(left, source, effect[3 * block : 3 * block + 3])


@step("void(float64[::1], float64[::1])")
def solved_velocity(sample: Float, velocity: Float) -> None:
    """Write the velocity that a fix was solved at, world axes; zero where it does not say."""
    velocity[:] = 0.0
    if math.isfinite(sample[_FIX_V]) and math.isfinite(sample[_EFFECT]):
        m, v = sample[_GM : _GM + 4], sample[_FIX_V : _FIX_V + 3]
        velocity[0], velocity[1], velocity[2] = rotate(m[0], m[1], m[2], m[3], v[0], v[1], v[2])


@kernel(
    "float64(float64[:, ::1], float64[:, ::1], float64[:, ::1], float64[::1], float64, float64[::1],"
    "float64[:, ::1])"
)
def correct(p: Float, h: Float, r: Float, z: Float, gate: float, nominal: Float, work: Float) -> float:
    """Correct by rows z = H error + noise; return the normalised innovation squared, negative when gated."""
    n, m = p.shape[0], h.shape[0]
    gain, error = np.empty((n, m)), np.empty(n)
    nis = innovate(p, h, r, z, gain)
    if not 0.0 <= nis <= gate:
        return -max(nis, _NOTHING)
    for i in range(n):
        error[i] = 0.0
        for k in range(m):
            error[i] += gain[i, k] * z[k]
    inject(nominal, error)
    joseph(p, h, r, gain, work)
    symmetrise(p)
    return nis


@step(
    "int64(float64[::1], float64[::1], float64[::1], float64[:, ::1], int64[::1], float64[:, ::1], float64[::1])"
)
def use_fix(
    sample: Float,
    settings: Float,
    nominal: Float,
    p: Float,
    counters: NDArray[np.int64],
    work: Float,
    nis: Float,
) -> int:
    """Correct by the tracker's position and orientation and by the filter's orientation (eq. 6.18-6.21, E4).

    Separate rows; returns the status bits, `nis` takes the normalised innovation squared of the fix.
    """
    n, status = p.shape[0], 0
    fixed = math.isfinite(sample[_FIX_P]) and math.isfinite(sample[_FIX_Q])
    if fixed:
        rows = 6 if settings[_USE_PSI] > 0.0 else 3
        z, h, r = np.empty(rows), np.zeros((rows, n)), np.zeros((rows, rows))
        source, sensor, q, turn = np.empty((3, 3)), np.empty((3, 3)), np.empty(4), np.empty(3)
        effect, solved = np.empty((6, 3)), np.empty(3)
        fix_axes(sample, source, sensor, q)
        velocity_effect(sample, effect)
        solved_velocity(sample, solved)
        turn_between(q, nominal[_Q : _Q + 4], turn)
        for i in range(rows):
            z[i] = turn[i - 3] if i >= 3 else -nominal[_P + i]
            h[i, (_EP if i < 3 else _ET - 3) + i] = h[i, _EQ + i] = 1.0
            r[i, i] = _NOTHING
            for j in range(3):
                if i < 3:
                    z[i] += source[i, j] * sample[_FIX_P + j]
                z[i] -= effect[i, j] * (nominal[_V + j] - solved[j])
                h[i, _EV + j] = effect[i, j]
        found = correct(p, h, r, z, settings[_FIX_GATE if rows == 6 else _GATE], nominal, work)
        nis[0] = abs(found)
        if found < 0.0:
            status |= at.GATED
            counters[_STREAK] += 1
        else:
            counters[_STREAK] = 0
    counters[_SINCE] += 1
    due = fixed or counters[_SINCE] >= settings[at.ATTITUDE_TICKS]
    if settings[_USE_XI] > 0.0 and due and math.isfinite(sample[_SAID]):
        counters[_SINCE] = 0
        z, h, r = np.empty(3), np.zeros((3, n)), np.zeros((3, 3))
        worn, own = np.empty((3, 3)), np.empty((3, 3))
        attitude_matrix(sample[_GM : _GM + 4], worn)
        attitude_matrix(nominal[_Q : _Q + 4], own)
        turn_between(sample[_SAID : _SAID + 4], nominal[_Q : _Q + 4], z)
        # R_said = Exp(-source's error) R Exp(own error): each in the axes of its module.
        for i in range(3):
            h[i, _ET + i], r[i, i] = 1.0, _NOTHING
            for j in range(3):
                h[i, _EPHI + j], h[i, _EXI + j] = -worn[i, j], own[i, j]
                z[i] += worn[i, j] * nominal[_PHI + j] - own[i, j] * nominal[_XI + j]
        if correct(p, h, r, z, settings[_GATE], nominal, work) < 0.0:
            status |= at.GATED
    return status


@step("void(float64[::1], float64[::1], float64[::1], float64[:, ::1], float64[::1], int64[::1])")
def start(
    sample: Float, settings: Float, nominal: Float, p: Float, memory: Float, counters: NDArray[np.int64]
) -> None:
    """Begin at a fix: position and orientation are its own, the velocity that it was solved at (page 2.3).

    At rest the mean of the gyroscope is its offset, known to its noise over the root of the samples.
    """
    again = counters[_STARTED] > 0
    source, sensor, q = np.empty((3, 3)), np.empty((3, 3)), np.empty(4)
    fix_axes(sample, source, sensor, q)
    noise, effect, solved = np.empty((6, 6)), np.empty((6, 3)), np.empty(3)
    fix_noise(sample, settings, 0.0, noise)
    velocity_effect(sample, effect)
    solved_velocity(sample, solved)
    rested = not again and counters[_STILL] >= _LEAST_STILL
    speed = (_RESTART_VELOCITY if again else _START_VELOCITY) ** 2
    spread = np.zeros(at.ERRORS)
    for i in range(4):
        nominal[_Q + i] = q[i]
    for i in range(3):
        nominal[_P + i] = 0.0
        for j in range(3):
            nominal[_P + i] += source[i, j] * sample[_FIX_P + j]
        nominal[_V + i] = solved[i]
        nominal[_XI + i] = nominal[_PHI + i] = 0.0
        if rested:
            nominal[_BG + i] = memory[at.SUM_RATE + i] / counters[_STILL]
        rate = settings[_RATE] ** 2 / counters[_STILL] if rested else settings[_RATE_START] ** 2
        spread[_EV + i] = speed
        spread[_EA + i] = p[_EA + i, _EA + i] if again else settings[_FORCE_START] ** 2
        spread[_EM + i] = p[_EM + i, _EM + i] if again else settings[_FORCE_START] ** 2
        spread[_EG + i] = p[_EG + i, _EG + i] if again else rate
        spread[_EXI + i] = spread[_EPHI + i] = settings[_XI_SIGMA] ** 2
    for i in range(at.ERRORS):
        for j in range(at.ERRORS):
            p[i, j] = spread[i] if i == j else 0.0
    for i in range(6):
        row = (_EP if i < 3 else _ET - 3) + i
        for j in range(6):
            column = (_EP if j < 3 else _ET - 3) + j
            p[row, column] = noise[i, j]
            for k in range(3):
                p[row, column] += speed * effect[i, k] * effect[j, k]
        for k in range(3):
            p[row, _EV + k] = p[_EV + k, row] = -speed * effect[i, k]
    counters[_STARTED] = 1
    counters[_STREAK] = 0
    counters[_SINCE] = 0
    counters[_RESTARTED] += 1
