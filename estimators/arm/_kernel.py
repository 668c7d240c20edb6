"""The compiled live path: segment orientations of a few ticks to points, angles, flags.

One call serves one session. Every formula stands a second time, in numpy, in `_joint_angles`,
`chains.homogeneous` and `_uncertainty`; the tests hold the two against each other.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from estimators._kernels import Scalars3
from estimators.arm._angle_kernel import first_axes, hinge, matrix_of, relative_of, shoulder, sigmas
from estimators.arm._names import MODEL_POINTS, MODEL_SCALARS, MODEL_SEGMENTS
from estimators.compiling import compiled
from estimators.kernels import VOID, borrowing, bundle

Float = NDArray[np.float64]
Integer = NDArray[np.int64]
Flags = NDArray[np.uint8]

_SINGULAR = np.uint8(128)  # OrientationFlag.SINGULAR
_THORAX, _HEAD, _FIRST_CLAVICLE = (
    MODEL_SEGMENTS.index(name) for name in ("sternum", "head", "shoulder_left")
)
_PELVIS, _NECK, _HEAD_POINT, _FIRST_SHOULDER, _FIRST_HAND = (
    MODEL_POINTS.index(name) for name in ("pelvis", "neck", "head", "shoulder_left", "hand_left")
)
_PER_ARM = 4
"""Segments of an arm, clavicle to hand, and points, shoulder to hand: each begins at the joint before its end."""
_POINTS = len(MODEL_POINTS)
_LEAN_FORWARD, _LEAN_LATERAL, _TRUNK_TURN = range(3)
_FIRST_HIKE, _FIRST_SPEED = (
    MODEL_SCALARS.index(name) for name in ("shoulder_hike_left_m", "hand_speed_left_mps")
)
_HIPS, _TRUNK, _HALF_WIDTH, _NECK_LENGTH, _FIRST_OF_ARM = range(5)
"""Places of `model_lengths`."""
_JOINT_ANGLES, _ARM_ANGLES = 3, 9


@borrowing()
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


class Segments(NamedTuple):
    """What moves the model: q (K, G, 4), angular velocity and sigma (K, G, 3), or (0, 0, 3) where not given, flags."""

    q_room: Float
    omega_room_radps: Float
    sigma_room_rad: Float
    flags: Flags


class Columns(NamedTuple):
    """Which segment of `MODEL_SEGMENTS` is which of the G, (10,), and the columns of points, angles and scalars; or -1.

    `lengths_m` is that of `model_lengths`.
    """

    source: Integer
    lengths_m: Float
    point: Integer
    angle: Integer
    scalar: Integer


class Filled(NamedTuple):
    """What is filled, K ticks leading."""

    point_m: Float
    angle_rad: Float
    angle_sigma_rad: Float
    scalar: Float
    angle_flags: Flags


class _Chain(NamedTuple):
    """Where the eleven points of one tick are, and room for a matrix, axes, a rotation and three angles' numbers."""

    position: Float
    velocity: Float
    matrix: Float
    axes: Float
    relative: Float
    found: Float
    variance: Float
    sigma: Float
    upright: Float
    zero: Float


_ROW, _TABLE, _CUBE = types.float64[::1], types.float64[:, ::1], types.float64[:, :, ::1]
_WHOLE, _BYTES = types.int64[::1], types.uint8[:, ::1]
_SEGMENTS = bundle(Segments, _CUBE, _CUBE, _CUBE, _BYTES)
_COLUMNS = bundle(Columns, _WHOLE, _ROW, _WHOLE, _WHOLE, _WHOLE)
_FILLED = bundle(Filled, _CUBE, _TABLE, _TABLE, _TABLE, _BYTES)


@borrowing()
def _trunk(
    k: int, thorax: Float, thorax_omega: Float, worn: Segments, model: Columns, at: _Chain, out: Filled
) -> None:
    """Place neck and head, and write the trunk's lean."""
    head = worn.q_room[k, model.source[_HEAD]] if model.source[_HEAD] >= 0 else thorax
    has_omega = worn.omega_room_radps.shape[0] > 0
    lengths, position, velocity = model.lengths_m, at.position, at.velocity
    position[_PELVIS, 0] = 0.0
    position[_PELVIS, 1] = 0.0
    position[_PELVIS, 2] = lengths[_HIPS]
    _advance(
        thorax, thorax_omega, has_omega, 0.0, 0.0, lengths[_TRUNK],
        position[_PELVIS], velocity[_PELVIS], position[_NECK], velocity[_NECK],
    )  # fmt: skip
    _advance(
        head, thorax_omega, False, 0.0, 0.0, lengths[_NECK_LENGTH],
        position[_NECK], velocity[_NECK], position[_HEAD_POINT], velocity[_HEAD_POINT],
    )  # fmt: skip
    if model.scalar[_LEAN_FORWARD] >= 0:
        matrix = at.matrix
        matrix_of(thorax, matrix)
        # R = Ry(forward) Rx(right) Rz(left)
        out.scalar[k, model.scalar[_LEAN_FORWARD]] = math.atan2(matrix[0, 2], matrix[2, 2])
        lateral = math.atan2(-matrix[1, 2], math.hypot(matrix[1, 0], matrix[1, 1]))
        out.scalar[k, model.scalar[_LEAN_LATERAL]] = lateral
        out.scalar[k, model.scalar[_TRUNK_TURN]] = math.atan2(matrix[1, 0], matrix[1, 1])


@borrowing()
def _shoulder_point(
    k: int,
    side: int,
    thorax: Float,
    thorax_omega: Float,
    worn: Segments,
    model: Columns,
    at: _Chain,
    out: Filled,
) -> None:
    """Place the shoulder, on its clavicle or with the thorax, and write how far it is hiked."""
    is_left = side == 0
    point = _FIRST_SHOULDER + _PER_ARM * side
    has_omega = worn.omega_room_radps.shape[0] > 0
    outward = model.lengths_m[_HALF_WIDTH] if is_left else -model.lengths_m[_HALF_WIDTH]
    clavicle_index = model.source[_FIRST_CLAVICLE + _PER_ARM * side]
    clavicle = worn.q_room[k, clavicle_index] if clavicle_index >= 0 else thorax
    clavicle_omega = thorax_omega
    if has_omega and clavicle_index >= 0:
        clavicle_omega = worn.omega_room_radps[k, clavicle_index]
    position, velocity = at.position, at.velocity
    _advance(
        clavicle, clavicle_omega, has_omega, 0.0, outward, 0.0,
        position[_NECK], velocity[_NECK], position[point], velocity[point],
    )  # fmt: skip
    column = model.scalar[_FIRST_HIKE + side]
    if column >= 0:
        matrix_of(thorax, at.matrix)
        hike = 0.0
        for i in range(3):
            hike += at.matrix[i, 2] * (position[point, i] - position[_NECK, i])
        out.scalar[k, column] = hike


@borrowing()
def _joint_sigmas(
    k: int,
    joint: int,
    places: tuple[int, int],
    parent: Float,
    is_left: bool,
    found: Float,
    sigma: Float,
    at: _Chain,
) -> Scalars3:
    """Return one sigma of each of the joint's angles from those of its segments, at `places` (parent or -1, child)."""
    variance, one_sigma = at.variance, at.sigma
    parent_index, child_index = places
    for i in range(3):
        variance[i] = sigma[k, child_index, i] ** 2
        if parent_index >= 0:
            variance[i] += sigma[k, parent_index, i] ** 2
    first_axes(parent, found[0], joint == 0, is_left, at.matrix, at.axes)
    second = -found[1] if joint == 1 else found[1]
    sigmas(at.axes, variance, second, joint == 0, one_sigma)
    return one_sigma[0], one_sigma[1], one_sigma[2]


@borrowing()
def _joint(
    k: int,
    side: int,
    joint: int,
    worn: Segments,
    model: Columns,
    step_s: float,
    memory: Float,
    at: _Chain,
    out: Filled,
) -> None:
    """Write angles, sigmas and flags of shoulder (0), elbow (1) or wrist (2)."""
    column = model.angle[_ARM_ANGLES * side + _JOINT_ANGLES * joint]
    is_left = side == 0
    before = _FIRST_CLAVICLE + _PER_ARM * side + joint
    child_index = model.source[before + 1]
    parent_index = model.source[_THORAX] if joint == 0 else model.source[before]
    parent = worn.q_room[k, parent_index] if parent_index >= 0 else at.upright
    relative, found = at.relative, at.found
    relative_of(parent, worn.q_room[k, child_index], is_left, relative)
    flag = worn.flags[k, child_index]
    if parent_index >= 0:
        flag |= worn.flags[k, parent_index]
    if not math.isfinite(relative[0] + relative[1] + relative[2] + relative[3]):
        for i in range(3):
            out.angle_rad[k, column + i] = math.nan
            out.angle_sigma_rad[k, column + i] = math.nan
            out.angle_flags[k, column + i] = flag
        return
    if joint == 0:
        singular = shoulder(relative, memory, step_s, found)
    else:
        singular = hinge(relative, memory, -1.0 if joint == 1 else 1.0, found)
    one_sigma = (math.nan, math.nan, math.nan)
    if worn.sigma_room_rad.shape[0] > 0:
        places = (parent_index, child_index)
        one_sigma = _joint_sigmas(k, joint, places, parent, is_left, found, worn.sigma_room_rad, at)
    for i in range(3):
        memory[i] = found[i]
        out.angle_rad[k, column + i] = found[i]
        out.angle_sigma_rad[k, column + i] = one_sigma[i]
        out.angle_flags[k, column + i] = flag
        if singular and i != 1:
            out.angle_flags[k, column + i] = flag | _SINGULAR


@borrowing()
def _onward(k: int, side: int, joint: int, worn: Segments, model: Columns, at: _Chain) -> None:
    """Go on from a joint to the next point of the arm, unless it is not wanted."""
    point = _FIRST_SHOULDER + _PER_ARM * side + joint
    if model.point[point + 1] < 0:
        return
    # A hand without a sensor goes straight on from the forearm.
    before = _FIRST_CLAVICLE + _PER_ARM * side + joint
    child_index = model.source[before + 1]
    carrier = child_index if child_index >= 0 else model.source[before]
    has_omega = worn.omega_room_radps.shape[0] > 0
    omega = worn.omega_room_radps[k, carrier] if has_omega else at.zero
    _advance(
        worn.q_room[k, carrier], omega, has_omega, 0.0, 0.0, -model.lengths_m[_FIRST_OF_ARM + joint],
        at.position[point], at.velocity[point], at.position[point + 1], at.velocity[point + 1],
    )  # fmt: skip


@borrowing()
def _tick(
    k: int, worn: Segments, model: Columns, step_s: float, previous: Float, at: _Chain, out: Filled
) -> None:
    has_omega = worn.omega_room_radps.shape[0] > 0
    thorax_index = model.source[_THORAX]
    thorax = worn.q_room[k, thorax_index] if thorax_index >= 0 else at.upright
    thorax_omega = worn.omega_room_radps[k, thorax_index] if has_omega and thorax_index >= 0 else at.zero
    _trunk(k, thorax, thorax_omega, worn, model, at, out)
    for side in range(2):
        _shoulder_point(k, side, thorax, thorax_omega, worn, model, at, out)
        for joint in range(3):
            _onward(k, side, joint, worn, model, at)
            first = _ARM_ANGLES * side + _JOINT_ANGLES * joint
            if model.angle[first] >= 0:
                _joint(k, side, joint, worn, model, step_s, previous[first : first + _JOINT_ANGLES], at, out)
        column = model.scalar[_FIRST_SPEED + side]
        if column >= 0:
            speed = math.nan
            if has_omega:
                v = at.velocity[_FIRST_HAND + _PER_ARM * side]
                speed = math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
            out.scalar[k, column] = speed
    for p in range(_POINTS):
        if model.point[p] >= 0:
            for i in range(3):
                out.point_m[k, model.point[p], i] = at.position[p, i]


@compiled(VOID(_SEGMENTS, _COLUMNS, types.float64, _ROW, _FILLED))
def evaluate_kernel(worn: Segments, model: Columns, step_s: float, previous: Float, out: Filled) -> None:
    """Fill the outputs for every tick; `previous` (18,), the angles before, is read and left at the last tick."""
    at = _Chain(
        np.empty((_POINTS, 3)),
        np.zeros((_POINTS, 3)),
        np.empty((3, 3)),
        np.empty((3, 3)),
        np.empty(4),
        np.empty(3),
        np.empty(3),
        np.empty(3),
        np.array([1.0, 0.0, 0.0, 0.0]),
        np.zeros(3),
    )
    for k in range(worn.q_room.shape[0]):
        _tick(k, worn, model, step_s, previous, at, out)
