"""Sound recordings drawn at random: movement, device, field, rate and length; nothing in them is to be blamed."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.ndimage import gaussian_filter1d

from estimators import rotation
from estimators.calibration import Hemisphere
from estimators.conventions import GRAVITY_MPS2, PLACEMENTS
from estimators.magnetic import perpendicular_source
from estimators.recording import Float, ImuChunk
from estimators.signals import to_common_ticks
from estimators.simulation import (
    ArmScenario,
    GaitScenario,
    Schedule,
    SensorErrors,
    TriadErrors,
    WalkStyle,
    simulate_arm,
    simulate_gait,
)
from estimators.simulation.coil.motion import relative_motion
from estimators.simulation.coil.scene import relative_scene

_OVER: Final = 4
"""Steps between two samples, over which a device takes the mean."""
_RATES_HZ: Final = (25.0, 32.0, 50.0, 60.0, 64.0, 100.0, 100.0, 120.0, 128.0, 200.0)
_LENGTHS_S: Final = (8.0, 12.0, 20.0, 30.0, 45.0, 90.0, 150.0)
_BY_HAND: Final = ("hand", "swings", "circles", "turns", "hinge", "hardly moves")
MOVES: Final = (*_BY_HAND, *_BY_HAND, "arm", "walk", "module", "module")
"""What moves a sensor; those made here twice as often as a simulated person."""
_SOURCE_MOVES: Final = ("flexion", "hip", "random", "rotation", "shoulder")
"""Of those beside a source: without the walks, in which each step is like the last as no person's is."""
_SCALES: Final = (0.5, 1.0, 3.0)
"""Good, usual and cheap devices, relative to the usual one."""
_SOUND_IRON: Final = 1.0 / 3.0
"""Of the field: so much iron may sit on a device that is sound."""


@dataclass(frozen=True)
class SoundRecording:
    """A recording of sensors that are declared rightly and work.

    Attributes
    ----------
    names : tuple of str
        Of its sensors.
    hemisphere : {"north", "south"}
        Where it was recorded.
    moves : str
        Of `MOVES`.
    is_field_clean : bool
        No iron but what sits on the device, of less than a third of the field: more of it is a magnetometer that nobody
        calibrated, and to say so is right.
    """

    chunk: ImuChunk
    names: tuple[str, ...]
    hemisphere: Hemisphere
    moves: str
    is_field_clean: bool


def sound_recording(seed: int) -> SoundRecording:
    """Draw a recording: 25 to 200 Hz, 8 to 150 s, six axes in one of three, devices good, usual or cheap.

    Parameters
    ----------
    seed : int
        Not negative.

    Returns
    -------
    SoundRecording
        Of a person who moves an arm, walks, or wears a magnetic source, or of one sensor that is moved about.
    """
    generator = np.random.default_rng([seed, 44])
    moves = str(generator.choice(MOVES))
    rate_hz, lasts_s = float(generator.choice(_RATES_HZ)), float(generator.choice(_LENGTHS_S))
    has_field = bool(generator.random() < 2.0 / 3.0)
    device = float(generator.choice(_SCALES))
    if moves == "arm":
        return _arm(generator, rate_hz, device, has_field=has_field)
    if moves == "walk":
        return _walk(generator, rate_hz, device, has_field=has_field)
    if moves == "module":
        return _module(generator, rate_hz, lasts_s)
    return _by_hand(generator, moves, rate_hz, lasts_s, device, has_field=has_field)


def device_errors(scale: float, rate_hz: float) -> SensorErrors:
    """Return the errors of a device so many times as bad as the usual one; noise grows with the rate."""
    noise = scale * np.sqrt(rate_hz / 100.0)
    return SensorErrors(
        TriadErrors(
            (0.003 * noise,) * 3,
            bias_sd=0.008 * scale,
            scale_sd=0.004 * scale,
            cross_axis_sd=0.003 * scale,
            random_walk_per_root_s=4e-5 * scale,
            drift_limit_per_s=2e-5 * scale,
            resolution=1e-3,
            limit=35.0,
        ),
        TriadErrors(
            (0.03 * noise,) * 3,
            bias_sd=0.08 * scale,
            scale_sd=0.005 * scale,
            cross_axis_sd=0.003 * scale,
            resolution=5e-3,
            limit=157.0,
        ),
        TriadErrors(
            (0.4e-6 * scale,) * 3,
            bias_sd=1.5e-6 * scale,
            scale_sd=0.01 * scale,
            cross_axis_sd=0.008 * scale,
            resolution=1.5e-7,
            limit=1e-3,
        ),
    )


def _by_hand(
    generator: np.random.Generator,
    moves: str,
    rate_hz: float,
    lasts_s: float,
    device: float,
    *,
    has_field: bool,
) -> SoundRecording:
    """Move one sensor about."""
    step_s = 1.0 / (rate_hz * _OVER)
    time_s = np.asarray(step_s * np.arange(round(lasts_s * rate_hz) * _OVER), dtype=np.float64)
    q, place = _motion(generator, moves, time_s, step_s)
    push = np.gradient(np.gradient(place, step_s, axis=0), step_s, axis=0)
    back = rotation.conjugate(q)
    steps = rotation.log(rotation.multiply(back[:-1], q[1:])) / step_s
    steps = np.vstack((steps[:1], steps))
    force = rotation.rotate(back, push + np.array([0.0, 0.0, GRAVITY_MPS2]))
    is_north = bool(generator.random() < 0.8)
    dip = np.radians(generator.uniform(25.0, 78.0)) * (1.0 if is_north else -1.0)
    field = float(generator.uniform(30e-6, 60e-6)) * np.array([0.0, np.cos(dip), -np.sin(dip)])
    is_clean = bool(generator.random() < 0.6)
    around = np.tile(field, (len(q), 1))
    if not is_clean:
        around += _iron(generator, time_s, step_s)
    errors = device_errors(device, rate_hz)
    readings = []
    for triad, true in (
        (errors.gyroscope, _mean(steps)),
        (errors.accelerometer, _mean(force)),
        (errors.magnetometer, rotation.rotate(back, around)[_OVER - 1 :: _OVER]),
    ):
        bias = triad.bias_over(time_s[_OVER - 1 :: _OVER], generator)
        if triad is errors.magnetometer:
            is_clean &= float(np.linalg.norm(bias.mean(axis=0))) < _SOUND_IRON * float(np.linalg.norm(field))
        readings.append(triad.apply(true, bias, generator)[None])
    quality = np.zeros((1, len(readings[0][0])), np.uint8)
    gyroscope, accelerometer, magnetometer = readings
    chunk = ImuChunk(0, 1.0 / rate_hz, gyroscope, accelerometer, magnetometer if has_field else None, quality)
    name = str(generator.choice(PLACEMENTS))
    return SoundRecording(chunk, (name,), "north" if is_north else "south", moves, is_clean or not has_field)


def _motion(generator: np.random.Generator, moves: str, time_s: Float, step_s: float) -> tuple[Float, Float]:
    """Return attitude and place in the earth frame."""
    effort = _effort(generator, time_s, step_s)
    mounting = rotation.normalize(generator.normal(size=4))
    length_m = generator.uniform(0.2, 0.8)
    if moves in ("hand", "turns", "hardly moves"):
        speed = generator.choice([0.5, 1.4, 2.6, 5.0]) * (0.1 if moves == "hardly moves" else 1.0)
        rate = _wander(generator, time_s, step_s, generator.choice([0.15, 0.3, 0.6])) * effort[:, None]
        turned = rotation.running_product(rotation.exp(speed / np.sqrt(3.0) * step_s * rate))
        # Who hardly turns does not go far either.
        reach_m = {"turns": 0.0, "hand": generator.choice([0.03, 0.1, 0.2]), "hardly moves": 0.01}[moves]
        place = reach_m * effort[:, None] * _wander(generator, time_s, step_s, 0.4)
        return rotation.multiply(mounting, turned), place
    pace = 2.0 * np.pi * generator.uniform(0.2, 1.0)
    about = pace * time_s + 0.6 * _wander(generator, time_s, step_s, 2.0)[:, 0]
    size = np.radians(generator.uniform(15.0, 60.0)) * effort
    aside = {"hinge": 0.0, "swings": generator.uniform(0.0, 0.4), "circles": 1.0}[moves]
    twist = 0.0 if moves == "hinge" else generator.uniform(0.0, 0.8)
    limb = rotation.about_z(np.full(len(time_s), generator.uniform(-np.pi, np.pi)))
    for angle, axis in (
        (size * np.sin(about), 1),
        (aside * size * np.cos(about), 0),
        (twist * size * np.sin(0.7 * about), 2),
    ):
        limb = rotation.multiply(limb, rotation.exp(angle[:, None] * np.eye(3)[axis]))
    # A device sits along the limb as often as it sits anyhow.
    if generator.random() < 0.5:
        mounting = np.array([1.0, 0.0, 0.0, 0.0])
    place = rotation.rotate(limb, np.array([0.0, 0.0, -length_m]))
    return rotation.multiply(limb, mounting), place


def _effort(generator: np.random.Generator, time_s: Float, step_s: float) -> Float:
    """Return how much is moved, 0 to 1: from the beginning or after a rest, in bouts or on and on."""
    effort, at = np.zeros(len(time_s)), float(generator.choice([-5.0, 0.5, 2.0, 5.0]))
    while at < time_s[-1]:
        stop = at + generator.uniform(3.0, 25.0)
        effort[(time_s >= at) & (time_s < stop)] = 1.0
        at = stop + generator.choice([0.0, generator.uniform(0.5, 8.0)])
    return np.asarray(gaussian_filter1d(effort, 0.2 / step_s))


def _wander(generator: np.random.Generator, time_s: Float, step_s: float, over_s: float) -> Float:
    """Return a smooth random course of three numbers of about unit size."""
    width = over_s / step_s
    margin = round(5.0 * width)
    course = gaussian_filter1d(generator.normal(size=(len(time_s) + 2 * margin, 3)), width, axis=0)
    return np.asarray(course[margin : margin + len(time_s)] * np.sqrt(2.0 * np.sqrt(np.pi) * width))


def _iron(generator: np.random.Generator, time_s: Float, step_s: float) -> Float:
    """Return what iron adds to the field: everywhere another, or in passing."""
    if generator.random() < 0.5:
        return generator.uniform(1e-6, 6e-6) * _wander(generator, time_s, step_s, 3.0)
    added = np.zeros((len(time_s), 3))
    for _ in range(int(generator.integers(1, 4))):
        size = generator.uniform(4e-6, 25e-6) * _unit(generator)
        begun, lasts_s = generator.uniform(0.0, time_s[-1]), generator.uniform(1.0, 10.0)
        added += size * np.exp(-(((time_s - begun) / lasts_s) ** 2))[:, None]
    return added


def _unit(generator: np.random.Generator) -> Float:
    direction = generator.normal(size=3)
    return np.asarray(direction / np.linalg.norm(direction))


def _mean(values: Float) -> Float:
    return np.asarray(values.reshape(-1, _OVER, 3).mean(axis=1))


def _arm(generator: np.random.Generator, rate_hz: float, device: float, *, has_field: bool) -> SoundRecording:
    made = simulate_arm(
        ArmScenario(
            exercise=str(generator.choice(["reaching", "drinking", "abduction", "flexion", "pronation"])),
            placements=("sternum", "upper_arm_right", "forearm_right"),
            schedule=Schedule(
                n_pose_s=float(generator.choice([0.5, 2.0])), repetitions=int(generator.integers(1, 6))
            ),
            rate_hz=rate_hz,
            facing_rad=generator.uniform(-np.pi, np.pi),
            errors=device_errors(device, rate_hz),
            has_magnetometer=has_field,
            seed=int(generator.integers(1 << 31)),
        )
    )
    chunk = to_common_ticks(made.recording, rate_hz)
    return SoundRecording(chunk, tuple(made.recording.sensors), "north", "arm", is_field_clean=True)


def _walk(
    generator: np.random.Generator, rate_hz: float, device: float, *, has_field: bool
) -> SoundRecording:
    rate_hz = max(rate_hz, 50.0)
    made = simulate_gait(
        GaitScenario(
            walk=WalkStyle(stride_length_sd_m=0.05, stride_time_sd_s=0.03),
            rate_hz=rate_hz,
            stand_before_s=float(generator.choice([1.5, 3.0])),
            errors=device_errors(device, rate_hz),
            facing_rad=generator.uniform(-np.pi, np.pi),
            has_magnetometer=has_field,
            has_load_cells=False,
            mounting_sd_rad=0.2,
            seed=int(generator.integers(1 << 31)),
        )
    )
    chunk = to_common_ticks(made.recording, rate_hz)
    return SoundRecording(chunk, tuple(made.recording.sensors), "north", "walk", is_field_clean=True)


def _module(generator: np.random.Generator, rate_hz: float, lasts_s: float) -> SoundRecording:
    """Sensor and source of a magnetic session between the pulses."""
    rate_hz, seed = max(rate_hz, 50.0), int(generator.integers(1 << 31))
    motion = relative_motion(str(generator.choice(_SOURCE_MOVES)), lasts_s, seed)
    made = relative_scene(perpendicular_source(), motion, lasts_s, rate_hz, seed=seed)
    triads = (
        (made.source_gyroscope_radps, made.gyroscope_radps),
        (made.source_accelerometer_mps2, made.accelerometer_mps2),
        (made.source_ambient_t, made.ambient_t),
    )
    gyroscope, accelerometer, magnetometer = (np.stack(pair) for pair in triads)
    quality = np.zeros(gyroscope.shape[:2], np.uint8)
    chunk = ImuChunk(0, made.time_step_s, gyroscope, accelerometer, magnetometer, quality)
    return SoundRecording(chunk, ("pelvis", "upper_arm_left"), "north", "module", is_field_clean=True)
