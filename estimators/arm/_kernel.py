"""The compiled live path: segment orientations of a few ticks to points, angles, flags.

One call serves one session. Every formula stands a second time, in numpy, in `_joint_angles`,
`chains.homogeneous` and `_uncertainty`; the tests hold the two against each other. The shared constants
live here because numba's cache does not see a change of a constant in another file.
"""

import math
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from estimators.compiling import compiled

Float = NDArray[np.float64]
Integer = NDArray[np.int64]
Flags = NDArray[np.uint8]

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
_SINGULAR = np.uint8(128)  # OrientationFlag.SINGULAR


@compiled()
def _multiply(p: Any, q: Float, out: Float) -> None:
    out[0] = p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3]
    out[1] = p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2]
    out[2] = p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1]
    out[3] = p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0]


@compiled()
def _matrix(q: Float, out: Float) -> None:
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


@compiled()
def _nearest(angle: float, wanted: float) -> float:
    return angle + _TWO_PI * math.floor((wanted - angle) / _TWO_PI + 0.5)


@compiled()
def _near(angle: float, previous: float, centre: float) -> float:
    """Choose the turn of an angle closest to the previous one, but no farther off the centre than a joint gets."""
    if math.isfinite(previous):
        near = _nearest(angle, previous)
        if abs(near - centre) <= REACH_RAD:
            return near
    return _nearest(angle, centre)


@compiled()
def _relative(parent: Float, child: Float, is_left: bool, out: Float) -> None:
    """Relative rotation, mirrored in the sagittal plane for the left side."""
    inverse = (parent[0], -parent[1], -parent[2], -parent[3])
    _multiply(inverse, child, out)
    if is_left:
        out[1] = -out[1]
        out[3] = -out[3]


@compiled()
def _shoulder(r: Float, previous: Float, step_s: float, angle: Float) -> bool:
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


@compiled()
def _hinge(r: Float, previous: Float, carrying_sign: float, angle: Float) -> bool:
    """Z-X-Y angles of elbow or wrist into `angle[0:3]`; returns whether they are near the singularity."""
    m12 = 2.0 * (r[2] * r[3] - r[0] * r[1])
    flexion = -math.atan2(2.0 * (r[1] * r[3] + r[0] * r[2]), 1.0 - 2.0 * (r[1] * r[1] + r[2] * r[2]))
    across = math.atan2(
        -m12, math.hypot(2.0 * (r[1] * r[2] + r[0] * r[3]), 1.0 - 2.0 * (r[1] * r[1] + r[3] * r[3]))
    )
    turn = math.atan2(2.0 * (r[1] * r[2] + r[0] * r[3]), 1.0 - 2.0 * (r[1] * r[1] + r[3] * r[3]))
    angle[0] = _near(flexion, previous[0], FLEXION_CENTRE_RAD)
    angle[1] = carrying_sign * across
    angle[2] = _near(turn, previous[2], PRONATION_CENTRE_RAD)
    return 0.5 * math.pi - abs(across) < SINGULAR_MARGIN_RAD


@compiled()
def _first_axes(
    parent: Float, angle: float, is_shoulder: bool, is_left: bool, scratch: Float, out: Float
) -> None:
    """Axes of the frame after the first rotation, in the room, as columns of `out`."""
    _matrix(parent, scratch)
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


@compiled()
def _sigmas(axes: Float, variance: Float, second: float, is_shoulder: bool, out: Float) -> None:
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


@compiled()
def _advance(
    q: Float,
    omega: Float,
    has_omega: bool,
    x: float,
    y: float,
    z: float,
    position: Float,
    velocity: Float,
    next_position: Float,
    next_velocity: Float,
) -> None:
    """Go from a joint along a segment vector to the next joint, with its velocity."""
    # v + 2 w (u x v) + 2 u x (u x v)
    w, a, b, c = q[0], q[1], q[2], q[3]
    tx, ty, tz = 2.0 * (b * z - c * y), 2.0 * (c * x - a * z), 2.0 * (a * y - b * x)
    rx = x + w * tx + b * tz - c * ty
    ry = y + w * ty + c * tx - a * tz
    rz = z + w * tz + a * ty - b * tx
    next_position[0] = position[0] + rx
    next_position[1] = position[1] + ry
    next_position[2] = position[2] + rz
    if has_omega:
        next_velocity[0] = velocity[0] + omega[1] * rz - omega[2] * ry
        next_velocity[1] = velocity[1] + omega[2] * rx - omega[0] * rz
        next_velocity[2] = velocity[2] + omega[0] * ry - omega[1] * rx


def evaluate_python(
    q_room_segment: Float,
    omega_room: Float,
    sigma_room: Float,
    segment_flags: Flags,
    source: Integer,
    lengths: Float,
    step_s: float,
    previous: Float,
    point_column: Integer,
    angle_column: Integer,
    scalar_column: Integer,
    points: Float,
    angles: Float,
    angle_sigma: Float,
    scalars: Float,
    angle_flags: Flags,
) -> None:
    """Fill the five outputs for every tick; `previous` (18,) is read and left at the last tick.

    Shapes: q (K,G,4), omega and sigma (K,G,3) or (0,0,3) when not given, flags (K,G); `source` (10,) maps
    `MODEL_SEGMENTS` to G or -1; the column arrays map the model's points, angles and scalars to output
    columns or -1; `lengths` is that of `model_lengths`.
    """
    has_omega = omega_room.shape[0] > 0
    has_sigma = sigma_room.shape[0] > 0
    upright = np.array([1.0, 0.0, 0.0, 0.0])
    zero3 = np.zeros(3)
    position = np.empty((11, 3))
    velocity = np.zeros((11, 3))
    relative = np.empty(4)
    found = np.empty(3)
    one_sigma = np.empty(3)
    variance = np.empty(3)
    matrix = np.empty((3, 3))
    axes = np.empty((3, 3))
    for k in range(q_room_segment.shape[0]):
        q_tick = q_room_segment[k]
        thorax_index = source[0]
        thorax = q_tick[thorax_index] if thorax_index >= 0 else upright
        thorax_omega = omega_room[k, thorax_index] if has_omega and thorax_index >= 0 else zero3
        head = q_tick[source[1]] if source[1] >= 0 else thorax
        position[0, 0] = 0.0
        position[0, 1] = 0.0
        position[0, 2] = lengths[0]
        _advance(
            thorax, thorax_omega, has_omega, 0.0, 0.0, lengths[1],
            position[0], velocity[0], position[1], velocity[1],
        )  # fmt: skip
        _advance(
            head,
            thorax_omega,
            False,
            0.0,
            0.0,
            lengths[3],
            position[1],
            velocity[1],
            position[2],
            velocity[2],
        )
        if scalar_column[0] >= 0:
            _matrix(thorax, matrix)
            # R = Ry(forward) Rx(right) Rz(left)
            scalars[k, scalar_column[0]] = math.atan2(matrix[0, 2], matrix[2, 2])
            scalars[k, scalar_column[1]] = math.atan2(-matrix[1, 2], math.hypot(matrix[1, 0], matrix[1, 1]))
            scalars[k, scalar_column[2]] = math.atan2(matrix[1, 0], matrix[1, 1])
        for side in range(2):
            is_left = side == 0
            base = 2 + 4 * side
            point = 3 + 4 * side
            outward = lengths[2] if is_left else -lengths[2]
            clavicle_index = source[base]
            clavicle = q_tick[clavicle_index] if clavicle_index >= 0 else thorax
            clavicle_omega = thorax_omega
            if has_omega and clavicle_index >= 0:
                clavicle_omega = omega_room[k, clavicle_index]
            _advance(
                clavicle, clavicle_omega, has_omega, 0.0, outward, 0.0,
                position[1], velocity[1], position[point], velocity[point],
            )  # fmt: skip
            if scalar_column[3 + side] >= 0:
                _matrix(thorax, matrix)
                hike = 0.0
                for i in range(3):
                    hike += matrix[i, 2] * (position[point, i] - position[1, i])
                scalars[k, scalar_column[3 + side]] = hike
            for joint in range(3):
                child_index = source[base + 1 + joint]
                reach = lengths[4 + joint]
                if point_column[point + 1 + joint] >= 0:
                    # A hand without a sensor goes straight on from the forearm.
                    carrier = child_index if child_index >= 0 else source[base + joint]
                    carrier_omega = omega_room[k, carrier] if has_omega else zero3
                    _advance(
                        q_tick[carrier], carrier_omega, has_omega, 0.0, 0.0, -reach,
                        position[point + joint], velocity[point + joint],
                        position[point + joint + 1], velocity[point + joint + 1],
                    )  # fmt: skip
                column = angle_column[9 * side + 3 * joint]
                if column < 0:
                    continue
                parent_index = thorax_index if joint == 0 else source[base + joint]
                parent = q_tick[parent_index] if parent_index >= 0 else upright
                memory = previous[9 * side + 3 * joint : 9 * side + 3 * joint + 3]
                _relative(parent, q_tick[child_index], is_left, relative)
                flag = segment_flags[k, child_index]
                if parent_index >= 0:
                    flag |= segment_flags[k, parent_index]
                norm = relative[0] + relative[1] + relative[2] + relative[3]
                if not math.isfinite(norm):
                    for i in range(3):
                        angles[k, column + i] = math.nan
                        angle_sigma[k, column + i] = math.nan
                        angle_flags[k, column + i] = flag
                    continue
                if joint == 0:
                    singular = _shoulder(relative, memory, step_s, found)
                else:
                    singular = _hinge(relative, memory, -1.0 if joint == 1 else 1.0, found)
                for i in range(3):
                    memory[i] = found[i]
                    angles[k, column + i] = found[i]
                    angle_flags[k, column + i] = flag
                    if singular and i != 1:
                        angle_flags[k, column + i] = flag | _SINGULAR
                    one_sigma[i] = math.nan
                if has_sigma:
                    for i in range(3):
                        variance[i] = sigma_room[k, child_index, i] ** 2
                        if parent_index >= 0:
                            variance[i] += sigma_room[k, parent_index, i] ** 2
                    _first_axes(parent, found[0], joint == 0, is_left, matrix, axes)
                    second = -found[1] if joint == 1 else found[1]
                    _sigmas(axes, variance, second, joint == 0, one_sigma)
                for i in range(3):
                    angle_sigma[k, column + i] = one_sigma[i]
            if scalar_column[5 + side] >= 0:
                speed = math.nan
                if has_omega:
                    v = velocity[point + 3]
                    speed = math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
                scalars[k, scalar_column[5 + side]] = speed
        for p in range(11):
            if point_column[p] >= 0:
                for i in range(3):
                    points[k, point_column[p], i] = position[p, i]


evaluate_kernel = compiled(
    "void(f8[:,:,::1],f8[:,:,::1],f8[:,:,::1],u1[:,::1],i8[::1],f8[::1],f8,f8[::1],"
    "i8[::1],i8[::1],i8[::1],f8[:,:,::1],f8[:,::1],f8[:,::1],f8[:,::1],u1[:,::1])"
)(evaluate_python)
