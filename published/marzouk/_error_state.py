"""The modern replacement of Marzouk's filter: a multiplicative error-state EKF (method page, A9m)."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from estimators.orientation._parameters import parameter
from published.marzouk import _error_state_kernel as kernel
from published.marzouk._estimator import MarzoukEstimator, SharedParameters


@dataclass(frozen=True)
class ErrorStateParameters(SharedParameters):
    """The tuning of A9m."""

    gyroscope_sigma_degps: float = parameter(0.54, "deg/s", "noise of a sample")
    bias_drift_degps_per_sqrt_s: float = parameter(1e-3, "deg/s/sqrt(s)", "random walk of the bias")
    gravity_sigma: float = parameter(0.034, "", "noise of the measured direction of gravity, as a ratio")
    push_weight: float = parameter(
        3.0, "", "how strongly a norm of specific force other than gravity lowers its weight"
    )
    heading_sigma_deg: float = parameter(2.56, "deg", "noise of the measured heading")
    magnetic_penalty: float = parameter(
        25.0,
        "",
        "factor on the heading variance where the norm of the field is off by more than the tolerance",
    )


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
    _settings_kind = kernel.SETTINGS
    _state_kind = kernel.STATE
    _covariance_size = 6
    _bias_first = 3
    _parameters: ErrorStateParameters

    def _own_settings(self) -> dict[str, Any]:
        p, scale = self._parameters, self._noise_scale
        return {
            "rate_variance": np.deg2rad(p.gyroscope_sigma_degps) ** 2 * scale,
            "bias_drift": np.deg2rad(p.bias_drift_degps_per_sqrt_s) ** 2,
            "gravity_variance": p.gravity_sigma**2 * scale,
            "push_weight": p.push_weight * scale,
            "heading_variance": np.deg2rad(p.heading_sigma_deg) ** 2 * scale,
            "field_penalty": p.magnetic_penalty,
        }

    def _run(self, *arguments: Any) -> None:
        kernel.run(*arguments)
