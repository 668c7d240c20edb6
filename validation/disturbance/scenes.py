"""Sensors, iron and scores of Roetenberg (2006), chapters 2 and 3, as the orientation method page has them (4.2).

Earth here is x east, y north, z up; the page has x north. The field is in units of the undisturbed one.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from estimators import orientation, rotation
from estimators.conventions import GRAVITY_MPS2
from estimators.recording import Float, ImuChunk

STEP_S = 0.01
DIP_RAD = float(np.radians(67.0))
FIELD = np.array([0.0, np.cos(DIP_RAD), -np.sin(DIP_RAD)])
FIELD_T = 49e-6
GYROSCOPE_SD_RADPS = 0.01
ACCELEROMETER_SD_MPS2 = 0.1
MAGNETOMETER_SD = 0.001
OFFSET_WALK_RADPS = float(np.radians(0.3e-3))
RAMP_RADPS2 = float(np.radians(0.1 / 60.0))
IRON_DENSITY = 7870.0
ELONGATED = 2.5
ZEROED_RADPS = float(np.radians(0.05))
UNKNOWN_RADPS = float(np.radians(0.5))
FILTERS: dict[str, tuple[str, dict[str, Any]]] = {
    "compensated": ("roetenberg_disturbance", {}),
    "our filter": ("telemotion", {}),
}
UNCOMPENSATED: tuple[str, dict[str, Any]] = ("roetenberg_disturbance", {"compensation": False})
GYROSCOPE_ONLY: tuple[str, dict[str, Any]] = (
    "roetenberg_disturbance",
    {"use_gravity": False, "use_field": False},
)


def minimum_jerk(u: Float) -> Float:
    """Rise from 0 to 1 over u from 0 to 1 with least jerk."""
    share = np.clip(u, 0.0, 1.0)
    return np.asarray(share**3 * (10.0 - 15.0 * share + 6.0 * share**2))


def iron_radius(mass_kg: float) -> float:
    """Radius of the iron sphere of that mass."""
    return float((3.0 * mass_kg / (4.0 * np.pi * IRON_DENSITY)) ** (1.0 / 3.0))


def iron_field(sensor_m: Float, iron_m: Float, radius_m: float, strength: float = ELONGATED) -> Float:
    """Field that an iron sphere adds, in units of the earth field.

    Parameters
    ----------
    sensor_m, iron_m : ndarray, shape (..., 3)
        Centres, earth frame.
    strength : float
        2.5 stands for a cylinder, longer than wide.

    Notes
    -----
    Induced dipole: `strength (radius / r)^3 (3 u (u . H) - H)`.
    """
    away = sensor_m - iron_m
    r = np.linalg.norm(away, axis=-1, keepdims=True)
    u = away / r
    return np.asarray(strength * (radius_m / r) ** 3 * (3.0 * u * (u @ FIELD)[..., None] - FIELD))


def band_limited(
    time_s: Float, low_hz: float, high_hz: float, sizes: Sequence[float], generator: np.random.Generator
) -> Float:
    """Smooth random curves of given root mean squares within a band, shape (N, len(sizes))."""
    tones = 40
    frequency = generator.uniform(low_hz, high_hz, size=(tones, 1, len(sizes)))
    phase = generator.uniform(0.0, 2.0 * np.pi, size=(tones, 1, len(sizes)))
    coarse = np.arange(time_s[0] - 0.1, time_s[-1] + 0.2, 0.02)
    waves = np.sin(2.0 * np.pi * frequency * coarse[:, None] + phase).sum(axis=0)
    return np.asarray(CubicSpline(coarse, waves * np.sqrt(2.0 / tones) * np.asarray(sizes))(time_s))


@dataclass(frozen=True)
class Readings:
    """What one module saw, with its true quaternions earth-sensor, shape (N, 4)."""

    attitude: Float
    gyroscope_radps: Float
    accelerometer_mps2: Float
    magnetometer: Float


def measure(
    q: Float,
    acceleration_mps2: Float,
    disturbance: Float,
    generator: np.random.Generator,
    *,
    offset_radps: float = ZEROED_RADPS,
    warming_radps2: float = RAMP_RADPS2,
) -> Readings:
    """Sample attitude, acceleration and added field with noise, offset drift and the rests of a calibration.

    Parameters
    ----------
    q : ndarray, shape (N, 4)
    acceleration_mps2, disturbance : ndarray, shape (N, 3)
        Earth frame; the second in units of the field.
    offset_radps : float
        Largest offset left after zeroing, per axis.
    warming_radps2 : float
        Largest rise of the offset with temperature.
    """
    samples = len(q)
    shape = (samples, 3)
    back = rotation.conjugate(q)
    rate = np.zeros(shape)
    rate[1:] = rotation.log(rotation.multiply(back[:-1], q[1:])) / STEP_S

    def crossed(scale: float, across: float) -> Float:
        matrix = generator.normal(size=(3, 3)) * across
        matrix[np.diag_indices(3)] = 1.0 + generator.normal(size=3) * scale
        return matrix

    offset = generator.uniform(-offset_radps, offset_radps, size=3)
    offset = offset + np.cumsum(generator.normal(size=shape) * OFFSET_WALK_RADPS, axis=0)
    offset += warming_radps2 * generator.uniform(-1.0, 1.0, size=3) * np.arange(samples)[:, None] * STEP_S
    force = rotation.rotate(back, acceleration_mps2 + np.array([0.0, 0.0, GRAVITY_MPS2]))
    field = rotation.rotate(back, FIELD + disturbance)
    return Readings(
        attitude=q,
        gyroscope_radps=rate @ crossed(0.003, 0.003).T
        + offset
        + generator.normal(size=shape) * GYROSCOPE_SD_RADPS,
        accelerometer_mps2=force @ crossed(0.002, 0.003).T
        + generator.normal(size=3) * 0.05
        + generator.normal(size=shape) * ACCELEROMETER_SD_MPS2,
        magnetometer=field @ crossed(0.003, 0.003).T
        + generator.normal(size=3) * 0.003
        + generator.normal(size=shape) * MAGNETOMETER_SD,
    )


def to_chunk(trials: Sequence[Readings]) -> ImuChunk:
    """Make trials the sensors of a network; shorter ones keep their last sample, still, to the end."""
    longest = max(len(trial.attitude) for trial in trials)

    def padded(name: str) -> Float:
        return np.stack(
            [np.pad(getattr(t, name), ((0, longest - len(t.attitude)), (0, 0)), mode="edge") for t in trials]
        )

    rate = padded("gyroscope_radps")
    for number, trial in enumerate(trials):
        rate[number, len(trial.attitude) :] = 0.0
    return ImuChunk(
        first_tick=0,
        time_step_s=STEP_S,
        gyroscope_radps=rate,
        accelerometer_mps2=padded("accelerometer_mps2"),
        magnetometer_t=FIELD_T * padded("magnetometer"),
        quality=np.zeros(rate.shape[:2], dtype=np.uint8),
    )


def errors_deg(
    trials: Sequence[Readings],
    estimator: tuple[str, dict[str, Any]],
    *,
    offset_sigma_radps: float = ZEROED_RADPS,
) -> list[Float]:
    """Run a filter over trials, offset known to `offset_sigma_radps`; angle of the rotation error of every sample."""
    name, parameters = estimator
    chunk = to_chunk(trials)
    filter_ = orientation.create(name, len(trials), STEP_S, parameters)
    filter_.set_gyroscope_bias(np.zeros((len(trials), 3)), offset_sigma_radps)
    found = filter_.update(chunk).q_earth_sensor
    return [
        np.degrees(rotation.angle_between(q[: len(trial.attitude)], trial.attitude))
        for q, trial in zip(found, trials, strict=True)
    ]


def random_direction(generator: np.random.Generator) -> Float:
    """Return a unit vector, every direction alike."""
    v = generator.normal(size=3)
    return np.asarray(v / np.linalg.norm(v))


def seconds(samples: int) -> Float:
    """Time of each sample, s."""
    return np.arange(samples, dtype=np.float64) * STEP_S


def root_mean_square(values: Float) -> float:
    """Root mean square over all elements."""
    return float(np.sqrt(np.mean(np.square(values))))
