"""The quaternion EKF of the arm-monitoring thesis (A9, corrected), compiled over sensors and ticks."""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import Scalars4, kernel, multiply
from estimators.kernels import Record, far_direction, mirror, record, step, turn
from estimators.orientation._contract import OrientationFlag
from estimators.orientation._strapdown_steps import BEGIN, FILTER, HOLD, Estimates, Ticks, run_signature
from estimators.orientation.marzouk import _steps as steps
from estimators.orientation.marzouk._covariance import dot, downdate, predict_cross, twice_cross
from estimators.orientation.marzouk._steps import (
    SAMPLE,
    begin,
    direction,
    horizontal_field,
    motion_weight,
    prepare,
    set_heading,
    store,
)
from estimators.recording import Float

SETTINGS = record(
    steps.SETTINGS, steps.ANGLE_SETTINGS, [("rate_variance", "f8", 3), ("is_weighted_when_steep", "i8")]
)
STATE = record(steps.STATE)
STATES = 7
"""Quaternion, then offset."""

_SINGULAR = int(OrientationFlag.SINGULAR)
_GUARD = 1e-6
_SINGULAR_SINE = math.sin(math.radians(85.0))
_STEEP = 0.25
"""Squared cosine of the pitch (60 degrees) from which roll and yaw measurements lose weight."""

_ROW = "UniTuple(float64, 7)"
Row = tuple[float, float, float, float, float, float, float]
"""Sine and cosine of an angle, times any positive number; a length D; D times the angle's derivative by w, x, y, z."""


@step(inlined=True)
def transition(x: Record, rx: float, ry: float, rz: float, step_s: float, f: Float, w: Float) -> None:
    """Write Phi of A9.2: for a turn (rx, ry, rz) the blocks of the quaternion and of the offset."""
    # a + (r x) structure; Omega^2 = -|u|^2 I.
    a = 1.0 - (rx * rx + ry * ry + rz * rz) / 8.0
    hx, hy, hz = 0.5 * rx, 0.5 * ry, 0.5 * rz
    f[0, 0], f[0, 1], f[0, 2], f[0, 3] = a, -hx, -hy, -hz
    f[1, 0], f[1, 1], f[1, 2], f[1, 3] = hx, a, hz, -hy
    f[2, 0], f[2, 1], f[2, 2], f[2, 3] = hy, -hz, a, hx
    f[3, 0], f[3, 1], f[3, 2], f[3, 3] = hz, hy, -hx, a
    # -Ts/2 (I + Ts/4 Omega) Xi: columns q (0, e) (1, r/4) of e = e_x, e_y, e_z.
    half = -0.5 * step_s
    hw, hx2, hy2, hz2 = half * x.q[0], half * x.q[1], half * x.q[2], half * x.q[3]
    kx, ky, kz = 0.5 * hx, 0.5 * hy, 0.5 * hz
    w[0, 0] = -hx2 - kx * hw + kz * hy2 - ky * hz2
    w[0, 1] = -hy2 - ky * hw + kx * hz2 - kz * hx2
    w[0, 2] = -hz2 - kz * hw + ky * hx2 - kx * hy2
    w[1, 0] = hw - kx * hx2 + kz * hz2 + ky * hy2
    w[1, 1] = -hz2 - ky * hx2 - kx * hy2 + kz * hw
    w[1, 2] = hy2 - kz * hx2 - kx * hz2 - ky * hw
    w[2, 0] = hz2 - kx * hy2 - ky * hx2 - kz * hw
    w[2, 1] = hw - ky * hy2 + kz * hz2 + kx * hx2
    w[2, 2] = -hx2 - kz * hy2 - ky * hz2 + kx * hw
    w[3, 0] = -hy2 - kx * hz2 - kz * hx2 + ky * hw
    w[3, 1] = hx2 - ky * hz2 - kz * hy2 - kx * hw
    w[3, 2] = hw - kz * hz2 + ky * hy2 + kx * hx2


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
def predict(x: Record, p: Float, sample: Record, c: Record, work: Float, offset: Float) -> None:
    """Turn by the rate and carry the covariance, Phi P Phi' + Ts Qc (A9.1 to A9.3)."""
    f, k, w, g = work[0], work[1], offset[0], offset[1]
    step_s = c.step_s
    rx = (sample.rate[0] - x.bias[0]) * step_s
    ry = (sample.rate[1] - x.bias[1]) * step_s
    rz = (sample.rate[2] - x.bias[2]) * step_s
    transition(x, rx, ry, rz, step_s, f, w)
    drift = step_s * c.bias_drift[0], step_s * c.bias_drift[1], step_s * c.bias_drift[2]
    predict_cross(p, f, w, g, k, drift)
    for i in range(4):
        p[i, i] = dot(f[i], k[i]) + twice_cross(p, w, g, i)
        for j in range(i + 1, 4):
            p[i, j] = dot(f[j], k[i]) + (dot(p[i, 4:], w[j]) + dot(w[i], g[j]))
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


@kernel("float64(float64, float64, float64, float64)", inlined=True)
def steepness(w: float, x: float, y: float, z: float) -> float:
    """Return the factor of the variance of roll and yaw: as noisy as one over the cosine of a steep pitch."""
    c13 = 2.0 * (x * z - w * y)
    cosine_squared = 1.0 - c13 * c13
    return 1.0 if cosine_squared >= _STEEP else _STEEP / max(cosine_squared, _GUARD)


@kernel(f"{_ROW}(float64, float64, float64, float64)", inlined=True)
def roll_row(w: float, x: float, y: float, z: float) -> Row:
    """Return the row of the roll (A7.3 and A9.4, guarded at the singularity; see `absorb`)."""
    c23, c33 = 2.0 * (y * z + w * x), (w * w - x * x) - (y * y - z * z)
    length = 0.5 * max(c23 * c23 + c33 * c33, _GUARD)
    return c23, c33, length, x * c33 - w * c23, w * c33 + x * c23, z * c33 + y * c23, y * c33 - z * c23


@kernel(f"{_ROW}(float64, float64, float64, float64)", inlined=True)
def pitch_row(w: float, x: float, y: float, z: float) -> Row:
    """Return the row of the pitch (A7.3 and A9.4, guarded at the singularity; see `absorb`)."""
    c13 = min(max(2.0 * (x * z - w * y), -1.0), 1.0)
    cosine = math.sqrt(1.0 - c13 * c13)
    return -c13, cosine, 0.5 * max(cosine, _GUARD), y + c13 * w, c13 * x - z, w + c13 * y, c13 * z - x


@kernel(f"{_ROW}(float64, float64, float64, float64)", inlined=True)
def yaw_row(w: float, x: float, y: float, z: float) -> Row:
    """Return the row of the yaw (A7.3 and A9.4, guarded at the singularity; see `absorb`)."""
    c12, c11 = 2.0 * (x * y + w * z), (w * w + x * x) - (y * y + z * z)
    length = 0.5 * max(c11 * c11 + c12 * c12, _GUARD)
    return c12, c11, length, z * c11 - w * c12, y * c11 - x * c12, x * c11 + y * c12, w * c11 + z * c12


@kernel("UniTuple(float64, 4)(float64, float64, float64, float64)", inlined=True)
def renormalized(w: float, x: float, y: float, z: float) -> Scalars4:
    """Return a quaternion at unit norm; one that nearly is by a series exact to 1e-16."""
    off = (w * w + x * x) + (y * y + z * z) - 1.0
    scale = 1.0 - off * (1 / 2 - off * (3 / 8 - off * (5 / 16)))
    if abs(off) > 1e-5:
        scale = 1.0 / math.sqrt(off + 1.0)
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
    found = direction(across, along) if abs(across) < 0.125 * along else far_direction(across, along)
    size = inverse * (length * found)
    x.q[0], x.q[1], x.q[2], x.q[3] = renormalized(
        x.q[0] + h[0] * size, x.q[1] + h[1] * size, x.q[2] + h[2] * size, x.q[3] + h[3] * size
    )
    for axis in range(3):
        x.bias[axis] += h[4 + axis] * size
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
    samples, h, work, offset = np.zeros(1, SAMPLE), np.zeros(STATES), np.zeros((2, 4, 4)), np.zeros((2, 4, 3))
    sample, c, quality = samples[0], settings[0], ticks.quality
    p = np.zeros((STATES, STATES))
    for s in range(quality.shape[0]):
        x = state[s]
        p[:] = covariance[s]
        for k in range(quality.shape[1]):
            action = prepare(ticks, s, k, x, c, sample)
            if action == BEGIN:
                # A turn by d moves the quaternion by d/2.
                begin(x, p, c, 4, 0.25)
            elif action != HOLD:
                predict(x, p, sample, c, work, offset)
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
        covariance[s] = p


__all__ = ["SETTINGS", "STATE", "STATES", "pitch_row", "roll_row", "run", "yaw_row"]
