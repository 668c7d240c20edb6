"""Attitudes of error-state filters, unit quaternions (wxyz) as arrays: matrix, difference, a turn put in; compiled."""

import math

from estimators._kernels import Scalars3, exponential, multiply, normalized, rotate, step
from estimators.recording import Float


@step("UniTuple(float64, 3)(float64, float64, float64, float64)")
def logarithm(w: float, x: float, y: float, z: float) -> Scalars3:
    """Return the rotation vector of a unit quaternion, rad, the shorter way round."""
    sign = 1.0 if w >= 0.0 else -1.0
    sine = math.sqrt(x * x + y * y + z * z)
    scale = 2.0 if sine < 1e-9 else 2.0 * math.atan2(sine, sign * w) / sine
    return sign * scale * x, sign * scale * y, sign * scale * z


@step("void(float64[::1], float64[::1], float64[::1])")
def turn_between(q: Float, other: Float, out: Float) -> None:
    """Write Log(q other^-1): the turn, in the world, that takes `other` to `q`."""
    a = multiply(q[0], q[1], q[2], q[3], other[0], -other[1], -other[2], -other[3])
    out[0], out[1], out[2] = logarithm(a[0], a[1], a[2], a[3])


@step("void(float64[::1], float64[::1])")
def turn_in_world(q: Float, turn: Float) -> None:
    """Replace q by Exp(turn) q."""
    t = exponential(turn[0], turn[1], turn[2])
    a = multiply(t[0], t[1], t[2], t[3], q[0], q[1], q[2], q[3])
    q[0], q[1], q[2], q[3] = normalized(a[0], a[1], a[2], a[3])


@step("void(float64[::1], float64[:, ::1])")
def attitude_matrix(q: Float, out: Float) -> None:
    """Write the matrix that turns a vector as q does, shape (3, 3)."""
    for j in range(3):
        column = rotate(
            q[0], q[1], q[2], q[3], 1.0 if j == 0 else 0.0, 1.0 if j == 1 else 0.0, 1.0 if j == 2 else 0.0
        )
        out[0, j], out[1, j], out[2, j] = column
