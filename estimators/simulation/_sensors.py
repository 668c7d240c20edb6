"""Sensors on a moving body: mounting, surroundings, and exact readings before any error."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from estimators import rotation
from estimators.body import BodyDimensions
from estimators.conventions import GRAVITY_MPS2, PLACEMENTS, Placement
from estimators.simulation.arm.body import SegmentMotion
from estimators.simulation.arm.kinematics import Path, carried, rotate
from estimators.simulation.arm.timeline import minimum_jerk

Float = NDArray[np.float64]

MAGNETIC_CONSTANT: Final = 4e-7 * np.pi


@dataclass(frozen=True)
class EarthField:
    """The undisturbed magnetic field: norm, and dip below the horizontal toward north.

    Defaults: 49 uT and 67 degrees, Roetenberg (2006) sections 5.2.1 and 2.2.1.
    """

    norm_t: float = 49e-6
    dip_rad: float = float(np.radians(67.0))

    @property
    def earth_t(self) -> Float:
        """Field in the earth frame (east, north, up), shape (3,)."""
        return self.norm_t * np.array([0.0, np.cos(self.dip_rad), -np.sin(self.dip_rad)])


@dataclass(frozen=True)
class Magnet:
    """A permanent magnet (or magnetised iron) that comes close and goes away: a point dipole.

    Attributes
    ----------
    moment_am2 : tuple of 3 floats
        Dipole moment in the room frame. A loudspeaker has some 5 A m^2, a fridge magnet 0.1.
    near_m, far_m : tuple of 3 floats
        Where it is while near, and before and after, in the room.
    arrive_s, leave_s : float
        When it starts to come and to go; each way is one minimum-jerk move of `move_s`.
    """

    moment_am2: tuple[float, float, float]
    near_m: tuple[float, float, float]
    far_m: tuple[float, float, float] = (5.0, 5.0, 1.0)
    arrive_s: float = 0.0
    leave_s: float = np.inf
    move_s: float = 1.5

    def position_m(self, time_s: Float) -> Float:
        """Return where it is, shape (N, 3)."""
        come = minimum_jerk((time_s - self.arrive_s) / self.move_s).value
        go = minimum_jerk((time_s - self.leave_s) / self.move_s).value
        near, far = np.array(self.near_m), np.array(self.far_m)
        return np.asarray(far + (come - go)[:, None] * (near - far))

    def field_room_t(self, time_s: Float, point_room_m: Float) -> Float:
        """Return its field at points, shape (N, 3), in the room frame, tesla."""
        return dipole_field(self.moment_am2, point_room_m - self.position_m(time_s))


def dipole_field(moment_am2: ArrayLike, offset_m: Float) -> Float:
    """Return the field of a point dipole, shape (N, 3), tesla.

    Parameters
    ----------
    moment_am2 : array_like, shape (3,)
    offset_m : ndarray, shape (N, 3)
        From the dipole to the point; taken as at least 1 cm, where a real magnet ends.

    Notes
    -----
    B = mu0 / (4 pi r^3) (3 u (u . m) - m).
    """
    moment = np.asarray(moment_am2, dtype=np.float64)
    distance = np.maximum(np.linalg.norm(offset_m, axis=-1, keepdims=True), 0.01)
    unit = offset_m / distance
    along = np.sum(unit * moment, axis=-1, keepdims=True)
    return np.asarray(MAGNETIC_CONSTANT / (4.0 * np.pi) * (3.0 * unit * along - moment) / distance**3)


# Outward and distal direction of the sensor's z and x axes, in segment axes while the N-pose is held.
_AXES_N_POSE: Final[dict[str, tuple[tuple[float, float, float], tuple[float, float, float]]]] = {
    "head": ((1, 0, 0), (0, 0, -1)),
    "sternum": ((1, 0, 0), (0, 0, -1)),
    "pelvis": ((1, 0, 0), (0, 0, -1)),
    "shoulder": ((0, 1, 0), (0, 0, -1)),
    "upper_arm": ((0, 1, 0), (0, 0, -1)),
    "forearm": ((0, 1, 0), (0, 0, -1)),
    "hand": ((0, 1, 0), (0, 0, -1)),
    "thigh": ((0, 1, 0), (0, 0, -1)),
    "shank": ((0, 1, 0), (0, 0, -1)),
    "foot": ((0.6, 0, 0.8), (0.8, 0, -0.6)),
}


def outward_mounting(placement: Placement) -> Float:
    """Return `q_segment_sensor` of the house rule, shape (4,).

    The sensor's z axis points outward from the body while the N-pose is held (head, sternum and pelvis
    forward; shoulder, arm, back of the hand and leg to their side; the slope of the instep forward and up)
    and its x axis along the segment, away from the trunk: the rule that the N-pose calibration expects.
    """
    part, _, side = placement.rpartition("_")
    part = part if side in ("left", "right") else placement
    outward, distal = (np.array(axis, dtype=np.float64) for axis in _AXES_N_POSE[part])
    if side == "right":
        outward[1], distal[1] = -outward[1], -distal[1]
    q_room_sensor = rotation.from_matrix(np.column_stack((distal, np.cross(outward, distal), outward)))
    q_room_segment = rotation.identity()
    if part in ("forearm", "hand"):
        q_room_segment = rotation.about_z(0.5 * np.pi if side == "right" else -0.5 * np.pi)
    return rotation.multiply(rotation.conjugate(q_room_segment), q_room_sensor)


def sensor_offset_m(placement: Placement, body: BodyDimensions) -> Float:
    """Return where a sensor sits in its segment frame, shape (3,): on the skin, not on the bone's axis."""
    part, _, side = placement.rpartition("_")
    sign = 1.0 if side == "left" else -1.0
    along = {
        "head": (0.09, 0.0, 0.20),
        "sternum": (0.10, 0.0, 0.80 * body.trunk_m),
        "pelvis": (0.10, 0.0, 0.05),
        "shoulder": (0.0, sign * 0.55 * body.shoulder_width_m, 0.02),
        # Thesis V9: 0.18 m from the shoulder on a 0.30 m arm.
        "upper_arm": (0.0, sign * 0.045, -0.60 * body.upper_arm_m),
        # Forearm and hand frames are turned by 90 degrees in the N-pose: outward is x there.
        "forearm": (-0.030, 0.0, -0.80 * body.forearm_m),
        "hand": (-0.020, 0.0, -0.40 * body.hand_m),
        "thigh": (0.0, sign * 0.07, -0.20),
        "shank": (0.0, sign * 0.05, -0.15),
        "foot": (0.10, 0.0, -0.02),
    }
    return np.array(along[part if side in ("left", "right") else placement])


@dataclass(frozen=True)
class Mounting:
    """How sensors are put on.

    Attributes
    ----------
    misalignment_sd_rad : float
        Random turn against the house rule, per axis, drawn once a sensor.
    q_segment_sensor : mapping of Placement to (w, x, y, z)
        Exact mounting of some sensors, in place of rule and misalignment.
    offset_m : mapping of Placement to (x, y, z)
        Where some sensors sit in their segment frame.
    soft_tissue_rad : float
        Largest turn of the skin, and the sensor on it, against the bone; see `_soft_tissue`.
    """

    misalignment_sd_rad: float = float(np.radians(3.0))
    q_segment_sensor: Mapping[Placement, tuple[float, float, float, float]] = field(default_factory=dict)
    offset_m: Mapping[Placement, tuple[float, float, float]] = field(default_factory=dict)
    soft_tissue_rad: float = 0.0

    def draw(self, placement: Placement, body: BodyDimensions, seed: int) -> tuple[Float, Float]:
        """Return `q_segment_sensor`, shape (4,), and the offset in segment axes, shape (3,)."""
        rng = np.random.default_rng([seed, 6, PLACEMENTS.index(placement)])
        off = rotation.exp(rng.normal(size=3) * self.misalignment_sd_rad)
        q = rotation.multiply(outward_mounting(placement), off)
        if placement in self.q_segment_sensor:
            q = rotation.normalize(np.array(self.q_segment_sensor[placement], dtype=np.float64))
        offset = self.offset_m.get(placement)
        return q, sensor_offset_m(placement, body) if offset is None else np.array(offset, dtype=np.float64)


class TrueReadings(NamedTuple):
    """What a perfect sensor reads, and where it is; all shape (N, ...).

    `q_room_sensor`; gyroscope in rad/s, at the instants and as mean since the sample before; specific force
    in m/s^2 and field in T, in sensor axes; path in the room.
    """

    q_room_sensor: Float
    rate_radps: Float
    mean_rate_radps: Float
    specific_force_mps2: Float
    field_t: Float
    path: Path


def true_readings(
    motion: SegmentMotion,
    q_before: Float,
    time_s: Float,
    step_before_s: Float,
    q_segment_sensor: Float,
    offset_m: Float,
    field_room_t: Float,
    magnets: tuple[Magnet, ...] = (),
) -> TrueReadings:
    """Return the perfect readings of one sensor.

    Parameters
    ----------
    motion : SegmentMotion
        At `time_s`, shape (N,).
    q_before : ndarray, shape (N, 4)
        `q_room_segment` one sampling interval before each sample.
    time_s, step_before_s : ndarray, shape (N,)
        Sample times and the interval before each.
    q_segment_sensor : ndarray, shape (4,)
    offset_m : ndarray, shape (3,)
        Sensor in segment axes: the lever arm.
    field_room_t : ndarray, shape (3,)
    """
    q = rotation.multiply(motion.turn.q, q_segment_sensor)
    back = rotation.conjugate(q)
    path = carried(motion.origin, motion.turn, offset_m)
    field = np.broadcast_to(field_room_t, path.position.shape)
    for magnet in magnets:
        field = field + magnet.field_room_t(time_s, path.position)
    turned = rotation.log(rotation.multiply(rotation.conjugate(q_before), motion.turn.q))
    mean_rate = rotation.rotate(rotation.conjugate(q_segment_sensor), turned) / step_before_s[:, None]
    gravity_up = np.array([0.0, 0.0, GRAVITY_MPS2])
    return TrueReadings(
        q,
        rotate(back, motion.turn.rate),
        mean_rate,
        rotate(back, path.acceleration + gravity_up),
        rotate(back, field),
        path,
    )
