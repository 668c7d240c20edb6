"""Repetitions counted as they end: valid, partial, wrong, ignored. Section 4 and equation (9)."""

import math

from estimators.guidance._cue_kernel import begin_attempt, conclude, watch
from estimators.guidance._cue_records import Orders, Said, Spoken
from estimators.guidance._records import (
    IGNORED,
    PARTIAL,
    VALID,
    WRONG,
    Memory,
    Model,
    Out,
    Work,
)
from estimators.kernels import Record, step

_LATE, _EARLY = 0.85, 0.25
_WRONG_BEGINS, _WRONG_ENDS = 0.5, 0.3


@step()
def _begin(state: Record, memory: Memory, said: Said) -> None:
    state.in_attempt = 1
    state.attempt += 1
    state.attempt_tick = state.tick
    state.updates = 0
    state.wrong_sum, state.stiff_sum = 0.0, 0.0
    state.was_late = 0
    state.was_wrong = 0
    memory.reached[:] = 0.0
    memory.quotient[:] = 0.0
    begin_attempt(state.phase, said)


@step()
def _excursion(model: Model, memory: Memory) -> float:
    """Return how far the attempt went, as a share of the template's."""
    total, weight = 0.0, 0.0
    for f in range(len(model.weight)):
        total += model.weight[f] * memory.reached[f] / model.excursion[f]
        weight += model.weight[f]
    return total / weight


@step()
def _main_was_seen(settings: Record, model: Model, memory: Memory) -> bool:
    """Tell whether the main channel was known at any time of the attempt; one that does not steer is not looked at."""
    for f in range(len(model.steering)):
        if model.steering[f] == settings.main:
            return bool(memory.reached[f] > 0.0)
    return True


@step()
def _least_share(model: Model, memory: Memory) -> float:
    """Return how far the joint went that went least of its way, of those that move most."""
    least = 1.0
    for f in range(len(model.weight)):
        if model.weight[f] >= 1.0:
            least = min(least, memory.reached[f] / model.excursion[f])
    return least


@step()
def _learn_size(state: Record, model: Model, memory: Memory) -> None:
    """Equation (7): after the turn the size of a repetition is no guess, it was measured."""
    size = 0.0
    for k in range(len(memory.quotient)):
        size += memory.quotient[k] / len(memory.quotient)
    state.finished += 1
    for a in range(len(model.sizes)):
        width = model.sizes[1] - model.sizes[0]
        held = min(max(size, model.sizes[0]), model.sizes[-1])
        share = max(0.0, 1.0 - abs(held - model.sizes[a]) / width)
        memory.size_mean[a] += (share - memory.size_mean[a]) / state.finished


@step()
def _finish(
    settings: Record,
    state: Record,
    model: Model,
    memory: Memory,
    out: Out,
    orders: Orders,
    said: Said,
    spoken: Spoken,
) -> None:
    state.in_attempt = 0
    excursion = _excursion(model, memory)
    wrong = state.wrong_sum / max(state.updates, 1)
    kind = VALID
    for k in range(len(memory.quotient)):
        if memory.quotient[k] < settings.valid_share:
            kind = PARTIAL
    stiff = state.stiff_sum / max(state.updates, 1)
    if stiff > settings.wrong_share:
        # One joint did not come along: the way was the right one, and not gone to its end.
        kind = PARTIAL
    if wrong > settings.wrong_share:
        kind = WRONG
    lasted_s = (state.tick - state.attempt_tick) * settings.tick_s
    # Of a main channel that was never known nothing can be counted.
    if not _main_was_seen(settings, model, memory):
        kind = IGNORED
    if excursion < settings.least_excursion or lasted_s < settings.least_attempt_s:
        kind = IGNORED
    if kind in (VALID, PARTIAL) and stiff <= settings.wrong_share:
        _learn_size(state, model, memory)
    share = _least_share(model, memory) if stiff > settings.wrong_share else math.nan
    conclude(settings, state, kind, share, orders, said, spoken)
    tally = said.state[0]
    tally.attempts += kind != IGNORED
    tally.valid += kind == VALID
    if kind != IGNORED:
        tally.wrong_in_a_row = tally.wrong_in_a_row + 1 if kind == WRONG else 0
    row = out.counts[0]
    one = out.repetitions[row]
    one.tick, one.kind, one.attempt, one.start_tick = state.tick, kind, state.attempt, state.attempt_tick
    one.wrong, one.stiff, one.excursion, one.size = wrong, stiff, excursion, state.size
    for k in range(len(memory.quotient)):
        out.quotients[row, k] = memory.quotient[k]
    out.counts[0] = row + 1


@step()
def count(
    settings: Record,
    state: Record,
    model: Model,
    memory: Memory,
    work: Work,
    out: Out,
    orders: Orders,
    said: Said,
    spoken: Spoken,
) -> None:
    """Follow the attempt that goes on, or begin one."""
    rests = state.p_rest > 0.5
    if state.in_attempt == 0:
        if rests:
            return
        _begin(state, memory, said)
    state.updates += 1
    state.wrong_sum += state.p_wrong
    state.stiff_sum += state.p_stiff * max(1.0 - state.p_rest - state.p_wrong, 0.0)
    for f in range(len(model.steering)):
        c = model.steering[f]
        away = abs(work.y[c] - memory.start[c])
        if away > memory.reached[f]:
            memory.reached[f] = away
    main = work.y[settings.main] - memory.start[settings.main]
    if not math.isnan(main):
        for k in range(len(memory.quotient)):
            memory.quotient[k] = max(memory.quotient[k], main / model.target[k, 1])
    if not rests:
        watch(settings, state, model, memory, work, orders, said, spoken)
    moves = state.p_rest + state.p_wrong < 0.5
    wrapped = moves and state.was_late == 1 and state.phase < _EARLY
    recovered = state.was_wrong == 1 and state.p_wrong < _WRONG_ENDS
    if rests or wrapped or recovered:
        _finish(settings, state, model, memory, out, orders, said, spoken)
        if not rests:
            _begin(state, memory, said)
    if moves and state.phase > _LATE:
        state.was_late = 1
    if state.p_wrong > _WRONG_BEGINS:
        state.was_wrong = 1
