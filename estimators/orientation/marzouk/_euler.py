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
from numpy.typing import NDArray

from estimators.conventions import GRAVITY_MPS2
from estimators.orientation.marzouk import _euler_kernel as kernel
from estimators.orientation.marzouk._estimator import MarzoukEstimator, SharedParameters
from estimators.recording import Float

_ROLL_DEG, _PITCH_DEG, _YAW_DEG = math.sqrt(0.5737), math.sqrt(0.9096), math.sqrt(6.5572)
_X_DEGPS, _Y_DEGPS, _Z_DEGPS = math.sqrt(0.2460), math.sqrt(0.3601), math.sqrt(0.2684)


@dataclass(frozen=True)
class EulerParameters(SharedParameters):
    """The recommended tuning; `PUBLISHED_TUNING` is the thesis' own.

    `gyroscope_*_sigma_degps`: noise of a gyroscope sample (T2.1), taken as noise of roll, pitch and yaw.
    `*_drift_deg_per_sqrt_s`: further random walk of the angles. `bias_drift_*`: random walk of the bias.
    `roll_`, `pitch_`, `yaw_sigma_deg`: noise of the measured angles (T2.3, T2.5). `motion_scale_mps2`: if
    above zero, angle variances grow by `1 + ((|f| - g) / scale)^2` (A10).
    """

    gyroscope_x_sigma_degps: float = _X_DEGPS
    gyroscope_y_sigma_degps: float = _Y_DEGPS
    gyroscope_z_sigma_degps: float = _Z_DEGPS
    roll_drift_deg_per_sqrt_s: float = 0.0
    pitch_drift_deg_per_sqrt_s: float = 0.0
    yaw_drift_deg_per_sqrt_s: float = 0.0
    bias_drift_x_degps_per_sqrt_s: float = 1e-3
    bias_drift_y_degps_per_sqrt_s: float = 1e-3
    bias_drift_z_degps_per_sqrt_s: float = 1e-3
    roll_sigma_deg: float = _ROLL_DEG
    pitch_sigma_deg: float = _PITCH_DEG
    yaw_sigma_deg: float = _YAW_DEG
    motion_scale_mps2: float = 0.0


PUBLISHED_TUNING: Final[dict[str, Any]] = {
    "midpoint_rate": False,
    "gyroscope_x_sigma_degps": 0.0,
    "gyroscope_y_sigma_degps": 0.0,
    "gyroscope_z_sigma_degps": 0.0,
    "roll_drift_deg_per_sqrt_s": _ROLL_DEG,
    "pitch_drift_deg_per_sqrt_s": _PITCH_DEG,
    "yaw_drift_deg_per_sqrt_s": _YAW_DEG,
    "bias_drift_x_degps_per_sqrt_s": _X_DEGPS,
    "bias_drift_y_degps_per_sqrt_s": _Y_DEGPS,
    "bias_drift_z_degps_per_sqrt_s": _Z_DEGPS,
}
"""Qc = blkdiag(Sigma_E, Sigma_b), R = Sigma_E, the rate of this sample alone (A8.1, A8.7)."""


class MarzoukEulerEstimator(MarzoukEstimator):
    """State: roll, pitch, yaw and bias (6), all three angles measured (A8, A4, A5).

    Where the sensor's x axis is steeper than 85 degrees roll and yaw mean nothing: they are held, flagged
    SINGULAR with a sigma that says so, and found anew below.
    """

    name: ClassVar[str] = "marzouk_euler_ekf"
    version: ClassVar[str] = "1"
    title: ClassVar[str] = "Euler-angle Kalman filter"
    description: ClassVar[str] = (
        "The first published filter for arm monitoring, which loses its way when the sensor points straight "
        "up or down; for comparison with earlier work."
    )
    _parameter_kind = EulerParameters
    _covariance_size = 6
    _bias_first = 3
    _memory_columns = kernel.MEMORY
    _parameters: EulerParameters

    def _own_settings(self) -> Float:
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
        variances = (step_s * noise**2 * scale + drift**2, bias**2, angles**2 * scale)
        settings = np.zeros(kernel.SETTINGS - kernel.ANGLE_DRIFT)
        settings[:9] = np.concatenate(variances) * math.radians(1.0) ** 2
        settings[kernel.MOTION_SCALE_G - kernel.ANGLE_DRIFT] = p.motion_scale_mps2 / GRAVITY_MPS2
        return settings

    def _run(self, *arrays: NDArray[Any]) -> None:
        kernel.run(*arrays)


__all__ = ["PUBLISHED_TUNING", "EulerParameters", "MarzoukEulerEstimator"]
