"""Updates of the relative-pose filter by a pulse of one coil and by the common gravity; compiled."""

import math

import numpy as np

from estimators._kernels import exponential, kernel, multiply, rotate, rotate_back
from estimators.magnetic import _relative_layout as at
from estimators.magnetic._loop_kernel import coil_field
from estimators.magnetic._relative_motion import attitude_matrix, cross, inject
from estimators.magnetic._small_algebra import cholesky, joseph, solve
from estimators.recording import Float

_P, _U, _Q = at.POSITION, at.VELOCITY, at.ATTITUDE
_BA, _BG, _BAC, _BGC = at.FORCE_BIAS, at.RATE_BIAS, at.SOURCE_FORCE_BIAS, at.SOURCE_RATE_BIAS
_EP, _EU, _ET, _EA, _EAC = at.E_POSITION, at.E_VELOCITY, at.E_ATTITUDE, at.E_FORCE, at.E_SOURCE_FORCE
_GYR, _FIELD, _COIL, _CURRENT, _RING = at.GYROSCOPE, at.FIELD, at.COIL, at.CURRENT, at.RING
_FIELD_SIGMA, _RATE_SIGMA, _TIME_STEP, _EARTH = at.FIELD_SIGMA, at.RATE_SIGMA, at.TIME_STEP, at.EARTH_FIELD
_GAIN_SIGMA, _PASSES, _FULL_SCALE, _NIS_SOFT, _NIS_STREAK = (
    at.GAIN_SIGMA,
    at.PASSES,
    at.FULL_SCALE,
    at.NIS_SOFT,
    at.NIS_STREAK,
)
_INCLINATION_SIGMA = at.INCLINATION_SIGMA
_DONE = 1e-7


@kernel("int64(float64[:, ::1], int64, int64, int64, float64[::1], float64[::1], float64[::1])")
def pulse_value(
    ring: Float, last: int, length: int, most_off: int, nominal: Float, settings: Float, out: Float
) -> int:
    """Read a pulse whose last sample is tick `last` from the ring, in the sensor axes of its middle sample.

    `out` takes value (3), white variance, current and the ticks from the middle to `last`. Returns 0 when sound,
    1 without a usable sample, 2 when saturated.
    """
    t = settings[_TIME_STEP]
    first = last - length + 1
    middle = first + (length - 1) // 2
    # Attitude of every sample in the axes of the middle one, walking outwards by the gyroscope.
    inner_first, inner_last = (first, last) if length <= 3 else (first + 1, last - 1)
    sums = np.zeros((2, 3))
    counts = np.zeros(2)
    current = 0.0
    saturated = False
    for direction in (-1, 1):
        q = (1.0, 0.0, 0.0, 0.0)
        k = middle if direction < 0 else middle + 1
        while True:
            if direction < 0 and (counts[1] >= most_off or k < max(0, first - 60) or last - k >= _RING):
                break
            if direction > 0 and k > last:
                break
            row = ring[k % _RING]
            if k != middle:
                before, after = ring[(k + 1) % _RING] if direction < 0 else ring[(k - 1) % _RING], row
                h = 0.5 * t * direction
                w = exponential(
                    h * (before[_GYR] + after[_GYR] - 2.0 * nominal[_BG]),
                    h * (before[_GYR + 1] + after[_GYR + 1] - 2.0 * nominal[_BG + 1]),
                    h * (before[_GYR + 2] + after[_GYR + 2] - 2.0 * nominal[_BG + 2]),
                )
                q = multiply(q[0], q[1], q[2], q[3], w[0], w[1], w[2], w[3])
                if not math.isfinite(q[0]):
                    break
            group = -1
            if inner_first <= k <= inner_last:
                group = 0
            elif k < first:
                # Beside another pulse of the same burst the edge may be smeared over a sample.
                busy = row[_COIL] != 0.0 or (k + 1 != first and ring[(k + 1) % _RING][_COIL] != 0.0)
                group = -1 if busy or (k > 0 and ring[(k - 1) % _RING][_COIL] != 0.0) else 1
            x, y, z = row[_FIELD], row[_FIELD + 1], row[_FIELD + 2]
            if group >= 0 and math.isfinite(x + y + z):
                limit = settings[_FULL_SCALE]
                saturated = saturated or abs(x) >= limit or abs(y) >= limit or abs(z) >= limit
                b = rotate(q[0], q[1], q[2], q[3], x, y, z)
                for i in range(3):
                    sums[group, i] += b[i]
                counts[group] += 1.0
                if group == 0:
                    current += row[_CURRENT]
            k += direction
    if counts[0] < 1.0 or counts[1] < 2.0:
        return 1
    for i in range(3):
        out[i] = sums[0, i] / counts[0] - sums[1, i] / counts[1]
    out[3] = (
        settings[_FIELD_SIGMA] ** 2 * (1.0 / counts[0] + 1.0 / counts[1])
        + 0.7 * counts[1] * (settings[_RATE_SIGMA] * t * settings[_EARTH]) ** 2
    )
    out[4] = current / counts[0]
    out[5] = float(last - middle)
    return 2 if saturated else 0


@kernel(
    "void(float64[:, ::1], float64, float64, float64, float64[::1], float64[::1], float64[::1], float64[:, ::1])"
)
def predict_pulse(
    loops: Float,
    coil: float,
    current: float,
    delay: float,
    nominal: Float,
    rates: Float,
    value: Float,
    h: Float,
) -> None:
    """Write the field that a coil makes at the sensor `delay` seconds ago, in its axes then, and H (method page 3.7).

    `rates` are the corrected rates of sensor and source, `h` has shape (3, 21) and must be zero elsewhere.
    """
    p = (nominal[_P], nominal[_P + 1], nominal[_P + 2])
    wc = (rates[3], rates[4], rates[5])
    cp = cross(wc[0], wc[1], wc[2], p[0], p[1], p[2])
    px = p[0] - delay * (nominal[_U] - cp[0])
    py = p[1] - delay * (nominal[_U + 1] - cp[1])
    pz = p[2] - delay * (nominal[_U + 2] - cp[2])
    ahead = exponential(delay * wc[0], delay * wc[1], delay * wc[2])
    turn = exponential(-delay * rates[0], -delay * rates[1], -delay * rates[2])
    q = multiply(
        ahead[0], ahead[1], ahead[2], ahead[3], nominal[_Q], nominal[_Q + 1], nominal[_Q + 2], nominal[_Q + 3]
    )
    q = multiply(q[0], q[1], q[2], q[3], turn[0], turn[1], turn[2], turn[3])
    f = coil_field(loops, coil, current, px, py, pz)
    y = rotate_back(q[0], q[1], q[2], q[3], f[0], f[1], f[2])
    value[0], value[1], value[2] = y
    g = (
        rotate_back(q[0], q[1], q[2], q[3], f[3], f[4], f[5]),
        rotate_back(q[0], q[1], q[2], q[3], f[4], f[6], f[7]),
        rotate_back(q[0], q[1], q[2], q[3], f[5], f[7], f[8]),
    )
    # d(p then)/dp = I + delay [w_c]x
    x = (
        (1.0, delay * wc[2], -delay * wc[1]),
        (-delay * wc[2], 1.0, delay * wc[0]),
        (delay * wc[1], -delay * wc[0], 1.0),
    )
    for j in range(3):
        column = x[j]
        # Columns of [y]x Exp(w_s delay): each unit vector is first turned by the sensor's own motion.
        e = rotate_back(
            turn[0],
            turn[1],
            turn[2],
            turn[3],
            1.0 if j == 0 else 0.0,
            1.0 if j == 1 else 0.0,
            1.0 if j == 2 else 0.0,
        )
        levered = cross(y[0], y[1], y[2], e[0], e[1], e[2])
        for i in range(3):
            h[i, _EP + j] = g[0][i] * column[0] + g[1][i] * column[1] + g[2][i] * column[2]
            h[i, _EU + j] = -delay * g[j][i]
            h[i, _ET + j] = levered[i]


@kernel("float64(float64[:, ::1], float64[:, ::1], float64[:, ::1], float64[::1], float64[:, ::1])")
def innovate(p: Float, h: Float, r: Float, innovation: Float, gain: Float) -> float:
    """Write K = P H^T S^-1 and return the normalised innovation squared; minus one if S is not positive."""
    n, m = p.shape[0], h.shape[0]
    s = np.empty((m, m))
    for i in range(n):
        for a in range(m):
            total = 0.0
            for k in range(n):
                if h[a, k] != 0.0:
                    total += p[i, k] * h[a, k]
            gain[i, a] = total
    for a in range(m):
        for b in range(m):
            total = r[a, b]
            for k in range(n):
                if h[a, k] != 0.0:
                    total += h[a, k] * gain[k, b]
            s[a, b] = total
    for a in range(m):
        for b in range(a):
            s[a, b] = s[b, a] = 0.5 * (s[a, b] + s[b, a])
    if not cholesky(s):
        return -1.0
    whitened = innovation.copy()
    solve(s, whitened)
    nis = 0.0
    for a in range(m):
        nis += innovation[a] * whitened[a]
    for i in range(n):
        solve(s, gain[i])
    return nis


@kernel(
    "float64(float64[:, ::1], float64, float64[::1], float64[::1], float64[::1], float64, float64[::1],"
    "float64[:, ::1], float64[:, ::1])"
)
def update_pulse(
    loops: Float,
    coil: float,
    pulse: Float,
    rates: Float,
    settings: Float,
    inflation: float,
    nominal: Float,
    p: Float,
    work: Float,
) -> float:
    """Correct state and covariance by a pulse (iterated, softly weighted); return its normalised innovation squared."""
    n = p.shape[0]
    h, gain, r = np.zeros((3, n)), np.empty((n, 3)), np.zeros((3, 3))
    value, innovation, right = np.empty(3), np.empty(3), np.empty(3)
    correction, trial = np.zeros(n), nominal.copy()
    delay, current = pulse[5] * settings[_TIME_STEP], pulse[4]
    first = -1.0
    for number in range(int(settings[_PASSES])):
        predict_pulse(loops, coil, current, delay, trial, rates, value, h)
        if number == 0:
            size = value[0] * value[0] + value[1] * value[1] + value[2] * value[2]
            for i in range(3):
                r[i, i] = (pulse[3] + settings[_GAIN_SIGMA] ** 2 * size) * inflation
        for i in range(3):
            innovation[i] = value[i] - pulse[i]
        nis = innovate(p, h, r, innovation, gain)
        if nis < 0.0 or not math.isfinite(nis):
            return -1.0
        if number == 0:
            first = nis
            if nis > settings[_NIS_STREAK]:
                # Nothing that the filter believes possible: three of these in a row ask for a new burst instead.
                return first
            if nis > settings[_NIS_SOFT]:
                # R += (NIS / limit - 1) S: an outlier weighs less the farther out it is, but is never shut out.
                share = nis / settings[_NIS_SOFT] - 1.0
                for a in range(3):
                    for b in range(3):
                        total = r[a, b]
                        for k in range(n):
                            if h[a, k] != 0.0:
                                for m in range(9):
                                    total += h[a, k] * p[k, m] * h[b, m]
                        work[a, b] = total
                for a in range(3):
                    for b in range(3):
                        r[a, b] += share * 0.5 * (work[a, b] + work[b, a])
                innovate(p, h, r, innovation, gain)
        largest = 0.0
        for i in range(3):
            right[i] = innovation[i]
            for k in range(9):
                right[i] += h[i, k] * correction[k]
        for i in range(n):
            total = gain[i, 0] * right[0] + gain[i, 1] * right[1] + gain[i, 2] * right[2]
            largest = max(largest, abs(total - correction[i]))
            correction[i] = total
        for i in range(trial.shape[0]):
            trial[i] = nominal[i]
        inject(trial, correction)
        if largest < _DONE:
            break
    for i in range(nominal.shape[0]):
        nominal[i] = trial[i]
    joseph(p, h, r, gain, work)
    return first


@kernel("void(float64[::1], float64[::1], float64[::1], float64, float64[:, ::1], float64[:, ::1])")
def update_inclination(
    nominal: Float, signals: Float, settings: Float, factor: float, p: Float, work: Float
) -> None:
    """Correct by the gravity that both modules see while quasi-static: R^T f_c = f_s (method page 3.9b).

    `factor` scales the variance: accelerations last for longer than the interval between updates, which matters
    once no pulse corrects what that overstates.
    """
    n = p.shape[0]
    h, gain, noise = np.zeros((3, n)), np.empty((n, 3)), np.zeros((3, 3))
    innovation, correction, r = np.empty(3), np.empty(n), np.empty((3, 3))
    attitude_matrix(nominal, r)
    seen = rotate_back(
        nominal[_Q], nominal[_Q + 1], nominal[_Q + 2], nominal[_Q + 3], signals[9], signals[10], signals[11]
    )
    for i in range(3):
        innovation[i] = seen[i] - signals[3 + i]
        noise[i, i] = factor * settings[_INCLINATION_SIGMA] ** 2
        h[i, _EA + i] = -1.0
        for j in range(3):
            h[i, _EAC + j] = r[j, i]
    h[0, _ET + 1], h[0, _ET + 2] = -seen[2], seen[1]
    h[1, _ET], h[1, _ET + 2] = seen[2], -seen[0]
    h[2, _ET], h[2, _ET + 1] = -seen[1], seen[0]
    if innovate(p, h, noise, innovation, gain) < 0.0:
        return
    for i in range(n):
        correction[i] = gain[i, 0] * innovation[0] + gain[i, 1] * innovation[1] + gain[i, 2] * innovation[2]
    inject(nominal, correction)
    joseph(p, h, noise, gain, work)


__all__ = ["innovate", "predict_pulse", "pulse_value", "update_inclination", "update_pulse"]
