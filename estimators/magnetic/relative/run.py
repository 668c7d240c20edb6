"""The loop of the relative-pose filter over samples; compiled."""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import kernel, step
from estimators.magnetic.relative import layout as at
from estimators.magnetic.relative.decide import decide
from estimators.magnetic.relative.moment import carry_sensitivity, judge_moment
from estimators.magnetic.relative.motion import corrected, mechanise, predict, relax
from estimators.magnetic.relative.pulse import pulse_value
from estimators.magnetic.relative.update import UNSEEN, update_inclination, update_pulse
from estimators.magnetic.relative.watch import (
    account,
    at_rest,
    calibrate,
    gather,
    keep_pulse,
    retreat,
    tell,
    watch_field,
)
from estimators.recording import Float

_P, _U, _Q, _COIL, _CURRENT = at.POSITION, at.VELOCITY, at.ATTITUDE, at.COIL, at.CURRENT
_RING, _SAMPLE, _LAST, _WINDOW, _LENGTH = at.RING, at.SAMPLE, at.LAST, at.NIS_WINDOW, at.NIS_LENGTH
_REFUSED, _NIS_ALARM = at.REFUSED, at.NIS_ALARM
_TICK, _PHASE, _WIDE_AFTER, _FIELD = at.TICK, at.PHASE, at.WIDE_AFTER, at.FIELD
_PULSE_LENGTH, _QUIET, _PENDING, _REQUESTED, _STREAK = (
    at.PULSE_LENGTH,
    at.QUIET,
    at.PENDING,
    at.REQUESTED_TICK,
    at.STREAK,
)
_BURST_COIL, _WAIT_UNTIL, _ALARM_UNTIL, _FIELD_BAD, _PULSES = (
    at.BURST_COIL,
    at.WAIT_UNTIL,
    at.ALARM_UNTIL,
    at.FIELD_BAD,
    at.PULSES,
)
_MISSED, _SATURATED_UNTIL, _EVENT, _STARTED, _MISSED_RUN = (
    at.MISSED,
    at.SATURATED_UNTIL,
    at.EVENT,
    at.STARTED,
    at.MISSED_RUN,
)
_FAILURES, _CALIBRATE, _GATHER, _WAIT, _T = at.FAILURES, at.CALIBRATE, at.GATHER, at.WAIT, at.TIME_STEP
_FORCE, _RATE, _OFF, _START_OFF, _INCLINE = (
    at.FORCE_SIGMA,
    at.RATE_SIGMA,
    at.OFF_TICKS,
    at.START_OFF_TICKS,
    at.INCLINATION_TICKS,
)
_NIS_SOFT, _NIS_STREAK, _FACTOR, _RETRY, _RESPONSE = (
    at.NIS_SOFT,
    at.NIS_STREAK,
    at.DISTURBED_FACTOR,
    at.RETRY_TICKS,
    at.RESPONSE_TICKS,
)
_ALARM, _PUBLISHED, _COILS, _USE_INCLINATION, _STREAK_PULSES, _O_P = (
    at.ALARM_TICKS,
    at.PUBLISHED,
    at.COILS,
    at.USE_INCLINATION,
    at.STREAK_PULSES,
    at.O_POSITION,
)
_O_Q, _O_U, _O_COV, _O_NIS, _O_FLAGS = at.O_ATTITUDE, at.O_VELOCITY, at.O_COVARIANCE, at.O_NIS, at.O_FLAGS

_KEPT_P, _KEPT_Q, _PATH, _PATH_COLUMNS = at.KEPT_POSITION, at.KEPT_ATTITUDE, at.PATH, at.PATH_COLUMNS
_GAP_LENGTH, _TRACK = at.GAP_LENGTH, at.TRACK
_GYR, _GYR_C, _MEASURED, _EP, _POSE_ERRORS = (
    at.GYROSCOPE,
    at.SOURCE_GYROSCOPE,
    at.MEASURED,
    at.E_POSITION,
    at.POSE_ERRORS,
)
_SIGNALS, _RATES, _PULSE, _LATE = at.SIGNALS, at.RATES, at.PULSE, at.PULSE_LATE
_S_RATE, _S_SOURCE_RATE, _R_SENSOR, _R_SOURCE = at.S_RATE, at.S_SOURCE_RATE, at.R_SENSOR, at.R_SOURCE
_GAP_FORCE, _GAP_RATE = 30.0, 8.0
"""White noise of a held sample that stands for 3 m/s^2 and 1 rad/s held wrongly over some tenths of a second."""
_UNREAD = 3
"""Pulses in a row that could not be read, after which the source is of no use for a while."""
_WIDE_SHARE = 0.25
"""Of the distance: with a place known less well than this a single pulse is not nearly linear, a burst needs to be
nothing at all."""
_LONG_GAP_S = 0.3
"""After this the pose is asked for again."""
_ALONE_FACTOR = 10.0
_PAIR_LIMIT, _WINDOW_LIMIT = 22.46, 37.7
"""99.9 % points of chi-square with the degrees of freedom of two and of five pulses."""


@step("void(float64[::1], int64[::1])")
def fail(settings: Float, counters: NDArray[np.int64]) -> None:
    """Count a pulse that said nothing; after a few in a row go on without the source."""
    counters[_FAILURES] += 1
    if counters[_FAILURES] >= _UNREAD:
        retreat(settings, counters)


@step("boolean(float64[::1], float64[:, ::1])")
def too_wide(nominal: Float, p: Float) -> bool:
    """Whether the place is known too badly, against the distance, for pulses one by one."""
    distance = nominal[_P] ** 2 + nominal[_P + 1] ** 2 + nominal[_P + 2] ** 2
    variance = p[_EP, _EP] + p[_EP + 1, _EP + 1] + p[_EP + 2, _EP + 2]
    return bool(variance > _WIDE_SHARE * _WIDE_SHARE * distance)


@step(
    "float64(int64, int64, float64[:, ::1], float64[::1], float64[::1], float64[::1], float64[:, ::1],"
    "float64[::1], int64[::1], float64[:, ::1], float64[:, ::1])"
)
def end_pulse(
    coil: int,
    length: int,
    loops: Float,
    settings: Float,
    rates: Float,
    nominal: Float,
    p: Float,
    memory: Float,
    counters: NDArray[np.int64],
    ring: Float,
    work: Float,
) -> float:
    """Use a pulse that has just ended; return its normalised innovation squared, NaN when it corrected nothing."""
    phase = counters[_PHASE]
    pulse, path = np.empty(_PULSE), np.empty((_PATH, _PATH_COLUMNS))
    counters[_PULSES] += 1
    counters[_MISSED_RUN] = 0
    if phase == _WAIT and coil == 1 and counters[_STARTED] > 0:
        # Nobody asked here, but a burst begins: of a source that fires by itself, or for another sensor.
        gather(counters)
        phase = _GATHER
    if phase in (_CALIBRATE, _WAIT):
        return math.nan
    if phase == _TRACK and counters[_TICK] >= counters[_WIDE_AFTER] and too_wide(nominal, p):
        gather(counters)
        phase = _GATHER
    gathering = phase == _GATHER
    off = int(settings[_START_OFF] if gathering else settings[_OFF])
    status = pulse_value(ring, counters[_TICK] - 1, length, off, nominal, settings, pulse, path)
    pulse[_LATE] += 1.0
    if status != 0:
        if status == 2:
            counters[_SATURATED_UNTIL] = counters[_TICK] + int(settings[_ALARM])
        fail(settings, counters)
        return math.nan
    if gathering:
        counters[_FAILURES] = 0
        if coil == counters[_BURST_COIL] + 1:
            middle = ring[(counters[_TICK] - int(pulse[_LATE])) % _RING]
            keep_pulse(pulse, middle, memory, coil - 1, counters[_TICK] - int(pulse[_LATE]))
            counters[_BURST_COIL] += 1
            if counters[_BURST_COIL] == 3:
                counters[_EVENT] = 1
        return math.nan
    if coil > int(settings[_COILS]):
        counters[_ALARM_UNTIL] = counters[_TICK] + int(settings[_ALARM])
        return math.nan
    inflation = settings[_FACTOR] if counters[_FIELD_BAD] >= 5 else 1.0
    nis = update_pulse(
        loops, float(coil - 1), pulse, path, rates, settings, inflation, nominal, p, memory, work
    )
    if nis == UNSEEN:
        counters[_ALARM_UNTIL] = counters[_TICK] + int(settings[_ALARM])
        fail(settings, counters)
        return math.nan
    counters[_FAILURES] = 0
    if nis <= settings[_NIS_SOFT]:
        counters[_REFUSED] = 0
    total = nis
    for i in range(_LENGTH - 1):
        memory[_WINDOW + i] = memory[_WINDOW + i + 1]
        total += memory[_WINDOW + i]
    memory[_WINDOW + _LENGTH - 1] = nis
    pair = nis + memory[_WINDOW + _LENGTH - 2]
    if nis > settings[_NIS_ALARM] or pair > _PAIR_LIMIT or total > _WINDOW_LIMIT:
        counters[_ALARM_UNTIL] = counters[_TICK] + int(settings[_ALARM])
    counters[_STREAK] = counters[_STREAK] + 1 if nis > settings[_NIS_STREAK] else 0
    if counters[_STREAK] >= settings[_STREAK_PULSES]:
        gather(counters)
    return nis


@step(
    "void(float64[::1], float64[:, ::1], float64[::1], float64[::1], float64[:, ::1], float64[::1], int64[::1],"
    "float64[:, ::1], float64[:, :, ::1], float64[::1])"
)
def tick(
    sample: Float,
    loops: Float,
    settings: Float,
    nominal: Float,
    p: Float,
    memory: Float,
    counters: NDArray[np.int64],
    ring: Float,
    work: Float,
    out: Float,
) -> None:
    """Take one sample of both modules and the state of the coils."""
    row = ring[counters[_TICK] % _RING]
    total = 0.0
    for first in (_GYR, _GYR_C):
        for i in range(first, first + 6):
            total += sample[i]
    whole = math.isfinite(total)
    for i in range(_SAMPLE):
        row[i] = sample[i]
    last = memory[_LAST : _LAST + _MEASURED]
    if whole:
        if counters[_GAP_LENGTH] * settings[_T] > _LONG_GAP_S and counters[_PHASE] == _TRACK:
            gather(counters)
        counters[_GAP_LENGTH] = 0
    else:
        counters[_GAP_LENGTH] += 1
        # No pulse may be read across what the gyroscope did not see.
        row[_GYR] = math.nan
    signals, rates = np.empty(_SIGNALS), np.empty(_RATES)
    corrected(nominal, last, row if whole else last, signals)
    if counters[_STARTED] > 0:
        force = settings[_FORCE] if whole else _GAP_FORCE
        rate = settings[_RATE] if whole else _GAP_RATE
        predict(nominal, signals, settings, force, rate, p, work)
        carry_sensitivity(work[1], settings, memory)
        mechanise(nominal, signals, settings[_T], settings[_PUBLISHED] > 0.0)
        relax(nominal, settings)
    for i in range(3):
        row[_KEPT_P + i] = nominal[_P + i]
        rates[_R_SENSOR + i], rates[_R_SOURCE + i] = signals[_S_RATE + i], signals[_S_SOURCE_RATE + i]
    for i in range(4):
        row[_KEPT_Q + i] = nominal[_Q + i]
    coil = int(sample[_COIL])
    before = int(ring[(counters[_TICK] - 1) % _RING, _COIL]) if counters[_TICK] > 0 else 0
    resting = at_rest(signals, whole, settings, counters)
    inclined = counters[_STARTED] > 0 and resting and settings[_USE_INCLINATION] > 0.0
    # Not while a pulse is read: its way must be one piece.
    inclined = inclined and coil == 0 and before == 0
    if inclined and counters[_TICK] % int(settings[_INCLINE]) == 0:
        corrected(nominal, row, row, signals)
        factor = 1.0 if counters[_PHASE] == _TRACK else _ALONE_FACTOR
        update_inclination(nominal, signals, settings, factor, p, memory, work[0])
    out[:] = 0.0
    out[_O_NIS] = math.nan
    if before > 0 and coil != before:
        out[_O_NIS] = end_pulse(
            before,
            counters[_PULSE_LENGTH],
            loops,
            settings,
            rates,
            nominal,
            p,
            memory,
            counters,
            ring,
            work[0],
        )
        counters[_PULSE_LENGTH] = 0
    account(sample, settings, memory, counters)
    if coil > 0:
        counters[_PULSE_LENGTH] += 1
        counters[_QUIET] = 0
        counters[_PENDING] = 0
    else:
        counters[_QUIET] += 1
        if counters[_PHASE] == _CALIBRATE and whole:
            calibrate(sample, settings, nominal, memory, counters)
        elif counters[_STARTED] > 0:
            watch_field(row, resting, settings, memory, counters)
    if counters[_PENDING] > 0 and counters[_TICK] - counters[_REQUESTED] > settings[_RESPONSE]:
        counters[_PENDING] = 0
        counters[_MISSED] += 1
        counters[_MISSED_RUN] += 1
        if counters[_MISSED_RUN] >= 3:
            counters[_PHASE] = _WAIT
            counters[_WAIT_UNTIL] = counters[_TICK] + int(settings[_RETRY])
    # No coil is fired for a magnetometer that says nothing.
    has_field = math.isfinite(sample[_FIELD] + sample[_FIELD + 1] + sample[_FIELD + 2])
    if counters[_PHASE] == _WAIT and counters[_TICK] >= counters[_WAIT_UNTIL] and has_field:
        gather(counters)
        counters[_PENDING] = 0
    decide(loops, settings, rates, nominal, p, memory, counters, out)
    if whole:
        for i in range(_MEASURED):
            last[i] = row[i]
    for i in range(3):
        out[_O_P + i], out[_O_U + i] = nominal[_P + i], nominal[_U + i]
    for i in range(4):
        out[_O_Q + i] = nominal[_Q + i]
    column = _O_COV
    for i in _POSE_ERRORS:
        for j in _POSE_ERRORS:
            out[column] = p[i, j]
            column += 1
    if counters[_STARTED] > 0:
        judge_moment(settings, memory, counters, out)
    out[_O_FLAGS] = float(tell(sample, settings, counters, p))
    counters[_TICK] += 1


@kernel(
    "int64(float64[:, ::1], float64[:, ::1], float64[::1], float64[::1], float64[:, ::1], float64[::1], int64[::1],"
    "float64[:, ::1], float64[:, ::1])"
)
def run(
    samples: Float,
    loops: Float,
    settings: Float,
    nominal: Float,
    p: Float,
    memory: Float,
    counters: NDArray[np.int64],
    ring: Float,
    out: Float,
) -> int:
    """Take samples until one completes a burst that must be solved; return how many were taken."""
    work = np.empty((3, p.shape[0], p.shape[0]))
    for k in range(samples.shape[0]):
        tick(samples[k], loops, settings, nominal, p, memory, counters, ring, work, out[k])
        if counters[_EVENT] > 0:
            return k + 1
    return len(samples)
