"""Shared parts of the filters of the arm-monitoring thesis behind the contract."""

import math
from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from estimators.conventions import GRAVITY_MPS2
from estimators.orientation._parameters import parameter
from estimators.orientation._record_estimator import RecordEstimator

HEADING_LOST_RAD = math.radians(15.0)
_EARTH_IN_U = (0.0, -math.sqrt(0.5), -math.sqrt(0.5), 0.0)
"""Identity in the product's earth frame, seen from north-east-down."""


@dataclass(frozen=True)
class SharedParameters:
    """Start, gaps and flags of these filters.

    Noise sigmas are of single samples at the reference rate (the thesis measured at 17 Hz). At another rate they are
    scaled so that a second of samples weighs the same: errors of slow devices and of motion are correlated, and more
    samples do not average them away.
    """

    reference_rate_hz: float = parameter(17.0, "Hz", "rate of the noise sigmas of single samples", above=0.0)
    midpoint_rate: bool = parameter(True, "", "turn by the mean of this and the last rate, not by this alone")
    start_samples: float = parameter(10.0, "samples", "mean that the filter starts from", above=0.0)
    initial_attitude_sigma_deg: float = parameter(2.0, "deg", "of an axis at a start at rest")
    initial_bias_sigma_degps: float = parameter(1.0, "deg/s", "of the gyroscope bias before any calibration")
    coast_s: float = parameter(0.2, "s", "how long a gap is crossed at the last rate")
    gap_rate_sigma_degps: float = parameter(57.3, "deg/s", "error of the last rate in a gap")
    convergence_s: float = parameter(3.0, "s", "after a start in which estimates are flagged as converging")
    acceleration_tolerance_mps2: float = parameter(2.0, "m/s^2", "force off gravity that is flagged")
    magnetic_norm_tolerance: float = parameter(0.15, "", "share of the reference that the field may be off")
    magnetic_reference_time_constant_s: float = parameter(
        20.0, "s", "in which the accepted norm of the field is learned", above=0.0
    )
    magnetic_trust_s: float = parameter(10.0, "s", "of a foreign field after which heading is not trusted")


@dataclass(frozen=True)
class AngleParameters(SharedParameters):
    """Noise of the gyroscope by axes (T2.1), and of the measured angles (T2.3, T2.5)."""

    gyroscope_x_sigma_degps: float = parameter(math.sqrt(0.2460), "deg/s", "noise of a sample")
    gyroscope_y_sigma_degps: float = parameter(math.sqrt(0.3601), "deg/s", "noise of a sample")
    gyroscope_z_sigma_degps: float = parameter(math.sqrt(0.2684), "deg/s", "noise of a sample")
    bias_drift_x_degps_per_sqrt_s: float = parameter(1e-3, "deg/s/sqrt(s)", "random walk of the bias")
    bias_drift_y_degps_per_sqrt_s: float = parameter(1e-3, "deg/s/sqrt(s)", "random walk of the bias")
    bias_drift_z_degps_per_sqrt_s: float = parameter(1e-3, "deg/s/sqrt(s)", "random walk of the bias")
    roll_sigma_deg: float = parameter(math.sqrt(0.5737), "deg", "noise of the measured roll")
    pitch_sigma_deg: float = parameter(math.sqrt(0.9096), "deg", "noise of the measured pitch")
    yaw_sigma_deg: float = parameter(math.sqrt(6.5572), "deg", "noise of the measured yaw")
    motion_scale_mps2: float = parameter(
        0.0, "m/s^2", "if above zero, angle variances grow by 1 + ((|f| - g) / scale)^2 (A10)"
    )


class MarzoukEstimator(RecordEstimator):
    """Start, gaps and shared settings; subclasses name the kernel, its records and their own settings.

    A MISSING tick is coasted at the last rate with growing covariance, flagged BRIDGED, for at most
    `coast_s`; then the estimate holds, INVALID, and the filter starts again with the next samples,
    with the gyroscope bias (and, without a field, the heading) that it had. Sigma is the filter's covariance,
    which takes all errors for white noise: it is optimistic where they last.
    """

    _parameter_kind: ClassVar[type[SharedParameters]]
    _parameters: SharedParameters

    def __init__(
        self, sensor_count: int, time_step_s: float, parameters: Mapping[str, Any] | None = None
    ) -> None:
        super().__init__(sensor_count, time_step_s, parameters)
        self._state["q"] = _EARTH_IN_U
        self._set_bias_covariance(math.radians(self._parameters.initial_bias_sigma_degps))

    @property
    def _noise_scale(self) -> float:
        """Factor on variances that brings single-sample noise from the reference rate to this one."""
        return 1.0 / (self._parameters.reference_rate_hz * self._guard.time_step_s)

    def _make_settings(self) -> dict[str, Any]:
        p, step_s = self._parameters, self._guard.time_step_s
        return {
            "step_s": step_s,
            "is_midpoint": p.midpoint_rate,
            "start_samples": p.start_samples,
            "bridge_ticks": math.floor(p.coast_s / step_s + 1e-6),
            "convergence_ticks": p.convergence_s / step_s,
            "attitude_sigma": math.radians(p.initial_attitude_sigma_deg),
            "gap_rate_sigma": math.radians(p.gap_rate_sigma_degps),
            "acceleration_tolerance_g": p.acceleration_tolerance_mps2 / GRAVITY_MPS2,
            "field_tolerance": p.magnetic_norm_tolerance,
            "field_reference_gain": -math.expm1(-step_s / p.magnetic_reference_time_constant_s),
            "disturbed_ticks": p.magnetic_trust_s / step_s,
            "heading_lost": HEADING_LOST_RAD,
        } | self._own_settings()

    @abstractmethod
    def _own_settings(self) -> dict[str, Any]:
        """Return the settings that are the subclass's own."""
