"""Shared checks and counts of all streaming orientation estimators."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.errors import SetupError, ShapeError
from estimators.orientation._contract import OrientationFlag
from estimators.orientation._screen import SampleScreen
from estimators.recording import Float, ImuChunk, SampleQuality

MAXIMUM_SENSORS = 255
_NEVER = -1
_DISTURBANCE = np.uint8(OrientationFlag.MAGNETIC_DISTURBANCE)


class ChunkGuard:
    """Checks that chunks fit the network and follow each other, and takes samples out that cannot be true.

    Parameters
    ----------
    is_whole : bool
        One chunk will be the whole session (`SampleScreen`).
    """

    def __init__(self, sensor_count: int, time_step_s: float, *, is_whole: bool = False) -> None:
        if not 1 <= sensor_count <= MAXIMUM_SENSORS:
            raise SetupError(f"{sensor_count} sensors; an estimator serves 1 to {MAXIMUM_SENSORS}")
        if not 1e-4 <= time_step_s <= 1.0:
            raise SetupError(f"time step {time_step_s} s; it must lie between 0.0001 and 1 s")
        self.sensor_count = sensor_count
        self.time_step_s = float(time_step_s)
        self.next_tick = _NEVER
        self._screen = SampleScreen(sensor_count, self.time_step_s, is_whole=is_whole)

    @property
    def memory(self) -> Float:
        """What judging the next sample depends on, shape (S, ...); part of every stored state."""
        return self._screen.memory

    @memory.setter
    def memory(self, values: Float) -> None:
        self._screen.memory = values

    def flag_lost_field(self, flags: NDArray[np.uint8]) -> None:
        """Flag MAGNETIC_DISTURBANCE, in place, where the chunk last accepted had a field that cannot be one."""
        if self._screen.lost_field is not None:
            flags |= np.where(self._screen.lost_field, _DISTURBANCE, np.uint8(0))

    def accept(self, chunk: ImuChunk) -> ImuChunk:
        """Return the chunk with wild samples MISSING; `ShapeError` unless it is the next one of this network."""
        first, ticks = chunk.first_tick, chunk.tick_count
        expected = (self.sensor_count, ticks, 3)
        field = chunk.magnetometer_t
        if (
            chunk.gyroscope_radps.shape != expected
            or chunk.accelerometer_mps2.shape != expected
            or (field is not None and field.shape != expected)
        ):
            raise _wrong_shape(chunk, expected)
        if chunk.quality.shape != expected[:2]:
            raise ShapeError(f"quality has shape {chunk.quality.shape}; it must be {expected[:2]}")
        if abs(chunk.time_step_s - self.time_step_s) > 1e-9 * self.time_step_s:
            raise ShapeError(
                f"chunk at {chunk.time_step_s} s per tick; the estimator runs at {self.time_step_s}"
            )
        if self.next_tick not in (_NEVER, first):
            raise ShapeError(f"chunk starts at tick {first}; tick {self.next_tick} is next")
        self.next_tick = first + ticks
        return self._screen.screened(chunk)


def _wrong_shape(chunk: ImuChunk, expected: tuple[int, int, int]) -> ShapeError:
    for name in ("gyroscope_radps", "accelerometer_mps2", "magnetometer_t"):
        values = getattr(chunk, name)
        if values is not None and values.shape != expected:
            return ShapeError(f"{name} has shape {values.shape}; this network needs {expected}")
    return ShapeError(f"this network needs {expected}")


def usable_samples(chunk: ImuChunk) -> NDArray[np.bool_]:
    """Return where gyroscope and accelerometer hold something to work with, shape (S, K)."""
    missing = (chunk.quality & int(SampleQuality.MISSING)) != 0
    # One sum per sample is NaN or infinite exactly when a part is (or overflows, which is as bad).
    with np.errstate(over="ignore", invalid="ignore"):
        total = chunk.gyroscope_radps.sum(axis=-1) + chunk.accelerometer_mps2.sum(axis=-1)
    return np.asarray(np.isfinite(total) & ~missing)


def bias_array(bias_radps: Float, sigma_radps: float, sensor_count: int) -> Float:
    """Check a static calibration and return the bias as (S, 3)."""
    bias = np.ascontiguousarray(bias_radps, dtype=np.float64)
    if bias.shape != (sensor_count, 3) or not np.isfinite(bias).all():
        raise ShapeError(f"gyroscope bias must be finite numbers of shape ({sensor_count}, 3)")
    if not (np.isfinite(sigma_radps) and sigma_radps > 0.0):
        raise ShapeError(f"standard error of the bias must be above zero, not {sigma_radps}")
    return bias


def copied(state: Mapping[str, NDArray[Any]], name: str, like: NDArray[Any]) -> NDArray[Any]:
    """Return a stored array, checked against the one it replaces."""
    if name not in state:
        raise ShapeError(f"the stored state has no {name}; it was made by another version")
    values = np.array(state[name], dtype=like.dtype, order="C")
    if values.shape != like.shape:
        raise ShapeError(f"stored {name} has shape {values.shape}; this estimator needs {like.shape}")
    return values
