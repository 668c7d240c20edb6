"""The error-state Kalman filter of orientation and gyroscope bias, compiled; a model adds states of its own.

The state begins with the orientation error xi in the earth frame, estimate = Exp(xi) truth, and the bias error in the
sensor frame; from `BASE` on it is the model's. In the earth frame a turn of the sensor leaves xi alone. Of the
covariance `p` (n, n) only the upper triangle holds inside a loop over ticks; `mirror` completes it.

A model predicts with `turn_by_rate` and `predict`, then its own states. For each scalar measurement of variance R it
lets `attitude_seen` write h = P H' for the attitude's part of H, adds that of its own states, and `absorb`s the
residual with 1 / (H h + R); noises are independent, so that one row after the other is the joint update. `inject`
takes the errors that were gathered out of the estimate.
"""

from typing import Final

from estimators._kernels import Scalars3, multiply, step
from estimators.kernels._angles import turn
from estimators.kernels._records import Record
from estimators.recording import Float

_BIAS: Final = 3
BASE: Final = 6
"""States of orientation and bias."""
Matrix = tuple[float, float, float, float, float, float, float, float, float]
"""A 3 x 3 matrix by rows."""


@step(inlined=True)
def turn_by_rate(x: Record, rx: float, ry: float, rz: float, step_s: float) -> Matrix:
    """Turn the estimate `x.q` by a rate less `x.bias`, rad/s, over a step and return T R by rows."""
    tw, tx, ty, tz = turn((rx - x.bias[0]) * step_s, (ry - x.bias[1]) * step_s, (rz - x.bias[2]) * step_s)
    qw, qx, qy, qz = multiply(x.q[0], x.q[1], x.q[2], x.q[3], tw, tx, ty, tz)
    # One Newton step keeps the norm: it is off by rounding only.
    norm = 1.5 - 0.5 * (qw * qw + qx * qx + qy * qy + qz * qz)
    qw, qx, qy, qz = qw * norm, qx * norm, qy * norm, qz * norm
    x.q[0], x.q[1], x.q[2], x.q[3] = qw, qx, qy, qz
    a, b, c = 2.0 * step_s * qx, 2.0 * step_s * qy, 2.0 * step_s * qz
    xx, yy, zz, xy, xz, yz = a * qx, b * qy, c * qz, a * qy, a * qz, b * qz
    wx, wy, wz = a * qw, b * qw, c * qw
    return (
        step_s - yy - zz,
        xy - wz,
        xz + wy,
        xy + wz,
        step_s - xx - zz,
        yz - wx,
        xz - wy,
        yz + wx,
        step_s - xx - yy,
    )


@step("void(float64[:, ::1], UniTuple(float64, 9), float64, float64)", inlined=True)
def predict(p: Float, turned: Matrix, noise: float, drift: float) -> None:
    """P' = F P F' + Q with F = [[I, -T R], [0, I]] over orientation and bias.

    `noise` and `drift` are what the variances of each axis of the two grow by. Written as
    P_xx' = P_xx - (T R) C' - N (T R)', with C the old and N the new cross covariance.
    """
    r00, r01, r02, r10, r11, r12, r20, r21, r22 = turned
    x, y, z = _BIAS, _BIAS + 1, _BIAS + 2
    b00, b01, b02, b11, b12, b22 = p[x, x], p[x, y], p[x, z], p[y, y], p[y, z], p[z, z]
    c00, c01, c02 = p[0, x], p[0, y], p[0, z]
    c10, c11, c12 = p[1, x], p[1, y], p[1, z]
    c20, c21, c22 = p[2, x], p[2, y], p[2, z]
    n00 = c00 - (r00 * b00 + r01 * b01 + r02 * b02)
    n01 = c01 - (r00 * b01 + r01 * b11 + r02 * b12)
    n02 = c02 - (r00 * b02 + r01 * b12 + r02 * b22)
    n10 = c10 - (r10 * b00 + r11 * b01 + r12 * b02)
    n11 = c11 - (r10 * b01 + r11 * b11 + r12 * b12)
    n12 = c12 - (r10 * b02 + r11 * b12 + r12 * b22)
    n20 = c20 - (r20 * b00 + r21 * b01 + r22 * b02)
    n21 = c21 - (r20 * b01 + r21 * b11 + r22 * b12)
    n22 = c22 - (r20 * b02 + r21 * b12 + r22 * b22)
    # The sums C + N of the diagonal save three products each.
    p[0, 0] += noise - (r00 * (c00 + n00) + r01 * (c01 + n01) + r02 * (c02 + n02))
    p[1, 1] += noise - (r10 * (c10 + n10) + r11 * (c11 + n11) + r12 * (c12 + n12))
    p[2, 2] += noise - (r20 * (c20 + n20) + r21 * (c21 + n21) + r22 * (c22 + n22))
    p[0, 1] -= (r00 * c10 + r01 * c11 + r02 * c12) + (r10 * n00 + r11 * n01 + r12 * n02)
    p[0, 2] -= (r00 * c20 + r01 * c21 + r02 * c22) + (r20 * n00 + r21 * n01 + r22 * n02)
    p[1, 2] -= (r10 * c20 + r11 * c21 + r12 * c22) + (r20 * n10 + r21 * n11 + r22 * n12)
    p[0, x], p[0, y], p[0, z] = n00, n01, n02
    p[1, x], p[1, y], p[1, z] = n10, n11, n12
    p[2, x], p[2, y], p[2, z] = n20, n21, n22
    p[x, x], p[y, y], p[z, z] = b00 + drift, b11 + drift, b22 + drift


@step("void(float64[:, ::1], UniTuple(float64, 3), float64[::1])", inlined=True)
def attitude_seen(p: Float, row: Scalars3, h: Float) -> None:
    """Write h = P H' of a measurement with this row on the orientation error alone."""
    a, b, c = row
    h[0] = a * p[0, 0] + b * p[0, 1] + c * p[0, 2]
    h[1] = a * p[0, 1] + b * p[1, 1] + c * p[1, 2]
    h[2] = a * p[0, 2] + b * p[1, 2] + c * p[2, 2]
    for k in range(3, len(h)):
        h[k] = a * p[0, k] + b * p[1, k] + c * p[2, k]


@step("void(float64[:, ::1], float64[::1], float64[::1], float64, float64, float64)", inlined=True)
def absorb(p: Float, errors: Float, h: Float, residual: float, inverse: float, own: float) -> None:
    """Take a scalar measurement with h = P H', its residual and 1 / S: P - h h' / S; the errors gather h residual / S.

    `own` stands for 1 / S where the model's own states are concerned: zero leaves them and what they have to do with
    the others alone.
    """
    gain, own_gain, size = inverse * residual, own * residual, len(h)
    for i in range(BASE):
        g = inverse * h[i]
        errors[i] += gain * h[i]
        for j in range(i, BASE):
            p[i, j] -= g * h[j]
    for j in range(BASE, size):
        g = own * h[j]
        errors[j] += own_gain * h[j]
        for i in range(BASE):
            p[i, j] -= h[i] * g
        for i in range(j, size):
            p[j, i] -= g * h[i]


@step(inlined=True)
def inject(x: Record, errors: Float) -> None:
    """Take the errors of orientation and bias out of the estimate: R = Exp(-xi) R, b = b - b_e."""
    tw, tx, ty, tz = turn(-errors[0], -errors[1], -errors[2])
    x.q[0], x.q[1], x.q[2], x.q[3] = multiply(tw, tx, ty, tz, x.q[0], x.q[1], x.q[2], x.q[3])
    for axis in range(3):
        x.bias[axis] -= errors[_BIAS + axis]
