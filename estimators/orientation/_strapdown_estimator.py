"""What the filters of Luinge and of Roetenberg share behind the contract."""

import math
from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from estimators.conventions import GRAVITY_MPS2
from estimators.errors import SetupError
from estimators.orientation import _strapdown_steps as steps
from estimators.orientation._contract import OrientationResult
from estimators.orientation._kernel_estimator import KernelEstimator
from estimators.recording import Float, ImuChunk

REFERENCE_RATE_HZ = 100.0
"""Rate at which the papers' noise figures are those of single samples."""

_NO_DETAILS = np.empty((0, 0, 0))


@dataclass(frozen=True)
class StrapdownParameters:
    """Noise, start and gaps of both filters.

    Noise sigmas are of single samples at 100 Hz; at another rate they are scaled so that a second of samples
    weighs the same. `acceleration_correlation` and `acceleration_change_sigma_mps2` are c_a and sigma_w of
    a(t) = c_a a(t - 10 ms) + w; the stationary acceleration stays the same at another rate.
    `bias_walk_degps_per_sqrt_s`: random walk of the gyroscope bias. `instantaneous_rate`: samples are the rate
    at their time and not the mean since the last one, as in devices that sum up inside. `coast_s`: how long a
    gap is crossed at the last rate, whose error is taken as `gap_rate_sigma_degps`. `report_details`: results
    carry acceleration and innovations too.
    """

    gyroscope_sigma_radps: float = 0.01
    accelerometer_sigma_mps2: float = 0.1
    acceleration_correlation: float = 0.6
    acceleration_change_sigma_mps2: float = 0.4
    bias_walk_degps_per_sqrt_s: float = 0.03
    instantaneous_rate: bool = False
    start_samples: float = 10.0
    initial_attitude_sigma_deg: float = 3.0
    initial_bias_sigma_degps: float = 1.0
    coast_s: float = 0.2
    gap_rate_sigma_degps: float = 57.3
    convergence_s: float = 3.0
    acceleration_tolerance_mps2: float = 2.0
    report_details: bool = False


@dataclass(frozen=True)
class StrapdownResult(OrientationResult):
    """An orientation with what else these filters know, if `report_details` asks for it.

    Attributes
    ----------
    acceleration_earth_mps2 : ndarray, shape (S, K, 3), or None
        Measured force less gravity.
    whitened_innovations : ndarray, shape (S, K, m), or None
        Innovations of the scalar measurements over their predicted deviations; NaN where none was taken.
    disturbance_earth : ndarray, shape (S, K, 3), or None
        Magnetic disturbance in units of the local field.
    field_norm, field_dip_rad : ndarray, shape (S, K), or None
        Smoothed norm over that of the reference, and dip.
    """

    acceleration_earth_mps2: Float | None = None
    whitened_innovations: Float | None = None
    disturbance_earth: Float | None = None
    field_norm: Float | None = None
    field_dip_rad: Float | None = None


class StrapdownEstimator(KernelEstimator):
    """Noise settings and details; subclasses name the kernel and their own settings.

    A MISSING tick is coasted at the last rate with growing covariance, flagged BRIDGED, for at most
    `coast_s`; then the estimate holds, INVALID, and the filter starts again with the next samples, keeping
    the gyroscope bias. The kernels work in the earth frame of the product; nothing is converted.
    """

    _parameter_kind: ClassVar[type[StrapdownParameters]]
    _positive: ClassVar[tuple[str, ...]] = (
        "gyroscope_sigma_radps",
        "accelerometer_sigma_mps2",
        "start_samples",
    )
    _bias_first = 3
    _details: ClassVar[int]
    """Columns that the kernel writes when details are asked for; the first three are the acceleration."""
    _parameters: StrapdownParameters

    def __init__(
        self, sensor_count: int, time_step_s: float, parameters: Mapping[str, Any] | None = None
    ) -> None:
        super().__init__(sensor_count, time_step_s, parameters)
        self._set_bias_covariance(math.radians(self._parameters.initial_bias_sigma_degps))

    @property
    def _noise_scale(self) -> float:
        """Factor on variances that brings single-sample noise from the reference rate to this one."""
        return 1.0 / (REFERENCE_RATE_HZ * self._guard.time_step_s)

    @property
    def _acceleration_gain(self) -> float:
        """The correlation c_a over one step of this rate."""
        return float(self._parameters.acceleration_correlation ** (1.0 / self._noise_scale))

    @property
    def _change_variance(self) -> float:
        """sigma_w^2 of this rate: the stationary acceleration sigma_w / sqrt(1 - c_a^2) is kept."""
        p = self._parameters
        stationary = p.acceleration_change_sigma_mps2**2 / (1.0 - p.acceleration_correlation**2)
        return stationary * (1.0 - self._acceleration_gain**2)

    @property
    def _force_variance(self) -> float:
        return self._parameters.accelerometer_sigma_mps2**2 * self._noise_scale

    def _make_settings(self) -> Float:
        p, step_s = self._parameters, self._guard.time_step_s
        if p.acceleration_correlation >= 1.0:
            raise SetupError("acceleration_correlation must be below 1")
        settings = np.zeros(steps.SHARED_SETTINGS)
        for position, value in (
            (steps.STEP_S, step_s),
            (steps.INSTANT_RATE, float(p.instantaneous_rate)),
            (steps.START_SAMPLES, p.start_samples),
            (steps.BRIDGE_TICKS, math.floor(p.coast_s / step_s + 1e-6)),
            (steps.CONVERGENCE_TICKS, p.convergence_s / step_s),
            (steps.ATTITUDE_SIGMA, math.radians(p.initial_attitude_sigma_deg)),
            (steps.GAP_RATE_SIGMA, math.radians(p.gap_rate_sigma_degps)),
            (steps.ACCELERATION_TOLERANCE, p.acceleration_tolerance_mps2),
            (steps.GRAVITY, GRAVITY_MPS2),
            (steps.RATE_VARIANCE, p.gyroscope_sigma_radps**2 * self._noise_scale),
            (steps.BIAS_VARIANCE, math.radians(p.bias_walk_degps_per_sqrt_s) ** 2 * step_s),
            (steps.ACCELERATION_GAIN, self._acceleration_gain),
        ):
            settings[position] = value
        return np.concatenate((settings, self._own_settings()))

    @abstractmethod
    def _own_settings(self) -> Float:
        """Return the settings of the subclass's kernel, in its order."""

    def _field(self, chunk: ImuChunk) -> Float | None:
        """Return what the kernel is to see of the magnetometer."""
        return chunk.magnetometer_t

    def update(self, chunk: ImuChunk) -> StrapdownResult:
        """Take the next ticks; see the contract."""
        chunk = self._guard.accept(chunk)
        details = _NO_DETAILS
        if self._parameters.report_details:
            details = np.full((chunk.sensor_count, chunk.tick_count, self._details), np.nan)
        found = self._filter(chunk, self._field(chunk), details)
        plain = (found.q_earth_sensor, found.gyroscope_bias_radps, found.sigma_rad, found.flags)
        if not self._parameters.report_details:
            return StrapdownResult(*plain)
        return self._detailed(StrapdownResult(*plain, acceleration_earth_mps2=details[..., :3]), details)

    @abstractmethod
    def _detailed(self, result: StrapdownResult, details: Float) -> StrapdownResult:
        """Name the kernel's details after the acceleration."""


__all__ = ["REFERENCE_RATE_HZ", "StrapdownEstimator", "StrapdownParameters", "StrapdownResult"]
