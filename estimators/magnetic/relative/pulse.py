"""A pulse as the relative-pose filter reads it and predicts it; compiled."""

import math

import numpy as np

from estimators._kernels import exponential, multiply, rotate, rotate_back, step
from estimators.magnetic._loop_kernel import coil_field
from estimators.magnetic.relative import layout as at
from estimators.magnetic.relative.motion import cross
from estimators.recording import Float

_P, _U, _Q, _BG = at.POSITION, at.VELOCITY, at.ATTITUDE, at.RATE_BIAS
_EP, _EU, _ET = at.E_POSITION, at.E_VELOCITY, at.E_ATTITUDE
_GYR, _FIELD, _COIL, _CURRENT, _RING = at.GYROSCOPE, at.FIELD, at.COIL, at.CURRENT, at.RING
_FIELD_SIGMA, _RATE_SIGMA, _TIME_STEP, _EARTH, _FULL_SCALE = (
    at.FIELD_SIGMA,
    at.RATE_SIGMA,
    at.TIME_STEP,
    at.EARTH_FIELD,
    at.FULL_SCALE,
)
_KEPT_P, _KEPT_Q = at.KEPT_POSITION, at.KEPT_ATTITUDE
_ON_TICKS, _OFF_TICKS = at.ON_TICKS, at.OFF_TICKS
_WS, _WC, _TURN = at.R_SENSOR, at.R_SOURCE, at.PATH_TURN
_VALUE, _WHITE, _AMPERES, _LATE, _ROWS, _AMBIENT, _TURNING, _LEVER = (
    at.PULSE_VALUE,
    at.PULSE_WHITE,
    at.PULSE_CURRENT,
    at.PULSE_LATE,
    at.PULSE_PATH,
    at.PULSE_AMBIENT,
    at.PULSE_TURNING,
    at.PULSE_LEVER,
)


@step("float64(float64[::1])")
def fading(settings: Float) -> float:
    """Return how much less a quiet sample weighs than the next one: white noise of the field against turning.

    The gain of the steady Kalman filter of a random walk (variance per step q) under white noise (r) is
    k = (sqrt(q^2 + 4 q r) - q) / (2 r); what is one step older weighs 1 - k.
    """
    ratio = (settings[_RATE_SIGMA] * settings[_TIME_STEP] * settings[_EARTH] / settings[_FIELD_SIGMA]) ** 2
    return float(1.0 - 0.5 * (math.sqrt(ratio * ratio + 4.0 * ratio) - ratio))


@step("UniTuple(float64, 3)(float64[:, :, ::1])")
def spread(shares: Float) -> tuple[float, float, float]:
    """Return by how much white noise, noise of the gyroscope's steps, and its offset come through into a pulse.

    The first two as variances, the last in ticks. `shares` are the weights of samples: before (0) or after (1) the
    middle, on (0) or quiet (1), ticks from it. Every step turns all samples beyond it: its error comes with the sum
    of their weights, quiet ones counted negative.
    """
    total_on, total_off = shares[:, 0].sum(), shares[:, 1].sum()
    white = (shares[0, 0, 0] / total_on) ** 2
    turning = lever = 0.0
    for side in range(2):
        sign, beyond = 2.0 * side - 1.0, 0.0
        for k in range(shares.shape[2] - 1, 0, -1):
            on, off = shares[side, 0, k] / total_on, shares[side, 1, k] / total_off
            white += on * on + off * off
            beyond += on - off
            turning += beyond * beyond
            lever += sign * beyond
    return white, turning, lever


@step("float64(float64[::1])")
def expected_variance(settings: Float) -> float:
    """Return the variance of a pulse as set, right after its quiet samples, the mean of the three axes."""
    shares = np.zeros((2, 2, _RING))
    length = int(settings[_ON_TICKS])
    before = (length - 1) // 2
    cut = 0 if length <= 3 else 1
    shares[0, 0, : before + 1 - cut] = 1.0
    shares[1, 0, 1 : length - before - cut] = 1.0
    weight, fade = 1.0, fading(settings)
    for k in range(int(settings[_OFF_TICKS])):
        shares[0, 1, before + 1 + k] = weight
        weight *= fade
    white, turning, _ = spread(shares)
    turn = settings[_RATE_SIGMA] * settings[_TIME_STEP] * settings[_EARTH]
    return float(settings[_FIELD_SIGMA] ** 2 * white + 2.0 / 3.0 * turn * turn * turning)


@step(
    "int64(float64[:, ::1], int64, int64, int64, float64[::1], float64[::1], float64[::1], float64[:, ::1])"
)
def pulse_value(
    ring: Float,
    last: int,
    length: int,
    most_off: int,
    nominal: Float,
    settings: Float,
    out: Float,
    path: Float,
) -> int:
    """Read a pulse whose last sample is tick `last` from the ring, in the sensor axes of its middle sample.

    `out` takes value (3), white variance, current, the ticks from the middle to `last`, how many rows of `path` are
    filled, the ambient field (3), the variance of the turn between it and the pulse by the gyroscope's noise, and the
    time for which an error of the gyroscope's offset turns it. The path is, for samples that are on, the place that
    the filter gave the sensor, and the turn (quaternion) from the source's axes then to the sensor's in the middle.
    Quiet samples weigh less the older they are (own: generalised least squares, where page 3.8 takes their plain
    mean). Returns 0 when sound, 1 without a usable sample
    (none, or all of them the same to the last bit: the magnetometer is stuck), 2 when saturated.
    """
    out[_ROWS] = 0.0
    t = settings[_TIME_STEP]
    first = last - length + 1
    middle = first + (length - 1) // 2
    # Attitude of every sample in the axes of the middle one, walking outwards by the gyroscope.
    inner_first, inner_last = (first, last) if length <= 3 else (first + 1, last - 1)
    sums = np.zeros((2, 3))
    counts, shares = np.zeros(2), np.zeros((2, 2, _RING))
    weight, fade = 1.0, fading(settings)
    current, held = 0.0, np.zeros(3)
    saturated, stuck = False, True
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
                if counts[0] + counts[1] == 0.0:
                    held[0], held[1], held[2] = x, y, z
                stuck = stuck and x == held[0] and y == held[1] and z == held[2]
                b = rotate(q[0], q[1], q[2], q[3], x, y, z)
                own = 1.0 if group == 0 else weight
                for i in range(3):
                    sums[group, i] += own * b[i]
                counts[group] += 1.0
                shares[0 if direction < 0 else 1, group, abs(k - middle)] = own
                if group == 0:
                    current += row[_CURRENT]
                    if out[_ROWS] < path.shape[0]:
                        place = path[int(out[_ROWS])]
                        out[_ROWS] += 1.0
                        retained = row[_KEPT_Q : _KEPT_Q + 4]
                        m = multiply(
                            q[0], q[1], q[2], q[3], retained[0], -retained[1], -retained[2], -retained[3]
                        )
                        for i in range(3):
                            place[i] = row[_KEPT_P + i]
                        place[_TURN], place[_TURN + 1], place[_TURN + 2], place[_TURN + 3] = m
            if counts[1] > 0.0:
                weight *= fade
            k += direction
    if counts[0] < 1.0 or counts[1] < 2.0:
        return 1
    quiet = shares[:, 1].sum()
    for i in range(3):
        out[_AMBIENT + i] = sums[1, i] / quiet
        out[_VALUE + i] = sums[0, i] / counts[0] - out[_AMBIENT + i]
    white, turning, lever = spread(shares)
    out[_WHITE] = settings[_FIELD_SIGMA] ** 2 * white
    out[_TURNING] = (settings[_RATE_SIGMA] * t) ** 2 * turning
    out[_LEVER] = t * lever
    out[_AMPERES] = current / counts[0]
    out[_LATE] = float(last - middle)
    if saturated:
        return 2
    return 1 if stuck else 0


@step(
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
    wc = (rates[_WC], rates[_WC + 1], rates[_WC + 2])
    cp = cross(wc[0], wc[1], wc[2], p[0], p[1], p[2])
    px = p[0] - delay * (nominal[_U] - cp[0])
    py = p[1] - delay * (nominal[_U + 1] - cp[1])
    pz = p[2] - delay * (nominal[_U + 2] - cp[2])
    ahead = exponential(delay * wc[0], delay * wc[1], delay * wc[2])
    turn = exponential(-delay * rates[_WS], -delay * rates[_WS + 1], -delay * rates[_WS + 2])
    q = multiply(
        ahead[0], ahead[1], ahead[2], ahead[3], nominal[_Q], nominal[_Q + 1], nominal[_Q + 2], nominal[_Q + 3]
    )
    q = multiply(q[0], q[1], q[2], q[3], turn[0], turn[1], turn[2], turn[3])
    bx, by, bz, gxx, gxy, gxz, gyy, gyz, gzz = coil_field(loops, coil, current, px, py, pz)
    y = rotate_back(q[0], q[1], q[2], q[3], bx, by, bz)
    value[0], value[1], value[2] = y
    g = (
        rotate_back(q[0], q[1], q[2], q[3], gxx, gxy, gxz),
        rotate_back(q[0], q[1], q[2], q[3], gxy, gyy, gyz),
        rotate_back(q[0], q[1], q[2], q[3], gxz, gyz, gzz),
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


@step(
    "void(float64[:, ::1], float64, float64[::1], float64[:, ::1], float64, float64[::1], float64[::1], float64[::1],"
    "float64[::1], float64[:, ::1])"
)
def predict_path(
    loops: Float,
    coil: float,
    pulse: Float,
    path: Float,
    delay: float,
    nominal: Float,
    trial: Float,
    rates: Float,
    value: Float,
    h: Float,
) -> None:
    """Write the mean field of a pulse along the way that the sensor went, and H, at a trial state beside the nominal.

    A foot moves by centimetres within a pulse; the field at its middle is then no longer the mean (own, beside page
    3.7, whose single instant is `predict_pulse`). `path` is that of the nominal state; what the trial state differs
    in is carried back by `delay`.
    """
    wc = (rates[_WC], rates[_WC + 1], rates[_WC + 2])
    # d(p then)/dp = I + delay [w_c]x, d(p then)/du = -delay
    x = (
        (1.0, -delay * wc[2], delay * wc[1]),
        (delay * wc[2], 1.0, -delay * wc[0]),
        (-delay * wc[1], delay * wc[0], 1.0),
    )
    turn = exponential(-delay * rates[_WS], -delay * rates[_WS + 1], -delay * rates[_WS + 2])
    a = multiply(
        nominal[_Q],
        -nominal[_Q + 1],
        -nominal[_Q + 2],
        -nominal[_Q + 3],
        trial[_Q],
        trial[_Q + 1],
        trial[_Q + 2],
        trial[_Q + 3],
    )
    b = rotate_back(turn[0], turn[1], turn[2], turn[3], a[1], a[2], a[3])
    off = np.empty(3)
    for i in range(3):
        off[i] = -delay * (trial[_U + i] - nominal[_U + i])
        for j in range(3):
            off[i] += x[i][j] * (trial[_P + j] - nominal[_P + j])
    count = int(pulse[_ROWS])
    mean, gradient = np.zeros(3), np.zeros((3, 3))
    for k in range(count):
        m, turned = path[k], path[k, _TURN:]
        bx, by, bz, gxx, gxy, gxz, gyy, gyz, gzz = coil_field(
            loops, coil, pulse[_AMPERES], m[0] + off[0], m[1] + off[1], m[2] + off[2]
        )
        columns = (
            rotate(turned[0], turned[1], turned[2], turned[3], bx, by, bz),
            rotate(turned[0], turned[1], turned[2], turned[3], gxx, gxy, gxz),
            rotate(turned[0], turned[1], turned[2], turned[3], gxy, gyy, gyz),
            rotate(turned[0], turned[1], turned[2], turned[3], gxz, gyz, gzz),
        )
        for i in range(3):
            mean[i] += columns[0][i] / count
            for j in range(3):
                gradient[i, j] += columns[1 + j][i] / count
    y = rotate_back(a[0], b[0], b[1], b[2], mean[0], mean[1], mean[2])
    value[0], value[1], value[2] = y
    for j in range(3):
        g = rotate_back(a[0], b[0], b[1], b[2], gradient[0, j], gradient[1, j], gradient[2, j])
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
            h[i, _EU + j] = -delay * g[i]
            h[i, _ET + j] = levered[i]
            gradient[i, j] = g[i]
    for i in range(3):
        for j in range(3):
            h[i, _EP + j] = gradient[i, 0] * x[0][j] + gradient[i, 1] * x[1][j] + gradient[i, 2] * x[2][j]
