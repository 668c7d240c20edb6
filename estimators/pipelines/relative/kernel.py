"""The way of relative pose from samples to filters and from filters to frames; compiled.

Per packet of five ticks numpy spends its time in the calls: the same columns cost some 350 microseconds there, against
25 of the filter itself. The numpy form is the oracle in the tests.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from estimators._kernels import kernel, multiply, rotate
from estimators.kernels import VOID, bundle, step
from estimators.magnetic import CURRENT_SPAN_A, RelativeFlag
from estimators.magnetic._coil_state import HIGHEST_COIL
from estimators.magnetic.relative import layout as at
from estimators.orientation import OrientationFlag
from estimators.pipelines.relative.columns import SENSOR_SCALARS, SOURCE_SCALARS
from estimators.recording import Float, SampleQuality

SENSOR_COLUMNS, SOURCE_COLUMNS = len(SENSOR_SCALARS), len(SOURCE_SCALARS)
_DISTANCE, _DISTANCE_SIGMA, _X, _X_SIGMA, _XY, _S_NIS, _S_STATE = (
    SENSOR_SCALARS.index(name)
    for name in ("distance_m", "distance_sigma_m", "x_m", "x_sigma_m", "xy_correlation", "nis", "state")
)
_COIL_ON, _CURRENT_ON, _ASK, _ON_TIME = (
    SOURCE_SCALARS.index(name) for name in ("coil", "current_a", "ask_coil", "on_time_s")
)
ON_TICKS, CHARGE, SQUARED, ACCOUNT = 0, 1, 2, 3
"""What the source has used: ticks with a coil on, charge (A s), squared current (A^2 s)."""

_GYR, _ACC, _FIELD, _GYR_C, _ACC_C = (
    at.GYROSCOPE,
    at.ACCELEROMETER,
    at.FIELD,
    at.SOURCE_GYROSCOPE,
    at.SOURCE_ACCELEROMETER,
)
_COIL, _CURRENT = at.COIL, at.CURRENT
_POSE, _PLACE, _TURN = len(at.POSE), 0, 3
_P, _Q, _COV = at.O_POSITION, at.O_ATTITUDE, at.O_COVARIANCE
_NIS, _FIRE, _FIRE_CURRENT, _FIRE_TICKS, _FLAGS = at.O_NIS, at.O_COIL, at.O_CURRENT, at.O_TICKS, at.O_FLAGS
_NOT_MEASURED = int(SampleQuality.MISSING | SampleQuality.BRIDGED)
_SPAN, _HIGHEST = CURRENT_SPAN_A, HIGHEST_COIL
_FAULT, _INVALID = int(RelativeFlag.FAULT), int(RelativeFlag.INVALID)
_SINGULAR = int(OrientationFlag.SINGULAR)
_SINGULAR_COSINE = math.sin(math.radians(10.0))
_NOT_HEADING = 255 - int(OrientationFlag.HEADING_NOT_TRUSTED)
_SHOWN = (
    (RelativeFlag.INVALID, OrientationFlag.INVALID),
    (RelativeFlag.CALIBRATING | RelativeFlag.UNCERTAIN, OrientationFlag.CONVERGING),
    (RelativeFlag.INERTIAL_ONLY | RelativeFlag.FAULT, OrientationFlag.HEADING_NOT_TRUSTED),
    (RelativeFlag.DISTURBED, OrientationFlag.MAGNETIC_DISTURBANCE),
    (RelativeFlag.SATURATED, OrientationFlag.SATURATED),
    (RelativeFlag.GAP, OrientationFlag.BRIDGED),
)
_SAID, _SHOWN_AS = tuple(int(own) for own, _ in _SHOWN), tuple(int(shown) for _, shown in _SHOWN)
_TWO_PI = 2.0 * math.pi

Nine = tuple[float, float, float, float, float, float, float, float, float]


@step("UniTuple(float64, 9)(float64, float64, float64, float64)")
def matrix(w: float, x: float, y: float, z: float) -> Nine:
    """Return the rotation matrix of a unit quaternion, row by row."""
    return (
        1.0 - 2.0 * (y * y + z * z),
        2.0 * (x * y - w * z),
        2.0 * (x * z + w * y),
        2.0 * (x * y + w * z),
        1.0 - 2.0 * (x * x + z * z),
        2.0 * (y * z - w * x),
        2.0 * (x * z - w * y),
        2.0 * (y * z + w * x),
        1.0 - 2.0 * (x * x + y * y),
    )


@step("float64(float64[::1], int64, float64, float64, float64)")
def sigma_along(out: Float, first: int, x: float, y: float, z: float) -> float:
    """Return one sigma along a vector of what begins at row and column `first` of the covariance in an output row."""
    a = _COV + (_POSE + 1) * first
    b, c = a + _POSE, a + 2 * _POSE
    total = x * x * out[a] + y * y * out[b + 1] + z * z * out[c + 2]
    total += 2.0 * (x * y * out[a + 1] + x * z * out[a + 2] + y * z * out[b + 2])
    return math.sqrt(max(total, 0.0))


@kernel(
    "void(float64[:, :, :], float64[:, :, :], float64[:, :, :], uint8[:, :], float64[:, :], int64, int64,"
    "float64[:, :, ::1], boolean[::1])"
)
def take(
    rate_radps: Float,
    force_mps2: Float,
    field_t: Float,
    quality: NDArray[np.uint8],
    coil_state: Float,
    source: int,
    coils: int,
    samples: Float,
    wrong: NDArray[np.bool_],
) -> None:
    """Fill what the filters take, (N, K, 17), from the signals of all S = N + 1 modules; (0, ...) where there is none.

    What was bridged is no sample, least of all of a pulse. `wrong` says where the coils do what this source cannot:
    what `estimators.magnetic.read_coil_state` does not read, another coil, or one that fires where no source is said
    to be, for then the modules are exchanged.
    """
    for k in range(quality.shape[1]):
        number = current = 0.0
        strange = False
        for s in range(coil_state.shape[0]):
            state = coil_state[s, k]
            if math.isnan(state):
                continue
            if s != source:
                strange = strange or state != 0.0
                continue
            size = abs(state)
            if not size < _HIGHEST + 1.0 or 0.0 < size < 1.0:
                strange = True
                continue
            number = math.floor(size)
            if number > 0.0:
                current = math.copysign((size - number) * _SPAN, state)
        wrong[k] = strange or number > coils
        i = 0
        for s in range(quality.shape[0]):
            if s == source:
                continue
            row = samples[i, k]
            i += 1
            row[_COIL], row[_CURRENT] = number, current
            if (quality[s, k] | quality[source, k]) & _NOT_MEASURED:
                row[:_COIL] = math.nan
                continue
            for a in range(3):
                row[_GYR + a], row[_ACC + a] = rate_radps[s, k, a], force_mps2[s, k, a]
                row[_FIELD + a] = field_t[s, k, a] if field_t.shape[0] > 0 else math.nan
                row[_GYR_C + a], row[_ACC_C + a] = rate_radps[source, k, a], force_mps2[source, k, a]


@step(
    "void(float64[::1], int64, boolean, float64[::1], float64[::1], float64[::1], float64[::1], float64[::1])"
)
def write_pose(
    out: Float,
    stated: int,
    known: bool,
    q: Float,
    scalar: Float,
    angle: Float,
    angle_sigma: Float,
    sigma: Float,
) -> None:
    """Write one tick of one sensor: its scalars, angles with sigmas, and sigmas about the axes of the room."""
    scalar[_S_NIS], scalar[_S_STATE] = out[_NIS], float(stated)
    if not known:
        scalar[:_S_NIS] = math.nan
        angle[:], angle_sigma[:], sigma[:] = math.nan, math.nan, math.nan
        return
    x, y, z = out[_P], out[_P + 1], out[_P + 2]
    distance = math.sqrt(x * x + y * y + z * z)
    scale = 1.0 / distance if distance > 0.0 else 1.0
    scalar[_DISTANCE] = distance
    scalar[_DISTANCE_SIGMA] = sigma_along(out, _PLACE, x * scale, y * scale, z * scale)
    for a in range(3):
        scalar[_X + a] = out[_P + a]
        scalar[_X_SIGMA + a] = math.sqrt(max(out[_COV + (_POSE + 1) * a], 0.0))
    column = _XY
    for a in range(2):
        for b in range(a + 1, 3):
            both = scalar[_X_SIGMA + a] * scalar[_X_SIGMA + b]
            scalar[column] = out[_COV + _POSE * a + b] / both if both > 0.0 else 0.0
            column += 1

    xx, _, _, yx, _, _, zx, zy, zz = matrix(out[_Q], out[_Q + 1], out[_Q + 2], out[_Q + 3])
    angle[0] = math.atan2(yx, xx)
    angle[1] = math.asin(min(max(-zx, -1.0), 1.0))
    angle[2] = math.atan2(zy, zz)
    sine, cosine = math.sin(angle[2]), math.cos(angle[2])
    near, tangent = math.cos(angle[1]), math.tan(angle[1])
    near = near if abs(near) >= 1e-6 else 1e-6
    # By how much the angles change with turns about the sensor's axes.
    angle_sigma[0] = sigma_along(out, _TURN, 0.0, sine / near, cosine / near)
    angle_sigma[1] = sigma_along(out, _TURN, 0.0, cosine, -sine)
    angle_sigma[2] = sigma_along(out, _TURN, 1.0, sine * tangent, cosine * tangent)

    m = matrix(q[0], q[1], q[2], q[3])
    for a in range(3):
        sigma[a] = sigma_along(out, _TURN, m[3 * a], m[3 * a + 1], m[3 * a + 2])


class Written(NamedTuple):
    """Arrays of frames to fill: K ticks leading, then segments (q, point, sigma, flags) or columns (the others)."""

    q: Float
    point_m: Float
    sigma_rad: Float
    flags: NDArray[np.uint8]
    angle_rad: Float
    angle_sigma_rad: Float
    angle_flags: NDArray[np.uint8]
    scalar: Float


class Running(NamedTuple):
    """What is carried on: the account, (3,), and each angle's last value within half a turn and its whole turns."""

    account: Float
    last_angle_rad: Float
    turns: NDArray[np.int64]


_ROW, _TABLE, _CUBE, _BYTES = (
    types.float64[::1],
    types.float64[:, ::1],
    types.float64[:, :, ::1],
    types.uint8[:, ::1],
)
_RUNNING = bundle(Running, _ROW, _ROW, types.int64[::1])
_WRITTEN = bundle(Written, _CUBE, _CUBE, _CUBE, _BYTES, _TABLE, _TABLE, _BYTES, _TABLE)


@step()
def _shown_as(stated: int) -> int:
    """Return the flags of an orientation that say what the filter's do."""
    bits = 0
    for a in range(len(_SAID)):
        if stated & _SAID[a]:
            bits |= _SHOWN_AS[a]
    return bits


@step()
def _write_source(k: int, q: Float, source_flags: int, height_m: float, out: Written) -> None:
    """Write the segment that carries the source; its heading is that of the room, so that it cannot be wrong."""
    for a in range(4):
        out.q[k, 0, a] = q[a]
    out.point_m[k, 0, 0], out.point_m[k, 0, 1], out.point_m[k, 0, 2] = 0.0, 0.0, height_m
    out.sigma_rad[k, 0, :] = math.nan
    out.flags[k, 0] = source_flags & _NOT_HEADING


@step()
def _write_sensor(k: int, i: int, q: Float, one: Float, stated: int, running: Running, out: Written) -> None:
    """Write what one row of a filter's output says of sensor i; unknown angles neither turn nor are remembered."""
    w, x, y, z = q[0], q[1], q[2], q[3]
    known = stated & _INVALID == 0
    turned = multiply(w, x, y, z, one[_Q], one[_Q + 1], one[_Q + 2], one[_Q + 3])
    away = rotate(w, x, y, z, one[_P], one[_P + 1], one[_P + 2])
    for a in range(4):
        out.q[k, i + 1, a] = turned[a]
    for a in range(3):
        out.point_m[k, i + 1, a] = out.point_m[k, 0, a] + away[a] if known else math.nan
    bits = _shown_as(stated)
    out.flags[k, i + 1] = bits
    first = SENSOR_COLUMNS * i
    columns = slice(3 * i, 3 * i + 3)
    write_pose(
        one,
        stated,
        known,
        out.q[k, i + 1],
        out.scalar[k, first : first + SENSOR_COLUMNS],
        out.angle_rad[k, columns],
        out.angle_sigma_rad[k, columns],
        out.sigma_rad[k, i + 1],
    )
    if abs(math.cos(out.angle_rad[k, 3 * i + 1])) < _SINGULAR_COSINE:
        bits |= _SINGULAR
    for c in range(3 * i, 3 * i + 3):
        out.angle_flags[k, c] = bits
        angle = out.angle_rad[k, c]
        if math.isfinite(angle):
            running.turns[c] -= int(np.rint((angle - running.last_angle_rad[c]) / _TWO_PI))
            running.last_angle_rad[c] = angle
            out.angle_rad[k, c] = angle + _TWO_PI * running.turns[c]


@kernel(
    VOID(
        _TABLE,
        types.uint8[::1],
        _CUBE,
        _CUBE,
        types.boolean[::1],
        types.float64,
        types.float64,
        _RUNNING,
        _WRITTEN,
    )
)
def write_frames(
    q_source: Float,
    source_flags: NDArray[np.uint8],
    samples: Float,
    outs: Float,
    wrong: NDArray[np.bool_],
    height_m: float,
    step_s: float,
    running: Running,
    out: Written,
) -> None:
    """Fill the arrays of frames from outputs of the filters, (N, K, 54), and the pose of the source, (K, 4).

    Angles go on beyond half a turn.
    """
    sensors = outs.shape[0]
    last = sensors * SENSOR_COLUMNS
    account = running.account
    for k in range(q_source.shape[0]):
        _write_source(k, q_source[k], source_flags[k], height_m, out)
        asked = out.scalar[k, last + _ASK : last + _ASK + 3]
        asked[:] = 0.0
        for i in range(sensors):
            one = outs[i, k]
            stated = int(one[_FLAGS]) | (_FAULT if wrong[k] else 0)
            _write_sensor(k, i, q_source[k], one, stated, running, out)
            # A start needs longer pulses than tracking: who asks for the longest goes first.
            if one[_FIRE_TICKS] > asked[2]:
                asked[0], asked[1], asked[2] = one[_FIRE], one[_FIRE_CURRENT], one[_FIRE_TICKS]
        coil, current = samples[0, k, _COIL], samples[0, k, _CURRENT]
        account[ON_TICKS] += 1.0 if coil > 0.0 else 0.0
        account[CHARGE] += abs(current) * step_s
        account[SQUARED] += current * current * step_s
        row = out.scalar[k, last:]
        row[_COIL_ON], row[_CURRENT_ON] = coil, current
        row[_ON_TIME] = account[ON_TICKS] * step_s
        row[_ON_TIME + 1], row[_ON_TIME + 2] = account[CHARGE], account[SQUARED]
