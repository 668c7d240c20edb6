"""Biases from a still moment."""

import numpy as np

from estimators.calibration import StaticBias
from estimators.conventions import GRAVITY_MPS2
from estimators.recording import Float

_LEAST_BIAS_SIGMA_RADPS = float(np.deg2rad(0.02))
_LARGEST_BIAS_MPS2 = 0.04 * GRAVITY_MPS2


def bias_sigma(rest: StaticBias) -> float:
    """One number for the network: the typical standard error, sway included."""
    return max(float(np.median(rest.gyroscope_standard_error_radps)), _LEAST_BIAS_SIGMA_RADPS)


def bias_along_gravity(accelerometer_mps2: Float) -> Float:
    """Return what a pose at rest tells of the accelerometers' bias: the excess over gravity, shape (S, 3).

    The other two components cannot be distinguished from tilt and go into the mounting. An excess above what a bias
    explains is left for the calibration to judge.
    """
    bias = np.zeros((accelerometer_mps2.shape[0], 3))
    for s, force in enumerate(accelerometer_mps2):
        force = force[np.isfinite(force).all(axis=1)]
        if len(force):
            mean = np.median(force, axis=0)
            norm = float(np.linalg.norm(mean))
            if abs(norm - GRAVITY_MPS2) < _LARGEST_BIAS_MPS2:
                bias[s] = (norm - GRAVITY_MPS2) * mean / norm
    return bias
