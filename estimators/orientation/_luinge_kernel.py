"""Luinge and Veltink's inclination and offset filter in its consistent form (A5), compiled."""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import kernel
from estimators.orientation import _luinge_rest as rest
from estimators.orientation import _strapdown_steps as steps
from estimators.orientation._contract import OrientationFlag
from estimators.orientation._luinge_rest import forget_rest, measure_rest, watch_rest
from estimators.orientation._strapdown_kernel import (
    begin,
    inject,
    lessen,
    mirror,
    predict_covariance,
    turn_by_rate,
)
from estimators.orientation._strapdown_steps import (
    force_without_acceleration,
    keep_acceleration,
    prepare,
    store,
    tell,
)
from estimators.recording import Float

# Numba freezes globals, not attributes of modules.
_HOLD, _BEGIN, _FILTER = steps.HOLD, steps.BEGIN, steps.FILTER
_SAMPLE, _INNOVATION, _ACCELERATION_GAIN = steps.SAMPLE, steps.INNOVATION, steps.ACCELERATION_GAIN
_AT_REST = rest.AT_REST
_NO_HEADING = int(OrientationFlag.HEADING_NOT_TRUSTED)

INCLINATION_VARIANCE = steps.SHARED_SETTINGS
"""Position in the settings: variance of an inclination error measured once, R_v / (1 - c_a)^2."""


@kernel(
    "void(float64[:, ::1], float64[:, ::1], int64, float64[:, ::1], float64[:, ::1], float64[::1],"
    "float64[::1])",
    inlined=True,
)
def correct(q: Float, bias: Float, s: int, p: Float, memory: Float, sample: Float, settings: Float) -> None:
    """Correct by the direction of force less predicted acceleration (A5.2 to A5.5).

    Rows 1 and 2 of that direction in the earth frame are (1 - c_a) (xi_y, -xi_x): two scalar measurements of
    xi itself. Their noises are independent, so that one after the other is the joint update.
    """
    ux, uy, uz = force_without_acceleration(s, q, memory, sample, settings)
    square = ux * ux + uy * uy + uz * uz
    if square > 0.0:
        scale = 1.0 / (math.sqrt(square) * (1.0 - settings[_ACCELERATION_GAIN]))
        variance = settings[INCLINATION_VARIANCE]
        h0, h1, h2, h3, h4, h5 = p[0, 1], p[1, 1], p[1, 2], p[1, 3], p[1, 4], p[1, 5]
        inverse = 1.0 / (h1 + variance)
        residual = scale * ux
        sample[_INNOVATION], sample[_INNOVATION + 1] = residual, inverse
        gain = inverse * residual
        e0, e1, e2, e3, e4, e5 = h0 * gain, h1 * gain, h2 * gain, h3 * gain, h4 * gain, h5 * gain
        lessen(p, inverse, h0, h1, h2, h3, h4, h5)
        h0, h1, h2, h3, h4, h5 = p[0, 0], p[0, 1], p[0, 2], p[0, 3], p[0, 4], p[0, 5]
        inverse = 1.0 / (h0 + variance)
        residual = -scale * uy - e0
        sample[_INNOVATION + 2], sample[_INNOVATION + 3] = residual, inverse
        gain = inverse * residual
        lessen(p, inverse, h0, h1, h2, h3, h4, h5)
        inject(
            q,
            bias,
            s,
            e0 + h0 * gain,
            e1 + h1 * gain,
            e2 + h2 * gain,
            e3 + h3 * gain,
            e4 + h4 * gain,
            e5 + h5 * gain,
        )
    keep_acceleration(s, q, memory, sample, settings)


@kernel(
    "void(float64[:, :, ::1], float64[:, :, ::1], float64[:, :, ::1], uint8[:, ::1], float64[::1],"
    "float64[:, ::1], float64[:, ::1], float64[:, :, ::1], float64[:, ::1], int64[:, ::1],"
    "float64[:, :, ::1], float64[:, :, ::1], float64[:, :, ::1], uint8[:, ::1], float64[:, :, ::1])"
)
def run(
    gyroscope_radps: Float,
    accelerometer_mps2: Float,
    magnetometer_t: Float,
    quality: NDArray[np.uint8],
    settings: Float,
    q: Float,
    bias: Float,
    covariance: Float,
    memory: Float,
    counters: NDArray[np.int64],
    q_earth_sensor: Float,
    bias_out: Float,
    sigma_rad: Float,
    flags: NDArray[np.uint8],
    details: Float,
) -> None:
    """Filter K ticks of S sensors; `q`, `bias`, `covariance` (S, 6, 6), memory and counts are carried on."""
    sample, error = np.zeros(_SAMPLE), np.zeros(6)
    for s in range(quality.shape[0]):
        p = covariance[s]
        for k in range(quality.shape[1]):
            action = prepare(
                s,
                k,
                gyroscope_radps,
                accelerometer_mps2,
                magnetometer_t,
                quality,
                settings,
                q,
                memory,
                counters,
                sample,
            )
            if action == _BEGIN:
                begin(s, p, memory, counters, settings)
                forget_rest(s, memory, counters)
            elif action != _HOLD:
                turned = turn_by_rate(q, bias, s, sample, settings)
                predict_covariance(p, turned, sample, settings)
                if action == _FILTER:
                    correct(q, bias, s, p, memory, sample, settings)
                    watch_rest(s, sample, settings, memory, counters)
                    if counters[s, _AT_REST]:
                        measure_rest(bias, s, p, sample, settings, error)
                        inject(q, bias, s, error[0], error[1], error[2], error[3], error[4], error[5])
            store(
                s,
                k,
                action,
                _NO_HEADING,
                quality,
                settings,
                q,
                bias,
                p,
                counters,
                sample,
                q_earth_sensor,
                bias_out,
                sigma_rad,
                flags,
            )
            if details.shape[0] > 0:
                tell(s, k, 2, action, memory, sample, details)
        mirror(p)


__all__ = ["INCLINATION_VARIANCE", "run"]
