"""The quaternion EKF with gyroscope-bias states of Marzouk (2009), section 3.3, with corrected equations."""

import math
from dataclasses import dataclass
from typing import Any, ClassVar, Final

import numpy as np

from estimators.conventions import GRAVITY_MPS2
from estimators.orientation._parameters import parameter
from published.marzouk import _quaternion_kernel as kernel
from published.marzouk._estimator import AngleParameters, MarzoukEstimator


@dataclass(frozen=True)
class QuaternionParameters(AngleParameters):
    """The recommended tuning; `PUBLISHED_TUNING` is the thesis' own.

    Without `singular_weighting` the filter is thrown off by up to 44 degrees (protocol V6). The accelerometer noise of
    the thesis would be a `motion_scale_mps2` of 0.166.
    """

    singular_weighting: bool = parameter(
        True,
        "",
        "roll and yaw lose weight, as their noise grows, where the x axis is steeper than 60 degrees",
    )


PUBLISHED_TUNING: Final[dict[str, Any]] = {
    "gyroscope_x_sigma_degps": 0.0,
    "gyroscope_y_sigma_degps": 0.0,
    "gyroscope_z_sigma_degps": 0.0,
    "bias_drift_x_degps_per_sqrt_s": math.sqrt(0.2460),
    "bias_drift_y_degps_per_sqrt_s": math.sqrt(0.3601),
    "bias_drift_z_degps_per_sqrt_s": math.sqrt(0.2684),
    "roll_sigma_deg": math.degrees(1.0),
    "pitch_sigma_deg": math.degrees(1.0),
    "yaw_sigma_deg": math.degrees(1.0),
    "singular_weighting": False,
}
"""What the thesis ran with: no angle noise, bias driven by the gyroscope variances, 1 rad^2 (3.3.1.2)."""


class MarzoukQuaternionEstimator(MarzoukEstimator):
    """State: quaternion and bias (7); measured roll, pitch and tilt-compensated yaw (A9, A4, A5)."""

    name: ClassVar[str] = "marzouk_quaternion_ekf"
    version: ClassVar[str] = "1"
    title: ClassVar[str] = "Quaternion Kalman filter"
    description: ClassVar[str] = (
        "The published filter for arm monitoring with its equations corrected; "
        "for comparison with earlier work."
    )
    _parameter_kind = QuaternionParameters
    _settings_kind = kernel.SETTINGS
    _state_kind = kernel.STATE
    _covariance_size = kernel.STATES
    _bias_first = 4
    _parameters: QuaternionParameters

    def _own_settings(self) -> dict[str, Any]:
        p, scale = self._parameters, self._noise_scale
        gyroscope = p.gyroscope_x_sigma_degps, p.gyroscope_y_sigma_degps, p.gyroscope_z_sigma_degps
        bias = (
            p.bias_drift_x_degps_per_sqrt_s,
            p.bias_drift_y_degps_per_sqrt_s,
            p.bias_drift_z_degps_per_sqrt_s,
        )
        return {
            "rate_variance": np.deg2rad(gyroscope) ** 2 * scale,
            "bias_drift": np.deg2rad(bias) ** 2,
            "angle_variance": np.deg2rad((p.roll_sigma_deg, p.pitch_sigma_deg, p.yaw_sigma_deg)) ** 2 * scale,
            "motion_scale_g": p.motion_scale_mps2 / GRAVITY_MPS2,
            "is_weighted_when_steep": p.singular_weighting,
        }

    def _run(self, *arguments: Any) -> None:
        kernel.run(*arguments)
