"""What the filters of Luinge and of Roetenberg do to a sample before and after their own equations.

Both work in the product's earth frame (x east, y north, z up) with specific force in m/s^2: the papers'
global frame, Roetenberg's turned by a quarter so that y and not x points north. Both carry the error in that
frame, estimate = Exp(xi) truth, where its transition is the identity and gravity leaves the heading alone.
"""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import Scalars3, Scalars4, kernel, multiply, normalized, rotate
from estimators.orientation._contract import OrientationFlag
from estimators.recording import Float, SampleQuality

# Columns of the counters, one row a sensor.
RUNNING, COLLECTED, FIELD_COLLECTED, GAP, SINCE_START, HEADING_KNOWN, STARTED = range(7)
COUNTERS = 7

# Columns of the memory, one row a sensor: triples start at the number given. SUM_FIELD is in sensor axes.
LAST_RATE, SUM_RATE, SUM_FORCE, SUM_FIELD, SUM_FIELD_NORM, ACCELERATION = 0, 3, 6, 9, 12, 13
MEMORY = 16

# Positions in a prepared sample.
RATE, FORCE, FIELD, FORCE_NORM, FIELD_NORM, HAS_FIELD, GAP_VARIANCE = 0, 3, 6, 9, 10, 11, 12
INNOVATION = 13
"""Pairs of an innovation and the inverse of its variance, one for each scalar measurement."""
SAMPLE = INNOVATION + 2 * 5

# Positions in the settings shared by both filters; each filter's own follow.
(
    STEP_S,
    INSTANT_RATE,
    START_SAMPLES,
    BRIDGE_TICKS,
    CONVERGENCE_TICKS,
    ATTITUDE_SIGMA,
    GAP_RATE_SIGMA,
    ACCELERATION_TOLERANCE,
    GRAVITY,
    RATE_VARIANCE,
    BIAS_VARIANCE,
    ACCELERATION_GAIN,
) = range(12)
SHARED_SETTINGS = 12

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


@kernel("UniTuple(float64, 4)(float64, float64, float64)", inlined=True)
def turn(rx: float, ry: float, rz: float) -> Scalars4:
    """Return the unit quaternion of a rotation vector; below half a radian by series exact to 1e-16."""
    square = 0.25 * (rx * rx + ry * ry + rz * rz)
    # sin(x)/x and cos(x) of x^2 = square; the terms left out are below 1e-16.
    if square < 1e-3:
        # Most samples and nearly all corrections: shorter series, of which attitude waits for the next.
        scale = 0.5 + square * (-1 / 12 + square * (1 / 240 - square * (1 / 10080)))
        cosine = 1.0 + square * (-1 / 2 + square * (1 / 24 + square * (-1 / 720 + square * (1 / 40320))))
        return cosine, rx * scale, ry * scale, rz * scale
    if square < 0.0625:
        scale = 0.5 * (
            1.0
            + square
            * (
                -1 / 6
                + square * (1 / 120 + square * (-1 / 5040 + square * (1 / 362880 - square * (1 / 39916800))))
            )
        )
        cosine = 1.0 + square * (
            -1 / 2
            + square
            * (
                1 / 24
                + square
                * (-1 / 720 + square * (1 / 40320 + square * (-1 / 3628800 + square * (1 / 479001600))))
            )
        )
        return cosine, rx * scale, ry * scale, rz * scale
    half = math.sqrt(square)
    scale = 0.5 * math.sin(half) / half
    return math.cos(half), rx * scale, ry * scale, rz * scale


@kernel("UniTuple(float64, 4)(float64, float64, float64, float64, float64, float64, float64)")
def tilted_to_force(w: float, x: float, y: float, z: float, fx: float, fy: float, fz: float) -> Scalars4:
    """Turn q_earth_sensor by the least angle so that specific force points up; heading is kept."""
    ex, ey, ez = rotate(w, x, y, z, fx, fy, fz)
    norm = math.sqrt(ex * ex + ey * ey + ez * ez)
    if not norm > 0.0:
        return w, x, y, z
    if ez < -norm * (1.0 - 1e-12):
        tw, tx, ty, tz = 0.0, 1.0, 0.0, 0.0
    else:
        tw, tx, ty, tz = normalized(norm + ez, ey, -ex, 0.0)
    return multiply(tw, tx, ty, tz, w, x, y, z)


@kernel("UniTuple(float64, 4)(float64, float64, float64, float64, float64, float64, float64)")
def facing_field(w: float, x: float, y: float, z: float, mx: float, my: float, mz: float) -> Scalars4:
    """Turn q_earth_sensor about the vertical so that the field's horizontal part points north."""
    east, north, _ = rotate(w, x, y, z, mx, my, mz)
    half = 0.5 * math.atan2(east, north)
    return multiply(math.cos(half), 0.0, 0.0, math.sin(half), w, x, y, z)


@kernel(
    "int64(int64, int64, float64[:, :, ::1], float64[:, :, ::1], uint8[:, ::1], float64[::1],"
    "float64[:, ::1], float64[:, ::1], int64[:, ::1], float64[::1])"
)
def prepare_unusual(
    s: int,
    k: int,
    gyroscope_radps: Float,
    accelerometer_mps2: Float,
    quality: NDArray[np.uint8],
    settings: Float,
    q: Float,
    memory: Float,
    counters: NDArray[np.int64],
    sample: Float,
) -> int:
    """Start from the mean of the first samples, coast short gaps, hold long ones.

    A gap is coasted at the last rate, with an error that grows with `GAP_RATE_SIGMA`, for `BRIDGE_TICKS`;
    after that the filter starts again with its bias and heading. Inclination is set here at a start, heading by
    the filter.
    """
    count, kept = counters[s], memory[s]
    usable = (quality[s, k] & _SAMPLE_MISSING) == 0 and sample[FORCE_NORM] > 0.0
    for axis in range(3):
        usable &= math.isfinite(gyroscope_radps[s, k, axis]) and math.isfinite(accelerometer_mps2[s, k, axis])
    growth = (settings[GAP_RATE_SIGMA] * settings[STEP_S]) ** 2
    if not usable:
        count[GAP] += 1
        if count[RUNNING] and count[GAP] <= settings[BRIDGE_TICKS]:
            for axis in range(3):
                sample[RATE + axis] = kept[LAST_RATE + axis]
            # Variance of (rate error x time): differences of n^2 are 2n - 1.
            sample[GAP_VARIANCE] = growth * (2.0 * count[GAP] - 1.0)
            count[SINCE_START] += 1
            return COAST
        if count[RUNNING] or count[COLLECTED]:
            count[RUNNING] = count[COLLECTED] = count[FIELD_COLLECTED] = 0
            for i in range(SUM_RATE, ACCELERATION + 3):
                kept[i] = 0.0
        return HOLD
    count[GAP] = 0
    if count[RUNNING]:
        count[SINCE_START] += 1
        if quality[s, k] & _SAMPLE_SATURATED:
            sample[GAP_VARIANCE] = growth
        return FILTER
    count[SINCE_START] = count[SINCE_START] + 1 if count[COLLECTED] else 0
    count[COLLECTED] += 1
    count[STARTED] += 1
    for axis in range(3):
        kept[LAST_RATE + axis] = sample[RATE + axis]
        kept[SUM_RATE + axis] += sample[RATE + axis]
        kept[SUM_FORCE + axis] += sample[FORCE + axis]
        if sample[HAS_FIELD] > 0.0:
            kept[SUM_FIELD + axis] += sample[FIELD + axis]
    if sample[HAS_FIELD] > 0.0:
        count[FIELD_COLLECTED] += 1
        kept[SUM_FIELD_NORM] += sample[FIELD_NORM]
    q[s, 0], q[s, 1], q[s, 2], q[s, 3] = tilted_to_force(
        q[s, 0], q[s, 1], q[s, 2], q[s, 3], kept[SUM_FORCE], kept[SUM_FORCE + 1], kept[SUM_FORCE + 2]
    )
    return BEGIN if count[COLLECTED] >= settings[START_SAMPLES] else HOLD


@kernel("void(int64, float64[:, ::1], float64[::1], float64[::1], float64, float64, float64)")
def coning(s: int, memory: Float, settings: Float, sample: Float, rx: float, ry: float, rz: float) -> None:
    """Replace the rate of now by the mean turn since the last sample: Bortz, two samples (page A3).

    phi/T = (last + now)/2 + T/12 last x now. The bias, the same in both, is left in: its part of the cross
    product is T/12 bias x (now - last), below a part in a million.
    """
    lx, ly, lz = memory[s, LAST_RATE], memory[s, LAST_RATE + 1], memory[s, LAST_RATE + 2]
    twelfth = settings[STEP_S] / 12.0
    sample[RATE] = 0.5 * (lx + rx) + twelfth * (ly * rz - lz * ry)
    sample[RATE + 1] = 0.5 * (ly + ry) + twelfth * (lz * rx - lx * rz)
    sample[RATE + 2] = 0.5 * (lz + rz) + twelfth * (lx * ry - ly * rx)


@kernel(
    "int64(int64, int64, float64[:, :, ::1], float64[:, :, ::1], float64[:, :, ::1], uint8[:, ::1],"
    "float64[::1], float64[:, ::1], float64[:, ::1], int64[:, ::1], float64[::1])",
    inlined=True,
)
def prepare(
    s: int,
    k: int,
    gyroscope_radps: Float,
    accelerometer_mps2: Float,
    magnetometer_t: Float,
    quality: NDArray[np.uint8],
    settings: Float,
    q: Float,
    memory: Float,
    counters: NDArray[np.int64],
    sample: Float,
) -> int:
    """Read one tick into `sample` and say what the filter is to do."""
    fx, fy, fz = accelerometer_mps2[s, k, 0], accelerometer_mps2[s, k, 1], accelerometer_mps2[s, k, 2]
    rx, ry, rz = gyroscope_radps[s, k, 0], gyroscope_radps[s, k, 1], gyroscope_radps[s, k, 2]
    square = fx * fx + fy * fy + fz * fz
    # Zero if all are finite, and not a number otherwise.
    finite = 0.0 * (rx + ry + rz + square)
    sample[RATE], sample[RATE + 1], sample[RATE + 2] = rx, ry, rz
    sample[FORCE], sample[FORCE + 1], sample[FORCE + 2] = fx, fy, fz
    sample[FORCE_NORM] = math.sqrt(square)
    sample[HAS_FIELD] = 0.0
    sample[GAP_VARIANCE] = 0.0
    if magnetometer_t.shape[0] > 0:
        mx, my, mz = magnetometer_t[s, k, 0], magnetometer_t[s, k, 1], magnetometer_t[s, k, 2]
        norm = math.sqrt(mx * mx + my * my + mz * mz)
        sample[FIELD], sample[FIELD + 1], sample[FIELD + 2], sample[FIELD_NORM] = mx, my, mz, norm
        sample[HAS_FIELD] = 1.0 if 0.0 < norm < math.inf else 0.0
    flawed = quality[s, k] & (_SAMPLE_MISSING | _SAMPLE_SATURATED)
    if finite != 0.0 or flawed != 0 or counters[s, RUNNING] == 0 or square == 0.0:
        action = prepare_unusual(
            s, k, gyroscope_radps, accelerometer_mps2, quality, settings, q, memory, counters, sample
        )
        if action != FILTER:
            return action
    else:
        counters[s, GAP] = 0
        counters[s, SINCE_START] += 1
    if settings[INSTANT_RATE] > 0.0:
        coning(s, memory, settings, sample, rx, ry, rz)
    memory[s, LAST_RATE], memory[s, LAST_RATE + 1], memory[s, LAST_RATE + 2] = rx, ry, rz
    return FILTER


@kernel("float64(int64, float64[:, ::1], int64[:, ::1], float64[::1])")
def start_variance(s: int, memory: Float, counters: NDArray[np.int64], settings: Float) -> float:
    """Return the variance per axis of the start attitude: more if the sensor turned or was pushed."""
    turned = force = 0.0
    for axis in range(3):
        turned += (memory[s, SUM_RATE + axis] * settings[STEP_S]) ** 2
        force += (memory[s, SUM_FORCE + axis] / counters[s, COLLECTED]) ** 2
    # A bias of a few degrees a second is no turn: it is known to the filter, and the start is short.
    push = math.sqrt(force) / settings[GRAVITY] - 1.0
    return float(settings[ATTITUDE_SIGMA] ** 2 + turned + push * push)


@kernel(
    "void(int64, int64, int64, int64, uint8[:, ::1], float64[::1], int64[:, ::1], float64[::1],"
    "float64[:, :, ::1], uint8[:, ::1])",
    inlined=True,
)
def store_flags(
    s: int,
    k: int,
    action: int,
    own_flag: int,
    quality: NDArray[np.uint8],
    settings: Float,
    counters: NDArray[np.int64],
    sample: Float,
    sigma_rad: Float,
    flags: NDArray[np.uint8],
) -> None:
    """Write the flags as `store` does, and before the start sigma, for filters that write the rest in lanes.

    Called from `store`, which has these lines again, it makes the scalar filters a seventh slower.
    """
    flag = own_flag
    if quality[s, k]:
        if quality[s, k] & _SAMPLE_BRIDGED:
            flag |= _BRIDGED
        if quality[s, k] & _SAMPLE_SATURATED:
            flag |= _SATURATED
    if counters[s, RUNNING] == 0:
        held = counters[s, COLLECTED] == 0
        for axis in range(3):
            sigma_rad[s, k, axis] = math.pi if held else settings[ATTITUDE_SIGMA]
        flags[s, k] = flag | (_INVALID if held else _CONVERGING)
        return
    if action == COAST:
        flag |= _BRIDGED
    elif abs(sample[FORCE_NORM] - settings[GRAVITY]) > settings[ACCELERATION_TOLERANCE]:
        flag |= _ACCELERATION
    if counters[s, SINCE_START] < settings[CONVERGENCE_TICKS]:
        flag |= _CONVERGING
    flags[s, k] = flag


@kernel(
    "void(int64, int64, int64, int64, uint8[:, ::1], float64[::1], float64[:, ::1], float64[:, ::1],"
    "float64[:, ::1], int64[:, ::1], float64[::1], float64[:, :, ::1], float64[:, :, ::1],"
    "float64[:, :, ::1], uint8[:, ::1])",
    inlined=True,
)
def store(
    s: int,
    k: int,
    action: int,
    own_flag: int,
    quality: NDArray[np.uint8],
    settings: Float,
    q: Float,
    bias: Float,
    p: Float,
    counters: NDArray[np.int64],
    sample: Float,
    q_earth_sensor: Float,
    bias_out: Float,
    sigma_rad: Float,
    flags: NDArray[np.uint8],
) -> None:
    """Write the estimate with sigma and flags; `own_flag` is the filter's.

    The covariance `p` begins with the error in the earth frame. Before the start sigma is that of a resting
    start.
    """
    for i in range(4):
        q_earth_sensor[s, k, i] = q[s, i]
    for axis in range(3):
        bias_out[s, k, axis] = bias[s, axis]
    flag = own_flag
    if quality[s, k]:
        if quality[s, k] & _SAMPLE_BRIDGED:
            flag |= _BRIDGED
        if quality[s, k] & _SAMPLE_SATURATED:
            flag |= _SATURATED
    if counters[s, RUNNING] == 0:
        held = counters[s, COLLECTED] == 0
        for axis in range(3):
            sigma_rad[s, k, axis] = math.pi if held else settings[ATTITUDE_SIGMA]
        flags[s, k] = flag | (_INVALID if held else _CONVERGING)
        return
    for axis in range(3):
        sigma_rad[s, k, axis] = min(math.sqrt(max(p[axis, axis], 0.0)), math.pi)
    if action == COAST:
        flag |= _BRIDGED
    elif abs(sample[FORCE_NORM] - settings[GRAVITY]) > settings[ACCELERATION_TOLERANCE]:
        flag |= _ACCELERATION
    if counters[s, SINCE_START] < settings[CONVERGENCE_TICKS]:
        flag |= _CONVERGING
    flags[s, k] = flag


@kernel(
    "UniTuple(float64, 3)(int64, float64[:, ::1], float64[:, ::1], float64[::1], float64[::1])", inlined=True
)
def force_without_acceleration(s: int, q: Float, memory: Float, sample: Float, settings: Float) -> Scalars3:
    """Return measured force in the earth frame less the predicted acceleration c_a a: the vertical of (7)."""
    fx, fy, fz = rotate(
        q[s, 0], q[s, 1], q[s, 2], q[s, 3], sample[FORCE], sample[FORCE + 1], sample[FORCE + 2]
    )
    share = settings[ACCELERATION_GAIN]
    return (
        fx - share * memory[s, ACCELERATION],
        fy - share * memory[s, ACCELERATION + 1],
        fz - share * memory[s, ACCELERATION + 2],
    )


@kernel("void(int64, float64[:, ::1], float64[:, ::1], float64[::1], float64[::1])", inlined=True)
def keep_acceleration(s: int, q: Float, memory: Float, sample: Float, settings: Float) -> None:
    """Take measured force less gravity for the acceleration in the earth frame (A5.5)."""
    ax, ay, az = rotate(
        q[s, 0], q[s, 1], q[s, 2], q[s, 3], sample[FORCE], sample[FORCE + 1], sample[FORCE + 2]
    )
    memory[s, ACCELERATION] = ax
    memory[s, ACCELERATION + 1] = ay
    memory[s, ACCELERATION + 2] = az - settings[GRAVITY]


@kernel("void(int64, int64, int64, int64, float64[:, ::1], float64[::1], float64[:, :, ::1])")
def tell(s: int, k: int, innovations: int, action: int, memory: Float, sample: Float, details: Float) -> None:
    """Write acceleration and whitened innovations, NaN where there was no correction."""
    for axis in range(3):
        details[s, k, axis] = memory[s, ACCELERATION + axis]
    for i in range(innovations):
        value, inverse = sample[INNOVATION + 2 * i], sample[INNOVATION + 2 * i + 1]
        details[s, k, 3 + i] = value * math.sqrt(inverse) if action == FILTER and inverse > 0.0 else math.nan
