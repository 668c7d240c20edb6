"""Shared parts of the filters of Luinge and of Roetenberg behind the contract."""

import math
from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from estimators.conventions import GRAVITY_MPS2
from estimators.orientation._contract import OrientationResult
from estimators.orientation._parameters import parameter
from estimators.orientation._record_estimator import RecordEstimator
from estimators.orientation._strapdown_steps import DETAIL_ACCELERATION, DETAIL_INNOVATION
from estimators.recording import Float, ImuChunk

REFERENCE_RATE_HZ = 100.0
"""Rate at which the papers' noise figures are those of single samples."""


@dataclass(frozen=True)
class StrapdownParameters:
    """Noise, start and gaps of both filters.

    Noise sigmas are of single samples at 100 Hz; at another rate they are scaled so that a second of samples
    weighs the same, and the stationary acceleration stays the same.
    """

    gyroscope_sigma_radps: float = parameter(0.01, "rad/s", "noise of a sample", above=0.0)
    accelerometer_sigma_mps2: float = parameter(0.1, "m/s^2", "noise of a sample", above=0.0)
    acceleration_correlation: float = parameter(0.6, "", "c_a of a(t) = c_a a(t - 10 ms) + w", below=1.0)
    acceleration_change_sigma_mps2: float = parameter(0.4, "m/s^2", "sigma_w of the same")
    bias_walk_degps_per_sqrt_s: float = parameter(0.03, "deg/s/sqrt(s)", "random walk of the gyroscope bias")
    instantaneous_rate: bool = parameter(
        False,
        "",
        "samples are the rate at their time, not the mean since the last as where devices sum up inside",
    )
    start_samples: float = parameter(10.0, "samples", "mean that the filter starts from", above=0.0)
    initial_attitude_sigma_deg: float = parameter(3.0, "deg", "of an axis at a start at rest")
    initial_bias_sigma_degps: float = parameter(1.0, "deg/s", "of the gyroscope bias before any calibration")
    coast_s: float = parameter(0.2, "s", "how long a gap is crossed at the last rate")
    gap_rate_sigma_degps: float = parameter(57.3, "deg/s", "error of the last rate in a gap")
    convergence_s: float = parameter(3.0, "s", "after a start in which estimates are flagged as converging")
    acceleration_tolerance_mps2: float = parameter(2.0, "m/s^2", "force off gravity that is flagged")
    report_details: bool = parameter(False, "", "results carry acceleration and innovations too")


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


class StrapdownEstimator(RecordEstimator):
    """Noise settings and details; subclasses name the kernel and their own settings.

    A MISSING tick is coasted at the last rate with growing covariance, flagged BRIDGED, for at most
    `coast_s`; then the estimate holds, INVALID, and the filter starts again with the next samples,
    with the gyroscope bias. The kernels work in the earth frame of the product; nothing is converted.
    """

    _parameter_kind: ClassVar[type[StrapdownParameters]]
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
        """sigma_w^2 of this rate: the stationary acceleration sigma_w / sqrt(1 - c_a^2) stays."""
        p = self._parameters
        stationary = p.acceleration_change_sigma_mps2**2 / (1.0 - p.acceleration_correlation**2)
        return stationary * (1.0 - self._acceleration_gain**2)

    @property
    def _force_variance(self) -> float:
        return self._parameters.accelerometer_sigma_mps2**2 * self._noise_scale

    def _make_settings(self) -> dict[str, float]:
        p, step_s = self._parameters, self._guard.time_step_s
        return {
            "step_s": step_s,
            "is_rate_instantaneous": p.instantaneous_rate,
            "start_samples": p.start_samples,
            "bridge_ticks": math.floor(p.coast_s / step_s + 1e-6),
            "convergence_ticks": p.convergence_s / step_s,
            "attitude_sigma": math.radians(p.initial_attitude_sigma_deg),
            "gap_rate_sigma": math.radians(p.gap_rate_sigma_degps),
            "acceleration_tolerance": p.acceleration_tolerance_mps2,
            "gravity": GRAVITY_MPS2,
            "rate_variance": p.gyroscope_sigma_radps**2 * self._noise_scale,
            "bias_variance": math.radians(p.bias_walk_degps_per_sqrt_s) ** 2 * step_s,
            "force_variance": self._force_variance,
            "acceleration_gain": self._acceleration_gain,
            "change_variance": self._change_variance,
        } | self._own_settings()

    @abstractmethod
    def _own_settings(self) -> dict[str, float]:
        """Return the settings that are the subclass's own."""

    def _field(self, chunk: ImuChunk) -> Float | None:
        """Return what the kernel is to see of the magnetometer."""
        return chunk.magnetometer_t

    def update(self, chunk: ImuChunk) -> StrapdownResult:
        """Take the next ticks; see the contract."""
        chunk = self._guard.accept(chunk)
        if not self._parameters.report_details:
            out = self._filter(chunk, self._field(chunk))
            return StrapdownResult(out.q, out.bias, out.sigma_rad, out.flags)
        details = np.full((chunk.sensor_count, chunk.tick_count, self._details), np.nan)
        out = self._filter(chunk, self._field(chunk), details)
        acceleration = details[..., DETAIL_ACCELERATION:DETAIL_INNOVATION]
        found = StrapdownResult(out.q, out.bias, out.sigma_rad, out.flags, acceleration)
        return self._detailed(found, details)

    @abstractmethod
    def _detailed(self, result: StrapdownResult, details: Float) -> StrapdownResult:
        """Name the kernel's details after the acceleration."""
