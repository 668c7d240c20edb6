"""Measurements of a body network, as arrays.

`ImuChunk` is the unit of the live path: a few ticks of all sensors on one common time base.
`Recording` is a whole one, with its own time stamps, as a file reader or the store gives it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import IntFlag
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from estimators.channels import CHANNELS
from estimators.errors import ShapeError
from estimators.samples import Samples

Float = NDArray[np.float64]


class SampleQuality(IntFlag):
    """Why a sample is less than measured; zero means measured and sound."""

    MEASURED = 0
    BRIDGED = 1
    """Interpolated across a gap of at most 200 ms; the estimate goes on, flagged."""
    MISSING = 2
    """Nothing to go on: the values are NaN and the estimate holds or coasts."""
    SATURATED = 4
    """A channel was at its clip level."""
    BACKFILLED = 8
    """Arrived after a lost link; not part of the live view."""


@dataclass(frozen=True)
class ImuChunk(Samples):
    """Consecutive ticks of S sensors at one fixed time step.

    Attributes
    ----------
    first_tick : int
        Number of the first tick since the start of the session; ticks are never renumbered.
    time_step_s : float
        Common tick interval.
    gyroscope_radps, accelerometer_mps2 : ndarray, shape (S, K, 3)
        Sensor axes; specific force. NaN where `quality` says MISSING.
    magnetometer_t : ndarray, shape (S, K, 3), or None
        Sensor axes, tesla; None when no sensor of the network has one. A sensor without one has NaN.
    quality : ndarray of uint8, shape (S, K)
        `SampleQuality` bits.
    coil_state : ndarray, shape (S, K), or None
        What a sensor with coils does at this tick: 0 for nothing, else `estimators.magnetic.coil_state`. None when
        the network has no source.
    force_n, moment_nm : ndarray, shape (S, K, 3), or None
        Of the ground on a load cell, about its centre, sensor axes; NaN where a cell gave nothing that can be used, and
        never bridged. None when no sensor of the network has a cell.
    temperature_degc : ndarray, shape (S, K), or None
        Inside each sensor; NaN where it gave nothing. None when the network sends none.
    """

    TICK_AXIS: ClassVar[int] = 1
    UNKNOWN_BITS: ClassVar[int] = SampleQuality.MISSING.value

    first_tick: int
    time_step_s: float
    gyroscope_radps: Float
    accelerometer_mps2: Float
    magnetometer_t: Float | None
    quality: NDArray[np.uint8]
    coil_state: Float | None = field(default=None, kw_only=True)
    force_n: Float | None = field(default=None, kw_only=True)
    moment_nm: Float | None = field(default=None, kw_only=True)
    temperature_degc: Float | None = field(default=None, kw_only=True)

    @property
    def sensor_count(self) -> int:
        """Number of sensors S."""
        return int(self.gyroscope_radps.shape[0])

    @property
    def time_s(self) -> Float:
        """Time of each tick since the start of the session, shape (K,)."""
        ticks = np.arange(self.first_tick, self.first_tick + self.tick_count, dtype=np.float64)
        return ticks * self.time_step_s

    def sensors(self, rows: Sequence[int]) -> "ImuChunk":
        """Return the sensors of these rows, in this order; of a chunk that holds what was measured and no more."""
        picked = list(rows)
        return self._twin(
            {
                name: value[picked] if isinstance(value, np.ndarray) else value
                for name, value in vars(self).items()
            }
        )


@dataclass(frozen=True)
class SensorSignals:
    """One sensor of a recording, on its own time stamps.

    Attributes
    ----------
    time_s : ndarray, shape (N,)
        Strictly increasing, not necessarily even; zero is the start of the recording.
    gyroscope_radps, accelerometer_mps2 : ndarray, shape (N, 3)
        Sensor axes; specific force.
    magnetometer_t : ndarray, shape (N, 3), or None
        Sensor axes, tesla.
    force_n, moment_nm : ndarray, shape (N, 3), or None
        Of the ground on a load cell, about its centre, sensor axes.
    temperature_degc : ndarray, shape (N,), or None
        Inside the sensor.
    """

    time_s: Float
    gyroscope_radps: Float
    accelerometer_mps2: Float
    magnetometer_t: Float | None = None
    force_n: Float | None = None
    moment_nm: Float | None = None
    temperature_degc: Float | None = None

    def __post_init__(self) -> None:
        samples = self.time_s.shape[0]
        for spec in CHANNELS:
            values, shape = getattr(self, spec.field, None), (samples, spec.width)[: 1 + (spec.width > 1)]
            if values is not None and values.shape != shape:
                raise ShapeError(f"{spec.field} has shape {values.shape}; {samples} time stamps need {shape}")
        if not np.isfinite(self.time_s).all():
            raise ShapeError("time_s has stamps that are no finite numbers; drop these samples")
        if samples and not (np.diff(self.time_s) > 0).all():
            raise ShapeError("time_s must increase strictly; sort the samples and drop repeated stamps")


@dataclass(frozen=True)
class Recording:
    """What a body network measured in one session.

    Attributes
    ----------
    sensors : dict of Placement (or any name, for single sensors) to SensorSignals
        In the order of the network.
    nominal_rate_hz : float
        The rate the devices were set to; the time stamps are the truth.
    origin : str
        Where it came from, for people: file format and device.
    reference : dict of str to ndarray
        What else the file holds about the same samples, for validation: `q_earth_sensor` (N, 4) from motion
        capture, NaN where it saw nothing, and `is_movement` (N,) where a score counts.
    notes : tuple of str
        What was mended while it was read, sentences for people.
    """

    sensors: dict[str, SensorSignals]
    nominal_rate_hz: float
    origin: str = ""
    metadata: dict[str, str] = field(default_factory=dict)
    reference: dict[str, NDArray[Any]] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    @property
    def placements(self) -> tuple[str, ...]:
        """Names of the sensors in the order of the network."""
        return tuple(self.sensors)

    @property
    def duration_s(self) -> float:
        """From the earliest to the latest sample of any sensor."""
        if not self.sensors:
            return 0.0
        first = min(float(sensor.time_s[0]) for sensor in self.sensors.values())
        return max(float(sensor.time_s[-1]) for sensor in self.sensors.values()) - first
