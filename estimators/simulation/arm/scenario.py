"""One call that makes a session: a person, an exercise, sensors, their errors, and the exact truth."""

from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from estimators import rotation
from estimators.arm import ArmModel
from estimators.body import BodyDimensions
from estimators.conventions import PLACEMENTS, Placement, Side
from estimators.errors import SetupError
from estimators.leg import LegModel
from estimators.orientation import DEFAULT
from estimators.pipelines._contract import FrameLayout, Frames, SessionSetup
from estimators.recording import Recording, SensorSignals
from estimators.simulation._errors import SensorErrors, sensor_errors
from estimators.simulation._sensors import EarthField, Magnet, Mounting, TrueReadings, true_readings
from estimators.simulation._soft_tissue import soft_tissue_turn
from estimators.simulation.arm.body import MovingBody, SegmentMotion
from estimators.simulation.arm.exercises import EXERCISES, LEG_EXERCISES, Exercise
from estimators.simulation.arm.kinematics import Path, Scalar, Turn, compose
from estimators.simulation.arm.movements import (
    MovementStyle,
    Performance,
    Schedule,
    perform,
)

Float = NDArray[np.float64]

ARM_PLACEMENTS: Final[tuple[Placement, ...]] = (
    "sternum",
    "upper_arm_left",
    "forearm_left",
    "hand_left",
    "upper_arm_right",
    "forearm_right",
    "hand_right",
)
"""The seven sensors of two arms and the trunk."""


def leg_placements(side: Side) -> tuple[Placement, ...]:
    """Return the five sensors of the trunk and one leg."""
    legs: dict[Side, tuple[Placement, ...]] = {
        "left": ("thigh_left", "shank_left", "foot_left"),
        "right": ("thigh_right", "shank_right", "foot_right"),
    }
    return ("sternum", "pelvis", *legs[side])


_KNOWN: Final = {**EXERCISES, **LEG_EXERCISES}


@dataclass(frozen=True)
class SensorClocks:
    """How the sensors' sampling departs from the common tick; each draw is once a sensor but for jitter.

    The devices *stamp* their samples evenly; the body is sampled at the true instants
    `stamp * (1 + skew) + offset + jitter`.
    """

    skew_sd: float = 0.0
    offset_sd_s: float = 0.0
    jitter_sd_s: float = 0.0

    @property
    def is_common(self) -> bool:
        """Whether all sensors sample exactly at the ticks."""
        return self.skew_sd == 0.0 and self.offset_sd_s == 0.0 and self.jitter_sd_s == 0.0


@dataclass(frozen=True)
class ArmScenario:
    """Everything that a simulated arm session depends on; the same scenario gives the same bits.

    Attributes
    ----------
    exercise : str or Exercise
        `reaching`, `drinking`, `abduction`, `flexion` or `pronation`, of a leg `knee_extension` or `leg_raise`, or one
        of one's own.
    side : Side
        The acting side. The other arm hangs with a small sway, or mirrors it when `both_arms`; the other leg rests.
    schedule : Schedule
        N-pose, pauses, number of repetitions or total duration.
    placements : tuple of Placement
        Worn sensors, any of the seventeen, in network order.
    facing_rad : float
        Where the patient faces: heading of the room's x axis in the earth frame, counter-clockwise from east.
    errors : SensorErrors or str
        A model or the name of a preset: `ideal`, `nominal`, `marzouk_2009`.
    sway_rad, n_pose_error_rad : float
        Wander while standing; how far each joint is off the exact N-pose (standard deviation).
    seed : int
        Not negative.
    """

    exercise: str | Exercise = "reaching"
    side: Side = "right"
    both_arms: bool = False
    style: MovementStyle = field(default_factory=MovementStyle)
    schedule: Schedule = field(default_factory=Schedule)
    body: BodyDimensions = field(default_factory=BodyDimensions)
    placements: tuple[Placement, ...] = ARM_PLACEMENTS
    rate_hz: float = 100.0
    facing_rad: float = 0.6
    earth_field: EarthField = field(default_factory=EarthField)
    errors: SensorErrors | str = "nominal"
    mounting: Mounting = field(default_factory=Mounting)
    magnets: tuple[Magnet, ...] = ()
    clocks: SensorClocks = field(default_factory=SensorClocks)
    has_magnetometer: bool = True
    sway_rad: float = 0.003
    n_pose_error_rad: float = 0.0
    orientation: str = DEFAULT
    seed: int = 0


@dataclass(frozen=True)
class ArmTruth:
    """What really happened, on the ticks of the session.

    Attributes
    ----------
    frames : Frames
        Segment orientations, joint centres, joint angles and scalars under the pipeline's names, exact;
        all seventeen segments, both arms, where a leg acts both legs, sigmas zero.
    repetitions_s : ndarray, shape (R, 2)
        Start and end of each repetition, on ticks.
    progress : ndarray, shape (K,)
        How far in the cycle, in pieces: move, hold, move, ... return. Of a move the share of the way, of a hold that of
        its time. NaN outside repetitions and in those that are another movement.
    q_sensor_segment : dict of Placement to ndarray, shape (4,)
        True mounting, to be compared with a calibration.
    q_earth_sensor : ndarray, shape (S, K, 4)
        In the order of the scenario's placements.
    gyroscope_bias_radps : ndarray, shape (S, K, 3)
    sensor_room_m : ndarray, shape (S, K, 3)
        Position of the sensors.
    sensor_velocity_mps, sensor_acceleration_mps2 : ndarray, shape (S, K, 3)
        Of the sensors, in the room.
    """

    frames: Frames
    repetitions_s: Float
    progress: Float
    q_sensor_segment: dict[Placement, Float]
    q_earth_sensor: Float
    gyroscope_bias_radps: Float
    sensor_room_m: Float
    sensor_velocity_mps: Float
    sensor_acceleration_mps2: Float
    facing_rad: float

    @property
    def time_s(self) -> Float:
        """Session time of the ticks, shape (K,)."""
        return self.frames.time_s

    def angle_rad(self, name: str) -> Float:
        """Return one joint angle or scalar by its column name, shape (K,)."""
        layout = self.frames.layout
        if name in layout.angles:
            return self.frames.angle_rad[:, layout.angles.index(name)]
        return self.frames.scalar[:, layout.scalars.index(name)]

    def point_room_m(self, name: str) -> Float:
        """Return one joint centre by name, shape (K, 3)."""
        return self.frames.point_room_m[:, self.frames.layout.points.index(name)]


@dataclass(frozen=True)
class SimulatedSession:
    """A recording as the network would give it, the truth beside it, and the setup to process it with."""

    recording: Recording
    truth: ArmTruth
    setup: SessionSetup


def simulate_arm(scenario: ArmScenario) -> SimulatedSession:
    """Simulate a whole session.

    Returns
    -------
    SimulatedSession
        The setup has no calibration: the recording starts with `schedule.n_pose_s` of N-pose for that.

    Raises
    ------
    SetupError
        If the scenario contradicts itself.
    """
    _check(scenario)
    exercise = _KNOWN[scenario.exercise] if isinstance(scenario.exercise, str) else scenario.exercise
    performance = perform(
        exercise,
        scenario.style,
        scenario.schedule,
        both_arms=scenario.both_arms,
        sway_rad=scenario.sway_rad,
        n_pose_error_rad=scenario.n_pose_error_rad,
        seed=scenario.seed,
    )
    person = MovingBody(scenario.body, performance.timeline, scenario.side, scenario.sway_rad, scenario.seed)
    ticks = round(performance.end_s * scenario.rate_hz)
    # One instant before the first tick, for the mean rate of the first gyroscope sample.
    instants = np.arange(-1, ticks) / scenario.rate_hz
    motions, coordinates = person.at(instants), person.coordinates(instants)
    q_earth_room = rotation.about_z(scenario.facing_rad)
    field_room_t = rotation.rotate(rotation.conjugate(q_earth_room), scenario.earth_field.earth_t)
    sensors: dict[str, SensorSignals] = {}
    mountings: dict[Placement, Float] = {}
    q_earth, biases, paths = [], [], []
    for placement in scenario.placements:
        q_segment_sensor, offset_m = scenario.mounting.draw(placement, scenario.body, scenario.seed)
        mountings[placement] = rotation.conjugate(q_segment_sensor)
        at, moving = instants, _on_skin(scenario, placement, motions[placement], coordinates)
        exact = _readings(moving, at, q_segment_sensor, offset_m, field_room_t, scenario.magnets)
        q_earth.append(rotation.multiply(q_earth_room, exact.q_room_sensor))
        paths.append(exact.path)
        if not scenario.clocks.is_common:
            at = _sample_times(scenario, placement, instants)
            moving = _on_skin(scenario, placement, person.at(at)[placement], person.coordinates(at))
            exact = _readings(moving, at, q_segment_sensor, offset_m, field_room_t, scenario.magnets)
        sensors[placement], bias = _measured(scenario, placement, exact, instants[1:])
        biases.append(bias)
    metadata = {
        "exercise": exercise.name,
        "side": scenario.side,
        "seed": str(scenario.seed),
        "sensor_errors": sensor_errors(scenario.errors).source,
    }
    recording = Recording(sensors, scenario.rate_hz, origin="simulation", metadata=metadata)
    position, velocity, acceleration = (np.stack([path[order] for path in paths]) for order in range(3))
    truth = ArmTruth(
        _true_frames(scenario, motions, ticks, exercise.moves_leg),
        _on_ticks(performance, scenario.rate_hz),
        performance.progress(instants[1:]),
        mountings,
        np.stack(q_earth),
        np.stack(biases),
        position,
        velocity,
        acceleration,
        scenario.facing_rad,
    )
    setup = SessionSetup(
        "arm", scenario.placements, scenario.rate_hz, orientation=scenario.orientation, body=scenario.body
    )
    return SimulatedSession(recording, truth, setup)


def _check(scenario: ArmScenario) -> None:
    if isinstance(scenario.exercise, str) and scenario.exercise not in _KNOWN:
        raise SetupError(f"no exercise is named {scenario.exercise!r}; known: {', '.join(_KNOWN)}")
    unknown = [name for name in scenario.placements if name not in PLACEMENTS]
    if unknown or not scenario.placements or len(set(scenario.placements)) != len(scenario.placements):
        raise SetupError(f"placements {scenario.placements} must be different ones of {PLACEMENTS}")
    if not 5.0 <= scenario.rate_hz <= 5000.0:
        raise SetupError(f"rate_hz is {scenario.rate_hz}; it must lie between 5 and 5000")
    if scenario.seed < 0:
        raise SetupError(f"seed is {scenario.seed}; it must not be negative")


def _measured(
    scenario: ArmScenario, placement: Placement, exact: TrueReadings, stamps_s: Float
) -> tuple[SensorSignals, Float]:
    """Return what a sensor with its errors reads, and the bias of its gyroscope, shape (K, 3)."""
    errors = sensor_errors(scenario.errors)
    rng = np.random.default_rng([scenario.seed, 7, PLACEMENTS.index(placement)])
    rate = exact.mean_rate_radps if errors.gyroscope_sampling == "mean" else exact.rate_radps
    bias = errors.gyroscope.bias_over(stamps_s, rng)
    gyroscope = errors.gyroscope.apply(rate, bias, rng)
    accelerometer = errors.accelerometer.apply(
        exact.specific_force_mps2, errors.accelerometer.bias_over(stamps_s, rng), rng
    )
    magnetometer = errors.magnetometer.apply(exact.field_t, errors.magnetometer.bias_over(stamps_s, rng), rng)
    field = magnetometer if scenario.has_magnetometer else None
    return SensorSignals(stamps_s, gyroscope, accelerometer, field), bias


def _readings(
    moving: SegmentMotion,
    at: Float,
    q_segment_sensor: Float,
    offset_m: Float,
    field_room_t: Float,
    magnets: tuple[Magnet, ...],
) -> TrueReadings:
    """Drop the leading instant, which only serves the mean rate."""
    turn, origin = moving.turn, moving.origin
    now = SegmentMotion(
        Turn(turn.q[1:], turn.rate[1:], turn.acceleration[1:]),
        Path(origin.position[1:], origin.velocity[1:], origin.acceleration[1:]),
    )
    return true_readings(
        now, turn.q[:-1], at[1:], np.diff(at), q_segment_sensor, offset_m, field_room_t, magnets
    )


def _on_skin(
    scenario: ArmScenario, placement: Placement, moving: SegmentMotion, coordinates: dict[str, Scalar]
) -> SegmentMotion:
    """Return the motion of the skin under a sensor: the bone's, and soft tissue on top."""
    skin = soft_tissue_turn(
        placement, coordinates, scenario.side, scenario.mounting.soft_tissue_rad, scenario.seed
    )
    return moving if skin is None else SegmentMotion(compose(moving.turn, skin), moving.origin)


def _sample_times(scenario: ArmScenario, placement: Placement, instants: Float) -> Float:
    rng = np.random.default_rng([scenario.seed, 8, PLACEMENTS.index(placement)])
    skew, offset_s = rng.normal(size=2) * (scenario.clocks.skew_sd, scenario.clocks.offset_sd_s)
    # Beyond 0.4 of a step neighbouring samples could swap.
    jitter = np.clip(
        rng.normal(size=instants.size) * scenario.clocks.jitter_sd_s,
        -0.4 / scenario.rate_hz,
        0.4 / scenario.rate_hz,
    )
    return np.asarray(instants * (1.0 + skew) + offset_s + jitter)


def _on_ticks(performance: Performance, rate_hz: float) -> Float:
    return np.asarray(np.round(performance.repetitions_s * rate_hz) / rate_hz)


def _true_frames(
    scenario: ArmScenario, motions: dict[str, SegmentMotion], ticks: int, moves_leg: bool
) -> Frames:
    model = ArmModel(scenario.body, PLACEMENTS, 1.0 / scenario.rate_hz)
    q = np.stack([motions[name].turn.q[1:] for name in PLACEMENTS], axis=1)
    omega = np.stack([motions[name].turn.rate[1:] for name in PLACEMENTS], axis=1)
    legs, exact = LegModel(PLACEMENTS if moves_leg else ()), np.zeros_like(omega)
    found = model.evaluate(
        q, angular_velocity_room_radps=omega, sigma_room_rad=exact, more_angles=len(legs.angles)
    )
    flags = np.zeros((ticks, len(PLACEMENTS)), dtype=np.uint8)
    legs.write(q, exact, flags, found.angle_rad, found.angle_sigma_rad, found.angle_flags)
    return Frames(
        layout=FrameLayout(tuple(PLACEMENTS), model.points, (*model.angles, *legs.angles), model.scalars),
        first_tick=0,
        time_step_s=1.0 / scenario.rate_hz,
        q_room_segment=q,
        point_room_m=found.point_room_m,
        angle_rad=found.angle_rad,
        angle_sigma_rad=found.angle_sigma_rad,
        scalar=found.scalar,
        segment_flags=flags,
        angle_flags=found.angle_flags,
    )
