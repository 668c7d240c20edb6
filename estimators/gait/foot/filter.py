"""Shared parts of the off-line and the live foot filter: start, constants and records."""

import math

import numpy as np

from estimators import rotation
from estimators.gait.foot import kernel
from estimators.gait.foot import layout as at
from estimators.gait.foot.kernel import FootState, FootTicks, Trace
from estimators.gait.foot.parameters import FootParameters
from estimators.recording import Float

START_S = 0.1
_START_TILT = (0.05, 0.02, 0.5)
_START_YAW_RAD, _START_POSITION_M = 1e-4, 1e-4
_START_VELOCITY_MPS = (0.01, 3.0)
_START_CALM = 1.0
NO_FIELD = np.empty((0, 3))


def settings_of(parameters: FootParameters) -> Float:
    """Return the derived constants in the order of the kernel."""
    settings = np.zeros(at.SETTINGS)
    settings[at.S_STANDSTILL] = parameters.standstill_sigma_radps
    settings[at.S_HEIGHT_SIGMA] = parameters.height_sigma_m
    settings[at.S_HEIGHT_SCALE] = parameters.height_scale_m
    settings[at.S_HEIGHT_GATE] = parameters.height_gate_m
    settings[at.S_PIVOT_DENSITY2] = parameters.pivot_density**2
    settings[at.S_GYROSCOPE_BIAS_DENSITY2] = parameters.gyroscope_bias_density**2
    settings[at.S_ACCELEROMETER_BIAS_DENSITY2] = parameters.accelerometer_bias_density**2
    settings[at.S_FIELD_SIGMA] = parameters.field_sigma_rad
    settings[at.S_FIELD_TOLERANCE] = parameters.field_tolerance
    settings[at.S_FLAT] = float(parameters.is_floor_flat)
    settings[at.S_GATE] = parameters.gate
    settings[at.S_GATE_RATIO] = parameters.gate_ratio
    settings[at.S_GATE_TIME] = parameters.gate_time_s
    return settings


def level(accelerometer_mps2: Float) -> Float:
    """Return the orientation of least turn, wxyz, that brings a mean specific force upright."""
    x, y, z = accelerometer_mps2 / np.linalg.norm(accelerometer_mps2)
    if z < -1.0 + 1e-9:
        return np.array([0.0, 1.0, 0.0, 0.0])
    # Half-way between force and upright: (1 + z, f x up), at unit norm.
    return rotation.normalize(np.array([1.0 + z, y, -x, 0.0]))


def start_covariance(start_statistic: float, parameters: FootParameters) -> Float:
    """Return the covariance at the first sample, shape (ERRORS, ERRORS).

    Parameters
    ----------
    start_statistic : float
        Mean of T over the first 0.1 s: how far the foot is from resting.
    """
    slope, least, most = _START_TILT
    tilt = min(max(slope * start_statistic, least), most)
    speed = _START_VELOCITY_MPS[0 if start_statistic < _START_CALM else 1]
    sigma = np.empty(at.ERRORS)
    sigma[0:3] = _START_POSITION_M
    sigma[at.E_V : at.E_V + 3] = speed
    sigma[at.E_Q : at.E_Q + 2] = tilt
    sigma[at.E_Q + 2] = _START_YAW_RAD
    sigma[at.E_GYROSCOPE_BIAS : at.E_GYROSCOPE_BIAS + 3] = parameters.gyroscope_bias_sigma_radps
    sigma[at.E_ACCELEROMETER_BIAS : at.E_ACCELEROMETER_BIAS + 3] = parameters.accelerometer_bias_sigma_mps2
    sigma[at.E_PIVOT : at.E_PIVOT + 3] = parameters.pivot_sigma_m
    return np.diag(sigma**2)


def start_state(accelerometer_mps2: Float, gyroscope_bias_radps: Float) -> Float:
    """Return the state at the first sample: level, at the origin, at rest, heading zero."""
    x = np.zeros(at.STATE)
    x[at.Q : at.Q + 4] = level(accelerometer_mps2)
    x[at.GYROSCOPE_BIAS : at.GYROSCOPE_BIAS + 3] = gyroscope_bias_radps
    return x


class Records:
    """The trace that `forward` leaves behind for the way back, of up to `most` samples."""

    def __init__(self, most: int) -> None:
        self.trace = Trace(
            prior=np.zeros((most, at.STATE)),
            prior_p=np.zeros((most, at.ERRORS, at.ERRORS)),
            steps=np.zeros((most, at.STEP)),
            row_count=np.zeros(most, dtype=np.int64),
            rows=np.zeros((most, at.MOST_ROWS, at.ERRORS)),
            gains=np.zeros((most, at.MOST_ROWS, at.ERRORS)),
            ratios=np.zeros((most, at.MOST_ROWS)),
            posterior=np.zeros((most, at.STATE)),
            spread=np.zeros((most, 6)),
        )

    def forward(self, place: slice, samples: FootTicks, settings: Float, state: FootState) -> None:
        """Run the filter and record into `place`."""
        kernel.forward(samples, settings, state, Trace._make(values[place] for values in self.trace))

    def backward(self, first: int, wanted: int, stop: int, adjoint: Float, smooth: Float) -> None:
        """Go back over the records `[first, stop)`, smooth `[first, wanted)`, and update the adjoint."""
        kernel.backward(first, wanted, stop, self.trace, adjoint, smooth)


def rate_of(time_s: Float) -> float:
    """Return the rate that a device was set to, from its stamps."""
    return float(1.0 / np.median(np.diff(time_s)))


def root(values: Float) -> Float:
    """Return standard deviations from variances that rounding may have brought below zero."""
    return np.sqrt(np.maximum(values, 0.0))


def is_usable_rate(rate_hz: float) -> bool:
    """Whether a foot can be followed at this rate."""
    return math.isfinite(rate_hz) and 30.0 <= rate_hz <= 2000.0
