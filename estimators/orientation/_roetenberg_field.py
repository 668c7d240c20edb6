"""The magnetic side of Roetenberg's filter, sensor by sensor: reference, heading and flags, compiled."""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import kernel, multiply, rotate
from estimators.orientation import _roetenberg_layout as at
from estimators.orientation import _strapdown_steps as steps
from estimators.orientation._contract import OrientationFlag
from estimators.recording import Float

# Numba freezes globals, not attributes of modules.
_SUM_FIELD, _FIELD_COLLECTED = steps.SUM_FIELD, steps.FIELD_COLLECTED
_HEADING_KNOWN, _START_SAMPLES, _ACCELERATION = steps.HEADING_KNOWN, steps.START_SAMPLES, steps.ACCELERATION
_ATTITUDE_SIGMA = steps.ATTITUDE_SIGMA
_REFERENCE_NORM, _REFERENCE_DIP, _REFERENCE_FIELD = at.REFERENCE_NORM, at.REFERENCE_DIP, at.REFERENCE_FIELD
_HEADING_SUM, _DISTURBANCE, _FLOOR_VARIANCE = at.HEADING_SUM, at.DISTURBANCE, at.FLOOR_VARIANCE
_NOMINAL, _MISMATCH, _FACING = at.NOMINAL, at.MISMATCH, at.FACING
_GUARD_NORM, _GUARD_DIP = at.GUARD_NORM, at.GUARD_DIP
_HEADING_LOST, _TRUST_TICKS = at.HEADING_LOST, at.TRUST_TICKS
_COUNTERS = at.COUNTERS
_NO_HEADING = int(OrientationFlag.HEADING_NOT_TRUSTED)
_DISTURBED = int(OrientationFlag.MAGNETIC_DISTURBANCE)
_LEAST_HORIZONTAL = 0.1
"""Horizontal share of the field below which it tells no heading (the poles, page 2.2)."""


@kernel("void(int64, float64[:, ::1], float64[:, :, ::1], float64[::1])")
def forget_disturbance(s: int, memory: Float, covariance: Float, settings: Float) -> None:
    """No disturbance, known to the floor (page 2.5)."""
    for i in range(3):
        memory[s, _DISTURBANCE + i] = 0.0
        for j in range(9):
            covariance[s, 6 + i, j] = covariance[s, j, 6 + i] = 0.0
        covariance[s, 6 + i, 6 + i] = settings[_FLOOR_VARIANCE]


@kernel("boolean(int64, float64[:, ::1], float64, float64, float64)")
def take_reference(s: int, memory: Float, east: float, north: float, up: float) -> bool:
    """Take a field in the earth frame for the reference; false where it tells no heading."""
    horizontal = math.hypot(east, north)
    norm = math.hypot(horizontal, up)
    if not horizontal > _LEAST_HORIZONTAL * norm:
        return False
    memory[s, _REFERENCE_NORM] = norm
    memory[s, _REFERENCE_DIP] = math.atan2(-up, horizontal)
    memory[s, _REFERENCE_FIELD] = 0.0
    memory[s, _REFERENCE_FIELD + 1] = horizontal / norm
    memory[s, _REFERENCE_FIELD + 2] = up / norm
    return True


@kernel("boolean(int64, float64[:, ::1], float64[::1], float64, float64, float64)")
def is_reference(s: int, memory: Float, settings: Float, east: float, north: float, up: float) -> bool:
    """Say whether norm and dip are those of the reference, within the guard (page 2.2, step 6)."""
    horizontal = math.hypot(east, north)
    norm = math.hypot(horizontal, up) / memory[s, _REFERENCE_NORM]
    dip = math.atan2(-up, horizontal)
    return bool(
        abs(norm - 1.0) <= settings[_GUARD_NORM]
        and abs(dip - memory[s, _REFERENCE_DIP]) <= settings[_GUARD_DIP]
    )


@kernel("void(int64, float64[:, ::1], float64, float64)")
def face(s: int, q: Float, east: float, north: float) -> None:
    """Turn the estimate about the vertical so that this field in the earth frame points north."""
    half = 0.5 * math.atan2(east, north)
    q[s, 0], q[s, 1], q[s, 2], q[s, 3] = multiply(
        math.cos(half), 0.0, 0.0, math.sin(half), q[s, 0], q[s, 1], q[s, 2], q[s, 3]
    )


@kernel(
    "void(int64, float64[:, ::1], float64[:, :, ::1], float64[:, ::1], int64[:, ::1], float64[::1], boolean)"
)
def begin_heading(
    s: int,
    q: Float,
    covariance: Float,
    memory: Float,
    counters: NDArray[np.int64],
    settings: Float,
    use_field: bool,
) -> None:
    """Take the heading at a start from the mean field, if there is one and it is that of the reference."""
    forget_disturbance(s, memory, covariance, settings)
    for i in range(_NOMINAL, _COUNTERS):
        counters[s, i] = 0
    for axis in range(3):
        memory[s, _HEADING_SUM + axis] = 0.0
    count = counters[s, _FIELD_COLLECTED]
    was_known = memory[s, _REFERENCE_NORM] > 0.0
    counters[s, _HEADING_KNOWN] = 0
    if count == 0 or not use_field:
        return
    east, north, up = rotate(
        q[s, 0],
        q[s, 1],
        q[s, 2],
        q[s, 3],
        memory[s, _SUM_FIELD] / count,
        memory[s, _SUM_FIELD + 1] / count,
        memory[s, _SUM_FIELD + 2] / count,
    )
    if was_known:
        sound = is_reference(s, memory, settings, east, north, up)
    else:
        sound = take_reference(s, memory, east, north, up)
    if sound:
        face(s, q, east, north)
        covariance[s, 2, 2] = covariance[s, 1, 1]
        counters[s, _HEADING_KNOWN] = 1


@kernel(
    "void(int64, float64[:, ::1], float64[:, :, ::1], float64[:, ::1], int64[:, ::1], float64[::1],"
    "float64, float64, float64)"
)
def look_for_heading(
    s: int,
    q: Float,
    covariance: Float,
    memory: Float,
    counters: NDArray[np.int64],
    settings: Float,
    east: float,
    north: float,
    up: float,
) -> None:
    """While the heading is unknown, wait for as many samples of a sound field as at a start.

    Takes the field of a sample in the earth frame, tesla. With the heading its cross covariances are forgotten.
    """
    if memory[s, _REFERENCE_NORM] > 0.0 and not is_reference(s, memory, settings, east, north, up):
        counters[s, _FACING] = 0
        for axis in range(3):
            memory[s, _HEADING_SUM + axis] = 0.0
        return
    counters[s, _FACING] += 1
    memory[s, _HEADING_SUM] += east
    memory[s, _HEADING_SUM + 1] += north
    memory[s, _HEADING_SUM + 2] += up
    if counters[s, _FACING] < settings[_START_SAMPLES]:
        return
    count = counters[s, _FACING]
    counters[s, _FACING] = 0
    mean_east, mean_north = memory[s, _HEADING_SUM] / count, memory[s, _HEADING_SUM + 1] / count
    mean_up = memory[s, _HEADING_SUM + 2] / count
    for axis in range(3):
        memory[s, _HEADING_SUM + axis] = 0.0
    if memory[s, _REFERENCE_NORM] == 0.0 and not take_reference(s, memory, mean_east, mean_north, mean_up):
        return
    face(s, q, mean_east, mean_north)
    p = covariance[s]
    level = max(p[0, 0], p[1, 1])
    for i in range(3):
        for j in range(9):
            p[i, j] = p[j, i] = 0.0
        p[i, i] = level
        memory[s, _ACCELERATION + i] = 0.0
    p[2, 2] += settings[_ATTITUDE_SIGMA] ** 2
    forget_disturbance(s, memory, covariance, settings)
    counters[s, _HEADING_KNOWN] = 1


@kernel("int64(int64, float64, int64[:, ::1], float64[::1])", inlined=True)
def field_flags(s: int, heading_variance: float, counters: NDArray[np.int64], settings: Float) -> int:
    """Return what the field and the heading's variance say."""
    flag = 0
    if counters[s, _MISMATCH] > 0:
        flag |= _DISTURBED
    if (
        counters[s, _HEADING_KNOWN] == 0
        or counters[s, _MISMATCH] > settings[_TRUST_TICKS]
        or heading_variance > settings[_HEADING_LOST]
    ):
        flag |= _NO_HEADING
    return flag


__all__ = ["begin_heading", "field_flags", "forget_disturbance", "look_for_heading"]
