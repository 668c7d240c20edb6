"""How far our own filter trusts the magnetic field, and where north is under several hypotheses."""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import Scalars3, multiply, normalized, wrapped
from estimators.kernels import Record, borrowing
from estimators.orientation.telemotion._block import INNOVATION, VARIANCE, absorb
from estimators.orientation.telemotion._records import FIELD, IRON, LEAST_LEVEL, START, STATES, TURN
from estimators.recording import Float

_OWN_UNCERTAINTY = 0.5
"""Share of the predicted variance that a residual may have for free: all of it would let a disturbance in
whenever the filter is unsure, none would shut out the field that could make it sure."""
_TOLD_UNCERTAINTY = 0.05
_LARGEST_MISFIT = 100.0
_IRON_SMALLEST = 25.0
"""Squared microtesla: smaller residuals are left to the robust weight."""
_IRON_SPREAD = 0.15
_UNLIKELY = 0.1
"""A hypothesis below this adds its distance, but not its own variance, to the variance of the heading."""
_LARGEST_VARIANCE = 1.0
_NO_BELIEF = math.log(1.0 / 3.0)
HYPOTHESES = 9
_H_TURN, _H_FIELD, _H_IRON, _H_START, _SUB = 0, 3, 5, 8, 11
"""States that a hypothesis moves: turn, horizontal field, hard iron, field at the start."""
_X, _Y, _Z = _H_TURN, _H_TURN + 1, _H_TURN + 2
_EAST, _NORTH, _START_EAST, _START_NORTH = _H_FIELD, _H_FIELD + 1, _H_START, _H_START + 1
_LIKELY, _HEADING, _OF_HEADING, _TILT_X, _TILT_Y, _RESULTS = range(6)
"""What is found for each: log likelihood, heading and its variance, small tilt."""
_STARTS = 3
"""Hypotheses on the start place to each on hard iron."""
_TABLE = _SUB * (_SUB + 1)
_FOUND = 3 * _TABLE
WORK = _FOUND + _RESULTS * HYPOTHESES


@borrowing()
def _doubt_field(p: Float, memory: Record, settings: Record, slow: float, time_s: float) -> None:
    """Learn how far the field wanders from its mean, of its `slow` squared residual; doubt a young mean as it grows.

    In the first seconds of movement nothing contradicts the field that is met: heading and iron follow it. Where it
    then turns out to wander, what those seconds said of it is worth no more than one place of many.
    """
    gain = -math.expm1(-time_s / settings.wander_level_s)
    memory.wander += gain * (min(slow / 3.0, _LARGEST_MISFIT) - memory.wander)
    grown = memory.wander - memory.wander_doubted
    if grown > 0.0:
        memory.wander_doubted = memory.wander
        grown *= settings.wander_doubt * math.exp(-((memory.moved_s / settings.wander_doubt_s) ** 2))
        for a in range(3):
            p[(STATES + 1) * (FIELD + a)] += grown


@borrowing()
def field_variance(p: Float, memory: Record, settings: Record, time_s: float, rest: bool) -> float:
    """Weigh the block's field by its residual, now and of late; return the variance of each component.

    The residual is held against `FIELD_SCALE` and a share of what the filter itself does not know.
    """
    per_field, per_sample = 1.0 / memory.field_count, 1.0 / memory.count
    if memory.rest_s == 0.0:
        memory.start_share *= math.exp(-time_s / settings.start_leaving_s)
        if memory.start_share < 1e-6:
            memory.start_share = 0.0
    share = memory.start_share
    if not rest and share < 0.5:
        memory.moved_s += time_s
    squares = predicted = slow = 0.0
    seen = 0.0
    if memory.moved_s > settings.wander_begin_s:
        seen = -math.expm1(-time_s / settings.wander_s)
    for a in range(3):
        residual = memory.sum_field[a] * per_field - memory.field[a] - share * memory.start[a]
        squares += residual * residual
        memory.slow_residual[a] += seen * (residual - memory.slow_residual[a])
        slow += memory.slow_residual[a] ** 2
        field, iron, start = STATES * (FIELD + a), STATES * (IRON + a), STATES * (START + a)
        predicted += p[field + FIELD + a] + p[iron + IRON + a]
        predicted += share * (share * p[start + START + a] + 2.0 * p[field + START + a])
        for b in range(3):
            turned = memory.sum_rotation[3 * a + b] * per_sample
            predicted += 2.0 * turned * (p[field + IRON + b] + share * p[start + IRON + b])
    # What people are shown leaves less to the filter's own doubts, and nothing to its heading's.
    memory.misfit = squares / (3.0 * settings.field_scale + _TOLD_UNCERTAINTY * max(predicted, 0.0))
    east = memory.field[0] + share * memory.start[0]
    north = memory.field[1] + share * memory.start[1]
    across = memory.sum_field[0] * per_field * north - memory.sum_field[1] * per_field * east
    turned = across * across / (east * east + north * north + 1e-9)
    if not rest and share < 0.5:
        seen = -math.expm1(-time_s / settings.quiet_s)
        memory.quiet += seen * (min(0.5 * (squares - turned), _LARGEST_MISFIT) - memory.quiet)
    _doubt_field(p, memory, settings, slow, time_s)
    squares -= settings.turn_free * turned
    misfit = squares / (3.0 * settings.field_scale + _OWN_UNCERTAINTY * max(predicted, 0.0))
    gain = -math.expm1(-time_s / settings.field_level_s)
    memory.disturbance += gain * (min(misfit, _LARGEST_MISFIT) - memory.disturbance)
    noise = settings.field_noise_rest if rest else settings.field_noise_moving
    noise *= min(max(memory.quiet / settings.quiet_level, settings.quiet_least), 1.0)
    noise += share * (settings.field_noise_start - noise)
    doubt = 1.0 + max(misfit, memory.disturbance)
    if rest:
        doubt *= 1.0 + (memory.rest_s / settings.field_same_s) ** 2
    return float(noise * noise / time_s * doubt)


@borrowing()
def iron_changed(memory: Record, settings: Record, time_s: float) -> bool:
    """Say whether the residual has become a magnet's on the sensor: still in it while turning in the room."""
    gain = -math.expm1(-time_s / settings.iron_window_s)
    per_field, per_sample = 1.0 / memory.field_count, 1.0 / memory.count
    sensor_step = earth_step = size = 0.0
    share = memory.start_share
    for a in range(3):
        inside = 0.0
        for b in range(3):
            residual = memory.sum_field[b] * per_field - memory.field[b] - share * memory.start[b]
            inside += memory.sum_rotation[3 * b + a] * per_sample * residual
        residual = memory.sum_field[a] * per_field - memory.field[a] - share * memory.start[a]
        d = inside - memory.sensor_mean[a]
        memory.sensor_mean[a] += gain * d
        sensor_step += d * d
        size += memory.sensor_mean[a] ** 2
        d = residual - memory.earth_mean[a]
        memory.earth_mean[a] += gain * d
        earth_step += d * d
    memory.sensor_spread = (1.0 - gain) * (memory.sensor_spread + gain * sensor_step)
    memory.earth_spread = (1.0 - gain) * (memory.earth_spread + gain * earth_step)
    carried = (
        size > _IRON_SMALLEST
        and memory.sensor_spread < _IRON_SPREAD * size
        and memory.earth_spread > settings.iron_ratio * memory.sensor_spread
    )
    memory.iron_s = memory.iron_s + time_s if carried else 0.0
    if memory.iron_s <= 0.5 * settings.iron_window_s:
        return False
    memory.iron_s = 0.0
    memory.sensor_spread += size  # the window starts afresh
    return True


@borrowing()
def restless(memory: Record, settings: Record, time_s: float, rest: bool) -> bool:
    """Say whether the field changed at the first rest before it was trusted: somebody moves iron about.

    What was seen before then tells nothing, and a magnet on the sensor or near its place is as likely as none.
    """
    if memory.start_share < 0.5 or not rest:
        memory.steady_field[0] = np.nan
        return False
    per_field, per_sample = 1.0 / memory.field_count, 1.0 / memory.count
    change = 0.0
    raw = (0.0, 0.0, 0.0)
    for a in range(3):
        seen = memory.sum_field[a] * per_field
        for b in range(3):
            seen += memory.sum_rotation[3 * a + b] * per_sample * memory.iron[b]
        raw = (seen if a == 0 else raw[0], seen if a == 1 else raw[1], seen if a == 2 else raw[2])
        change += (seen - memory.steady_field[a]) ** 2
    if change <= settings.steady_change:
        memory.steady_s += time_s
        return False
    first = math.isnan(change)
    for a in range(3):
        memory.steady_field[a] = raw[a]
    if first or memory.steady_s >= settings.steady_trusted_s:
        return False
    memory.steady_s = 0.0
    memory.restless = 1.0
    return True


@borrowing()
def open_iron(
    p: Float,
    error: Float,
    rows: Float,
    memory: Record,
    index: NDArray[np.int64],
    value: Float,
    settings: Record,
    odds: Float,
) -> None:
    """Make the hard iron unknown again, having settled what it was before: its likeliest hypothesis."""
    narrow = odds[0] + odds[1] + odds[2]
    middle = odds[_STARTS] + odds[_STARTS + 1] + odds[_STARTS + 2]
    if memory.opened == 0 and max(narrow, middle) >= 1.0 - narrow - middle:
        variance = settings.iron_narrow if narrow >= middle else settings.iron_middle
        for a in range(3):
            index[a, 0], value[a, 0] = IRON + a, 1.0
            rows[INNOVATION, a] = memory.iron_known[a] - memory.iron[a]
            rows[VARIANCE, a] = variance + memory.iron_known_variance
        absorb(p, error, rows, index, value, 1)
    for a in range(3):
        p[(STATES + 1) * (IRON + a)] += settings.iron_wide
    memory.opened += 1
    memory.wander = 0.0  # what did not fit was the magnet's
    for a in range(3):
        memory.slow_residual[a] = 0.0


@borrowing("int64(int64)")
def _moved_state(i: int) -> int:
    """Return the error state in place `i` of those that a hypothesis moves."""
    if i < _H_FIELD:
        return TURN + i
    if i < _H_IRON:
        return FIELD + i - _H_FIELD
    if i < _H_START:
        return IRON + i - _H_IRON
    return START + i - _H_START


@borrowing("float64(float64[::1], int64, int64, float64, float64, float64)")
def _suppose(table: Float, first: int, row: int, target: float, own: float, wide: float) -> float:
    """Replace the prior variance `wide` of one state by `own`; return the change of the log likelihood.

    `table` holds, from `first` on, the covariance of the states and their shift, as one matrix of _SUB + 1
    rows. Given prior variance W, the prior s^2 equals W and a measurement of variance
    1 / (1 / s^2 - 1 / W).
    """
    variance = 1.0 / (1.0 / own - 1.0 / wide)
    at_row, at_shift = first + _SUB * row, first + _SUB * _SUB
    total = table[at_row + row] + variance
    innovation = target - table[at_shift + row]
    inverse = 1.0 / total
    for i in range(_SUB):
        table[at_shift + i] += table[at_row + i] * inverse * innovation
    # Turn about x and y is only shifted, and once the start place is looked at, so is the iron.
    for i in range(_Z, _SUB):
        if i != row and (row < _H_START or i < _H_IRON or i >= _H_START):
            factor = table[at_row + i] * inverse
            for j in range(_SUB):
                table[first + _SUB * i + j] -= factor * table[at_row + j]
    # Last, for the others need it as it was.
    factor = 1.0 - table[at_row + row] * inverse
    for j in range(_SUB):
        table[at_row + j] *= factor
    return float(0.5 * (math.log(wide / own * variance / total) - innovation * innovation * inverse))


@borrowing("UniTuple(float64, 3)(float64[:, ::1], float64)", inlined=True)
def _field_seen(cov: Float, part: float) -> Scalars3:
    """Return variances of the field east and north, with `part` of that at the start, and their covariance."""
    east = cov[_EAST, _EAST] + part * (2.0 * cov[_EAST, _START_EAST] + part * cov[_START_EAST, _START_EAST])
    across = cov[_NORTH, _START_NORTH]
    north = cov[_NORTH, _NORTH] + part * (2.0 * across + part * cov[_START_NORTH, _START_NORTH])
    crossed = cov[_EAST, _START_NORTH] + cov[_NORTH, _START_EAST] + part * cov[_START_EAST, _START_NORTH]
    return east, north, cov[_EAST, _NORTH] + part * crossed


@borrowing()
def find_north(p: Float, memory: Record, settings: Record, odds: Float, work: Float) -> None:
    """Weigh nine hypotheses on hard iron and start place; set CORRECTION and HEADING_VARIANCE.

    The filter itself runs with both wide. That hard iron was N(known, s^2) all along is then one more
    measurement (`_suppose`), and its likelihood against the wide prior follows from the same numbers. So
    one filter holds every hypothesis exactly, and a wrong first belief (a magnet on the sensor, iron under
    the table) costs nothing once turning has shown it.
    """
    region = settings.region_base + settings.region_share * memory.wander
    found = work[_FOUND:].reshape(_RESULTS, HYPOTHESES)
    for i in range(_SUB):
        source = STATES * _moved_state(i)
        for j in range(_SUB):
            work[_SUB * i + j] = p[source + _moved_state(j)]
        work[_SUB * _SUB + i] = 0.0
    best = -np.inf
    narrow_iron, middle_iron = settings.iron_narrow_odds, settings.iron_middle_odds
    narrow_start, middle_start = settings.start_narrow_odds, settings.start_middle_odds
    if memory.restless > 0.0:
        narrow_iron = middle_iron = narrow_start = middle_start = _NO_BELIEF
    kinds = 1 if memory.opened > 0 else 3  # once the iron has changed, what it was says nothing any more
    for h in range(HYPOTHESES):
        odds[h] = 0.0
        found[_LIKELY, h] = -np.inf
    for iron in range(kinds):
        own = settings.iron_narrow if iron == 0 else settings.iron_middle
        own += memory.iron_known_variance
        wide = settings.iron_wide + memory.iron_known_variance
        iron_odds = narrow_iron if iron == 0 else middle_iron
        if iron == 2:
            iron_odds = math.log1p(-math.exp(narrow_iron) - math.exp(middle_iron))
        for i in range(_TABLE):
            work[_TABLE + i] = work[i]
        if kinds > 1 and iron < 2:
            for a in range(3):
                target = memory.iron_known[a] - memory.iron[a]
                iron_odds += _suppose(work, _TABLE, _H_IRON + a, target, own, wide)
        for start in range(_STARTS):
            h = _STARTS * iron + start
            logarithm = iron_odds + (narrow_start if start == 0 else middle_start)
            if start == 2:
                logarithm = iron_odds + math.log1p(-math.exp(narrow_start) - math.exp(middle_start))
            for i in range(_TABLE):
                work[2 * _TABLE + i] = work[_TABLE + i]
            if start < 2:
                own_start = settings.start_narrow if start == 0 else settings.start_middle
                for a in range(3):
                    target = -memory.start[a]
                    logarithm += _suppose(
                        work, 2 * _TABLE, _H_START + a, target, own_start + region, settings.start_wide
                    )
            else:
                own_start = settings.start_wide
            cov = work[2 * _TABLE : 3 * _TABLE].reshape(_SUB + 1, _SUB)
            shift = cov[_SUB]
            part = region / (region + own_start)
            east = memory.field[0] + shift[_EAST] + part * (memory.start[0] + shift[_START_EAST])
            north = memory.field[1] + shift[_NORTH] + part * (memory.start[1] + shift[_START_NORTH])
            level = east * east + north * north + 1e-9
            by_east, by_north = north / level, -east / level
            of_east, of_north, of_both = _field_seen(cov, part)
            found[_LIKELY, h] = logarithm
            found[_HEADING, h] = math.atan2(east, north) + shift[_Z]
            found[_OF_HEADING, h] = (
                cov[_Z, _Z]
                + 2.0 * by_east * (cov[_Z, _EAST] + part * cov[_Z, _START_EAST])
                + 2.0 * by_north * (cov[_Z, _NORTH] + part * cov[_Z, _START_NORTH])
                + by_east * by_east * of_east
                + by_north * by_north * of_north
                + 2.0 * by_east * by_north * of_both
                + part * own_start / level
            )
            found[_TILT_X, h], found[_TILT_Y, h] = shift[_X], shift[_Y]
            best = max(best, logarithm)
    total = 0.0
    for h in range(_STARTS * kinds):
        odds[h] = math.exp(found[_LIKELY, h] - best)
        total += odds[h]
    cosine = sine = tilt_x = tilt_y = own_variance = counted = 0.0
    for h in range(_STARTS * kinds):
        odds[h] /= total
        cosine += odds[h] * math.cos(found[_HEADING, h])
        sine += odds[h] * math.sin(found[_HEADING, h])
        tilt_x += odds[h] * found[_TILT_X, h]
        tilt_y += odds[h] * found[_TILT_Y, h]
        if odds[h] > _UNLIKELY:
            own_variance += odds[h] * min(found[_OF_HEADING, h], _LARGEST_VARIANCE)
            counted += odds[h]
    heading = math.atan2(sine, cosine)
    scale = settings.heading_scale
    if memory.start_moving > 0.0 and memory.since_start < settings.convergence_ticks:
        scale = 1.0
    variance = scale * own_variance / counted
    for h in range(_STARTS * kinds):
        variance += odds[h] * wrapped(found[_HEADING, h] - heading) ** 2
    level = max(memory.field[0] ** 2 + memory.field[1] ** 2, LEAST_LEVEL)
    memory.heading_variance = variance + settings.wander_share * memory.wander / level
    # The small tilt of the hypotheses first, then the turn to north.
    w, x, y, z = multiply(
        math.cos(0.5 * heading), 0.0, 0.0, math.sin(0.5 * heading), 1.0, 0.5 * tilt_x, 0.5 * tilt_y, 0.0
    )
    w, x, y, z = normalized(w, x, y, z)
    memory.correction[0], memory.correction[1] = w, x
    memory.correction[2], memory.correction[3] = y, z
