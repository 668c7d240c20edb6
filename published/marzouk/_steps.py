"""Steps of the filters of the arm-monitoring thesis before and after their own equations.

Inside, the thesis' convention holds (Marzouk 2009, method page 1.3): U is north-east-down and the
accelerometer is gravity-positive in g, `s = -specific force / g`. `prepare` converts on the way in and
`store` on the way out; nothing else in the product sees it. Sensor axes stay those of the device.
"""

import math
from typing import Final

from estimators._kernels import Scalars3, Scalars4, multiply, normalized, rotate, rotate_back
from estimators.conventions import GRAVITY_MPS2
from estimators.kernels import Fields, Record, record, step
from estimators.orientation._contract import OrientationFlag
from estimators.orientation._strapdown_steps import (
    BEGIN,
    COAST,
    FILTER,
    HOLD,
    Estimates,
    Ticks,
    cross_gap,
    sigma_of,
)
from estimators.recording import Float, SampleQuality

SETTINGS: Final[Fields] = [
    ("step_s", "f8"),
    ("is_midpoint", "i8"),
    ("start_samples", "f8"),
    ("bridge_ticks", "f8"),
    ("convergence_ticks", "f8"),
    ("attitude_sigma", "f8"),
    ("gap_rate_sigma", "f8"),
    ("acceleration_tolerance_g", "f8"),
    ("field_tolerance", "f8"),
    ("field_reference_gain", "f8"),
    ("disturbed_ticks", "f8"),
    ("heading_lost", "f8"),
]
"""Constants of all these filters, for this time step; each filter's own follow."""

ANGLE_SETTINGS: Final[Fields] = [
    ("angle_variance", "f8", 3),  # of measured roll, pitch and yaw
    ("bias_drift", "f8", 3),
    ("motion_scale_g", "f8"),  # zero: motion does not lessen the weight of the angles
]
"""Constants of the two filters that measure angles."""

STATE: Final[Fields] = [
    ("q", "f8", 4),  # q_U_sensor
    ("bias", "f8", 3),
    ("last_rate", "f8", 3),
    # Sums over the samples of a start, in sensor axes.
    ("sum_rate", "f8", 3),
    ("sum_force", "f8", 3),  # gravity-positive, in g
    ("sum_field", "f8", 3),
    ("sum_field_norm", "f8"),
    ("field_reference", "f8"),  # norm, in tesla; zero until known
    ("is_running", "i8"),
    ("collected", "i8"),
    ("field_collected", "i8"),
    ("gap", "i8"),
    ("since_start", "i8"),
    ("disturbed", "i8"),
    ("is_heading_known", "i8"),
]
"""What all these filters carry from sample to sample, a record a sensor, apart from the covariance."""

SAMPLE: Final = record(
    [
        ("rate", "f8", 3),
        ("gravity", "f8", 3),
        ("field", "f8", 3),
        ("field_norm", "f8"),  # over that of the reference
        ("gravity_norm", "f8"),
        ("has_field", "i8"),
        ("gap_variance", "f8"),
    ]
)
"""One tick of one sensor, prepared."""

_HALF_ROOT = math.sqrt(0.5)
_INVALID = int(OrientationFlag.INVALID | OrientationFlag.HEADING_NOT_TRUSTED)
_BRIDGED = int(OrientationFlag.BRIDGED)
_CONVERGING = int(OrientationFlag.CONVERGING)
_ACCELERATION = int(OrientationFlag.ACCELERATION_NOT_TRUSTED)
_DISTURBANCE = int(OrientationFlag.MAGNETIC_DISTURBANCE)
_NO_HEADING = int(OrientationFlag.HEADING_NOT_TRUSTED)
_SATURATED = int(OrientationFlag.SATURATED)
_SAMPLE_BRIDGED = int(SampleQuality.BRIDGED)
_SAMPLE_MISSING = int(SampleQuality.MISSING)
_SAMPLE_SATURATED = int(SampleQuality.SATURATED)


@step("UniTuple(float64, 4)(UniTuple(float64, 3), UniTuple(float64, 3))")
def attitude_from_vectors(gravity: Scalars3, field: Scalars3) -> Scalars4:
    """Return q_U_sensor from gravity and field in the sensor frame (A4 and A5); all zero if parallel.

    Down is gravity, east is down x field, north is east x down; these are the rows of R_US.
    """
    dx, dy, dz = gravity
    fx, fy, fz = field
    norm = math.sqrt(dx * dx + dy * dy + dz * dz)
    dx, dy, dz = dx / norm, dy / norm, dz / norm
    ex = dy * fz - dz * fy
    ey = dz * fx - dx * fz
    ez = dx * fy - dy * fx
    east = math.sqrt(ex * ex + ey * ey + ez * ez)
    whole = math.sqrt(fx**2 + fy**2 + fz**2)
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


@step("UniTuple(float64, 4)(float64, float64, float64, float64, UniTuple(float64, 3))")
def tilted_to_gravity(w: float, x: float, y: float, z: float, gravity: Scalars3) -> Scalars4:
    """Turn q_U_sensor by the least angle so that it agrees with measured gravity; heading is unchanged."""
    vx, vy, vz = rotate_back(w, x, y, z, 0.0, 0.0, 1.0)
    sx, sy, sz = gravity
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


@step()
def collect(x: Record, c: Record, sample: Record, field_norm: float) -> int:
    """Gather the samples of a start; the attitude is that of their mean so far (A11)."""
    if x.collected == 0:
        x.sum_field_norm = 0.0
    x.collected += 1
    for axis in range(3):
        x.last_rate[axis] = sample.rate[axis]
        x.sum_rate[axis] += sample.rate[axis]
        x.sum_force[axis] += sample.gravity[axis]
        if sample.has_field:
            x.sum_field[axis] += sample.field[axis]
    gravity = x.sum_force[0], x.sum_force[1], x.sum_force[2]
    q = 0.0, 0.0, 0.0, 0.0
    if sample.has_field:
        x.field_collected += 1
        x.sum_field_norm += field_norm
    if x.field_collected > 0:
        q = attitude_from_vectors(gravity, (x.sum_field[0], x.sum_field[1], x.sum_field[2]))
    if q[0] == 0.0 and q[1] == 0.0 and q[2] == 0.0 and q[3] == 0.0:
        q = tilted_to_gravity(x.q[0], x.q[1], x.q[2], x.q[3], gravity)
    else:
        x.is_heading_known = 1
    x.q[0], x.q[1], x.q[2], x.q[3] = q
    if x.collected < c.start_samples:
        return HOLD
    if x.field_reference == 0.0 and x.field_collected:
        x.field_reference = x.sum_field_norm / x.field_collected
    x.is_running = 1
    return BEGIN


@step()
def prepare_unusual(x: Record, c: Record, sample: Record, quality: int, field_norm: float) -> int:
    """Start from the mean of the first samples, coast short gaps, hold long ones.

    While a gap is coasted at the last rate its error grows with `gap_rate_sigma`; after a long one the filter starts
    again, with its bias and, lacking a field, its heading.
    """
    usable = (quality & _SAMPLE_MISSING) == 0 and sample.gravity_norm > 0.0
    for axis in range(3):
        usable &= math.isfinite(sample.rate[axis]) and math.isfinite(sample.gravity[axis])
    growth = (c.gap_rate_sigma * c.step_s) ** 2
    if not usable:
        sample.has_field = 0
        return cross_gap(x, c, sample, growth)
    x.gap = 0
    x.since_start = x.since_start + 1 if x.is_running or x.collected else 0
    if quality & _SAMPLE_SATURATED:
        sample.gap_variance = growth
    return FILTER if x.is_running else collect(x, c, sample, field_norm)


@step(inlined=True)
def judge_field(x: Record, c: Record, sample: Record, norm: float) -> None:
    """Compare the norm of the field with that of the reference, which it moves where they agree."""
    reference = x.field_reference
    if reference == 0.0:
        x.field_reference = reference = norm
    share = norm / reference
    sample.field_norm = share
    if abs(share - 1.0) > c.field_tolerance:
        x.disturbed += 1
    else:
        x.disturbed = 0
        x.field_reference = reference + c.field_reference_gain * (norm - reference)


@step(inlined=True)
def prepare(ticks: Ticks, s: int, k: int, x: Record, c: Record, sample: Record) -> int:
    """Read tick `k` of sensor `s` into `sample` and say what the filter is to do."""
    force, rate, quality = ticks.accelerometer_mps2, ticks.gyroscope_radps, ticks.quality[s, k]
    rx, ry, rz = rate[s, k, 0], rate[s, k, 1], rate[s, k, 2]
    sx = force[s, k, 0] * (-1.0 / GRAVITY_MPS2)
    sy = force[s, k, 1] * (-1.0 / GRAVITY_MPS2)
    sz = force[s, k, 2] * (-1.0 / GRAVITY_MPS2)
    square = sx * sx + sy * sy + sz * sz
    # Zero if all are finite, and not a number otherwise.
    finite = 0.0 * (rx + ry + rz + square)
    sample.rate[0], sample.rate[1], sample.rate[2] = rx, ry, rz
    sample.gravity[0], sample.gravity[1], sample.gravity[2] = sx, sy, sz
    sample.gravity_norm = math.sqrt(square)
    sample.gap_variance = 0.0
    sample.field_norm = 1.0
    norm, has_field = 0.0, 0
    if ticks.magnetometer_t.shape[0] > 0:
        field = ticks.magnetometer_t
        mx, my, mz = field[s, k, 0], field[s, k, 1], field[s, k, 2]
        norm = math.sqrt(mx * mx + my * my + mz * mz)
        sample.field[0], sample.field[1], sample.field[2] = mx, my, mz
        has_field = 1 if 0.0 < norm < math.inf else 0
    sample.has_field = has_field
    flawed = quality & (_SAMPLE_MISSING | _SAMPLE_SATURATED)
    if finite != 0.0 or flawed != 0 or x.is_running == 0 or square == 0.0:
        action = prepare_unusual(x, c, sample, quality, norm)
        if action != FILTER:
            return action
    else:
        x.gap = 0
        x.since_start += 1
    if c.is_midpoint:
        sample.rate[0] = 0.5 * (x.last_rate[0] + rx)
        sample.rate[1] = 0.5 * (x.last_rate[1] + ry)
        sample.rate[2] = 0.5 * (x.last_rate[2] + rz)
    x.last_rate[0], x.last_rate[1], x.last_rate[2] = rx, ry, rz
    if has_field:
        judge_field(x, c, sample, norm)
    return FILTER


@step()
def set_heading(x: Record, sample: Record) -> None:
    """Turn the attitude to the first field ever seen: its heading so far was arbitrary."""
    w, qx, y, z = x.q[0], x.q[1], x.q[2], x.q[3]
    north, east, _ = rotate(w, qx, y, z, sample.field[0], sample.field[1], sample.field[2])
    half = -0.5 * math.atan2(east, north)
    x.q[0], x.q[1], x.q[2], x.q[3] = multiply(math.cos(half), 0.0, 0.0, math.sin(half), w, qx, y, z)
    x.is_heading_known = 1


@step()
def begin(x: Record, p: Float, c: Record, states: int, scale: float) -> None:
    """Set the start covariance of the first `states`, `scale` times the variance of the attitude.

    It is known less well if the sensor turned or was pushed. That of the offset stays.
    """
    turned = gravity = 0.0
    for axis in range(3):
        turned += (x.sum_rate[axis] * c.step_s) ** 2
        gravity += (x.sum_force[axis] / x.collected) ** 2
    push = math.sqrt(gravity) - 1.0
    variance = scale * (c.attitude_sigma**2 + turned + push * push)
    for i in range(states):
        for j in range(i, p.shape[0]):
            p[i, j] = 0.0
        p[i, i] = variance


@step(inlined=True)
def motion_weight(sample: Record, c: Record) -> float:
    """Return the factor of the variance of measured angles: one where gravity alone is felt (A10)."""
    if not c.motion_scale_g > 0.0:
        return 1.0
    push = (sample.gravity_norm - 1.0) / c.motion_scale_g
    return float(1.0 + push * push)


@step(inlined=True)
def horizontal_field(sample: Record) -> tuple[float, float]:
    """Return the field's east and north at a yaw of zero, tilt compensated, both times the same positive number.

    The page's A5 lacks the norm of s; without it the yaw is wrong whenever the arm is pushed.
    """
    sx, sy, sz = sample.gravity[0], sample.gravity[1], sample.gravity[2]
    mx, my, mz = sample.field[0], sample.field[1], sample.field[2]
    px, py, pz = my * sz - mz * sy, mz * sx - mx * sz, mx * sy - my * sx
    return -px * sample.gravity_norm, sy * pz - sz * py


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
    """Write the estimate in the product's earth frame with sigma, from variances about north, east and down, and flags.

    `own_flag` is the filter's.
    """
    # Rotation from north-east-down to east-north-up: half a turn about the line between x and y.
    w, qx, y, z = _HALF_ROOT * x.q[0], _HALF_ROOT * x.q[1], _HALF_ROOT * x.q[2], _HALF_ROOT * x.q[3]
    out.q[s, k, 0] = -qx - y
    out.q[s, k, 1] = w + z
    out.q[s, k, 2] = w - z
    out.q[s, k, 3] = y - qx
    for axis in range(3):
        out.bias[s, k, axis] = x.bias[axis]
    flag = own_flag
    if quality:
        if quality & _SAMPLE_BRIDGED:
            flag |= _BRIDGED
        if quality & _SAMPLE_SATURATED:
            flag |= _SATURATED
    if x.is_running == 0:
        if x.collected == 0:
            out.flags[s, k] = flag | _INVALID
            for axis in range(3):
                out.sigma_rad[s, k, axis] = math.pi
            return
        variances = c.attitude_sigma**2, c.attitude_sigma**2, c.attitude_sigma**2
    sigma_down = sigma_of(variances[2])
    out.sigma_rad[s, k, 0] = sigma_of(variances[1])
    out.sigma_rad[s, k, 1] = sigma_of(variances[0])
    out.sigma_rad[s, k, 2] = sigma_down
    if action == COAST:
        flag |= _BRIDGED
    elif abs(sample.gravity_norm - 1.0) > c.acceleration_tolerance_g:
        flag |= _ACCELERATION
    if x.since_start < c.convergence_ticks:
        flag |= _CONVERGING
    if x.disturbed > 0:
        flag |= _DISTURBANCE
    if x.is_heading_known == 0 or x.disturbed > c.disturbed_ticks or sigma_down > c.heading_lost:
        flag |= _NO_HEADING
    out.flags[s, k] = flag
