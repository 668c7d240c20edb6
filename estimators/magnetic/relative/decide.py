"""Which coil to fire, with which current, and when; compiled (method page 3.10)."""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import step
from estimators.magnetic.relative import layout as at
from estimators.magnetic.relative.pulse import expected_variance, predict_pulse
from estimators.magnetic.relative.update import innovate
from estimators.magnetic.relative.watch import affordable
from estimators.recording import Float

_P, _TICK, _PHASE, _PULSE_LENGTH, _QUIET = at.POSITION, at.TICK, at.PHASE, at.PULSE_LENGTH, at.QUIET
_PENDING, _REQUESTED, _BURST_COIL, _PULSES, _LAST_REQUEST = (
    at.PENDING,
    at.REQUESTED_TICK,
    at.BURST_COIL,
    at.PULSES,
    at.LAST_REQUEST,
)
_GATHER, _TRACK = at.GATHER, at.TRACK
_LIMIT_P, _LIMIT_A, _ON, _OFF, _START_ON = (
    at.POSITION_LIMIT,
    at.ATTITUDE_LIMIT,
    at.ON_TICKS,
    at.OFF_TICKS,
    at.START_ON_TICKS,
)
_START_OFF, _CURRENT_SET, _LEAST, _CURRENT_SHARE = (
    at.START_OFF_TICKS,
    at.CURRENT_SETTING,
    at.LEAST_CURRENT,
    at.CURRENT_SHARE,
)
_ADAPTIVE, _BY_DISTANCE, _GAIN, _FIXED = (
    at.ADAPTIVE_CURRENT,
    at.SCALE_BY_DISTANCE,
    at.GAIN_SIGMA,
    at.FIXED_TICKS,
)
_WAIT_UNTIL = at.WAIT_UNTIL
_EP, _EU, _ET, _EA, _POSE_ERRORS = at.E_POSITION, at.E_VELOCITY, at.E_ATTITUDE, at.E_FORCE, at.POSE_ERRORS
_COILS, _O_COIL, _O_CURRENT, _O_SCORES, _O_TICKS = at.COILS, at.O_COIL, at.O_CURRENT, at.O_SCORES, at.O_TICKS


@step("float64(float64[:, ::1], float64[:, ::1], float64[:, ::1], float64[::1], float64, float64)")
def score_after(p: Float, h: Float, r: Float, zero: Float, limit_p: float, limit_a: float) -> float:
    """Return the traces of position and attitude covariance over their squared limits after a pulse."""
    n = p.shape[0]
    gain = np.empty((n, 3))
    if innovate(p, h, r, zero, gain) < 0.0:
        return math.inf
    score = 0.0
    for i in _POSE_ERRORS:
        reduced = p[i, i]
        for a in range(3):
            total = 0.0
            for k in range(_EA):
                total += h[a, k] * p[k, i]
            reduced -= gain[i, a] * total
        score += reduced / (limit_p * limit_p if i < _EU else limit_a * limit_a)
    return score


@step(
    "int64(float64[:, ::1], float64[::1], float64[::1], float64[::1], float64[:, ::1], float64, float64[::1])"
)
def choose(
    loops: Float, nominal: Float, rates: Float, settings: Float, p: Float, current: float, scores: Float
) -> int:
    """Return the coil that would leave the least uncertainty, from 1; fill the scores (page MM 4.5 step 4)."""
    h, r, value, zero = np.zeros((3, p.shape[0])), np.zeros((3, 3)), np.empty(3), np.zeros(3)
    white = expected_variance(settings)
    best, least = 0, math.inf
    for coil in range(int(settings[_COILS])):
        predict_pulse(loops, float(coil), current, 0.0, nominal, rates, value, h)
        size = value[0] * value[0] + value[1] * value[1] + value[2] * value[2]
        for i in range(3):
            r[i, i] = white + settings[_GAIN] ** 2 * size
        score = score_after(p, h, r, zero, settings[_LIMIT_P], settings[_LIMIT_A])
        if coil < 3:
            scores[coil] = score
        if score < least:
            best, least = coil + 1, score
    return best


@step("float64(float64[:, ::1], float64, float64[::1], float64[::1], float64[::1], float64[:, ::1], float64)")
def choose_current(
    loops: Float, coil: float, nominal: Float, rates: Float, settings: Float, p: Float, target: float
) -> float:
    """Return the least current whose pulse brings the score of its coil to a target, at most the set one."""
    h, r, value, zero = np.zeros((3, p.shape[0])), np.zeros((3, 3)), np.empty(3), np.zeros(3)
    white = expected_variance(settings)
    low, high = settings[_LEAST], settings[_CURRENT_SET]
    for _ in range(10):
        middle = 0.5 * (low + high)
        predict_pulse(loops, coil, middle, 0.0, nominal, rates, value, h)
        size = value[0] * value[0] + value[1] * value[1] + value[2] * value[2]
        for i in range(3):
            r[i, i] = white + settings[_GAIN] ** 2 * size
        if score_after(p, h, r, zero, settings[_LIMIT_P], settings[_LIMIT_A]) <= target:
            high = middle
        else:
            low = middle
    return float(high)


@step(
    "void(float64[:, ::1], float64[::1], float64[::1], float64[::1], float64[:, ::1], float64[::1], int64[::1],"
    "float64[::1])"
)
def decide(
    loops: Float,
    settings: Float,
    rates: Float,
    nominal: Float,
    p: Float,
    memory: Float,
    counters: NDArray[np.int64],
    out: Float,
) -> None:
    """Ask for a pulse when the uncertainty passes its limit (method page 3.10) and the source may do one more."""
    if counters[_PENDING] > 0 or counters[_PULSE_LENGTH] > 0:
        return
    coil, ticks = 0, settings[_ON]
    current = settings[_CURRENT_SET]
    if counters[_PHASE] == _GATHER and counters[_BURST_COIL] < 3:
        # A burst that came unasked while waiting is no reason to ask for the rest of it.
        is_over = counters[_TICK] >= counters[_WAIT_UNTIL]
        if is_over and counters[_QUIET] >= settings[_START_OFF]:
            coil, ticks = counters[_BURST_COIL] + 1, settings[_START_ON]
    elif counters[_PHASE] == _TRACK and counters[_QUIET] >= settings[_OFF]:
        if settings[_FIXED] > 0.0:
            if counters[_TICK] - counters[_LAST_REQUEST] >= settings[_FIXED]:
                coil = int(counters[_PULSES] % int(settings[_COILS])) + 1
        else:
            scale = 1.0
            if settings[_BY_DISTANCE] > 0.0:
                r = math.sqrt(nominal[_P] ** 2 + nominal[_P + 1] ** 2 + nominal[_P + 2] ** 2)
                scale = min(1.5, max(0.5, r / 0.4))
            above = False
            for i in range(3):
                above = above or p[_EP + i, _EP + i] > (scale * settings[_LIMIT_P]) ** 2
                above = above or p[_ET + i, _ET + i] > (scale * settings[_LIMIT_A]) ** 2
            if above:
                scores = np.full(3, np.inf)
                coil = choose(loops, nominal, rates, settings, p, current, scores)
                for i in range(3):
                    out[_O_SCORES + i] = scores[i]
                if coil > 0 and settings[_ADAPTIVE] > 0.0:
                    now = 0.0
                    for i in range(3):
                        now += p[_EP + i, _EP + i] / settings[_LIMIT_P] ** 2
                        now += p[_ET + i, _ET + i] / settings[_LIMIT_A] ** 2
                    least = scores[coil - 1]
                    target = least + (1.0 - settings[_CURRENT_SHARE]) * (now - least)
                    current = choose_current(loops, float(coil - 1), nominal, rates, settings, p, target)
    if coil > 0 and affordable(settings, memory, ticks, current):
        out[_O_COIL], out[_O_CURRENT], out[_O_TICKS] = float(coil), current, ticks
        counters[_PENDING] = coil
        counters[_REQUESTED] = counters[_TICK]
        counters[_LAST_REQUEST] = counters[_TICK]
