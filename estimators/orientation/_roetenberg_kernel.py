"""Roetenberg's complementary Kalman filter with magnetic disturbance (method page 2.3), compiled.

The page carries the errors in the sensor frame; here orientation and disturbance errors are in the earth frame,
xi = R theta and delta = R d_e, where reference and gravity are constant and the transition needs no turning.
Noise is the same on all axes, so this is the same filter; the dense twin of the tests is in the sensor frame.
Of the covariance only the upper triangle is kept up to date inside the loop.
"""

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import kernel, rotate
from estimators.orientation import _roetenberg_layout as at
from estimators.orientation import _strapdown_steps as steps
from estimators.orientation._marzouk_covariance import keep, loaded, predicted
from estimators.orientation._roetenberg_covariance import (
    faded,
    keep_disturbance,
    loaded_disturbance,
    no_disturbance,
    predicted_disturbance,
)
from estimators.orientation._roetenberg_field import (
    arcsine,
    begin_heading,
    detect,
    field_flags,
    look_for_heading,
)
from estimators.orientation._roetenberg_measure import field_taken, gravity_taken, keep_spread
from estimators.orientation._strapdown_kernel import begin, inject, mirror, turn_by_rate
from estimators.orientation._strapdown_steps import (
    keep_acceleration,
    prepare,
    store,
    tell,
)
from estimators.recording import Float

# Numba freezes globals, not attributes of modules.
_HOLD, _BEGIN, _FILTER = steps.HOLD, steps.BEGIN, steps.FILTER
_SAMPLE, _INNOVATION, _GAP_VARIANCE = steps.SAMPLE, steps.INNOVATION, steps.GAP_VARIANCE
_STEP_S, _RATE_VARIANCE, _BIAS_VARIANCE = steps.STEP_S, steps.RATE_VARIANCE, steps.BIAS_VARIANCE
_FIELD, _FIELD_NORM, _HAS_FIELD = steps.FIELD, steps.FIELD_NORM, steps.HAS_FIELD
_HEADING_KNOWN, _DISTURBANCE_GAIN = steps.HEADING_KNOWN, at.DISTURBANCE_GAIN
_USE_GRAVITY, _USE_FIELD, _BLOCKS_ONLY = at.USE_GRAVITY, at.USE_FIELD, at.BLOCKS_ONLY
_HELD_ACCELERATION, _CHANGE_VARIANCE, _FLOOR_VARIANCE = (
    at.HELD_ACCELERATION,
    at.CHANGE_VARIANCE,
    at.FLOOR_VARIANCE,
)
_REFERENCE_NORM, _DISTURBANCE = at.REFERENCE_NORM, at.DISTURBANCE
_SPREAD, _SMOOTH_NORM, _SMOOTH_DIP, _PINNED = at.SPREAD, at.SMOOTH_NORM, at.SMOOTH_DIP, at.PINNED
_DETAIL_DISTURBANCE, _DETAIL_NORM, _DETAIL_DIP = at.DETAIL_DISTURBANCE, at.DETAIL_NORM, at.DETAIL_DIP


@kernel("void(float64[:, ::1])")
def keep_blocks(p: Float) -> None:
    """Forget what the three errors have to do with each other, as the published filter does (E5)."""
    for i in range(3):
        for j in range(3):
            p[i, 3 + j] = p[i, 6 + j] = p[3 + i, 6 + j] = 0.0


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
    """Filter K ticks of S sensors; `q`, `bias`, `covariance` (S, 9, 9), memory and counts are carried on."""
    sample = np.zeros(_SAMPLE)
    use_field = settings[_USE_FIELD] > 0.0
    for s in range(quality.shape[0]):
        kept = covariance[s]
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
                begin(s, kept, memory, counters, settings)
                begin_heading(s, q, covariance, memory, counters, settings, use_field)
                memory[s, _SPREAD] = memory[s, _SPREAD + 2] = settings[_CHANGE_VARIANCE]
                memory[s, _SPREAD + 1] = 0.0
            elif action != _HOLD:
                if settings[_BLOCKS_ONLY] > 0.0:
                    keep_blocks(kept)
                turned = turn_by_rate(q, bias, s, sample, settings)
                noise = (
                    settings[_RATE_VARIANCE] * settings[_STEP_S] * settings[_STEP_S] + sample[_GAP_VARIANCE]
                )
                drift = settings[_BIAS_VARIANCE]
                p = predicted(
                    loaded(kept), turned, (noise, 0.0, 0.0, noise, 0.0, noise), (drift, drift, drift)
                )
                for i in range(5):
                    sample[_INNOVATION + 2 * i + 1] = 0.0
                fx = fy = fz = 0.0
                measured = use_field and action == _FILTER and sample[_HAS_FIELD] > 0.0
                change = settings[_FLOOR_VARIANCE]
                if measured:
                    w, x, y, z = q[s, 0], q[s, 1], q[s, 2], q[s, 3]
                    fx, fy, fz = rotate(w, x, y, z, sample[_FIELD], sample[_FIELD + 1], sample[_FIELD + 2])
                    if counters[s, _HEADING_KNOWN] == 0:
                        keep(kept, p)
                        look_for_heading(s, q, covariance, memory, counters, settings, fx, fy, fz)
                        p = loaded(kept)
                        measured = False
                    else:
                        reference = 1.0 / memory[s, _REFERENCE_NORM]
                        fx, fy, fz = fx * reference, fy * reference, fz * reference
                        norm = sample[_FIELD_NORM] * reference
                        dip = arcsine(min(max(-fz * (1.0 / norm), -1.0), 1.0))
                        change = detect(s, memory, counters, settings, norm, dip)
                pinned = counters[s, _PINNED] != 0
                gain = settings[_DISTURBANCE_GAIN]
                d = loaded_disturbance(kept)
                if pinned:
                    gain = 0.0
                    d = no_disturbance(settings[_FLOOR_VARIANCE])
                else:
                    if gain != 1.0:
                        d = faded(d, gain)
                    d = predicted_disturbance(d, turned, change)
                for i in range(3):
                    memory[s, _DISTURBANCE + i] *= gain
                if action == _FILTER:
                    state = p, d, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
                    # Written out twice, so that a branch is taken once and not at each of five rows.
                    if settings[_USE_GRAVITY] > 0.0:
                        if pinned:
                            state = gravity_taken(state, q, s, memory, sample, settings, True)
                        else:
                            state = gravity_taken(state, q, s, memory, sample, settings, False)
                    if measured:
                        if pinned:
                            state = field_taken(state, s, memory, sample, settings, True, fx, fy, fz)
                        else:
                            state = field_taken(state, s, memory, sample, settings, False, fx, fy, fz)
                    p, d, error = state
                    inject(q, bias, s, error[0], error[1], error[2], error[3], error[4], error[5])
                    for i in range(3):
                        memory[s, _DISTURBANCE + i] -= error[6 + i]
                    keep_acceleration(s, q, memory, sample, settings)
                    if settings[_HELD_ACCELERATION] > 0.0:
                        keep_spread(s, p[0], p[1], p[3], memory, settings)
                keep(kept, p)
                keep_disturbance(kept, d)
            store(
                s,
                k,
                action,
                field_flags(s, kept, counters, settings),
                quality,
                settings,
                q,
                bias,
                kept,
                counters,
                sample,
                q_earth_sensor,
                bias_out,
                sigma_rad,
                flags,
            )
            if details.shape[0] > 0:
                tell(s, k, 5, action, memory, sample, details)
                for i in range(3):
                    details[s, k, _DETAIL_DISTURBANCE + i] = memory[s, _DISTURBANCE + i]
                details[s, k, _DETAIL_NORM] = memory[s, _SMOOTH_NORM]
                details[s, k, _DETAIL_DIP] = memory[s, _SMOOTH_DIP]
        mirror(kept)


__all__ = ["run"]
