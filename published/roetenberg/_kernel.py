"""Roetenberg's complementary Kalman filter with magnetic disturbance (method page 2.3), compiled.

The page carries the errors in the sensor frame; here orientation and disturbance errors are in the earth frame,
xi = R theta and delta = R d_e, where reference and gravity are constant and the transition needs no turning.
Noise is the same on all axes, so this is the same filter; the dense twin of the tests is in the sensor frame.
"""

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import kernel, rotate
from estimators.kernels import Record, arcsine, mirror, step
from estimators.orientation._strapdown_steps import (
    BEGIN,
    FILTER,
    HOLD,
    SAMPLE,
    Estimates,
    Ticks,
    begin,
    keep_acceleration,
    prepare,
    run_signature,
    store,
    store_details,
)
from estimators.recording import Float
from published._error_state import BASE, Matrix, inject, predict, turn_by_rate
from published.roetenberg._detector import detect
from published.roetenberg._measurement import keep_spread, measure_field, measure_gravity
from published.roetenberg._model import (
    DIP,
    DISTURBANCE,
    MEASUREMENTS,
    NORM,
    SETTINGS,
    STATE,
    STATES,
    forget_disturbance,
    keep_blocks,
    predict_disturbance,
)
from published.roetenberg._reference import begin_heading, field_flags, look_for_heading


@step()
def start(x: Record, p: Float, c: Record) -> None:
    """Set attitude, heading and covariances from the first samples."""
    begin(x, p, c)
    begin_heading(x, p, c)
    x.spread[0] = x.spread[2] = c.change_variance
    x.spread[1] = 0.0


@step(inlined=True)
def correct(
    x: Record, p: Float, sample: Record, c: Record, turned: Matrix, errors: Float, h: Float, to_correct: bool
) -> None:
    """Predict the disturbance by what the field says of it, and correct by gravity and field (page 2.3 to 2.5)."""
    change, field = c.floor_variance, (0.0, 0.0, 0.0)
    measured = to_correct and c.use_field != 0 and sample.has_field != 0
    if measured:
        field = rotate(x.q[0], x.q[1], x.q[2], x.q[3], sample.field[0], sample.field[1], sample.field[2])
        if x.is_heading_known == 0:
            look_for_heading(x, p, c, field)
            measured = False
        else:
            scale = 1.0 / x.reference_norm
            field = field[0] * scale, field[1] * scale, field[2] * scale
            norm = sample.field_norm * scale
            change = detect(x, c, norm, arcsine(min(max(-field[2] * (1.0 / norm), -1.0), 1.0)))
    if x.is_pinned:
        forget_disturbance(x, p, c)
    else:
        predict_disturbance(x, p, c, turned, change)
    if not to_correct:
        return
    for i in range(STATES):
        errors[i] = 0.0
    for i in range(MEASUREMENTS):
        sample.inverse[i] = 0.0
    if c.use_gravity:
        force = rotate(x.q[0], x.q[1], x.q[2], x.q[3], sample.force[0], sample.force[1], sample.force[2])
        measure_gravity(x, p, sample, c, errors, h, force)
    if measured:
        measure_field(x, p, sample, c, errors, h, field)
    inject(x, errors)
    for axis in range(3):
        x.disturbance[axis] -= errors[BASE + axis]
    keep_acceleration(x, sample, c)
    if c.held_acceleration:
        keep_spread(x, p, c)


@step()
def store_field(out: Estimates, s: int, k: int, x: Record) -> None:
    """Write disturbance, norm and dip after acceleration and innovations."""
    for axis in range(3):
        out.details[s, k, DISTURBANCE + axis] = x.disturbance[axis]
    out.details[s, k, NORM] = x.smooth_norm
    out.details[s, k, DIP] = x.smooth_dip


@kernel(run_signature(SETTINGS, STATE))
def run(
    ticks: Ticks, settings: NDArray[np.void], state: NDArray[np.void], covariance: Float, out: Estimates
) -> None:
    """Filter K ticks of S sensors; `state` and `covariance` (S, 9, 9) are carried on."""
    samples, errors, h = np.zeros(1, SAMPLE), np.zeros(STATES), np.zeros(STATES)
    sample, c, quality = samples[0], settings[0], ticks.quality
    for s in range(quality.shape[0]):
        x, p = state[s], covariance[s]
        for k in range(quality.shape[1]):
            action = prepare(ticks, s, k, x, c, sample)
            if action == BEGIN:
                start(x, p, c)
            elif action != HOLD:
                if c.blocks_only:
                    keep_blocks(p)
                turned = turn_by_rate(x, sample.rate[0], sample.rate[1], sample.rate[2], c.step_s)
                predict(
                    p, turned, c.rate_variance * c.step_s * c.step_s + sample.gap_variance, c.bias_variance
                )
                correct(x, p, sample, c, turned, errors, h, action == FILTER)
            variances = p[0, 0], p[1, 1], p[2, 2]
            own = field_flags(x, c, p[2, 2])
            store(out, s, k, x, variances, quality[s, k], action, own, sample, c)
            if out.details.shape[0] > 0:
                store_details(out, s, k, MEASUREMENTS, action, x, sample)
                store_field(out, s, k, x)
        mirror(p)
