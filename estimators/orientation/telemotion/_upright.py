"""Whether force contradicts the tilt of our own filter, and how it then starts over."""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import exponential, kernel, multiply, normalized, rotate
from estimators.orientation.telemotion._layout import (
    BIAS,
    BIAS_START,
    COUNT,
    FIELD_COUNT,
    FIELD_KNOWN,
    GRAVITY,
    OFFSET,
    OTHER_S,
    POSITION,
    SINCE_START,
    SPEED_START,
    START_MOVING,
    STATES,
    SUM_FORCE,
    SUPPORT_S,
    TILT_RESTART,
    TURN,
    UP_LIMIT,
    UP_S,
    UP_SUM,
    UP_WINDOW_S,
    VELOCITY,
)
from estimators.orientation.telemotion._samples import to_vertical
from estimators.orientation.telemotion._start import forget_field, forget_motion
from estimators.recording import Float

_SURE = 9.0
"""Three sigma, squared: what a tilt must be off to contradict what is stated of it."""
_SPEED_CHANGE = 4.0
"""Squared m/s by which people change speed within the window, per axis."""
_UNEVEN = 0.25
"""Share of the angle, squared and taken for uncertain: the window may hold time from before the tilt was lost."""
_LEAST_FORCE = 0.5
"""Share of gravity below which the mean force of the window has no direction: the sensor falls."""
_LOST_HEADING = 1.0
_BIAS_SPOILT = math.radians(1.0) ** 2
"""What a wrong tilt may have made of the bias; one that is known to be larger than usual is not forgotten."""


@kernel("float64(float64[::1], float64[::1], float64[::1], float64[::1], float64)")
def contradiction(p: Float, memory: Float, error: Float, settings: Float, time_s: float) -> float:
    """Add the block's force to the window; once that is full, return by which angle it contradicts the tilt, or zero.

    The filter's correction `error` turns the window as it turns the attitude, so that the window tells of the tilt
    as it is now. What the bias may have turned since its middle contradicts nothing: it is still to be found.
    """
    memory[UP_S] += time_s
    tw, tx, ty, tz = exponential(error[TURN], error[TURN + 1], error[TURN + 2])
    x, y, z = rotate(
        tw,
        tx,
        ty,
        tz,
        memory[UP_SUM] + memory[SUM_FORCE],
        memory[UP_SUM + 1] + memory[SUM_FORCE + 1],
        memory[UP_SUM + 2] + memory[SUM_FORCE + 2],
    )
    memory[UP_SUM], memory[UP_SUM + 1], memory[UP_SUM + 2] = x, y, z
    window_s = memory[UP_S]
    if window_s < settings[UP_WINDOW_S] - 0.5 * time_s:
        return 0.0
    whole = memory[GRAVITY] * window_s
    off = 0.0
    if x * x + y * y + z * z > (_LEAST_FORCE * whole) ** 2:
        off = math.atan2(math.hypot(x, y), z)
    known = _SPEED_CHANGE / (whole * whole)
    for a in range(3):
        known += p[(STATES + 1) * (BIAS + a)] * 0.25 * window_s * window_s
        if a < 2:
            known += p[(STATES + 1) * (TURN + a)]
    if off > settings[UP_LIMIT] and off * off > _SURE * known:
        return off
    memory[UP_S] = 0.0
    for a in range(3):
        memory[UP_SUM + a] = 0.0
    return 0.0


@kernel("void(float64[::1], float64[::1], float64[::1], int64[::1], float64[::1], float64)")
def start_over(
    q: Float, p: Float, memory: Float, counts: NDArray[np.int64], settings: Float, off: float
) -> None:
    """Level the attitude on the window, which contradicts it by the angle `off`, and forget what followed from it.

    The bias stays, for it may be large and well known, but it may also be what the wrong tilt made of it: it is as
    uncertain as at the start. The field is met anew.
    """
    whole = memory[GRAVITY] * memory[UP_S]
    tw, tx, ty, tz = to_vertical(memory[UP_SUM], memory[UP_SUM + 1], memory[UP_SUM + 2])
    w, x, y, z = multiply(tw, tx, ty, tz, q[0], q[1], q[2], q[3])
    q[0], q[1], q[2], q[3] = normalized(w, x, y, z)
    tilt = settings[TILT_RESTART] + _SPEED_CHANGE / (whole * whole) + _UNEVEN * off * off
    sees = counts[FIELD_KNOWN] > 0 and 2 * counts[FIELD_COUNT] >= counts[COUNT]
    forget_motion(p, tilt, 0.0 if sees else _LOST_HEADING, settings[SPEED_START])
    forget_field(memory, p, settings)
    for a in range(3):
        known = p[(STATES + 1) * (BIAS + a)]
        p[(STATES + 1) * (BIAS + a)] = max(known, min(settings[BIAS_START], _BIAS_SPOILT))
        memory[VELOCITY + a] = memory[POSITION + a] = memory[OFFSET + a] = memory[UP_SUM + a] = 0.0
    memory[UP_S] = memory[SUPPORT_S] = memory[OTHER_S] = 0.0
    memory[START_MOVING] = 1.0
    counts[FIELD_KNOWN] = counts[SINCE_START] = 0


__all__ = ["contradiction", "start_over"]
