"""Gait of a foot, a shank and a pelvis: steps along a way that bends."""

from typing import Final

import numpy as np

from estimators import rotation
from estimators.recording import Float
from validation.worlds.curves import bump, noise, smooth_step, vibration

_STANCE: Final = 0.6
"""Share of a stride in which the foot stands."""
_WAY_KNOT_S: Final = 5.0


def foot(own_s: Float, generator: np.random.Generator) -> tuple[Float, Float]:
    """Walk with a sensor on the instep: it stands, rolls over the toe, swings and lands on the heel."""
    toe, pitch, yaw, _ = _foot_path(own_s, generator)
    q = rotation.multiply(rotation.about_z(yaw), rotation.about_y(pitch))
    lever = [-generator.uniform(0.06, 0.14), 0.0, generator.uniform(0.03, 0.08)]
    return q, toe + rotation.rotate(q, lever)


def shank(own_s: Float, generator: np.random.Generator) -> tuple[Float, Float]:
    """Walk with a sensor on the shank, which turns about the ankle."""
    toe, pitch, yaw, stride = _foot_path(own_s, generator)
    standing = rotation.multiply(rotation.about_z(yaw), rotation.about_y(pitch))
    ankle = toe + rotation.rotate(standing, [-0.15, 0.0, 0.08])
    size = generator.uniform(0.8, 1.2)
    turn = 2.0 * np.pi * stride
    angle = size * (0.35 * np.sin(turn - 0.4) + 0.16 * np.sin(2.0 * turn + 0.8) + 0.1)
    roll = 0.06 * np.sin(turn + generator.uniform(0.0, 6.0))
    q = rotation.multiply(rotation.about_z(yaw), rotation.about_y(angle))
    q = rotation.multiply(q, rotation.about_x(roll))
    return q, ankle + rotation.rotate(q, [0.03, 0.0, generator.uniform(0.12, 0.35)])


def pelvis(own_s: Float, generator: np.random.Generator) -> tuple[Float, Float]:
    """Walk with a sensor on the sacrum: it goes on evenly, up and down twice a stride and aside once."""
    stride_s, length_m, yaw = _way(own_s, generator)
    turn = 2.0 * np.pi * own_s / stride_s
    forward = np.gradient(own_s * length_m / stride_s + 0.01 * np.sin(2.0 * turn))
    place = _along(forward, yaw)
    aside = generator.uniform(0.01, 0.03) * np.sin(turn)
    place += aside[:, None] * np.column_stack((-np.sin(yaw), np.cos(yaw), np.zeros(len(yaw))))
    place[:, 2] = generator.uniform(0.01, 0.03) * np.cos(2.0 * turn)
    place[:, 2] += _strikes(own_s, 0.5 * stride_s, generator, 2.0, 6.0)
    sizes = generator.uniform(0.03, 0.12, 3)
    q = rotation.about_z(yaw + sizes[0] * np.sin(turn + 0.5))
    q = rotation.multiply(q, rotation.about_y(0.1 + sizes[1] * np.sin(2.0 * turn)))
    return rotation.multiply(q, rotation.about_x(sizes[2] * np.sin(turn))), place


def _way(own_s: Float, generator: np.random.Generator) -> tuple[float, float, Float]:
    """Return duration and length of a stride, and the heading along the way."""
    stride_s = float(generator.uniform(0.9, 1.6))
    length_m = float(generator.uniform(0.6, 1.5))
    bends = generator.choice([0.0, 0.4, 1.2])
    return stride_s, length_m, bends * noise(own_s, generator, 1, _WAY_KNOT_S)[:, 0]


def _foot_path(own_s: Float, generator: np.random.Generator) -> tuple[Float, Float, Float, Float]:
    """Return place of the toe, pitch (nose down positive), heading, and time in strides."""
    stride_s, length_m, yaw = _way(own_s, generator)
    stride = own_s / stride_s
    count = np.floor(stride)
    phase = stride - count
    swing = np.clip((phase - _STANCE) / (1.0 - _STANCE), 0.0, 1.0)
    toe = _along(np.gradient(length_m * (count + smooth_step(swing))), yaw)
    toe[:, 2] = generator.uniform(0.03, 0.1) * 64.0 * (swing * (1.0 - swing)) ** 3
    toe[:, 2] += _strikes(own_s, stride_s, generator, 10.0, 60.0)
    off, landing = generator.uniform(0.8, 1.4), generator.uniform(0.2, 0.45)
    pitch = off * bump((phase - 0.64) / 0.2)
    # The heel lands before the stride ends, and the foot is flat a tenth of a stride later.
    pitch -= landing * (bump((phase - 0.97) / 0.13) + bump((phase + 0.03) / 0.13))
    return toe, pitch, yaw, stride


def _along(forward_m: Float, yaw: Float) -> Float:
    """Add steps along a heading to a place, shape (N, 3)."""
    steps = np.column_stack((np.cos(yaw), np.sin(yaw), np.zeros(len(yaw)))) * forward_m[:, None]
    place = np.zeros_like(steps)
    place[1:] = np.cumsum(0.5 * (steps[1:] + steps[:-1]), axis=0)
    return place


def _strikes(
    own_s: Float, every_s: float, generator: np.random.Generator, least_mps2: float, most_mps2: float
) -> Float:
    """Return how the ground shakes the segment up and down at each contact."""
    starts = every_s * np.arange(1.0, int(own_s[-1] / every_s) + 1)
    peaks = generator.uniform(least_mps2, most_mps2) * generator.uniform(0.7, 1.3, len(starts))
    return vibration(own_s, starts, peaks, generator.uniform(10.0, 20.0))
