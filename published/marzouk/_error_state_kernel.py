"""The error-state EKF that replaces the thesis' filter (A9m), compiled over sensors and ticks.

The page carries the attitude error in the sensor frame, theta; here it is in the earth frame U, as in
`estimators.kernels`. The noise is the same on all axes, so this is the same filter, and there F of A9m.1 needs no
turning, of gravity's rows [v x] two are left that read one state each (the third is zero), and the heading's row is
the third axis. As the error sits in U it is the covariance there that outlives an injection unchanged.
"""

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import kernel, rotate
from estimators.kernels import Record, direction, mirror, record, step
from estimators.orientation._strapdown_steps import BEGIN, FILTER, HOLD, Estimates, Ticks, run_signature
from estimators.recording import Float
from published._error_state import BASE, absorb, attitude_seen, inject, predict, turn_by_rate
from published.marzouk import _steps as steps
from published.marzouk._steps import SAMPLE, begin, prepare, set_heading, store

SETTINGS = record(
    steps.SETTINGS,
    [
        ("rate_variance", "f8"),
        ("bias_drift", "f8"),
        ("gravity_variance", "f8"),
        ("push_weight", "f8"),
        ("heading_variance", "f8"),
        ("field_penalty", "f8"),
    ],
)
STATE = record(steps.STATE)


@step(inlined=True)
def correct_inclination(x: Record, p: Float, sample: Record, c: Record, errors: Float, h: Float) -> None:
    """Correct by gravity (A9m.2): in the earth frame it is (xi_y, -xi_x, 1), two equally uncertain rows."""
    scale = 1.0 / sample.gravity_norm
    gx, gy, _ = rotate(
        x.q[0], x.q[1], x.q[2], x.q[3], sample.gravity[0], sample.gravity[1], sample.gravity[2]
    )
    push = sample.gravity_norm - 1.0
    variance = c.gravity_variance + c.push_weight * push * push
    errors[:] = 0.0
    attitude_seen(p, (0.0, 1.0, 0.0), h)
    inverse = 1.0 / (h[1] + variance)
    absorb(p, errors, h, gx * scale, inverse, inverse)
    attitude_seen(p, (1.0, 0.0, 0.0), h)
    inverse = 1.0 / (h[0] + variance)
    absorb(p, errors, h, -gy * scale - errors[0], inverse, inverse)
    inject(x, errors)


@step(inlined=True)
def correct_heading(x: Record, p: Float, sample: Record, c: Record, errors: Float, h: Float) -> None:
    """Correct the heading alone by the field (A9m.3)."""
    if x.is_heading_known == 0:
        set_heading(x, sample)
    north, east, _ = rotate(x.q[0], x.q[1], x.q[2], x.q[3], sample.field[0], sample.field[1], sample.field[2])
    variance = c.heading_variance
    if abs(sample.field_norm - 1.0) > c.field_tolerance:
        variance *= c.field_penalty
    errors[:] = 0.0
    attitude_seen(p, (0.0, 0.0, 1.0), h)
    inverse = 1.0 / (h[2] + variance)
    absorb(p, errors, h, direction(east, north), inverse, inverse)
    inject(x, errors)


@kernel(run_signature(SETTINGS, STATE))
def run(
    ticks: Ticks, settings: NDArray[np.void], state: NDArray[np.void], covariance: Float, out: Estimates
) -> None:
    """Filter K ticks of S sensors; `state` and `covariance` (S, 6, 6, earth frame) are carried on."""
    samples, errors, h = np.zeros(1, SAMPLE), np.zeros(BASE), np.zeros(BASE)
    sample, c, quality = samples[0], settings[0], ticks.quality
    for s in range(quality.shape[0]):
        x, p = state[s], covariance[s]
        for k in range(quality.shape[1]):
            action = prepare(ticks, s, k, x, c, sample)
            if action == BEGIN:
                begin(x, p, c, 3, 1.0)
            elif action != HOLD:
                turned = turn_by_rate(x, sample.rate[0], sample.rate[1], sample.rate[2], c.step_s)
                noise = c.rate_variance * c.step_s * c.step_s + sample.gap_variance
                predict(p, turned, noise, c.step_s * c.bias_drift)
                if action == FILTER:
                    correct_inclination(x, p, sample, c, errors, h)
                    if sample.has_field:
                        correct_heading(x, p, sample, c, errors, h)
            store(out, s, k, x, (p[0, 0], p[1, 1], p[2, 2]), quality[s, k], action, 0, sample, c)
        mirror(p)
