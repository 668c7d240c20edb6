"""Sensors in the hand and on a table: what calibrations of a device need, with exact device errors."""

from collections.abc import Sequence
from typing import Final, Literal

import numpy as np

from estimators import rotation
from estimators.conventions import GRAVITY_MPS2, PLACEMENTS, Placement
from estimators.errors import SetupError
from estimators.recording import Float, Recording, SensorSignals
from estimators.simulation._errors import SensorErrors, sensor_errors
from estimators.simulation._sensors import EarthField

HandlingName = Literal["lie_still", "six_position", "turn_all_ways"]
_REST_S: Final = 2.5
_TIP_S: Final = 1.5
_TURN_S: Final = 5.0
_WANDER_S: Final = 75.0
_FACES: Final[tuple[tuple[float, float, float], ...]] = (
    (0, 0, 1),
    (0, 0, -1),
    (1, 0, 0),
    (-1, 0, 0),
    (0, 1, 0),
    (0, -1, 0),
)


def simulate_handling(
    kind: HandlingName,
    placements: Sequence[Placement],
    *,
    rate_hz: float = 100.0,
    errors: SensorErrors | str = "nominal",
    hard_iron_t: float = 15e-6,
    accelerometer_bias_mps2: float = 0.15,
    gyroscope_scale: float = 1.01,
    seed: int = 0,
) -> Recording:
    """Simulate sensors that are handled together.

    Parameters
    ----------
    kind : {"lie_still", "six_position", "turn_all_ways"}
        Ten seconds on a table; six faces up and a turn about each axis; turned as if painting a ball.
    placements : sequence of Placement
        Names of the sensors.
    errors : SensorErrors or str
        Noise and bias.
    hard_iron_t, accelerometer_bias_mps2, gyroscope_scale : float
        Of every device on top: along its first axis, along its second, and of all axes.
    """
    if kind == "lie_still":
        q = np.tile(rotation.identity(), (round(10.0 * rate_hz) + 1, 1))
    elif kind == "six_position":
        q = _six_positions(rate_hz)
    elif kind == "turn_all_ways":
        q = _all_ways(rate_hz, seed)
    else:
        raise SetupError(f"nothing is known of {kind!r}; known are lie_still, six_position, turn_all_ways")
    model = sensor_errors(errors)
    back = rotation.conjugate(q[1:])
    rate = rotation.log(rotation.multiply(rotation.conjugate(q[:-1]), q[1:])) * rate_hz
    force = rotation.rotate(back, np.array([0.0, 0.0, GRAVITY_MPS2]))
    field = rotation.rotate(back, EarthField().earth_t)
    time_s = np.arange(len(back)) / rate_hz
    sensors: dict[str, SensorSignals] = {}
    for placement in placements:
        rng = np.random.default_rng([seed, 31, PLACEMENTS.index(placement)])
        shift_force = np.array([0.0, accelerometer_bias_mps2, 0.0])
        shift_field = np.array([hard_iron_t, 0.0, 0.0])
        sensors[placement] = SensorSignals(
            time_s,
            model.gyroscope.apply(gyroscope_scale * rate, model.gyroscope.bias_over(time_s, rng), rng),
            model.accelerometer.apply(force + shift_force, model.accelerometer.bias_over(time_s, rng), rng),
            model.magnetometer.apply(field + shift_field, model.magnetometer.bias_over(time_s, rng), rng),
        )
    metadata = {"exercise": kind, "seed": str(seed), "sensor_errors": f"{model.source} in the hand"}
    return Recording(sensors, rate_hz, origin="simulation", metadata=metadata)


def _six_positions(rate_hz: float) -> Float:
    parts: list[Float] = []
    now = rotation.identity()
    for face in _FACES:
        target = _face_up(np.array(face, dtype=np.float64))
        parts.append(_swing(now, target, round(_TIP_S * rate_hz)))
        parts.append(np.tile(target, (round(_REST_S * rate_hz), 1)))
        now = target
        if sum(face) > 0:
            turn = 2.0 * np.pi * _smooth(round(_TURN_S * rate_hz))
            parts.append(rotation.multiply(rotation.about_z(turn), target))
            parts.append(np.tile(target, (round(_REST_S * rate_hz), 1)))
    return np.concatenate(parts)


def _face_up(face: Float) -> Float:
    """Return an orientation in which this sensor axis points up."""
    up = np.array([0.0, 0.0, 1.0])
    axis = np.cross(face, up)
    if np.linalg.norm(axis) < 1e-9:
        return rotation.identity() if face[2] > 0 else rotation.exp(np.array([np.pi, 0.0, 0.0]))
    return rotation.exp(0.5 * np.pi * axis / np.linalg.norm(axis))


def _swing(start: Float, end: Float, count: int) -> Float:
    path = rotation.log(rotation.positive(rotation.multiply(rotation.conjugate(start), end)))
    return rotation.multiply(start, rotation.exp(_smooth(count)[:, None] * path))


def _smooth(count: int) -> Float:
    """Return a way from 0 to 1 that begins and ends at rest."""
    s = np.linspace(0.0, 1.0, max(count, 2))
    return np.asarray(s**3 * (10.0 - 15.0 * s + 6.0 * s**2))


def _all_ways(rate_hz: float, seed: int) -> Float:
    """Visit every direction: a slow spiral over the ball, turned about itself at its own pace."""
    share = np.linspace(0.0, 1.0, round(_WANDER_S * rate_hz) + 1)
    polar = np.arccos(np.clip(1.0 - 2.0 * share, -1.0, 1.0))
    azimuth = 2.0 * np.pi * 9.0 * share
    roll = 2.0 * np.pi * 7.3 * share + seed
    upward = np.stack((0.0 * share, polar, 0.0 * share), axis=1)
    return rotation.multiply(
        rotation.about_z(azimuth), rotation.multiply(rotation.exp(upward), rotation.about_z(roll))
    )
