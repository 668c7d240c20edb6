"""Whether force contradicts the tilt of our own filter, and how it then starts over."""

import math

from estimators._kernels import exponential, multiply, normalized, rotate
from estimators.kernels import Record, borrowing
from estimators.orientation.telemotion._records import BIAS, STATES, TURN
from estimators.orientation.telemotion._samples import to_vertical
from estimators.orientation.telemotion._start import forget_field, forget_motion, lean
from estimators.recording import Float

_SURE = 9.0
"""Three sigma, squared: what a tilt must be off to contradict what is stated of it."""
_SPEED_CHANGE = 4.0
"""Squared m/s by which people change speed within the window, per axis."""
_SWING_S = 0.3
"""Time for which the force of a swing goes one way: what it changes of the speed."""
_UNEVEN = 0.25
"""Share of the angle, squared and taken for uncertain: the window may hold time from before the tilt was lost."""
_LEAST_FORCE = 0.5
"""Share of gravity below which the mean force of the window has no direction: the sensor falls."""
_LOST_HEADING = 1.0
_BIAS_SPOILT = math.radians(1.0) ** 2
"""What a wrong tilt may have made of the bias; one that is known to be larger than usual is not forgotten."""


@borrowing()
def contradiction(p: Float, memory: Record, error: Float, settings: Record, time_s: float) -> float:
    """Add the block's force to the window; once that is full, return by which angle it contradicts the tilt, or zero.

    The filter's correction `error` turns the window as it turns the attitude, so that the window tells of the tilt
    as it is now. What the bias may have turned since its middle contradicts nothing: it is still to be found.
    """
    memory.up_s += time_s
    tw, tx, ty, tz = exponential(error[TURN], error[TURN + 1], error[TURN + 2])
    x, y, z = rotate(
        tw,
        tx,
        ty,
        tz,
        memory.up_sum[0] + memory.sum_force[0],
        memory.up_sum[1] + memory.sum_force[1],
        memory.up_sum[2] + memory.sum_force[2],
    )
    memory.up_sum[0], memory.up_sum[1], memory.up_sum[2] = x, y, z
    for a in range(3):
        memory.up_square += memory.sum_force[a] ** 2 / time_s
    window_s = memory.up_s
    if window_s < settings.up_window_s - 0.5 * time_s:
        return 0.0
    whole = memory.gravity * window_s
    off = 0.0
    if x * x + y * y + z * z > (_LEAST_FORCE * whole) ** 2:
        off = math.atan2(math.hypot(x, y), z)
    spread = memory.up_square / window_s - (x * x + y * y + z * z) / (window_s * window_s)
    known = (_SPEED_CHANGE + _SWING_S * _SWING_S * max(spread, 0.0)) / (whole * whole)
    for a in range(3):
        known += p[(STATES + 1) * (BIAS + a)] * 0.25 * window_s * window_s
        if a < 2:
            known += p[(STATES + 1) * (TURN + a)]
    if off > settings.up_limit and off * off > _SURE * known:
        return off
    memory.up_s = memory.up_square = 0.0
    for a in range(3):
        memory.up_sum[a] = 0.0
    return 0.0


@borrowing()
def start_over(p: Float, memory: Record, settings: Record, off: float) -> None:
    """Level the attitude on the window, which contradicts it by the angle `off`, and forget what followed from it.

    The bias stays, for it may be large and well known, but it may also be what the wrong tilt made of it: it is as
    uncertain as at the start. The field is met again.
    """
    whole = memory.gravity * memory.up_s
    tw, tx, ty, tz = to_vertical(memory.up_sum[0], memory.up_sum[1], memory.up_sum[2])
    w, x, y, z = multiply(tw, tx, ty, tz, memory.q[0], memory.q[1], memory.q[2], memory.q[3])
    memory.q[0], memory.q[1], memory.q[2], memory.q[3] = normalized(w, x, y, z)
    tilt = settings.tilt_restart + _SPEED_CHANGE / (whole * whole) + _UNEVEN * off * off
    sees = memory.field_known > 0 and 2 * memory.field_count >= memory.count
    forget_motion(p, tilt, 0.0 if sees else _LOST_HEADING, settings.speed_start)
    lean(p, memory)
    forget_field(memory, p, settings)
    for a in range(3):
        known = p[(STATES + 1) * (BIAS + a)]
        p[(STATES + 1) * (BIAS + a)] = max(known, min(settings.bias_start, _BIAS_SPOILT))
        memory.velocity[a] = memory.position[a] = memory.offset[a] = memory.up_sum[a] = 0.0
    memory.up_s = memory.up_square = memory.support_s = memory.other_s = 0.0
    memory.start_moving = 1.0
    memory.field_known = memory.since_start = 0
