"""Causes that stop or pause an exercise, looked at before any cue and without an estimate in between. Section 6."""

import math

import numpy as np

from estimators.guidance._cue_records import (
    ATTEMPT_COUNT,
    LIMIT,
    LOST,
    TIME,
    UNSURE,
    VALID_COUNT,
    WRONG_IN_A_ROW,
    Orders,
    Said,
    Spoken,
)
from estimators.guidance._records import Model, Work
from estimators.kernels import Record, step

_SIGMAS = 2.0


@step()
def _seen(
    stop: Record, settings: Record, state: Record, model: Model, work: Work, orders: Orders, said: Said
) -> tuple[float, float]:
    """Return what a rule looks at, and above what it holds; NaN where nothing is known."""
    cue = said.state[0]
    if stop.kind == LIMIT:
        sigma = work.sigma[stop.channel]
        doubt = _SIGMAS * (orders.unknown_sigma[stop.channel] if math.isnan(sigma) else sigma)
        return stop.side * work.y[stop.channel], stop.side * stop.limit - doubt
    # Numbers are reached, not passed.
    if stop.kind == VALID_COUNT:
        return float(cue.valid), stop.limit - 0.5
    if stop.kind == ATTEMPT_COUNT:
        return float(cue.attempts), stop.limit - 0.5
    if stop.kind == WRONG_IN_A_ROW:
        return float(cue.wrong_in_a_row), stop.limit - 0.5
    if stop.kind == TIME:
        return (state.tick - cue.since_tick) * settings.tick_s, stop.limit - 0.5 * settings.tick_s
    is_present, largest = False, np.nan
    for f in range(len(model.steering)):
        c = model.steering[f]
        if not math.isnan(work.y[c]):
            is_present = True
            if model.turns[c] == 1 and not math.isnan(work.sigma[c]) and not work.sigma[c] <= largest:
                largest = work.sigma[c]
    if stop.kind == UNSURE:
        return largest, stop.limit
    return (0.0 if is_present else 1.0), 0.5


@step()
def guard(
    settings: Record, state: Record, model: Model, work: Work, orders: Orders, said: Said, spoken: Spoken
) -> None:
    """Hold every stop rule against this tick; the first that fires stops until somebody resumes by hand."""
    cue = said.state[0]
    if cue.stopped == 1:
        return
    for r in range(len(orders.stops)):
        stop, held = orders.stops[r], said.stops[r]
        value, above = _seen(stop, settings, state, model, work, orders, said)
        if not value > above:
            held.held_s = 0.0
            continue
        held.held_s += settings.tick_s
        if held.held_s < stop.hold_s - 1e-9 or held.was_fired == 1:
            continue
        # Reached numbers and times stay reached: they fire once.
        if stop.kind in (VALID_COUNT, ATTEMPT_COUNT, TIME):
            held.was_fired = 1
        row = spoken.counts[1]
        one = spoken.stops[row]
        one.tick, one.rule, one.limit = state.tick, r, stop.limit
        one.value = stop.side * value if stop.kind == LIMIT else value
        if stop.kind == LOST:
            one.value = held.held_s
        spoken.counts[1] = row + 1
        cue.stopped = 1
        return
