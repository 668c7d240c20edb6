"""One shoe from its raw signals to forces, centre of pressure, joint moments and power."""

from dataclasses import dataclass, field

import numpy as np

from estimators import rotation
from estimators.errors import SetupError, ShapeError
from estimators.kinetics._contact import ContactParameters, ShoeContact, shoe_contact
from estimators.kinetics._ground_reaction import GroundReaction, ShoeLoads, ground_reaction
from estimators.kinetics._joint_loads import FootSegment, JointLoad, ankle_load, hinge_load
from estimators.kinetics._load_cell import LoadCellCalibration, is_tareable, tare, unloaded
from estimators.kinetics._shoe_geometry import ShoeGeometry
from estimators.kinetics._shoe_pose import PositionMode, ShoePose, shoe_pose
from estimators.orientation import create
from estimators.recording import Float, ImuChunk, SensorSignals
from estimators.sentences import say
from estimators.signals import low_pass

_CELLS = ("heel", "forefoot")
_SWINGING_RADPS = 2.0
"""A foot turns faster than this as it is lifted, in swing and as it lands, and hardly while it carries."""


@dataclass(frozen=True)
class ShoeParameters:
    """How the signals of a shoe are treated.

    Attributes
    ----------
    cutoff_hz : float
        Of the Butterworth low-pass there and back over all signals, of order 2; zero for none.
    is_level : bool
        Whether all stances are on one floor.
    unloaded_n : float
        Force below which a cell is taken to be in the air, for taring.
    foot : FootSegment, optional
        For the ankle moment in full; massless without.
    shank_filter : str
        Orientation estimator for the lower leg.
    """

    geometry: ShoeGeometry = field(default_factory=ShoeGeometry)
    cutoff_hz: float = 15.0
    contact: ContactParameters = field(default_factory=ContactParameters)
    position_mode: PositionMode = "flat"
    is_level: bool = True
    unloaded_n: float = 10.0
    foot: FootSegment | None = None
    shank_filter: str = "vqf"


@dataclass(frozen=True)
class ShoeKinetics:
    """One shoe over N samples at `rate_hz`.

    Attributes
    ----------
    ankle, hinge : JointLoad, or None
        None for the ankle without a sensor on the lower leg.
    shank_rate_radps : ndarray, shape (N, 3), or None
        Room axes.
    """

    rate_hz: float
    contact: ShoeContact
    pose: ShoePose
    loads: ShoeLoads
    reaction: GroundReaction
    ankle: JointLoad | None
    hinge: JointLoad
    shank_rate_radps: Float | None

    @property
    def total_power_w(self) -> Float | None:
        """Ankle and hinge together, shape (N,)."""
        return None if self.ankle is None else np.asarray(self.ankle.power_w + self.hinge.power_w)


def analyse_shoe(
    heel: SensorSignals,
    forefoot: SensorSignals,
    shank: SensorSignals | None = None,
    parameters: ShoeParameters | None = None,
    *,
    calibrations: tuple[LoadCellCalibration, LoadCellCalibration] | None = None,
    q_segment_sensor: tuple[Float, Float, Float] | None = None,
) -> ShoeKinetics:
    """Run the whole method over one shoe, off-line.

    Parameters
    ----------
    heel, forefoot : SensorSignals
        On one even time base, with load cells; bring them there first.
    shank : SensorSignals, optional
        On the lower leg, in segment axes after `q_segment_sensor`; needed for the ankle's power.
    calibrations : pair of LoadCellCalibration, optional
        Heel and forefoot cell, when the files hold voltages: force has outputs 1 to 3, moment 4 to 6.
    q_segment_sensor : three ndarrays, shape (4,), optional
        Mounting of heel, forefoot and shank sensor; identity by default.

    Raises
    ------
    SetupError
        If a cell is missing, time bases differ, or samples are not even.
    ShapeError
        If no stance was found, a cell is never without load, or samples are not finite.
    """
    chosen = parameters or ShoeParameters()
    rate_hz = _common_rate(heel, forefoot, shank)
    mounting = q_segment_sensor or (rotation.identity(), rotation.identity(), rotation.identity())

    def smooth(values: Float) -> Float:
        return low_pass(values, rate_hz, chosen.cutoff_hz, axis=0) if chosen.cutoff_hz > 0.0 else values

    cells, inertial = [], []
    for number, sensor in enumerate((heel, forefoot)):
        if sensor.force_n is None or sensor.moment_nm is None:
            raise SetupError(say("shoes.no_cell", cell=_CELLS[number]))
        load = np.concatenate((sensor.force_n, sensor.moment_nm), axis=1)
        if calibrations is not None:
            load = calibrations[number].apply(load)
        swings = np.linalg.norm(sensor.gyroscope_radps, axis=1) > _SWINGING_RADPS
        in_the_air = unloaded(load[:, :3], chosen.unloaded_n, swings)
        if not is_tareable(in_the_air, swings, rate_hz):
            raise ShapeError(say("shoes.cell_jammed", cell=_CELLS[number]))
        load = smooth(tare(load, in_the_air, rate_hz))
        q = mounting[number]
        cells.append((rotation.rotate(q, load[:, :3]), rotation.rotate(q, load[:, 3:])))
        gyroscope = rotation.rotate(q, smooth(sensor.gyroscope_radps))
        inertial.append((gyroscope, rotation.rotate(q, smooth(sensor.accelerometer_mps2))))
    loads = ShoeLoads(cells[0][0], cells[0][1], cells[1][0], cells[1][1])
    contact = shoe_contact(cells[0][0][:, 2], cells[1][0][:, 2], rate_hz, chosen.contact)
    geometry = chosen.geometry
    pose = shoe_pose(
        inertial[0],
        inertial[1],
        contact,
        rate_hz,
        geometry,
        mode=chosen.position_mode,
        is_level=chosen.is_level,
    )
    floor = 0.0 if chosen.is_level else floor_under(pose, contact, geometry)
    reaction = ground_reaction(loads, pose, floor_m=floor)
    ankle, shank_rate = None, None
    if shank is not None:
        gyroscope = rotation.rotate(mounting[2], smooth(shank.gyroscope_radps))
        accelerometer = rotation.rotate(mounting[2], smooth(shank.accelerometer_mps2))
        shank_rate = segment_rate(
            gyroscope, accelerometer, rate_hz, contact, pose.q_room_heel, chosen.shank_filter
        )
        ankle = ankle_load(reaction, pose, shank_rate, rate_hz, geometry, chosen.foot)
    hinge = hinge_load(reaction, pose, geometry)
    return ShoeKinetics(rate_hz, contact, pose, loads, reaction, ankle, hinge, shank_rate)


def floor_under(pose: ShoePose, contact: ShoeContact, geometry: ShoeGeometry) -> Float:
    """Return the height of the floor under every stance, shape (N,), held from each landing to the next."""
    samples = pose.heel_m.shape[0]
    floor = np.zeros(samples)
    heights = [float(pose.heel_m[a:b, 2].mean()) - geometry.sensor_height_m for a, b in contact.core]
    starts = [0]
    for (_, before), (after, _) in zip(contact.core[:-1], contact.core[1:], strict=True):
        between = contact.land[(contact.land > before) & (contact.land <= after)]
        starts.append(int(between[0]) if between.size else int(after))
    for start, height in zip(starts, heights, strict=True):
        floor[start:] = height
    return floor


def segment_rate(
    gyroscope_radps: Float,
    accelerometer_mps2: Float,
    rate_hz: float,
    contact: ShoeContact,
    q_room_heel: Float,
    estimator: str = "vqf",
) -> Float:
    """Return the turning of the lower leg in the room, shape (N, 3).

    Parameters
    ----------
    gyroscope_radps, accelerometer_mps2 : ndarray, shape (N, 3)
        Segment axes.
    contact : ShoeContact
        At every rest the leg is given the heading of the foot, less the mean that it has there: its own
        heading drifts, for there is no compass.
    q_room_heel : ndarray, shape (N, 4)

    Returns
    -------
    ndarray, shape (N, 3)
        Room axes, gyroscope bias taken out.
    """
    samples = gyroscope_radps.shape[0]
    found = create(estimator, 1, 1.0 / rate_hz).update(
        ImuChunk(
            0,
            1.0 / rate_hz,
            np.ascontiguousarray(gyroscope_radps[None]),
            np.ascontiguousarray(accelerometer_mps2[None]),
            None,
            np.zeros((1, samples), dtype=np.uint8),
        )
    )
    # The very end knows the bias best; a walk is short against its wander.
    bias = found.gyroscope_bias_radps[0, -1]
    x_axis = np.array([1.0, 0.0, 0.0])
    leg = rotation.rotate(found.q_earth_sensor[0], x_axis)
    foot = rotation.rotate(q_room_heel, x_axis)
    apart = np.unwrap(np.arctan2(leg[:, 1], leg[:, 0]) - np.arctan2(foot[:, 1], foot[:, 0]))
    middles = contact.core.mean(axis=1)
    at_rest = np.array([apart[a:b].mean() for a, b in contact.core])
    drift = np.interp(np.arange(samples), middles, at_rest)
    q_room_leg = rotation.multiply(rotation.about_z(-drift), found.q_earth_sensor[0])
    return rotation.rotate(q_room_leg, gyroscope_radps - bias)


def _common_rate(heel: SensorSignals, forefoot: SensorSignals, shank: SensorSignals | None) -> float:
    for other in (forefoot, shank):
        if other is not None and not np.array_equal(other.time_s, heel.time_s):
            raise SetupError(say("shoes.time_bases"))
    steps = np.diff(heel.time_s)
    if steps.size < 20 or np.ptp(steps) > 0.01 * float(np.median(steps)):
        raise SetupError(say("shoes.uneven"))
    return float(1.0 / np.median(steps))
