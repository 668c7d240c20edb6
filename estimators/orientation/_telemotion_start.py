"""How our own filter starts, and starts again after a long gap."""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import kernel, multiply, normalized, wrapped
from estimators.orientation._telemotion_layout import (
    BIAS,
    COAST_TICKS,
    COLLECTING,
    CORRECTION,
    COUNT,
    DELAY,
    DISTURBANCE,
    FIELD,
    FIELD_COUNT,
    FIELD_KNOWN,
    FIELD_START,
    FILTERED,
    GAP,
    GRAVITY,
    HEADING_RESTART,
    HEADING_VARIANCE,
    IRON,
    IRON_KNOWN,
    IRON_KNOWN_VARIANCE,
    IRON_WIDE,
    OFFSET,
    PENDING,
    PHASE,
    POSITION,
    RUNNING,
    SINCE_START,
    SPEED_START,
    START,
    START_SHARE,
    START_TICKS,
    START_WIDE,
    STATES,
    STEP_S,
    SUM_FIELD,
    SUM_FORCE,
    SUM_RATE2,
    TILT_RESTART,
    TILT_START,
    TILT_VARIANCE,
    TURN,
    VELOCITY,
)
from estimators.orientation._telemotion_samples import begin_rest, clear_sums, integrate, level, watch_rest
from estimators.recording import Float

_PLACE_VARIANCE = 0.01
_TURNING_TILT = 0.1
"""Tilt error of a start in motion, rad per rad/s of mean rate, up to one rad/s."""
_LOST_RATE = 1.0
"""Rate error, rad/s, of a heading held through a gap too long to fill."""
_SAME_FIELD = 0.15
_SHOWN_TILT = math.radians(5.0)
_SHOWN_HEADING = math.radians(15.0)


@kernel("void(float64[::1], int64[::1], float64[::1])")
def begin(memory: Float, counts: NDArray[np.int64], sample: Float) -> None:
    """Start to collect; what was shown before the gap is taken up without a way back."""
    clear_sums(memory, counts)
    if counts[PHASE] == 0:
        begin_rest(memory, sample)
    counts[PHASE] = COLLECTING
    counts[SINCE_START] = counts[PENDING] = 0
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
    memory[START_SHARE] = 1.0
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


@kernel("float64(float64[::1], float64[::1], int64[::1], float64[::1], float64)")
def _turn_to_field(
    q: Float, memory: Float, counts: NDArray[np.int64], settings: Float, gap_s: float
) -> float:
    """After a long gap, turn to the field if it is the known one; return the variance of the heading."""
    held = min((_LOST_RATE * gap_s) ** 2, 1.0)
    memory[START_SHARE] = 0.0
    if counts[FIELD_KNOWN] == 0 or 2 * counts[FIELD_COUNT] < counts[COUNT]:
        return held
    x = memory[SUM_FIELD] / counts[FIELD_COUNT]
    y = memory[SUM_FIELD + 1] / counts[FIELD_COUNT]
    z = memory[SUM_FIELD + 2] / counts[FIELD_COUNT]
    bx, by, bz = memory[FIELD], memory[FIELD + 1], memory[FIELD + 2]
    known = math.sqrt(bx * bx + by * by + bz * bz)
    across = math.hypot(x, y) - math.hypot(bx, by)
    if math.hypot(across, z - bz) > _SAME_FIELD * known or held <= settings[HEADING_RESTART]:
        return held
    half = 0.5 * wrapped(math.atan2(by, bx) - math.atan2(y, x))
    w, x, y, z = multiply(math.cos(half), 0.0, 0.0, math.sin(half), q[0], q[1], q[2], q[3])
    q[0], q[1], q[2], q[3] = normalized(w, x, y, z)
    return float(settings[HEADING_RESTART])


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
    level(q, memory, counts)
    if counts[FIELD_KNOWN] == 0 and counts[FIELD_COUNT] > 0:
        face_north(memory)
    if counts[COUNT] < settings[START_TICKS]:
        return False
    time_s = counts[COUNT] * settings[STEP_S]
    push = memory[SUM_FORCE + 2] / (time_s * memory[GRAVITY]) - 1.0
    turning = min(math.sqrt(memory[SUM_RATE2] / counts[COUNT]), 1.0)
    tilt = push * push + (_TURNING_TILT * turning) ** 2
    heading = 0.0  # the first heading defines the frame
    if counts[FILTERED] == 0:
        tilt += settings[TILT_START]
        if 2 * counts[FIELD_COUNT] >= counts[COUNT]:
            meet_field(memory, counts, p, settings)
    else:
        tilt += settings[TILT_RESTART]
        gap_s = (counts[GAP] + settings[COAST_TICKS]) * settings[STEP_S]
        heading = _turn_to_field(q, memory, counts, settings, gap_s)
    for i in range(BIAS):
        for j in range(STATES):
            p[STATES * i + j] = p[STATES * j + i] = 0.0
    for a in range(3):
        p[(STATES + 1) * (TURN + a)] = tilt if a < 2 else heading
        p[(STATES + 1) * (VELOCITY + a)] = settings[SPEED_START]
        p[(STATES + 1) * (POSITION + a)] = _PLACE_VARIANCE
    clear_sums(memory, counts)
    counts[PHASE] = RUNNING
    counts[FILTERED] = 1
    counts[GAP] = 0
    return True


__all__ = ["begin", "collect", "forget_field", "meet_field"]
