"""What the two quaternion filters of the arm-monitoring thesis share behind the contract."""

import math
from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from estimators.conventions import GRAVITY_MPS2
from estimators.errors import SetupError
from estimators.orientation import _marzouk_steps as steps
from estimators.orientation._contract import OrientationEstimator, OrientationResult
from estimators.orientation._parameters import read_parameters
from estimators.orientation._streaming import ChunkGuard, bias_array, copied
from estimators.recording import Float, ImuChunk

_STATE = ("q", "bias", "covariance", "memory", "counters")
_NO_FIELD = np.empty((0, 0, 3))
HEADING_LOST_RAD = math.radians(15.0)


@dataclass(frozen=True)
class SharedParameters:
    """Start, gaps and flags of both filters.

    `reference_rate_hz`: the rate at which the noise sigmas are those of single samples (the thesis
    measured at 17 Hz). At another rate they are scaled so that a second of samples weighs the same:
    errors of slow devices and of motion are correlated, and more samples do not average them away.
    `midpoint_rate`: turn by the mean of this and the last rate instead of this one alone.
    `coast_s`: how long a gap is crossed at the last rate, whose error is taken as `gap_rate_sigma_degps`.
    `magnetic_reference_time_constant_s`: how fast the accepted norm of the field is learned.
    """

    reference_rate_hz: float = 17.0
    midpoint_rate: bool = True
    start_samples: float = 10.0
    initial_attitude_sigma_deg: float = 2.0
    initial_bias_sigma_degps: float = 1.0
    coast_s: float = 0.2
    gap_rate_sigma_degps: float = 57.3
    convergence_s: float = 3.0
    acceleration_tolerance_mps2: float = 2.0
    magnetic_norm_tolerance: float = 0.15
    magnetic_reference_time_constant_s: float = 20.0
    magnetic_trust_s: float = 10.0


class MarzoukEstimator(OrientationEstimator):
    """State, checks and settings; subclasses name the kernel, its covariance and its own settings.

    A MISSING tick is coasted at the last rate with growing covariance, flagged BRIDGED, for at most
    `coast_s`; then the estimate holds, INVALID, and the filter starts again with the next samples,
    keeping the gyroscope bias (and, without a field, the heading). Sigma is the filter's covariance,
    which takes all errors for white noise: it is optimistic where they last.
    """

    _parameter_kind: ClassVar[type[SharedParameters]]
    _covariance_size: ClassVar[int]

    def __init__(
        self, sensor_count: int, time_step_s: float, parameters: Mapping[str, Any] | None = None
    ) -> None:
        self._guard = ChunkGuard(sensor_count, time_step_s)
        self._parameters = read_parameters(self._parameter_kind, parameters)
        for name, value in asdict(self._parameters).items():
            if not isinstance(value, bool) and value < 0.0:
                raise SetupError(f"{name} must not be negative, not {value}")
        for name in ("reference_rate_hz", "start_samples", "magnetic_reference_time_constant_s"):
            if getattr(self._parameters, name) <= 0.0:
                raise SetupError(f"{name} must be above zero")
        self._settings = np.concatenate((self._shared_settings(), self._own_settings()))
        size = self._covariance_size
        # Identity in the product's earth frame, seen from north-east-down.
        self._q = np.tile(np.array([0.0, -math.sqrt(0.5), -math.sqrt(0.5), 0.0]), (sensor_count, 1))
        self._bias = np.zeros((sensor_count, 3))
        self._covariance = np.zeros((sensor_count, size, size))
        self._set_bias_covariance(math.radians(self._parameters.initial_bias_sigma_degps))
        self._memory = np.zeros((sensor_count, steps.MEMORY))
        self._counters = np.zeros((sensor_count, steps.COUNTERS), dtype=np.int64)

    @property
    def _noise_scale(self) -> float:
        """Factor on variances that brings single-sample noise from the reference rate to this one."""
        return 1.0 / (self._parameters.reference_rate_hz * self._guard.time_step_s)

    def _shared_settings(self) -> Float:
        p, step_s = self._parameters, self._guard.time_step_s
        settings = np.zeros(steps.SHARED_SETTINGS)
        settings[steps.STEP_S] = step_s
        settings[steps.MIDPOINT] = p.midpoint_rate
        settings[steps.START_SAMPLES] = p.start_samples
        settings[steps.BRIDGE_TICKS] = math.floor(p.coast_s / step_s + 1e-6)
        settings[steps.CONVERGENCE_TICKS] = p.convergence_s / step_s
        settings[steps.ATTITUDE_SIGMA] = math.radians(p.initial_attitude_sigma_deg)
        settings[steps.GAP_RATE_SIGMA] = math.radians(p.gap_rate_sigma_degps)
        settings[steps.ACCELERATION_TOLERANCE_G] = p.acceleration_tolerance_mps2 / GRAVITY_MPS2
        settings[steps.FIELD_TOLERANCE] = p.magnetic_norm_tolerance
        settings[steps.FIELD_REFERENCE_GAIN] = -math.expm1(-step_s / p.magnetic_reference_time_constant_s)
        settings[steps.DISTURBED_TICKS] = p.magnetic_trust_s / step_s
        settings[steps.HEADING_LOST] = HEADING_LOST_RAD
        return settings

    @abstractmethod
    def _own_settings(self) -> Float:
        """Return the settings of the subclass's kernel, in its order."""

    @abstractmethod
    def _run(self, *arrays: NDArray[Any]) -> None:
        """Call the subclass's kernel."""

    def _set_bias_covariance(self, sigma_radps: float) -> None:
        first = self._covariance_size - 3
        self._covariance[:, first:, :] = 0.0
        self._covariance[:, :, first:] = 0.0
        for axis in range(first, self._covariance_size):
            self._covariance[:, axis, axis] = sigma_radps**2

    def update(self, chunk: ImuChunk) -> OrientationResult:
        """Take the next ticks; see the contract."""
        self._guard.accept(chunk)
        shape = (chunk.sensor_count, chunk.tick_count)
        q, bias, sigma = np.empty((*shape, 4)), np.empty((*shape, 3)), np.empty((*shape, 3))
        flags = np.empty(shape, dtype=np.uint8)
        field = _NO_FIELD if chunk.magnetometer_t is None else chunk.magnetometer_t
        self._run(
            np.ascontiguousarray(chunk.gyroscope_radps, dtype=np.float64),
            np.ascontiguousarray(chunk.accelerometer_mps2, dtype=np.float64),
            np.ascontiguousarray(field, dtype=np.float64),
            np.ascontiguousarray(chunk.quality, dtype=np.uint8),
            self._settings,
            self._q,
            self._bias,
            self._covariance,
            self._memory,
            self._counters,
            q,
            bias,
            sigma,
            flags,
        )
        return OrientationResult(q, bias, sigma, flags)

    def state(self) -> dict[str, NDArray[Any]]:
        """Return quaternions (north-east-down), biases, covariances and counts of all sensors."""
        arrays = {name: getattr(self, f"_{name}").copy() for name in _STATE}
        return arrays | {"next_tick": np.array(self._guard.next_tick, dtype=np.int64)}

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Continue from `state` of an estimator built alike."""
        restored = {name: copied(state, name, getattr(self, f"_{name}")) for name in _STATE}
        next_tick = copied(state, "next_tick", np.array(0, dtype=np.int64))
        for name, values in restored.items():
            setattr(self, f"_{name}", values)
        self._guard.next_tick = int(next_tick)

    def set_gyroscope_bias(self, bias_radps: Float, sigma_radps: float) -> None:
        """Take a static calibration, shape (S, 3), with its standard error."""
        self._bias[:] = bias_array(bias_radps, sigma_radps, self._guard.sensor_count)
        self._set_bias_covariance(sigma_radps)

    @property
    def parameters(self) -> dict[str, Any]:
        """Every parameter with its value."""
        return asdict(self._parameters)

    @property
    def covariance(self) -> Float:
        """Covariance of the filter's state now, shape (S, n, n); the bias (rad/s) is in the last three."""
        return self._covariance.copy()


__all__ = ["MarzoukEstimator", "SharedParameters"]
