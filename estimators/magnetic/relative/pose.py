"""Pose of a sensor against a worn source, and when which coil is to be fired (Schepers 2009, ch. 6)."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntFlag
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from estimators import rotation
from estimators.errors import SetupError, ShapeError
from estimators.kernels.array_filter import ArrayFilter
from estimators.magnetic._coil import Source
from estimators.magnetic.relative import layout as at
from estimators.magnetic.relative import run as kernel
from estimators.magnetic.relative.parameters import read, to_settings
from estimators.magnetic.relative.start import start_from_burst
from estimators.recording import Float
from estimators.samples import Samples


class RelativeFlag(IntFlag):
    """What the user of a relative pose must know about it; zero means sound."""

    SOUND = 0
    INVALID = 1
    """No pose yet."""
    CALIBRATING = 2
    """Waiting for the standstill or the first burst: stand still."""
    INERTIAL_ONLY = 4
    """The source is not used now, or its pulses cannot be read; the uncertainty grows."""
    DISTURBED = 8
    """Iron near the sensor, the source or between, coils not as strong as stated, or pulses that do not fit."""
    MISSING_PULSE = 16
    """Pulses that were asked for did not come: is the source switched on?"""
    SATURATED = 32
    """The magnetometer was at full scale during a pulse."""
    FAULT = 64
    """Bursts fit no pose: coil numbers, or source and sensor, may be exchanged, or the magnetometer is dead."""
    UNCERTAIN = 128
    """A sigma is above `uncertain_m` or `uncertain_deg`."""
    GAP = 256
    """The sample is missing; the last one was held."""


@dataclass(frozen=True)
class RelativeChunk(Samples):
    """Consecutive ticks of the two modules and of the coils.

    Attributes
    ----------
    gyroscope_radps, accelerometer_mps2, magnetometer_t : ndarray, shape (K, 3)
        Of the sensor; NaN where missing.
    source_gyroscope_radps, source_accelerometer_mps2 : ndarray, shape (K, 3)
    coil : ndarray of int, shape (K,)
        What was on: 0 nothing, else the number of the coil plus one.
    current_a : ndarray, shape (K,)
    """

    first_tick: int
    time_step_s: float
    gyroscope_radps: Float
    accelerometer_mps2: Float
    magnetometer_t: Float
    source_gyroscope_radps: Float
    source_accelerometer_mps2: Float
    coil: NDArray[np.int64]
    current_a: Float

    def table(self) -> Float:
        """Return the samples as the compiled loop takes them, shape (K, 17)."""
        count = self.tick_count
        table = np.empty((count, at.SAMPLE))
        for column, values in (
            (at.GYROSCOPE, self.gyroscope_radps),
            (at.ACCELEROMETER, self.accelerometer_mps2),
            (at.FIELD, self.magnetometer_t),
            (at.SOURCE_GYROSCOPE, self.source_gyroscope_radps),
            (at.SOURCE_ACCELEROMETER, self.source_accelerometer_mps2),
        ):
            if values.shape != (count, 3):
                raise ShapeError(f"all signals need shape ({count}, 3), not {values.shape}")
            table[:, column : column + 3] = values
        for column, numbers in ((at.COIL, self.coil), (at.CURRENT, self.current_a)):
            if numbers.shape != (count,):
                raise ShapeError(f"coil and current need shape ({count},), not {numbers.shape}")
            table[:, column] = numbers
        if not np.isfinite(table[:, at.COIL :]).all() or (table[:, at.COIL] < 0).any():
            raise ShapeError("coil states must be 0 or more, currents finite")
        return table


@dataclass(frozen=True)
class RelativeResult(Samples):
    """Pose over K ticks, and what the source is asked to do.

    Attributes
    ----------
    position_m : ndarray, shape (K, 3)
        Of the sensor in the source frame.
    q_source_sensor : ndarray, shape (K, 4)
    velocity_mps : ndarray, shape (K, 3)
        Inertial relative velocity in source axes.
    covariance : ndarray, shape (K, 6, 6)
        Position in source axes, then orientation error in sensor axes.
    nis : ndarray, shape (K,)
        Of the pulse that ended at this tick; NaN without one.
    fire_coil : ndarray of int, shape (K,)
        Actuation plan: at the next tick switch on this coil (number plus one); 0 for nothing to do.
    fire_current_a : ndarray, shape (K,)
    fire_ticks : ndarray of int, shape (K,)
        For so many ticks.
    scores : ndarray, shape (K, 3)
        Of the coils where a choice was made, else zero; the least one was chosen.
    flags : ndarray of uint16, shape (K,)
        `RelativeFlag` bits.
    """

    position_m: Float
    q_source_sensor: Float
    velocity_mps: Float
    covariance: Float
    nis: Float
    fire_coil: NDArray[np.int64]
    fire_current_a: Float
    fire_ticks: NDArray[np.int64]
    scores: Float
    flags: NDArray[np.uint16]

    @property
    def position_sigma_m(self) -> Float:
        """One sigma along the source axes, shape (K, 3)."""
        return np.sqrt(np.diagonal(self.covariance, axis1=-2, axis2=-1)[:, :3])

    @property
    def attitude_sigma_rad(self) -> Float:
        """One sigma about the sensor axes, shape (K, 3)."""
        return np.sqrt(np.diagonal(self.covariance, axis1=-2, axis2=-1)[:, 3:])

    @classmethod
    def of_table(cls, out: Float) -> "RelativeResult":
        """Read the output of the compiled loop."""
        return cls(
            out[:, at.O_POSITION : at.O_POSITION + 3],
            out[:, at.O_ATTITUDE : at.O_ATTITUDE + 4],
            out[:, at.O_VELOCITY : at.O_VELOCITY + 3],
            out[:, at.O_COVARIANCE : at.O_COVARIANCE + 36].reshape(-1, 6, 6),
            out[:, at.O_NIS],
            out[:, at.O_COIL].astype(np.int64),
            out[:, at.O_CURRENT],
            out[:, at.O_TICKS].astype(np.int64),
            out[:, at.O_SCORES : at.O_SCORES + 3],
            out[:, at.O_FLAGS].astype(np.uint16),
        )


@dataclass(frozen=True)
class EnergyAccount:
    """What the source has used: time with a coil on (s), charge (A s), current squared over time (A^2 s)."""

    on_time_s: float
    charge_as: float
    current_squared_a2s: float
    pulses: int
    missed: int

    def heat_j(self, resistance_ohm: float) -> float:
        """Energy turned into heat in coils of a resistance."""
        return self.current_squared_a2s * resistance_ohm


class RelativePoseFilter(ArrayFilter):
    """Error-state Kalman filter over both inertial modules and single pulses, with adaptive actuation.

    The same samples give the same result, bit for bit, one by one, in uneven chunks, in one batch, or across `state`
    and `restore` into a fresh instance built with the same arguments.

    Parameters
    ----------
    parameters : mapping, optional
        Of `RelativePoseParameters`.
    usual_place_m : ndarray, shape (3,), optional
        Where the sensor is on somebody who stands, in source axes, roughly: tells a place from its mirror image
        after dead reckoning has lost it.
    """

    name: ClassVar[str] = "relative_pose"
    version: ClassVar[str] = "4"
    _ARRAYS: ClassVar[tuple[str, ...]] = ("nominal", "covariance", "memory", "counters", "ring")

    def __init__(
        self,
        source: Source,
        time_step_s: float,
        parameters: Mapping[str, Any] | None = None,
        usual_place_m: Float | None = None,
    ) -> None:
        if not 1e-4 < time_step_s < 0.1:
            raise SetupError(f"time_step_s must be between 0.1 ms and 100 ms, not {time_step_s}")
        if len(source.coils) != 3:
            raise SetupError("the filter starts from a burst of three coils; give a source with three")
        self._source, self._time_step_s, self._usual_place_m = source, time_step_s, usual_place_m
        self._parameters = read(parameters)
        if self._parameters.current_a > source.current_limit_a:
            raise SetupError("current_a is above what the source can give")
        self._loops = source.loops
        self._settings = to_settings(self._parameters, time_step_s, len(source.coils))
        self._nominal = np.zeros(at.NOMINAL)
        self._nominal[at.ATTITUDE] = 1.0
        self._covariance = np.zeros((at.ERRORS, at.ERRORS))
        self._memory = np.zeros(at.MEMORY)
        self._counters = np.zeros(at.COUNTERS, dtype=np.int64)
        self._ring = np.zeros((at.RING, at.RING_COLUMNS))

    def update(self, chunk: RelativeChunk) -> RelativeResult:
        """Take the next ticks; `chunk.first_tick` must continue the last one.

        Raises
        ------
        ShapeError
            For arrays of other shapes, another time step, or ticks that do not follow.
        """
        if chunk.first_tick != int(self._counters[at.TICK]):
            raise ShapeError(f"tick {chunk.first_tick} does not follow {int(self._counters[at.TICK]) - 1}")
        if abs(chunk.time_step_s - self._time_step_s) > 1e-9:
            raise ShapeError(f"the filter was built for {self._time_step_s} s, not {chunk.time_step_s} s")
        return RelativeResult.of_table(self.run(chunk.table()))

    def run(self, samples: Float) -> Float:
        """Take samples as a table, shape (K, 17), and return the output table: the way without checks."""
        out = np.empty((len(samples), at.OUTPUT))
        taken = 0
        while taken < len(samples):
            taken += int(kernel.run(samples[taken:], *self.arrays(), out[taken:]))
            if self._counters[at.EVENT]:
                self.handle_event()
        return out

    def arrays(self) -> tuple[Float, Float, Float, Float, Float, NDArray[np.int64], Float]:
        """Return the arguments of the compiled loop between samples and output, for loops that hold it."""
        return (
            self._loops,
            self._settings,
            self._nominal,
            self._covariance,
            self._memory,
            self._counters,
            self._ring,
        )

    def handle_event(self) -> None:
        """Solve the burst that the compiled loop has just completed."""
        start_from_burst(
            self._source,
            self._parameters,
            self._settings,
            self._nominal,
            self._covariance,
            self._memory,
            self._counters,
            self._usual_place_m,
        )

    @property
    def source(self) -> Source:
        """The coils that the filter knows."""
        return self._source

    @property
    def covariance(self) -> Float:
        """Covariance of all 21 errors now."""
        return self._covariance.copy()

    @property
    def energy(self) -> EnergyAccount:
        """What the source has used so far."""
        return EnergyAccount(
            float(self._memory[at.ON_TIME]),
            float(self._memory[at.CHARGE]),
            float(self._memory[at.ENERGY]),
            int(self._counters[at.PULSES]),
            int(self._counters[at.MISSED]),
        )

    @property
    def gyroscope_bias_radps(self) -> tuple[Float, Float]:
        """Offsets of the gyroscopes of sensor and source."""
        return (
            self._nominal[at.RATE_BIAS : at.RATE_BIAS + 3].copy(),
            self._nominal[at.SOURCE_RATE_BIAS : at.SOURCE_RATE_BIAS + 3].copy(),
        )

    def set_pose(self, position_m: Float, q_source_sensor: Float, covariance: Float) -> None:
        """Start from a pose that is known otherwise, at rest, without standstill or burst."""
        self._nominal[at.POSITION : at.POSITION + 3] = position_m
        self._nominal[at.ATTITUDE : at.ATTITUDE + 4] = rotation.normalize(q_source_sensor)
        p = self._parameters
        sigma = 1.5 * p.rate_sigma_radps / np.sqrt(self._settings[at.CALIBRATE_TICKS]) + 1e-4
        variances = np.repeat(
            [0.0, 0.01, 0.0, p.force_bias_sigma_mps2, sigma, p.force_bias_sigma_mps2, sigma], 3
        )
        self._covariance[:] = np.diag(variances**2)
        self._covariance[np.ix_(at.POSE, at.POSE)] = covariance
        self._memory[at.SENSITIVITY : at.MEMORY] = 0.0
        self._counters[at.PHASE] = at.TRACK
        self._counters[at.STARTED] = 1
        self._counters[at.RESTARTED] += 1
