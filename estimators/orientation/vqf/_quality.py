"""Flags and an error budget for the estimates of VQF, which itself gives neither covariance nor time."""

import math

from estimators.conventions import GRAVITY_MPS2
from estimators.kernels import Record, step
from estimators.orientation._contract import OrientationFlag
from estimators.orientation._strapdown_steps import Estimates
from estimators.recording import SampleQuality

_INVALID = int(OrientationFlag.INVALID)
_BRIDGED = int(OrientationFlag.BRIDGED)
_CONVERGING = int(OrientationFlag.CONVERGING)
_ACCELERATION = int(OrientationFlag.ACCELERATION_NOT_TRUSTED)
_DISTURBED = int(OrientationFlag.MAGNETIC_DISTURBANCE)
_NO_HEADING = int(OrientationFlag.HEADING_NOT_TRUSTED)
_SATURATED = int(OrientationFlag.SATURATED)
_SAMPLE_BRIDGED = int(SampleQuality.BRIDGED)
_SAMPLE_SATURATED = int(SampleQuality.SATURATED)

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


@step()
def sample_flags(quality: int) -> int:
    """Return what the sample itself says."""
    flag = 0
    if quality & _SAMPLE_BRIDGED:
        flag |= _BRIDGED
    if quality & _SAMPLE_SATURATED:
        flag |= _SATURATED
    return flag


@step()
def annotate_missing(out: Estimates, s: int, k: int, x: Record, quality: int) -> None:
    """Write flags and sigma of a tick without a usable sample."""
    if x.since_start >= 0:
        x.without_field += 1
        x.since_start = -1
    out.flags[s, k] = sample_flags(quality) | _INVALID | _NO_HEADING
    for axis in range(3):
        out.sigma_rad[s, k, axis] = math.pi


@step()
def follow_field(x: Record, is_measured: bool, is_rejected: bool) -> int:
    """Count the ticks without a trusted field; return the flag of a disturbance."""
    if not is_measured:
        x.without_field += 1
        return 0
    x.has_seen_field = 1
    if not is_rejected:
        x.is_field_known = 1
        x.without_field = 0
    elif x.is_field_known:
        x.without_field += 1
        return _DISTURBED
    else:
        # VQF has no reference field before the first seconds of motion: it follows what
        # it measures, which cannot be called disturbed.
        x.without_field = 0
    return 0


@step()
def annotate(
    out: Estimates,
    s: int,
    k: int,
    x: Record,
    c: Record,
    quality: int,
    force_norm: float,
    is_measured: bool,
    is_rejected: bool,
    bias_sigma_radps: float,
) -> None:
    """Write flags and sigma of a usable sample.

    Sigma is a budget, not a covariance: a floor measured on reference recordings; the error that the
    remaining gyroscope bias (its own estimated sigma) makes in inclination over the accelerometer's
    time constant and in heading since the last trusted field sample; and the start error dying out.
    Without a magnetometer sigma of the heading counts from the start, whose heading is arbitrary.
    """
    flag = sample_flags(quality)
    x.since_start += 1
    since_start_s = x.since_start * c.step_s
    if since_start_s < c.convergence_s:
        flag |= _CONVERGING
    if abs(force_norm - GRAVITY_MPS2) > c.acceleration_tolerance:
        flag |= _ACCELERATION
    flag |= follow_field(x, is_measured, is_rejected)
    without_s = x.without_field * c.step_s
    start_share = START_DECAY_S / (START_DECAY_S + since_start_s)
    tilt = math.sqrt(
        TILT_FLOOR_RAD**2 + (bias_sigma_radps * c.tilt_time_s) ** 2 + (START_TILT_RAD * start_share) ** 2
    )
    drift = (bias_sigma_radps**2 + RATE_ERROR_RADPS**2) * without_s**2
    heading = math.sqrt(HEADING_FLOOR_RAD**2 + drift + (START_HEADING_RAD * start_share) ** 2)
    if x.has_seen_field == 0 or heading > HEADING_LOST_RAD:
        flag |= _NO_HEADING
    out.flags[s, k] = flag
    out.sigma_rad[s, k, 0] = out.sigma_rad[s, k, 1] = min(tilt, math.pi)
    out.sigma_rad[s, k, 2] = min(heading, math.pi)
