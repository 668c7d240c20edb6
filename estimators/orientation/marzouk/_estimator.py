"""What the filters of the arm-monitoring thesis share behind the contract."""

import math
from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from estimators.conventions import GRAVITY_MPS2
from estimators.orientation._kernel_estimator import KernelEstimator
from estimators.orientation.marzouk import _steps as steps
from estimators.recording import Float

HEADING_LOST_RAD = math.radians(15.0)


@dataclass(frozen=True)
class SharedParameters:
    """Start, gaps and flags of these filters.

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


class MarzoukEstimator(KernelEstimator):
    """Start, gaps and shared settings; subclasses name the kernel, its covariance and its own settings.

    A MISSING tick is coasted at the last rate with growing covariance, flagged BRIDGED, for at most
    `coast_s`; then the estimate holds, INVALID, and the filter starts again with the next samples,
    keeping the gyroscope bias (and, without a field, the heading). Sigma is the filter's covariance,
    which takes all errors for white noise: it is optimistic where they last.
    """

    _parameter_kind: ClassVar[type[SharedParameters]]
    _positive = ("reference_rate_hz", "start_samples", "magnetic_reference_time_constant_s")
    _memory_columns = steps.MEMORY
    _counter_columns = steps.COUNTERS
    # The kernels work in north-east-down.
    _q_start = (0.0, -math.sqrt(0.5), -math.sqrt(0.5), 0.0)
    _parameters: SharedParameters

    def __init__(
        self, sensor_count: int, time_step_s: float, parameters: Mapping[str, Any] | None = None
    ) -> None:
        super().__init__(sensor_count, time_step_s, parameters)
        self._set_bias_covariance(math.radians(self._parameters.initial_bias_sigma_degps))

    def _make_settings(self) -> Float:
        return np.concatenate((self._shared_settings(), self._own_settings()))

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


__all__ = ["MarzoukEstimator", "SharedParameters"]
