"""VQF (Laidig and Seel, Information Fusion 91, 2023) compiled over sensors and ticks.

Our own formulation of the published algorithm, with the behaviour of the authors' `vqf` package 2.1,
which the tests hold against it: prediction by the gyroscope, inclination from specific force low-passed
in an almost inertial frame, heading from the field with rejection of disturbances, bias by a Kalman filter
in motion and at rest. What the package lacks is here too: gaps. Field in microtesla; any unit would do.
"""

import math

from estimators._kernels import kernel, multiply, normalized, rotate, rotate_back
from estimators.conventions import GRAVITY_MPS2
from estimators.recording import Float

# Positions in a sensor's state. A filter of n channels takes 1 + 2 n: the number of samples averaged so
# far (RUNNING once it filters), then two memories a channel; while averaging, the first holds the sum.
GYROSCOPE_Q, ACCELEROMETER_Q, DELTA = 0, 4, 8
AT_REST, REST_S, REST_RATE = 9, 10, 11
REST_RATE_FILTER, REST_FORCE_FILTER = 14, 21
FORCE_FILTER, MATRIX_FILTER, BIAS_FILTER = 28, 35, 54
BIAS, BIAS_COVARIANCE = 59, 62
FIELD_REJECTED, FIELD_NORM, FIELD_DIP = 71, 72, 73
UNDISTURBED_S, REJECTED_S = 74, 75
CANDIDATE_NORM, CANDIDATE_DIP, CANDIDATE_S = 76, 77, 78
FIELD_FILTER, START_GAIN, IN_GAP, STARTED = 79, 84, 85, 86
STATE = 87
RUNNING = -1.0

# Positions in the settings; a filter's five coefficients are b0 b1 b2 a1 a2, then its time constant.
STEP_S = 0
FORCE_COEFFICIENTS, REST_COEFFICIENTS, FIELD_COEFFICIENTS = 1, 7, 13
(
    HEADING_GAIN,
    REFERENCE_GAIN,
    MOTION_BIAS,
    REST_BIAS,
    REJECTION,
    BIAS_START_VARIANCE,
    BIAS_DRIFT,
    BIAS_LIMIT,
    MOTION_WEIGHT,
    VERTICAL_WEIGHT,
    REST_WEIGHT,
    REST_MINIMUM_S,
    REST_RATE_LIMIT,
    REST_FORCE_LIMIT,
    NORM_TOLERANCE,
    DIP_TOLERANCE,
    NEW_FIELD_S,
    FIRST_FIELD_S,
    NEW_FIELD_RATE,
    UNDISTURBED_MINIMUM_S,
    REJECTED_MAXIMUM_S,
    REJECTION_FACTOR,
    HEADING_TIME_S,
    LATENCY_S,
    RESTART_TILT_SAMPLES,
    RESTART_GAIN,
) = range(19, 45)
SETTINGS = 45

_EPSILON = 2.0**-52


@kernel("void(float64[::1], int64, int64, float64[::1], int64, float64[::1])")
def low_pass(state: Float, at: int, channels: int, settings: Float, coefficients: int, values: Float) -> None:
    """Replace `values` by their second-order low-pass; the mean, for the first time constant."""
    count = state[at]
    b0, b1, b2 = settings[coefficients], settings[coefficients + 1], settings[coefficients + 2]
    a1, a2 = settings[coefficients + 3], settings[coefficients + 4]
    if count < 0.0:
        for i in range(channels):
            first = at + 1 + 2 * i
            x = values[i]
            y = b0 * x + state[first]
            state[first] = b1 * x - a1 * y + state[first + 1]
            state[first + 1] = b2 * x - a2 * y
            values[i] = y
        return
    count += 1.0
    state[at] = count
    for i in range(channels):
        first = at + 1 + 2 * i
        state[first] += values[i]
        values[i] = state[first] / count
    if count * settings[STEP_S] >= settings[coefficients + 5]:
        state[at] = RUNNING
        for i in range(channels):
            first = at + 1 + 2 * i
            # The memory of a filter that has always seen this value.
            state[first] = values[i] * (1.0 - b0)
            state[first + 1] = values[i] * (b2 - a2)


@kernel("void(float64[::1], int64, int64)")
def forget(state: Float, at: int, channels: int) -> None:
    """Let a filter begin by averaging again."""
    for i in range(1 + 2 * channels):
        state[at + i] = 0.0


@kernel("void(float64[::1], float64[::1])")
def restart(state: Float, settings: Float) -> None:
    """After a gap: average anew around the held inclination and heading; keep bias and reference field."""
    forget(state, REST_RATE_FILTER, 3)
    forget(state, REST_FORCE_FILTER, 3)
    forget(state, MATRIX_FILTER, 9)
    forget(state, BIAS_FILTER, 2)
    forget(state, FIELD_FILTER, 2)
    forget(state, FORCE_FILTER, 3)
    state[REST_S] = state[AT_REST] = 0.0
    weight = settings[RESTART_TILT_SAMPLES]
    a = ACCELEROMETER_Q
    up = rotate_back(state[a], state[a + 1], state[a + 2], state[a + 3], 0.0, 0.0, GRAVITY_MPS2)
    state[FORCE_FILTER] = weight
    for axis in range(3):
        state[FORCE_FILTER + 1 + 2 * axis] = weight * up[axis]
    if not (state[FIELD_REJECTED] > 0.0 and state[FIELD_NORM] > 0.0):
        state[START_GAIN] = max(state[START_GAIN], settings[RESTART_GAIN])


@kernel("void(float64[::1], float64[::1], float64, float64, float64, float64[::1])")
def predict(state: Float, settings: Float, wx: float, wy: float, wz: float, values: Float) -> None:
    """Watch for rest and turn by the rate without its bias."""
    limit = settings[BIAS_LIMIT]
    if settings[REST_BIAS] > 0.0 or settings[REJECTION] > 0.0:
        values[0], values[1], values[2] = wx, wy, wz
        low_pass(state, REST_RATE_FILTER, 3, settings, REST_COEFFICIENTS, values)
        deviation = (wx - values[0]) ** 2 + (wy - values[1]) ** 2 + (wz - values[2]) ** 2
        fast = abs(values[0]) > limit or abs(values[1]) > limit or abs(values[2]) > limit
        for axis in range(3):
            state[REST_RATE + axis] = values[axis]
        if fast or deviation >= settings[REST_RATE_LIMIT] ** 2:
            state[REST_S] = state[AT_REST] = 0.0
    wx, wy, wz = wx - state[BIAS], wy - state[BIAS + 1], wz - state[BIAS + 2]
    norm = math.sqrt(wx * wx + wy * wy + wz * wz)
    if norm > _EPSILON:
        half = 0.5 * norm * settings[STEP_S]
        scale = math.sin(half) / norm
        w, x, y, z = multiply(
            state[0], state[1], state[2], state[3], math.cos(half), scale * wx, scale * wy, scale * wz
        )
        state[0], state[1], state[2], state[3] = normalized(w, x, y, z)


@kernel("void(float64[::1], float64[::1], float64, float64, float64[::1], float64[:, ::1])")
def learn_bias(
    state: Float, settings: Float, drift_x: float, drift_y: float, values: Float, work: Float
) -> None:
    """Update the bias by a Kalman filter: by the mean rate at rest, by the drift of inclination in motion.

    `drift_x`, `drift_y`: horizontal part of the corrected direction a second. The covariance is in
    squares of 0.01 degrees a second.
    """
    w, x, y, z = multiply(state[4], state[5], state[6], state[7], state[0], state[1], state[2], state[3])
    values[0], values[1], values[2] = (
        1.0 - 2.0 * (y * y + z * z),
        2.0 * (x * y - w * z),
        2.0 * (w * y + x * z),
    )
    values[3], values[4], values[5] = (
        2.0 * (w * z + x * y),
        1.0 - 2.0 * (x * x + z * z),
        2.0 * (y * z - w * x),
    )
    values[6], values[7], values[8] = (
        2.0 * (x * z - w * y),
        2.0 * (w * x + y * z),
        1.0 - 2.0 * (x * x + y * y),
    )
    bx, by, bz = state[BIAS], state[BIAS + 1], state[BIAS + 2]
    seen = work[3]
    seen[0] = values[0] * bx + values[1] * by + values[2] * bz
    seen[1] = values[3] * bx + values[4] * by + values[5] * bz
    low_pass(state, MATRIX_FILTER, 9, settings, FORCE_COEFFICIENTS, values)
    low_pass(state, BIAS_FILTER, 2, settings, FORCE_COEFFICIENTS, seen)
    p = BIAS_COVARIANCE
    for axis in range(3):
        if state[p + 4 * axis] < settings[BIAS_START_VARIANCE]:
            state[p + 4 * axis] += settings[BIAS_DRIFT]
    limit = settings[BIAS_LIMIT]
    resting = state[AT_REST] > 0.0 and settings[REST_BIAS] > 0.0
    if resting:
        e0, e1, e2 = state[REST_RATE] - bx, state[REST_RATE + 1] - by, state[REST_RATE + 2] - bz
        weight_horizontal = weight_vertical = settings[REST_WEIGHT]
        for i in range(9):
            values[i] = 1.0 if i % 4 == 0 else 0.0
    elif settings[MOTION_BIAS] > 0.0:
        e0 = seen[0] - drift_y - (values[0] * bx + values[1] * by + values[2] * bz)
        e1 = seen[1] + drift_x - (values[3] * bx + values[4] * by + values[5] * bz)
        e2 = -(values[6] * bx + values[7] * by + values[8] * bz)
        weight_horizontal, weight_vertical = settings[MOTION_WEIGHT], settings[VERTICAL_WEIGHT]
    else:
        return
    e0, e1, e2 = (
        min(max(e0, -limit), limit),
        min(max(e1, -limit), limit),
        min(max(e2, -limit), limit),
    )
    # a = R P, innovation covariance a R' + W, gain a' inv(...), P <- P - gain a.
    a, inverse, gain = work[0], work[1], work[2]
    for i in range(3):
        for j in range(3):
            a[3 * i + j] = (
                values[3 * i] * state[p + j]
                + values[3 * i + 1] * state[p + 3 + j]
                + values[3 * i + 2] * state[p + 6 + j]
            )
    s00 = a[0] * values[0] + a[1] * values[1] + a[2] * values[2] + weight_horizontal
    s01 = a[0] * values[3] + a[1] * values[4] + a[2] * values[5]
    s02 = a[0] * values[6] + a[1] * values[7] + a[2] * values[8]
    s11 = a[3] * values[3] + a[4] * values[4] + a[5] * values[5] + weight_horizontal
    s12 = a[3] * values[6] + a[4] * values[7] + a[5] * values[8]
    s22 = a[6] * values[6] + a[7] * values[7] + a[8] * values[8] + weight_vertical
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
        moved = state[BIAS + i] + gain[3 * i] * e0 + gain[3 * i + 1] * e1 + gain[3 * i + 2] * e2
        state[BIAS + i] = min(max(moved, -limit), limit)
        for j in range(3):
            state[p + 3 * i + j] -= (
                gain[3 * i] * a[j] + gain[3 * i + 1] * a[3 + j] + gain[3 * i + 2] * a[6 + j]
            )


@kernel("void(float64[::1], float64[::1], float64, float64, float64, float64[::1], float64[:, ::1])")
def correct_inclination(
    state: Float, settings: Float, fx: float, fy: float, fz: float, values: Float, work: Float
) -> None:
    """Turn the low-passed specific force upright, and learn the bias from how far it had drifted."""
    step = settings[STEP_S]
    if settings[REST_BIAS] > 0.0:
        values[0], values[1], values[2] = fx, fy, fz
        low_pass(state, REST_FORCE_FILTER, 3, settings, REST_COEFFICIENTS, values)
        deviation = (fx - values[0]) ** 2 + (fy - values[1]) ** 2 + (fz - values[2]) ** 2
        if deviation >= settings[REST_FORCE_LIMIT] ** 2:
            state[REST_S] = state[AT_REST] = 0.0
        else:
            state[REST_S] += step
            if state[REST_S] >= settings[REST_MINIMUM_S]:
                state[AT_REST] = 1.0
    values[0], values[1], values[2] = rotate(state[0], state[1], state[2], state[3], fx, fy, fz)
    low_pass(state, FORCE_FILTER, 3, settings, FORCE_COEFFICIENTS, values)
    a = ACCELEROMETER_Q
    aw, ax, ay, az = state[a], state[a + 1], state[a + 2], state[a + 3]
    ux, uy, uz = rotate(aw, ax, ay, az, values[0], values[1], values[2])
    norm = math.sqrt(ux * ux + uy * uy + uz * uz)
    if norm >= _EPSILON:
        ux, uy, uz = ux / norm, uy / norm, uz / norm
    half = math.sqrt(max(0.5 * (uz + 1.0), 0.0))
    if half > 1e-6:
        aw, ax, ay, az = multiply(half, 0.5 * uy / half, -0.5 * ux / half, 0.0, aw, ax, ay, az)
    else:
        aw, ax, ay, az = multiply(0.0, 1.0, 0.0, 0.0, aw, ax, ay, az)
    aw, ax, ay, az = normalized(aw, ax, ay, az)
    state[a], state[a + 1], state[a + 2], state[a + 3] = aw, ax, ay, az
    if settings[MOTION_BIAS] > 0.0 or settings[REST_BIAS] > 0.0:
        learn_bias(state, settings, ux / step, uy / step, values, work)
