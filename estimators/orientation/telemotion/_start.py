"""How our own filter starts, and starts again after a long gap."""

import math

from estimators._kernels import multiply, normalized, wrapped
from estimators.kernels import Record, borrowing
from estimators.orientation.telemotion._records import (
    BIAS,
    COLLECTING,
    DELAY,
    FIELD,
    LEAST_LEVEL,
    OFFSET,
    POSITION,
    RUNNING,
    STATES,
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
_DIP = 4.0
"""Square by which an error of tilt turns a heading by the field, where the field is not yet known."""
_LINEAR_HEADING = math.radians(20.0) ** 2
_LINEAR_TILT = math.radians(20.0) ** 2
_SHOWN_TILT = math.radians(5.0)
_SHOWN_HEADING = math.radians(15.0)


@borrowing("boolean(float64[::1])")
def upright(p: Float) -> bool:
    """Say whether the tilt is known well enough for what the field then says of heading to be nearly linear."""
    return bool(p[0] + p[STATES + 1] < _LINEAR_TILT)


@borrowing()
def young(memory: Record, settings: Record) -> bool:
    """Say whether a start in movement is not yet over."""
    return bool(memory.start_moving > 0.0 and memory.since_start < settings.convergence_ticks)


@borrowing()
def begin(memory: Record, sample: Record) -> None:
    """Start to collect; what was shown before the gap is taken up without a way back."""
    clear_sums(memory)
    if memory.phase == 0:
        begin_rest(memory, sample)
    memory.phase = COLLECTING
    memory.since_start = memory.pending = 0
    memory.start_moving = memory.start_force2 = memory.start_speed2 = 0.0
    memory.up_s = memory.up_square = memory.support_s = memory.other_s = 0.0
    for a in range(3):
        memory.start_speed[a] = memory.start_lever[a] = memory.up_sum[a] = memory.other[a] = 0.0
        memory.offset[a] = memory.velocity[a] = memory.position[a] = 0.0
    memory.tilt_variance[0] = memory.tilt_variance[1] = _SHOWN_TILT**2
    memory.heading_variance = _SHOWN_HEADING**2


@borrowing()
def face_north(memory: Record) -> None:
    """Set the correction of the start frame to the field summed up so far."""
    half = 0.5 * math.atan2(memory.sum_field[0], memory.sum_field[1])
    memory.correction[0], memory.correction[3] = math.cos(half), math.sin(half)
    memory.correction[1] = memory.correction[2] = 0.0


@borrowing()
def meet_field(memory: Record, p: Float, settings: Record) -> None:
    """Take the block's mean field as the first there is; its uncertainty is the prior's."""
    for a in range(3):
        memory.field[a] = memory.sum_field[a] / memory.field_count
        p[(STATES + 1) * (FIELD + a)] = settings.field_start
    memory.start_share = 1.0 - memory.start_moving  # there is no place of a first rest
    memory.field_known = 1
    face_north(memory)


@borrowing()
def forget_field(memory: Record, p: Float, settings: Record) -> None:
    """Give hard iron and the field at the start their priors again; FIELD is met again."""
    for i in range(FIELD, OFFSET):
        if i == DELAY:
            continue
        for j in range(STATES):
            p[STATES * i + j] = p[STATES * j + i] = 0.0
        prior = settings.start_wide
        if i < DELAY:
            prior = settings.iron_wide + memory.iron_known_variance
        p[(STATES + 1) * i] = prior
    for a in range(3):
        memory.iron[a] = memory.iron_known[a]
        memory.start[a] = 0.0
    memory.disturbance = 0.0


@borrowing()
def _turn_from_known(memory: Record) -> float:
    """Return by which angle the field of the sums is turned about the vertical from the known; NaN if it is another."""
    if memory.field_known == 0 or 2 * memory.field_count < memory.count:
        return math.nan
    x = memory.sum_field[0] / memory.field_count
    y = memory.sum_field[1] / memory.field_count
    z = memory.sum_field[2] / memory.field_count
    bx, by, bz = memory.field[0], memory.field[1], memory.field[2]
    known = math.sqrt(bx * bx + by * by + bz * bz)
    across = math.hypot(x, y) - math.hypot(bx, by)
    if math.hypot(across, z - bz) > SAME_FIELD * known:
        return math.nan
    return float(wrapped(math.atan2(y, x) - math.atan2(by, bx)))


@borrowing()
def _tie_heading(p: Float, memory: Record, variance: float) -> None:
    """Make the heading as uncertain as by a known field of this variance, seen at the tilt as it is.

    Across the field nothing was left over: h turn_z = b_z (b_x turn_x + b_y turn_y) / h, h being its horizontal part.
    """
    bx, by, bz = memory.field[0], memory.field[1], memory.field[2]
    level = max(bx * bx + by * by, LEAST_LEVEL)
    by_x, by_y = bz * bx / level, bz * by / level
    z = TURN + 2
    for j in range(STATES):
        p[STATES * z + j] = by_x * p[STATES * TURN + j] + by_y * p[STATES * (TURN + 1) + j]
    p[STATES * z + z] = 0.0
    for j in range(STATES):
        p[STATES * j + z] = p[STATES * z + j]
    p[STATES * z + z] = variance + by_x * p[STATES * z + TURN] + by_y * p[STATES * z + TURN + 1]


@borrowing("boolean(float64[::1])")
def lost(p: Float) -> bool:
    """Say whether the heading is too uncertain for what the field says of it to be linear."""
    return bool(p[(STATES + 1) * (TURN + 2)] > _LINEAR_HEADING)


@borrowing()
def find_heading(p: Float, memory: Record, settings: Record, rest: bool) -> bool:
    """Find a lost heading by the block's field, once this is the known one; say whether it is found.

    Attitude stays and the known field is turned to the one seen, for the heading of the start frame is anybody's.
    A sensor that moves and does not meet the known field any more meets another as its first.
    """
    turned = _turn_from_known(memory)
    if math.isnan(turned):
        if rest or memory.since_start < settings.convergence_ticks:
            return False
        for i in (TURN + 2, FIELD, FIELD + 1, FIELD + 2):
            for j in range(STATES):
                p[STATES * i + j] = p[STATES * j + i] = 0.0
        meet_field(memory, p, settings)
        memory.start_share = memory.disturbance = memory.support_s = memory.other_s = 0.0
        return True
    cosine, sine = math.cos(turned), math.sin(turned)
    for vector in (memory.field, memory.start):
        x, y = vector[0], vector[1]
        vector[0], vector[1] = cosine * x - sine * y, sine * x + cosine * y
    _tie_heading(p, memory, settings.heading_restart)
    return True


@borrowing()
def _moves(p: Float, memory: Record, settings: Record) -> bool:
    """Say whether the first samples are those of a moving sensor.

    It turns faster than the bias can be, or the force is not gravity's, or changes: where a hand is shaken, force
    may have gravity's size for a moment and any direction.
    """
    count = float(memory.count)
    turning, known = memory.sum_rate2 / count, _STILL_RATE**2
    squares = 0.0
    for a in range(3):
        known += _SURE * p[(STATES + 1) * (BIAS + a)]
        squares += memory.sum_force[a] ** 2
    force = math.sqrt(squares) / (count * settings.step_s)
    spread = memory.start_force2 / count - force * force
    push = force - memory.gravity
    return bool(turning > known or max(push * push, spread) > settings.rest_force)


@borrowing()
def _start_variances(p: Float, memory: Record, settings: Record) -> tuple[float, float]:
    """Return the variances of tilt and of speed of a start in movement.

    Force summed up is gravity's part and the speed gained. How much speed changes is seen in how the sum bends
    about its chord; what is slower is not, and stays a prior's, unless the force is as steady as gravity. The
    gyroscope adds what its bias, its scale and its limit make of the turn since the middle.
    """
    count = float(memory.count)
    time_s = count * settings.step_s
    whole = chord = bend2 = 0.0
    for a in range(3):
        total = memory.sum_force[a]
        whole += total * total
        chord += total * memory.start_lever[a]
        bend2 += (memory.start_speed[a] / count - 0.5 * total * (count + 1.0) / count) ** 2
    lever = (count + 1.0) * (2.0 * count + 1.0) / (6.0 * count * count)
    bent = memory.start_speed2 / count - 2.0 * chord / (count * count) + whole * lever - bend2
    push = math.sqrt(whole) / time_s - memory.gravity
    spread = memory.start_force2 / count - whole / (time_s * time_s)
    calm = _SURE * (push * push + max(spread, 0.0) + settings.rest_force)
    speed = min(settings.speed_start, time_s * time_s * calm) + 2.0 / 3.0 * max(bent, 0.0)
    unseen, turned, bias = 0.0, 0.0, 0.0
    for a in range(3):
        turned += memory.gap_turn_variance[a] / 3.0
        unseen += memory.gap_speed_variance[a] / 3.0
        bias += p[(STATES + 1) * (BIAS + a)] / 3.0
    push /= memory.gravity
    gyroscope = bias + _SCALE_ERROR**2 * memory.sum_rate2 / count
    tilt = push * push + (speed + unseen) / max(whole, 1e-9) + turned + 0.25 * time_s * time_s * gyroscope
    return min(tilt, _LARGEST_TILT), speed


@borrowing()
def collect(
    p: Float,
    memory: Record,
    sample: Record,
    settings: Record,
) -> bool:
    """Level the attitude on the mean of the first samples; say whether the filter now runs."""
    watch_rest(memory, sample, settings)
    integrate(memory, memory, sample, settings)
    count = float(memory.count)
    for a in range(3):
        speed = memory.sum_force[a]
        memory.start_force2 += (sample.force[a] - memory.force_offset[a]) ** 2
        memory.start_speed[a] += speed
        memory.start_lever[a] += count * speed
        memory.start_speed2 += speed * speed
    level(memory)
    if memory.field_known == 0 and memory.field_count > 0:
        face_north(memory)
    moving = memory.start_moving > 0.0
    if moving or count <= settings.start_ticks:
        moving = _moves(p, memory, settings) or (moving and count > settings.start_ticks)
        memory.start_moving = 1.0 if moving else 0.0
    speed_variance = settings.speed_start
    time_s = count * settings.step_s
    if moving:
        tilt, speed_variance = _start_variances(p, memory, settings)
        memory.tilt_variance[0] = memory.tilt_variance[1] = tilt
        memory.heading_variance = min(_SHOWN_HEADING**2 + tilt * _DIP, _LARGEST_TILT)
        falls = memory.sum_force[2] < 0.5 * memory.gravity * time_s
        if count < (settings.falling_ticks if falls else settings.moving_ticks):
            return False
        memory.since_start = 0
    else:
        memory.tilt_variance[0] = memory.tilt_variance[1] = _SHOWN_TILT**2
        memory.heading_variance = _SHOWN_HEADING**2
        if count < settings.start_ticks:
            return False
        push = memory.sum_force[2] / (time_s * memory.gravity) - 1.0
        turning = min(math.sqrt(memory.sum_rate2 / count), 1.0)
        tilt = push * push + (_TURNING_TILT * turning) ** 2
    heading, faces = 0.0, False  # the first heading defines the frame
    if memory.filtered == 0:
        tilt += settings.tilt_start
        if 2 * memory.field_count >= memory.count and 2.0 * tilt < _LINEAR_TILT:
            meet_field(memory, p, settings)
    else:
        tilt += settings.tilt_restart
        gap_s = (memory.gap + settings.coast_ticks) * settings.step_s
        heading = min((_LOST_RATE * gap_s) ** 2, 1.0)
        memory.start_share = 0.0
        turned = _turn_from_known(memory)
        faces = heading > settings.heading_restart and not math.isnan(turned)
        if faces:
            w, x, y, z = multiply(
                math.cos(0.5 * turned),
                0.0,
                0.0,
                -math.sin(0.5 * turned),
                memory.q[0],
                memory.q[1],
                memory.q[2],
                memory.q[3],
            )
            memory.q[0], memory.q[1], memory.q[2], memory.q[3] = normalized(w, x, y, z)
    forget_motion(p, tilt, heading, speed_variance)
    if faces:
        _tie_heading(p, memory, settings.heading_restart)
    lean(p, memory)  # after the heading: the known field was seen leaning by the same offset
    clear_sums(memory)
    memory.phase = RUNNING
    memory.filtered = 1
    memory.gap = 0
    return True


@borrowing("void(float64[::1], float64, float64, float64)")
def forget_motion(p: Float, tilt: float, heading: float, speed: float) -> None:
    """Give attitude, velocity and position these variances, apart from all else."""
    for i in range(BIAS):
        for j in range(STATES):
            p[STATES * i + j] = p[STATES * j + i] = 0.0
    for a in range(3):
        p[(STATES + 1) * (TURN + a)] = tilt if a < 2 else heading
        p[(STATES + 1) * (VELOCITY + a)] = speed
        p[(STATES + 1) * (POSITION + a)] = _PLACE_VARIANCE


@borrowing()
def lean(p: Float, memory: Record) -> None:
    """Tie the tilt to the accelerometer's offset: an attitude levelled on its force leans by what is in it.

    turn = (-(R offset)_y, (R offset)_x, 0) / gravity
    """
    w, x, y, z = memory.q[0], memory.q[1], memory.q[2], memory.q[3]
    one = 1.0 / memory.gravity
    r00, r01, r02 = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)
    r10, r11, r12 = 2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)
    by_x = (-one * r10, -one * r11, -one * r12)
    by_y = (one * r00, one * r01, one * r02)
    for c in range(3):
        row = STATES * (OFFSET + c)
        for j in range(STATES):
            p[STATES * TURN + j] += by_x[c] * p[row + j]
            p[STATES * (TURN + 1) + j] += by_y[c] * p[row + j]
    for i in range(STATES):
        row = STATES * i
        for c in range(3):
            p[row + TURN] += by_x[c] * p[row + OFFSET + c]
            p[row + TURN + 1] += by_y[c] * p[row + OFFSET + c]
