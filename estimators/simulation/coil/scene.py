"""A body-worn source and a sensor as the body network would measure them, with exact truth."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from estimators import rotation
from estimators.conventions import GRAVITY_MPS2
from estimators.magnetic import IronSphere, Source
from estimators.recording import Float
from estimators.simulation.coil.motion import RelativeMotion

EARTH_FIELD_T = np.array([1.9e-5, 0.0, -4.5e-5])
"""0.19 G to the north (here x), 0.45 G down."""


@dataclass(frozen=True)
class ModuleErrors:
    """Sensor errors: noise per sample; offsets are drawn once per module from their sigmas."""

    force_sigma_mps2: float = 0.02
    rate_sigma_radps: float = 0.0123
    magnetometer_sigma_t: float = 3e-8
    force_bias_sigma_mps2: float = 0.02
    rate_bias_sigma_radps: float = float(np.radians(0.5))


@dataclass(frozen=True)
class Iron:
    """A ferromagnetic object.

    Attributes
    ----------
    place_m : callable
        Times (K,) to places (K, 3) in the source frame.
    in_earth_field : bool
        Whether the earth magnetises it too.
    """

    sphere: IronSphere
    place_m: Callable[[Float], Float]
    in_earth_field: bool = True


@dataclass(frozen=True)
class RelativeScene:
    """Signals of K ticks without the pulses, what each coil would add, and the truth.

    Attributes
    ----------
    time_s : ndarray, shape (K,)
    position_m, velocity_mps : ndarray, shape (K, 3)
        Truth: sensor in the source frame; inertial relative velocity in source axes.
    q_source_sensor, q_world_source : ndarray, shape (K, 4)
    gyroscope_radps, accelerometer_mps2, ambient_t : ndarray, shape (K, 3)
        Sensor module, with errors; the magnetometer while no coil is on.
    source_gyroscope_radps, source_accelerometer_mps2 : ndarray, shape (K, 3)
    source_ambient_t : ndarray, shape (K, 3)
        Magnetometer of the source module while no coil is on.
    per_ampere_t : ndarray, shape (K, C, 3)
        What one ampere in each coil adds in sensor axes, iron included.
    """

    time_s: Float
    position_m: Float
    velocity_mps: Float
    q_source_sensor: Float
    q_world_source: Float
    gyroscope_radps: Float
    accelerometer_mps2: Float
    ambient_t: Float
    source_gyroscope_radps: Float
    source_accelerometer_mps2: Float
    source_ambient_t: Float
    per_ampere_t: Float

    @property
    def time_step_s(self) -> float:
        """Tick interval."""
        return float(self.time_s[1] - self.time_s[0])


def _body_rate(spline: object, time_s: Float) -> Float:
    """Angular rate in body axes, by a symmetric difference: independent of the convention of the spline."""
    step = 1e-4
    ahead: Rotation = spline(time_s + step)  # type: ignore[operator]
    behind: Rotation = spline(np.maximum(time_s - step, 0.0))  # type: ignore[operator]
    width = (time_s + step) - np.maximum(time_s - step, 0.0)
    return np.asarray((behind.inv() * ahead).as_rotvec() / width[:, None])


def relative_scene(
    source: Source,
    motion: RelativeMotion,
    duration_s: float,
    rate_hz: float = 100.0,
    errors: ModuleErrors | None = None,
    seed: int = 0,
    iron: Sequence[Iron] = (),
    earth_field_t: Float | None = None,
) -> RelativeScene:
    """Measure a motion.

    Parameters
    ----------
    errors : ModuleErrors, optional
        The defaults of the method page.
    seed : int
        Of noise and offsets.
    """
    rng = np.random.default_rng([seed, 67])
    e = errors or ModuleErrors()
    t = np.arange(round(duration_s * rate_hz)) / rate_hz
    earth = EARTH_FIELD_T if earth_field_t is None else np.asarray(earth_field_t, dtype=np.float64)
    up = np.array([0.0, 0.0, GRAVITY_MPS2])
    r_source, r_sensor = motion.source_attitude(t), motion.sensor_attitude(t)
    offset = np.asarray(motion.sensor_place(t)) - np.asarray(motion.source_place(t))
    drift = np.asarray(motion.sensor_place(t, 1)) - np.asarray(motion.source_place(t, 1))
    position = r_source.inv().apply(offset)
    relative = rotation.from_scipy(r_source.inv() * r_sensor)

    def module(spline: object, track: Callable[..., object], attitude: Rotation) -> tuple[Float, Float]:
        force = attitude.inv().apply(np.asarray(track(t, 2)) + up)
        force = force + rng.normal(0.0, e.force_bias_sigma_mps2, 3)
        force = force + rng.normal(0.0, e.force_sigma_mps2, force.shape)
        rate = _body_rate(spline, t) + rng.normal(0.0, e.rate_bias_sigma_radps, 3)
        return rate + rng.normal(0.0, e.rate_sigma_radps, rate.shape), force

    own = module(motion.sensor_attitude, motion.sensor_place, r_sensor)
    beside = module(motion.source_attitude, motion.source_place, r_source)
    ambient = r_sensor.inv().apply(earth)
    coils = np.arange(len(source.coils))
    field = source.with_model("exact").field(coils[None, :], 1.0, position[:, None, :])
    for item in iron:
        place = item.place_m(t)
        at_iron = source.with_model("exact").field(coils[None, :], 1.0, place[:, None, :])
        field = field + item.sphere.disturbance(at_iron, (position - place)[:, None, :])
        if item.in_earth_field:
            added = item.sphere.disturbance(r_source.inv().apply(earth), position - place)
            ambient = ambient + rotation.rotate(rotation.conjugate(relative), added)
    ambient = ambient + rng.normal(0.0, e.magnetometer_sigma_t, ambient.shape)
    worn = r_source.inv().apply(earth) + rng.normal(0.0, e.magnetometer_sigma_t, ambient.shape)
    seen = rotation.rotate(rotation.conjugate(relative)[:, None, :], field)
    return RelativeScene(
        t,
        position,
        r_source.inv().apply(drift),
        relative,
        rotation.from_scipy(r_source),
        *own,
        ambient,
        *beside,
        worn,
        np.ascontiguousarray(seen),
    )
