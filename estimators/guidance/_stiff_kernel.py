"""A joint that does not come along: the movement is the template's, but for one channel that goes a share of its way.

The sizes of (1) scale all channels alike. Where an elbow opens by a third and the shoulder goes the whole way no size
fits, and the movement was taken for another one. Here each phase and size may also be explained with one channel less:
that one lies anywhere between a small share of its way and all of it, the others must fit as ever. It costs
`stiff_misfit`, less than a wrong movement, so that a movement that fits as a whole is never seen so.
"""

import math

from estimators.guidance._channel_kernel import ALONG, CROSS, FIT, SIZE, SPEED, STEEP, against_phase
from estimators.guidance._records import Memory, Model, Work
from estimators.kernels import Record, step

_LEAST_OTHERS = 0.5
"""Weight of the channels that are left below which they do not tell the movement."""


@step()
def _weights(model: Model, memory: Memory, work: Work) -> tuple[float, float]:
    """Return the weights of the values and of the slopes that are known."""
    of_values, of_slopes = 0.0, 0.0
    for f in range(len(model.steering)):
        c = model.steering[f]
        if not math.isnan(work.y[c] - memory.start[c]):
            of_values += model.weight[f]
            if not math.isnan(work.v[c]):
                of_slopes += model.weight[f]
    return of_values, of_slopes


@step()
def _slopes_left(
    f: int, v: float, scale: float, b: int, precision: float, work: Work
) -> tuple[float, float, float]:
    """Return the sums of slopes without this channel: of speed, along, and steep."""
    sums, slope = work.sums, work.slope[f, b]
    if math.isnan(v):
        return sums[SPEED, b], sums[ALONG, b], sums[STEEP, b]
    own = precision * scale
    return (
        max(sums[SPEED, b] - own * v * v, 0.0),
        sums[ALONG, b] - own * v * slope,
        max(sums[STEEP, b] - own * slope * slope, 0.0),
    )


@step()
def _spare(
    f: int,
    settings: Record,
    state: Record,
    model: Model,
    memory: Memory,
    work: Work,
    scales: tuple[float, float],
) -> None:
    """Explain every phase and size without one channel where that is better; what is so becomes negative."""
    c, misfits, sums = model.steering[f], work.moved, work.sums
    d, v, sigma = work.y[c] - memory.start[c], work.v[c], work.sigma[c]
    extra = 0.0 if math.isnan(sigma) else 0.25 * sigma * sigma
    sizes, phases = misfits.shape
    r0 = settings.pace
    known, least = 1.0 / (settings.pace_sd * r0) ** 2, settings.slope_sd_per_s**2
    fastest, ahead = settings.fastest * r0, state.pace - r0
    # What hardly moves may stay behind, and the repetition is whole without it.
    is_needed = model.weight[f] >= 1.0
    for b in range(phases):
        mu, precision = model.offset[f, b], model.weight[f] / (model.variance[f, b] + extra)
        speed, along, steep = _slopes_left(f, v, scales[1], b, precision, work)
        own = precision * scales[0]
        against = settings.stiff_misfit + against_phase(settings, state, speed, along, steep)
        for a in range(sizes):
            size = model.sizes[a]
            whole = size * mu
            part = settings.stiff_least * whole
            low, high = min(part, whole), max(part, whole)
            gap = max(max(low - d, d - high), 0.0)
            misfit = sums[FIT, b] - 2.0 * size * sums[CROSS, b] + size * size * sums[SIZE, b]
            misfit += own * (gap * gap - (d - whole) * (d - whole))
            go, climb = size * along, size * size * steep
            level = climb * r0 * r0
            noise = least + settings.slope_share * level
            expected = r0 + ahead * level / (level + 1.0)
            held = min(max((expected * known * noise + go) / (known * noise + climb), 0.0), fastest)
            strange = (speed - 2.0 * held * go + held * held * climb) / (noise + state.rest_v)
            strange += (held - expected) * (held - expected) * known
            spared = max(0.0, misfit - settings.free_misfit) + against + strange
            if spared < abs(misfits[a, b]):
                misfits[a, b] = -spared if is_needed else spared


@step()
def spare_one_joint(settings: Record, state: Record, model: Model, memory: Memory, work: Work) -> None:
    """Let one channel be short of its way, each phase and size by itself, where that explains more.

    `work.moved` holds the misfit of each phase and size, and afterwards the smaller ones; `p_stiff` is the share of the
    movement's probability that needs a channel less.
    """
    of_values, of_slopes = _weights(model, memory, work)
    for f in range(len(model.steering)):
        c = model.steering[f]
        is_known = not math.isnan(work.y[c] - memory.start[c])
        if is_known and of_values - model.weight[f] >= _LEAST_OTHERS:
            scales = 1.0 / of_values, 1.0 / of_slopes if of_slopes > 0.0 else 0.0
            _spare(f, settings, state, model, memory, work, scales)
    misfits, mass = work.moved, memory.mass
    sizes, phases = mass.shape
    stiff, moving = 0.0, 0.0
    rate = 0.5 * settings.update_s / settings.memory_s
    for a in range(sizes):
        for b in range(phases):
            is_spared = misfits[a, b] < 0.0
            misfits[a, b] = abs(misfits[a, b])
            after = mass[a, b] * math.exp(-rate * min(misfits[a, b], settings.misfit_cap))
            moving += after
            if is_spared:
                stiff += after
    state.p_stiff = stiff / moving if moving > 0.0 else 0.0
