"""The mathematics of joint angles that the compiled live path inlines: Euler angles, their turns, their sigmas.

Every formula stands a second time, in numpy, in `_joint_angles` and `_uncertainty`; the tests hold the two against
each other.
"""

import math
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import Scalars3
from estimators.kernels import borrowing

Float = NDArray[np.float64]

SINGULAR_MARGIN_RAD: Final = math.radians(10.0)
"""Within this of elevation 0 or 180 degrees plane of elevation and axial rotation are flagged SINGULAR.

An orientation error of e appears in both as e / sin(elevation): 5.8 times at 10 degrees.
"""

REFERENCE_STEP_S: Final = 0.01
"""Time step for which the weight of a new plane of elevation inside the singular zone is defined."""

PLANE_CENTRE_RAD: Final = math.radians(45.0)
"""Middle of the anatomical range of the plane of elevation; also its value before any is known."""

AXIAL_CENTRE_RAD: Final = math.radians(-30.0)
FLEXION_CENTRE_RAD: Final = math.radians(60.0)
PRONATION_CENTRE_RAD: Final = math.radians(75.0)
"""Middles of the ranges in which the first value of an angle is looked for before unwrapping takes over."""

REACH_RAD: Final = math.radians(210.0)
"""An angle unwraps to this far from its middle; beyond it is a full turn off, which no joint gets to.

Thirty degrees more than half a turn, so that an arm that wavers at the edge does not jump to and fro.
"""

SIGMA_CEILING_RAD: Final = math.pi / math.sqrt(3.0)
"""Standard deviation of an angle about which nothing is known (uniform over a turn)."""

_TWO_PI = 2.0 * math.pi


@borrowing()
def _multiply(p: Any, q: Float, out: Float) -> None:
    out[0] = p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3]
    out[1] = p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2]
    out[2] = p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1]
    out[3] = p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0]


@borrowing()
def matrix_of(q: Float, out: Float) -> None:
    """Write the rotation matrix of a unit quaternion."""
    w, x, y, z = q[0], q[1], q[2], q[3]
    out[0, 0] = 1.0 - 2.0 * (y * y + z * z)
    out[0, 1] = 2.0 * (x * y - w * z)
    out[0, 2] = 2.0 * (x * z + w * y)
    out[1, 0] = 2.0 * (x * y + w * z)
    out[1, 1] = 1.0 - 2.0 * (x * x + z * z)
    out[1, 2] = 2.0 * (y * z - w * x)
    out[2, 0] = 2.0 * (x * z - w * y)
    out[2, 1] = 2.0 * (y * z + w * x)
    out[2, 2] = 1.0 - 2.0 * (x * x + y * y)


@borrowing()
def _nearest(angle: float, wanted: float) -> float:
    return angle + _TWO_PI * math.floor((wanted - angle) / _TWO_PI + 0.5)


@borrowing()
def _near(angle: float, previous: float, centre: float) -> float:
    """Choose the turn of an angle closest to the previous one, but no farther off the centre than a joint gets."""
    if math.isfinite(previous):
        near = _nearest(angle, previous)
        if abs(near - centre) <= REACH_RAD:
            return near
    return _nearest(angle, centre)


@borrowing()
def relative_of(parent: Float, child: Float, is_left: bool, out: Float) -> None:
    """Relative rotation, mirrored in the sagittal plane for the left side."""
    inverse = (parent[0], -parent[1], -parent[2], -parent[3])
    _multiply(inverse, child, out)
    if is_left:
        out[1] = -out[1]
        out[3] = -out[3]


@borrowing()
def shoulder(r: Float, previous: Float, step_s: float, angle: Float) -> bool:
    """Y-X-Y angles into `angle[0:3]`; returns whether they are near the singularity."""
    elevation = 2.0 * math.atan2(math.hypot(r[1], r[2]), math.hypot(r[0], r[3]))
    total = 2.0 * math.atan2(r[3], r[0])
    difference = 2.0 * math.atan2(-r[2], -r[1])
    plane = 0.5 * (total + difference)
    angle[1] = elevation
    margin = min(elevation, math.pi - elevation)
    if margin >= SINGULAR_MARGIN_RAD:
        angle[0] = _near(plane, previous[0], PLANE_CENTRE_RAD)
        angle[2] = _near(0.5 * (total - difference), previous[2], AXIAL_CENTRE_RAD)
        return False
    held = previous[0] if math.isfinite(previous[0]) else PLANE_CENTRE_RAD
    ratio = margin / SINGULAR_MARGIN_RAD
    weight = 1.0 - (1.0 - ratio * ratio * (3.0 - 2.0 * ratio)) ** (step_s / REFERENCE_STEP_S)
    moved = held + weight * (_nearest(plane, held) - held)
    angle[0] = _near(moved, moved, PLANE_CENTRE_RAD)
    axial = total - angle[0] if elevation < 0.5 * math.pi else angle[0] - difference
    angle[2] = _near(axial, previous[2], AXIAL_CENTRE_RAD)
    return True


@borrowing()
def cardan(r: Float) -> Scalars3:
    """Return a, b and c of r = Ry(a) Rx(b) Rz(c)."""
    m12 = 2.0 * (r[2] * r[3] - r[0] * r[1])
    forward = math.atan2(2.0 * (r[1] * r[3] + r[0] * r[2]), 1.0 - 2.0 * (r[1] * r[1] + r[2] * r[2]))
    across = math.atan2(
        -m12, math.hypot(2.0 * (r[1] * r[2] + r[0] * r[3]), 1.0 - 2.0 * (r[1] * r[1] + r[3] * r[3]))
    )
    turn = math.atan2(2.0 * (r[1] * r[2] + r[0] * r[3]), 1.0 - 2.0 * (r[1] * r[1] + r[3] * r[3]))
    return forward, across, turn


@borrowing()
def hinge(r: Float, previous: Float, carrying_sign: float, angle: Float) -> bool:
    """Z-X-Y angles of elbow or wrist into `angle[0:3]`; returns whether they are near the singularity."""
    forward, across, turn = cardan(r)
    angle[0] = _near(-forward, previous[0], FLEXION_CENTRE_RAD)
    angle[1] = carrying_sign * across
    angle[2] = _near(turn, previous[2], PRONATION_CENTRE_RAD)
    return 0.5 * math.pi - abs(across) < SINGULAR_MARGIN_RAD


@borrowing()
def first_axes(
    parent: Float, angle: float, is_shoulder: bool, is_left: bool, scratch: Float, out: Float
) -> None:
    """Axes of the frame after the first rotation, in the room, as columns of `out`."""
    matrix_of(parent, scratch)
    if is_left:
        for i in range(3):
            scratch[i, 0] = -scratch[i, 0]
            scratch[i, 2] = -scratch[i, 2]
    cosine, sine = math.cos(angle), math.sin(angle)
    for i in range(3):
        if is_shoulder:  # about z
            out[i, 0] = cosine * scratch[i, 0] + sine * scratch[i, 1]
            out[i, 1] = cosine * scratch[i, 1] - sine * scratch[i, 0]
            out[i, 2] = scratch[i, 2]
        else:  # about -y
            out[i, 0] = cosine * scratch[i, 0] + sine * scratch[i, 2]
            out[i, 1] = scratch[i, 1]
            out[i, 2] = cosine * scratch[i, 2] - sine * scratch[i, 0]


@borrowing()
def sigmas(axes: Float, variance: Float, second: float, is_shoulder: bool, out: Float) -> None:
    """First-order one-sigma of three Euler angles; see `_uncertainty` for the derivation."""
    var0 = var1 = var2 = 0.0
    if is_shoulder:
        sine = max(math.sin(second), 1e-9)
        cotangent = math.cos(second) / sine
        for i in range(3):
            x, y, z = axes[i, 0], axes[i, 1], axes[i, 2]
            var0 += (z - cotangent * y) ** 2 * variance[i]
            var1 += x * x * variance[i]
            var2 += (y / sine) ** 2 * variance[i]
    else:
        cosine = max(math.cos(second), 1e-9)
        tangent = math.sin(second) / cosine
        for i in range(3):
            x, y, z = axes[i, 0], axes[i, 1], axes[i, 2]
            var0 += (y + tangent * z) ** 2 * variance[i]
            var1 += x * x * variance[i]
            var2 += (z / cosine) ** 2 * variance[i]
    out[0] = min(math.sqrt(var0), SIGMA_CEILING_RAD) if var0 == var0 else math.nan
    out[1] = min(math.sqrt(var1), SIGMA_CEILING_RAD) if var1 == var1 else math.nan
    out[2] = min(math.sqrt(var2), SIGMA_CEILING_RAD) if var2 == var2 else math.nan
