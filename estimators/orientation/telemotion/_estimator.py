"""Our own online estimator behind the contract."""

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from estimators.conventions import GRAVITY_MPS2
from estimators.errors import ShapeError
from estimators.orientation._contract import OrientationResult
from estimators.orientation._device_constants import DeviceConstants
from estimators.orientation._record_estimator import RecordEstimator
from estimators.orientation.telemotion import _records as at
from estimators.orientation.telemotion._constants import begin_with, believed, constants_of
from estimators.orientation.telemotion._kernel import run
from estimators.orientation.telemotion._parameters import (
    TelemotionParameters,
    check,
    settings_of,
)
from estimators.recording import Float, ImuChunk

_LEAST_VARIANCE = 1e-12
_SWAY_RADPS = np.deg2rad(0.5)
"""How far a person's sway moves the mean rate of half a second, until it has been seen."""


class TelemotionEstimator(RecordEstimator):
    """Error-state filter that also learns the sensors' offsets and gains, magnetometer delay, hard iron and room field.

    Each sample turns the attitude; every `block_s` a Kalman filter of 35 states corrects it, and corrections
    enter the output gradually (`return_*`), so that it never jumps faster than the stated rate except where a
    heading is found for the first time or after a gap longer than `coast_s` (CONVERGING). Inside shorter gaps,
    MISSING or BRIDGED, the output runs on; once over, they are filled again from the samples around them.

    Sigma is the covariance scaled to what the errors were found to be, with floors for what no sensor shows,
    and the part of a correction that is still to come.
    """

    name: ClassVar[str] = "telemotion"
    version: ClassVar[str] = "10"
    title: ClassVar[str] = "Telemotion"
    description: ClassVar[str] = (
        "Also learns each sensor's own errors and nearby magnets while it is worn; the most accurate live estimate."
    )
    _parameter_kind = TelemotionParameters
    _settings_kind = at.SETTINGS
    _state_kind = at.STATE
    _covariance_size = at.STATES
    _bias_first = at.BIAS
    _parameters: TelemotionParameters

    def __init__(
        self, sensor_count: int, time_step_s: float, parameters: Mapping[str, Any] | None = None
    ) -> None:
        super().__init__(sensor_count, time_step_s, parameters)
        self._given = [DeviceConstants()] * sensor_count
        p = self._parameters
        self._set_variance(at.BIAS, 3, np.deg2rad(p.bias_start_sigma_degps) ** 2)
        self._set_variance(at.GAIN, 9, p.gain_sigma**2)
        self._set_variance(at.IRON, 3, p.iron_wide_ut**2)
        self._set_variance(at.DELAY, 1, p.delay_sigma_s**2)
        self._set_variance(at.START, 3, p.start_wide_ut**2)
        self._set_variance(at.OFFSET, 3, p.force_offset_sigma_mps2**2)
        self._set_variance(at.WEIGHT, 1, p.gravity_sigma_mps2**2)
        x = self._state
        x["gravity"] = GRAVITY_MPS2
        x["gains_settled"] = p.gain_narrow >= p.gain_sigma
        x["quiet"] = p.quiet_ut**2
        x["rest_sway"] = _SWAY_RADPS**2
        x["clip_level"] = np.inf
        x["steady_field"][:, 0] = np.nan
        x["correction"][:, 0] = x["shown"][:, 0] = 1.0

    def _make_settings(self) -> dict[str, float]:
        check(self._parameters)
        return settings_of(self._parameters, self._guard.time_step_s)

    def _run(self, *arguments: Any) -> None:
        run(*arguments)

    def _set_variance(self, first: int, count: int, variance: float, sensor: int | None = None) -> None:
        """Set the variance of some states, of one sensor or of all, and what correlates with them to zero."""
        sensors = slice(None) if sensor is None else slice(sensor, sensor + 1)
        span = slice(first, first + count)
        self._covariance[sensors, span, :] = 0.0
        self._covariance[sensors, :, span] = 0.0
        for i in range(first, first + count):
            self._covariance[sensors, i, i] = variance

    def update(self, chunk: ImuChunk) -> OrientationResult:
        """Take the next ticks; see the contract."""
        chunk = self._guard.accept(chunk)
        self._state["tick"] = chunk.first_tick
        out = self._filter(chunk, chunk.magnetometer_t)
        self._guard.flag_lost_field(out.flags)
        return OrientationResult(out.q, out.bias, out.sigma_rad, out.flags)

    def set_device_constants(self, constants: Sequence[DeviceConstants | None]) -> None:
        """Begin with what earlier sessions learnt about the same devices; call before the first sample."""
        sensors = self._guard.sensor_count
        if len(constants) != sensors:
            raise ShapeError(f"constants of {len(constants)} sensors for {sensors}")
        for s, given in enumerate(constants):
            if given is None:
                continue
            self._given[s] = known = believed(given, self._parameters)
            begin_with(known, self._state[s], self._covariance[s], self._parameters)

    def take_off_force(self, offset_mps2: Float) -> None:
        """Expect specific force less an offset from the next sample on; see the contract."""
        self._state["force_offset"] -= offset_mps2

    @property
    def nominal(self) -> Float:
        """The filter's states now, shape (S, STATES), in the order and units of `_records`."""
        x = self._state
        turn = np.zeros((len(x), 3))
        parts = [x[name] for name in ("velocity", "position", "bias", "gain", "field", "iron")]
        return np.hstack(
            [turn, *parts, x["delay"][:, None], x["start"], x["force_offset"], x["gravity"][:, None]]
        )

    @property
    def hypothesis_odds(self) -> Float:
        """Odds of the nine hypotheses, hard iron leading, start place within, shape (S, 9)."""
        odds = self._state["odds"].copy()
        odds[odds.sum(axis=1) == 0.0, 0] = 1.0
        return odds

    @property
    def hard_iron_changes(self) -> NDArray[np.int64]:
        """How often each sensor's hard iron was found to have changed, shape (S,)."""
        return self._state["opened"].copy()

    @property
    def device_constants(self) -> tuple[DeviceConstants, ...]:
        """What is known of each device now; hard iron only as far as no magnet came near in between."""
        return tuple(self._learnt(s) for s in range(self._guard.sensor_count))

    def _learnt(self, s: int) -> DeviceConstants:
        if self._state["filtered"][s] == 0:
            # It learnt nothing: what is known is what was given, and a prior is no knowledge.
            return self._given[s]
        variance = np.maximum(np.diagonal(self._covariance[s]), _LEAST_VARIANCE)
        gyroscope, accelerometer = (
            float(clip) if np.isfinite(clip) else None for clip in self._state[s]["clip_level"]
        )
        clips = gyroscope, accelerometer
        return constants_of(self.nominal[s], np.sqrt(variance), *self._iron(s), clips, self._parameters)

    def _iron(self, s: int) -> tuple[Float, Float]:
        """Return mean and sigma of the hard iron, microtesla, over the beliefs of what it was at first."""
        memory, p, span = self._state[s], self._parameters, slice(at.IRON, at.IRON + 3)
        known, known_variance = memory["iron_known"], memory["iron_known_variance"]
        if self._state["opened"][s] > 0:
            return known, np.full(3, np.sqrt(known_variance + p.iron_middle_ut**2))
        odds = self.hypothesis_odds[s].reshape(3, 3).sum(axis=1)
        odds = odds / odds.sum()
        wide, covariance = p.iron_wide_ut**2 + known_variance, self._covariance[s, span, span]
        means, variances = np.empty((3, 3)), np.empty((3, 3))
        for i, own in enumerate((p.iron_narrow_ut, p.iron_middle_ut, p.iron_wide_ut)):
            means[i], variances[i] = memory["iron"], np.diagonal(covariance)
            prior = own**2 + known_variance
            if prior < wide:
                # That the iron was N(known, prior) all along, as one measurement more (see `find_north`).
                gain = covariance @ np.linalg.inv(covariance + np.eye(3) / (1.0 / prior - 1.0 / wide))
                means[i] += gain @ (known - memory["iron"])
                variances[i] -= np.diagonal(gain @ covariance)
        mean = odds @ means
        spread = odds @ (variances + (means - mean) ** 2)
        return mean, np.sqrt(np.maximum(spread, _LEAST_VARIANCE))
