"""A sensor that stops measuring and repeats what it last gave: one value, or one block of values."""

import math
from typing import Final

from estimators.kernels import borrowing
from estimators.recording import Float

SAMPLE_FROZEN, FIELD_FROZEN = 1, 2

_FEWEST_CHANGES: Final = 50.0
"""Changes of a triad in movement, and rates that went back and forth by noise, before a freeze can be certain."""
_USUAL_TIMES: Final = 3.0
_USUAL_WHOLE_TIMES: Final = 5.0
"""A freeze is so many times longer than the sensor ever repeated itself."""
_LEAST_S: Final = 0.05
_LEAST_FIELD_S: Final = 0.2
_LEAST_WHOLE_S: Final = 0.25
"""Public recordings hold a row for 20 ms where the radio lost one; magnetometers are slower than the rest."""
_TURNING_RADPS: Final = 0.5
"""Nothing that turns at this rate gives the same three numbers again and again."""
_SEEN_TURNING_RADPS: Final = 0.35
"""More than the bias of a usable gyroscope: the others must change."""
_MOVED_MPS2: Final = 1.0
_TURNED_RAD: Final = 0.35
_LEAST_BLOCK: Final = 8
_KEYS: Final = 32
"""The longest block that is looked for, samples."""

_SAME: Final = 1e-9
_SAME_FIELD_T: Final = 1e-14
"""Averages over ticks of one value agree to this; different counts of a device do not."""

_LAST_RATE, _LAST_FORCE, _LAST_FIELD = 0, 3, 6
_RUN, _MOVED, _USUAL, _CHANGES = 9, 12, 15, 18
_FORCE_FROM, _TURNED, _TURNED_FIELD = 21, 24, 27
_WHOLE_USUAL, _NOISE, _CHANGE = 28, 29, 30
_RATE, _FORCE, _FIELD = range(3)
_LAG, _MATCHES, _BLOCK_RATE, _NEXT, _KEY = 33, 34, 35, 36, 37
MEMORY = _KEY + _KEYS
"""Per sensor: last values of the three triads; per triad for how long it has repeated itself, for how long of that it
should have moved, the longest such time that was none of a freeze, and its changes in movement; what the others did
meanwhile; the same of the whole sensor; the last change of rate; and keys of the last samples."""


@borrowing("float64(float64[::1], float64[:], float64[:])")
def _block(m: Float, rate: Float, force: Float) -> float:
    """Return for how many samples the sensor has repeated a block of some samples, or zero."""
    key = norm = 0.0
    for a in range(3):
        # Any mixture will do: equal samples have equal keys, others have not.
        key += (1.0 + 0.6180339887 * a) * rate[a] + (0.3141592653 + 0.1732050807 * a) * force[a]
        norm += rate[a] * rate[a]
    at, lag = int(m[_NEXT]), int(m[_LAG])
    m[_NEXT] = (at + 1) % _KEYS
    if lag == 0 or abs(m[_KEY + (at - lag) % _KEYS] - key) > _SAME:
        lag = alike = 0
        # Hardly any sample is like one of these: looked for in the order of memory, several at a time.
        for place in range(_KEYS):
            alike += abs(m[_KEY + place] - key) <= _SAME
        if alike:
            for candidate in range(2, _KEYS):
                if lag == 0 and abs(m[_KEY + (at - candidate) % _KEYS] - key) <= _SAME:
                    lag = candidate
        m[_LAG], m[_MATCHES], m[_BLOCK_RATE] = lag, 0.0, 0.0
    m[_KEY + at] = key
    if lag == 0:
        return 0.0
    m[_MATCHES] += 1.0
    m[_BLOCK_RATE] = max(m[_BLOCK_RATE], norm)
    if m[_MATCHES] < max(lag, _LEAST_BLOCK) or m[_BLOCK_RATE] < _TURNING_RADPS**2:
        return 0.0
    return float(m[_MATCHES])


@borrowing("void(float64[::1])", inlined=True)
def forget(m: Float) -> None:
    """Begin again after a sample that is missing; what is usual stays known."""
    for i in range(_LAST_RATE, _RUN):
        m[i] = math.nan
    for t in range(3):
        m[_RUN + t] = m[_MOVED + t] = 0.0
    m[_LAG] = m[_MATCHES] = m[_CHANGE] = m[_CHANGE + 1] = m[_CHANGE + 2] = 0.0


@borrowing("UniTuple(float64, 2)(float64[::1], float64[:], float64[:], float64[:], boolean, float64)")
def frozen(
    m: Float, rate: Float, force: Float, field: Float, has_field: bool, step_s: float
) -> tuple[float, float]:
    """Take the next sample; return for how many samples, up to this, the sensor and its field have been frozen.

    Parameters
    ----------
    m : ndarray, shape (MEMORY,)
        Carried on.
    rate, force, field : ndarray, shape (3,)
        Finite but for the field.

    Notes
    -----
    Repeated values alone are no freeze: a slow magnetometer is held between its samples, a coarse sensor at rest gives
    one count for long, a radio repeats a row. It is one where the sensor moves, as itself or another triad says, for
    several times as long as the triad has ever repeated itself in movement; or where all triads stand still at once
    for longer than they ever did, noise and all.
    """
    turning = reverse = moved = across = 0.0
    same_rate, same_force, same_field = True, True, True
    for a in range(3):
        turning += rate[a] * rate[a]
        change = rate[a] - m[_LAST_RATE + a]
        same_rate &= abs(change) <= _SAME
        same_force &= abs(force[a] - m[_LAST_FORCE + a]) <= _SAME
        same_field &= has_field and abs(field[a] - m[_LAST_FIELD + a]) <= _SAME_FIELD_T
        reverse += change * m[_CHANGE + a]
        if abs(change) > _SAME:
            m[_CHANGE + a] = change
    if reverse < 0.0:
        m[_NOISE] += 1.0
    turning = math.sqrt(turning)
    if not same_rate:
        for a in range(3):
            m[_FORCE_FROM + a] = force[a]
    if not same_force:
        m[_TURNED] = m[_TURNED + 1] = m[_TURNED + 2] = 0.0
    if not same_field:
        m[_TURNED_FIELD] = 0.0
    seen = turning > _SEEN_TURNING_RADPS
    if seen:
        m[_TURNED_FIELD] += turning * step_s
        for a in range(3):
            m[_TURNED + a] += rate[a] * step_s
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        moved += (force[a] - m[_FORCE_FROM + a]) ** 2
        across += (force[b] * m[_TURNED + c] - force[c] * m[_TURNED + b]) ** 2
        m[_LAST_RATE + a], m[_LAST_FORCE + a] = rate[a], force[a]
        m[_LAST_FIELD + a] = field[a] if has_field else math.nan
    noisy = m[_NOISE] >= _FEWEST_CHANGES
    whole = min(m[_RUN + _RATE], m[_RUN + _FORCE])
    lasts = field_lasts = 0.0
    for t in range(3):
        same, moves, shown, least_s = same_rate, turning > _TURNING_RADPS, noisy, _LEAST_S
        if t == _RATE:
            moves |= moved > _MOVED_MPS2**2
        elif t == _FORCE:
            same, moves, shown = same_force, seen, across > _MOVED_MPS2**2
        else:
            same, moves, least_s = same_field, seen, _LEAST_FIELD_S
            shown = m[_TURNED_FIELD] > _TURNED_RAD
        least = max(_USUAL_TIMES * m[_USUAL + t] + 2.0, least_s / step_s)
        if same:
            m[_RUN + t] += 1.0
            if moves:
                m[_MOVED + t] += 1.0
            if shown and m[_CHANGES + t] >= _FEWEST_CHANGES and m[_MOVED + t] > least:
                if t != _FIELD:
                    lasts = max(lasts, m[_RUN + t])
                else:
                    field_lasts = m[_RUN + t]
            continue
        if moves or m[_MOVED + t] > 0.0:
            if m[_MOVED + t] <= least or m[_CHANGES + t] < _FEWEST_CHANGES:
                m[_USUAL + t] = max(m[_USUAL + t], m[_MOVED + t])
            m[_CHANGES + t] += 1.0
        m[_RUN + t] = m[_MOVED + t] = 0.0
    least = max(_USUAL_WHOLE_TIMES * m[_WHOLE_USUAL] + 2.0, _LEAST_WHOLE_S / step_s)
    if same_rate and same_force and (same_field or not has_field):
        whole = min(m[_RUN + _RATE], m[_RUN + _FORCE])
        if noisy and whole > least:
            lasts = max(lasts, whole)
    elif whole <= least or not noisy:
        m[_WHOLE_USUAL] = max(m[_WHOLE_USUAL], whole)
    repeats = _block(m, rate, force)
    if noisy and repeats > 0.0:
        lasts = max(lasts, repeats)
    return lasts, field_lasts
