"""Steps of the filters of Luinge and of Roetenberg before and after their own equations.

What they read and write, and how a gap is crossed, is also that of other filters. Both work in the product's earth
frame (x east, y north, z up) with specific force in m/s^2: the papers' global frame, Roetenberg's turned by a quarter
so that y and not x points north. Both carry the error in that frame, estimate = Exp(xi) truth, where its transition is
the identity and gravity leaves the heading alone.
"""

import math
from typing import Any, Final, NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from estimators._kernels import Scalars3, Scalars4, multiply, normalized, rotate
from estimators.kernels import VOID, Fields, Record, bundle, record, rows, step
from estimators.orientation._contract import OrientationFlag
from estimators.recording import Float, SampleQuality

MEASUREMENTS: Final = 5
"""At most so many scalar measurements a sample."""
DETAIL_ACCELERATION: Final = 0
DETAIL_INNOVATION: Final = 3
"""Columns of the details: the acceleration, the whitened innovations, then what is the filter's own."""

SETTINGS: Final[Fields] = [
    ("step_s", "f8"),
    ("is_rate_instantaneous", "i8"),
    ("start_samples", "f8"),
    ("bridge_ticks", "f8"),
    ("convergence_ticks", "f8"),
    ("attitude_sigma", "f8"),
    ("gap_rate_sigma", "f8"),
    ("acceleration_tolerance", "f8"),
    ("gravity", "f8"),
    ("rate_variance", "f8"),
    ("bias_variance", "f8"),
    ("force_variance", "f8"),
    ("acceleration_gain", "f8"),  # c_a
    ("change_variance", "f8"),  # sigma_w^2
]
"""Constants of both filters, for this time step; each filter's own follow."""

STATE: Final[Fields] = [
    ("q", "f8", 4),  # q_earth_sensor
    ("bias", "f8", 3),
    ("acceleration", "f8", 3),  # earth frame
    ("last_rate", "f8", 3),
    # Sums over the samples of a start, in sensor axes.
    ("sum_rate", "f8", 3),
    ("sum_force", "f8", 3),
    ("sum_field", "f8", 3),
    ("is_running", "i8"),
    ("collected", "i8"),
    ("field_collected", "i8"),
    ("gap", "i8"),
    ("since_start", "i8"),
    ("is_heading_known", "i8"),
    ("started", "i8"),
]
"""What both filters carry from sample to sample, a record a sensor, apart from the covariance."""

SAMPLE: Final = record(
    [
        ("rate", "f8", 3),
        ("force", "f8", 3),
        ("field", "f8", 3),
        ("force_norm", "f8"),
        ("field_norm", "f8"),
        ("has_field", "i8"),
        ("gap_variance", "f8"),
        ("innovation", "f8", MEASUREMENTS),
        ("inverse", "f8", MEASUREMENTS),  # 1 / variance of the innovation; zero where none was taken
    ]
)
"""One tick of one sensor, prepared."""


class Ticks(NamedTuple):
    """What a kernel reads: rate and force, shape (S, K, 3), field the same or without sensors, and quality, (S, K)."""

    gyroscope_radps: Float
    accelerometer_mps2: Float
    magnetometer_t: Float
    quality: NDArray[np.uint8]


class Estimates(NamedTuple):
    """What a kernel writes, shapes (S, K, ...); `details` of no sensor are not wanted."""

    q: Float
    bias: Float
    sigma_rad: Float
    flags: NDArray[np.uint8]
    details: Float


_VALUES, _BYTES = types.float64[:, :, ::1], types.uint8[:, ::1]


def run_signature(settings: np.dtype[Any], state: np.dtype[Any]) -> Any:
    """Return the signature of a filter's `run(ticks, settings, state, covariance, out)`."""
    ticks = bundle(Ticks, _VALUES, _VALUES, _VALUES, _BYTES)
    out = bundle(Estimates, _VALUES, _VALUES, _VALUES, _BYTES, _VALUES)
    return VOID(ticks, rows(settings), rows(state), _VALUES, out)


HOLD, COAST, FILTER, BEGIN = range(4)
"""What `prepare` asks for: keep the estimate; predict only; predict and correct; set the start values."""

UNKNOWN = math.pi * math.pi / 3.0
"""Variance of an angle that may be anything."""

_INVALID = int(OrientationFlag.INVALID | OrientationFlag.HEADING_NOT_TRUSTED)
_BRIDGED = int(OrientationFlag.BRIDGED)
_CONVERGING = int(OrientationFlag.CONVERGING)
_ACCELERATION = int(OrientationFlag.ACCELERATION_NOT_TRUSTED)
_SATURATED = int(OrientationFlag.SATURATED)
_SAMPLE_BRIDGED = int(SampleQuality.BRIDGED)
_SAMPLE_MISSING = int(SampleQuality.MISSING)
_SAMPLE_SATURATED = int(SampleQuality.SATURATED)


@step("UniTuple(float64, 4)(float64, float64, float64, float64, float64, float64, float64)")
def tilted_to_force(w: float, x: float, y: float, z: float, fx: float, fy: float, fz: float) -> Scalars4:
    """Turn q_earth_sensor by the least angle so that specific force points up; heading is unchanged."""
    ex, ey, ez = rotate(w, x, y, z, fx, fy, fz)
    norm = math.sqrt(ex * ex + ey * ey + ez * ez)
    if not norm > 0.0:
        return w, x, y, z
    if ez < -norm * (1.0 - 1e-12):
        tw, tx, ty, tz = 0.0, 1.0, 0.0, 0.0
    else:
        tw, tx, ty, tz = normalized(norm + ez, ey, -ex, 0.0)
    return multiply(tw, tx, ty, tz, w, x, y, z)


@step()
def cross_gap(x: Record, c: Record, sample: Record, growth: float) -> int:
    """Coast at the last rate for `bridge_ticks`, then hold and start again with bias and heading."""
    x.gap += 1
    if x.is_running and x.gap <= c.bridge_ticks:
        for axis in range(3):
            sample.rate[axis] = x.last_rate[axis]
        # Variance of (rate error x time): differences of n^2 are 2n - 1.
        sample.gap_variance = growth * (2.0 * x.gap - 1.0)
        x.since_start += 1
        return COAST
    if x.is_running or x.collected:
        x.is_running = x.collected = x.field_collected = 0
        for axis in range(3):
            x.sum_rate[axis] = x.sum_force[axis] = x.sum_field[axis] = 0.0
    return HOLD


@step()
def collect(x: Record, c: Record, sample: Record) -> int:
    """Gather the samples of a start; inclination is set here, heading by the filter."""
    x.since_start = x.since_start + 1 if x.collected else 0
    x.collected += 1
    x.started += 1
    for axis in range(3):
        x.last_rate[axis] = sample.rate[axis]
        x.sum_rate[axis] += sample.rate[axis]
        x.sum_force[axis] += sample.force[axis]
        if sample.has_field:
            x.sum_field[axis] += sample.field[axis]
    x.field_collected += sample.has_field
    x.q[0], x.q[1], x.q[2], x.q[3] = tilted_to_force(
        x.q[0], x.q[1], x.q[2], x.q[3], x.sum_force[0], x.sum_force[1], x.sum_force[2]
    )
    return BEGIN if x.collected >= c.start_samples else HOLD


@step()
def prepare_unusual(x: Record, c: Record, sample: Record, quality: int) -> int:
    """Start from the mean of the first samples, coast short gaps, hold long ones.

    While a gap is coasted at the last rate its error grows with `gap_rate_sigma`.
    """
    usable = (quality & _SAMPLE_MISSING) == 0 and sample.force_norm > 0.0
    for axis in range(3):
        usable &= math.isfinite(sample.rate[axis]) and math.isfinite(sample.force[axis])
    growth = (c.gap_rate_sigma * c.step_s) ** 2
    if not usable:
        action = cross_gap(x, c, sample, growth)
        if action == HOLD:
            x.acceleration[0] = x.acceleration[1] = x.acceleration[2] = 0.0
        return action
    x.gap = 0
    if x.is_running:
        x.since_start += 1
        if quality & _SAMPLE_SATURATED:
            sample.gap_variance = growth
        return FILTER
    return collect(x, c, sample)


@step()
def coning(x: Record, c: Record, sample: Record, rx: float, ry: float, rz: float) -> None:
    """Replace the rate of now by the mean turn since the last sample: Bortz, two samples (page A3).

    phi/T = (last + now)/2 + T/12 last x now. The bias, the same in both, is left in: its part of the cross
    product is T/12 bias x (now - last), below a part in a million.
    """
    lx, ly, lz = x.last_rate[0], x.last_rate[1], x.last_rate[2]
    twelfth = c.step_s / 12.0
    sample.rate[0] = 0.5 * (lx + rx) + twelfth * (ly * rz - lz * ry)
    sample.rate[1] = 0.5 * (ly + ry) + twelfth * (lz * rx - lx * rz)
    sample.rate[2] = 0.5 * (lz + rz) + twelfth * (lx * ry - ly * rx)


@step(inlined=True)
def prepare(ticks: Ticks, s: int, k: int, x: Record, c: Record, sample: Record) -> int:
    """Read tick `k` of sensor `s` into `sample` and say what the filter is to do."""
    force, rate, quality = ticks.accelerometer_mps2, ticks.gyroscope_radps, ticks.quality[s, k]
    fx, fy, fz = force[s, k, 0], force[s, k, 1], force[s, k, 2]
    rx, ry, rz = rate[s, k, 0], rate[s, k, 1], rate[s, k, 2]
    square = fx * fx + fy * fy + fz * fz
    # Zero if all are finite, and not a number otherwise.
    finite = 0.0 * (rx + ry + rz + square)
    sample.rate[0], sample.rate[1], sample.rate[2] = rx, ry, rz
    sample.force[0], sample.force[1], sample.force[2] = fx, fy, fz
    sample.force_norm = math.sqrt(square)
    sample.has_field = 0
    sample.gap_variance = 0.0
    if ticks.magnetometer_t.shape[0] > 0:
        field = ticks.magnetometer_t
        mx, my, mz = field[s, k, 0], field[s, k, 1], field[s, k, 2]
        norm = math.sqrt(mx * mx + my * my + mz * mz)
        sample.field[0], sample.field[1], sample.field[2], sample.field_norm = mx, my, mz, norm
        sample.has_field = 1 if 0.0 < norm < math.inf else 0
    flawed = quality & (_SAMPLE_MISSING | _SAMPLE_SATURATED)
    if finite != 0.0 or flawed != 0 or x.is_running == 0 or square == 0.0:
        action = prepare_unusual(x, c, sample, quality)
        if action != FILTER:
            return action
    else:
        x.gap = 0
        x.since_start += 1
    if c.is_rate_instantaneous:
        coning(x, c, sample, rx, ry, rz)
    x.last_rate[0], x.last_rate[1], x.last_rate[2] = rx, ry, rz
    return FILTER


@step()
def begin(x: Record, p: Float, c: Record) -> None:
    """Set the start covariance (A2.3), apart from that of the offset; after a gap the heading may be anything.

    The start attitude is known less well if the sensor turned or was pushed.
    """
    turned = force = 0.0
    for axis in range(3):
        turned += (x.sum_rate[axis] * c.step_s) ** 2
        force += (x.sum_force[axis] / x.collected) ** 2
    # A bias of a few degrees a second is no turn: it is known to the filter, and the start is short.
    push = math.sqrt(force) / c.gravity - 1.0
    variance = c.attitude_sigma**2 + turned + push * push
    for i in range(3):
        for j in range(p.shape[0]):
            p[i, j] = p[j, i] = 0.0
        p[i, i] = variance
        x.acceleration[i] = 0.0
    if x.started > x.collected:
        p[2, 2] = UNKNOWN
    x.is_running = 1


@step(inlined=True)
def force_without_acceleration(x: Record, sample: Record, c: Record) -> Scalars3:
    """Return measured force in the earth frame less the predicted acceleration c_a a: the vertical of (7)."""
    fx, fy, fz = rotate(x.q[0], x.q[1], x.q[2], x.q[3], sample.force[0], sample.force[1], sample.force[2])
    share, a = c.acceleration_gain, x.acceleration
    return fx - share * a[0], fy - share * a[1], fz - share * a[2]


@step(inlined=True)
def keep_acceleration(x: Record, sample: Record, c: Record) -> None:
    """Take measured force less gravity for the acceleration in the earth frame (A5.5)."""
    ax, ay, az = rotate(x.q[0], x.q[1], x.q[2], x.q[3], sample.force[0], sample.force[1], sample.force[2])
    x.acceleration[0], x.acceleration[1], x.acceleration[2] = ax, ay, az - c.gravity


@step("float64(float64)", inlined=True)
def sigma_of(variance: float) -> float:
    """Return the square root of a variance of an angle, at most half a turn."""
    return min(math.sqrt(max(variance, 0.0)), math.pi)


@step(inlined=True)
def store(
    out: Estimates,
    s: int,
    k: int,
    x: Record,
    variances: Scalars3,
    quality: int,
    action: int,
    own_flag: int,
    sample: Record,
    c: Record,
) -> None:
    """Write the estimate of a tick with sigma, from the variances about the earth's axes, and flags.

    `own_flag` is the filter's. Before the start sigma is that of a resting start.
    """
    for i in range(4):
        out.q[s, k, i] = x.q[i]
    flag = own_flag
    for axis in range(3):
        out.bias[s, k, axis] = x.bias[axis]
    if quality:
        if quality & _SAMPLE_BRIDGED:
            flag |= _BRIDGED
        if quality & _SAMPLE_SATURATED:
            flag |= _SATURATED
    if x.is_running == 0:
        held = x.collected == 0
        for axis in range(3):
            out.sigma_rad[s, k, axis] = math.pi if held else c.attitude_sigma
        out.flags[s, k] = flag | (_INVALID if held else _CONVERGING)
        return
    out.sigma_rad[s, k, 0] = sigma_of(variances[0])
    out.sigma_rad[s, k, 1] = sigma_of(variances[1])
    out.sigma_rad[s, k, 2] = sigma_of(variances[2])
    if action == COAST:
        flag |= _BRIDGED
    elif abs(sample.force_norm - c.gravity) > c.acceleration_tolerance:
        flag |= _ACCELERATION
    if x.since_start < c.convergence_ticks:
        flag |= _CONVERGING
    out.flags[s, k] = flag


@step()
def store_details(
    out: Estimates, s: int, k: int, innovations: int, action: int, x: Record, sample: Record
) -> None:
    """Write acceleration and whitened innovations, NaN where there was no correction."""
    for axis in range(3):
        out.details[s, k, DETAIL_ACCELERATION + axis] = x.acceleration[axis]
    for i in range(innovations):
        value, inverse = sample.innovation[i], sample.inverse[i]
        taken = action == FILTER and inverse > 0.0
        out.details[s, k, DETAIL_INNOVATION + i] = value * math.sqrt(inverse) if taken else math.nan
