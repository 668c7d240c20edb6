"""The quaternion EKF of the arm-monitoring thesis (A9, corrected), compiled over sensors and ticks."""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import Scalars4, kernel, multiply
from estimators.kernels import Record, direction, mirror, record, step, turn
from estimators.orientation._contract import OrientationFlag
from estimators.orientation._strapdown_steps import BEGIN, FILTER, HOLD, Estimates, Ticks, run_signature
from estimators.recording import Float
from published.marzouk import _steps as steps
from published.marzouk._steps import (
    SAMPLE,
    begin,
    horizontal_field,
    motion_weight,
    prepare,
    set_heading,
    store,
)

SETTINGS = record(
    steps.SETTINGS, steps.ANGLE_SETTINGS, [("rate_variance", "f8", 3), ("is_weighted_when_steep", "i8")]
)
STATE = record(steps.STATE)
_X, _Y, _Z = 4, 5, 6
STATES = 7
"""Quaternion, then the offset about x, y and z."""

_SINGULAR = int(OrientationFlag.SINGULAR)
_GUARD = 1e-6
_SINGULAR_SINE = math.sin(math.radians(85.0))
_STEEP = 0.25
"""Squared cosine of the pitch (60 degrees) from which roll and yaw measurements lose weight."""

_ROW = "UniTuple(float64, 7)"
Row = tuple[float, float, float, float, float, float, float]
"""Sine and cosine of an angle, times any positive number; a length D; D times the angle's derivative by w, x, y, z."""


@step(inlined=True)
def moved_along(
    g: Scalars4, w0: Scalars4, w1: Scalars4, w2: Scalars4, a: float, b: float, c: float
) -> Scalars4:
    """Return g + a w0 + b w1 + c w2."""
    return (
        g[0] + (a * w0[0] + b * w1[0] + c * w2[0]),
        g[1] + (a * w0[1] + b * w1[1] + c * w2[1]),
        g[2] + (a * w0[2] + b * w1[2] + c * w2[2]),
        g[3] + (a * w0[3] + b * w1[3] + c * w2[3]),
    )


@step(inlined=True)
def add_noise(x: Record, p: Float, nx: float, ny: float, nz: float) -> None:
    """Add Xi diag(n) Xi' to the quaternion's block, with Xi = columns q (0, e)."""
    w, qx, y, z = x.q[0], x.q[1], x.q[2], x.q[3]
    ww, xx, yy, zz = w * w, qx * qx, y * y, z * z
    nxx, nyy, nzz = nx * qx, ny * y, nz * z
    nxw, nyw, nzw = nx * w, ny * w, nz * w
    p[0, 0] += nxx * qx + nyy * y + nzz * z
    p[0, 1] += -nxx * w + nyy * z - nzz * y
    p[0, 2] += -nxx * z - nyy * w + nzz * qx
    p[0, 3] += nxx * y - nyy * qx - nzz * w
    p[1, 1] += nx * ww + ny * zz + nz * yy
    p[1, 2] += nxw * z - nyw * z - nz * qx * y
    p[1, 3] += -nxw * y - ny * qx * z + nzw * y
    p[2, 2] += nx * zz + ny * ww + nz * xx
    p[2, 3] += -nx * y * z + nyw * qx - nzw * qx
    p[3, 3] += nx * yy + ny * xx + nz * ww


@step(inlined=True)
def predict(x: Record, p: Float, sample: Record, c: Record) -> None:
    """Turn by the rate and carry the covariance, Phi P Phi' + Ts Qc (A9.1 to A9.3).

    Phi's block of the quaternion, 1 + Ts/2 Omega + (Ts/2 Omega)^2 / 2, multiplies by a quaternion f from the right;
    that of the offset is W = -Ts/2 (1 + Ts/4 Omega) Xi, whose columns are q (0, e) (1, r/4) for the axes e. With A, C
    and B the blocks of P and G = f C, the new cross terms are N = G + W B, and A' = F A F' + N W' + W G', where the
    matrix F does what f does.
    """
    step_s = c.step_s
    rx = (sample.rate[0] - x.bias[0]) * step_s
    ry = (sample.rate[1] - x.bias[1]) * step_s
    rz = (sample.rate[2] - x.bias[2]) * step_s
    # Omega^2 = -|u|^2.
    f = 1.0 - (rx * rx + ry * ry + rz * rz) / 8.0, 0.5 * rx, 0.5 * ry, 0.5 * rz
    half = -0.5 * step_s
    hw, hx, hy, hz = half * x.q[0], half * x.q[1], half * x.q[2], half * x.q[3]
    kx, ky, kz = 0.25 * rx, 0.25 * ry, 0.25 * rz
    w0 = multiply(-hx, hw, hz, -hy, 1.0, kx, ky, kz)
    w1 = multiply(-hy, -hz, hw, hx, 1.0, kx, ky, kz)
    w2 = multiply(-hz, hy, -hx, hw, 1.0, kx, ky, kz)
    g0 = multiply(p[0, _X], p[1, _X], p[2, _X], p[3, _X], *f)
    g1 = multiply(p[0, _Y], p[1, _Y], p[2, _Y], p[3, _Y], *f)
    g2 = multiply(p[0, _Z], p[1, _Z], p[2, _Z], p[3, _Z], *f)
    n0 = moved_along(g0, w0, w1, w2, p[_X, _X], p[_X, _Y], p[_X, _Z])
    n1 = moved_along(g1, w0, w1, w2, p[_X, _Y], p[_Y, _Y], p[_Y, _Z])
    n2 = moved_along(g2, w0, w1, w2, p[_X, _Z], p[_Y, _Z], p[_Z, _Z])
    k0 = multiply(p[0, 0], p[0, 1], p[0, 2], p[0, 3], *f)
    k1 = multiply(p[0, 1], p[1, 1], p[1, 2], p[1, 3], *f)
    k2 = multiply(p[0, 2], p[1, 2], p[2, 2], p[2, 3], *f)
    k3 = multiply(p[0, 3], p[1, 3], p[2, 3], p[3, 3], *f)
    r0, r1 = multiply(k0[0], k1[0], k2[0], k3[0], *f), multiply(k0[1], k1[1], k2[1], k3[1], *f)
    r2, r3 = multiply(k0[2], k1[2], k2[2], k3[2], *f), multiply(k0[3], k1[3], k2[3], k3[3], *f)
    r0 = moved_along(moved_along(r0, w0, w1, w2, n0[0], n1[0], n2[0]), g0, g1, g2, w0[0], w1[0], w2[0])
    r1 = moved_along(moved_along(r1, w0, w1, w2, n0[1], n1[1], n2[1]), g0, g1, g2, w0[1], w1[1], w2[1])
    r2 = moved_along(moved_along(r2, w0, w1, w2, n0[2], n1[2], n2[2]), g0, g1, g2, w0[2], w1[2], w2[2])
    r3 = moved_along(moved_along(r3, w0, w1, w2, n0[3], n1[3], n2[3]), g0, g1, g2, w0[3], w1[3], w2[3])
    p[0, 0], p[0, 1], p[0, 2], p[0, 3] = r0
    _, p[1, 1], p[1, 2], p[1, 3] = r1
    p[2, 2], p[2, 3], p[3, 3] = r2[2], r2[3], r3[3]
    p[0, _X], p[1, _X], p[2, _X], p[3, _X] = n0
    p[0, _Y], p[1, _Y], p[2, _Y], p[3, _Y] = n1
    p[0, _Z], p[1, _Z], p[2, _Z], p[3, _Z] = n2
    for axis in range(3):
        p[_X + axis, _X + axis] += step_s * c.bias_drift[axis]
    gap, quarter = 0.25 * sample.gap_variance, 0.25 * step_s * step_s
    add_noise(
        x,
        p,
        quarter * c.rate_variance[0] + gap,
        quarter * c.rate_variance[1] + gap,
        quarter * c.rate_variance[2] + gap,
    )
    tw, tx, ty, tz = turn(rx, ry, rz)
    x.q[0], x.q[1], x.q[2], x.q[3] = multiply(x.q[0], x.q[1], x.q[2], x.q[3], tw, tx, ty, tz)


@step("float64(float64, float64, float64, float64)", inlined=True)
def steepness(w: float, x: float, y: float, z: float) -> float:
    """Return the factor of the variance of roll and yaw: as noisy as one over the cosine of a steep pitch."""
    c13 = 2.0 * (x * z - w * y)
    cosine_squared = 1.0 - c13 * c13
    return 1.0 if cosine_squared >= _STEEP else _STEEP / max(cosine_squared, _GUARD)


@step(f"{_ROW}(float64, float64, float64, float64)", inlined=True)
def roll_row(w: float, x: float, y: float, z: float) -> Row:
    """Return the row of the roll (A7.3 and A9.4, guarded at the singularity; see `absorb`)."""
    c23, c33 = 2.0 * (y * z + w * x), (w * w - x * x) - (y * y - z * z)
    length = 0.5 * max(c23 * c23 + c33 * c33, _GUARD)
    return c23, c33, length, x * c33 - w * c23, w * c33 + x * c23, z * c33 + y * c23, y * c33 - z * c23


@step(f"{_ROW}(float64, float64, float64, float64)", inlined=True)
def pitch_row(w: float, x: float, y: float, z: float) -> Row:
    """Return the row of the pitch (A7.3 and A9.4, guarded at the singularity; see `absorb`)."""
    c13 = min(max(2.0 * (x * z - w * y), -1.0), 1.0)
    cosine = math.sqrt(1.0 - c13 * c13)
    return -c13, cosine, 0.5 * max(cosine, _GUARD), y + c13 * w, c13 * x - z, w + c13 * y, c13 * z - x


@step(f"{_ROW}(float64, float64, float64, float64)", inlined=True)
def yaw_row(w: float, x: float, y: float, z: float) -> Row:
    """Return the row of the yaw (A7.3 and A9.4, guarded at the singularity; see `absorb`)."""
    c12, c11 = 2.0 * (x * y + w * z), (w * w + x * x) - (y * y + z * z)
    length = 0.5 * max(c11 * c11 + c12 * c12, _GUARD)
    return c12, c11, length, z * c11 - w * c12, y * c11 - x * c12, x * c11 + y * c12, w * c11 + z * c12


@step("UniTuple(float64, 4)(float64, float64, float64, float64)", inlined=True)
def renormalized(w: float, x: float, y: float, z: float) -> Scalars4:
    """Return a quaternion, which must not be zero, at unit norm."""
    scale = 1.0 / math.sqrt((w * w + x * x) + (y * y + z * z))
    return w * scale, x * scale, y * scale, z * scale


@step(inlined=True)
def quaternion_seen(p: Float, row: Scalars4, h: Float) -> None:
    """Write h = P H' of a measurement of the quaternion alone."""
    a, b, c, d = row
    h[0] = a * p[0, 0] + b * p[0, 1] + c * p[0, 2] + d * p[0, 3]
    h[1] = a * p[0, 1] + b * p[1, 1] + c * p[1, 2] + d * p[1, 3]
    h[2] = a * p[0, 2] + b * p[1, 2] + c * p[2, 2] + d * p[2, 3]
    for k in range(3, len(h)):
        h[k] = a * p[0, k] + b * p[1, k] + c * p[2, k] + d * p[3, k]


@step(inlined=True)
def downdate(p: Float, h: Float, inverse: float) -> None:
    """Take h h' times `inverse` from the covariance: a scalar measurement with h = P H' and S = 1 / inverse."""
    for i in range(len(h)):
        gain = inverse * h[i]
        for j in range(i, len(h)):
            p[i, j] -= gain * h[j]


@step(inlined=True)
def absorb(x: Record, p: Float, row: Row, sine: float, cosine: float, variance: float, h: Float) -> None:
    """Correct by an angle measured as sine and cosine (times any positive number).

    The rows of A9.4 are right along the unit sphere only. Their part along q says that the norm were measured, which
    it is not; left in, it makes a heading without magnetometer look known. Those here lack it.
    """
    now_sine, now_cosine, length, h0, h1, h2, h3 = row
    quaternion_seen(p, (h0, h1, h2, h3), h)
    # Row and gain over the length save its division: 1 / S = inverse length^2.
    inverse = 1.0 / ((h0 * h[0] + h1 * h[1]) + (h2 * h[2] + h3 * h[3]) + variance * length * length)
    # The difference of two angles is that of their complex numbers; it comes within half a turn.
    across, along = sine * now_cosine - cosine * now_sine, cosine * now_cosine + sine * now_sine
    found = direction(across, along)
    size = inverse * (length * found)
    x.q[0], x.q[1], x.q[2], x.q[3] = renormalized(
        x.q[0] + h[0] * size, x.q[1] + h[1] * size, x.q[2] + h[2] * size, x.q[3] + h[3] * size
    )
    for axis in range(3):
        x.bias[axis] += h[_X + axis] * size
    downdate(p, h, inverse)


@step(inlined=True)
def correct(x: Record, p: Float, sample: Record, c: Record, h: Float) -> None:
    """Correct by roll, pitch and tilt-compensated magnetic yaw, one after the other (A4, A5, A9.4)."""
    sx, sy, sz = sample.gravity[0], sample.gravity[1], sample.gravity[2]
    across = math.sqrt(sy * sy + sz * sz)
    weight = motion_weight(sample, c)
    q = x.q[0], x.q[1], x.q[2], x.q[3]
    variance = weight * c.angle_variance[0]
    if c.is_weighted_when_steep:
        variance *= steepness(*q)
    absorb(x, p, roll_row(*q), sy, sz, variance, h)
    absorb(x, p, pitch_row(x.q[0], x.q[1], x.q[2], x.q[3]), -sx, across, weight * c.angle_variance[1], h)
    if sample.has_field:
        q = x.q[0], x.q[1], x.q[2], x.q[3]
        variance = weight * c.angle_variance[2]
        if c.is_weighted_when_steep:
            variance *= steepness(*q)
        east, north = horizontal_field(sample)
        absorb(x, p, yaw_row(*q), east, north, variance, h)


@step(inlined=True)
def quadratic(p: Float, g0: float, g1: float, g2: float, g3: float) -> float:
    """Return 4 g' P g over the quaternion block: the variance about an axis of U."""
    first = g0 * (g0 * p[0, 0] + 2.0 * (g1 * p[0, 1] + g2 * p[0, 2] + g3 * p[0, 3]))
    second = g1 * (g1 * p[1, 1] + 2.0 * (g2 * p[1, 2] + g3 * p[1, 3]))
    third = g2 * (g2 * p[2, 2] + 2.0 * g3 * p[2, 3])
    return float(4.0 * (first + second + third + g3 * g3 * p[3, 3]))


@kernel(run_signature(SETTINGS, STATE))
def run(
    ticks: Ticks, settings: NDArray[np.void], state: NDArray[np.void], covariance: Float, out: Estimates
) -> None:
    """Filter K ticks of S sensors; `state` and `covariance` (S, 7, 7, quaternion and bias) are carried on."""
    samples, h = np.zeros(1, SAMPLE), np.zeros(STATES)
    sample, c, quality = samples[0], settings[0], ticks.quality
    for s in range(quality.shape[0]):
        x, p = state[s], covariance[s]
        for k in range(quality.shape[1]):
            action = prepare(ticks, s, k, x, c, sample)
            if action == BEGIN:
                # A turn by d moves the quaternion by d/2.
                begin(x, p, c, 4, 0.25)
            elif action != HOLD:
                predict(x, p, sample, c)
                if action == FILTER:
                    if sample.has_field and x.is_heading_known == 0:
                        set_heading(x, sample)
                    correct(x, p, sample, c, h)
            w, qx, y, z = x.q[0], x.q[1], x.q[2], x.q[3]
            # Rotation error in U: twice the vector part of dq * conj(q).
            variances = quadratic(p, -qx, w, -z, y), quadratic(p, -y, z, w, -qx), quadratic(p, -z, -y, qx, w)
            own = _SINGULAR if abs(2.0 * (qx * z - w * y)) > _SINGULAR_SINE else 0
            store(out, s, k, x, variances, quality[s, k], action, own, sample, c)
        mirror(p)
