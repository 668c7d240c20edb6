"""How our own filter starts, and starts again after a long gap."""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import kernel, multiply, normalized, wrapped
from estimators.orientation.telemotion._layout import (
    BIAS,
    COAST_TICKS,
    COLLECTING,
    CONVERGENCE_TICKS,
    CORRECTION,
    COUNT,
    DELAY,
    DISTURBANCE,
    FALLING_TICKS,
    FIELD,
    FIELD_COUNT,
    FIELD_KNOWN,
    FIELD_START,
    FILTERED,
    FORCE,
    GAP,
    GAP_SPEED_VARIANCE,
    GAP_TURN_VARIANCE,
    GRAVITY,
    HEADING_RESTART,
    HEADING_VARIANCE,
    IRON,
    IRON_KNOWN,
    IRON_KNOWN_VARIANCE,
    IRON_WIDE,
    MOVING_TICKS,
    OFFSET,
    OTHER_S,
    PENDING,
    PHASE,
    POSITION,
    REST_FORCE,
    RUNNING,
    SINCE_START,
    SPEED_START,
    START,
    START_FORCE2,
    START_LEVER,
    START_MOVING,
    START_SHARE,
    START_SPEED,
    START_SPEED2,
    START_TICKS,
    START_WIDE,
    STATES,
    STEP_S,
    SUM_FIELD,
    SUM_FORCE,
    SUM_RATE2,
    SUPPORT_S,
    TILT_RESTART,
    TILT_START,
    TILT_VARIANCE,
    TURN,
    VELOCITY,
)
from estimators.orientation.telemotion._samples import begin_rest, clear_sums, integrate, level, watch_rest
from estimators.recording import Float

_PLACE_VARIANCE = 0.01
_TURNING_TILT = 0.1
"""Tilt error of a start in motion, rad per rad/s of mean rate, up to one rad/s."""
_LOST_RATE = 1.0
"""Rate error, rad/s, of a heading held through a gap too long to fill."""
SAME_FIELD = 0.15
"""Share of its norm by which a field differs from itself, as it is seen in movement."""
_STILL_RATE = 0.2
"""Slower turns, rad/s, do not tilt what 0.05 s show of the vertical."""
_SURE = 9.0
_SCALE_ERROR = 0.01
"""Error of a gyroscope's scale that is taken for possible in the first second."""
_LARGEST_TILT = 1.0
_LEAST_LEVEL = 9.0
"""Squared microtesla: a field that points straight down tells no heading."""
_DIP = 4.0
"""Square by which an error of tilt turns a heading by the field, where the field is not yet known."""
_LINEAR_HEADING = math.radians(20.0) ** 2
_LINEAR_TILT = math.radians(20.0) ** 2
_SHOWN_TILT = math.radians(5.0)
_SHOWN_HEADING = math.radians(15.0)


@kernel("boolean(float64[::1])")
def upright(p: Float) -> bool:
    """Say whether the tilt is known well enough for what the field then says of heading to be nearly linear."""
    return bool(p[0] + p[STATES + 1] < _LINEAR_TILT)


@kernel("boolean(float64[::1], int64[::1], float64[::1])")
def young(memory: Float, counts: NDArray[np.int64], settings: Float) -> bool:
    """Say whether a start in movement is not yet over."""
    return bool(memory[START_MOVING] > 0.0 and counts[SINCE_START] < settings[CONVERGENCE_TICKS])


@kernel("void(float64[::1], int64[::1], float64[::1])")
def begin(memory: Float, counts: NDArray[np.int64], sample: Float) -> None:
    """Start to collect; what was shown before the gap is taken up without a way back."""
    clear_sums(memory, counts)
    if counts[PHASE] == 0:
        begin_rest(memory, sample)
    counts[PHASE] = COLLECTING
    counts[SINCE_START] = counts[PENDING] = 0
    for i in range(START_MOVING, OTHER_S + 1):
        memory[i] = 0.0
    for a in range(3):
        memory[OFFSET + a] = 0.0
        memory[VELOCITY + a] = memory[POSITION + a] = 0.0
    memory[TILT_VARIANCE] = memory[TILT_VARIANCE + 1] = _SHOWN_TILT**2
    memory[HEADING_VARIANCE] = _SHOWN_HEADING**2


@kernel("void(float64[::1])")
def face_north(memory: Float) -> None:
    """Set the correction of the start frame to the field summed up so far."""
    half = 0.5 * math.atan2(memory[SUM_FIELD], memory[SUM_FIELD + 1])
    memory[CORRECTION], memory[CORRECTION + 3] = math.cos(half), math.sin(half)
    memory[CORRECTION + 1] = memory[CORRECTION + 2] = 0.0


@kernel("void(float64[::1], int64[::1], float64[::1], float64[::1])")
def meet_field(memory: Float, counts: NDArray[np.int64], p: Float, settings: Float) -> None:
    """Take the block's mean field as the first there is; its uncertainty is the prior's."""
    for a in range(3):
        memory[FIELD + a] = memory[SUM_FIELD + a] / counts[FIELD_COUNT]
        p[(STATES + 1) * (FIELD + a)] = settings[FIELD_START]
    memory[START_SHARE] = 1.0 - memory[START_MOVING]  # there is no place of a first rest
    counts[FIELD_KNOWN] = 1
    face_north(memory)


@kernel("void(float64[::1], float64[::1], float64[::1])")
def forget_field(memory: Float, p: Float, settings: Float) -> None:
    """Give hard iron and the field at the start their priors again; FIELD is met anew."""
    for i in range(FIELD, STATES):
        if i == DELAY:
            continue
        for j in range(STATES):
            p[STATES * i + j] = p[STATES * j + i] = 0.0
        prior = settings[START_WIDE]
        if i < DELAY:
            prior = settings[IRON_WIDE] + memory[IRON_KNOWN_VARIANCE]
        p[(STATES + 1) * i] = prior
    for a in range(3):
        memory[IRON + a] = memory[IRON_KNOWN + a]
        memory[START + a] = 0.0
    memory[DISTURBANCE] = 0.0


@kernel("float64(float64[::1], int64[::1])")
def _turn_from_known(memory: Float, counts: NDArray[np.int64]) -> float:
    """Return by which angle the field of the sums is turned about the vertical from the known; NaN if it is another."""
    if counts[FIELD_KNOWN] == 0 or 2 * counts[FIELD_COUNT] < counts[COUNT]:
        return math.nan
    x = memory[SUM_FIELD] / counts[FIELD_COUNT]
    y = memory[SUM_FIELD + 1] / counts[FIELD_COUNT]
    z = memory[SUM_FIELD + 2] / counts[FIELD_COUNT]
    bx, by, bz = memory[FIELD], memory[FIELD + 1], memory[FIELD + 2]
    known = math.sqrt(bx * bx + by * by + bz * bz)
    across = math.hypot(x, y) - math.hypot(bx, by)
    if math.hypot(across, z - bz) > SAME_FIELD * known:
        return math.nan
    return float(wrapped(math.atan2(y, x) - math.atan2(by, bx)))


@kernel("void(float64[::1], float64[::1], float64)")
def _tie_heading(p: Float, memory: Float, variance: float) -> None:
    """Make the heading as uncertain as by a known field of this variance, seen at the tilt as it is.

    Across the field nothing was left over: h turn_z = b_z (b_x turn_x + b_y turn_y) / h, h being its horizontal part.
    """
    bx, by, bz = memory[FIELD], memory[FIELD + 1], memory[FIELD + 2]
    level = max(bx * bx + by * by, _LEAST_LEVEL)
    by_x, by_y = bz * bx / level, bz * by / level
    z = TURN + 2
    for j in range(STATES):
        p[STATES * z + j] = by_x * p[STATES * TURN + j] + by_y * p[STATES * (TURN + 1) + j]
    p[STATES * z + z] = 0.0
    for j in range(STATES):
        p[STATES * j + z] = p[STATES * z + j]
    p[STATES * z + z] = variance + by_x * p[STATES * z + TURN] + by_y * p[STATES * z + TURN + 1]


@kernel("boolean(float64[::1])")
def lost(p: Float) -> bool:
    """Say whether the heading is too uncertain for what the field says of it to be linear."""
    return bool(p[(STATES + 1) * (TURN + 2)] > _LINEAR_HEADING)


@kernel("boolean(float64[::1], float64[::1], int64[::1], float64[::1], boolean)")
def find_heading(p: Float, memory: Float, counts: NDArray[np.int64], settings: Float, rest: bool) -> bool:
    """Find a lost heading by the block's field, once this is the known one; say whether it is found.

    Attitude stays and the known field is turned to the one seen, for the heading of the start frame is anybody's.
    A sensor that moves and does not meet the known field any more meets another as its first.
    """
    turned = _turn_from_known(memory, counts)
    if math.isnan(turned):
        if rest or counts[SINCE_START] < settings[CONVERGENCE_TICKS]:
            return False
        for i in (TURN + 2, FIELD, FIELD + 1, FIELD + 2):
            for j in range(STATES):
                p[STATES * i + j] = p[STATES * j + i] = 0.0
        meet_field(memory, counts, p, settings)
        memory[START_SHARE] = memory[DISTURBANCE] = memory[SUPPORT_S] = memory[OTHER_S] = 0.0
        return True
    cosine, sine = math.cos(turned), math.sin(turned)
    for i in (FIELD, START):
        x, y = memory[i], memory[i + 1]
        memory[i], memory[i + 1] = cosine * x - sine * y, sine * x + cosine * y
    _tie_heading(p, memory, settings[HEADING_RESTART])
    return True


@kernel("boolean(float64[::1], float64[::1], int64[::1], float64[::1])")
def _moves(p: Float, memory: Float, counts: NDArray[np.int64], settings: Float) -> bool:
    """Say whether the first samples are those of a moving sensor.

    It turns faster than the bias can be, or the force is not gravity's, or changes: where a hand is shaken, force
    may have gravity's size for a moment and any direction.
    """
    count = float(counts[COUNT])
    turning, known = memory[SUM_RATE2] / count, _STILL_RATE**2
    squares = 0.0
    for a in range(3):
        known += _SURE * p[(STATES + 1) * (BIAS + a)]
        squares += memory[SUM_FORCE + a] ** 2
    force = math.sqrt(squares) / (count * settings[STEP_S])
    spread = memory[START_FORCE2] / count - force * force
    push = force - memory[GRAVITY]
    return bool(turning > known or max(push * push, spread) > settings[REST_FORCE])


@kernel("UniTuple(float64, 2)(float64[::1], float64[::1], int64[::1], float64[::1])")
def _start_variances(
    p: Float, memory: Float, counts: NDArray[np.int64], settings: Float
) -> tuple[float, float]:
    """Return the variances of tilt and of speed of a start in movement.

    Force summed up is gravity's part and the speed gained. How much speed changes is seen in how the sum bends
    about its chord; what is slower is not, and stays a prior's, unless the force is as steady as gravity. The
    gyroscope adds what its bias, its scale and its limit make of the turn since the middle.
    """
    count = float(counts[COUNT])
    time_s = count * settings[STEP_S]
    whole = chord = bend2 = 0.0
    for a in range(3):
        total = memory[SUM_FORCE + a]
        whole += total * total
        chord += total * memory[START_LEVER + a]
        bend2 += (memory[START_SPEED + a] / count - 0.5 * total * (count + 1.0) / count) ** 2
    lever = (count + 1.0) * (2.0 * count + 1.0) / (6.0 * count * count)
    bent = memory[START_SPEED2] / count - 2.0 * chord / (count * count) + whole * lever - bend2
    push = math.sqrt(whole) / time_s - memory[GRAVITY]
    spread = memory[START_FORCE2] / count - whole / (time_s * time_s)
    calm = _SURE * (push * push + max(spread, 0.0) + settings[REST_FORCE])
    speed = min(settings[SPEED_START], time_s * time_s * calm) + 2.0 / 3.0 * max(bent, 0.0)
    unseen, turned, bias = 0.0, 0.0, 0.0
    for a in range(3):
        turned += memory[GAP_TURN_VARIANCE + a] / 3.0
        unseen += memory[GAP_SPEED_VARIANCE + a] / 3.0
        bias += p[(STATES + 1) * (BIAS + a)] / 3.0
    push /= memory[GRAVITY]
    gyroscope = bias + _SCALE_ERROR**2 * memory[SUM_RATE2] / count
    tilt = push * push + (speed + unseen) / max(whole, 1e-9) + turned + 0.25 * time_s * time_s * gyroscope
    return min(tilt, _LARGEST_TILT), speed


@kernel(
    "boolean(float64[::1], float64[::1], float64[::1], float64[::1], int64[::1], float64[::1], float64[::1])"
)
def collect(
    q: Float,
    bias: Float,
    p: Float,
    memory: Float,
    counts: NDArray[np.int64],
    sample: Float,
    settings: Float,
) -> bool:
    """Level the attitude on the mean of the first samples; say whether the filter now runs."""
    watch_rest(memory, counts, sample, settings)
    integrate(q, bias, memory, counts, sample, settings)
    count = float(counts[COUNT])
    for a in range(3):
        speed = memory[SUM_FORCE + a]
        memory[START_FORCE2] += sample[FORCE + a] ** 2
        memory[START_SPEED + a] += speed
        memory[START_LEVER + a] += count * speed
        memory[START_SPEED2] += speed * speed
    level(q, memory, counts)
    if counts[FIELD_KNOWN] == 0 and counts[FIELD_COUNT] > 0:
        face_north(memory)
    moving = memory[START_MOVING] > 0.0
    if moving or count <= settings[START_TICKS]:
        moving = _moves(p, memory, counts, settings) or (moving and count > settings[START_TICKS])
        memory[START_MOVING] = 1.0 if moving else 0.0
    speed_variance = settings[SPEED_START]
    time_s = count * settings[STEP_S]
    if moving:
        tilt, speed_variance = _start_variances(p, memory, counts, settings)
        memory[TILT_VARIANCE] = memory[TILT_VARIANCE + 1] = tilt
        memory[HEADING_VARIANCE] = min(_SHOWN_HEADING**2 + tilt * _DIP, _LARGEST_TILT)
        falls = memory[SUM_FORCE + 2] < 0.5 * memory[GRAVITY] * time_s
        if count < settings[FALLING_TICKS if falls else MOVING_TICKS]:
            return False
        counts[SINCE_START] = 0
    else:
        memory[TILT_VARIANCE] = memory[TILT_VARIANCE + 1] = _SHOWN_TILT**2
        memory[HEADING_VARIANCE] = _SHOWN_HEADING**2
        if count < settings[START_TICKS]:
            return False
        push = memory[SUM_FORCE + 2] / (time_s * memory[GRAVITY]) - 1.0
        turning = min(math.sqrt(memory[SUM_RATE2] / count), 1.0)
        tilt = push * push + (_TURNING_TILT * turning) ** 2
    heading, faces = 0.0, False  # the first heading defines the frame
    if counts[FILTERED] == 0:
        tilt += settings[TILT_START]
        if 2 * counts[FIELD_COUNT] >= counts[COUNT] and 2.0 * tilt < _LINEAR_TILT:
            meet_field(memory, counts, p, settings)
    else:
        tilt += settings[TILT_RESTART]
        gap_s = (counts[GAP] + settings[COAST_TICKS]) * settings[STEP_S]
        heading = min((_LOST_RATE * gap_s) ** 2, 1.0)
        memory[START_SHARE] = 0.0
        turned = _turn_from_known(memory, counts)
        faces = heading > settings[HEADING_RESTART] and not math.isnan(turned)
        if faces:
            w, x, y, z = multiply(
                math.cos(0.5 * turned), 0.0, 0.0, -math.sin(0.5 * turned), q[0], q[1], q[2], q[3]
            )
            q[0], q[1], q[2], q[3] = normalized(w, x, y, z)
    forget_motion(p, tilt, heading, speed_variance)
    if faces:
        _tie_heading(p, memory, settings[HEADING_RESTART])
    clear_sums(memory, counts)
    counts[PHASE] = RUNNING
    counts[FILTERED] = 1
    counts[GAP] = 0
    return True


@kernel("void(float64[::1], float64, float64, float64)")
def forget_motion(p: Float, tilt: float, heading: float, speed: float) -> None:
    """Give attitude, velocity and position these variances, apart from all else."""
    for i in range(BIAS):
        for j in range(STATES):
            p[STATES * i + j] = p[STATES * j + i] = 0.0
    for a in range(3):
        p[(STATES + 1) * (TURN + a)] = tilt if a < 2 else heading
        p[(STATES + 1) * (VELOCITY + a)] = speed
        p[(STATES + 1) * (POSITION + a)] = _PLACE_VARIANCE


__all__ = [
    "SAME_FIELD",
    "begin",
    "collect",
    "find_heading",
    "forget_field",
    "forget_motion",
    "lost",
    "meet_field",
    "upright",
    "young",
]
