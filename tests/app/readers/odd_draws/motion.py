"""What drawn sensors measure: rest, then smooth turns about all axes, with the noise that makes each sample its own."""

from dataclasses import dataclass, field

import numpy as np

GRAVITY_MPS2 = 9.80665
_FIELD_UT = np.array([0.0, 20.0, -44.0])
_REST_S = 0.3
_NOISE = {"gyroscope": 0.01, "accelerometer": 0.05, "magnetometer": 0.3}


@dataclass
class Signals:
    """One quantity of one sensor.

    Attributes
    ----------
    time_s : ndarray, shape (N,)
        When each sample was measured.
    values : ndarray, shape (N, 3)
        rad/s, m/s^2 or microtesla.
    there : ndarray of bool, shape (N,)
        Which samples the table holds; the others were lost.
    """

    time_s: np.ndarray
    values: np.ndarray
    there: np.ndarray


@dataclass
class Sensor:
    """A drawn sensor: its name in the table, and its signals by quantity."""

    name: str
    signals: dict[str, Signals] = field(default_factory=dict)


def measured(rng: np.random.Generator, times_s: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return what a sensor measures at these times, by quantity, each shape (N, 3)."""
    waves = rng.uniform((0.15, 0.2, 0.0), (0.6, 0.8, 2.0 * np.pi), (3, 2, 3))
    start = rng.uniform(-0.6, 0.6, 3)
    found = {}
    for quantity, time_s in times_s.items():
        moved = np.maximum(time_s - time_s[0] - _REST_S, 0.0)
        yaw, pitch, roll = (
            start[axis]
            + sum(a * (np.sin(2.0 * np.pi * f * moved + p) - np.sin(p)) for f, a, p in waves[axis])
            for axis in range(3)
        )
        found[quantity] = _seen(quantity, time_s, yaw, pitch, roll)
        found[quantity] += rng.normal(0.0, _NOISE[quantity], found[quantity].shape)
    return found


def _seen(
    quantity: str, time_s: np.ndarray, yaw: np.ndarray, pitch: np.ndarray, roll: np.ndarray
) -> np.ndarray:
    if quantity == "gyroscope":
        dy, dp, dr = (np.gradient(angle, time_s) for angle in (yaw, pitch, roll))
        return np.stack(
            [
                dr - dy * np.sin(pitch),
                dp * np.cos(roll) + dy * np.cos(pitch) * np.sin(roll),
                -dp * np.sin(roll) + dy * np.cos(pitch) * np.cos(roll),
            ],
            axis=1,
        )
    fixed = np.array([0.0, 0.0, GRAVITY_MPS2]) if quantity == "accelerometer" else _FIELD_UT
    x, y, z = fixed
    # Into the sensor: about z, then y, then x.
    x, y = np.cos(yaw) * x + np.sin(yaw) * y, -np.sin(yaw) * x + np.cos(yaw) * y
    x, z = np.cos(pitch) * x - np.sin(pitch) * z, np.sin(pitch) * x + np.cos(pitch) * z
    y, z = np.cos(roll) * y + np.sin(roll) * z, -np.sin(roll) * y + np.cos(roll) * z
    return np.stack([x, y, z], axis=1)
