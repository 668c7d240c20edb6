"""The simulated scenes of the arm-monitoring thesis' protocols: a module moved by hand, 17 Hz, its own noise.

Everything here is in the thesis' convention: U is north-east-down, `s` is gravity-positive in g, `m` is
normalised to the earth field. `as_chunk` converts to the convention of the product.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from estimators.conventions import GRAVITY_MPS2
from estimators.recording import ImuChunk

STEP_S = 1.0 / 17.0
DIP_RAD = np.deg2rad(69.4)
EARTH_FIELD_T = 50e-6
GYROSCOPE_BIAS_DEGPS = np.array([-0.8229, 0.7879, 0.5597])
GYROSCOPE_SIGMA_DEGPS = np.array([0.4960, 0.6001, 0.5181])
ACCELEROMETER_BIAS_G = np.array([-0.0158, 0.0068, 0.0176])
ACCELEROMETER_SIGMA_G = np.array([0.0169, 0.0134, 0.01469])
FIELD_SIGMA = np.array([0.0031, 0.0131, 0.0302])
HANDLE = np.cos(DIP_RAD) * np.tan(np.deg2rad(12.0))


def ramp(t):
    u = np.clip((t - 10.0) / 2.0, 0.0, 1.0)
    return u**3 * (10 - 15 * u + 6 * u**2)


def hand_motion(t):
    """Rotation and position of protocol V4."""
    e, v = ramp(t), t - 10.0
    w = 2 * np.pi * v
    roll = 40 * np.sin(0.21 * w + 0.3) + 15 * np.sin(0.47 * w + 1.1)
    pitch = 35 * np.sin(0.17 * w + 0.9) + 12 * np.sin(0.41 * w)
    yaw = 60 * np.sin(0.11 * w) + 20 * np.sin(0.33 * w + 0.5)
    position = np.stack(
        [0.12 * np.sin(0.43 * w), 0.10 * np.sin(0.37 * w + 1), 0.10 * np.sin(0.51 * w + 2)], axis=-1
    )
    return np.deg2rad(np.stack([yaw, pitch, roll], axis=-1)) * e[:, None], position * e[:, None]


def through_the_singularity(t):
    """Rotation of protocol V6; no linear acceleration."""
    e, w = ramp(t), 2 * np.pi * (t - 10.0)
    angles = np.stack([20 * np.sin(0.07 * w), 110 * np.sin(0.10 * w), 15 * np.sin(0.13 * w)], axis=-1)
    return np.deg2rad(angles) * e[:, None], np.zeros((t.size, 3))


def at_rest(t):
    """Level, facing north."""
    return np.zeros((t.size, 3)), np.zeros((t.size, 3))


@dataclass(frozen=True)
class Scene:
    time_s: np.ndarray
    true_rotation: Rotation
    rate_radps: np.ndarray
    gravity_g: np.ndarray
    field: np.ndarray
    step_s: float


def scene(
    motion, duration_s, seed, *, step_s=STEP_S, noise=1.0, bias=1.0, body_field=(0.0, 0.0, 0.0)
) -> Scene:
    """Sample a motion with the common sensor model of section 4.2."""
    t = np.arange(round(duration_s / step_s)) * step_s
    half = 5e-4

    def attitude(at):
        return Rotation.from_euler("ZYX", motion(at)[0])

    truth = attitude(t)
    rate = (attitude(t - half).inv() * attitude(t + half)).as_rotvec() / (2 * half)
    h = 1e-3
    acceleration = (motion(t + h)[1] - 2 * motion(t)[1] + motion(t - h)[1]) / h**2
    gravity = truth.inv().apply([0, 0, 1] - acceleration / GRAVITY_MPS2)
    field = truth.inv().apply([np.cos(DIP_RAD), 0, np.sin(DIP_RAD)]) + np.asarray(body_field)
    rng = np.random.default_rng(seed)
    draws = rng.standard_normal((3, t.size, 3)) * noise
    rate = rate + np.deg2rad(bias * GYROSCOPE_BIAS_DEGPS + draws[0] * GYROSCOPE_SIGMA_DEGPS)
    gravity = gravity + bias * ACCELEROMETER_BIAS_G + draws[1] * ACCELEROMETER_SIGMA_G
    return Scene(t, truth, rate, gravity, field + draws[2] * FIELD_SIGMA, step_s)


def calibrated(given: Scene, samples: int = 150, gyroscope: bool = True) -> Scene:
    """Static calibration A2 over the first samples, level."""
    rate, gravity = given.rate_radps, given.gravity_g
    if gyroscope:
        rate = rate - rate[:samples].mean(axis=0)
    gravity = gravity - (gravity[:samples].mean(axis=0) - [0.0, 0.0, 1.0])
    return Scene(given.time_s, given.true_rotation, rate, gravity, given.field, given.step_s)


def as_chunk(scenes: list[Scene]) -> ImuChunk:
    """All scenes as the sensors of one network, specific force and tesla."""
    return ImuChunk(
        0,
        scenes[0].step_s,
        np.stack([one.rate_radps for one in scenes]),
        np.stack([-GRAVITY_MPS2 * one.gravity_g for one in scenes]),
        np.stack([EARTH_FIELD_T * one.field for one in scenes]),
        np.zeros((len(scenes), scenes[0].time_s.size), dtype=np.uint8),
    )


NED_FROM_EARTH = Rotation.from_matrix([[0, 1, 0], [1, 0, 0], [0, 0, -1]])


def thesis_rotation(q_earth_sensor) -> Rotation:
    """R_US of estimates of one sensor, shape (K, 4)."""
    return NED_FROM_EARTH * Rotation.from_quat(np.asarray(q_earth_sensor)[..., [1, 2, 3, 0]])


def euler_errors_deg(estimated: Rotation, given: Scene, after_s: float = 12.0) -> np.ndarray:
    """Mean absolute wrapped errors of roll, pitch, yaw."""
    scored = given.time_s > after_s
    difference = estimated[scored].as_euler("ZYX") - given.true_rotation[scored].as_euler("ZYX")
    wrapped = np.mod(difference + np.pi, 2 * np.pi) - np.pi
    return np.rad2deg(np.abs(wrapped)).mean(axis=0)[::-1]
