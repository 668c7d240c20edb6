"""Flags and an error budget beside the estimates of VQF, which itself gives neither covariance nor time."""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import kernel
from estimators.conventions import GRAVITY_MPS2
from estimators.orientation._contract import OrientationFlag
from estimators.recording import Float, SampleQuality

_INVALID = int(OrientationFlag.INVALID)
_BRIDGED = int(OrientationFlag.BRIDGED)
_CONVERGING = int(OrientationFlag.CONVERGING)
_ACCELERATION = int(OrientationFlag.ACCELERATION_NOT_TRUSTED)
_DISTURBED = int(OrientationFlag.MAGNETIC_DISTURBANCE)
_NO_HEADING = int(OrientationFlag.HEADING_NOT_TRUSTED)
_SATURATED = int(OrientationFlag.SATURATED)
_SAMPLE_BRIDGED = int(SampleQuality.BRIDGED)
_SAMPLE_SATURATED = int(SampleQuality.SATURATED)

COUNTERS = 4
"""Per sensor: ticks since the last (re)start, ticks without trusted field, field known, field ever seen."""

TILT_FLOOR_RAD = math.radians(0.7)
HEADING_FLOOR_RAD = math.radians(2.3)
"""Root-mean-square errors of online VQF over the 30 trials of the BROAD set, inclination and heading."""
RATE_ERROR_RADPS = math.radians(2.7 / 60.0)
"""Median drift of heading without magnetometer on the same set (gyroscope scale and axis errors)."""
START_TILT_RAD = math.radians(5.0)
START_HEADING_RAD = math.radians(10.0)
START_DECAY_S = 0.5
"""Error of the first samples, averaged away like 1/(1 + time/START_DECAY_S)."""
HEADING_LOST_RAD = math.radians(15.0)


@kernel(
    "void(float64[:, :, ::1], uint8[:, ::1], boolean[:, ::1], boolean[:, ::1], boolean[:, ::1],"
    "float64[:, ::1], int64[:, ::1], float64, float64, float64, float64, uint8[:, ::1], float64[:, :, ::1])"
)
def annotate(
    accelerometer_mps2: Float,
    quality: NDArray[np.uint8],
    usable: NDArray[np.bool_],
    field_measured: NDArray[np.bool_],
    field_rejected: NDArray[np.bool_],
    bias_sigma_radps: Float,
    counters: NDArray[np.int64],
    time_step_s: float,
    convergence_s: float,
    acceleration_tolerance_mps2: float,
    tilt_time_constant_s: float,
    flags: NDArray[np.uint8],
    sigma_rad: Float,
) -> None:
    """Fill `flags` (S, K) and `sigma_rad` (S, K, 3), and carry `counters` (S, COUNTERS) on.

    Sigma is a budget, not a covariance: a floor measured on reference recordings; the error that the
    remaining gyroscope bias (its own estimated sigma) makes in inclination over the accelerometer's
    time constant and in heading since the last trusted field sample; and the start error dying out.
    Without a magnetometer sigma of the heading counts from the start, whose heading is arbitrary.
    """
    for s in range(quality.shape[0]):
        for k in range(quality.shape[1]):
            flag = 0
            sample = quality[s, k]
            if sample & _SAMPLE_BRIDGED:
                flag |= _BRIDGED
            if sample & _SAMPLE_SATURATED:
                flag |= _SATURATED
            if not usable[s, k]:
                if counters[s, 0] >= 0:
                    counters[s, 1] += 1
                    counters[s, 0] = -1
                flags[s, k] = flag | _INVALID | _NO_HEADING
                for axis in range(3):
                    sigma_rad[s, k, axis] = math.pi
                continue
            counters[s, 0] += 1
            since_start_s = counters[s, 0] * time_step_s
            if since_start_s < convergence_s:
                flag |= _CONVERGING
            norm = 0.0
            for axis in range(3):
                norm += accelerometer_mps2[s, k, axis] * accelerometer_mps2[s, k, axis]
            if abs(math.sqrt(norm) - GRAVITY_MPS2) > acceleration_tolerance_mps2:
                flag |= _ACCELERATION
            if field_measured[s, k]:
                counters[s, 3] = 1
                if not field_rejected[s, k]:
                    counters[s, 2] = 1
                    counters[s, 1] = 0
                elif counters[s, 2]:
                    flag |= _DISTURBED
                    counters[s, 1] += 1
                else:
                    # VQF has no reference field before the first seconds of motion: it follows what
                    # it measures, which cannot be called disturbed.
                    counters[s, 1] = 0
            else:
                counters[s, 1] += 1
            without_s = counters[s, 1] * time_step_s
            start_share = START_DECAY_S / (START_DECAY_S + since_start_s)
            bias_sigma = bias_sigma_radps[s, k]
            tilt = math.sqrt(
                TILT_FLOOR_RAD**2
                + (bias_sigma * tilt_time_constant_s) ** 2
                + (START_TILT_RAD * start_share) ** 2
            )
            drift = (bias_sigma**2 + RATE_ERROR_RADPS**2) * without_s**2
            heading = math.sqrt(HEADING_FLOOR_RAD**2 + drift + (START_HEADING_RAD * start_share) ** 2)
            if counters[s, 3] == 0 or heading > HEADING_LOST_RAD:
                flag |= _NO_HEADING
            flags[s, k] = flag
            sigma_rad[s, k, 0] = min(tilt, math.pi)
            sigma_rad[s, k, 1] = min(tilt, math.pi)
            sigma_rad[s, k, 2] = min(heading, math.pi)


__all__ = ["COUNTERS", "annotate"]
