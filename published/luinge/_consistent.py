"""Luinge and Veltink's inclination and offset filter in its consistent form (A5), compiled."""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import kernel
from estimators.kernels import Record, mirror, record, step
from estimators.orientation import _strapdown_steps as steps
from estimators.orientation._contract import OrientationFlag
from estimators.orientation._strapdown_steps import (
    BEGIN,
    FILTER,
    HOLD,
    SAMPLE,
    Estimates,
    Ticks,
    begin,
    force_without_acceleration,
    keep_acceleration,
    prepare,
    run_signature,
    store,
    store_details,
)
from estimators.recording import Float
from published._error_state import BASE, absorb, attitude_seen, inject, predict, turn_by_rate
from published.luinge._rest import (
    REST_SETTINGS,
    REST_STATE,
    forget_rest,
    measure_rest,
    watch_rest,
)

_NO_HEADING = int(OrientationFlag.HEADING_NOT_TRUSTED)

SETTINGS = record(
    steps.SETTINGS,
    REST_SETTINGS,
    [("inclination_variance", "f8")],  # of an inclination error measured once, R_v / (1 - c_a)^2
)
STATE = record(
    steps.STATE,
    REST_STATE,
    [("spread", "f8", 6)],  # Q_a of the published form: xx xy xz yy yz zz, sensor frame
)


@step(inlined=True)
def correct(x: Record, p: Float, sample: Record, c: Record, errors: Float, h: Float) -> None:
    """Correct by the direction of force less predicted acceleration (A5.2 to A5.5).

    Rows 1 and 2 of that direction in the earth frame are (1 - c_a) (xi_y, -xi_x): two scalar measurements of
    xi itself.
    """
    ux, uy, uz = force_without_acceleration(x, sample, c)
    square = ux * ux + uy * uy + uz * uz
    if square > 0.0:
        scale = 1.0 / (math.sqrt(square) * (1.0 - c.acceleration_gain))
        for i in range(BASE):
            errors[i] = 0.0
        attitude_seen(p, (0.0, 1.0, 0.0), h)
        sample.innovation[0], sample.inverse[0] = scale * ux, 1.0 / (h[1] + c.inclination_variance)
        absorb(p, errors, h, sample.innovation[0], sample.inverse[0], 0.0)
        attitude_seen(p, (1.0, 0.0, 0.0), h)
        sample.innovation[1] = -scale * uy - errors[0]
        sample.inverse[1] = 1.0 / (h[0] + c.inclination_variance)
        absorb(p, errors, h, sample.innovation[1], sample.inverse[1], 0.0)
        inject(x, errors)
    keep_acceleration(x, sample, c)


@kernel(run_signature(SETTINGS, STATE))
def run(
    ticks: Ticks, settings: NDArray[np.void], state: NDArray[np.void], covariance: Float, out: Estimates
) -> None:
    """Filter K ticks of S sensors; `state` and `covariance` (S, 6, 6) are carried on."""
    samples, errors, h = np.zeros(1, SAMPLE), np.zeros(BASE), np.zeros(BASE)
    sample, c, quality = samples[0], settings[0], ticks.quality
    for s in range(quality.shape[0]):
        x, p = state[s], covariance[s]
        for k in range(quality.shape[1]):
            action = prepare(ticks, s, k, x, c, sample)
            if action == BEGIN:
                begin(x, p, c)
                forget_rest(x)
            elif action != HOLD:
                turned = turn_by_rate(x, sample.rate[0], sample.rate[1], sample.rate[2], c.step_s)
                predict(
                    p, turned, c.rate_variance * c.step_s * c.step_s + sample.gap_variance, c.bias_variance
                )
                if action == FILTER:
                    correct(x, p, sample, c, errors, h)
                    watch_rest(x, sample, c)
                    if x.is_at_rest:
                        for i in range(BASE):
                            errors[i] = 0.0
                        measure_rest(x, p, sample, c, errors, h)
                        inject(x, errors)
            variances = p[0, 0], p[1, 1], p[2, 2]
            store(out, s, k, x, variances, quality[s, k], action, _NO_HEADING, sample, c)
            if out.details.shape[0] > 0:
                store_details(out, s, k, 2, action, x, sample)
        mirror(p)
