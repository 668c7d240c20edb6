"""The Euler-angle EKF of the arm-monitoring thesis (A8, corrected), compiled over sensors and ticks."""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import Scalars3, kernel, wrapped
from estimators.kernels import Record, direction, mirror, record, step
from estimators.orientation._contract import OrientationFlag
from estimators.orientation._strapdown_steps import (
    BEGIN,
    FILTER,
    HOLD,
    UNKNOWN,
    Estimates,
    Ticks,
    run_signature,
)
from estimators.recording import Float
from published._error_state import BASE, absorb, attitude_seen
from published.marzouk import _steps as steps
from published.marzouk._angles import (
    Circle,
    attitude,
    doubled,
    euler,
    halves,
    moved,
    quaternion,
    variances,
    wrap,
)
from published.marzouk._steps import (
    SAMPLE,
    begin,
    horizontal_field,
    motion_weight,
    prepare,
    set_heading,
    store,
)

SETTINGS = record(steps.SETTINGS, steps.ANGLE_SETTINGS, [("angle_drift", "f8", 3)])
# Roll, pitch and yaw stand first: numba takes a record that only adds to the end of another for a kind of that one.
STATE = record([("angles", "f8", 3)], steps.STATE)

_SINGULAR = int(OrientationFlag.SINGULAR | OrientationFlag.HEADING_NOT_TRUSTED)
_STEEPEST = math.radians(85.0)


@step(inlined=True)
def dot(a: Float, b: Float) -> float:
    """Return the sum of products, first to last."""
    total = a[0] * b[0]
    for i in range(1, len(a)):
        total += a[i] * b[i]
    return float(total)


@step(inlined=True)
def predict_cross(p: Float, f: Float, w: Float, g: Float, k: Float, drift: Scalars3) -> None:
    """Carry offset and cross terms: with C the old cross terms N = G + W B, where G = F C; write G and K = F A.

    The block A of the first n states stays, so that its P' = K F' + N W' + W G' can be formed of what is then in `p`.
    """
    n = len(f)
    mirror(p[:n, :n])
    mirror(p[n:, n:])
    for i in range(n):
        for j in range(n):
            k[i, j] = dot(f[i], p[j, :n])
        for j in range(3):
            g[i, j] = dot(f[i], p[:n, n + j])
    for i in range(n):
        for j in range(3):
            p[i, n + j] = g[i, j] + dot(w[i], p[n + j, n:])
    for j in range(3):
        p[n + j, n + j] += drift[j]


@step(inlined=True)
def twice_cross(p: Float, w: Float, g: Float, i: int) -> float:
    """Return the diagonal of N W' + W G', which saves a product each."""
    n = len(g)
    a, b, c = p[i, n] + g[i, 0], p[i, n + 1] + g[i, 1], p[i, n + 2] + g[i, 2]
    return float(w[i, 0] * a + w[i, 1] * b + w[i, 2] * c)


@step(inlined=True)
def predict_steep(
    x: Record, p: Float, circle: Circle, rate: tuple[float, float, float], gap: float, c: Record
) -> Circle:
    """Carry the pitch alone beyond 85 degrees of it: roll and yaw are held and unknown."""
    sr, cr, sp, cp, sy, cy = circle
    _, uy, uz = rate
    by = c.step_s * (uy * cr - uz * sr)
    x.angles[1] += by
    sp, cp = moved(sp, cp, by)
    # Which axis pitches is unknown with the roll.
    p[1, 1] = p[1, 1] + c.step_s * (c.angle_drift[1] + c.step_s * (uy * uy + uz * uz)) + gap
    p[0, 1] = p[1, 2] = 0.0
    for j in range(BASE):
        p[0, j] = 0.0
        if j > 1:
            p[2, j] = 0.0
    p[0, 0] = p[2, 2] = UNKNOWN
    for axis in range(3):
        p[3 + axis, 3 + axis] += c.step_s * c.bias_drift[axis]
    return sr, cr, sp, cp, sy, cy


@step(inlined=True)
def predict(x: Record, p: Float, half: Circle, sample: Record, c: Record, work: Float) -> Circle:
    """Carry the angles by the rate and the covariance by I + Ts A (A8.1 to A8.4); return sines and cosines.

    The page's P + Ts (A P + P A' + Qc) is positive by the term Ts^2 A P A' of the second order.
    """
    f, w, g, k = work[0], work[1], work[2], work[3]
    step_s, e, gap = c.step_s, x.angles, sample.gap_variance
    ux, uy, uz = sample.rate[0] - x.bias[0], sample.rate[1] - x.bias[1], sample.rate[2] - x.bias[2]
    circle = doubled(half)
    if abs(e[1]) > _STEEPEST:
        return predict_steep(x, p, circle, (ux, uy, uz), gap, c)
    sr, cr, sp, cp, sy, cy = circle
    secant = 1.0 / cp
    tangent = sp * secant
    along, across = uy * cr - uz * sr, uy * sr + uz * cr
    # How the angles turn with the rate, and so with the offset.
    w01, w02 = step_s * sr * tangent, step_s * cr * tangent
    w11, w12 = step_s * cr, -step_s * sr
    w21, w22 = step_s * sr * secant, step_s * cr * secant
    w[0, 0], w[0, 1], w[0, 2] = -step_s, -w01, -w02
    w[1, 1], w[1, 2], w[2, 1], w[2, 2] = -w11, -w12, -w21, -w22
    f[0, 0], f[0, 1] = 1.0 + step_s * tangent * along, step_s * across * secant * secant
    f[1, 0], f[1, 1] = -step_s * across, 1.0
    f[2, 0], f[2, 1], f[2, 2] = step_s * along * secant, step_s * across * tangent * secant, 1.0
    roll, pitch, yaw = step_s * ux + w01 * uy + w02 * uz, step_s * along, w21 * uy + w22 * uz
    e[0] += roll
    e[1] += pitch
    e[2] += yaw
    drift = step_s * c.bias_drift[0], step_s * c.bias_drift[1], step_s * c.bias_drift[2]
    predict_cross(p, f, w, g, k, drift)
    for i in range(3):
        for j in range(i + 1, 3):
            p[i, j] = dot(f[j], k[i]) + dot(p[i, 3:], w[j]) + dot(w[i], g[j])
        noise = step_s * c.angle_drift[i] + (gap * secant * secant if i == 2 else gap)
        p[i, i] = dot(f[i], k[i]) + twice_cross(p, w, g, i) + noise
    sr, cr = moved(sr, cr, roll)
    sp, cp = moved(sp, cp, pitch)
    sy, cy = moved(sy, cy, yaw)
    return sr, cr, sp, cp, sy, cy


@step(inlined=True)
def correct(x: Record, p: Float, circle: Circle, sample: Record, c: Record, errors: Float, h: Float) -> None:
    """Correct by measured roll, pitch and tilt-compensated magnetic yaw (A4, A5, A8.5).

    The difference of a measured and a predicted angle is that of their complex numbers.
    """
    sr, cr, sp, cp, s_yaw, c_yaw = circle
    sx, sy, sz = sample.gravity[0], sample.gravity[1], sample.gravity[2]
    weight = motion_weight(sample, c)
    is_held = abs(x.angles[1]) > _STEEPEST
    across = math.sqrt(sy * sy + sz * sz)
    errors[:] = 0.0
    if not is_held:
        innovation = direction(sy * cr - sz * sr, sz * cr + sy * sr)
        attitude_seen(p, (1.0, 0.0, 0.0), h)
        inverse = 1.0 / (h[0] + weight * c.angle_variance[0])
        absorb(p, errors, h, innovation, inverse, inverse)
    innovation = direction(-sx * cp - across * sp, across * cp - sx * sp)
    attitude_seen(p, (0.0, 1.0, 0.0), h)
    inverse = 1.0 / (h[1] + weight * c.angle_variance[1])
    absorb(p, errors, h, innovation - errors[1], inverse, inverse)
    if sample.has_field and not is_held:
        east, north = horizontal_field(sample)
        innovation = direction(east * c_yaw - north * s_yaw, north * c_yaw + east * s_yaw)
        attitude_seen(p, (0.0, 0.0, 1.0), h)
        inverse = 1.0 / (h[2] + weight * c.angle_variance[2])
        absorb(p, errors, h, innovation - errors[2], inverse, inverse)
    for axis in range(3):
        x.angles[axis] += errors[axis]
        x.bias[axis] += errors[3 + axis]


@step()
def take_angles(x: Record) -> Circle:
    """Set the angles from the attitude; return `halves` of them."""
    e = x.angles
    e[0], e[1], e[2] = euler(x.q[0], x.q[1], x.q[2], x.q[3])
    return halves(e[0], e[1], e[2])


@kernel(run_signature(SETTINGS, STATE))
def run(
    ticks: Ticks, settings: NDArray[np.void], state: NDArray[np.void], covariance: Float, out: Estimates
) -> None:
    """Filter K ticks of S sensors; `state` and `covariance` (S, 6, 6, angles and bias) are carried on."""
    samples, errors, h, work = np.zeros(1, SAMPLE), np.zeros(BASE), np.zeros(BASE), np.zeros((4, 3, 3))
    sample, c, quality = samples[0], settings[0], ticks.quality
    for s in range(quality.shape[0]):
        x, p = state[s], covariance[s]
        e = x.angles
        half = halves(e[0], e[1], e[2])
        for k in range(quality.shape[1]):
            action = prepare(ticks, s, k, x, c, sample)
            if action == BEGIN:
                half = take_angles(x)
                begin(x, p, c, 3, 1.0)
            elif action != HOLD:
                circle = predict(x, p, half, sample, c, work)
                if action == FILTER:
                    if sample.has_field and x.is_heading_known == 0:
                        x.q[0], x.q[1], x.q[2], x.q[3] = quaternion(wrapped(e[0]), e[1], wrapped(e[2]))
                        set_heading(x, sample)
                        circle = doubled(take_angles(x))
                    correct(x, p, circle, sample, c, errors, h)
                if abs(e[0]) >= math.pi or abs(e[1]) > 0.5 * math.pi or abs(e[2]) >= math.pi:
                    wrap(e)
                half = halves(e[0], e[1], e[2])
                x.q[0], x.q[1], x.q[2], x.q[3] = attitude(half)
            own = _SINGULAR if abs(e[1]) > _STEEPEST else 0
            store(out, s, k, x, variances(half, p), quality[s, k], action, own, sample, c)
        mirror(p)
