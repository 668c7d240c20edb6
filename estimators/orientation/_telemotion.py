"""Our own online estimator behind the contract."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from estimators.conventions import GRAVITY_MPS2
from estimators.errors import SetupError, ShapeError
from estimators.orientation import _telemotion_layout as at
from estimators.orientation._contract import OrientationResult
from estimators.orientation._kernel_estimator import KernelEstimator
from estimators.orientation._telemotion_kernel import run
from estimators.orientation._telemotion_parameters import (
    POSITIVE,
    TelemotionParameters,
    ordered,
    settings_of,
)
from estimators.recording import Float, ImuChunk

MICROTESLA_PER_TESLA = 1e6


@dataclass(frozen=True)
class DeviceConstants:
    """What belongs to the sensors and not to the session, with one standard error for each kind.

    Attributes
    ----------
    magnetometer_delay_s : ndarray, shape (S,)
        Delay of the magnetometer against the gyroscope.
    gyroscope_gain : ndarray, shape (S, 3, 3)
        Scale and axis errors K: true rate = (I + K) measured - bias.
    hard_iron_t : ndarray, shape (S, 3)
        Sensor axes.
    gyroscope_clip_radps : ndarray, shape (S,)
        Largest rate that the device shows; infinite where it was never reached.
    magnetometer_delay_sigma_s, gyroscope_gain_sigma, hard_iron_sigma_t : float
    """

    magnetometer_delay_s: Float
    gyroscope_gain: Float
    hard_iron_t: Float
    gyroscope_clip_radps: Float
    magnetometer_delay_sigma_s: float = 0.002
    gyroscope_gain_sigma: float = 0.003
    hard_iron_sigma_t: float = 0.3e-6

    def __post_init__(self) -> None:
        sensors = np.shape(self.magnetometer_delay_s)
        for name, shape in (
            ("magnetometer_delay_s", sensors),
            ("gyroscope_gain", (*sensors, 3, 3)),
            ("hard_iron_t", (*sensors, 3)),
            ("gyroscope_clip_radps", sensors),
        ):
            values = getattr(self, name)
            if len(sensors) != 1 or np.shape(values) != shape:
                raise ShapeError(f"{name} has shape {np.shape(values)}; it must be {shape}")
            if not (np.isfinite(values).all() or name == "gyroscope_clip_radps"):
                raise ShapeError(f"{name} must be finite")
        for name in ("magnetometer_delay_sigma_s", "gyroscope_gain_sigma", "hard_iron_sigma_t"):
            if not getattr(self, name) > 0.0:
                raise ShapeError(f"{name} must be above zero")


class TelemotionEstimator(KernelEstimator):
    """Error-state filter that also learns gyroscope gain, magnetometer delay, hard iron and the room's field.

    Each sample turns the attitude; every `block_s` a Kalman filter of 31 states corrects it, and corrections
    enter the output gradually (`return_*`), so that it never jumps faster than the stated rate except where a
    heading is found for the first time or after a gap longer than `coast_s` (CONVERGING). Inside shorter gaps,
    MISSING or BRIDGED, the output runs on; once over, they are filled anew from the samples around them.

    Sigma is the covariance scaled to what the errors were found to be, with floors for what no sensor shows,
    and the part of a correction that is still to come.
    """

    name: ClassVar[str] = "telemotion"
    version: ClassVar[str] = "1"
    title: ClassVar[str] = "Telemotion"
    description: ClassVar[str] = (
        "Also learns each sensor's own errors and nearby magnets while it is worn; the most accurate live estimate."
    )
    _parameter_kind = TelemotionParameters
    _positive = POSITIVE
    _covariance_size = at.STATES
    _bias_first = at.BIAS
    _memory_columns = at.MEMORY
    _counter_columns = at.COUNTERS
    _parameters: TelemotionParameters

    def __init__(
        self, sensor_count: int, time_step_s: float, parameters: Mapping[str, Any] | None = None
    ) -> None:
        super().__init__(sensor_count, time_step_s, parameters)
        wrong = ordered(self._parameters)
        if wrong:
            raise SetupError(wrong)
        p = self._parameters
        self._set_variance(at.BIAS, 3, np.deg2rad(p.bias_start_sigma_degps) ** 2)
        self._set_variance(at.GAIN, 9, p.gain_sigma**2)
        self._set_variance(at.IRON, 3, p.iron_wide_ut**2)
        self._set_variance(at.DELAY, 1, p.delay_sigma_s**2)
        self._set_variance(at.START, 3, p.start_wide_ut**2)
        self._memory[:, at.GRAVITY] = GRAVITY_MPS2
        self._memory[:, at.CORRECTION] = self._memory[:, at.SHOWN] = 1.0

    def _make_settings(self) -> Float:
        return settings_of(self._parameters, self._guard.time_step_s)

    def _run(self, *arrays: NDArray[Any]) -> None:
        run(*arrays)

    def _set_variance(self, first: int, count: int, variance: float) -> None:
        span = slice(first, first + count)
        self._covariance[:, span, :] = 0.0
        self._covariance[:, :, span] = 0.0
        for i in range(first, first + count):
            self._covariance[:, i, i] = variance

    def update(self, chunk: ImuChunk) -> OrientationResult:
        """Take the next ticks; see the contract."""
        self._guard.accept(chunk)
        self._counters[:, at.TICK] = chunk.first_tick
        return self._filter(chunk, chunk.magnetometer_t)

    def set_device_constants(self, constants: DeviceConstants) -> None:
        """Begin with what an earlier session learnt about the same devices, before the first sample."""
        sensors = self._guard.sensor_count
        if np.shape(constants.magnetometer_delay_s) != (sensors,):
            raise ShapeError(f"constants of {np.shape(constants.magnetometer_delay_s)} sensors for {sensors}")
        iron_variance = (MICROTESLA_PER_TESLA * constants.hard_iron_sigma_t) ** 2
        self._memory[:, at.DELAY] = constants.magnetometer_delay_s
        self._memory[:, at.GAIN : at.GAIN + 9] = np.swapaxes(constants.gyroscope_gain, 1, 2).reshape(
            sensors, 9
        )
        iron = MICROTESLA_PER_TESLA * constants.hard_iron_t
        self._memory[:, at.IRON : at.IRON + 3] = self._memory[:, at.IRON_KNOWN : at.IRON_KNOWN + 3] = iron
        self._memory[:, at.IRON_KNOWN_VARIANCE] = iron_variance
        self._set_variance(at.DELAY, 1, constants.magnetometer_delay_sigma_s**2)
        self._set_variance(at.GAIN, 9, constants.gyroscope_gain_sigma**2)
        self._set_variance(at.IRON, 3, self._parameters.iron_wide_ut**2 + iron_variance)

    @property
    def nominal(self) -> Float:
        """The filter's states now, shape (S, STATES), in the order and units of `_telemotion_layout`."""
        states = self._memory[:, : at.STATES].copy()
        states[:, at.BIAS : at.BIAS + 3] = self._bias
        return states

    @property
    def hypothesis_odds(self) -> Float:
        """Odds of the nine hypotheses, hard iron leading, start place within, shape (S, 9)."""
        odds = self._memory[:, at.ODDS : at.ODDS + 9].copy()
        odds[odds.sum(axis=1) == 0.0, 0] = 1.0
        return odds

    @property
    def hard_iron_changes(self) -> NDArray[np.int64]:
        """How often each sensor's hard iron was found to have changed, shape (S,)."""
        return self._counters[:, at.OPENED].copy()

    @property
    def device_constants(self) -> DeviceConstants:
        """What has been learnt so far; the clip level is not this filter's to know."""
        gain = self._memory[:, at.GAIN : at.GAIN + 9].reshape(-1, 3, 3)
        return DeviceConstants(
            self._memory[:, at.DELAY].copy(),
            np.swapaxes(gain, 1, 2).copy(),
            self._memory[:, at.IRON : at.IRON + 3] / MICROTESLA_PER_TESLA,
            np.full(len(gain), np.inf),
        )


__all__ = ["MICROTESLA_PER_TESLA", "DeviceConstants", "TelemotionEstimator"]
