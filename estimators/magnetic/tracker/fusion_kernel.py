"""Steps of the tracker fusion between fixes: strapdown of the difference, error dynamics; compiled."""

import math

import numpy as np

from estimators._kernels import Scalars4, exponential, multiply, normalized, rotate
from estimators.kernels import step
from estimators.kernels.attitudes import attitude_matrix, turn_between, turn_in_world
from estimators.kernels.matrices import matrix_multiply, symmetrise
from estimators.magnetic.relative.motion import add_skew
from estimators.magnetic.tracker import fusion_layout as at
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
_EQ, _EPSI = at.E_FIX_POSITION, at.E_FIX_ATTITUDE
_GYR, _ACC, _ACC_M, _GM = at.GYROSCOPE, at.FORCE, at.SOURCE_FORCE, at.SOURCE_ATTITUDE
_T, _FORCE, _RATE, _FORCE_WALK, _RATE_WALK = (
    at.TIME_STEP,
    at.FORCE_SIGMA,
    at.RATE_SIGMA,
    at.FORCE_WALK,
    at.RATE_WALK,
)
_XI_SIGMA, _XI_TIME = at.FILTER_SIGMA, at.FILTER_TIME


@step("void(float64[::1], float64[::1])")
def inject(nominal: Float, error: Float) -> None:
    """Put an error (truth minus estimate, turns in the world) into the nominal state."""
    for i in range(3):
        nominal[_P + i] += error[_EP + i]
        nominal[_V + i] += error[_EV + i]
        nominal[_BA + i] += error[_EA + i]
        nominal[_BG + i] += error[_EG + i]
        nominal[_XI + i] += error[_EXI + i]
        nominal[_PHI + i] += error[_EPHI + i]
        nominal[_BM + i] += error[_EM + i]
    turn_in_world(nominal[_Q : _Q + 4], error[_ET : _ET + 3])


@step()
def _attitude_between(before: Float, now: Float) -> Scalars4:
    """Return the source's attitude halfway between two samples."""
    dot = 0.0
    for i in range(4):
        dot += before[_GM + i] * now[_GM + i]
    sign = 1.0 if dot >= 0.0 else -1.0
    return normalized(
        before[_GM] + sign * now[_GM],
        before[_GM + 1] + sign * now[_GM + 1],
        before[_GM + 2] + sign * now[_GM + 2],
        before[_GM + 3] + sign * now[_GM + 3],
    )


@step()
def _turn_world(nominal: Float, a: Float, wander: Float, last: Float) -> None:
    """Turn place and velocity with the world of the source's filter, and write what its error does to them."""
    lever = np.zeros((3, 3))
    for error in (_EP, _EV, _ET):
        add_skew(a, error, error, 1.0, wander[0], wander[1], wander[2])
    for start, error in ((_P, _EP), (_V, _EV)):
        x, y, z = nominal[start], nominal[start + 1], nominal[start + 2]
        lever[:, :] = 0.0
        add_skew(lever, 0, 0, -1.0, x, y, z)
        for i in range(3):
            for j in range(3):
                nominal[start + i] += lever[i, j] * wander[j]
                for k in range(3):
                    a[error + i, _EPHI + j] += lever[i, k] * last[k, j]


@step("void(float64[::1], float64[::1], float64[::1], float64[::1], float64[:, ::1])")
def propagate(nominal: Float, before: Float, now: Float, settings: Float, a: Float) -> None:
    """Carry the nominal state over a step (eq. 6.1-6.4, 6.8) and write its error matrix (page C4 2.2, E6).

    `before` and `now` are samples up to the source's attitude; signals are taken as their mean.
    """
    t, n = settings[_T], a.shape[0]
    for i in range(n):
        for j in range(n):
            a[i, j] = 0.0
        a[i, i] = 1.0
    w, f, fm = np.empty(3), np.empty(3), np.empty(3)
    for i in range(3):
        w[i] = 0.5 * (before[_GYR + i] + now[_GYR + i]) - nominal[_BG + i]
        f[i] = 0.5 * (before[_ACC + i] + now[_ACC + i]) - nominal[_BA + i]
        fm[i] = 0.5 * (before[_ACC_M + i] + now[_ACC_M + i]) - nominal[_BM + i]
    m = _attitude_between(before, now)
    half = exponential(0.5 * t * w[0], 0.5 * t * w[1], 0.5 * t * w[2])
    q = multiply(
        nominal[_Q], nominal[_Q + 1], nominal[_Q + 2], nominal[_Q + 3], half[0], half[1], half[2], half[3]
    )
    own = rotate(q[0], q[1], q[2], q[3], f[0], f[1], f[2])
    worn = rotate(m[0], m[1], m[2], m[3], fm[0], fm[1], fm[2])
    r, rm, first, last = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    wander = np.zeros(3)
    attitude_matrix(np.array(q), r)
    attitude_matrix(np.array(m), rm)
    attitude_matrix(before[_GM:], first)
    attitude_matrix(now[_GM:], last)
    keep = math.exp(-t / settings[_XI_TIME])
    # The world is the one that the source's filter says: it turns by what that filter's error does in world axes.
    for i in range(3):
        for j in range(3):
            last[i, j] = keep * last[i, j] - first[i, j]
            wander[i] += last[i, j] * nominal[_PHI + j]
            a[_ET + i, _EPHI + j] = last[i, j]
    for i in range(3):
        net = own[i] - worn[i]
        nominal[_P + i] += t * nominal[_V + i] + 0.5 * t * t * net
        nominal[_V + i] += t * net
        nominal[_XI + i] *= keep
        nominal[_PHI + i] *= keep
        a[_EP + i, _EV + i] = t
        for j in range(3):
            a[_EP + i, _EA + j], a[_EV + i, _EA + j] = -0.5 * t * t * r[i, j], -t * r[i, j]
            a[_EP + i, _EM + j], a[_EV + i, _EM + j] = 0.5 * t * t * rm[i, j], t * rm[i, j]
            a[_ET + i, _EG + j] = -t * r[i, j]
        a[_EQ + i, _EQ + i] = a[_EPSI + i, _EPSI + i] = 0.0
        a[_EXI + i, _EXI + i] = a[_EPHI + i, _EPHI + i] = keep
    add_skew(a, _EP, _ET, -0.5 * t * t, own[0], own[1], own[2])
    add_skew(a, _EV, _ET, -t, own[0], own[1], own[2])
    _turn_world(nominal, a, wander, last)
    q = multiply(q[0], q[1], q[2], q[3], half[0], half[1], half[2], half[3])
    turn = exponential(wander[0], wander[1], wander[2])
    q = multiply(turn[0], turn[1], turn[2], turn[3], q[0], q[1], q[2], q[3])
    q = normalized(q[0], q[1], q[2], q[3])
    nominal[_Q], nominal[_Q + 1], nominal[_Q + 2], nominal[_Q + 3] = q


@step("float64(float64[::1], float64[::1], float64[::1], float64)")
def relative_rate(nominal: Float, before: Float, now: Float, time_step_s: float) -> float:
    """Return how fast the sensor turns against the source, rad/s."""
    source = np.empty(3)
    turn_between(now[_GM : _GM + 4], before[_GM : _GM + 4], source)
    own = rotate(
        nominal[_Q],
        nominal[_Q + 1],
        nominal[_Q + 2],
        nominal[_Q + 3],
        now[_GYR] - nominal[_BG],
        now[_GYR + 1] - nominal[_BG + 1],
        now[_GYR + 2] - nominal[_BG + 2],
    )
    total = 0.0
    for i in range(3):
        total += (own[i] - source[i] / time_step_s) ** 2
    return math.sqrt(total)


@step(
    "void(float64[:, ::1], float64[:, ::1], float64[::1], float64[::1], float64[::1], float64[:, ::1],"
    "float64[:, :, ::1])"
)
def predict(
    p: Float, a: Float, nominal: Float, source: Float, settings: Float, white: Float, work: Float
) -> None:
    """Carry the covariance over a step to `nominal`; the white errors of a fix are drawn again. `work` is (3, n, n).

    `source` is the attitude of the source then, `white` the covariance of those errors, shape (6, 6). What the error
    of the source's filter wanders in the step, w in its axes, turns the world with all that is in it.
    """
    t, n = settings[_T], p.shape[0]
    matrix_multiply(a, p, work[0])
    for i in range(n):
        for j in range(n):
            work[1, i, j] = work[0, j, i]
    # A (A P)^T = A P A^T; both products pass over the zeros of A.
    matrix_multiply(a, work[1], p)
    # Both modules' accelerometers are in the difference.
    force, spin = 2.0 * settings[_FORCE] ** 2, settings[_RATE] ** 2
    wander = settings[_XI_SIGMA] ** 2 * (1.0 - math.exp(-2.0 * t / settings[_XI_TIME]))
    turn, lever, r = np.zeros((n, 3)), np.zeros((n, 3)), np.empty((3, 3))
    attitude_matrix(source, r)
    add_skew(lever, _EP, 0, -1.0, nominal[_P], nominal[_P + 1], nominal[_P + 2])
    add_skew(lever, _EV, 0, -1.0, nominal[_V], nominal[_V + 1], nominal[_V + 2])
    for i in range(3):
        lever[_ET + i, i] = 1.0
    matrix_multiply(lever, r, turn)
    for i in range(3):
        turn[_EPHI + i, i] = 1.0
    for i in range(n):
        for j in range(n):
            p[i, j] += wander * (turn[i, 0] * turn[j, 0] + turn[i, 1] * turn[j, 1] + turn[i, 2] * turn[j, 2])
    for i in range(3):
        p[_EP + i, _EP + i] += force * t**4 / 4.0
        p[_EP + i, _EV + i] += force * t**3 / 2.0
        p[_EV + i, _EP + i] += force * t**3 / 2.0
        p[_EV + i, _EV + i] += force * t * t
        p[_ET + i, _ET + i] += spin * t * t
        p[_EA + i, _EA + i] += settings[_FORCE_WALK] ** 2 * t
        p[_EM + i, _EM + i] += settings[_FORCE_WALK] ** 2 * t
        p[_EG + i, _EG + i] += settings[_RATE_WALK] ** 2 * t
        p[_EXI + i, _EXI + i] += wander
    for i in range(6):
        for j in range(6):
            p[_EQ + i, _EQ + j] += white[i, j]
    symmetrise(p)
