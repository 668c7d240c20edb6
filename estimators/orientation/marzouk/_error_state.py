"""The modern replacement of Marzouk's filter: a multiplicative error-state EKF (method page, A9m)."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from estimators.orientation.marzouk import _error_state_kernel as kernel
from estimators.orientation.marzouk._estimator import MarzoukEstimator, SharedParameters
from estimators.recording import Float


@dataclass(frozen=True)
class ErrorStateParameters(SharedParameters):
    """The tuning of A9m.

    `gravity_sigma`: noise of the measured direction of gravity, as a ratio; `push_weight`: how strongly
    a norm of specific force other than gravity lowers its weight. `magnetic_penalty`: factor on the
    heading variance where the norm of the field is off by more than `magnetic_norm_tolerance`.
    """

    gyroscope_sigma_degps: float = 0.54
    bias_drift_degps_per_sqrt_s: float = 1e-3
    gravity_sigma: float = 0.034
    push_weight: float = 3.0
    heading_sigma_deg: float = 2.56
    magnetic_penalty: float = 25.0


class MarzoukErrorStateEstimator(MarzoukEstimator):
    """State: attitude error (in U) and bias (6); gravity corrects tilt and the field corrects heading only."""

    name: ClassVar[str] = "marzouk_error_state_ekf"
    version: ClassVar[str] = "2"
    title: ClassVar[str] = "Error-state Kalman filter"
    description: ClassVar[str] = (
        "A Kalman filter without singular positions whose inclination never follows a magnet; "
        "reports its uncertainty."
    )
    _parameter_kind = ErrorStateParameters
    _covariance_size = 6
    _bias_first = 3
    _parameters: ErrorStateParameters

    def _own_settings(self) -> Float:
        p, scale = self._parameters, self._noise_scale
        settings = np.zeros(kernel.SETTINGS - kernel.RATE_VARIANCE)
        for position, value in (
            (kernel.RATE_VARIANCE, np.deg2rad(p.gyroscope_sigma_degps) ** 2 * scale),
            (kernel.BIAS_DRIFT, np.deg2rad(p.bias_drift_degps_per_sqrt_s) ** 2),
            (kernel.GRAVITY_VARIANCE, p.gravity_sigma**2 * scale),
            (kernel.PUSH_WEIGHT, p.push_weight * scale),
            (kernel.HEADING_VARIANCE, np.deg2rad(p.heading_sigma_deg) ** 2 * scale),
            (kernel.FIELD_PENALTY, p.magnetic_penalty),
        ):
            settings[position - kernel.RATE_VARIANCE] = value
        return settings

    def _run(self, *arrays: NDArray[Any]) -> None:
        kernel.run(*arrays)


__all__ = ["ErrorStateParameters", "MarzoukErrorStateEstimator"]
