"""Shared parts of estimators whose compiled filter works on records: the call, arrays, storage and checks."""

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from estimators.kernels import filled, restored
from estimators.orientation._contract import OrientationEstimator, OrientationResult
from estimators.orientation._parameters import read_parameters
from estimators.orientation._strapdown_steps import Estimates, Ticks
from estimators.orientation._streaming import ChunkGuard, bias_array
from estimators.recording import Float, ImuChunk

_NO_FIELD, _NO_DETAILS = np.empty((0, 0, 3)), np.empty((0, 0, 0))


class RecordEstimator(OrientationEstimator):
    """Settings, state and covariance of a filter; subclasses name their parameters, records and kernel.

    Class attributes: `_parameter_kind` is the dataclass of the parameters; `_settings_kind` and `_state_kind` are the
    dtypes of the kernel's records, the latter with `q` and `bias`; `_covariance_size` counts the filter's states, the
    three of the gyroscope bias at `_bias_first`.
    """

    _parameter_kind: ClassVar[type[Any]]
    _settings_kind: ClassVar[np.dtype[Any]]
    _state_kind: ClassVar[np.dtype[Any]]
    _covariance_size: ClassVar[int]
    _bias_first: ClassVar[int]

    def __init__(
        self, sensor_count: int, time_step_s: float, parameters: Mapping[str, Any] | None = None
    ) -> None:
        self._guard = ChunkGuard(sensor_count, time_step_s)
        self._parameters = read_parameters(self._parameter_kind, parameters)
        self._settings = filled(self._settings_kind, self._make_settings())
        self._state = np.zeros(sensor_count, dtype=self._state_kind)
        self._state["q"][:, 0] = 1.0
        self._covariance = np.zeros((sensor_count, self._covariance_size, self._covariance_size))

    @abstractmethod
    def _make_settings(self) -> dict[str, Any]:
        """Return the derived constants by the names of the settings' record."""

    def _set_bias_covariance(self, sigma_radps: float) -> None:
        bias = slice(self._bias_first, self._bias_first + 3)
        self._covariance[:, bias, :] = self._covariance[:, :, bias] = 0.0
        self._covariance[:, bias, bias] = sigma_radps**2 * np.eye(3)

    @abstractmethod
    def _run(self, *arguments: Any) -> None:
        """Call the kernel: ticks, settings, state, covariance, estimates."""

    def _filter(self, chunk: ImuChunk, field: Float | None, details: Float = _NO_DETAILS) -> Estimates:
        """Run the kernel over a chunk that was accepted; `details` is what else it is to write."""
        shape = chunk.gyroscope_radps.shape[:2]
        # One piece of memory: the system gives a large one in large pages, which cost less than many small ones.
        ticks_in_all = shape[0] * shape[1]
        whole, bias_at, sigma_at = np.empty(10 * ticks_in_all), 4 * ticks_in_all, 7 * ticks_in_all
        out = Estimates(
            whole[:bias_at].reshape(*shape, 4),
            whole[bias_at:sigma_at].reshape(*shape, 3),
            whole[sigma_at:].reshape(*shape, 3),
            np.empty(shape, dtype=np.uint8),
            details,
        )
        ticks = Ticks(
            np.ascontiguousarray(chunk.gyroscope_radps, dtype=np.float64),
            np.ascontiguousarray(chunk.accelerometer_mps2, dtype=np.float64),
            np.ascontiguousarray(_NO_FIELD if field is None else field, dtype=np.float64),
            np.ascontiguousarray(chunk.quality, dtype=np.uint8),
        )
        self._run(ticks, self._settings, self._state, self._covariance, out)
        return out

    def update(self, chunk: ImuChunk) -> OrientationResult:
        """Take the next ticks; see the contract."""
        chunk = self._guard.accept(chunk)
        out = self._filter(chunk, chunk.magnetometer_t)
        return OrientationResult(out.q, out.bias, out.sigma_rad, out.flags)

    def state(self) -> dict[str, NDArray[Any]]:
        """Return the records and covariances of all sensors, copied."""
        return {
            "state": self._state.copy(),
            "covariance": self._covariance.copy(),
            "next_tick": np.array(self._guard.next_tick, dtype=np.int64),
            "screen": self._guard.memory.copy(),
        }

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Continue from `state` of an estimator built alike."""
        records = restored(state, "state", self._state)
        covariance = restored(state, "covariance", self._covariance)
        next_tick = restored(state, "next_tick", np.array(0, dtype=np.int64))
        screen = restored(state, "screen", self._guard.memory)
        self._state, self._covariance = records, covariance
        self._guard.next_tick, self._guard.memory = int(next_tick), screen

    def set_gyroscope_bias(self, bias_radps: Float, sigma_radps: float) -> None:
        """Take a static calibration, shape (S, 3), with its standard error."""
        self._state["bias"] = bias_array(bias_radps, sigma_radps, self._guard.sensor_count)
        self._set_bias_covariance(sigma_radps)

    @property
    def parameters(self) -> dict[str, Any]:
        """Every parameter with its value."""
        return asdict(self._parameters)

    @property
    def covariance(self) -> Float:
        """Covariance of the filter's states now, shape (S, n, n), in the units and order of the kernel."""
        return self._covariance.copy()
