"""The quaternion EKF with gyroscope-bias states of Marzouk (2009), section 3.3, with corrected equations."""

import math
from dataclasses import dataclass
from typing import Any, ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from estimators.conventions import GRAVITY_MPS2
from estimators.orientation.marzouk import _quaternion_kernel as kernel
from estimators.orientation.marzouk._estimator import MarzoukEstimator, SharedParameters
from estimators.recording import Float


@dataclass(frozen=True)
class QuaternionParameters(SharedParameters):
    """The recommended tuning; `PUBLISHED_TUNING` is the thesis' own.

    `*_sigma_degps`: noise of a gyroscope sample (T2.1); `bias_drift_*`: random walk of the bias.
    `roll_`, `pitch_`, `yaw_sigma_deg`: noise of the measured angles (T2.3, T2.5).
    `motion_scale_mps2`: if above zero, angle variances grow by `1 + ((|f| - g) / scale)^2` (A10; the
    thesis' accelerometer noise would be 0.166).
    `singular_weighting`: roll and yaw lose weight where the sensor's x axis is steeper than 60 degrees,
    as their noise grows there; without it the filter is thrown off by up to 44 degrees (protocol V6).
    """

    gyroscope_x_sigma_degps: float = math.sqrt(0.2460)
    gyroscope_y_sigma_degps: float = math.sqrt(0.3601)
    gyroscope_z_sigma_degps: float = math.sqrt(0.2684)
    bias_drift_x_degps_per_sqrt_s: float = 1e-3
    bias_drift_y_degps_per_sqrt_s: float = 1e-3
    bias_drift_z_degps_per_sqrt_s: float = 1e-3
    roll_sigma_deg: float = math.sqrt(0.5737)
    pitch_sigma_deg: float = math.sqrt(0.9096)
    yaw_sigma_deg: float = math.sqrt(6.5572)
    motion_scale_mps2: float = 0.0
    singular_weighting: bool = True


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
    _covariance_size = 7
    _bias_first = 4
    _parameters: QuaternionParameters

    def _own_settings(self) -> Float:
        p, scale = self._parameters, self._noise_scale
        settings = np.zeros(kernel.SETTINGS - kernel.RATE_VARIANCE)
        degrees = (
            (p.gyroscope_x_sigma_degps, p.gyroscope_y_sigma_degps, p.gyroscope_z_sigma_degps),
            (
                p.bias_drift_x_degps_per_sqrt_s,
                p.bias_drift_y_degps_per_sqrt_s,
                p.bias_drift_z_degps_per_sqrt_s,
            ),
            (p.roll_sigma_deg, p.pitch_sigma_deg, p.yaw_sigma_deg),
        )
        variances = np.deg2rad(np.array(degrees)) ** 2 * np.array([[scale], [1.0], [scale]])
        settings[:9] = variances.ravel()
        settings[kernel.MOTION_SCALE_G - kernel.RATE_VARIANCE] = p.motion_scale_mps2 / GRAVITY_MPS2
        settings[kernel.SINGULAR_WEIGHTING - kernel.RATE_VARIANCE] = p.singular_weighting
        return settings

    def _run(self, *arrays: NDArray[Any]) -> None:
        kernel.run(*arrays)


__all__ = ["PUBLISHED_TUNING", "MarzoukQuaternionEstimator", "QuaternionParameters"]
