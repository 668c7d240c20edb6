"""What every estimator with a compiled Kalman filter keeps: its arrays, their storage and the checks."""

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from estimators.errors import SetupError
from estimators.orientation._contract import OrientationEstimator, OrientationResult
from estimators.orientation._parameters import read_parameters
from estimators.orientation._streaming import ChunkGuard, bias_array, copied
from estimators.recording import Float, ImuChunk

_STATE = ("q", "bias", "covariance", "memory", "counters")
NO_FIELD = np.empty((0, 0, 3))


class KernelEstimator(OrientationEstimator):
    """State, storage and the call of a kernel; subclasses name their parameters, arrays and kernel.

    Class attributes: `_parameter_kind` is the dataclass of the parameters, `_positive` the names that must
    be above zero; `_covariance_size` counts the filter's states, the three of the gyroscope bias at
    `_bias_first`; `_memory_columns` and `_counter_columns` are what else it carries per sensor.
    """

    _parameter_kind: ClassVar[type[Any]]
    _positive: ClassVar[tuple[str, ...]] = ()
    _covariance_size: ClassVar[int]
    _bias_first: ClassVar[int]
    _memory_columns: ClassVar[int]
    _counter_columns: ClassVar[int]

    def __init__(
        self, sensor_count: int, time_step_s: float, parameters: Mapping[str, Any] | None = None
    ) -> None:
        self._guard = ChunkGuard(sensor_count, time_step_s)
        self._parameters = read_parameters(self._parameter_kind, parameters)
        for name, value in asdict(self._parameters).items():
            if not isinstance(value, bool) and value < 0.0:
                raise SetupError(f"{name} must not be negative, not {value}")
        for name in self._positive:
            if getattr(self._parameters, name) <= 0.0:
                raise SetupError(f"{name} must be above zero")
        self._settings = self._make_settings()
        size = self._covariance_size
        self._q = np.tile(np.array([1.0, 0.0, 0.0, 0.0]), (sensor_count, 1))
        self._bias = np.zeros((sensor_count, 3))
        self._covariance = np.zeros((sensor_count, size, size))
        self._memory = np.zeros((sensor_count, self._memory_columns))
        self._counters = np.zeros((sensor_count, self._counter_columns), dtype=np.int64)

    @abstractmethod
    def _make_settings(self) -> Float:
        """Return the derived constants in the order of the kernel."""

    @abstractmethod
    def _run(self, *arrays: NDArray[Any]) -> None:
        """Call the kernel."""

    def _set_bias_covariance(self, sigma_radps: float) -> None:
        first = self._bias_first
        self._covariance[:, first : first + 3, :] = 0.0
        self._covariance[:, :, first : first + 3] = 0.0
        for axis in range(first, first + 3):
            self._covariance[:, axis, axis] = sigma_radps**2

    def _filter(self, chunk: ImuChunk, field: Float | None, *more: NDArray[Any]) -> OrientationResult:
        """Run the kernel over a chunk that was accepted; `more` are further output arrays of the kernel."""
        shape = chunk.gyroscope_radps.shape[:2]
        # One piece of memory: the system gives a large one in large pages, which cost less than many small ones.
        ticks = shape[0] * shape[1]
        whole = np.empty(10 * ticks)
        q = whole[: 4 * ticks].reshape(*shape, 4)
        bias = whole[4 * ticks : 7 * ticks].reshape(*shape, 3)
        sigma = whole[7 * ticks :].reshape(*shape, 3)
        flags = np.empty(shape, dtype=np.uint8)
        self._run(
            np.ascontiguousarray(chunk.gyroscope_radps, dtype=np.float64),
            np.ascontiguousarray(chunk.accelerometer_mps2, dtype=np.float64),
            np.ascontiguousarray(NO_FIELD if field is None else field, dtype=np.float64),
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
            *more,
        )
        return OrientationResult(q, bias, sigma, flags)

    def update(self, chunk: ImuChunk) -> OrientationResult:
        """Take the next ticks; see the contract."""
        chunk = self._guard.accept(chunk)
        return self._filter(chunk, chunk.magnetometer_t)

    def state(self) -> dict[str, NDArray[Any]]:
        """Return quaternions (in the kernel's frame), biases, covariances and counts of all sensors."""
        arrays = {name: getattr(self, f"_{name}").copy() for name in _STATE}
        next_tick = np.array(self._guard.next_tick, dtype=np.int64)
        return arrays | {"next_tick": next_tick, "screen": self._guard.memory.copy()}

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Continue from `state` of an estimator built alike."""
        restored = {name: copied(state, name, getattr(self, f"_{name}")) for name in _STATE}
        next_tick = copied(state, "next_tick", np.array(0, dtype=np.int64))
        screen = copied(state, "screen", self._guard.memory)
        for name, values in restored.items():
            setattr(self, f"_{name}", values)
        self._guard.next_tick, self._guard.memory = int(next_tick), screen

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
        """Covariance of the filter's states now, shape (S, n, n), in the units and order of the kernel."""
        return self._covariance.copy()


__all__ = ["NO_FIELD", "KernelEstimator"]
