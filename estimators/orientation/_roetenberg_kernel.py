"""Roetenberg's complementary Kalman filter with magnetic disturbance (method page 2.3), compiled.

The page carries the errors in the sensor frame; here orientation and disturbance errors are in the earth frame,
xi = R theta and delta = R d_e, where reference and gravity are constant and the transition needs no turning.
Noise is the same on all axes, so this is the same filter; the dense twin of the tests is in the sensor frame.
Of the covariance only the upper triangle is kept up to date inside the loop.
"""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import kernel, rotate
from estimators.orientation import _roetenberg_layout as at
from estimators.orientation import _strapdown_steps as steps
from estimators.orientation._roetenberg_field import begin_heading, detect, field_flags, look_for_heading
from estimators.orientation._roetenberg_measure import keep_spread, measure_field, measure_gravity
from estimators.orientation._strapdown_kernel import (
    Row,
    begin,
    inject,
    mirror,
    predict_covariance,
    turn_by_rate,
)
from estimators.orientation._strapdown_steps import (
    keep_acceleration,
    prepare,
    store,
    tell,
)
from estimators.recording import Float

# Numba freezes globals, not attributes of modules.
_HOLD, _BEGIN, _FILTER = steps.HOLD, steps.BEGIN, steps.FILTER
_SAMPLE, _INNOVATION, _ACCELERATION = steps.SAMPLE, steps.INNOVATION, steps.ACCELERATION
_FIELD, _FIELD_NORM, _HAS_FIELD = steps.FIELD, steps.FIELD_NORM, steps.HAS_FIELD
_ACCELERATION_GAIN, _GRAVITY, _HEADING_KNOWN = steps.ACCELERATION_GAIN, steps.GRAVITY, steps.HEADING_KNOWN
_USE_GRAVITY, _USE_FIELD, _BLOCKS_ONLY = at.USE_GRAVITY, at.USE_FIELD, at.BLOCKS_ONLY
_HELD_ACCELERATION, _CHANGE_VARIANCE, _FORCE_VARIANCE = (
    at.HELD_ACCELERATION,
    at.CHANGE_VARIANCE,
    at.FORCE_VARIANCE,
)
_FIELD_VARIANCE, _FLOOR_VARIANCE, _DISTURBANCE_GAIN = (
    at.FIELD_VARIANCE,
    at.FLOOR_VARIANCE,
    at.DISTURBANCE_GAIN,
)
_REFERENCE_NORM, _REFERENCE_FIELD, _DISTURBANCE = at.REFERENCE_NORM, at.REFERENCE_FIELD, at.DISTURBANCE
_SPREAD, _SMOOTH_NORM, _SMOOTH_DIP, _PINNED = at.SPREAD, at.SMOOTH_NORM, at.SMOOTH_DIP, at.PINNED
_DETAIL_DISTURBANCE, _DETAIL_NORM, _DETAIL_DIP = at.DETAIL_DISTURBANCE, at.DETAIL_NORM, at.DETAIL_DIP


@kernel("void(float64[:, ::1])")
def keep_blocks(p: Float) -> None:
    """Forget what the three errors have to do with each other, as the published filter does (E5)."""
    for i in range(3):
        for j in range(3):
            p[i, 3 + j] = p[i, 6 + j] = p[3 + i, 6 + j] = 0.0


@kernel("void(float64[:, ::1], UniTuple(float64, 9), float64, float64)", inlined=True)
def predict_disturbance(p: Float, turned: Row, gain: float, change: float) -> None:
    """Carry the blocks of the disturbance: delta' = c_d delta + w_d, and xi' = xi - T R b against it."""
    r00, r01, r02, r10, r11, r12, r20, r21, r22 = turned
    for j in range(6, 9):
        b0, b1, b2 = p[3, j], p[4, j], p[5, j]
        p[0, j] = gain * (p[0, j] - (r00 * b0 + r01 * b1 + r02 * b2))
        p[1, j] = gain * (p[1, j] - (r10 * b0 + r11 * b1 + r12 * b2))
        p[2, j] = gain * (p[2, j] - (r20 * b0 + r21 * b1 + r22 * b2))
        p[3, j], p[4, j], p[5, j] = gain * b0, gain * b1, gain * b2
    square = gain * gain
    p[6, 6] = square * p[6, 6] + change
    p[7, 7] = square * p[7, 7] + change
    p[8, 8] = square * p[8, 8] + change
    p[6, 7] *= square
    p[6, 8] *= square
    p[7, 8] *= square


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
    sample, error = np.zeros(_SAMPLE), np.zeros(9)
    use_field = settings[_USE_FIELD] > 0.0
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
                begin_heading(s, q, covariance, memory, counters, settings, use_field)
                memory[s, _SPREAD] = memory[s, _SPREAD + 2] = settings[_CHANGE_VARIANCE]
                memory[s, _SPREAD + 1] = 0.0
            elif action != _HOLD:
                if settings[_BLOCKS_ONLY] > 0.0:
                    keep_blocks(p)
                turned = turn_by_rate(q, bias, s, sample, settings)
                predict_covariance(p, turned, sample, settings)
                for i in range(9):
                    error[i] = 0.0
                for i in range(5):
                    sample[_INNOVATION + 2 * i + 1] = 0.0
                fx = fy = fz = 0.0
                measured = use_field and action == _FILTER and sample[_HAS_FIELD] > 0.0
                change = settings[_FLOOR_VARIANCE]
                if measured:
                    w, x, y, z = q[s, 0], q[s, 1], q[s, 2], q[s, 3]
                    fx, fy, fz = rotate(w, x, y, z, sample[_FIELD], sample[_FIELD + 1], sample[_FIELD + 2])
                    if counters[s, _HEADING_KNOWN] == 0:
                        look_for_heading(s, q, covariance, memory, counters, settings, fx, fy, fz)
                        measured = False
                    else:
                        reference = 1.0 / memory[s, _REFERENCE_NORM]
                        fx, fy, fz = fx * reference, fy * reference, fz * reference
                        norm = sample[_FIELD_NORM] * reference
                        dip = math.asin(min(max(-fz / norm, -1.0), 1.0))
                        change = detect(s, memory, counters, settings, norm, dip)
                states = 9
                if counters[s, _PINNED]:
                    states = 6
                    for i in range(3):
                        memory[s, _DISTURBANCE + i] = 0.0
                        p[6 + i, 6 + i] = settings[_FLOOR_VARIANCE]
                        for j in range(6 + i):
                            p[j, 6 + i] = 0.0
                else:
                    gain = settings[_DISTURBANCE_GAIN]
                    predict_disturbance(p, turned, gain, change)
                    for i in range(3):
                        memory[s, _DISTURBANCE + i] *= gain
                if action == _FILTER:
                    if settings[_USE_GRAVITY] > 0.0:
                        measure_gravity(q, s, p, memory, sample, settings, error, states)
                    if measured:
                        measure_field(s, p, memory, sample, settings, error, states, fx, fy, fz)
                    inject(q, bias, s, error[0], error[1], error[2], error[3], error[4], error[5])
                    for i in range(3):
                        memory[s, _DISTURBANCE + i] -= error[6 + i]
                    keep_acceleration(s, q, memory, sample, settings)
                    if settings[_HELD_ACCELERATION] > 0.0:
                        keep_spread(s, p, memory, settings)
            store(
                s,
                k,
                action,
                field_flags(s, p, counters, settings),
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
                tell(s, k, 5, action, memory, sample, details)
                for i in range(3):
                    details[s, k, _DETAIL_DISTURBANCE + i] = memory[s, _DISTURBANCE + i]
                details[s, k, _DETAIL_NORM] = memory[s, _SMOOTH_NORM]
                details[s, k, _DETAIL_DIP] = memory[s, _SMOOTH_DIP]
        mirror(p)


__all__ = ["run"]
