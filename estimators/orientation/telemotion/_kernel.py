"""Our own online filter over sensors and ticks: start, gaps, blocks and output."""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import exponential, kernel, multiply
from estimators.orientation._contract import OrientationFlag
from estimators.orientation.telemotion._block import hold_place, inject, move, predict, see_field
from estimators.orientation.telemotion._field import (
    WORK,
    field_variance,
    find_north,
    iron_changed,
    open_iron,
    restless,
)
from estimators.orientation.telemotion._first_field import doubt, outlasted
from estimators.orientation.telemotion._gaps import (
    after_gap,
    coast,
    doubt_filling,
    filled,
    gap_variance,
    remember,
    set_aside,
)
from estimators.orientation.telemotion._layout import (
    BLOCK_TICKS,
    COAST,
    COAST_TICKS,
    CONVERGENCE_TICKS,
    CORRECTION,
    COUNT,
    DISTURBANCE,
    FIELD_COUNT,
    FIELD_KNOWN,
    FORCE,
    FORCE_TOLERANCE,
    GAP,
    GAP_SHARE,
    GRAVITY,
    HAS_FIELD,
    HEADING_FLOOR,
    HEADING_LOST,
    HEADING_VARIANCE,
    HYPOTHESIS_BLOCKS,
    IDLE,
    LAST_SAMPLE,
    LEAD_S,
    MISFIT,
    ODDS,
    OFFSET,
    PENDING,
    PHASE,
    REST_MINIMUM_S,
    REST_S,
    RUNNING,
    SAMPLE,
    SATURATED,
    SHOWN,
    SINCE_START,
    SLOPE,
    START_MOVING,
    STATES,
    STEP_S,
    TICK,
    TILT_FLOOR,
    TILT_SCALE,
    TILT_VARIANCE,
)
from estimators.orientation.telemotion._output import keep_shown, read, shown, take_back
from estimators.orientation.telemotion._samples import clear_sums, integrate, watch_rest
from estimators.orientation.telemotion._start import (
    begin,
    collect,
    find_heading,
    forget_field,
    lost,
    meet_field,
    upright,
    young,
)
from estimators.orientation.telemotion._upright import contradiction, start_over
from estimators.recording import Float, SampleQuality

_INVALID = int(OrientationFlag.INVALID)
_BRIDGED = int(OrientationFlag.BRIDGED)
_CONVERGING = int(OrientationFlag.CONVERGING)
_ACCELERATION = int(OrientationFlag.ACCELERATION_NOT_TRUSTED)
_DISTURBANCE = int(OrientationFlag.MAGNETIC_DISTURBANCE)
_NO_HEADING = int(OrientationFlag.HEADING_NOT_TRUSTED)
_SATURATED = int(OrientationFlag.SATURATED)
_SAMPLE_BRIDGED = int(SampleQuality.BRIDGED)
_DISTURBED = 8.0
"""Misfit of a block, in squared scales: a residual of 5 uT from a field that is well known."""
_WORST_LEVEL = 10.0
_SETTLING = 1.0 / 3.0
_UNSURE = math.radians(5.0)
_UNKNOWN = 1.0
"""Variance of a heading while there is a field that is not yet met."""


@kernel(
    "void(float64[::1], float64[::1], float64[::1], float64[::1], int64[::1], int64, float64[::1],"
    "float64[:, ::1], int64[:, ::1], float64[:, ::1], float64[::1])"
)
def end_block(
    q: Float,
    bias: Float,
    p: Float,
    memory: Float,
    counts: NDArray[np.int64],
    tick: int,
    settings: Float,
    rows: Float,
    index: NDArray[np.int64],
    value: Float,
    work: Float,
) -> None:
    """Run the filter over the sums of a block and move its error into the estimate."""
    error, before = rows[5], rows[6]
    shown(memory, q, before)
    ticks = float(counts[COUNT])
    time_s = ticks * settings[STEP_S]
    rest = memory[REST_S] > settings[REST_MINIMUM_S]
    met, found = False, True
    move(memory, settings, ticks)
    predict(p, memory, settings, ticks)
    hold_place(p, error, rows, bias, memory, settings, index, value, ticks, rest)
    odds = memory[ODDS : ODDS + 9]
    if 2 * counts[FIELD_COUNT] >= counts[COUNT] and upright(p):
        if counts[FIELD_KNOWN] == 0:
            meet_field(memory, counts, p, settings)
            met = True
        elif lost(p):
            met = found = find_heading(p, memory, counts, settings, rest)
        elif restless(memory, counts, settings, time_s, rest):
            forget_field(memory, p, settings)
            meet_field(memory, counts, p, settings)
        elif outlasted(memory, counts, time_s, rest):
            forget_field(memory, p, settings)
            meet_field(memory, counts, p, settings)
            met = True
        elif iron_changed(memory, counts, settings, time_s):
            open_iron(p, error, rows, memory, index, value, counts, settings, odds)
        if found:
            variance = field_variance(p, memory, counts, settings, time_s, rest)
            see_field(p, error, rows, memory, index, value, counts, variance)
    off = contradiction(p, memory, error, settings, time_s)
    inject(q, bias, memory, error)
    if off > 0.0:
        start_over(q, p, memory, counts, settings, off)
    blocks = (tick + 1) // int(settings[BLOCK_TICKS])
    if counts[FIELD_KNOWN] and (blocks % int(settings[HYPOTHESIS_BLOCKS]) == 0 or met):
        find_north(p, memory, counts, settings, odds, work)
        memory[HEADING_VARIANCE] += doubt(memory)
    if counts[FIELD_KNOWN] == 0:
        memory[HEADING_VARIANCE] = p[2 * (STATES + 1)] + (_UNKNOWN if counts[FIELD_COUNT] > 0 else 0.0)
    cosine = memory[CORRECTION] ** 2 - memory[CORRECTION + 3] ** 2
    sine = 2.0 * memory[CORRECTION] * memory[CORRECTION + 3]
    mixed = 2.0 * sine * cosine * p[1]
    across, along = p[0], p[STATES + 1]
    scale = settings[TILT_SCALE]
    if young(memory, counts, settings):  # what a start leaves open is no correlated noise
        scale = 1.0
    memory[TILT_VARIANCE] = scale * (cosine**2 * across + sine**2 * along - mixed)
    memory[TILT_VARIANCE + 1] = scale * (sine**2 * across + cosine**2 * along + mixed)
    clear_sums(memory, counts)
    if met:
        for a in range(3):
            memory[OFFSET + a] = 0.0
        counts[SINCE_START] = 0
    elif off == 0.0:
        keep_shown(memory, q, before)


@kernel(
    "void(float64[::1], float64[::1], float64[::1], float64[::1], int64[::1], int64, float64[::1],"
    "float64[::1], float64[:, ::1], int64[:, ::1], float64[:, ::1], float64[::1])"
)
def advance(
    q: Float,
    bias: Float,
    p: Float,
    memory: Float,
    counts: NDArray[np.int64],
    tick: int,
    sample: Float,
    settings: Float,
    rows: Float,
    index: NDArray[np.int64],
    value: Float,
    work: Float,
) -> None:
    """Take the sample of one tick; blocks end at multiples of their length in ticks of the session."""
    watch_rest(memory, counts, sample, settings)
    integrate(q, bias, memory, counts, sample, settings)
    if (tick + 1) % int(settings[BLOCK_TICKS]) == 0:
        end_block(q, bias, p, memory, counts, tick, settings, rows, index, value, work)


@kernel(
    "void(float64[::1], float64[::1], float64[::1], float64[::1], int64[::1], int64, float64[::1], boolean,"
    "float64[::1], float64[:, ::1], int64[:, ::1], float64[:, ::1], float64[::1])"
)
def fill_gap(
    q: Float,
    bias: Float,
    p: Float,
    memory: Float,
    counts: NDArray[np.int64],
    tick: int,
    now: Float,
    sloped: bool,
    settings: Float,
    rows: Float,
    index: NDArray[np.int64],
    value: Float,
    work: Float,
) -> None:
    """Catch up: the samples of the gap, and the one set aside, whose tick is `tick`."""
    sample = rows[7][:SAMPLE]
    gap = counts[GAP]
    for place in range(1, gap + 1):
        filled(memory, now, place, float(gap), sloped, sample)
        advance(
            q, bias, p, memory, counts, tick - 1 - gap + place, sample, settings, rows, index, value, work
        )
    doubt_filling(memory, now, sloped, settings, float(gap))
    after_gap(memory, sample)
    advance(q, bias, p, memory, counts, tick, sample, settings, rows, index, value, work)
    for i in range(6):
        first, second = memory[LAST_SAMPLE + i], sample[i]
        memory[SLOPE + i] = now[i] - second if sloped else (second - first) / (gap + 1.0)
        memory[LAST_SAMPLE + i] = second
    for i in range(6, 9):
        memory[LAST_SAMPLE + i] = sample[i] if sample[HAS_FIELD] > 0.0 else np.nan
    counts[GAP] = counts[PENDING] = 0


@kernel(
    "void(float64[:, :, ::1], float64[:, :, ::1], float64[:, :, ::1], uint8[:, ::1], float64[::1],"
    "float64[:, ::1], float64[:, ::1], float64[:, :, ::1], float64[:, ::1], int64[:, ::1],"
    "float64[:, :, ::1], float64[:, :, ::1], float64[:, :, ::1], uint8[:, ::1])"
)
def run(
    gyroscope_radps: Float,
    accelerometer_mps2: Float,
    magnetometer_t: Float,
    quality: NDArray[np.uint8],
    settings: Float,
    q_all: Float,
    bias_all: Float,
    covariance: Float,
    memory_all: Float,
    counters: NDArray[np.int64],
    q_earth_sensor: Float,
    bias_out: Float,
    sigma_rad: Float,
    flags: NDArray[np.uint8],
) -> None:
    """Filter K ticks of S sensors; the states are carried on."""
    rows = np.zeros((8, STATES))
    index, value = np.zeros((3, 8), dtype=np.int64), np.zeros((3, 8))
    work = np.zeros(WORK)
    sample, out = np.zeros(SAMPLE), np.zeros(4)
    step_s, block_ticks = settings[STEP_S], int(settings[BLOCK_TICKS])
    flat = covariance.reshape(covariance.shape[0], STATES * STATES)
    for s in range(quality.shape[0]):
        q, bias, p = q_all[s], bias_all[s], flat[s]
        memory, counts = memory_all[s], counters[s]
        for k in range(quality.shape[1]):
            tick = counts[TICK]
            counts[TICK] += 1
            grade = quality[s, k]
            usable = read(
                s, k, gyroscope_radps, accelerometer_mps2, magnetometer_t, grade, sample, memory, counts
            )
            bridged = (grade & _SAMPLE_BRIDGED) != 0
            measured = usable and not bridged
            take_back(memory, settings)
            coasting = False
            if counts[PHASE] == RUNNING:
                counts[SINCE_START] += 1
                if measured and counts[GAP] == 0:
                    remember(memory, sample)
                    watch_rest(memory, counts, sample, settings)
                    integrate(q, bias, memory, counts, sample, settings)
                    if (tick + 1) % block_ticks == 0:
                        end_block(q, bias, p, memory, counts, tick, settings, rows, index, value, work)
                elif measured and counts[PENDING]:
                    fill_gap(
                        q, bias, p, memory, counts, tick - 1, sample, True, settings, rows, index, value, work
                    )
                    remember(memory, sample)
                    advance(q, bias, p, memory, counts, tick, sample, settings, rows, index, value, work)
                elif measured:
                    set_aside(memory, sample)
                    counts[PENDING] = 1
                    coast(memory, bias, sample, True, 1.0, step_s)
                    coasting = True
                else:
                    if counts[PENDING]:
                        fill_gap(
                            q,
                            bias,
                            p,
                            memory,
                            counts,
                            tick - 1,
                            sample,
                            False,
                            settings,
                            rows,
                            index,
                            value,
                            work,
                        )
                    if counts[GAP] == 0:
                        for i in range(4):
                            memory[COAST + i] = q[i]
                    counts[GAP] += 1
                    if counts[GAP] > settings[COAST_TICKS]:
                        for i in range(4):
                            q[i] = memory[COAST + i]
                        counts[PHASE] = IDLE
                    else:
                        coast(memory, bias, sample, usable, float(counts[GAP]), step_s)
                        coasting = True
            elif usable:
                if counts[PHASE] == IDLE:
                    begin(memory, counts, sample)
                    remember(memory, sample)
                    for i in range(6):
                        memory[SLOPE + i] = 0.0
                else:
                    counts[SINCE_START] += 1
                    remember(memory, sample)
                collect(q, bias, p, memory, counts, sample, settings)
            else:
                counts[PHASE] = IDLE
                counts[GAP] += 1
            flag = _BRIDGED if bridged else 0
            if sample[SATURATED] > 0.0:
                flag |= _SATURATED
            for a in range(3):
                bias_out[s, k, a] = bias[a]
            if counts[PHASE] == IDLE:
                flags[s, k] = flag | _INVALID | _NO_HEADING
                for i in range(4):
                    q_earth_sensor[s, k, i] = memory[SHOWN + i]
                for a in range(3):
                    sigma_rad[s, k, a] = math.pi
                continue
            if coasting:
                shown(memory, memory[COAST : COAST + 4], out)
            else:
                shown(memory, q, out)
            if settings[LEAD_S] != 0.0:
                tw, tx, ty, tz = exponential(
                    settings[LEAD_S] * (memory[LAST_SAMPLE] - bias[0]),
                    settings[LEAD_S] * (memory[LAST_SAMPLE + 1] - bias[1]),
                    settings[LEAD_S] * (memory[LAST_SAMPLE + 2] - bias[2]),
                )
                out[0], out[1], out[2], out[3] = multiply(out[0], out[1], out[2], out[3], tw, tx, ty, tz)
            for i in range(4):
                q_earth_sensor[s, k, i] = memory[SHOWN + i] = out[i]
            added = 0.0
            if coasting:
                added = gap_variance(
                    memory, float(counts[GAP] + counts[PENDING]), settings[GAP_SHARE], step_s
                )
                if not measured:
                    flag |= _BRIDGED
            level = 1.0 + min(memory[DISTURBANCE], _WORST_LEVEL)
            for a in range(3):
                variance = added + memory[OFFSET + a] ** 2
                if a < 2:
                    variance += memory[TILT_VARIANCE + a] + settings[TILT_FLOOR]
                else:
                    variance += memory[HEADING_VARIANCE] + settings[HEADING_FLOOR] * level
                sigma_rad[s, k, a] = min(math.sqrt(max(variance, 1e-12)), math.pi)
            if usable:
                norm = math.sqrt(sample[FORCE] ** 2 + sample[FORCE + 1] ** 2 + sample[FORCE + 2] ** 2)
                if abs(norm - memory[GRAVITY]) > settings[FORCE_TOLERANCE]:
                    flag |= _ACCELERATION
            # A third of the time at least; after that only while the uncertainty is large.
            age = counts[SINCE_START] / settings[CONVERGENCE_TICKS]
            largest = max(sigma_rad[s, k, 0], sigma_rad[s, k, 1], sigma_rad[s, k, 2])
            unsure = largest > _UNSURE or memory[START_MOVING] > 0.0
            if age < _SETTLING or (age < 1.0 and unsure):
                flag |= _CONVERGING
            if sample[HAS_FIELD] > 0.0 and memory[MISFIT] > _DISTURBED:
                flag |= _DISTURBANCE
            if counts[FIELD_KNOWN] == 0 or sigma_rad[s, k, 2] > settings[HEADING_LOST]:
                flag |= _NO_HEADING
            flags[s, k] = flag


__all__ = ["run"]
