"""Measurement of a tick against the template: whole turns, slopes, and the sums over channels of (1) to (5)."""

import math

import numpy as np

from estimators.guidance._records import Memory, Model, Work
from estimators.kernels import Record, step
from estimators.recording import Float

FIT, CROSS, SIZE, SPEED, ALONG, STEEP = range(6)
"""Rows of the sums: <(y-y0)^2/s^2>, <(y-y0) mu/s^2>, <mu^2/s^2>, <v^2/s^2>, <v mu'/s^2>, <mu'^2/s^2>."""
PACE_STEP = 0.5
"""Between the paces for which the model has slopes, in r0, and the first of them."""


@step()
def unwrap(model: Model, memory: Memory, values: Float, y: Float) -> None:
    """Take one tick's values, angles by whole turns nearest to their last, and put them into the ring's slot `y`."""
    for c in range(len(values)):
        value = values[c]
        if not math.isnan(value):
            if model.turns[c] == 1 and not math.isnan(memory.last[c]):
                value += 2.0 * math.pi * np.rint((memory.last[c] - value) / (2.0 * math.pi))
            memory.last[c] = value
        y[c] = value


@step()
def slopes(settings: Record, state: Record, model: Model, memory: Memory, v: Float) -> None:
    """Fit a line to the last values of each channel that steers; NaN where fewer than half are known."""
    width = memory.window.shape[0]
    newest = state.tick % width
    for c in model.steering:
        count, t, tt, s, ts = 0.0, 0.0, 0.0, 0.0, 0.0
        base = memory.window[newest, c]
        v[c] = np.nan
        if math.isnan(base):
            continue
        for k in range(width):
            value = memory.window[(newest + width - k) % width, c]
            if not math.isnan(value):
                age = -float(k)
                count += 1.0
                t += age
                tt += age * age
                s += value - base
                ts += age * (value - base)
        if 2.0 * count > width and count > 1.0:
            v[c] = (ts - t * s / count) / (tt - t * t / count) / settings.tick_s


@step()
def slopes_at_pace(settings: Record, state: Record, model: Model, work: Work) -> None:
    """Take the template's slopes as late as those of somebody who moves at the patient's pace."""
    paces, channels, phases = model.slope.shape
    place = min(max(state.pace / (PACE_STEP * settings.pace) - 1.0, 0.0), paces - 1.0)
    low = min(int(place), paces - 2)
    share = place - low
    for f in range(channels):
        slower, faster, between = model.slope[low, f], model.slope[low + 1, f], work.slope[f]
        for b in range(phases):
            between[b] = slower[b] + share * (faster[b] - slower[b])


@step()
def sums_of_channels(model: Model, memory: Memory, work: Work) -> tuple[float, float]:
    """Sum over the channels present, once a phase; return the weights of values and of slopes."""
    sums = work.sums
    phases = sums.shape[1]
    sums[:] = 0.0
    of_values, of_slopes = 0.0, 0.0
    for f in range(len(model.steering)):
        c = model.steering[f]
        d = work.y[c] - memory.start[c]
        if math.isnan(d):
            continue
        w, v = model.weight[f], work.v[c]
        sigma = work.sigma[c]
        extra = 0.0 if math.isnan(sigma) else 0.25 * sigma * sigma
        of_values += w
        mu, slope, variance = model.offset[f], work.slope[f], model.variance[f]
        if math.isnan(v):
            for b in range(phases):
                precision = w / (variance[b] + extra)
                sums[FIT, b] += precision * d * d
                sums[CROSS, b] += precision * d * mu[b]
                sums[SIZE, b] += precision * mu[b] * mu[b]
            continue
        of_slopes += w
        for b in range(phases):
            precision = w / (variance[b] + extra)
            sums[FIT, b] += precision * d * d
            sums[CROSS, b] += precision * d * mu[b]
            sums[SIZE, b] += precision * mu[b] * mu[b]
            sums[SPEED, b] += precision * v * v
            sums[ALONG, b] += precision * v * slope[b]
            sums[STEEP, b] += precision * slope[b] * slope[b]
    value_scale = 1.0 / of_values if of_values > 0.0 else 0.0
    slope_scale = 1.0 / of_slopes if of_slopes > 0.0 else 0.0
    for b in range(phases):
        sums[FIT, b] *= value_scale
        sums[CROSS, b] *= value_scale
        sums[SIZE, b] *= value_scale
        sums[SPEED, b] *= slope_scale
        sums[ALONG, b] *= slope_scale
        sums[STEEP, b] *= slope_scale
    return of_values, of_slopes


@step()
def against_phase(settings: Record, state: Record, speed: float, along: float, steep: float) -> float:
    """Return what the direction of movement and the steepness of a phase say against it, (4)."""
    r0 = settings.pace
    turned = 1.0 - along / math.sqrt(max(speed * steep, 1e-30))
    steady = steep * r0 * r0
    of_pace = settings.pace_sd**2 + settings.slope_share
    least = settings.slope_sd_per_s**2 + state.rest_v
    return float(
        settings.direction * 0.5 * turned * speed / (speed + 1.0 + state.rest_v) * steady / (steady + 1.0)
        + settings.steepness * math.log(1.0 + steady * of_pace / least)
    )


@step()
def rest_speed(model: Model, memory: Memory, work: Work) -> tuple[float, float, float]:
    """Return <(y-y0)^2/s0^2>, <v^2/s0^2> and the weight of slopes at the start posture."""
    away, speed, of_values, of_slopes = 0.0, 0.0, 0.0, 0.0
    for f in range(len(model.steering)):
        c = model.steering[f]
        sigma = work.sigma[c]
        variance = model.variance[f, 0] + (0.0 if math.isnan(sigma) else 0.25 * sigma * sigma)
        d, v = work.y[c] - memory.start[c], work.v[c]
        if not math.isnan(d):
            away += model.weight[f] * d * d / variance
            of_values += model.weight[f]
        if not math.isnan(v):
            speed += model.weight[f] * v * v / variance
            of_slopes += model.weight[f]
    return (
        away / of_values if of_values > 0.0 else 0.0,
        speed / of_slopes if of_slopes > 0.0 else 0.0,
        of_slopes,
    )
