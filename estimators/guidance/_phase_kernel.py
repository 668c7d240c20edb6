"""The phase filter: one update of the probability of each phase and size, of rest and of a wrong movement.

Equations (1) to (8) of the house's page on live guidance, and what they leave out, which put the phase of somebody who
repeats the template exactly ahead in holds, and behind after them and at the end:

- (2) expects the template's pace; here the patient's own, which the filter follows.
- (3) charges standing still; (4) asks whither, not how fast the body moves. Here slopes are held against the pace of
  each state, so that one looks not long at each place (`memory_s`) and still does not lose its way.
- Slopes lie half a window back, those of the template here as well (`prepare_template`), at the patient's own pace.
- sigma_v is one number there; here it is small where the template rests and grows with its speed: when a hold begins
  and ends shows in slow movement.
- A phase that moves fast can explain any slope by its pace; the logarithm of the variance that it expects sets the
  ends of a movement apart from a slower middle.
- Splitting a mass between two bins blurs it, in a hold by more than all else: `_shifted` takes most of that back.
- Only the last phase passes on to rest or to the next repetition: the last three took away what was ahead.
"""

import math

from estimators.guidance._channel_kernel import (
    ALONG,
    CROSS,
    FIT,
    SIZE,
    SPEED,
    STEEP,
    against_phase,
    rest_speed,
    slopes_at_pace,
    sums_of_channels,
)
from estimators.guidance._records import Memory, Model, Work
from estimators.guidance._stiff_kernel import spare_one_joint
from estimators.kernels import Record, step
from estimators.recording import Float

SHIFT, SLOWEST, ONWARD, STAYS, BACK = range(5)
"""Rows of the lines with which probabilities are moved."""
_ENTRY = 3
"""Phases at which a movement begins."""
_SLOWEST_OWN = 0.25
"""Least pace of a patient, in r0: who stands still is not slow."""
_NEAR = 8
_EDGE_LOW, _EDGE_HIGH = 0.75, 0.9


@step(inlined=True)
def _decay(x: float) -> float:
    """Return exp(-x) for 0 <= x <= 15 within 1e-6 of it, without a call so that loops become wide instructions."""
    u = x / 32.0
    p = 1.0 - u * (1.0 - u * (0.5 - u * (1.0 / 6.0 - u * (1.0 / 24.0 - u / 120.0))))
    p *= p
    p *= p
    p *= p
    p *= p
    return p * p


@step()
def _pace(settings: Record, state: Record, model: Model, memory: Memory, work: Work) -> None:
    """Equation (2): at which pace each phase and size goes on, and how strange the slopes would be at it.

    Expected is the patient's own pace, which follows what is seen; where the template holds, its own: how long somebody
    stays does not follow from how fast he moves; at rest it is forgotten. Strange is what is left of the slopes,
    <(v - r a mu')^2>, and how far the pace is from the expected one: it sets a movement that slows down before a hold
    apart from the hold.
    """
    sums, pace, strange, mass = work.sums, work.pace, work.strange, memory.mass
    sizes, phases = mass.shape
    r0 = settings.pace
    known = 1.0 / (settings.pace_sd * r0) ** 2
    least = settings.slope_sd_per_s**2
    fastest = settings.fastest * r0
    ahead = state.pace - r0
    gone, steepness = work.line[0], work.line[1]
    gone[:], steepness[:] = 0.0, 0.0
    for a in range(sizes):
        size = model.sizes[a]
        for b in range(phases):
            along, steep = size * sums[ALONG, b], size * size * sums[STEEP, b]
            level = steep * r0 * r0
            noise = least + settings.slope_share * level
            expected = r0 + ahead * level / (level + 1.0)
            r = (expected * known * noise + along) / (known * noise + steep)
            held = min(max(r, 0.0), fastest)
            left = sums[SPEED, b] - 2.0 * held * along + held * held * steep
            pace[a, b] = r
            strange[a, b] = left / (noise + state.rest_v) + (held - expected) * (held - expected) * known
            gone[b] += mass[a, b] * along / noise
            steepness[b] += mass[a, b] * steep / noise
    moved, certain = 0.0, 0.0
    for b in range(phases):
        moved += gone[b]
        certain += steepness[b]
    if certain > 0.0:
        new = certain * settings.update_s
        own = state.pace + new / (new + known * settings.pace_follows_s) * (moved / certain - state.pace)
        state.pace = min(max(own, _SLOWEST_OWN * r0), fastest)
    state.pace += state.p_rest * settings.update_s / settings.pace_forgets_s * (r0 - state.pace)


@step()
def _shifted(
    mass: Float, shift: Float, blur: float, onward: Float, stays: Float, back: Float, moved: Float
) -> None:
    """Move one size's probabilities by `shift` phases each; what leaves an end stays there.

    Split between two bins, a mass that goes f bins spreads by a variance of f (1 - f): many times `blur_per_s`. No
    further than one bin, three bins share it so that its mean goes f on and its variance grows by
    `blur` of that alone (Lax and Wendroff's weights with none). One of them may take from what others bring; nothing
    falls below zero, so that a lone bin may gain a little, which the next reading takes out of all. Further than one
    bin, as in templates that are done within a second, mass is split as ever. Each bin gathers what comes from the two
    beside it and from itself, in wide instructions.
    """
    phases, last = len(mass), len(mass) - 1
    is_near = True
    for b in range(phases):
        far = abs(shift[b])
        square = far * far + blur * far * (1.0 - far)
        onward[b] = 0.5 * (square + shift[b])
        stays[b] = 1.0 - square
        back[b] = 0.5 * (square - shift[b])
        is_near &= far < 1.0
    if is_near:
        for b in range(1, last):
            comes = onward[b - 1] * mass[b - 1] + stays[b] * mass[b] + back[b + 1] * mass[b + 1]
            moved[b] = max(comes, 0.0)
        moved[0] = max(back[0] * mass[0] + stays[0] * mass[0] + back[1] * mass[1], 0.0)
        leaves = onward[last - 1] * mass[last - 1] + stays[last] * mass[last] + onward[last] * mass[last]
        moved[last] = max(leaves, 0.0)
        return
    moved[:] = 0.0
    for b in range(phases):
        place = b + shift[b]
        low = math.floor(place)
        share = place - low
        first, second = min(max(low, 0), last), min(max(low + 1, 0), last)
        moved[first] += (1.0 - share) * mass[b]
        moved[second] += share * mass[b]


@step()
def _move(settings: Record, model: Model, memory: Memory, work: Work) -> None:
    """Equation (3): each phase and size goes on at its own pace."""
    mass, moved = memory.mass, work.moved
    sizes, phases = mass.shape
    r0, dt = settings.pace, settings.update_s
    shift, slowest = work.line[SHIFT], work.line[SLOWEST]
    fastest = settings.fastest * r0
    for b in range(phases):
        phi = (b + 0.5) / phases
        edge = min(max((phi - _EDGE_LOW) / (_EDGE_HIGH - _EDGE_LOW), 0.0), 1.0)
        slowest[b] = settings.slowest * r0 * (1.0 - edge)
    for a in range(sizes):
        for b in range(phases):
            pace = min(max(work.pace[a, b], slowest[b]), fastest)
            shift[b] = pace * dt * phases
        _shifted(
            mass[a],
            shift,
            settings.split_blur,
            work.line[ONWARD],
            work.line[STAYS],
            work.line[BACK],
            moved[a],
        )
    spread = 0.5 * settings.blur_per_s * dt * phases * phases
    trade = 0.5 * settings.size_exchange_per_s * dt
    for a in range(sizes):
        below, above = max(a - 1, 0), min(a + 1, sizes - 1)
        for b in range(phases):
            mass[a, b] = (1.0 - 2.0 * trade) * moved[a, b] + trade * (moved[below, b] + moved[above, b])
    for a in range(sizes):
        before = mass[a, 0]
        for b in range(phases):
            here = mass[a, b]
            after = mass[a, min(b + 1, phases - 1)]
            mass[a, b] = (1.0 - 2.0 * spread) * here + spread * (before + after)
            before = here


@step()
def _change(settings: Record, state: Record, memory: Memory, work: Work) -> None:
    """Equations (6) and (7): between rest, movement and wrong movement."""
    mass, dt = memory.mass, settings.update_s
    sizes, phases = mass.shape
    total = 0.0
    for a in range(sizes):
        total += memory.size_mean[a]
    for a in range(sizes):
        mean = memory.size_mean[a] / total if state.finished > 0 else 1.0 / sizes
        work.prior[a] = settings.broad_share / sizes + (1.0 - settings.broad_share) * mean
    to_rest, to_wrong, to_start = 0.0, 0.0, 0.0
    away = (settings.to_rest_per_s + settings.to_wrong_per_s) * dt
    ended = (settings.end_to_rest_per_s + settings.end_to_start_per_s) * dt
    for a in range(sizes):
        for b in range(phases):
            here = mass[a, b]
            to_rest += settings.to_rest_per_s * dt * here
            to_wrong += settings.to_wrong_per_s * dt * here
            stays = 1.0 - away
            if b == phases - 1:
                to_rest += settings.end_to_rest_per_s * dt * here
                to_start += settings.end_to_start_per_s * dt * here
                stays -= ended
            mass[a, b] = stays * here
    rest, wrong = state.p_rest, state.p_wrong
    to_start += settings.rest_to_start_per_s * dt * rest + settings.from_wrong_per_s * dt * wrong
    to_rest += (settings.from_wrong_per_s + settings.to_rest_per_s) * dt * wrong
    to_wrong += settings.to_wrong_per_s * dt * rest
    rest *= 1.0 - (settings.rest_to_start_per_s + settings.to_wrong_per_s) * dt
    wrong *= 1.0 - (2.0 * settings.from_wrong_per_s + settings.to_rest_per_s) * dt
    again = settings.restart_per_s * dt
    # REST and WRONG are two of the states over which the restart is spread.
    share = again / (phases + 2)
    for a in range(sizes):
        for b in range(phases):
            entering = to_start * work.prior[a] / _ENTRY if b < _ENTRY else 0.0
            mass[a, b] = (1.0 - again) * (mass[a, b] + entering) + share * work.prior[a]
    state.p_rest = (1.0 - again) * (rest + to_rest) + share
    state.p_wrong = (1.0 - again) * (wrong + to_wrong) + share


@step()
def _weigh(settings: Record, state: Record, model: Model, memory: Memory, work: Work, away: float) -> None:
    """Equations (4) and (5): what is measured speaks for some phases and sizes and against others."""
    mass, sums, misfits = memory.mass, work.sums, work.moved
    sizes, phases = mass.shape
    rate = 0.5 * settings.update_s / settings.memory_s
    against = work.line[0]
    for b in range(phases):
        against[b] = against_phase(settings, state, sums[SPEED, b], sums[ALONG, b], sums[STEEP, b])
    moving, strange = 0.0, 0.0
    for a in range(sizes):
        size = model.sizes[a]
        for b in range(phases):
            misfit = sums[FIT, b] - 2.0 * size * sums[CROSS, b] + size * size * sums[SIZE, b]
            d = max(0.0, misfit - settings.free_misfit) + against[b] + work.strange[a, b]
            misfits[a, b] = d
            moving += mass[a, b]
            strange += mass[a, b] * min(d, settings.misfit_cap)
    if strange > settings.stiff_from * moving:
        spare_one_joint(settings, state, model, memory, work)
    else:
        state.p_stiff = 0.0
    for a in range(sizes):
        for b in range(phases):
            mass[a, b] *= _decay(rate * min(misfits[a, b], settings.misfit_cap))
    still = away + state.v / (settings.rest_speed + state.rest_v)
    state.p_rest *= _decay(rate * min(still, settings.misfit_cap))
    state.p_wrong *= _decay(rate * settings.wrong_misfit)


@step()
def _read(settings: Record, state: Record, model: Model, memory: Memory, work: Work) -> None:
    """Equation (8): normalise, and read phase, its sigma, at which rate it goes on, and the size."""
    mass, line = memory.mass, work.line[0]
    sizes, phases = mass.shape
    line[:] = 0.0
    moving, size = 0.0, 0.0
    for a in range(sizes):
        of_size = 0.0
        for b in range(phases):
            line[b] += mass[a, b]
            of_size += mass[a, b]
        moving += of_size
        size += model.sizes[a] * of_size
    total = moving + state.p_rest + state.p_wrong
    for a in range(sizes):
        for b in range(phases):
            mass[a, b] /= total
    state.p_rest /= total
    state.p_wrong /= total
    mode = 0
    for b in range(phases):
        if line[b] > line[mode]:
            mode = b
    near, sum_near, gone = 0.0, 0.0, 0.0
    fastest = settings.fastest * settings.pace
    for b in range(max(mode - _NEAR, 0), min(mode + _NEAR + 1, phases)):
        near += line[b]
        sum_near += line[b] * (b + 0.5) / phases
        for a in range(sizes):
            gone += total * mass[a, b] * min(max(work.pace[a, b], 0.0), fastest)
    state.phase = sum_near / near
    state.rate = gone / near
    spread = 0.0
    for b in range(phases):
        spread += line[b] * ((b + 0.5) / phases - state.phase) ** 2
    state.sigma = math.sqrt(spread / moving)
    state.size = size / moving


@step()
def update(settings: Record, state: Record, model: Model, memory: Memory, work: Work) -> None:
    """Go one update on: move, change, weigh, read. Without any channel nothing is weighed."""
    slopes_at_pace(settings, state, model, work)
    of_values, _ = sums_of_channels(model, memory, work)
    _pace(settings, state, model, memory, work)
    _move(settings, model, memory, work)
    _change(settings, state, memory, work)
    away, speed, _ = rest_speed(model, memory, work)
    state.v = speed
    if of_values > 0.0:
        _weigh(settings, state, model, memory, work, away)
    _read(settings, state, model, memory, work)
