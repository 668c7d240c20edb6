"""Dead reckoning of a sensor against a turning source, and what it does to the errors (Schepers 2009, 6.2), compiled.

The velocity state is the inertial relative velocity in source axes: the published integral of the difference of
accelerations forgets that the source axes turn (erratum X1).
"""

import numpy as np

from estimators._kernels import exponential, kernel, multiply, normalized, rotate, step
from estimators.kernels.attitudes import attitude_matrix
from estimators.kernels.matrices import matrix_multiply, symmetrise
from estimators.magnetic.relative import layout as at
from estimators.recording import Float

_P, _U, _Q = at.POSITION, at.VELOCITY, at.ATTITUDE
_BA, _BG, _BAC, _BGC = at.FORCE_BIAS, at.RATE_BIAS, at.SOURCE_FORCE_BIAS, at.SOURCE_RATE_BIAS
_EP, _EU, _ET = at.E_POSITION, at.E_VELOCITY, at.E_ATTITUDE
_EA, _EG, _EAC, _EGC = at.E_FORCE, at.E_RATE, at.E_SOURCE_FORCE, at.E_SOURCE_RATE
_GYR, _ACC, _GYR_C, _ACC_C = at.GYROSCOPE, at.ACCELEROMETER, at.SOURCE_GYROSCOPE, at.SOURCE_ACCELEROMETER
_TIME_STEP, _FORCE_SIGMA, _RATE_SIGMA = at.TIME_STEP, at.FORCE_SIGMA, at.RATE_SIGMA
_FORCE_BIAS_SIGMA, _RATE_BIAS_SIGMA, _BIAS_DECAY = at.FORCE_BIAS_SIGMA, at.RATE_BIAS_SIGMA, at.BIAS_DECAY
_PUBLISHED = at.PUBLISHED
_WS, _FS, _WC, _FC = at.S_RATE, at.S_FORCE, at.S_SOURCE_RATE, at.S_SOURCE_FORCE

Vector = tuple[float, float, float]
_V = "UniTuple(float64, 3)"


@step(f"{_V}(float64, float64, float64, float64, float64, float64)")
def cross(ax: float, ay: float, az: float, bx: float, by: float, bz: float) -> Vector:
    """Return the cross product."""
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


@step("void(float64[:, ::1], int64, int64, float64, float64, float64, float64)")
def add_skew(f: Float, row: int, column: int, sign: float, x: float, y: float, z: float) -> None:
    """Add the cross-product matrix of a vector to a block."""
    f[row, column + 1] -= sign * z
    f[row, column + 2] += sign * y
    f[row + 1, column] += sign * z
    f[row + 1, column + 2] -= sign * x
    f[row + 2, column] -= sign * y
    f[row + 2, column + 1] += sign * x


@step("void(float64[::1], float64[::1], float64[::1], float64[::1])")
def corrected(nominal: Float, before: Float, now: Float, out: Float) -> None:
    """Write w_s, f_s, w_c, f_c: means of two samples, less the biases."""
    for i in range(3):
        out[_WS + i] = 0.5 * (before[_GYR + i] + now[_GYR + i]) - nominal[_BG + i]
        out[_FS + i] = 0.5 * (before[_ACC + i] + now[_ACC + i]) - nominal[_BA + i]
        out[_WC + i] = 0.5 * (before[_GYR_C + i] + now[_GYR_C + i]) - nominal[_BGC + i]
        out[_FC + i] = 0.5 * (before[_ACC_C + i] + now[_ACC_C + i]) - nominal[_BAC + i]


@step("void(float64[::1], float64[::1], float64, boolean)")
def mechanise(nominal: Float, signals: Float, time_step: float, published: bool) -> None:
    """Carry position, velocity and attitude over a step (method page 3.3; published: 3.2)."""
    t = time_step
    ws = (signals[_WS], signals[_WS + 1], signals[_WS + 2])
    fs = (signals[_FS], signals[_FS + 1], signals[_FS + 2])
    wc = (signals[_WC], signals[_WC + 1], signals[_WC + 2])
    fc = (signals[_FC], signals[_FC + 1], signals[_FC + 2])
    # The published position integral takes the source axes as fixed.
    c = (0.0, 0.0, 0.0) if published else wc
    p = (nominal[_P], nominal[_P + 1], nominal[_P + 2])
    u = (nominal[_U], nominal[_U + 1], nominal[_U + 2])
    q0 = (nominal[_Q], nominal[_Q + 1], nominal[_Q + 2], nominal[_Q + 3])
    half_c = exponential(-0.5 * t * wc[0], -0.5 * t * wc[1], -0.5 * t * wc[2])
    half_s = exponential(0.5 * t * ws[0], 0.5 * t * ws[1], 0.5 * t * ws[2])
    left = multiply(half_c[0], half_c[1], half_c[2], half_c[3], q0[0], q0[1], q0[2], q0[3])
    m = multiply(left[0], left[1], left[2], left[3], half_s[0], half_s[1], half_s[2], half_s[3])
    a = rotate(m[0], m[1], m[2], m[3], fs[0], fs[1], fs[2])
    a = (a[0] - fc[0], a[1] - fc[1], a[2] - fc[2])
    cp = cross(c[0], c[1], c[2], p[0], p[1], p[2])
    cu = cross(c[0], c[1], c[2], u[0], u[1], u[2])
    h = 0.5 * t
    pm = (p[0] + h * (u[0] - cp[0]), p[1] + h * (u[1] - cp[1]), p[2] + h * (u[2] - cp[2]))
    um = (u[0] + h * (a[0] - cu[0]), u[1] + h * (a[1] - cu[1]), u[2] + h * (a[2] - cu[2]))
    cp = cross(c[0], c[1], c[2], pm[0], pm[1], pm[2])
    cu = cross(c[0], c[1], c[2], um[0], um[1], um[2])
    for i in range(3):
        nominal[_P + i] += t * (um[i] - cp[i])
        nominal[_U + i] += t * (a[i] - cu[i])
    left = multiply(half_c[0], half_c[1], half_c[2], half_c[3], m[0], m[1], m[2], m[3])
    q = multiply(left[0], left[1], left[2], left[3], half_s[0], half_s[1], half_s[2], half_s[3])
    q = normalized(q[0], q[1], q[2], q[3])
    nominal[_Q], nominal[_Q + 1], nominal[_Q + 2], nominal[_Q + 3] = q


@step("void(float64[::1], float64[::1])")
def relax(nominal: Float, settings: Float) -> None:
    """Let the estimated offsets of the accelerometers return towards zero over a step (own, beside method page 3.4).

    An offset is a first-order Markov process, so what is expected of it decays as its variance does. The thesis lets
    only the variance decay: an estimate that nothing observes (an offset that both accelerometers share) then keeps
    every small correction for ever, and after hours is far outside of what its variance says.
    """
    if settings[_PUBLISHED] > 0.0:
        return
    share = settings[_BIAS_DECAY] * settings[_TIME_STEP]
    keep = 1.0 - share + 0.5 * share * share
    for i in range(3):
        nominal[_BA + i] *= keep
        nominal[_BAC + i] *= keep


@step("void(float64[::1], float64[::1], float64, boolean, float64[:, ::1])")
def dynamics(nominal: Float, signals: Float, decay: float, published: bool, f: Float) -> None:
    """Write the matrix of the error dynamics (method page 3.4; published: B.6-B.12).

    Offsets of accelerometers decay. Those of gyroscopes walk: they are far from zero (half a degree a second) and
    known from the standstill, and what is known of them is not forgotten. Published, all of them decay.
    """
    for i in range(f.shape[0]):
        for j in range(f.shape[1]):
            f[i, j] = 0.0
    r = np.empty((3, 3))
    attitude_matrix(nominal[_Q : _Q + 4], r)
    ws = (signals[_WS], signals[_WS + 1], signals[_WS + 2])
    fs = (signals[_FS], signals[_FS + 1], signals[_FS + 2])
    wc = (signals[_WC], signals[_WC + 1], signals[_WC + 2])
    for i in range(3):
        f[_EP + i, _EU + i] = 1.0
        f[_ET + i, _EG + i] = 1.0
        for j in range(3):
            f[_EU + i, _EA + j] = r[i, j]
        # -R [f]x: columns are -R (e_j-th column of [f]x)
        f[_EU + i, _ET] = -(r[i, 1] * fs[2] - r[i, 2] * fs[1])
        f[_EU + i, _ET + 1] = -(r[i, 2] * fs[0] - r[i, 0] * fs[2])
        f[_EU + i, _ET + 2] = -(r[i, 0] * fs[1] - r[i, 1] * fs[0])
    if published:
        turned = (
            ws[0] - (r[0, 0] * wc[0] + r[1, 0] * wc[1] + r[2, 0] * wc[2]),
            ws[1] - (r[0, 1] * wc[0] + r[1, 1] * wc[1] + r[2, 1] * wc[2]),
            ws[2] - (r[0, 2] * wc[0] + r[1, 2] * wc[1] + r[2, 2] * wc[2]),
        )
        add_skew(f, _ET, _ET, -1.0, turned[0], turned[1], turned[2])
        last = _EG
    else:
        add_skew(f, _EP, _EP, -1.0, wc[0], wc[1], wc[2])
        add_skew(f, _EP, _EGC, 1.0, nominal[_P], nominal[_P + 1], nominal[_P + 2])
        add_skew(f, _EU, _EU, -1.0, wc[0], wc[1], wc[2])
        add_skew(f, _EU, _EGC, 1.0, nominal[_U], nominal[_U + 1], nominal[_U + 2])
        add_skew(f, _ET, _ET, -1.0, ws[0], ws[1], ws[2])
        for i in range(3):
            f[_EU + i, _EAC + i] = -1.0
            for j in range(3):
                f[_ET + i, _EGC + j] = -r[j, i]
        last = _EGC
    for i in range(_EA, last + 3):
        if published or i < _EG or _EAC <= i < _EGC:
            f[i, i] = -decay


@step("void(float64[::1], float64[::1], float64[::1], float64, float64, float64[:, ::1], float64[:, :, ::1])")
def predict(
    nominal: Float,
    signals: Float,
    settings: Float,
    force_noise: float,
    rate_noise: float,
    p: Float,
    work: Float,
) -> None:
    """Carry the covariance over a step: Phi P Phi^T + Q with Phi = I + F T + F^2 T^2 / 2 (3.4, 3.5).

    `nominal` is that before the step; `work` is shape (3, 21, 21), of which the second is left as Phi.
    """
    t = settings[_TIME_STEP]
    published = settings[_PUBLISHED] > 0.0
    f, phi, left = work[0], work[1], work[2]
    n = p.shape[0]
    dynamics(nominal, signals, settings[_BIAS_DECAY], published, f)
    matrix_multiply(f, f, phi)
    for i in range(n):
        for j in range(n):
            phi[i, j] = f[i, j] * t + 0.5 * t * t * phi[i, j]
        phi[i, i] += 1.0
    matrix_multiply(phi, p, left)
    for i in range(n):
        for j in range(n):
            f[i, j] = phi[j, i]
    # left times the transposed Phi, over the few columns of Phi that are not zero
    for i in range(n):
        for j in range(n):
            p[i, j] = 0.0
    for k in range(n):
        for j in range(n):
            value = f[k, j]
            if value != 0.0:
                for i in range(n):
                    p[i, j] += left[i, k] * value
    force, rate = force_noise * force_noise, rate_noise * rate_noise
    for i in range(3):
        p[_EP + i, _EP + i] += force * t**4 / 4.0
        p[_EU + i, _EU + i] += 2.0 * force * t * t
        p[_ET + i, _ET + i] += rate * t * t * (2.0 if published else 1.0)
        force_walk = 2.0 * settings[_FORCE_BIAS_SIGMA] ** 2 * settings[_BIAS_DECAY] * t
        rate_walk = 2.0 * settings[_RATE_BIAS_SIGMA] ** 2 * settings[_BIAS_DECAY] * t
        p[_EA + i, _EA + i] += force_walk
        p[_EG + i, _EG + i] += rate_walk
        if not published:
            p[_EAC + i, _EAC + i] += force_walk
            p[_EGC + i, _EGC + i] += rate_walk
    if not published:
        # Noise of the source gyroscope turns position, velocity and attitude together.
        lever, r = np.zeros((_EA, 3)), np.empty((3, 3))
        attitude_matrix(nominal[_Q : _Q + 4], r)
        add_skew(lever, _EP, 0, 1.0, nominal[_P], nominal[_P + 1], nominal[_P + 2])
        add_skew(lever, _EU, 0, 1.0, nominal[_U], nominal[_U + 1], nominal[_U + 2])
        for i in range(3):
            for j in range(3):
                lever[_ET + i, j] = -r[j, i]
        for i in range(_EA):
            for j in range(_EA):
                total = lever[i, 0] * lever[j, 0] + lever[i, 1] * lever[j, 1] + lever[i, 2] * lever[j, 2]
                p[i, j] += total * rate * t * t
    symmetrise(p)


@kernel("void(float64[::1], float64[::1])")
def inject(nominal: Float, error: Float) -> None:
    """Take an error (estimate minus truth) out of the nominal state; bias errors have the other sign (X5)."""
    for i in range(3):
        nominal[_P + i] -= error[_EP + i]
        nominal[_U + i] -= error[_EU + i]
        nominal[_BA + i] += error[_EA + i]
        nominal[_BG + i] += error[_EG + i]
        nominal[_BAC + i] += error[_EAC + i]
        nominal[_BGC + i] += error[_EGC + i]
    turn = exponential(-error[_ET], -error[_ET + 1], -error[_ET + 2])
    q = multiply(
        nominal[_Q], nominal[_Q + 1], nominal[_Q + 2], nominal[_Q + 3], turn[0], turn[1], turn[2], turn[3]
    )
    q = normalized(q[0], q[1], q[2], q[3])
    nominal[_Q], nominal[_Q + 1], nominal[_Q + 2], nominal[_Q + 3] = q
