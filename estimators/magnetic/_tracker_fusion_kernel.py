"""Steps of the tracker fusion: strapdown of the difference, error dynamics, fixes; compiled."""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import exponential, kernel, multiply, normalized, rotate
from estimators.magnetic import _tracker_fusion_layout as at
from estimators.magnetic._relative_motion import add_skew
from estimators.magnetic._relative_update import innovate
from estimators.magnetic._small_algebra import joseph, multiply_turned, symmetrise
from estimators.magnetic._small_algebra import multiply as matrix_multiply
from estimators.recording import Float

_P, _V, _Q, _BA, _BG, _AE = at.POSITION, at.VELOCITY, at.ATTITUDE, at.FORCE_BIAS, at.RATE_BIAS, at.LEAK
_EP, _EV, _ET, _EA, _EG, _EQ, _EPSI, _EL = (
    at.E_POSITION,
    at.E_VELOCITY,
    at.E_ATTITUDE,
    at.E_FORCE,
    at.E_RATE,
    at.E_FIX_POSITION,
    at.E_FIX_ATTITUDE,
    at.E_LEAK,
)
_GYR, _ACC, _ACC_M, _GM, _XI = (
    at.GYROSCOPE,
    at.FORCE,
    at.SOURCE_FORCE,
    at.SOURCE_ATTITUDE,
    at.FILTER_ATTITUDE,
)
_FIX_P, _FIX_Q, _FIX_COV = at.FIX_POSITION, at.FIX_ATTITUDE, at.FIX_COVARIANCE
_T, _FORCE, _RATE, _FORCE_WALK, _RATE_WALK = (
    at.TIME_STEP,
    at.FORCE_SIGMA,
    at.RATE_SIGMA,
    at.FORCE_WALK,
    at.RATE_WALK,
)
_LEAK_SIGMA, _LEAK_TIME, _FLOOR_P, _FLOOR_A, _XI_SIGMA = (
    at.LEAK_SIGMA,
    at.LEAK_TIME,
    at.FLOOR_POSITION,
    at.FLOOR_ATTITUDE,
    at.FILTER_ATTITUDE_SIGMA,
)
_LAW_P, _LAW_R, _LAW_A = at.FIX_POSITION_SIGMA, at.FIX_DISTANCE, at.FIX_ATTITUDE_SIGMA
_GATE, _USE_PSI, _USE_XI, _MOTION = at.GATE, at.USE_FIX_ATTITUDE, at.USE_FILTER_ATTITUDE, at.BURST_MOTION

_NOTHING = 1e-16
"""What is left of the measurement noise beside the white states that carry it (erratum E3)."""


@kernel("void(float64[::1], float64[:, ::1])")
def turned(q: Float, r: Float) -> None:
    """Write the matrix of a quaternion."""
    for j in range(3):
        a = rotate(
            q[0], q[1], q[2], q[3], 1.0 if j == 0 else 0.0, 1.0 if j == 1 else 0.0, 1.0 if j == 2 else 0.0
        )
        r[0, j], r[1, j], r[2, j] = a[0], a[1], a[2]


@kernel("void(float64[::1], float64[::1], float64[::1], float64[::1])")
def difference_of_attitudes(qw: Float, other: Float, out: Float, work: Float) -> None:
    """Write Log(q other^-1): the turn, in the world, that takes `other` to `q`; `work` has shape (4,)."""
    q = multiply(qw[0], qw[1], qw[2], qw[3], other[0], -other[1], -other[2], -other[3])
    sign = 1.0 if q[0] >= 0.0 else -1.0
    sine = math.sqrt(q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    scale = 2.0 if sine < 1e-9 else 2.0 * math.atan2(sine, sign * q[0]) / sine
    for i in range(3):
        out[i] = sign * scale * q[1 + i]


@kernel("void(float64[::1], float64[::1])")
def inject(nominal: Float, error: Float) -> None:
    """Put an error (truth minus estimate, turns in the world) into the nominal state."""
    for i in range(3):
        nominal[_P + i] += error[_EP + i]
        nominal[_V + i] += error[_EV + i]
        nominal[_BA + i] += error[_EA + i]
        nominal[_BG + i] += error[_EG + i]
        nominal[_AE + i] += error[_EL + i]
    turn = exponential(error[_ET], error[_ET + 1], error[_ET + 2])
    q = multiply(
        turn[0], turn[1], turn[2], turn[3], nominal[_Q], nominal[_Q + 1], nominal[_Q + 2], nominal[_Q + 3]
    )
    q = normalized(q[0], q[1], q[2], q[3])
    nominal[_Q], nominal[_Q + 1], nominal[_Q + 2], nominal[_Q + 3] = q


@kernel("void(float64[::1], float64[::1], float64[::1], float64[::1], float64[:, ::1])")
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
        fm[i] = 0.5 * (before[_ACC_M + i] + now[_ACC_M + i])
    dot = 0.0
    for i in range(4):
        dot += before[_GM + i] * now[_GM + i]
    sign = 1.0 if dot >= 0.0 else -1.0
    m = normalized(
        before[_GM] + sign * now[_GM],
        before[_GM + 1] + sign * now[_GM + 1],
        before[_GM + 2] + sign * now[_GM + 2],
        before[_GM + 3] + sign * now[_GM + 3],
    )
    half = exponential(0.5 * t * w[0], 0.5 * t * w[1], 0.5 * t * w[2])
    q = multiply(
        nominal[_Q], nominal[_Q + 1], nominal[_Q + 2], nominal[_Q + 3], half[0], half[1], half[2], half[3]
    )
    own = rotate(q[0], q[1], q[2], q[3], f[0], f[1], f[2])
    worn = rotate(m[0], m[1], m[2], m[3], fm[0], fm[1], fm[2])
    r = np.empty((3, 3))
    turned(np.array(q), r)
    keep = math.exp(-t / settings[_LEAK_TIME])
    for i in range(3):
        net = own[i] - worn[i] - nominal[_AE + i]
        nominal[_P + i] += t * nominal[_V + i] + 0.5 * t * t * net
        nominal[_V + i] += t * net
        nominal[_AE + i] *= keep
        a[_EP + i, _EV + i] = t
        a[_EP + i, _EL + i], a[_EV + i, _EL + i] = -0.5 * t * t, -t
        for j in range(3):
            a[_EP + i, _EA + j], a[_EV + i, _EA + j] = -0.5 * t * t * r[i, j], -t * r[i, j]
            a[_ET + i, _EG + j] = -t * r[i, j]
        a[_EQ + i, _EQ + i] = a[_EPSI + i, _EPSI + i] = 0.0
        a[_EL + i, _EL + i] = keep
    add_skew(a, _EP, _ET, -0.5 * t * t, own[0], own[1], own[2])
    add_skew(a, _EV, _ET, -t, own[0], own[1], own[2])
    q = multiply(q[0], q[1], q[2], q[3], half[0], half[1], half[2], half[3])
    q = normalized(q[0], q[1], q[2], q[3])
    nominal[_Q], nominal[_Q + 1], nominal[_Q + 2], nominal[_Q + 3] = q


@kernel("float64(float64[::1], float64[::1], float64[::1], float64)")
def relative_rate(nominal: Float, before: Float, now: Float, time_step_s: float) -> float:
    """Return how fast the sensor turns against the source, rad/s."""
    source, unused = np.empty(3), np.empty(4)
    difference_of_attitudes(now[_GM : _GM + 4], before[_GM : _GM + 4], source, unused)
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


@kernel("void(float64[::1], float64[::1], float64, float64[:, ::1], float64[:, ::1])")
def fix_noise(sample: Float, settings: Float, rate: float, position: Float, attitude: Float) -> None:
    """Write the covariances of a fix in world axes, both (3, 3): its own, else the law of the page (2.2).

    The law: a sigma that grows with the fourth power of the distance. Without a fix, that at the reference. A burst
    is solved as if nothing moved in it: what turns by `rate` meanwhile is added (own; feature 18).
    """
    own = math.isfinite(sample[_FIX_COV])
    r = 0.0
    for i in range(3):
        r += sample[_FIX_P + i] ** 2
    turn = rate * settings[_MOTION]
    moved = turn * math.sqrt(r) if math.isfinite(r) else 0.0
    ratio = max(1.0, (math.sqrt(r) / settings[_LAW_R]) ** 4) if math.isfinite(r) else 1.0
    for i in range(3):
        for j in range(3):
            position[i, j] = attitude[i, j] = 0.0
        position[i, i] = (settings[_LAW_P] * ratio) ** 2 + moved * moved
        attitude[i, i] = settings[_LAW_A] ** 2 + turn * turn
    if not own:
        return
    m, s, given, left = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    turned(sample[_GM : _GM + 4], m)
    q = multiply(
        sample[_GM],
        sample[_GM + 1],
        sample[_GM + 2],
        sample[_GM + 3],
        sample[_FIX_Q],
        sample[_FIX_Q + 1],
        sample[_FIX_Q + 2],
        sample[_FIX_Q + 3],
    )
    turned(np.array(q), s)
    for block in range(2):
        for i in range(3):
            for j in range(3):
                given[i, j] = sample[_FIX_COV + 6 * (3 * block + i) + 3 * block + j]
        out = position if block == 0 else attitude
        matrix_multiply(m if block == 0 else s, given, left)
        multiply_turned(left, m if block == 0 else s, out)
        floor = settings[_FLOOR_P] if block == 0 else settings[_FLOOR_A]
        extra = moved if block == 0 else turn
        for i in range(3):
            out[i, i] += floor * floor + extra * extra


@kernel("void(float64[:, ::1], float64[:, ::1], float64[::1], float64[::1], float64, float64[:, :, ::1])")
def predict(p: Float, a: Float, sample: Float, settings: Float, rate: float, work: Float) -> None:
    """Carry the covariance over a step; the white errors of a fix are drawn anew. `work` is (3, n, n).

    `rate` is that of the sensor against the source, rad/s.
    """
    t, n = settings[_T], p.shape[0]
    matrix_multiply(a, p, work[0])
    multiply_turned(work[0], a, p)
    force, spin = settings[_FORCE] ** 2, settings[_RATE] ** 2
    # Both modules' accelerometers are in the difference.
    force *= 2.0
    leak = settings[_LEAK_SIGMA] ** 2 * (1.0 - math.exp(-2.0 * t / settings[_LEAK_TIME]))
    white = np.empty((2, 3, 3))
    fix_noise(sample, settings, rate, white[0], white[1])
    for i in range(3):
        p[_EP + i, _EP + i] += force * t**4 / 4.0
        p[_EP + i, _EV + i] += force * t**3 / 2.0
        p[_EV + i, _EP + i] += force * t**3 / 2.0
        p[_EV + i, _EV + i] += force * t * t
        p[_ET + i, _ET + i] += spin * t * t
        p[_EA + i, _EA + i] += settings[_FORCE_WALK] ** 2 * t
        p[_EG + i, _EG + i] += settings[_RATE_WALK] ** 2 * t
        p[_EL + i, _EL + i] += leak
        for j in range(3):
            p[_EQ + i, _EQ + j] += white[0, i, j]
            p[_EPSI + i, _EPSI + j] += white[1, i, j]
    for k in range(n):
        # Exact symmetry, also after the products.
        for j in range(k):
            p[k, j] = p[j, k] = 0.5 * (p[k, j] + p[j, k])


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


@kernel(
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

    Separate rows; returns the status bits, `nis` takes the normalised innovation squared of the position.
    """
    n, status = p.shape[0], 0
    z, h, r, unused = np.empty(3), np.zeros((3, n)), np.zeros((3, 3)), np.empty(4)
    fixed = math.isfinite(sample[_FIX_P]) and math.isfinite(sample[_FIX_Q])
    if fixed:
        place = rotate(
            sample[_GM],
            sample[_GM + 1],
            sample[_GM + 2],
            sample[_GM + 3],
            sample[_FIX_P],
            sample[_FIX_P + 1],
            sample[_FIX_P + 2],
        )
        for i in range(3):
            z[i] = place[i] - nominal[_P + i]
            h[i, _EP + i] = h[i, _EQ + i] = 1.0
            r[i, i] = _NOTHING
        found = correct(p, h, r, z, settings[_GATE], nominal, work)
        nis[0] = abs(found)
        if found < 0.0:
            status |= at.GATED
            counters[at.STREAK] += 1
        else:
            counters[at.STREAK] = 0
    if fixed and settings[_USE_PSI] > 0.0:
        q = multiply(
            sample[_GM],
            sample[_GM + 1],
            sample[_GM + 2],
            sample[_GM + 3],
            sample[_FIX_Q],
            sample[_FIX_Q + 1],
            sample[_FIX_Q + 2],
            sample[_FIX_Q + 3],
        )
        difference_of_attitudes(np.array(q), nominal[_Q : _Q + 4], z, unused)
        h[:] = 0.0
        for i in range(3):
            h[i, _ET + i] = h[i, _EPSI + i] = 1.0
        if correct(p, h, r, z, settings[_GATE], nominal, work) < 0.0:
            status |= at.GATED
    counters[at.SINCE_ATTITUDE] += 1
    due = fixed or counters[at.SINCE_ATTITUDE] >= settings[at.ATTITUDE_TICKS]
    if settings[_USE_XI] > 0.0 and due and math.isfinite(sample[_XI]):
        counters[at.SINCE_ATTITUDE] = 0
        difference_of_attitudes(sample[_XI : _XI + 4], nominal[_Q : _Q + 4], z, unused)
        h[:] = 0.0
        for i in range(3):
            h[i, _ET + i] = 1.0
            r[i, i] = settings[_XI_SIGMA] ** 2
        if correct(p, h, r, z, settings[_GATE], nominal, work) < 0.0:
            status |= at.GATED
    return status


__all__ = [
    "correct",
    "difference_of_attitudes",
    "fix_noise",
    "inject",
    "predict",
    "propagate",
    "relative_rate",
    "turned",
    "use_fix",
]
