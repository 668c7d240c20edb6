"""The Euler-angle EKF with gyroscope-bias states of Marzouk (2009), section 3.2, with corrected equations.

Corrected: the state is carried by e + Ts W u and the covariance by I + Ts A (the thesis used the continuous
Jacobian as a transition and discarded P, E-10); bias states are not measured (E-11); innovations are
wrapped (E-17); tilt and heading have one sign convention (E-3 to E-5). `PUBLISHED_TUNING` is what the thesis
ran with: the variances of the measured angles serve as their own drift, those of the gyroscope as the drift
of its bias, both per second.
"""

import math
from dataclasses import dataclass
from typing import Any, ClassVar, Final

import numpy as np

from estimators.conventions import GRAVITY_MPS2
from estimators.orientation._parameters import parameter
from published.marzouk import _euler_kernel as kernel
from published.marzouk._estimator import AngleParameters, MarzoukEstimator


@dataclass(frozen=True)
class EulerParameters(AngleParameters):
    """The recommended tuning; `PUBLISHED_TUNING` is the thesis' own. Gyroscope noise is that of roll, pitch and yaw."""

    roll_drift_deg_per_sqrt_s: float = parameter(0.0, "deg/sqrt(s)", "further random walk of the roll")
    pitch_drift_deg_per_sqrt_s: float = parameter(0.0, "deg/sqrt(s)", "further random walk of the pitch")
    yaw_drift_deg_per_sqrt_s: float = parameter(0.0, "deg/sqrt(s)", "further random walk of the yaw")


PUBLISHED_TUNING: Final[dict[str, Any]] = {
    "midpoint_rate": False,
    "gyroscope_x_sigma_degps": 0.0,
    "gyroscope_y_sigma_degps": 0.0,
    "gyroscope_z_sigma_degps": 0.0,
    "roll_drift_deg_per_sqrt_s": math.sqrt(0.5737),
    "pitch_drift_deg_per_sqrt_s": math.sqrt(0.9096),
    "yaw_drift_deg_per_sqrt_s": math.sqrt(6.5572),
    "bias_drift_x_degps_per_sqrt_s": math.sqrt(0.2460),
    "bias_drift_y_degps_per_sqrt_s": math.sqrt(0.3601),
    "bias_drift_z_degps_per_sqrt_s": math.sqrt(0.2684),
}
"""Qc = blkdiag(Sigma_E, Sigma_b), R = Sigma_E, the rate of this sample alone (A8.1, A8.7)."""


class MarzoukEulerEstimator(MarzoukEstimator):
    """State: roll, pitch, yaw and bias (6), all three angles measured (A8, A4, A5).

    Where the sensor's x axis is steeper than 85 degrees roll and yaw mean nothing: they are held, flagged
    SINGULAR with a sigma that says so, and found again below.
    """

    name: ClassVar[str] = "marzouk_euler_ekf"
    version: ClassVar[str] = "1"
    title: ClassVar[str] = "Euler-angle Kalman filter"
    description: ClassVar[str] = (
        "The first published filter for arm monitoring, which loses its way when the sensor points straight "
        "up or down; for comparison with earlier work."
    )
    _parameter_kind = EulerParameters
    _settings_kind = kernel.SETTINGS
    _state_kind = kernel.STATE
    _covariance_size = 6
    _bias_first = 3
    _parameters: EulerParameters

    def _own_settings(self) -> dict[str, Any]:
        p, scale, step_s = self._parameters, self._noise_scale, self._guard.time_step_s
        noise = np.array([p.gyroscope_x_sigma_degps, p.gyroscope_y_sigma_degps, p.gyroscope_z_sigma_degps])
        drift = np.array(
            [p.roll_drift_deg_per_sqrt_s, p.pitch_drift_deg_per_sqrt_s, p.yaw_drift_deg_per_sqrt_s]
        )
        bias = np.array(
            [
                p.bias_drift_x_degps_per_sqrt_s,
                p.bias_drift_y_degps_per_sqrt_s,
                p.bias_drift_z_degps_per_sqrt_s,
            ]
        )
        angles = np.array([p.roll_sigma_deg, p.pitch_sigma_deg, p.yaw_sigma_deg])
        return {
            "angle_drift": (step_s * noise**2 * scale + drift**2) * math.radians(1.0) ** 2,
            "bias_drift": bias**2 * math.radians(1.0) ** 2,
            "angle_variance": angles**2 * scale * math.radians(1.0) ** 2,
            "motion_scale_g": p.motion_scale_mps2 / GRAVITY_MPS2,
        }

    def _run(self, *arguments: Any) -> None:
        kernel.run(*arguments)
