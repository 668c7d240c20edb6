"""Constants of one device: what turns its readings into what a perfect sensor would have read."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, cast

import numpy as np

from estimators.calibration.field.local_field import LocalField
from estimators.errors import ShapeError
from estimators.recording import Float, ImuChunk

Vector = tuple[float, float, float]
Matrix = tuple[Vector, Vector, Vector]

_IDENTITY: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
_NOTHING: Matrix = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


@dataclass(frozen=True)
class TriadCalibration:
    """Bias, scale and cross-axis of one three-axis sensor: `true = gain (measured - bias)`.

    Attributes
    ----------
    gain : 3 x 3 tuple
        Inverse of scale and cross-axis; the identity for a perfect sensor.
    bias : tuple of 3 floats
        In the unit of the sensor.
    per_acceleration : 3 x 3 tuple
        Reading per m/s^2 of true specific force, subtracted with the bias (gyroscopes: rad/s per m/s^2).
    """

    gain: Matrix = _IDENTITY
    bias: Vector = (0.0, 0.0, 0.0)
    per_acceleration: Matrix = _NOTHING

    def apply(self, measured: Float, specific_force_mps2: Float | None = None) -> Float:
        """Correct readings, shape (..., 3), given the corrected specific force, shape (..., 3), if it counts."""
        values = np.asarray(measured, dtype=np.float64) - np.array(self.bias)
        if specific_force_mps2 is not None and self.per_acceleration != _NOTHING:
            values = values - specific_force_mps2 @ np.array(self.per_acceleration).T
        return np.asarray(values @ np.array(self.gain).T)

    @classmethod
    def from_dict(cls, stored: Mapping[str, Any]) -> "TriadCalibration":
        """Rebuild from plain JSON types."""
        return cls(
            matrix(stored["gain"]),
            vector(stored["bias"]),
            matrix(stored.get("per_acceleration", _NOTHING)),
        )


@dataclass(frozen=True)
class DeviceCalibration:
    """What was found out about one device, to be stored with it and used in every later session.

    Attributes
    ----------
    accelerometer, gyroscope, magnetometer : TriadCalibration or None
        None while unknown: readings pass unchanged.
    field : LocalField or None
        The earth's field where the magnetometer was calibrated; corrects nothing, tells whether it can be believed.
    direction_sigma_rad : tuple of 3 floats
        What the corrections leave unknown of an orientation, one-sigma about x, y and z of the earth frame: added to
        what the estimate states. Zero for a calibration in the hand.
    """

    accelerometer: TriadCalibration | None = None
    gyroscope: TriadCalibration | None = None
    magnetometer: TriadCalibration | None = None
    field: LocalField | None = None
    direction_sigma_rad: Vector = (0.0, 0.0, 0.0)

    def to_dict(self) -> dict[str, Any]:
        """Return plain JSON types; `from_dict` reverses it exactly."""
        return asdict(self) | {"field": None if self.field is None else self.field.to_dict()}

    @classmethod
    def from_dict(cls, stored: Mapping[str, Any]) -> "DeviceCalibration":
        """Rebuild from `to_dict` after a trip through JSON."""
        names = ("accelerometer", "gyroscope", "magnetometer")
        parts = {n: TriadCalibration.from_dict(stored[n]) for n in names if stored.get(n) is not None}
        field = stored.get("field")
        return cls(
            **parts,
            field=None if field is None else LocalField.from_dict(field),
            direction_sigma_rad=vector(stored.get("direction_sigma_rad", (0.0, 0.0, 0.0))),
        )


def direction_variance(devices: Sequence[DeviceCalibration | None]) -> Float:
    """Return the variance, rad^2, that calibrations leave about x, y and z of the earth frame, shape (S, 3)."""
    return np.array(
        [(0.0, 0.0, 0.0) if one is None else np.square(one.direction_sigma_rad) for one in devices]
    ).reshape(-1, 3)


def correct(chunk: ImuChunk, devices: Sequence[DeviceCalibration | None]) -> ImuChunk:
    """Correct the readings of a network.

    Parameters
    ----------
    devices : sequence of DeviceCalibration or None, length S
        In the order of the sensors; None leaves a sensor as it is.

    Raises
    ------
    ShapeError
        If there are not as many devices as sensors.
    """
    if len(devices) != chunk.sensor_count:
        raise ShapeError(f"{len(devices)} devices for {chunk.sensor_count} sensors")
    force, rate = chunk.accelerometer_mps2.copy(), chunk.gyroscope_radps.copy()
    field = None if chunk.magnetometer_t is None else chunk.magnetometer_t.copy()
    for s, device in enumerate(devices):
        if device is None:
            continue
        if device.accelerometer is not None:
            force[s] = device.accelerometer.apply(force[s])
        if device.gyroscope is not None:
            rate[s] = device.gyroscope.apply(rate[s], force[s])
        if device.magnetometer is not None and field is not None:
            field[s] = device.magnetometer.apply(field[s])
    return replace(chunk, gyroscope_radps=rate, accelerometer_mps2=force, magnetometer_t=field)


def vector(values: Any) -> Vector:
    """Return three plain floats."""
    x, y, z = (float(value) for value in values)
    return x, y, z


def matrix(values: Any) -> Matrix:
    """Return three rows of plain floats."""
    return cast(Matrix, tuple(vector(row) for row in values))
