"""Which cue is due: rules held against what is measured, and silence. Section 5 and equation (10)."""

import math

import numpy as np

from estimators.guidance._cue_records import (
    AT_EQUAL,
    FAST,
    RANGE,
    SLOW,
    Orders,
    Said,
    Spoken,
)
from estimators.guidance._records import PARTIAL, VALID, Memory, Model, Work
from estimators.kernels import Record, step

_ALIKE_RAD = 0.07
"""Values of the other channel that count as equal."""
_PAST, _BACK = 0.08, 0.15
_LEFT_SHARE, _TIMED_SHARE, _LAST_SHARE = 0.1, 0.75, 0.95
"""Of the first target: between them its pace is read; who is past the last of them was not seen on the way."""
_LEAST_STRETCH = 0.03


@step()
def begin_attempt(phase: float, said: Said) -> None:
    """Forget what was said in the attempt before; this one is followed from a phase on."""
    state = said.state[0]
    state.said, state.moved_s, state.left_tick, state.is_timed = 0, 0.0, -1, 0
    state.begun_phase = phase
    for r in range(len(said.rules)):
        said.rules[r].held_s = 0.0
        said.rules[r].was_said = 0


@step()
def _say(
    state: Record,
    spoken: Spoken,
    tick: int,
    attempt: int,
    phase: float,
    rule: int,
    value: float,
    limit: float,
) -> None:
    row = spoken.counts[0]
    one = spoken.cues[row]
    one.tick, one.rule, one.attempt, one.phase = tick, rule, attempt, phase
    one.value, one.limit = value, limit
    spoken.counts[0] = row + 1
    state.last_tick = tick


@step()
def _sigma(c: int, orders: Orders, work: Work) -> float:
    return float(orders.unknown_sigma[c] if math.isnan(work.sigma[c]) else work.sigma[c])


@step()
def _beyond(side: int, d: float, below: float, above: float) -> float:
    """Return by how much a deviation is out of its tolerance on the side that counts; negative inside."""
    if side > 0:
        return d - above
    if side < 0:
        return -d - below
    return max(d - above, -d - below)


@step()
def _deviation(
    rule: Record, state: Record, model: Model, memory: Memory, orders: Orders, work: Work
) -> tuple[float, float, float]:
    """Return value, tolerance and how far beyond it, less z sigma: equation (10)."""
    c = rule.channel
    phases = model.whole.shape[0]
    place = min(max(state.phase * phases - 0.5, 0.0), phases - 1.0)
    low = min(int(place), phases - 2)
    first, second = model.whole[low, c], model.whole[low + 1, c]
    d = work.y[c] - memory.start[c] - (first + (place - low) * (second - first))
    if model.turns[c] == 1 and model.absolute[c] == 1:
        d -= 2.0 * math.pi * np.rint(d / (2.0 * math.pi))
    here = min(int(place + 0.5), phases - 1)
    below = orders.below[here, c] if math.isnan(rule.tolerance) else rule.tolerance
    above = orders.above[here, c] if math.isnan(rule.tolerance) else rule.tolerance
    sigma = math.hypot(_sigma(c, orders, work), (second - first) * phases * min(state.sigma, 0.04))
    limit = above if d > 0.0 else below
    return d, limit, _beyond(rule.side, d, below, above) - orders.settings[0].z * sigma


@step()
def _at_equal(rule: Record, model: Model, orders: Orders, work: Work) -> tuple[float, float, float]:
    """Return the same against the template where another channel is equal: a wrong plane says nothing of phase."""
    c, other = rule.channel, rule.against
    at = work.y[other]
    # NaN compares false.
    if not at >= rule.least:
        return np.nan, rule.tolerance, np.nan
    nearest, gap = 0, np.inf
    smallest = np.nan
    for b in range(model.whole.shape[0]):
        apart = abs(model.whole[b, other] + orders.origin[other] - at)
        d = work.y[c] - model.whole[b, c] - orders.origin[c]
        if math.isnan(d) or math.isnan(apart):
            continue
        d -= 2.0 * math.pi * np.rint(d / (2.0 * math.pi))
        if apart < gap:
            nearest, gap = b, apart
        if apart < _ALIKE_RAD and not abs(d) >= abs(smallest):
            smallest = d
    if math.isnan(smallest):
        smallest = work.y[c] - model.whole[nearest, c] - orders.origin[c]
        smallest -= 2.0 * math.pi * np.rint(smallest / (2.0 * math.pi))
    excess = _beyond(rule.side, smallest, rule.tolerance, rule.tolerance)
    return smallest, rule.tolerance, excess - orders.settings[0].z * _sigma(c, orders, work)


@step()
def _range(
    rule: Record,
    settings: Record,
    state: Record,
    model: Model,
    memory: Memory,
    orders: Orders,
    work: Work,
    cue: Record,
) -> tuple[float, float, float]:
    """Return the same of a target that was missed: seen after the turn, on the way back.

    Nothing is known of a target that lay behind when the attempt began, as where a wrong movement goes over into the
    way back; and what is too little to be counted is no attempt at a target.
    """
    main = settings.main
    now = work.y[main] - memory.start[main]
    worst, value = -np.inf, np.nan
    if math.isnan(now):
        return value, rule.tolerance, np.nan
    sigma = _sigma(main, orders, work)
    for k in range(len(memory.quotient)):
        phase, offset = model.target[k, 0], model.target[k, 1]
        q = memory.quotient[k]
        is_past = state.phase > phase + _PAST and now / offset < (1.0 - _BACK) * q
        is_tried = cue.begun_phase < phase and q >= settings.least_excursion
        if is_past and is_tried and rule.first <= phase <= rule.last:
            excess = rule.tolerance - q - orders.settings[0].z * sigma / abs(offset)
            if excess > worst:
                worst, value = excess, q
    return value, rule.tolerance, worst


@step()
def _phase_at(share: float, main: int, model: Model) -> float:
    """Return the phase at which the template first attains a share of its first target."""
    phases, target = model.whole.shape[0], model.target[0, 1]
    before = 0.0
    for b in range(phases):
        now = model.whole[b, main] / target
        if now >= share:
            part = (share - before) / (now - before) if now > before else 1.0
            return float(max(b - 0.5 + part, 0.0) / phases)
        before = now
    return math.nan


@step()
def _leave(settings: Record, state: Record, model: Model, memory: Memory, work: Work, cue: Record) -> None:
    """Note when, and at which share of the first target, the attempt is seen to leave its start posture."""
    now = (work.y[settings.main] - memory.start[settings.main]) / model.target[0, 1]
    if cue.left_tick < 0 and now >= _LEFT_SHARE:
        cue.left_tick, cue.left_share = state.tick, now


@step()
def _fast(
    rule: Record,
    settings: Record,
    state: Record,
    model: Model,
    memory: Memory,
    orders: Orders,
    work: Work,
    cue: Record,
) -> tuple[float, float, float]:
    """Return the same of the time between two shares of the first target.

    Both are read where the main channel is, in the patient and in the template: the phase is hardly known so early.
    """
    limit = 1.0 / rule.tolerance
    main, target = settings.main, model.target[0, 1]
    now = (work.y[main] - memory.start[main]) / target
    # NaN compares false.
    if cue.is_timed == 1 or cue.left_tick < 0 or not now >= _TIMED_SHARE:
        return np.nan, limit, np.nan
    cue.is_timed = 1
    first, last = _phase_at(cue.left_share, main, model), _phase_at(now, main, model)
    stretch = last - first
    if now > _LAST_SHARE or not stretch >= _LEAST_STRETCH:
        return np.nan, limit, np.nan
    ratio = (state.tick - cue.left_tick) * settings.tick_s * settings.pace / stretch
    off = _sigma(main, orders, work) / abs(target)
    unsure = math.hypot(
        first - _phase_at(cue.left_share - off, main, model), last - _phase_at(now - off, main, model)
    )
    return ratio, limit, limit - ratio - orders.settings[0].z * ratio * unsure / stretch


@step()
def watch(
    settings: Record,
    state: Record,
    model: Model,
    memory: Memory,
    work: Work,
    orders: Orders,
    said: Said,
    spoken: Spoken,
) -> None:
    """Hold every rule against this update of an attempt, and give the one cue that is due."""
    cue, of = said.state[0], orders.settings[0]
    if state.v > of.moving_speed + state.rest_v:
        cue.moved_s += settings.update_s
    _leave(settings, state, model, memory, work, cue)
    best = -1
    for r in range(len(orders.rules)):
        rule, held = orders.rules[r], said.rules[r]
        if rule.is_on == 0 or held.was_said == 1 or rule.quantity == SLOW:
            continue
        value, limit, excess = np.nan, np.nan, np.nan
        if rule.quantity == AT_EQUAL:
            value, limit, excess = _at_equal(rule, model, orders, work)
        elif rule.quantity == RANGE:
            value, limit, excess = _range(rule, settings, state, model, memory, orders, work, cue)
        elif rule.quantity == FAST:
            value, limit, excess = _fast(rule, settings, state, model, memory, orders, work, cue)
        elif rule.first <= state.phase <= rule.last:
            value, limit, excess = _deviation(rule, state, model, memory, orders, work)
        if not excess > 0.0:
            held.held_s = 0.0
            continue
        held.held_s += settings.update_s
        held.value, held.limit = value, limit
        if held.held_s >= rule.hold_s - 1e-9 and (best < 0 or rule.priority < orders.rules[best].priority):
            best = r
    if best < 0 or cue.stopped == 1 or cue.attempts % of.cue_every != 0:
        return
    if cue.last_tick >= 0 and state.tick - cue.last_tick < of.silence_ticks:
        return
    said.rules[best].was_said = 1
    cue.said += 1
    _say(
        cue,
        spoken,
        state.tick,
        state.attempt,
        state.phase,
        best,
        said.rules[best].value,
        said.rules[best].limit,
    )


@step()
def _in_the_end(
    quantity: int, value: float, state: Record, orders: Orders, cue: Record, spoken: Spoken
) -> bool:
    """Say the first rule of this quantity whose tolerance the value exceeds; False where there is none."""
    for r in range(len(orders.rules)):
        rule = orders.rules[r]
        off = value - rule.tolerance if quantity == SLOW else rule.tolerance - value
        if rule.is_on == 1 and rule.quantity == quantity and off > 0.0:
            cue.said += 1
            _say(cue, spoken, state.tick, state.attempt, 1.0, r, value, rule.tolerance)
            return True
    return False


@step()
def conclude(
    settings: Record, state: Record, kind: int, share: float, orders: Orders, said: Said, spoken: Spoken
) -> None:
    """At the end of an attempt in which nothing else was said: a joint that did not come along, too slow, praise.

    `share` is how far the joint went that went least, of its way in the template; NaN where all came along.
    """
    cue, of = said.state[0], orders.settings[0]
    if cue.stopped == 1 or cue.said > 0 or kind not in (VALID, PARTIAL):
        return
    is_turn = cue.attempts % of.cue_every == 0
    is_silence = cue.last_tick >= 0 and state.tick - cue.last_tick < of.silence_ticks
    if is_turn and not is_silence:
        # NaN compares false.
        if _in_the_end(RANGE, share, state, orders, cue, spoken):
            return
        if _in_the_end(SLOW, cue.moved_s / of.template_moves_s, state, orders, cue, spoken):
            return
    if kind == VALID and of.praise_every > 0:
        cue.silent_valid += 1
        if cue.silent_valid >= of.praise_every and not is_silence:
            cue.silent_valid = 0
            _say(cue, spoken, state.tick, state.attempt, 1.0, -1, np.nan, np.nan)
