"""The loop over ticks: stop rules, prompted rest, phase filter, counter and cues."""

import math

import numpy as np
from numba import types

from estimators.compiling import compiled
from estimators.guidance._channel_kernel import rest_speed, slopes, unwrap
from estimators.guidance._count_kernel import count
from estimators.guidance._cue_records import ORDERS, SAID, SPOKEN, Orders, Said, Spoken
from estimators.guidance._phase_kernel import update
from estimators.guidance._records import (
    ASTRAY,
    MEMORY,
    MODEL,
    OUTPUT,
    PHASE,
    REST,
    SETTINGS,
    SIGMA,
    SIZE,
    STATE,
    WORK,
    Memory,
    Model,
    Out,
    Work,
)
from estimators.guidance._stop_kernel import guard
from estimators.kernels import Record, rows, step
from estimators.recording import Float

_V_REST = 4.0
_SIGMA_CAP = 0.04


@step()
def _median(values: Float, count: int) -> float:
    """Return the median of the first `count`, which are sorted in place."""
    for i in range(1, count):
        value = values[i]
        j = i - 1
        while j >= 0 and values[j] > value:
            values[j + 1] = values[j]
            j -= 1
        values[j + 1] = value
    middle = count // 2
    return float(values[middle]) if count % 2 else 0.5 * float(values[middle - 1] + values[middle])


@step()
def _settle(settings: Record, state: Record, model: Model, memory: Memory, work: Work) -> None:
    """Take one tick of the prompted rest; after the last of them the start posture is known."""
    present = False
    for f in range(len(model.steering)):
        present |= not math.isnan(work.y[model.steering[f]])
    if not present:
        return
    memory.rest[state.rested] = work.y
    state.rested += 1
    if state.tick % settings.stride == 0:
        slopes(settings, state, model, memory, work.v)
        _, speed, weight = rest_speed(model, memory, work)
        if weight > 0.0:
            state.rest_v_count += 1
            state.rest_v += (_V_REST * speed - state.rest_v) / state.rest_v_count
    if state.rested < settings.rest_ticks:
        return
    for c in range(len(memory.start)):
        known = 0
        for i in range(settings.rest_ticks):
            if not math.isnan(memory.rest[i, c]):
                work.sorted[known] = memory.rest[i, c]
                known += 1
        if model.absolute[c] == 1:
            memory.start[c] = 0.0
        elif known > 0:
            memory.start[c] = _median(work.sorted, known)
    state.p_rest, state.p_wrong = 1.0, 0.0
    memory.mass[:] = 0.0
    state.in_attempt = 0


@step()
def _away(model: Model, memory: Memory, work: Work) -> float:
    """Return how far the body is from the start posture now, as a share of the template's excursion."""
    total, weight = 0.0, 0.0
    for f in range(len(model.steering)):
        d = work.y[model.steering[f]] - memory.start[model.steering[f]]
        if not math.isnan(d):
            total += model.weight[f] * abs(d) / model.excursion[f]
            weight += model.weight[f]
    return total / weight if weight > 0.0 else math.inf


@step()
def _follow_start(settings: Record, state: Record, model: Model, memory: Memory, work: Work) -> None:
    """Let the start posture follow while at rest, with a time constant.

    Who was prompted while still on the way to the start posture has a wrong one, in which no rest is ever found again.
    So standing still, nearer to it than any attempt that counts goes, is rest too, and the start posture is there.
    """
    is_still = state.v < settings.rest_speed + state.rest_v
    if state.p_rest > 0.5 or not is_still or _away(model, memory, work) >= settings.least_excursion:
        state.still_s = 0.0
    else:
        state.still_s += settings.update_s
    gain = settings.update_s / settings.start_follows_s
    if state.still_s >= settings.still_s:
        state.p_rest, state.p_wrong, state.still_s, gain = 1.0, 0.0, 0.0, 1.0
        memory.mass[:] = 0.0
    if state.p_rest > 0.5:
        for c in range(len(memory.start)):
            if model.absolute[c] == 0 and not math.isnan(work.y[c]):
                if math.isnan(memory.start[c]):
                    memory.start[c] = work.y[c]
                else:
                    memory.start[c] += gain * (work.y[c] - memory.start[c])


@step()
def _deviate(
    k: int, state: Record, model: Model, memory: Memory, work: Work, orders: Orders, out: Out
) -> None:
    """Equation (10): how far each channel is off the template at this phase, and how well that is known."""
    phases = model.whole.shape[0]
    place = min(max(state.phase * phases - 0.5, 0.0), phases - 1.0)
    low = min(int(place), phases - 2)
    share = place - low
    shaky = min(state.sigma, _SIGMA_CAP) * phases
    for c in range(len(memory.start)):
        first, second = model.whole[low, c], model.whole[low + 1, c]
        d = work.y[c] - memory.start[c] - (first + share * (second - first))
        if model.turns[c] == 1 and model.absolute[c] == 1:
            d -= 2.0 * math.pi * np.rint(d / (2.0 * math.pi))
        sigma = orders.unknown_sigma[c] if math.isnan(work.sigma[c]) else work.sigma[c]
        out.deviation[k, c] = d
        out.deviation_sigma[k, c] = math.hypot(sigma, (second - first) * shaky)


_TABLE = types.float64[:, ::1]


@step()
def _is_sound(values: Float, sigma: Float) -> bool:
    """Say whether values are finite or NaN, and sigma too and not negative."""
    for k in range(values.shape[0]):
        for c in range(values.shape[1]):
            if math.isinf(values[k, c]) or math.isinf(sigma[k, c]) or sigma[k, c] < 0.0:
                return False
    return True


@compiled(
    types.boolean(
        _TABLE, _TABLE, rows(SETTINGS), rows(STATE), MODEL, MEMORY, WORK, OUTPUT, ORDERS, SAID, SPOKEN
    )
)
def run(
    values: Float,
    sigma: Float,
    settings_row: Record,
    state_row: Record,
    model: Model,
    memory: Memory,
    work: Work,
    out: Out,
    orders: Orders,
    said: Said,
    spoken: Spoken,
) -> bool:  # pragma: no cover
    """Take the next ticks; False, and nothing was done, where they cannot be so.

    Parameters
    ----------
    values, sigma : ndarray, shape (N, C)
        NaN where nothing is known.
    settings_row : record array of `SETTINGS`, shape (1,)
    state_row : record array of `STATE`, shape (1,)
        Changed.
    memory : Memory
        Changed.
    out, spoken : Out, Spoken
        Written from the first row on.
    said : Said
        Changed.
    """
    if not _is_sound(values, sigma):
        return False
    settings, state = settings_row[0], state_row[0]
    out.counts[:] = 0
    spoken.counts[:] = 0
    for k in range(values.shape[0]):
        state.tick += 1
        unwrap(model, memory, values[k], work.y)
        # One by one: for arrays numba compiles the words of an error about shapes too, seconds of a first start;
        # `Guide.feed` has checked them.
        for i in range(len(work.sigma)):
            work.sigma[i] = sigma[k, i]
        guard(settings, state, model, work, orders, said, spoken)
        at = state.tick % memory.window.shape[0]
        for i in range(len(work.y)):
            memory.window[at, i] = work.y[i]
        if state.rested < settings.rest_ticks:
            _settle(settings, state, model, memory, work)
            if said.state[0].attempts == 0:
                # A pause in the middle gives no new time.
                said.state[0].since_tick = state.tick
            out.follow[k, :] = np.nan
            out.follow[k, REST] = 1.0
            out.follow[k, ASTRAY] = 0.0
            out.deviation[k, :] = np.nan
            out.deviation_sigma[k, :] = np.nan
            continue
        if state.tick % settings.stride == 0:
            slopes(settings, state, model, memory, work.v)
            update(settings, state, model, memory, work)
            if said.state[0].stopped == 1:
                state.in_attempt = 0
            else:
                count(settings, state, model, memory, work, out, orders, said, spoken)
            _follow_start(settings, state, model, memory, work)
        else:
            # Between two updates the phase goes on: what is reported is not late by the ticks since the last.
            state.phase = min(state.phase + state.rate * settings.tick_s, 1.0)
        out.follow[k, PHASE], out.follow[k, SIGMA] = state.phase, state.sigma
        out.follow[k, REST], out.follow[k, ASTRAY] = state.p_rest, state.p_wrong
        out.follow[k, SIZE] = state.size
        _deviate(k, state, model, memory, work, orders, out)
    return True
