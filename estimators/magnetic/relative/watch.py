"""Standstill, the earth's field between pulses, the first burst, and the flags; compiled."""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import kernel, step
from estimators.magnetic.relative import layout as at
from estimators.recording import Float

_BG, _BGC, _KEPT_P, _KEPT_Q = at.RATE_BIAS, at.SOURCE_RATE_BIAS, at.KEPT_POSITION, at.KEPT_ATTITUDE
_MODULES = ((at.S_RATE, at.S_FORCE), (at.S_SOURCE_RATE, at.S_SOURCE_FORCE))
_EP, _ET = at.E_POSITION, at.E_ATTITUDE
_B_VALUE, _B_P, _B_Q = at.BURST_VALUE, at.BURST_POSITION, at.BURST_ATTITUDE
_B_CURRENT, _B_TICK = at.BURST_CURRENT, at.BURST_TICK
_PULSE_VALUE, _PULSE_CURRENT = at.PULSE_VALUE, at.PULSE_CURRENT
_GYR, _ACC, _FIELD, _GYR_C, _ACC_C = (
    at.GYROSCOPE,
    at.ACCELEROMETER,
    at.FIELD,
    at.SOURCE_GYROSCOPE,
    at.SOURCE_ACCELEROMETER,
)
_SUM, _SUM_C, _SUM_F, _SUM_FC, _SUM_B = (
    at.SUM_RATE,
    at.SUM_SOURCE_RATE,
    at.SUM_FORCE,
    at.SUM_SOURCE_FORCE,
    at.SUM_FIELD,
)
_NORM, _DIP, _BURST, _COLUMNS, _TICK = (
    at.REFERENCE_NORM,
    at.REFERENCE_DIP,
    at.BURST,
    at.BURST_COLUMNS,
    at.TICK,
)
_PHASE, _STILL, _QUIET, _BURST_COIL, _ALARM_UNTIL = (
    at.PHASE,
    at.STILL,
    at.QUIET,
    at.BURST_COIL,
    at.ALARM_UNTIL,
)
_COIL, _CURRENT, _ON_TIME, _CHARGE, _ENERGY = at.COIL, at.CURRENT, at.ON_TIME, at.CHARGE, at.ENERGY
_BUDGET_ON, _BUDGET_SQUARED, _BINS = at.BUDGET_ON, at.BUDGET_SQUARED, at.BUDGET_BINS
_SECOND, _MOST_ON, _MOST_SQUARED = at.SECOND_TICKS, at.MOST_ON_TIME, at.MOST_SQUARED
_REFUSED, _WAIT_UNTIL, _STREAK, _FAILURES = at.REFUSED, at.WAIT_UNTIL, at.STREAK, at.FAILURES
_UNCERTAIN_P, _UNCERTAIN_A = at.UNCERTAIN_POSITION, at.UNCERTAIN_ATTITUDE
_RETRY, _LONGEST_RETRY = at.RETRY_TICKS, at.LONGEST_RETRY_TICKS
_FIELD_BAD, _SATURATED_UNTIL, _STARTED, _MISSED_RUN, _AT_REST = (
    at.FIELD_BAD,
    at.SATURATED_UNTIL,
    at.STARTED,
    at.MISSED_RUN,
    at.AT_REST,
)
_CALIBRATE, _GATHER, _TRACK, _WAIT, _T = at.CALIBRATE, at.GATHER, at.TRACK, at.WAIT, at.TIME_STEP
_G, _CALIBRATE_TICKS, _GATE_F = (
    at.GRAVITY,
    at.CALIBRATE_TICKS,
    at.GATE_FORCE,
)
_GATE_W, _NORM_LIMIT, _DIP_LIMIT, _ALARM, _STILL_RATE = (
    at.GATE_RATE,
    at.FIELD_NORM_LIMIT,
    at.FIELD_DIP_LIMIT,
    at.ALARM_TICKS,
    at.STILL_RATE,
)

# Flags, as in `RelativeFlag`.
INVALID, CALIBRATING, INERTIAL_ONLY, DISTURBED = 1, 2, 4, 8
MISSING_PULSE, SATURATED, FAULT, UNCERTAIN, GAP = 16, 32, 64, 128, 256

_REST_S = 0.7


@step("boolean(float64[::1], float64[::1])")
def quasi_static(signals: Float, settings: Float) -> bool:
    """Whether both modules hardly turn and feel little but gravity at a moment."""
    for w, f in _MODULES:
        rate = math.sqrt(signals[w] ** 2 + signals[w + 1] ** 2 + signals[w + 2] ** 2)
        force = math.sqrt(signals[f] ** 2 + signals[f + 1] ** 2 + signals[f + 2] ** 2)
        if rate > settings[_GATE_W] or abs(force - settings[_G]) > settings[_GATE_F]:
            return False
    return True


@step("boolean(float64[::1], boolean, float64[::1], int64[::1])")
def at_rest(signals: Float, whole: bool, settings: Float, counters: NDArray[np.int64]) -> bool:
    """Whether both modules hardly turn and feel little but gravity, and have done so for a while.

    At the turning points of a swing the rate vanishes too, but not for long, and acceleration is no gravity there:
    taken for gravity, swing by swing the same, it would bend the attitude far more than its noise says.
    """
    still = whole and quasi_static(signals, settings)
    counters[_AT_REST] = counters[_AT_REST] + 1 if still else 0
    return bool(counters[_AT_REST] * settings[_T] > _REST_S)


@step("void(float64[::1], float64[::1], int64)")
def _add_field(sample: Float, memory: Float, count: int) -> None:
    """Add the field of the `count`-th sample of a standstill; one that is missing counts as the mean of the others."""
    known = math.isfinite(sample[_FIELD] + sample[_FIELD + 1] + sample[_FIELD + 2])
    is_first = memory[_SUM_B] == 0.0 and memory[_SUM_B + 1] == 0.0 and memory[_SUM_B + 2] == 0.0
    for i in range(3):
        if known and is_first:
            memory[_SUM_B + i] = count * sample[_FIELD + i]
        elif known:
            memory[_SUM_B + i] += sample[_FIELD + i]
        elif count > 1:
            memory[_SUM_B + i] += memory[_SUM_B + i] / (count - 1)


@step("void(float64[::1], float64[::1], float64[::1], float64[::1], int64[::1])")
def calibrate(
    sample: Float, settings: Float, nominal: Float, memory: Float, counters: NDArray[np.int64]
) -> None:
    """Gather the standstill: offsets of the gyroscopes, norm and dip of the earth's field."""
    rate = force = rate_c = force_c = 0.0
    for i in range(3):
        rate += sample[_GYR + i] ** 2
        rate_c += sample[_GYR_C + i] ** 2
        force += sample[_ACC + i] ** 2
        force_c += sample[_ACC_C + i] ** 2
    still = max(rate, rate_c) < settings[_STILL_RATE] ** 2
    still = still and abs(math.sqrt(force) - settings[_G]) < 2.0 * settings[_GATE_F]
    still = still and abs(math.sqrt(force_c) - settings[_G]) < 2.0 * settings[_GATE_F]
    if not still:
        counters[_STILL] = 0
        for i in range(_SUM, _NORM):
            memory[i] = 0.0
        return
    counters[_STILL] += 1
    _add_field(sample, memory, counters[_STILL])
    for i in range(3):
        memory[_SUM + i] += sample[_GYR + i]
        memory[_SUM_C + i] += sample[_GYR_C + i]
        memory[_SUM_F + i] += sample[_ACC + i]
        memory[_SUM_FC + i] += sample[_ACC_C + i]
    if counters[_STILL] < settings[_CALIBRATE_TICKS]:
        return
    count = float(counters[_STILL])
    norm = dot = gravity = 0.0
    for i in range(3):
        nominal[_BG + i] = memory[_SUM + i] / count
        nominal[_BGC + i] = memory[_SUM_C + i] / count
        norm += (memory[_SUM_B + i] / count) ** 2
        gravity += (memory[_SUM_F + i] / count) ** 2
        dot += memory[_SUM_B + i] * memory[_SUM_F + i] / (count * count)
    memory[_NORM] = math.sqrt(norm)
    memory[_DIP] = math.acos(min(1.0, max(-1.0, dot / math.sqrt(norm * gravity)))) if norm > 0.0 else 0.0
    counters[_PHASE] = _GATHER
    counters[_BURST_COIL] = 0


@step("void(float64[::1], boolean, float64[::1], float64[::1], int64[::1])")
def watch_field(
    sample: Float, resting: bool, settings: Float, memory: Float, counters: NDArray[np.int64]
) -> None:
    """Compare norm and dip of the earth's field between pulses with those of the start (method page 3.13)."""
    if not memory[_NORM] > 0.0 or counters[_QUIET] < 2:
        return
    norm = dot = gravity = 0.0
    for i in range(3):
        norm += sample[_FIELD + i] ** 2
        gravity += sample[_ACC + i] ** 2
        dot += sample[_FIELD + i] * sample[_ACC + i]
    if not math.isfinite(norm + gravity) or norm <= 0.0:
        return
    bad = abs(math.sqrt(norm) / memory[_NORM] - 1.0) > settings[_NORM_LIMIT]
    if resting and not bad:
        dip = math.acos(min(1.0, max(-1.0, dot / math.sqrt(norm * gravity))))
        bad = abs(dip - memory[_DIP]) > settings[_DIP_LIMIT]
    counters[_FIELD_BAD] = min(20, counters[_FIELD_BAD] + 1) if bad else max(0, counters[_FIELD_BAD] - 1)
    if counters[_FIELD_BAD] >= 5:
        counters[_ALARM_UNTIL] = counters[_TICK] + int(settings[_ALARM])


@step("void(float64[::1], float64[::1], float64[::1], int64, int64)")
def keep_pulse(pulse: Float, middle: Float, memory: Float, number: int, tick: int) -> None:
    """Keep a pulse of a burst with the pose that was predicted for its middle, a row of the ring, at a tick."""
    row = _BURST + number * _COLUMNS
    for i in range(3):
        memory[row + _B_VALUE + i] = pulse[_PULSE_VALUE + i]
        memory[row + _B_P + i] = middle[_KEPT_P + i]
    for i in range(4):
        memory[row + _B_Q + i] = middle[_KEPT_Q + i]
    memory[row + _B_CURRENT] = pulse[_PULSE_CURRENT]
    memory[row + _B_TICK] = float(tick)


@kernel("void(float64[::1], int64[::1])")
def retreat(settings: Float, counters: NDArray[np.int64]) -> None:
    """Go on without the source for a while, for twice as long after each time that it was of no use."""
    pause = settings[_RETRY]
    for _ in range(counters[_REFUSED]):
        pause = min(2.0 * pause, settings[_LONGEST_RETRY])
    counters[_REFUSED] += 1
    counters[_PHASE] = _WAIT
    counters[_WAIT_UNTIL] = counters[_TICK] + int(pause)
    counters[_BURST_COIL] = 0
    counters[_STREAK] = 0
    counters[_FAILURES] = 0


@step("void(int64[::1])")
def gather(counters: NDArray[np.int64]) -> None:
    """Ask for a burst."""
    counters[_PHASE] = _GATHER
    counters[_BURST_COIL] = 0
    counters[_STREAK] = 0
    counters[_FAILURES] = 0


@step("void(float64[::1], float64[::1], float64[::1], int64[::1])")
def account(sample: Float, settings: Float, memory: Float, counters: NDArray[np.int64]) -> None:
    """Book what the source does at this tick: altogether, and in the bin of this second."""
    tick, second = counters[_TICK], int(settings[_SECOND])
    place = (tick // second) % _BINS
    if tick % second == 0:
        memory[_BUDGET_ON + place] = memory[_BUDGET_SQUARED + place] = 0.0
    if sample[_COIL] > 0.0:
        on, current = settings[_T], sample[_CURRENT]
        memory[_ON_TIME] += on
        memory[_CHARGE] += on * abs(current)
        memory[_ENERGY] += on * current * current
        memory[_BUDGET_ON + place] += on
        memory[_BUDGET_SQUARED + place] += on * current * current


@step("boolean(float64[::1], float64[::1], float64, float64)")
def affordable(settings: Float, memory: Float, ticks: float, current: float) -> bool:
    """Whether one more pulse keeps the last minute within what the source may do."""
    on = settings[_T] * ticks
    squared = on * current * current
    for i in range(_BINS):
        on += memory[_BUDGET_ON + i]
        squared += memory[_BUDGET_SQUARED + i]
    return bool(on <= settings[_MOST_ON] and squared <= settings[_MOST_SQUARED])


@step("int64(float64[::1], float64[::1], int64[::1], float64[:, ::1])")
def tell(sample: Float, settings: Float, counters: NDArray[np.int64], p: Float) -> int:
    """Return the flags of a tick."""
    flags, phase, tick = 0, counters[_PHASE], counters[_TICK]
    if counters[_STARTED] == 0:
        flags |= INVALID
    if phase == _CALIBRATE or (phase == _GATHER and counters[_STARTED] == 0):
        flags |= CALIBRATING
    if phase != _TRACK:
        flags |= INERTIAL_ONLY
    if phase == _WAIT:
        flags |= FAULT
    if tick < counters[_ALARM_UNTIL]:
        flags |= DISTURBED
    if counters[_MISSED_RUN] > 0:
        flags |= MISSING_PULSE
    if tick < counters[_SATURATED_UNTIL]:
        flags |= SATURATED
    whole = 0.0
    for i in range(3):
        whole += sample[_GYR + i] + sample[_ACC + i] + sample[_GYR_C + i] + sample[_ACC_C + i]
    if not math.isfinite(whole):
        flags |= GAP
    if counters[_STARTED] > 0:
        for i in range(3):
            place, turn = p[_EP + i, _EP + i], p[_ET + i, _ET + i]
            if place > settings[_UNCERTAIN_P] ** 2 or turn > settings[_UNCERTAIN_A] ** 2:
                flags |= UNCERTAIN
    return flags
