"""A foot that walks along closed-form curves: exact truth for one sensor, without forces or a body."""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Polynomial

from estimators import rotation
from estimators.conventions import GRAVITY_MPS2
from estimators.recording import SensorSignals

_U = Polynomial([0.0, 1.0])
_BUMP = 64.0 * (_U * (1.0 - _U)) ** 3
_FORWARD = 35 * _U**4 - 84 * _U**5 + 70 * _U**6 - 20 * _U**7
_ROLL = _BUMP * (1.0 - 2.0 * _U)  # heel up first, toes up before contact


@dataclass
class Walk:
    signals: SensorSignals
    position_m: np.ndarray
    velocity_mps: np.ndarray
    q_world_sensor: np.ndarray
    is_still: np.ndarray


def foot_walk(
    strides=6,
    length_m=1.2,
    period_s=1.1,
    rate_hz=100.0,
    rest_s=1.0,
    lift_m=0.08,
    roll_rad=0.6,
    heading_rad=0.0,
    turn_rad=0.0,
    rise_m=0.0,
    mounting=None,
    noise=0.0,
    bias_radps=(0.0, 0.0, 0.0),
    seed=0,
):
    """Each stride swings for 0.6 of its period, turns the foot by `turn_rad` and climbs by `rise_m`."""
    swing_s = 0.6 * period_s
    duration = 2 * rest_s + strides * period_s
    time = np.arange(round(duration * rate_hz) + 1) / rate_hz
    k = np.clip(np.floor((time - rest_s) / period_s), 0, strides - 1)
    u = np.clip((time - rest_s - k * period_s) / swing_s, 0.0, 1.0)
    moving = (u > 0.0) & (u < 1.0)

    def derivatives(curve, before):
        values = curve(u)
        return (
            before + values,
            np.where(moving, curve.deriv()(u) / swing_s, 0.0),
            np.where(moving, curve.deriv(2)(u) / swing_s**2, 0.0),
        )

    zero = np.zeros_like(time)
    along, v_along, a_along = derivatives(length_m * _FORWARD, length_m * k)
    up, v_up, a_up = derivatives(lift_m * _BUMP + rise_m * _FORWARD, rise_m * k)
    roll, w_roll, _ = derivatives(roll_rad * _ROLL, zero)
    yaw, w_yaw, _ = derivatives(turn_rad * _FORWARD, turn_rad * k)
    heading = np.array([np.cos(heading_rad), np.sin(heading_rad), 0.0])
    position = along[:, None] * heading + up[:, None] * [0, 0, 1]
    velocity = v_along[:, None] * heading + v_up[:, None] * [0, 0, 1]
    acceleration = a_along[:, None] * heading + a_up[:, None] * [0, 0, 1]
    # yaw about the vertical, then roll about the foot's own y axis
    q_yaw = rotation.exp(np.stack([zero, zero, yaw + heading_rad], axis=1))
    q_roll = rotation.exp(np.stack([zero, roll, zero], axis=1))
    q = rotation.multiply(q_yaw, q_roll)
    w_foot = np.stack([zero, w_roll, zero], axis=1) + rotation.rotate(
        rotation.conjugate(q_roll), np.stack([zero, zero, w_yaw], axis=1)
    )
    mount = rotation.identity() if mounting is None else rotation.exp(np.asarray(mounting))
    q = rotation.multiply(q, mount)
    gyroscope = rotation.rotate(rotation.conjugate(mount), w_foot)
    force = rotation.rotate(rotation.conjugate(q), acceleration + np.array([0, 0, GRAVITY_MPS2]))
    random = np.random.default_rng(seed)
    gyroscope = gyroscope + bias_radps + 0.005 * noise * random.standard_normal(gyroscope.shape)
    force = force + 0.05 * noise * random.standard_normal(force.shape)
    return Walk(SensorSignals(time, gyroscope, force), position, velocity, q, ~moving)
