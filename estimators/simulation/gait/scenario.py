"""One call that makes a walk: a person, a course, two instrumented shoes, their errors, and the exact truth."""

from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from estimators import rotation
from estimators.conventions import SIDES, Side
from estimators.errors import SetupError
from estimators.kinetics import ShoeGeometry
from estimators.recording import Recording, SensorSignals
from estimators.simulation._errors import SensorErrors
from estimators.simulation._sensors import EarthField
from estimators.simulation.arm.kinematics import Path, Turn, cross, rotate
from estimators.simulation.gait.body import UPWARD_MPS2, BodyMotion, move_body, total_of
from estimators.simulation.gait.course import Bout, Footing, Leg, WalkStyle, other, plan
from estimators.simulation.gait.foot import Foot, FootMotion
from estimators.simulation.gait.shoe import ShoeErrors, shoe_errors
from estimators.simulation.gait.truth import FootTruth, GaitTruth, foot_truth, thinned
from estimators.simulation.gait.upper import BodyStyle

Float = NDArray[np.float64]

GAIT_PLACEMENTS: Final = (
    "heel_left",
    "forefoot_left",
    "heel_right",
    "forefoot_right",
    "shank_left",
    "shank_right",
    "pelvis",
    "sternum",
)
"""Sensors of a simulated walk; heel and forefoot have load cells too."""
_LEAST_INTERNAL_HZ = 1000.0


@dataclass(frozen=True)
class GaitScenario:
    """Everything that a simulated walk depends on; the same scenario gives the same bits.

    Attributes
    ----------
    rate_hz : float
        Of the sensors. Motion and forces are computed at a multiple of at least 1000 Hz.
    anti_alias : bool
        Low-pass the sensors' signals at 0.4 of their rate before they are sampled, as devices do.
    errors : ShoeErrors, SensorErrors or str
        A model or the name of one: `ideal`, `shoe_nominal`, `shoe_stress`.
    facing_rad : float
        Heading of the room's x axis, the first direction of walking, in the earth frame.
    mounting_sd_rad : float
        Random turn of every sensor against its segment.
    """

    walk: WalkStyle = field(default_factory=WalkStyle)
    body: BodyStyle = field(default_factory=BodyStyle)
    course: tuple[Bout, ...] = (Bout((Leg(16),)),)
    first_foot: Side = "right"
    shoe: ShoeGeometry = field(default_factory=ShoeGeometry)
    stand_before_s: float = 3.0
    rate_hz: float = 100.0
    anti_alias: bool = True
    errors: ShoeErrors | SensorErrors | str = "shoe_nominal"
    facing_rad: float = 0.0
    earth_field: EarthField = field(default_factory=EarthField)
    has_magnetometer: bool = False
    has_load_cells: bool = True
    mounting_sd_rad: float = 0.0
    seed: int = 0

    def mirrored(self) -> "GaitScenario":
        """Return the same walk of the mirrored person on the mirrored course."""
        course = tuple(
            replace(bout, legs=tuple(replace(leg, turn_rad=-leg.turn_rad) for leg in bout.legs))
            for bout in self.course
        )
        return replace(self, walk=self.walk.mirrored(), course=course, first_foot=other(self.first_foot))


@dataclass(frozen=True)
class SimulatedWalk:
    """A recording as shoes would give it, and the truth beside it."""

    recording: Recording
    truth: GaitTruth


def simulate_gait(scenario: GaitScenario) -> SimulatedWalk:
    """Simulate a whole walk.

    Returns
    -------
    SimulatedWalk
        Sensor axes equal the segment's (foot and forefoot: x to the toes, y left, z up while flat) up to
        `mounting_sd_rad`. Loads are those of the ground on the sensor, about its centre, in its axes.

    Raises
    ------
    SetupError
        If the scenario contradicts itself.

    Notes
    -----
    Follows the analytic generator of the instrumented-shoe protocols (`ankle-dynamics`, section 5.1) with
    mass in the feet, a swaying trunk and pelvis, uneven courses and impaired legs added; see `move_body` for
    how Newton and Euler hold.
    """
    _check(scenario)
    style, rate_hz = scenario.walk, scenario.rate_hz
    every = int(np.ceil(_LEAST_INTERNAL_HZ / rate_hz - 1e-9))
    footing = plan(style, scenario.course, scenario.first_foot, scenario.stand_before_s, scenario.seed)
    ticks = int(np.floor(footing.end_s * rate_hz))
    time_s = np.arange(ticks * every) / (rate_hz * every)
    feet_model = {
        side: Foot(side, footing.stances[side], style.feet[side], scenario.shoe, style.stride_time_s)
        for side in SIDES
    }
    feet = {side: foot.at(time_s) for side, foot in feet_model.items()}
    pressed = {side: _sole_cop(feet[side]) for side in SIDES}
    body = move_body(scenario.body, footing, feet, pressed, style.stride_time_s, time_s)
    loads = {side: _sensor_loads(feet[side], body, side, scenario.shoe) for side in SIDES}
    errors = shoe_errors(scenario.errors, rate_hz)
    q_earth_room = rotation.about_z(scenario.facing_rad)
    field_room_t = rotation.rotate(rotation.conjugate(q_earth_room), scenario.earth_field.earth_t)
    sensors: dict[str, SensorSignals] = {}
    mountings: dict[str, Float] = {}
    stamps = time_s[::every]
    for number, (name, turn, path) in enumerate(_worn(feet, body)):
        # Seeded by role: the leg that steps first has the same draws in the mirrored walk.
        rng = np.random.default_rng([scenario.seed, 22, _role(name, number, scenario.first_foot)])
        q_segment_sensor = rotation.exp(scenario.mounting_sd_rad * rng.normal(size=3))
        mountings[name] = q_segment_sensor
        side = name.rpartition("_")[2]
        load = loads[side].get(name.partition("_")[0]) if side in SIDES else None
        clean = _exact_readings(turn, path, q_segment_sensor, field_room_t, load)
        if scenario.anti_alias and every > 1:
            clean = [_anti_aliased(values, 0.4 / every) for values in clean]
        sensors[name] = _measured(scenario, errors, stamps, [values[::every] for values in clean], rng)
    recording = Recording(
        sensors,
        rate_hz,
        origin="simulation of walking",
        metadata={"seed": str(scenario.seed), "sensor_errors": errors.source},
    )
    truth = _truth(scenario, footing, feet_model, feet, body, loads, mountings, every)
    return SimulatedWalk(recording, truth)


def _exact_readings(
    turn: Turn,
    path: Path,
    q_segment_sensor: Float,
    field_room_t: Float,
    load: tuple[Float, Float] | None,
) -> list[Float]:
    """Return rate, specific force, field and, where loads are, force and moment in sensor axes, (N, 3) each."""
    back = rotation.conjugate(rotation.multiply(turn.q, q_segment_sensor))
    found = [
        rotate(back, turn.rate),
        rotate(back, path.acceleration + UPWARD_MPS2),
        rotate(back, np.broadcast_to(field_room_t, path.position.shape)),
    ]
    if load is not None:
        found += [rotation.rotate(rotation.conjugate(q_segment_sensor), part) for part in load]
    return found


def _measured(
    scenario: GaitScenario, errors: ShoeErrors, stamps_s: Float, exact: list[Float], rng: np.random.Generator
) -> SensorSignals:
    """Return what a sensor with its errors reads."""
    rate, specific, magnetic, *wrench = exact
    inertial = errors.inertial
    measured_rate = inertial.gyroscope.apply(rate, inertial.gyroscope.bias_over(stamps_s, rng), rng)
    measured_force = inertial.accelerometer.apply(
        specific, inertial.accelerometer.bias_over(stamps_s, rng), rng
    )
    measured_field = inertial.magnetometer.apply(
        magnetic, inertial.magnetometer.bias_over(stamps_s, rng), rng
    )
    force = moment = None
    if wrench and scenario.has_load_cells:
        measured = errors.load.apply(stamps_s, np.concatenate(wrench, axis=1), rng)
        force, moment = measured[:, :3], measured[:, 3:]
    field = measured_field if scenario.has_magnetometer else None
    return SensorSignals(stamps_s, measured_rate, measured_force, field, force, moment)


def _role(name: str, number: int, first_foot: Side) -> int:
    side = name.rpartition("_")[2]
    if side not in SIDES:
        return number
    part = ("heel", "forefoot", "shank").index(name.partition("_")[0])
    return 10 + 2 * part + (side == first_foot)


def _check(scenario: GaitScenario) -> None:
    if not 20.0 <= scenario.rate_hz <= 2000.0:
        raise SetupError(f"rate_hz is {scenario.rate_hz}; it must lie between 20 and 2000")
    if scenario.seed < 0:
        raise SetupError(f"seed is {scenario.seed}; it must not be negative")
    if not 0.5 <= scenario.walk.stride_time_s <= 5.0:
        raise SetupError(f"a stride of {scenario.walk.stride_time_s} s; it must take 0.5 to 5 s")
    if 2.0 * scenario.body.foot_mass_kg >= scenario.body.mass_kg:
        raise SetupError("the feet weigh as much as the body; check the masses")


def _sole_cop(foot: FootMotion) -> Float:
    """Return where the foot is pressed, shape (N, 3): along the flat sole, on its floor."""
    along = np.column_stack((np.cos(foot.sole_yaw_rad), np.sin(foot.sole_yaw_rad), np.zeros(foot.flat.size)))
    return np.asarray(foot.sole_floor_m + foot.cop_local_m[:, None] * along)


def _sensor_loads(
    foot: FootMotion, body: BodyMotion, side: Side, shoe: ShoeGeometry
) -> dict[str, tuple[Float, Float]]:
    """Split the load between heel and forefoot plate; force and moment about the sensor in segment axes."""
    forefoot_share = np.clip(foot.cop_local_m / 0.16, 0.0, 1.0)
    force, twist = body.force_n[side], body.free_moment_nm[side]
    along = np.column_stack((np.cos(foot.sole_yaw_rad), np.sin(foot.sole_yaw_rad), np.zeros(twist.size)))
    result = {}
    for name, share, ahead, turn, path in (
        ("heel", 1.0 - forefoot_share, -forefoot_share, foot.heel, foot.heel_sensor),
        ("forefoot", forefoot_share, 1.0 - forefoot_share, foot.forefoot, foot.forefoot_sensor),
    ):
        point = body.cop_m[side] + (shoe.plate_distance_m * ahead)[:, None] * along
        part = share[:, None] * force
        moment = cross(point - path.position, part)
        moment[:, 2] += share * twist
        back = rotation.conjugate(turn.q)
        result[name] = (rotate(back, part), rotate(back, moment))
    return result


def _worn(feet: dict[Side, FootMotion], body: BodyMotion) -> list[tuple[str, Turn, Path]]:
    found: dict[str, tuple[Turn, Path]] = {}
    for side in SIDES:
        foot = feet[side]
        found[f"heel_{side}"] = (foot.heel, foot.heel_sensor)
        found[f"forefoot_{side}"] = (foot.forefoot, foot.forefoot_sensor)
        found[f"shank_{side}"] = (foot.shank, foot.ankle)
    found["pelvis"] = (body.parts["pelvis"].turn, body.parts["pelvis"].centre)
    found["sternum"] = (body.parts["trunk"].turn, body.parts["trunk"].centre)
    return [(name, *found[name]) for name in GAIT_PLACEMENTS]


def _anti_aliased(values: Float, part_of_rate: float) -> Float:
    sections = signal.butter(4, 2.0 * part_of_rate, output="sos")
    return np.asarray(signal.sosfiltfilt(sections, values, axis=0))


def _truth(
    scenario: GaitScenario,
    footing: Footing,
    models: dict[Side, Foot],
    feet: dict[Side, FootMotion],
    body: BodyMotion,
    loads: dict[Side, dict[str, tuple[Float, Float]]],
    mountings: dict[str, Float],
    every: int,
) -> GaitTruth:
    thin = slice(None, None, every)
    feet_truth: dict[Side, FootTruth] = {
        side: foot_truth(models[side], footing.stances[side], feet[side], body, side, loads[side], thin)
        for side in SIDES
    }
    time_s = np.arange(body.com.position[thin].shape[0]) / scenario.rate_hz
    momentum = total_of(
        cross(part.centre.position - body.com.position, part.mass_kg * part.centre.acceleration)
        + part.momentum_rate_nm
        for part in body.parts.values()
    )
    return GaitTruth(
        time_s=time_s,
        feet=feet_truth,
        com=thinned(body.com, thin),
        momentum_rate_nm=momentum[thin],
        mass_kg=scenario.body.mass_kg,
        pelvis=_part(body, "pelvis", thin),
        trunk=_part(body, "trunk", thin),
        step_side=tuple(step[0] for step in footing.steps),
        step_land_s=np.array([step[1] for step in footing.steps]),
        active_s=np.array(footing.active_s),
        q_segment_sensor=mountings,
        facing_rad=scenario.facing_rad,
    )


def _part(body: BodyMotion, name: str, thin: slice) -> tuple[Turn, Path]:
    part = body.parts[name]
    return thinned(part.turn, thin), thinned(part.centre, thin)
