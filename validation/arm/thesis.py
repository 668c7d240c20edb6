"""The scenes of Marzouk (2009) as the arm method page prescribes them (4.2): motions, sensors, scores.

Inside this module the thesis' convention holds: U is north-east-down, `gravity_g` is gravity-positive
(minus specific force over g), `field` is normalised. `to_chunk` converts for the product's filters and
`to_thesis` converts their result back.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from estimators import orientation, rotation
from estimators.calibration import static_bias
from estimators.conventions import GRAVITY_MPS2
from estimators.recording import Float, ImuChunk

RATE_HZ = 17.0
DIP_RAD = float(np.radians(69.4))
FIELD_T = 50e-6
GYROSCOPE_BIAS_DEGPS = np.array([-0.8229, 0.7879, 0.5597])
GYROSCOPE_SD_DEGPS = np.sqrt([0.2460, 0.3601, 0.2684])
GRAVITY_BIAS_G = np.array([-0.0158, 0.0068, 0.0176])
GRAVITY_SD_G = np.sqrt([2.8661e-4, 1.8078e-4, 2.1574e-4])
FIELD_SD = np.sqrt([9.3357e-6, 1.7240e-4, 9.1179e-4])
HANDLE = np.array([0.0, np.cos(DIP_RAD) * np.tan(np.radians(12.0)), 0.0])
"""Hard iron of the cast-iron handle that shifted the heading by 12 degrees (5.3)."""
STILL_SAMPLES = 150
SCORED_AFTER_S = 12.0

Motion = Callable[[Float], tuple[Float, Float]]
"""Time to intrinsic ZYX angles (yaw, pitch, roll) in rad and position in m, each (N, 3)."""

_NED_EARTH = Rotation.from_matrix([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])


@dataclass(frozen=True)
class Module:
    """What one module measured, with its true attitude."""

    time_s: Float
    attitude: Rotation
    gyroscope_radps: Float
    gravity_g: Float
    field: Float


def envelope(time_s: Float) -> Float:
    """Rest for 10 s, then a minimum-jerk rise over 2 s."""
    share = np.clip((time_s - 10.0) / 2.0, 0.0, 1.0)
    return np.asarray(share**3 * (10.0 - 15.0 * share + 6.0 * share**2))


def _waves(time_s: Float, *terms: tuple[float, float, float]) -> Float:
    """Sum of amplitude * sin(2 pi frequency t' + phase)."""
    turns = 2.0 * np.pi * (time_s - 10.0)
    return np.asarray(sum(size * np.sin(hz * turns + phase) for size, hz, phase in terms))


def hand_motion(time_s: Float) -> tuple[Float, Float]:
    """V4: turned and carried about by hand."""
    rise = envelope(time_s)[:, None]
    yaw = _waves(time_s, (60, 0.11, 0), (20, 0.33, 0.5))
    pitch = _waves(time_s, (35, 0.17, 0.9), (12, 0.41, 0))
    roll = _waves(time_s, (40, 0.21, 0.3), (15, 0.47, 1.1))
    x, y, z = (_waves(time_s, term) for term in ((0.12, 0.43, 0.0), (0.10, 0.37, 1.0), (0.10, 0.51, 2.0)))
    return np.radians(np.stack([yaw, pitch, roll], axis=1)) * rise, np.stack([x, y, z], axis=1) * rise


def steep_motion(time_s: Float) -> tuple[Float, Float]:
    """V6: pitch through plus and minus 90 degrees."""
    angles = [_waves(time_s, term) for term in ((20, 0.07, 0.0), (110, 0.10, 0.0), (15, 0.13, 0.0))]
    rise = envelope(time_s)[:, None]
    return np.radians(np.stack(angles, axis=1)) * rise, np.zeros((len(time_s), 3))


def measure_module(
    motion: Motion,
    duration_s: float,
    seed: int,
    *,
    rate_hz: float = RATE_HZ,
    with_bias: bool = True,
    body_field: Float | None = None,
) -> Module:
    """Sample a motion with the common sensor model.

    Parameters
    ----------
    with_bias : bool
        Gyroscope and accelerometer bias of T2.1 and T2.2.
    body_field : ndarray, shape (3,), optional
        Hard iron in sensor axes, in units of the earth field.
    """
    generator = np.random.default_rng([seed, 2009])
    time_s = np.arange(round(duration_s * rate_hz)) / rate_hz
    step = 1e-3

    def attitude_at(instants: Float) -> Rotation:
        return Rotation.from_euler("ZYX", motion(instants)[0])

    attitude = attitude_at(time_s)
    change = attitude_at(time_s - step / 2).inv() * attitude_at(time_s + step / 2)
    positions = [motion(time_s + shift)[1] for shift in (-step, 0.0, step)]
    acceleration = (positions[0] - 2.0 * positions[1] + positions[2]) / step**2
    back = attitude.inv()
    shape = (len(time_s), 3)
    bias = 1.0 if with_bias else 0.0
    return Module(
        time_s=time_s,
        attitude=attitude,
        gyroscope_radps=change.as_rotvec() / step
        + np.radians(bias * GYROSCOPE_BIAS_DEGPS + generator.normal(size=shape) * GYROSCOPE_SD_DEGPS),
        gravity_g=back.apply(np.array([0.0, 0.0, 1.0]) - acceleration / GRAVITY_MPS2)
        + bias * GRAVITY_BIAS_G
        + generator.normal(size=shape) * GRAVITY_SD_G,
        field=back.apply([np.cos(DIP_RAD), 0.0, np.sin(DIP_RAD)])
        + (0.0 if body_field is None else body_field)
        + generator.normal(size=shape) * FIELD_SD,
    )


def calibrate_still(module: Module, *, gyroscope: bool = True, accelerometer: bool = True) -> Module:
    """Subtract the static biases (A2) found by the product over the first 150 samples, level and facing north."""
    still = slice(0, STILL_SAMPLES)
    level = rotation.from_scipy(_NED_EARTH.inv())[None]
    found = static_bias(
        module.gyroscope_radps[None, still],
        -GRAVITY_MPS2 * module.gravity_g[None, still],
        float(module.time_s[1]),
        q_earth_sensor=level,
    )
    rate, gravity = module.gyroscope_radps, module.gravity_g
    if gyroscope:
        rate = rate - found.gyroscope_bias_radps[0]
    if accelerometer and found.accelerometer_bias_mps2 is not None:
        gravity = gravity + found.accelerometer_bias_mps2[0] / GRAVITY_MPS2
    return replace(module, gyroscope_radps=rate, gravity_g=gravity)


def raw_angles(gravity_g: Float, field: Float) -> Float:
    """Yaw, pitch and roll from one sample's gravity and field (A4, A5), shape (N, 3), rad."""
    sx, sy, sz = np.moveaxis(gravity_g, -1, 0)
    roll = np.arctan2(sy, sz)
    pitch = np.arctan2(-sx, sy * np.sin(roll) + sz * np.cos(roll))
    p = np.cross(field, gravity_g)
    yaw = np.arctan2(-p[..., 0], sy * p[..., 2] - sz * p[..., 1])
    return np.stack([yaw, pitch, roll], axis=-1)


def to_chunk(modules: Sequence[Module]) -> ImuChunk:
    """Make the modules the sensors of one network."""
    return ImuChunk(
        first_tick=0,
        time_step_s=float(modules[0].time_s[1]),
        gyroscope_radps=np.stack([m.gyroscope_radps for m in modules]),
        accelerometer_mps2=np.stack([-GRAVITY_MPS2 * m.gravity_g for m in modules]),
        magnetometer_t=np.stack([FIELD_T * m.field for m in modules]),
        quality=np.zeros((len(modules), len(modules[0].time_s)), dtype=np.uint8),
    )


def estimate(
    modules: Sequence[Module], name: str, parameters: dict[str, float | bool] | None = None
) -> tuple[list[Rotation], Float]:
    """Run a filter of the product over modules; attitudes R_US, and bias (S, N, 3) in rad/s."""
    chunk = to_chunk(modules)
    result = orientation.create(name, len(modules), chunk.time_step_s, parameters).update(chunk)
    return [to_thesis(q) for q in result.q_earth_sensor], result.gyroscope_bias_radps


def to_thesis(q_earth_sensor: Float) -> Rotation:
    """R_US from our quaternions, shape (N, 4)."""
    return _NED_EARTH * rotation.to_scipy(q_earth_sensor)


def angle_errors_deg(found: Float, module: Module) -> Float:
    """Mean absolute wrapped error of yaw, pitch and roll after 12 s, shape (3,); `found` is (N, 3) rad."""
    scored = module.time_s > SCORED_AFTER_S
    error = found[scored] - module.attitude.as_euler("ZYX")[scored]
    wrapped = np.remainder(error + np.pi, 2.0 * np.pi) - np.pi
    return np.asarray(np.degrees(np.abs(wrapped)).mean(axis=0))
