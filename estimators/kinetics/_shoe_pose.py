"""Orientation of heel and forefoot and position of the shoe, stride by stride, with drift taken out at rest."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from estimators import rotation
from estimators.conventions import GRAVITY_MPS2
from estimators.errors import ShapeError
from estimators.kinetics._contact import ShoeContact
from estimators.kinetics._shoe_geometry import ShoeGeometry
from estimators.kinetics._strapdown_kernel import integrate
from estimators.recording import Float
from estimators.sentences import say

PositionMode = Literal["flat", "pivot", "published"]


@dataclass(frozen=True)
class ShoePose:
    """Pose of one shoe over N samples, in a room frame with the floor at z = 0.

    Origin below the heel sensor in the first stance, x where the shoe points there.

    Attributes
    ----------
    q_room_heel, q_room_forefoot : ndarray, shape (N, 4)
    heel_rate_radps, forefoot_rate_radps : ndarray, shape (N, 3)
        Room axes, bias taken out.
    heel_m, forefoot_m : ndarray, shape (N, 3)
        Sensor centres.
    velocity_mps : ndarray, shape (N, 3)
        Of the heel sensor.
    specific_force_mps2 : ndarray, shape (N, 3)
        Of the heel sensor, room axes.
    is_known : ndarray of bool, shape (N,)
        From the first to the last stance; nothing can be said outside.
    """

    q_room_heel: Float
    q_room_forefoot: Float
    heel_rate_radps: Float
    forefoot_rate_radps: Float
    heel_m: Float
    forefoot_m: Float
    velocity_mps: Float
    specific_force_mps2: Float
    is_known: NDArray[np.bool_]

    def moved(self, heading_rad: float, origin_m: Float) -> "ShoePose":
        """Return the same pose in a room turned by `heading_rad` about z and then shifted by `origin_m`."""
        turn = rotation.about_z(heading_rad)
        return ShoePose(
            rotation.multiply(turn, self.q_room_heel),
            rotation.multiply(turn, self.q_room_forefoot),
            rotation.rotate(turn, self.heel_rate_radps),
            rotation.rotate(turn, self.forefoot_rate_radps),
            rotation.rotate(turn, self.heel_m) + origin_m,
            rotation.rotate(turn, self.forefoot_m) + origin_m,
            rotation.rotate(turn, self.velocity_mps),
            rotation.rotate(turn, self.specific_force_mps2),
            self.is_known,
        )


def _stride_by_stride(
    core: NDArray[np.int64],
    samples: int,
    height_m: float,
    stride_of: Callable[[slice, Float], tuple[Float, Float]],
) -> tuple[Float, Float]:
    """Return velocity and position, (N, 3), of a shoe that rests in each core and moves as said between two."""
    position, velocity = np.zeros((samples, 3)), np.zeros((samples, 3))
    at = np.array([0.0, 0.0, height_m])
    position[: core[0, 1]] = at
    for number in range(len(core) - 1):
        rest, next_rest = core[number, 1] - 1, core[number + 1, 0]
        stride = slice(rest, next_rest + 1)
        velocity[stride], position[stride] = stride_of(stride, at)
        at = position[next_rest].copy()
        position[next_rest : core[number + 1, 1]] = at
    position[core[-1, 1] :] = at
    return velocity, position


def shoe_pose(
    heel: tuple[Float, Float],
    forefoot: tuple[Float, Float],
    contact: ShoeContact,
    rate_hz: float,
    geometry: ShoeGeometry | None = None,
    *,
    mode: PositionMode = "flat",
    is_level: bool = True,
) -> ShoePose:
    """Estimate the pose of one shoe.

    Parameters
    ----------
    heel, forefoot : (gyroscope in rad/s, accelerometer in m/s^2), each shape (N, 3)
        In segment axes, filtered.
    mode : {"flat", "pivot", "published"}
        Where the double integration begins and ends: from rest to rest; from heel-off to heel-down with the
        speed and height of the rolling foot; or the same with zero speed and height as printed, which is
        50 to 60 mm short a stride and only here to show it.
    is_level : bool
        Every stance has the height of the first; switch off for stairs.

    Raises
    ------
    ShapeError
        If the foot was never seen flat: without a stance there is no pose.

    Notes
    -----
    Schepers (2009) equations 2.9 to 2.11 with 3.2 and 3.4. Orientation: `R(i+1) = R(i) exp(w dt)` from rest to
    rest, the inclination that is left over at the end spread linearly. Heading is not observable and carries on.
    Position: `v+ = v- - lambda (v-(end) - v_end)` and `x = x_0 + integral of v+`; the equation prints v- there
    (E4), and zero speed at heel-down while the heel still rolls (E5).
    """
    shoe = geometry or ShoeGeometry()
    if not len(contact.core):
        raise ShapeError(say("shoes.no_stance"))
    step_s = 1.0 / rate_hz
    q_heel, rate_heel, excess = _orientation(*heel, contact.core, step_s, None)
    q_forefoot, rate_forefoot, _ = _orientation(*forefoot, contact.core, step_s, q_heel)
    # Resting specific force other than 1 g is a bias of the vertical axis rather than a wrong scale, which
    # would be wrong for the horizontal ones too.
    specific = rotation.rotate(q_heel, heel[1])
    specific[:, 2] -= excess
    acceleration = specific - [0.0, 0.0, GRAVITY_MPS2]
    samples = heel[0].shape[0]

    def stride_of(stride: slice, at: Float) -> tuple[Float, Float]:
        if mode == "flat":
            return _between_rests(acceleration[stride], at, step_s, is_level)
        return _with_rolling(
            acceleration[stride],
            at,
            step_s,
            q_heel[stride],
            rate_heel[stride],
            contact.heel[stride],
            shoe,
            mode == "published",
            is_level,
        )

    velocity, position = _stride_by_stride(contact.core, samples, shoe.sensor_height_m, stride_of)
    is_known = np.zeros(samples, dtype=np.bool_)
    is_known[contact.core[0, 0] : contact.core[-1, 1]] = True
    hinge = position + rotation.rotate(q_heel, shoe.hinge_point_m)
    return ShoePose(
        q_heel,
        q_forefoot,
        rotation.rotate(q_heel, rate_heel),
        rotation.rotate(q_forefoot, rate_forefoot),
        position,
        hinge + rotation.rotate(q_forefoot, shoe.forefoot_sensor_point_m),
        velocity,
        specific,
        is_known,
    )


def _orientation(
    gyroscope: Float, accelerometer: Float, core: NDArray[np.int64], step_s: float, q_tied: Float | None
) -> tuple[Float, Float, Float]:
    """Return orientation, rate less its bias, and by how much resting specific force exceeds 1 g.

    With `q_tied` the heading at every rest is that of another part of the foot, whose sole is straight then.
    """
    samples = gyroscope.shape[0]
    middles = core.mean(axis=1)
    resting_rate = np.array([gyroscope[a:b].mean(axis=0) for a, b in core])
    resting_force = np.array([accelerometer[a:b].mean(axis=0) for a, b in core])
    at = np.arange(samples, dtype=np.float64)
    bias = np.column_stack([np.interp(at, middles, resting_rate[:, axis]) for axis in range(3)])
    excess = np.interp(at, middles, np.linalg.norm(resting_force, axis=1) - GRAVITY_MPS2)
    rate = np.ascontiguousarray(gyroscope - bias)
    q = np.empty((samples, 4))
    up = np.array([0.0, 0.0, 1.0])

    def level(force: Float, heading: float) -> Float:
        inclination = rotation.shortest(force, up)
        return rotation.multiply(rotation.about_z(heading - _heading(inclination)), inclination)

    heading = 0.0 if q_tied is None else _heading(q_tied[core[0, 0]])
    here = level(resting_force[0], heading)
    q[: core[0, 1]] = here
    for number in range(len(core) - 1):
        stride = slice(core[number, 1] - 1, core[number + 1, 0] + 1)
        turned = np.empty((stride.stop - stride.start, 4))
        integrate(np.ascontiguousarray(here), rate[stride], step_s, turned)
        end = turned[-1]
        if q_tied is None:
            found = rotation.rotate(end, resting_force[number + 1])
            # The smallest turn to the vertical has no part about it: heading is left alone.
            error = rotation.log(rotation.shortest(found, up))
        else:
            wanted = level(resting_force[number + 1], _heading(q_tied[core[number + 1, 0]]))
            error = rotation.log(rotation.multiply(wanted, rotation.conjugate(end)))
        part = np.linspace(0.0, 1.0, turned.shape[0])[:, None]
        q[stride] = rotation.multiply(rotation.exp(part * error), turned)
        here = q[core[number + 1, 0]].copy()
        q[core[number + 1, 0] : core[number + 1, 1]] = here
    q[core[-1, 1] :] = here
    return q, rate, excess


def _heading(q: Float) -> float:
    """Return where the x axis of a part points, seen from above."""
    x_axis = rotation.rotate(q, np.array([1.0, 0.0, 0.0]))
    return float(np.arctan2(x_axis[1], x_axis[0]))


def _integral(values: Float, step_s: float) -> Float:
    """Return the trapezoidal integral from the first sample, shape (N, 3)."""
    total = np.zeros_like(values)
    np.cumsum(0.5 * step_s * (values[1:] + values[:-1]), axis=0, out=total[1:])
    return total


def _between_rests(acceleration: Float, start_m: Float, step_s: float, is_level: bool) -> tuple[Float, Float]:
    part = np.linspace(0.0, 1.0, acceleration.shape[0])[:, None]
    velocity = _integral(acceleration, step_s)
    velocity = velocity - part * velocity[-1]
    position = start_m + _integral(velocity, step_s)
    if is_level:
        position[:, 2] -= part[:, 0] * (position[-1, 2] - start_m[2])
    return velocity, position


def _with_rolling(
    acceleration: Float,
    start_m: Float,
    step_s: float,
    q_heel: Float,
    rate: Float,
    heel_touches: NDArray[np.bool_],
    shoe: ShoeGeometry,
    is_published: bool,
    is_level: bool,
) -> tuple[Float, Float]:
    """Integrate the heel in the air only; before and after, the foot rolls on the hinge and on the rear edge."""
    samples = acceleration.shape[0]
    off = np.flatnonzero(heel_touches[:-1] & ~heel_touches[1:])
    down = np.flatnonzero(~heel_touches[:-1] & heel_touches[1:]) + 1
    if not off.size or not down.size or down[-1] <= off[0]:
        return _between_rests(acceleration, start_m, step_s, is_level)
    first, last = int(off[0]), int(down[-1])
    rate_room = rotation.rotate(q_heel, rate)
    if is_published:
        velocity, position = np.zeros((samples, 3)), np.broadcast_to(start_m, (samples, 3)).copy()
        air = slice(first, last + 1)
        velocity[air], position[air] = _between_rests(acceleration[air], start_m, step_s, is_level)
        position[last:] = position[last]
        return velocity, position
    # Phase C: on the hinge, which lies where it was while the foot was flat.
    arm = rotation.rotate(q_heel, shoe.hinge_point_m)
    hinge = start_m + arm[0]
    velocity, position = -np.cross(rate_room, arm), hinge - arm
    # Phase A: on the rear edge; its place follows from where the swing ends.
    rear = rotation.rotate(q_heel, shoe.rear_point_m)
    rolling = -np.cross(rate_room, rear)
    air = slice(first, last + 1)
    part = np.linspace(0.0, 1.0, last + 1 - first)[:, None]
    swing = velocity[first] + _integral(acceleration[air], step_s)
    swing = swing - part * (swing[-1] - rolling[last])
    path = position[first] + _integral(swing, step_s)
    if is_level:
        landing = (start_m[2] - shoe.sensor_height_m) - rear[last, 2]
        path[:, 2] -= part[:, 0] * (path[-1, 2] - landing)
    velocity[air], position[air] = swing, path
    edge = path[-1] + rear[last]
    position[last:] = edge - rear[last:]
    velocity[last:] = rolling[last:]
    return velocity, position
