"""VQF (Laidig and Seel, Information Fusion 91, 2023) compiled over sensors and ticks: inclination and bias.

Our own formulation of the published algorithm, with the behaviour of the authors' `vqf` package 2.1,
which the tests hold against it: prediction by the gyroscope, inclination from specific force low-passed
in an almost inertial frame, heading from the field with rejection of disturbances, bias by a Kalman filter
in motion and at rest. What the package lacks is here too: gaps. Field in microtesla; any unit would do.
"""

import math

from estimators._kernels import multiply, normalized, rotate, rotate_back
from estimators.conventions import GRAVITY_MPS2
from estimators.kernels import Record, fields_of, record, step
from estimators.orientation.vqf._parameters import VqfParameters, settings_of
from estimators.recording import Float

B0, B1, B2, A1, A2, SETTLED_S = range(6)
"""Coefficients of a low-pass, then its time constant: until then it is the mean."""
SETTINGS = record(fields_of(settings_of(VqfParameters(), 1.0)))
"""Constants for one time step."""

STATE = record(
    [
        ("q", "f8", 4),  # q_earth_sensor of the last usable sample
        ("bias", "f8", 3),
        ("gyroscope_q", "f8", 4),
        ("accelerometer_q", "f8", 4),
        ("delta", "f8"),  # heading
        ("is_at_rest", "i8"),
        ("rest_s", "f8"),
        ("rest_rate", "f8", 3),
        # A low-pass of n channels: the number of samples averaged so far (`_RUNNING` once it filters), then two
        # memories a channel; while averaging, the first holds the sum.
        ("rest_rate_filter", "f8", 7),
        ("rest_force_filter", "f8", 7),
        ("force_filter", "f8", 7),
        ("matrix_filter", "f8", 19),
        ("bias_filter", "f8", 5),
        ("field_filter", "f8", 5),
        ("is_field_rejected", "i8"),
        ("field_norm", "f8"),  # zero until known
        ("field_dip", "f8"),
        ("undisturbed_s", "f8"),
        ("rejected_s", "f8"),
        ("candidate_norm", "f8"),
        ("candidate_dip", "f8"),
        ("candidate_s", "f8"),
        ("start_gain", "f8"),
        ("is_in_gap", "i8"),
        ("is_started", "i8"),
        ("since_start", "i8"),  # ticks; -1 before a start
        ("without_field", "i8"),  # ticks without a trusted field
        ("is_field_known", "i8"),
        ("has_seen_field", "i8"),
    ]
)
"""What is carried from sample to sample, a record a sensor, apart from the bias's covariance."""

_RUNNING = -1.0
_EPSILON = 2.0**-52


@step()
def low_pass(memory: Float, coefficients: Float, step_s: float, channels: int, values: Float) -> None:
    """Replace `values` by their second-order low-pass; the mean, for the first time constant."""
    count = memory[0]
    b0, b1, b2 = coefficients[B0], coefficients[B1], coefficients[B2]
    a1, a2 = coefficients[A1], coefficients[A2]
    if count < 0.0:
        for i in range(channels):
            first = 1 + 2 * i
            x = values[i]
            y = b0 * x + memory[first]
            memory[first] = b1 * x - a1 * y + memory[first + 1]
            memory[first + 1] = b2 * x - a2 * y
            values[i] = y
        return
    count += 1.0
    memory[0] = count
    for i in range(channels):
        first = 1 + 2 * i
        memory[first] += values[i]
        values[i] = memory[first] / count
    if count * step_s >= coefficients[SETTLED_S]:
        memory[0] = _RUNNING
        for i in range(channels):
            first = 1 + 2 * i
            # The memory of a filter that has always seen this value.
            memory[first] = values[i] * (1.0 - b0)
            memory[first + 1] = values[i] * (b2 - a2)


@step()
def restart(x: Record, c: Record) -> None:
    """After a gap: average again around the held inclination and heading, with the old bias and reference field."""
    x.rest_rate_filter[:] = 0.0
    x.rest_force_filter[:] = 0.0
    x.matrix_filter[:] = 0.0
    x.bias_filter[:] = 0.0
    x.field_filter[:] = 0.0
    x.force_filter[:] = 0.0
    x.rest_s = 0.0
    x.is_at_rest = 0
    weight, a = c.restart_tilt_samples, x.accelerometer_q
    up = rotate_back(a[0], a[1], a[2], a[3], 0.0, 0.0, GRAVITY_MPS2)
    x.force_filter[0] = weight
    for axis in range(3):
        x.force_filter[1 + 2 * axis] = weight * up[axis]
    if not (x.is_field_rejected and x.field_norm > 0.0):
        x.start_gain = max(x.start_gain, c.restart_gain)


@step()
def predict(x: Record, c: Record, wx: float, wy: float, wz: float, values: Float) -> None:
    """Watch for rest and turn by the rate without its bias."""
    limit = c.bias_limit
    if c.learns_at_rest or c.rejects:
        values[0], values[1], values[2] = wx, wy, wz
        low_pass(x.rest_rate_filter, c.rest_low_pass, c.step_s, 3, values)
        deviation = (wx - values[0]) ** 2 + (wy - values[1]) ** 2 + (wz - values[2]) ** 2
        fast = abs(values[0]) > limit or abs(values[1]) > limit or abs(values[2]) > limit
        for axis in range(3):
            x.rest_rate[axis] = values[axis]
        if fast or deviation >= c.rest_rate_limit**2:
            x.rest_s = 0.0
            x.is_at_rest = 0
    wx, wy, wz = wx - x.bias[0], wy - x.bias[1], wz - x.bias[2]
    norm = math.sqrt(wx * wx + wy * wy + wz * wz)
    if norm > _EPSILON:
        half, q = 0.5 * norm * c.step_s, x.gyroscope_q
        scale = math.sin(half) / norm
        w, qx, y, z = multiply(q[0], q[1], q[2], q[3], math.cos(half), scale * wx, scale * wy, scale * wz)
        q[0], q[1], q[2], q[3] = normalized(w, qx, y, z)


@step()
def sensor_attitude(x: Record) -> tuple[float, float, float, float]:
    """Return the attitude of the sensor apart from its heading."""
    a, g = x.accelerometer_q, x.gyroscope_q
    return multiply(a[0], a[1], a[2], a[3], g[0], g[1], g[2], g[3])


@step()
def learn_bias(
    x: Record, p: Float, c: Record, drift_x: float, drift_y: float, values: Float, work: Float
) -> None:
    """Update the bias by a Kalman filter: by the mean rate at rest, by the drift of inclination in motion.

    `drift_x`, `drift_y`: horizontal part of the corrected direction a second. `p` (3, 3) is the covariance.
    """
    w, qx, y, z = sensor_attitude(x)
    values[0], values[1], values[2] = (
        1.0 - 2.0 * (y * y + z * z),
        2.0 * (qx * y - w * z),
        2.0 * (w * y + qx * z),
    )
    values[3], values[4], values[5] = (
        2.0 * (w * z + qx * y),
        1.0 - 2.0 * (qx * qx + z * z),
        2.0 * (y * z - w * qx),
    )
    values[6], values[7], values[8] = (
        2.0 * (qx * z - w * y),
        2.0 * (w * qx + y * z),
        1.0 - 2.0 * (qx * qx + y * y),
    )
    bx, by, bz = x.bias[0], x.bias[1], x.bias[2]
    seen = work[3]
    seen[0] = values[0] * bx + values[1] * by + values[2] * bz
    seen[1] = values[3] * bx + values[4] * by + values[5] * bz
    low_pass(x.matrix_filter, c.force_low_pass, c.step_s, 9, values)
    low_pass(x.bias_filter, c.force_low_pass, c.step_s, 2, seen)
    for axis in range(3):
        if p[axis, axis] < c.bias_start_variance:
            p[axis, axis] += c.bias_drift
    if x.is_at_rest and c.learns_at_rest:
        e0, e1, e2 = x.rest_rate[0] - bx, x.rest_rate[1] - by, x.rest_rate[2] - bz
        weight_horizontal = weight_vertical = c.rest_weight
        for i in range(9):
            values[i] = 1.0 if i % 4 == 0 else 0.0
    elif c.learns_in_motion:
        e0 = seen[0] - drift_y - (values[0] * bx + values[1] * by + values[2] * bz)
        e1 = seen[1] + drift_x - (values[3] * bx + values[4] * by + values[5] * bz)
        e2 = -(values[6] * bx + values[7] * by + values[8] * bz)
        weight_horizontal, weight_vertical = c.motion_weight, c.vertical_weight
    else:
        return
    limit = c.bias_limit
    e0, e1, e2 = (
        min(max(e0, -limit), limit),
        min(max(e1, -limit), limit),
        min(max(e2, -limit), limit),
    )
    absorb(x, p, c, (e0, e1, e2), (weight_horizontal, weight_vertical), values, work)


@step()
def absorb(
    x: Record,
    p: Float,
    c: Record,
    error: tuple[float, float, float],
    weight: tuple[float, float],
    r: Float,
    work: Float,
) -> None:
    """Correct the bias by a measured `error` of it turned by R, with the variances across and along the vertical.

    a = R P, innovation covariance a R' + W, gain a' inv(...), P <- P - gain a.
    """
    e0, e1, e2 = error
    a, inverse, gain = work[0], work[1], work[2]
    for i in range(3):
        for j in range(3):
            a[3 * i + j] = r[3 * i] * p[0, j] + r[3 * i + 1] * p[1, j] + r[3 * i + 2] * p[2, j]
    s00 = a[0] * r[0] + a[1] * r[1] + a[2] * r[2] + weight[0]
    s01 = a[0] * r[3] + a[1] * r[4] + a[2] * r[5]
    s02 = a[0] * r[6] + a[1] * r[7] + a[2] * r[8]
    s11 = a[3] * r[3] + a[4] * r[4] + a[5] * r[5] + weight[0]
    s12 = a[3] * r[6] + a[4] * r[7] + a[5] * r[8]
    s22 = a[6] * r[6] + a[7] * r[7] + a[8] * r[8] + weight[1]
    c00, c01, c02 = s11 * s22 - s12 * s12, s02 * s12 - s01 * s22, s01 * s12 - s02 * s11
    determinant = s00 * c00 + s01 * c01 + s02 * c02
    if abs(determinant) <= _EPSILON:
        return
    inverse[0], inverse[1], inverse[2] = c00, c01, c02
    inverse[3], inverse[4], inverse[5] = c01, s00 * s22 - s02 * s02, s01 * s02 - s00 * s12
    inverse[6], inverse[7], inverse[8] = c02, inverse[5], s00 * s11 - s01 * s01
    for i in range(3):
        for j in range(3):
            gain[3 * i + j] = (
                a[i] * inverse[j] + a[3 + i] * inverse[3 + j] + a[6 + i] * inverse[6 + j]
            ) / determinant
    for i in range(3):
        moved = x.bias[i] + gain[3 * i] * e0 + gain[3 * i + 1] * e1 + gain[3 * i + 2] * e2
        x.bias[i] = min(max(moved, -c.bias_limit), c.bias_limit)
        for j in range(3):
            p[i, j] -= gain[3 * i] * a[j] + gain[3 * i + 1] * a[3 + j] + gain[3 * i + 2] * a[6 + j]


@step()
def watch_force(x: Record, c: Record, fx: float, fy: float, fz: float, values: Float) -> None:
    """Watch for rest by the specific force."""
    values[0], values[1], values[2] = fx, fy, fz
    low_pass(x.rest_force_filter, c.rest_low_pass, c.step_s, 3, values)
    deviation = (fx - values[0]) ** 2 + (fy - values[1]) ** 2 + (fz - values[2]) ** 2
    if deviation >= c.rest_force_limit**2:
        x.rest_s = 0.0
        x.is_at_rest = 0
    else:
        x.rest_s += c.step_s
        if x.rest_s >= c.rest_minimum_s:
            x.is_at_rest = 1


@step()
def correct_inclination(
    x: Record, p: Float, c: Record, fx: float, fy: float, fz: float, values: Float, work: Float
) -> None:
    """Turn the low-passed specific force upright, and learn the bias from how far it had drifted."""
    if c.learns_at_rest:
        watch_force(x, c, fx, fy, fz, values)
    g, a = x.gyroscope_q, x.accelerometer_q
    values[0], values[1], values[2] = rotate(g[0], g[1], g[2], g[3], fx, fy, fz)
    low_pass(x.force_filter, c.force_low_pass, c.step_s, 3, values)
    aw, ax, ay, az = a[0], a[1], a[2], a[3]
    ux, uy, uz = rotate(aw, ax, ay, az, values[0], values[1], values[2])
    norm = math.sqrt(ux * ux + uy * uy + uz * uz)
    if norm >= _EPSILON:
        ux, uy, uz = ux / norm, uy / norm, uz / norm
    half = math.sqrt(max(0.5 * (uz + 1.0), 0.0))
    if half > 1e-6:
        aw, ax, ay, az = multiply(half, 0.5 * uy / half, -0.5 * ux / half, 0.0, aw, ax, ay, az)
    else:
        aw, ax, ay, az = multiply(0.0, 1.0, 0.0, 0.0, aw, ax, ay, az)
    a[0], a[1], a[2], a[3] = normalized(aw, ax, ay, az)
    if c.learns_in_motion or c.learns_at_rest:
        learn_bias(x, p, c, ux / c.step_s, uy / c.step_s, values, work)
