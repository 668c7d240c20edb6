"""What both quaternion filters of the arm-monitoring thesis do to a sample before and after the filter.

Inside, the thesis' convention holds (Marzouk 2009, method page 1.3): U is north-east-down and the
accelerometer is gravity-positive in g, `s = -specific force / g`. `prepare` converts on the way in and
`store` on the way out; nothing else in the product sees it. Sensor axes stay those of the device.
"""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import Scalars4, kernel, multiply, normalized, rotate, rotate_back
from estimators.conventions import GRAVITY_MPS2
from estimators.orientation._contract import OrientationFlag
from estimators.recording import Float, SampleQuality

# Columns of the counters, one row a sensor.
RUNNING, COLLECTED, FIELD_COLLECTED, GAP, SINCE_START, DISTURBED, HEADING_KNOWN, STARTED = range(8)
COUNTERS = 8

# Columns of the memory, one row a sensor: triples start at the number given.
LAST_RATE, SUM_RATE, SUM_GRAVITY, SUM_FIELD, SUM_FIELD_NORM, FIELD_REFERENCE = 0, 3, 6, 9, 12, 13
MEMORY = 14

# Positions in a prepared sample.
RATE, GRAVITY, FIELD, FIELD_NORM, GRAVITY_NORM, HAS_FIELD, GAP_VARIANCE = 0, 3, 6, 9, 10, 11, 12
SAMPLE = 13

# Positions in the settings shared by both filters; each filter's own follow.
(
    STEP_S,
    MIDPOINT,
    START_SAMPLES,
    BRIDGE_TICKS,
    CONVERGENCE_TICKS,
    ATTITUDE_SIGMA,
    GAP_RATE_SIGMA,
    ACCELERATION_TOLERANCE_G,
    FIELD_TOLERANCE,
    FIELD_REFERENCE_GAIN,
    DISTURBED_TICKS,
    HEADING_LOST,
) = range(12)
SHARED_SETTINGS = 12

HOLD, COAST, FILTER, BEGIN = range(4)
"""What `prepare` asks for: keep the estimate; predict only; predict and correct; set the start covariance."""

_HALF_ROOT = math.sqrt(0.5)
_INVALID = int(OrientationFlag.INVALID)
_BRIDGED = int(OrientationFlag.BRIDGED)
_CONVERGING = int(OrientationFlag.CONVERGING)
_ACCELERATION = int(OrientationFlag.ACCELERATION_NOT_TRUSTED)
_DISTURBANCE = int(OrientationFlag.MAGNETIC_DISTURBANCE)
_NO_HEADING = int(OrientationFlag.HEADING_NOT_TRUSTED)
_SATURATED = int(OrientationFlag.SATURATED)
_SAMPLE_BRIDGED = int(SampleQuality.BRIDGED)
_SAMPLE_MISSING = int(SampleQuality.MISSING)
_SAMPLE_SATURATED = int(SampleQuality.SATURATED)


@kernel("float64(float64, float64)", inlined=True)
def direction(y: float, x: float) -> float:
    """Return atan2(y, x); up to seven degrees, as innovations are, by a series exact to 1e-16."""
    if abs(y) < 0.125 * x:
        t = y / x
        s = t * t
        s2 = s * s
        near = (1.0 - s * (1 / 3)) + s2 * (1 / 5 - s * (1 / 7))
        return t * (near + s2 * s2 * ((1 / 9 - s * (1 / 11)) + s2 * (1 / 13 - s * (1 / 15))))
    return math.atan2(y, x)


@kernel("UniTuple(float64, 4)(float64[::1], int64, float64[::1], int64)")
def attitude_from_vectors(gravity: Float, g: int, field: Float, f: int) -> Scalars4:
    """Return q_U_sensor from gravity and field in the sensor frame (A4 and A5); all zero if parallel.

    Down is gravity, east is down x field, north is east x down; these are the rows of R_US.
    """
    dx, dy, dz = gravity[g], gravity[g + 1], gravity[g + 2]
    norm = math.sqrt(dx * dx + dy * dy + dz * dz)
    dx, dy, dz = dx / norm, dy / norm, dz / norm
    ex = dy * field[f + 2] - dz * field[f + 1]
    ey = dz * field[f] - dx * field[f + 2]
    ez = dx * field[f + 1] - dy * field[f]
    east = math.sqrt(ex * ex + ey * ey + ez * ez)
    whole = math.sqrt(field[f] ** 2 + field[f + 1] ** 2 + field[f + 2] ** 2)
    if not east > 1e-3 * whole:
        return 0.0, 0.0, 0.0, 0.0
    ex, ey, ez = ex / east, ey / east, ez / east
    nx, ny, nz = ey * dz - ez * dy, ez * dx - ex * dz, ex * dy - ey * dx
    # Shepperd: divide by the largest component.
    trace = nx + ey + dz
    if trace >= nx and trace >= ey and trace >= dz:
        return normalized(1.0 + trace, dy - ez, nz - dx, ex - ny)
    if nx >= ey and nx >= dz:
        return normalized(dy - ez, 1.0 + 2.0 * nx - trace, ny + ex, nz + dx)
    if ey >= dz:
        return normalized(nz - dx, ny + ex, 1.0 + 2.0 * ey - trace, ez + dy)
    return normalized(ex - ny, nz + dx, ez + dy, 1.0 + 2.0 * dz - trace)


@kernel("UniTuple(float64, 4)(float64, float64, float64, float64, float64[::1], int64)")
def tilted_to_gravity(w: float, x: float, y: float, z: float, gravity: Float, g: int) -> Scalars4:
    """Turn q_U_sensor by the least angle so that it agrees with measured gravity; heading is kept."""
    vx, vy, vz = rotate_back(w, x, y, z, 0.0, 0.0, 1.0)
    sx, sy, sz = gravity[g], gravity[g + 1], gravity[g + 2]
    norm = math.sqrt(sx * sx + sy * sy + sz * sz)
    sx, sy, sz = sx / norm, sy / norm, sz / norm
    cosine = sx * vx + sy * vy + sz * vz
    if cosine < -1.0 + 1e-12:
        # Opposite: half a turn about any axis perpendicular to gravity.
        if abs(sx) < 0.9:
            tw, tx, ty, tz = normalized(0.0, 0.0, sz, -sy)
        else:
            tw, tx, ty, tz = normalized(0.0, -sz, 0.0, sx)
    else:
        tw, tx, ty, tz = normalized(1.0 + cosine, sy * vz - sz * vy, sz * vx - sx * vz, sx * vy - sy * vx)
    return multiply(w, x, y, z, tw, tx, ty, tz)


@kernel(
    "int64(int64, uint8, float64[::1], float64[:, ::1], float64[:, ::1], int64[:, ::1], float64[::1], float64)"
)
def prepare_unusual(
    s: int,
    quality: int,
    settings: Float,
    q: Float,
    memory: Float,
    counters: NDArray[np.int64],
    sample: Float,
    field_norm: float,
) -> int:
    """Start from the mean of the first samples (A11), coast short gaps, hold long ones.

    A gap is coasted at the last rate, with an error that grows with `GAP_RATE_SIGMA`, for `BRIDGE_TICKS`;
    after that the filter starts again, with its bias and, lacking a field, its heading.
    """
    count, kept = counters[s], memory[s]
    usable = (quality & _SAMPLE_MISSING) == 0 and sample[GRAVITY_NORM] > 0.0
    for axis in range(3):
        usable &= math.isfinite(sample[RATE + axis]) and math.isfinite(sample[GRAVITY + axis])
    growth = (settings[GAP_RATE_SIGMA] * settings[STEP_S]) ** 2
    if not usable:
        sample[HAS_FIELD] = 0.0
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
            for i in range(SUM_RATE, SUM_FIELD_NORM + 1):
                kept[i] = 0.0
        return HOLD
    count[GAP] = 0
    count[SINCE_START] = count[SINCE_START] + 1 if count[RUNNING] or count[COLLECTED] else 0
    if quality & _SAMPLE_SATURATED:
        sample[GAP_VARIANCE] = growth
    if count[RUNNING]:
        return FILTER
    count[COLLECTED] += 1
    count[STARTED] = 1
    for axis in range(3):
        kept[LAST_RATE + axis] = sample[RATE + axis]
        kept[SUM_RATE + axis] += sample[RATE + axis]
        kept[SUM_GRAVITY + axis] += sample[GRAVITY + axis]
        if sample[HAS_FIELD] > 0.0:
            kept[SUM_FIELD + axis] += sample[FIELD + axis]
    w, x, y, z = 0.0, 0.0, 0.0, 0.0
    if sample[HAS_FIELD] > 0.0:
        count[FIELD_COLLECTED] += 1
        kept[SUM_FIELD_NORM] += field_norm
    if count[FIELD_COLLECTED] > 0:
        w, x, y, z = attitude_from_vectors(kept, SUM_GRAVITY, kept, SUM_FIELD)
    if w == 0.0 and x == 0.0 and y == 0.0 and z == 0.0:
        w, x, y, z = tilted_to_gravity(q[s, 0], q[s, 1], q[s, 2], q[s, 3], kept, SUM_GRAVITY)
    else:
        count[HEADING_KNOWN] = 1
    q[s, 0], q[s, 1], q[s, 2], q[s, 3] = w, x, y, z
    if count[COLLECTED] < settings[START_SAMPLES]:
        return HOLD
    if kept[FIELD_REFERENCE] == 0.0 and count[FIELD_COLLECTED]:
        kept[FIELD_REFERENCE] = kept[SUM_FIELD_NORM] / count[FIELD_COLLECTED]
    count[RUNNING] = 1
    return BEGIN


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
    rx, ry, rz = gyroscope_radps[s, k, 0], gyroscope_radps[s, k, 1], gyroscope_radps[s, k, 2]
    sx = accelerometer_mps2[s, k, 0] * (-1.0 / GRAVITY_MPS2)
    sy = accelerometer_mps2[s, k, 1] * (-1.0 / GRAVITY_MPS2)
    sz = accelerometer_mps2[s, k, 2] * (-1.0 / GRAVITY_MPS2)
    square = sx * sx + sy * sy + sz * sz
    # Zero if all are finite, and not a number otherwise.
    finite = 0.0 * (rx + ry + rz + square)
    sample[RATE], sample[RATE + 1], sample[RATE + 2] = rx, ry, rz
    sample[GRAVITY], sample[GRAVITY + 1], sample[GRAVITY + 2] = sx, sy, sz
    sample[GRAVITY_NORM] = math.sqrt(square)
    sample[GAP_VARIANCE] = 0.0
    sample[FIELD_NORM] = 1.0
    norm, has_field = 0.0, 0.0
    if magnetometer_t.shape[0] > 0:
        mx, my, mz = magnetometer_t[s, k, 0], magnetometer_t[s, k, 1], magnetometer_t[s, k, 2]
        norm = math.sqrt(mx * mx + my * my + mz * mz)
        sample[FIELD], sample[FIELD + 1], sample[FIELD + 2] = mx, my, mz
        has_field = 1.0 if 0.0 < norm < math.inf else 0.0
    sample[HAS_FIELD] = has_field
    mark = quality[s, k]
    flawed = mark & (_SAMPLE_MISSING | _SAMPLE_SATURATED)
    if finite != 0.0 or flawed != 0 or counters[s, RUNNING] == 0 or square == 0.0:
        action = prepare_unusual(s, mark, settings, q, memory, counters, sample, norm)
        if action != FILTER:
            return action
    else:
        counters[s, GAP] = 0
        counters[s, SINCE_START] += 1
    if settings[MIDPOINT] > 0.0:
        sample[RATE] = 0.5 * (memory[s, LAST_RATE] + rx)
        sample[RATE + 1] = 0.5 * (memory[s, LAST_RATE + 1] + ry)
        sample[RATE + 2] = 0.5 * (memory[s, LAST_RATE + 2] + rz)
    memory[s, LAST_RATE], memory[s, LAST_RATE + 1], memory[s, LAST_RATE + 2] = rx, ry, rz
    if has_field > 0.0:
        reference = memory[s, FIELD_REFERENCE]
        if reference == 0.0:
            memory[s, FIELD_REFERENCE] = reference = norm
        share = norm / reference
        sample[FIELD_NORM] = share
        if abs(share - 1.0) > settings[FIELD_TOLERANCE]:
            counters[s, DISTURBED] += 1
        else:
            counters[s, DISTURBED] = 0
            memory[s, FIELD_REFERENCE] = reference + settings[FIELD_REFERENCE_GAIN] * (norm - reference)
    return FILTER


@kernel("void(int64, float64[:, ::1], float64[::1], int64[:, ::1])")
def set_heading(s: int, q: Float, sample: Float, counters: NDArray[np.int64]) -> None:
    """Turn the attitude to the first field ever seen: its heading so far was arbitrary."""
    w, x, y, z = q[s, 0], q[s, 1], q[s, 2], q[s, 3]
    north, east, _ = rotate(w, x, y, z, sample[FIELD], sample[FIELD + 1], sample[FIELD + 2])
    half = -0.5 * math.atan2(east, north)
    w, x, y, z = multiply(math.cos(half), 0.0, 0.0, math.sin(half), w, x, y, z)
    q[s, 0], q[s, 1], q[s, 2], q[s, 3] = w, x, y, z
    counters[s, HEADING_KNOWN] = 1


@kernel("float64(int64, float64[:, ::1], int64[:, ::1], float64[::1])")
def start_variance(s: int, memory: Float, counters: NDArray[np.int64], settings: Float) -> float:
    """Return the variance per axis of the start attitude: more if the sensor turned or was pushed."""
    count = counters[s, COLLECTED]
    turned = gravity = 0.0
    for axis in range(3):
        turned += (memory[s, SUM_RATE + axis] * settings[STEP_S]) ** 2
        gravity += (memory[s, SUM_GRAVITY + axis] / count) ** 2
    push = math.sqrt(gravity) - 1.0
    return float(settings[ATTITUDE_SIGMA] ** 2 + turned + push * push)


@kernel(
    "void(int64, int64, int64, int64, float64, float64, float64, uint8[:, ::1], float64[::1],"
    "float64[:, ::1], float64[:, ::1], int64[:, ::1], float64[::1], float64[:, :, ::1], float64[:, :, ::1],"
    "float64[:, :, ::1], uint8[:, ::1])",
    inlined=True,
)
def store(
    s: int,
    k: int,
    action: int,
    own_flag: int,
    variance_north: float,
    variance_east: float,
    variance_down: float,
    quality: NDArray[np.uint8],
    settings: Float,
    q: Float,
    bias: Float,
    counters: NDArray[np.int64],
    sample: Float,
    q_earth_sensor: Float,
    bias_out: Float,
    sigma_rad: Float,
    flags: NDArray[np.uint8],
) -> None:
    """Write the estimate in the product's earth frame with sigma and flags; `own_flag` is the filter's."""
    # Rotation from north-east-down to east-north-up: half a turn about the line between x and y.
    w, x, y, z = _HALF_ROOT * q[s, 0], _HALF_ROOT * q[s, 1], _HALF_ROOT * q[s, 2], _HALF_ROOT * q[s, 3]
    q_earth_sensor[s, k, 0] = -x - y
    q_earth_sensor[s, k, 1] = w + z
    q_earth_sensor[s, k, 2] = w - z
    q_earth_sensor[s, k, 3] = y - x
    for axis in range(3):
        bias_out[s, k, axis] = bias[s, axis]
    flag = own_flag
    mark = quality[s, k]
    if mark != 0:
        if mark & _SAMPLE_BRIDGED:
            flag |= _BRIDGED
        if mark & _SAMPLE_SATURATED:
            flag |= _SATURATED
    running = counters[s, RUNNING] != 0
    if not running:
        if action == HOLD and counters[s, COLLECTED] == 0:
            flags[s, k] = flag | _INVALID | _NO_HEADING
            for axis in range(3):
                sigma_rad[s, k, axis] = math.pi
            return
        variance_north = variance_east = variance_down = settings[ATTITUDE_SIGMA] ** 2
    sigma_down = min(math.sqrt(max(variance_down, 0.0)), math.pi)
    sigma_rad[s, k, 0] = min(math.sqrt(max(variance_east, 0.0)), math.pi)
    sigma_rad[s, k, 1] = min(math.sqrt(max(variance_north, 0.0)), math.pi)
    sigma_rad[s, k, 2] = sigma_down
    if action == COAST:
        flag |= _BRIDGED
    elif abs(sample[GRAVITY_NORM] - 1.0) > settings[ACCELERATION_TOLERANCE_G]:
        flag |= _ACCELERATION
    if counters[s, SINCE_START] < settings[CONVERGENCE_TICKS]:
        flag |= _CONVERGING
    disturbed = counters[s, DISTURBED]
    if disturbed > 0:
        flag |= _DISTURBANCE
    if (
        counters[s, HEADING_KNOWN] == 0
        or disturbed > settings[DISTURBED_TICKS]
        or sigma_down > settings[HEADING_LOST]
    ):
        flag |= _NO_HEADING
    flags[s, k] = flag
