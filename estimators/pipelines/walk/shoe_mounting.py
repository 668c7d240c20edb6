"""How the sensors of an instrumented shoe sit on it, given by the walk itself."""

from typing import Final

import numpy as np

from estimators import rotation
from estimators.errors import SetupError
from estimators.recording import Float, SensorSignals
from estimators.sentences import say

WELL_MOUNTED_RAD: Final = float(np.radians(6.0))
"""A sensor found this close to its segment's axes is taken to be in them: the walk tells no better."""
_STILL_RADPS: Final = 0.3
_STIFF_RADPS: Final = 0.3
"""Where both sensors of a shoe turn equally fast the toe hinge does not move."""
_GRAVITY_WEIGHT: Final = 0.3
"""Of a squared m/s^2 against a squared rad/s: a sway of 0.3 g at rest against a hinge that moves a little."""
_LEAST_TURNING: Final = 0.3

Mounting = tuple[Float, Float, Float]
"""`q_segment_sensor` of heel, forefoot and lower leg."""


def shoe_mounting(
    q_heel_sensor: Float, heel: SensorSignals, forefoot: SensorSignals, shank: SensorSignals | None
) -> Mounting | None:
    """Return how the sensors of one shoe and its lower leg sit, or None where all sit as they should.

    Parameters
    ----------
    q_heel_sensor : ndarray, shape (4,)
        `q_segment_sensor` of the heel sensor, from the strides.
    heel, forefoot : SensorSignals
        On one time base. A stiff shoe turns both alike, and gravity points alike in both at rest.
    shank : SensorSignals, optional
        Its long axis is vertical in the first rest, and it swings about the axis that the foot swings about.

    Raises
    ------
    SetupError
        If the lower leg's sensor sits askew and its axes cannot be determined.
    """
    q_forefoot = rotation.multiply(q_heel_sensor, _forefoot_to_heel(heel, forefoot))
    feet = [_or_identity(q) for q in (q_heel_sensor, q_forefoot)]
    q_shank = rotation.identity() if shank is None else _or_identity(_shank(q_heel_sensor, heel, shank), 2.0)
    found = (feet[0], feet[1], q_shank)
    return None if all(float(q[0]) == 1.0 for q in found) else found


def _or_identity(q: Float, times: float = 1.0) -> Float:
    is_well = float(rotation.angle_between(q, rotation.identity())) < times * WELL_MOUNTED_RAD
    return rotation.identity() if is_well else q


def _forefoot_to_heel(heel: SensorSignals, forefoot: SensorSignals) -> Float:
    """Fit the turn between two sensors on one stiff body, shape (4,) (Wahba's problem)."""
    rates = [np.linalg.norm(one.gyroscope_radps, axis=1) for one in (heel, forefoot)]
    stiff = np.abs(rates[0] - rates[1]) < _STIFF_RADPS
    still = stiff & (rates[0] < _STILL_RADPS)
    together = heel.gyroscope_radps[stiff].T @ forefoot.gyroscope_radps[stiff]
    together = together + _GRAVITY_WEIGHT * (
        heel.accelerometer_mps2[still].T @ forefoot.accelerometer_mps2[still]
    )
    u, _, vt = np.linalg.svd(together)
    proper = np.diag([1.0, 1.0, np.linalg.det(u) * np.linalg.det(vt)])
    return rotation.from_matrix(u @ proper @ vt)


def _shank(q_heel_sensor: Float, heel: SensorSignals, shank: SensorSignals) -> Float:
    """Return `q_segment_sensor` of the lower leg from its swinging and the first rest, shape (4,)."""
    rate = np.linalg.norm(shank.gyroscope_radps, axis=1)
    still = np.flatnonzero(rate < _STILL_RADPS)
    size, axes = np.linalg.eigh(shank.gyroscope_radps.T @ shank.gyroscope_radps / len(rate))
    if not len(still) or np.sqrt(size[2]) < _LEAST_TURNING or size[1] > 0.5 * size[2]:
        raise SetupError(say("shoes.shank_swing"))
    rest = still[still < still[0] + 100]
    up = shank.accelerometer_mps2[rest].mean(axis=0)
    up = up / np.linalg.norm(up)
    left = axes[:, 2] - float(axes[:, 2] @ up) * up
    length = float(np.linalg.norm(left))
    if length < 0.5:
        raise SetupError(say("shoes.shank_twist"))
    foot_about_left = rotation.rotate(q_heel_sensor, heel.gyroscope_radps)[:, 1]
    together = float((shank.gyroscope_radps @ left) @ foot_about_left)
    left = left / length if together > 0.0 else -left / length
    return rotation.from_matrix(np.vstack((np.cross(left, up), left, up)))
