"""VQF (Laidig and Seel, 2023) behind the contract; its own package is the oracle in the tests."""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from estimators import rotation
from estimators.errors import SetupError
from estimators.orientation import _vqf_steps as steps
from estimators.orientation._contract import OrientationEstimator, OrientationResult
from estimators.orientation._parameters import read_parameters
from estimators.orientation._streaming import ChunkGuard, bias_array, copied, usable_samples
from estimators.orientation._vqf_kernel import run
from estimators.orientation._vqf_quality import COUNTERS, annotate
from estimators.recording import Float, ImuChunk

_ABOVE_ZERO = (
    "accelerometer_time_constant_s",
    "rest_time_constant_s",
    "bias_forgetting_time_s",
    "magnetic_rejection_factor",
)


@dataclass(frozen=True)
class VqfParameters:
    """The parameters of the authors' package under names with units, at its defaults, and five of ours.

    `restart_*_weight_s`: after a gap the inclination and heading held through it count as much as that
    many seconds of new measurements. `magnetometer_latency_s`: the magnetometer's delay against the
    gyroscope, undone to first order by the measured rate.
    """

    accelerometer_time_constant_s: float = 3.0
    magnetometer_time_constant_s: float = 9.0
    motion_bias_estimation: bool = True
    rest_bias_estimation: bool = True
    magnetic_disturbance_rejection: bool = True
    bias_sigma_initial_degps: float = 0.5
    bias_forgetting_time_s: float = 100.0
    bias_clip_degps: float = 2.0
    bias_sigma_motion_degps: float = 0.1
    bias_vertical_forgetting_factor: float = 0.0001
    bias_sigma_rest_degps: float = 0.03
    rest_minimum_s: float = 1.5
    rest_time_constant_s: float = 0.5
    rest_gyroscope_threshold_degps: float = 2.0
    rest_accelerometer_threshold_mps2: float = 0.5
    magnetic_current_time_constant_s: float = 0.05
    magnetic_reference_time_constant_s: float = 20.0
    magnetic_norm_tolerance: float = 0.1
    magnetic_dip_tolerance_deg: float = 10.0
    magnetic_new_field_s: float = 20.0
    magnetic_first_field_s: float = 5.0
    magnetic_new_field_minimum_degps: float = 20.0
    magnetic_minimum_undisturbed_s: float = 0.5
    magnetic_maximum_rejection_s: float = 60.0
    magnetic_rejection_factor: float = 2.0
    magnetometer_latency_s: float = 0.0
    restart_inclination_weight_s: float = 0.1
    restart_heading_weight_s: float = 0.25
    convergence_s: float = 3.0
    acceleration_tolerance_mps2: float = 2.0


_OWN_STATE = ("states", "q_earth_sensor", "counters")
_NO_FIELD = np.empty((0, 0, 3))


class VqfEstimator(OrientationEstimator):
    """VQF for a network, with gaps, flags and an error budget (see `_vqf_quality.annotate`).

    Without MISSING samples the estimate is that of `vqf.VQF.updateBatch`, sensor by sensor, with the
    magnetometer where it is finite. A MISSING sample holds the last orientation; the first usable one
    after it restarts the averaging of inclination and heading around the held values and keeps the
    gyroscope bias and the reference field.
    """

    name: ClassVar[str] = "vqf"
    version: ClassVar[str] = "1"
    title: ClassVar[str] = "VQF"
    description: ClassVar[str] = (
        "Learns the sensor's drift while still and moving and ignores passing magnetic disturbances; "
        "widely used and well proven."
    )

    def __init__(
        self, sensor_count: int, time_step_s: float, parameters: Mapping[str, Any] | None = None
    ) -> None:
        self._guard = ChunkGuard(sensor_count, time_step_s)
        self._parameters = read_parameters(VqfParameters, parameters)
        for name, value in asdict(self._parameters).items():
            if name in _ABOVE_ZERO and value <= 0.0:
                raise SetupError(f"{name} must be above zero, not {value}")
        self._settings = _settings(self._parameters, self._guard.time_step_s)
        self._states = np.zeros((sensor_count, steps.STATE))
        self._states[:, [steps.GYROSCOPE_Q, steps.ACCELEROMETER_Q, steps.START_GAIN]] = 1.0
        self._states[:, steps.FIELD_REJECTED] = 1.0
        self._states[:, steps.REJECTED_S] = self._parameters.magnetic_maximum_rejection_s
        self._states[:, steps.CANDIDATE_NORM] = -1.0
        self._set_bias_variance(self._settings[steps.BIAS_START_VARIANCE])
        self._q_earth_sensor = rotation.identity((sensor_count,))
        self._counters = np.zeros((sensor_count, COUNTERS), dtype=np.int64)
        self._counters[:, 0] = -1

    def _set_bias_variance(self, variance: float) -> None:
        first = steps.BIAS_COVARIANCE
        self._states[:, first : first + 9] = 0.0
        self._states[:, first : first + 9 : 4] = variance

    def update(self, chunk: ImuChunk) -> OrientationResult:
        """Take the next ticks; see the contract."""
        chunk = self._guard.accept(chunk)
        shape = (chunk.sensor_count, chunk.tick_count)
        accelerometer = np.ascontiguousarray(chunk.accelerometer_mps2, dtype=np.float64)
        field = _NO_FIELD if chunk.magnetometer_t is None else chunk.magnetometer_t
        usable = usable_samples(chunk)
        q, bias, sigma = np.empty((*shape, 4)), np.empty((*shape, 3)), np.empty((*shape, 3))
        bias_sigma, flags = np.empty(shape), np.empty(shape, dtype=np.uint8)
        measured, rejected = np.empty(shape, dtype=np.bool_), np.empty(shape, dtype=np.bool_)
        run(
            np.ascontiguousarray(chunk.gyroscope_radps, dtype=np.float64),
            accelerometer,
            np.ascontiguousarray(field, dtype=np.float64),
            usable,
            self._settings,
            self._states,
            self._q_earth_sensor,
            q,
            bias,
            bias_sigma,
            measured,
            rejected,
        )
        annotate(
            accelerometer,
            np.ascontiguousarray(chunk.quality, dtype=np.uint8),
            usable,
            measured,
            rejected,
            bias_sigma,
            self._counters,
            self._guard.time_step_s,
            self._parameters.convergence_s,
            self._parameters.acceleration_tolerance_mps2,
            self._parameters.accelerometer_time_constant_s,
            flags,
            sigma,
        )
        return OrientationResult(q, bias, sigma, flags)

    def state(self) -> dict[str, NDArray[Any]]:
        """Return the filters' states, one row a sensor (see `_vqf_steps`), the held attitudes and counts."""
        arrays = {name: getattr(self, f"_{name}").copy() for name in _OWN_STATE}
        next_tick = np.array(self._guard.next_tick, dtype=np.int64)
        return arrays | {"next_tick": next_tick, "screen": self._guard.memory.copy()}

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Continue from `state` of an estimator built alike."""
        restored = {name: copied(state, name, getattr(self, f"_{name}")) for name in _OWN_STATE}
        next_tick = copied(state, "next_tick", np.array(0, dtype=np.int64))
        screen = copied(state, "screen", self._guard.memory)
        for name, values in restored.items():
            setattr(self, f"_{name}", values)
        self._guard.next_tick, self._guard.memory = int(next_tick), screen

    def set_gyroscope_bias(self, bias_radps: Float, sigma_radps: float) -> None:
        """Take a static calibration, shape (S, 3), with its standard error."""
        bias = bias_array(bias_radps, sigma_radps, self._guard.sensor_count)
        self._states[:, steps.BIAS : steps.BIAS + 3] = bias
        self._set_bias_variance(_in_bias_units(math.degrees(sigma_radps)) ** 2)

    @property
    def parameters(self) -> dict[str, Any]:
        """Every parameter with its value."""
        return asdict(self._parameters)


def _in_bias_units(degps: float) -> float:
    """Convert degrees a second to the 0.01 degrees a second of the bias covariance."""
    return 100.0 * degps


def _butterworth(time_constant_s: float, step_s: float) -> list[float]:
    """Return b0 b1 b2 a1 a2 of the second-order low-pass with this time constant, and the constant.

    The time constant is that of the damped step response. Shorter than half a step, nothing is filtered.
    """
    if time_constant_s < 0.5 * step_s:
        return [1.0, 0.0, 0.0, 0.0, 0.0, time_constant_s]
    c = math.tan(math.sqrt(2.0) / 2.0 / time_constant_s * step_s)
    d = c * c + math.sqrt(2.0) * c + 1.0
    b0 = c * c / d
    return [
        b0,
        2.0 * b0,
        b0,
        2.0 * (c * c - 1.0) / d,
        (1.0 - math.sqrt(2.0) * c + c * c) / d,
        time_constant_s,
    ]


def _gain(time_constant_s: float, step_s: float) -> float:
    """Return the gain of a first-order low-pass: none below zero, all at zero."""
    if time_constant_s < 0.0:
        return 0.0
    return 1.0 if time_constant_s == 0.0 else -math.expm1(-step_s / time_constant_s)


def _settings(p: VqfParameters, step_s: float) -> Float:
    """Return the derived constants in the order of `_vqf_steps`."""
    # The drift brings the bias from known to 0.1 degrees a second of doubt in the forgetting time.
    drift = _in_bias_units(0.1) ** 2 * step_s / p.bias_forgetting_time_s

    def weight(sigma_degps: float) -> float:
        """Measurement variance that makes this sigma the steady state."""
        variance = _in_bias_units(sigma_degps) ** 2
        return variance**2 / drift + variance

    motion_weight = weight(p.bias_sigma_motion_degps)
    settings = np.zeros(steps.SETTINGS)
    settings[steps.STEP_S] = step_s
    for first, time_constant_s in (
        (steps.FORCE_COEFFICIENTS, p.accelerometer_time_constant_s),
        (steps.REST_COEFFICIENTS, p.rest_time_constant_s),
        (steps.FIELD_COEFFICIENTS, p.magnetic_current_time_constant_s),
    ):
        settings[first : first + 6] = _butterworth(time_constant_s, step_s)
    for position, value in (
        (steps.HEADING_GAIN, _gain(p.magnetometer_time_constant_s, step_s)),
        (steps.REFERENCE_GAIN, _gain(p.magnetic_reference_time_constant_s, step_s)),
        (steps.MOTION_BIAS, float(p.motion_bias_estimation)),
        (steps.REST_BIAS, float(p.rest_bias_estimation)),
        (steps.REJECTION, float(p.magnetic_disturbance_rejection)),
        (steps.BIAS_START_VARIANCE, _in_bias_units(p.bias_sigma_initial_degps) ** 2),
        (steps.BIAS_DRIFT, drift),
        (steps.BIAS_LIMIT, math.radians(p.bias_clip_degps)),
        (steps.MOTION_WEIGHT, motion_weight),
        (steps.VERTICAL_WEIGHT, motion_weight / max(p.bias_vertical_forgetting_factor, 1e-10)),
        (steps.REST_WEIGHT, weight(p.bias_sigma_rest_degps)),
        (steps.REST_MINIMUM_S, p.rest_minimum_s),
        (steps.REST_RATE_LIMIT, math.radians(p.rest_gyroscope_threshold_degps)),
        (steps.REST_FORCE_LIMIT, p.rest_accelerometer_threshold_mps2),
        (steps.NORM_TOLERANCE, p.magnetic_norm_tolerance),
        (steps.DIP_TOLERANCE, math.radians(p.magnetic_dip_tolerance_deg)),
        (steps.NEW_FIELD_S, p.magnetic_new_field_s),
        (steps.FIRST_FIELD_S, p.magnetic_first_field_s),
        (steps.NEW_FIELD_RATE, math.radians(p.magnetic_new_field_minimum_degps)),
        (steps.UNDISTURBED_MINIMUM_S, p.magnetic_minimum_undisturbed_s),
        (steps.REJECTED_MAXIMUM_S, p.magnetic_maximum_rejection_s),
        (steps.REJECTION_FACTOR, p.magnetic_rejection_factor),
        (steps.HEADING_TIME_S, p.magnetometer_time_constant_s),
        (steps.LATENCY_S, p.magnetometer_latency_s),
        (steps.RESTART_TILT_SAMPLES, p.restart_inclination_weight_s / step_s),
        (steps.RESTART_GAIN, 1.0 / (1.0 + p.restart_heading_weight_s / step_s)),
    ):
        settings[position] = value
    return settings


__all__ = ["VqfEstimator", "VqfParameters"]
