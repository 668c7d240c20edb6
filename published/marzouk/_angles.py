"""Roll, pitch and yaw of the thesis' Euler-angle filter: sines, conversions and intervals, compiled.

A sample needs the sines of three angles, and of their halves for the quaternion; all come from three series, and
those of the predicted angles from what the sample added.
"""

import math

from estimators._kernels import Scalars3, Scalars4, wrapped
from estimators.kernels import step
from estimators.recording import Float

Circle = tuple[float, float, float, float, float, float]
"""Sine and cosine of roll, of pitch and of yaw."""

_QUATERNION, _VECTOR, _PAIR = "UniTuple(float64, 4)", "UniTuple(float64, 3)", "UniTuple(float64, 2)"
_CIRCLE = "UniTuple(float64, 6)"


@step(f"{_PAIR}(float64)", inlined=True)
def half_circle(angle: float) -> tuple[float, float]:
    """Return sine and cosine of half an angle within half a turn, by series of a quarter of it, exact to 1e-16."""
    x = 0.25 * angle
    s = x * x
    s2 = s * s
    sine = x * (
        (1.0 - s * (1 / 6))
        + s2
        * (
            (1 / 120 - s * (1 / 5040))
            + s2 * ((1 / 362880 - s * (1 / 39916800)) + s2 * (1 / 6227020800 - s * (1 / 1307674368000)))
        )
    )
    # 1 - cos x of the same x, from which no digits are lost.
    rest = s * (
        (1 / 2 - s * (1 / 24))
        + s2
        * (
            (1 / 720 - s * (1 / 40320))
            + s2 * ((1 / 3628800 - s * (1 / 479001600)) + s2 * (1 / 87178291200 - s * (1 / 20922789888000)))
        )
    )
    return 2.0 * sine * (1.0 - rest), 1.0 - 2.0 * sine * sine


@step(f"{_CIRCLE}(float64, float64, float64)", inlined=True)
def halves(roll: float, pitch: float, yaw: float) -> Circle:
    """Return sine and cosine of half of each angle, all within half a turn."""
    sr, cr = half_circle(roll)
    sp, cp = half_circle(pitch)
    sy, cy = half_circle(yaw)
    return sr, cr, sp, cp, sy, cy


@step(f"{_CIRCLE}({_CIRCLE})", inlined=True)
def doubled(half: Circle) -> Circle:
    """Return sine and cosine of the angles from `halves` of them."""
    return (
        2.0 * half[0] * half[1],
        1.0 - 2.0 * half[0] * half[0],
        2.0 * half[2] * half[3],
        1.0 - 2.0 * half[2] * half[2],
        2.0 * half[4] * half[5],
        1.0 - 2.0 * half[4] * half[4],
    )


@step(f"{_QUATERNION}({_CIRCLE})", inlined=True)
def attitude(half: Circle) -> Scalars4:
    """Return q_U_sensor of Rz(yaw) Ry(pitch) Rx(roll) from `halves` (A7.1)."""
    sr, cr, sp, cp, sy, cy = half
    cc, ss, cs, sc = cp * cy, sp * sy, cp * sy, sp * cy
    return cr * cc + sr * ss, sr * cc - cr * ss, cr * sc + sr * cs, cr * cs - sr * sc


@step(f"{_QUATERNION}(float64, float64, float64)")
def quaternion(roll: float, pitch: float, yaw: float) -> Scalars4:
    """Return q_U_sensor of Rz(yaw) Ry(pitch) Rx(roll) (A7.1)."""
    return attitude(halves(roll, pitch, yaw))


@step("UniTuple(float64, 3)(float64, float64, float64, float64)")
def euler(w: float, x: float, y: float, z: float) -> Scalars3:
    """Return roll, pitch and yaw of a unit quaternion (A7.2, A7.3)."""
    c13 = 2.0 * (x * z - w * y)
    return (
        math.atan2(2.0 * (y * z + w * x), w * w - x * x - y * y + z * z),
        -math.asin(min(max(c13, -1.0), 1.0)),
        math.atan2(2.0 * (x * y + w * z), w * w + x * x - y * y - z * z),
    )


@step(f"{_PAIR}(float64, float64, float64)", inlined=True)
def moved(sine: float, cosine: float, by: float) -> tuple[float, float]:
    """Return sine and cosine of an angle that moved on, by series exact to 1e-16 for the turn of a sample."""
    s = by * by
    if s > 0.01:
        a, b = math.sin(by), math.cos(by)
    else:
        a = by * (1.0 - s * (1 / 6 - s * (1 / 120 - s * (1 / 5040 - s * (1 / 362880)))))
        b = 1.0 - s * (1 / 2 - s * (1 / 24 - s * (1 / 720 - s * (1 / 40320 - s * (1 / 3628800)))))
    return sine * b + cosine * a, cosine * b - sine * a


@step()
def wrap(e: Float) -> None:
    """Bring the angles to their intervals; beyond the pole roll and yaw are half a turn further."""
    e[1] = wrapped(e[1])
    if abs(e[1]) > 0.5 * math.pi:
        e[1] = math.copysign(math.pi, e[1]) - e[1]
        e[0] += math.pi
        e[2] += math.pi
    e[0], e[2] = wrapped(e[0]), wrapped(e[2])


@step(f"{_VECTOR}({_CIRCLE}, float64[:, ::1])", inlined=True)
def variances(half: Circle, p: Float) -> Scalars3:
    """Return the variance of the rotation error about north, east and down, given `halves` of the angles.

    A small change of the angles turns by d_roll Rz Ry e_x + d_pitch Rz e_y + d_yaw e_z.
    """
    _, _, sp, cp, sy, cy = doubled(half)
    n0, n1, d0 = cy * cp, sy * cp, -sp
    north = n0 * n0 * p[0, 0] - 2.0 * n0 * sy * p[0, 1] + sy * sy * p[1, 1]
    east = n1 * n1 * p[0, 0] + 2.0 * n1 * cy * p[0, 1] + cy * cy * p[1, 1]
    down = d0 * d0 * p[0, 0] + 2.0 * d0 * p[0, 2] + p[2, 2]
    return north, east, down
