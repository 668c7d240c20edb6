"""Our own online filter over sensors and ticks: start, gaps, blocks and output."""

import math

import numpy as np
from numba import types
from numpy.typing import NDArray

from estimators._kernels import exponential, kernel, multiply
from estimators.kernels import VOID, Record, borrowing, single
from estimators.orientation._contract import OrientationFlag
from estimators.orientation._strapdown_steps import Estimates, Ticks, run_signature
from estimators.orientation.telemotion._block import (
    BEFORE,
    ENTRIES,
    ERROR,
    ROWS,
    hold_place,
    inject,
    move,
    predict,
    see_field,
)
from estimators.orientation.telemotion._field import (
    WORK,
    field_variance,
    find_north,
    iron_changed,
    open_iron,
    restless,
)
from estimators.orientation.telemotion._first_field import doubt, outlasted
from estimators.orientation.telemotion._gains import settle_gains
from estimators.orientation.telemotion._gaps import (
    after_gap,
    coast,
    doubt_filling,
    filled,
    gap_variance,
    remember,
    set_aside,
    store_field,
    went_on,
)
from estimators.orientation.telemotion._output import keep_shown, read, shown, take_back
from estimators.orientation.telemotion._records import IDLE, RUNNING, SAMPLE, SETTINGS, STATE, STATES
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
_COVARIANCE = types.float64[::1]
_ROOM = (types.float64[:, ::1], types.int64[:, ::1], types.float64[:, ::1], types.float64[::1])
"""`rows`, `index`, `value` and `work`."""


@borrowing(VOID(_COVARIANCE, single(STATE), types.int64, single(SETTINGS), *_ROOM), is_entry=True)
def end_block(
    p: Float,
    memory: Record,
    tick: int,
    settings: Record,
    rows: Float,
    index: NDArray[np.int64],
    value: Float,
    work: Float,
) -> None:
    """Run the filter over the sums of a block and move its error into the estimate."""
    error, before = rows[ERROR], rows[BEFORE]
    shown(memory, memory.q, before)
    ticks = float(memory.count)
    time_s = ticks * settings.step_s
    rest = memory.rest_s > settings.rest_minimum_s
    met, found = False, True
    move(memory, settings, ticks)
    predict(p, memory, settings, ticks)
    hold_place(p, error, rows, memory, settings, index, value, ticks, rest)
    odds = memory.odds
    if 2 * memory.field_count >= memory.count and upright(p):
        if memory.field_known == 0:
            meet_field(memory, p, settings)
            met = True
        elif lost(p):
            met = found = find_heading(p, memory, settings, rest)
        elif restless(memory, settings, time_s, rest):
            forget_field(memory, p, settings)
            meet_field(memory, p, settings)
        elif outlasted(memory, time_s, rest):
            forget_field(memory, p, settings)
            meet_field(memory, p, settings)
            met = True
        elif iron_changed(memory, settings, time_s):
            open_iron(p, error, rows, memory, index, value, settings, odds)
        if found:
            variance = field_variance(p, memory, settings, time_s, rest)
            see_field(p, error, rows, memory, index, value, variance)
    blocks = (tick + 1) // int(settings.block_ticks)
    judged = blocks % int(settings.hypothesis_blocks) == 0
    if judged and memory.gains_settled == 0:
        settle_gains(p, error, rows, memory, index, value, settings, work)
    off = contradiction(p, memory, error, settings, time_s)
    inject(memory, error)
    if off > 0.0:
        start_over(p, memory, settings, off)
    if memory.field_known and (judged or met):
        find_north(p, memory, settings, odds, work)
        memory.heading_variance += doubt(memory)
    if memory.field_known == 0:
        memory.heading_variance = p[2 * (STATES + 1)] + (_UNKNOWN if memory.field_count > 0 else 0.0)
    cosine = memory.correction[0] ** 2 - memory.correction[3] ** 2
    sine = 2.0 * memory.correction[0] * memory.correction[3]
    across, along = p[0], p[STATES + 1]
    scale = settings.tilt_scale
    if young(memory, settings):  # what a start leaves open is no correlated noise
        scale = 1.0
    mixed = 2.0 * sine * cosine * p[1]
    memory.tilt_variance[0] = scale * (cosine**2 * across + sine**2 * along - mixed)
    memory.tilt_variance[1] = scale * (sine**2 * across + cosine**2 * along + mixed)
    clear_sums(memory)
    if met:
        for a in range(3):
            memory.offset[a] = 0.0
        memory.since_start = 0
    elif off == 0.0:
        keep_shown(memory, memory.q, before)


@borrowing()
def advance(
    p: Float,
    memory: Record,
    tick: int,
    sample: Record,
    settings: Record,
    rows: Float,
    index: NDArray[np.int64],
    value: Float,
    work: Float,
) -> None:
    """Take the sample of one tick; blocks end at multiples of their length in ticks of the session."""
    watch_rest(memory, sample, settings)
    integrate(memory, memory, sample, settings)
    if (tick + 1) % int(settings.block_ticks) == 0:
        end_block(p, memory, tick, settings, rows, index, value, work)


@borrowing(
    VOID(
        *(
            _COVARIANCE,
            single(STATE),
            types.int64,
            single(SAMPLE),
            types.boolean,
            single(SAMPLE),
            single(SETTINGS),
        ),
        *_ROOM,
    ),
    is_entry=True,
)
def fill_gap(
    p: Float,
    memory: Record,
    tick: int,
    now: Record,
    sloped: bool,
    sample: Record,
    settings: Record,
    rows: Float,
    index: NDArray[np.int64],
    value: Float,
    work: Float,
) -> None:
    """Catch up: the samples of the gap, and the one set aside, whose tick is `tick`; `sample` is room for each."""
    gap = memory.gap
    for place in range(1, gap + 1):
        filled(memory, now, place, float(gap), sloped, sample)
        advance(p, memory, tick - 1 - gap + place, sample, settings, rows, index, value, work)
    doubt_filling(memory, now, sloped, settings, float(gap))
    after_gap(memory, sample)
    advance(p, memory, tick, sample, settings, rows, index, value, work)
    went_on(memory.last_rate, memory.slope_rate, sample.rate, now.rate, sloped, gap)
    went_on(memory.last_force, memory.slope_force, sample.force, now.force, sloped, gap)
    store_field(memory.last_field, sample)
    memory.gap = memory.pending = 0


@borrowing()
def follow(
    ticks: Ticks,
    s: int,
    settings: Record,
    memory: Record,
    p: Float,
    out: Estimates,
    rows: Float,
    index: NDArray[np.int64],
    value: Float,
    work: Float,
    samples: NDArray[np.void],
    q: Float,
) -> None:
    """Filter the ticks of sensor `s`, whose record and covariance are `memory` and `p`; the last six are room."""
    sample, filling, quality = samples[0], samples[1], ticks.quality
    step_s, block_ticks = settings.step_s, int(settings.block_ticks)
    for k in range(quality.shape[1]):
        tick = memory.tick
        memory.tick += 1
        grade = quality[s, k]
        usable = read(ticks, s, k, sample, memory)
        bridged = (grade & _SAMPLE_BRIDGED) != 0
        measured = usable and not bridged
        take_back(memory, settings)
        coasting = False
        if memory.phase == RUNNING:
            memory.since_start += 1
            if measured and memory.gap == 0:
                remember(memory, sample)
                watch_rest(memory, sample, settings)
                integrate(memory, memory, sample, settings)
                if (tick + 1) % block_ticks == 0:
                    end_block(p, memory, tick, settings, rows, index, value, work)
            elif measured and memory.pending:
                fill_gap(p, memory, tick - 1, sample, True, filling, settings, rows, index, value, work)
                remember(memory, sample)
                advance(p, memory, tick, sample, settings, rows, index, value, work)
            elif measured:
                set_aside(memory, sample)
                memory.pending = 1
                coast(memory, sample, True, 1.0, step_s)
                coasting = True
            else:
                if memory.pending:
                    fill_gap(
                        p,
                        memory,
                        tick - 1,
                        sample,
                        False,
                        filling,
                        settings,
                        rows,
                        index,
                        value,
                        work,
                    )
                if memory.gap == 0:
                    for i in range(4):
                        memory.coast[i] = memory.q[i]
                memory.gap += 1
                if memory.gap > settings.coast_ticks:
                    for i in range(4):
                        memory.q[i] = memory.coast[i]
                    memory.phase = IDLE
                else:
                    coast(memory, sample, usable, float(memory.gap), step_s)
                    coasting = True
        elif usable:
            if memory.phase == IDLE:
                begin(memory, sample)
                remember(memory, sample)
                memory.slope_rate[:] = 0.0
                memory.slope_force[:] = 0.0
            else:
                memory.since_start += 1
                remember(memory, sample)
            collect(p, memory, sample, settings)
        else:
            memory.phase = IDLE
            memory.gap += 1
        flag = _BRIDGED if bridged else 0
        if sample.saturated:
            flag |= _SATURATED
        for a in range(3):
            out.bias[s, k, a] = memory.bias[a]
        if memory.phase == IDLE:
            out.flags[s, k] = flag | _INVALID | _NO_HEADING
            for i in range(4):
                out.q[s, k, i] = memory.shown[i]
            for a in range(3):
                out.sigma_rad[s, k, a] = math.pi
            continue
        if coasting:
            shown(memory, memory.coast, q)
        else:
            shown(memory, memory.q, q)
        if settings.lead_s != 0.0:
            tw, tx, ty, tz = exponential(
                settings.lead_s * (memory.last_rate[0] - memory.bias[0]),
                settings.lead_s * (memory.last_rate[1] - memory.bias[1]),
                settings.lead_s * (memory.last_rate[2] - memory.bias[2]),
            )
            q[0], q[1], q[2], q[3] = multiply(q[0], q[1], q[2], q[3], tw, tx, ty, tz)
        for i in range(4):
            out.q[s, k, i] = memory.shown[i] = q[i]
        added = 0.0
        if coasting:
            added = gap_variance(memory, float(memory.gap + memory.pending), settings.gap_share, step_s)
            if not measured:
                flag |= _BRIDGED
        level = 1.0 + min(memory.disturbance, _WORST_LEVEL)
        uneven = 0.0
        for a in range(3):
            uneven += memory.force_offset[a] ** 2
        uneven *= settings.uneven / memory.gravity**2
        for a in range(3):
            variance = added + memory.offset[a] ** 2
            if a < 2:
                variance += memory.tilt_variance[a] + settings.tilt_floor + uneven
            else:
                variance += memory.heading_variance + settings.heading_floor * level
            out.sigma_rad[s, k, a] = min(math.sqrt(max(variance, 1e-12)), math.pi)
        if usable:
            norm = math.sqrt(sample.force[0] ** 2 + sample.force[1] ** 2 + sample.force[2] ** 2)
            if abs(norm - memory.gravity) > settings.force_tolerance:
                flag |= _ACCELERATION
        # A third of the time at least; after that only while the uncertainty is large.
        age = memory.since_start / settings.convergence_ticks
        largest = max(out.sigma_rad[s, k, 0], out.sigma_rad[s, k, 1], out.sigma_rad[s, k, 2])
        unsure = largest > _UNSURE or memory.start_moving > 0.0
        if age < _SETTLING or (age < 1.0 and unsure):
            flag |= _CONVERGING
        if sample.has_field and memory.misfit > _DISTURBED:
            flag |= _DISTURBANCE
        if memory.field_known == 0 or out.sigma_rad[s, k, 2] > settings.heading_lost:
            flag |= _NO_HEADING
        out.flags[s, k] = flag


@kernel(run_signature(SETTINGS, STATE))
def run(
    ticks: Ticks,
    settings_of_all: NDArray[np.void],
    state: NDArray[np.void],
    covariance: Float,
    out: Estimates,
) -> None:
    """Filter K ticks of S sensors; `state` and `covariance` (S, STATES, STATES) are carried on."""
    rows = np.zeros((ROWS, STATES))
    index, value = np.zeros((3, ENTRIES), dtype=np.int64), np.zeros((3, ENTRIES))
    samples, work, q = np.zeros(2, SAMPLE), np.zeros(WORK), np.zeros(4)
    flat = covariance.reshape(covariance.shape[0], STATES * STATES)
    for s in range(ticks.quality.shape[0]):
        follow(ticks, s, settings_of_all[0], state[s], flat[s], out, rows, index, value, work, samples, q)
