"""A person who stands, sways and reaches as one stiff link on the ankles, with sensors on pelvis and chest."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import scipy

from estimators import rotation
from estimators.body import ANKLE_HEIGHT_PER_STATURE, HIP_HEIGHT_PER_STATURE, BodyDimensions
from estimators.conventions import GRAVITY_MPS2, Placement
from estimators.recording import Float, Recording, SensorSignals
from estimators.simulation._errors import SensorErrors, sensor_errors
from estimators.simulation._sensors import EarthField, Mounting

BEFORE_S: Final = 10.0
"""Still at the beginning: the pose from which sensors are calibrated."""
_FADE_S: Final = 2.0
_HIGHEST_HZ: Final = 2.5
_HALF_STEP_S: Final = 1e-3
"""Of the differences that give acceleration: their error is below 1e-6 m/s^2 for this sway."""


@dataclass(frozen=True)
class Stance:
    """Quiet standing: lean is a stationary normal process in both planes.

    Attributes
    ----------
    forward_rad, left_rad : float
        Standard deviation of the lean.
    corner_hz : float
        Its power is `1 / (1 + (f / corner)^2)^2` below 2.5 Hz, and nothing above.
    """

    seconds: float = 30.0
    forward_rad: float = 0.006
    left_rad: float = 0.004
    corner_hz: float = 0.4

    @property
    def duration_s(self) -> float:
        """How long it lasts."""
        return self.seconds

    def power(self, frequency_hz: Float) -> Float:
        """Return the spectral density of the lean for a variance of 1, 1/Hz."""
        density = np.where(
            frequency_hz <= _HIGHEST_HZ, (1.0 + (frequency_hz / self.corner_hz) ** 2) ** -2.0, 0.0
        )
        fine = np.linspace(0.0, _HIGHEST_HZ, 20_001)
        whole = np.trapezoid((1.0 + (fine / self.corner_hz) ** 2) ** -2.0, fine)
        return np.asarray(density / whole)


def expected_measures(stance: Stance, sensor_height_m: float, height_m: float) -> dict[str, float]:
    """Return what `estimators.balance.sway.sway_measures` would find of endless standing, in closed form.

    Parameters
    ----------
    sensor_height_m, height_m : float
        Of the sensor and of the point of which displacement is given, above the ankles.

    Notes
    -----
    The levelled acceleration of a stiff link is `-(g + h w^2)` times its lean, so that every variance is an integral
    over the spectrum of the lean. The mean length of a normal vector with deviations s > t is
    `s sqrt(2 / pi) E(1 - t^2 / s^2)`, with the complete elliptic integral E.
    """
    frequency = np.linspace(0.0, _HIGHEST_HZ, 20_001)
    omega, power = 2.0 * np.pi * frequency, stance.power(frequency)
    sides = np.array([stance.forward_rad, stance.left_rad])
    gain = (GRAVITY_MPS2 + sensor_height_m * omega**2) ** 2
    pushed, jerked, moved = (
        math.sqrt(np.trapezoid(one * power, frequency)) for one in (gain, gain * omega**2, omega**2)
    )
    small, large = np.sort(height_m * moved * sides)
    shown = frequency >= 0.15
    below = np.cumsum((gain * power)[shown])
    median, high = np.interp([0.5, 0.95], below / below[-1], frequency[shown])
    return {
        "acceleration_rms": pushed * float(np.linalg.norm(sides)),
        "acceleration_rms_forward": pushed * stance.forward_rad,
        "acceleration_rms_sideways": pushed * stance.left_rad,
        "jerk_rms": jerked * float(np.linalg.norm(sides)),
        "median_frequency": float(median),
        "frequency_95": float(high),
        "displacement_rms_forward": height_m * stance.forward_rad,
        "displacement_rms_sideways": height_m * stance.left_rad,
        "sway_speed": large
        * math.sqrt(2.0 / math.pi)
        * float(scipy.special.ellipe(1.0 - (small / large) ** 2)),
        "ellipse_area": -2.0 * math.log(0.05) * math.pi * height_m**2 * float(np.prod(sides)),
    }


@dataclass(frozen=True)
class Lean:
    """A functional reach: upright for a second and a half, forward, held, and back."""

    angle_rad: float = 0.25
    move_s: float = 1.5
    hold_s: float = 1.0

    @property
    def duration_s(self) -> float:
        """How long it lasts."""
        return 1.5 + 2.0 * self.move_s + self.hold_s + 0.5


@dataclass(frozen=True)
class StandingPerson:
    """What `simulate_standing` made.

    Attributes
    ----------
    trials_s : tuple of (float, float)
        Half-open time of each trial.
    lean_rad : ndarray, shape (N, 2)
        True lean forward and left at the samples.
    height_m : mapping of Placement to float
        Of each sensor above the ankles.
    """

    recording: Recording
    trials_s: tuple[tuple[float, float], ...]
    lean_rad: Float
    height_m: dict[Placement, float]


def _measured(
    model: SensorErrors,
    time_s: Float,
    q_before: Float,
    q_now: Float,
    acceleration_mps2: Float,
    rate_hz: float,
    rng: np.random.Generator,
) -> SensorSignals:
    """Return what a sensor reads that turned from one orientation to the other in each step, shape (K, 4) both."""
    rate = rotation.log(rotation.multiply(rotation.conjugate(q_before), q_now))
    back = rotation.conjugate(q_now)
    force = rotation.rotate(back, acceleration_mps2 + np.array([0.0, 0.0, GRAVITY_MPS2]))
    field = rotation.rotate(back, EarthField().earth_t)
    return SensorSignals(
        time_s,
        model.gyroscope.apply(rate * rate_hz, model.gyroscope.bias_over(time_s, rng), rng),
        model.accelerometer.apply(force, model.accelerometer.bias_over(time_s, rng), rng),
        model.magnetometer.apply(field, model.magnetometer.bias_over(time_s, rng), rng),
    )


def simulate_standing(
    trials: Sequence[Stance | Lean],
    seed: int,
    *,
    placements: tuple[Placement, ...] = ("pelvis", "sternum"),
    errors: SensorErrors | str = "nominal",
    rate_hz: float = 100.0,
    body: BodyDimensions | None = None,
    facing_rad: float = 0.4,
) -> StandingPerson:
    """Return what sensors on a standing person measure, with exact truth.

    Parameters
    ----------
    trials : sequence of Stance or Lean
        One after the other, four seconds between them; before them ten seconds without sway.
    placements : tuple of Placement
        `pelvis`, `sternum` or both.
    facing_rad : float
        Heading of the person, from east.

    Notes
    -----
    A stance is a sum of sinusoids with normal amplitudes, three in each step of frequency that the trial can
    separate: its moments over many seeds are those of the spectrum.
    """
    body = body or BodyDimensions()
    model = sensor_errors(errors)
    rng = np.random.default_rng([seed, 71])
    courses, spans, start = [], [], BEFORE_S
    for trial in trials:
        courses.append(_course(trial, start, rng))
        spans.append((start, start + trial.duration_s))
        start += trial.duration_s + 2.0 * _FADE_S
    time = np.arange(round(start * rate_hz)) / rate_hz

    def lean_at(at: Float) -> Float:
        return np.asarray(sum((course(at) for course in courses), np.zeros((len(at), 2))))

    def turn_at(at: Float) -> Float:
        forward, left = lean_at(at).T
        return rotation.multiply(
            rotation.about_z(facing_rad),
            # The angles of `posture`: inclination in each plane, not one turn after the other.
            rotation.shortest(
                np.array([0.0, 0.0, 1.0]),
                np.stack([np.tan(forward), np.tan(left), np.ones_like(left)], axis=-1),
            ),
        )

    sensors: dict[str, SensorSignals] = {}
    heights: dict[Placement, float] = {}
    # It turns about the ankles: what is above the floor and below them does not sway.
    hip = (HIP_HEIGHT_PER_STATURE - ANKLE_HEIGHT_PER_STATURE) * body.stature_m
    before, now, after = (turn_at(time + shift) for shift in (-_HALF_STEP_S, 0.0, _HALF_STEP_S))
    last = turn_at(time - 1.0 / rate_hz)
    for number, placement in enumerate(placements):
        q_segment_sensor, offset = Mounting().draw(placement, body, seed)
        arm = np.array([0.0, 0.0, hip]) + offset
        heights[placement] = float(arm[2])
        acceleration = (
            rotation.rotate(before, arm) - 2.0 * rotation.rotate(now, arm) + rotation.rotate(after, arm)
        ) / _HALF_STEP_S**2
        turns = rotation.multiply(last, q_segment_sensor), rotation.multiply(now, q_segment_sensor)
        own = np.random.default_rng([seed, 72, number])
        sensors[placement] = _measured(model, time, *turns, acceleration, rate_hz, own)
    recording = Recording(sensors, rate_hz, origin="simulation", metadata={"seed": str(seed)})
    return StandingPerson(recording, tuple(spans), lean_at(time), heights)


def _course(trial: Stance | Lean, start_s: float, rng: np.random.Generator) -> Callable[[Float], Float]:
    """Return a function from time to the lean (N, 2) that one trial adds."""
    stop_s = start_s + trial.duration_s
    if isinstance(trial, Lean):
        rise = start_s + 1.5
        fall = rise + trial.move_s + trial.hold_s

        def leaned(at: Float) -> Float:
            share = _smooth_step((at - rise) / trial.move_s) - _smooth_step((at - fall) / trial.move_s)
            return np.stack([trial.angle_rad * share, np.zeros_like(at)], axis=-1)

        return leaned
    step = 1.0 / (3.0 * trial.duration_s)
    frequency = np.arange(0.5, math.ceil(_HIGHEST_HZ / step)) * step
    spread = np.sqrt(trial.power(frequency) * step)
    size = np.array([trial.forward_rad, trial.left_rad])
    cosine, sine = rng.normal(size=(2, len(frequency), 2)) * spread[:, None] * size

    def swayed(at: Float) -> Float:
        near = (at > start_s - _FADE_S) & (at < stop_s + _FADE_S)
        found = np.zeros((len(at), 2))
        phase = 2.0 * np.pi * np.outer(at[near] - start_s, frequency)
        window = _smooth_step((at[near] - start_s) / _FADE_S + 1.0) - _smooth_step(
            (at[near] - stop_s) / _FADE_S
        )
        found[near] = window[:, None] * (np.cos(phase) @ cosine + np.sin(phase) @ sine)
        return found

    return swayed


def _smooth_step(share: Float) -> Float:
    """Return minimum jerk from 0 to 1."""
    s = np.clip(share, 0.0, 1.0)
    return np.asarray(s**3 * (10.0 - 15.0 * s + 6.0 * s**2))
