"""Roetenberg's complementary Kalman filter with magnetic disturbance (method page 2.3), compiled.

The page carries the errors in the sensor frame; here orientation and disturbance errors are in the earth frame,
xi = R theta and delta = R d_e, where reference and gravity are constant and the transition needs no turning.
Noise is the same on all axes, so this is the same filter; the dense twin of the tests is in the sensor frame.
Of the covariance only the upper triangle is kept up to date inside the loop.

`LANES` sensors go through the equations at a time. What differs from sensor to sensor, the look at the samples, a
start, the first heading and the flags, is done one by one.
"""

import numpy as np
from numba import types
from numpy.typing import NDArray

from estimators._kernels import Scalars3, Scalars4, kernel
from estimators._lanes import (
    LANES,
    QUATERNION_TYPE,
    VECTOR_TYPE,
    anywhere,
    at_least,
    at_most,
    chosen,
    column,
    in_lanes,
    put_column,
    spread,
)
from estimators.orientation import _roetenberg_layout as at
from estimators.orientation import _strapdown_steps as steps
from estimators.orientation._lane_steps import (
    arcsine,
    either_quaternion,
    either_vector,
    multiply_lanes,
    put_quaternions,
    put_results,
    put_three,
    quaternions,
    rotate_lanes,
    three,
    turn_lanes,
)
from estimators.orientation._marzouk_covariance import Row
from estimators.orientation._roetenberg_choice import either, either_disturbance, either_state
from estimators.orientation._roetenberg_covariance import (
    ROW,
    block,
    disturbance_block,
    faded,
    keep,
    loaded,
    loaded_disturbance,
    no_disturbance,
    predicted,
    predicted_disturbance,
)
from estimators.orientation._roetenberg_detector import count_fields, detect
from estimators.orientation._roetenberg_field import begin_heading, field_flags, look_for_heading
from estimators.orientation._roetenberg_measure import field_taken, gravity_taken, spread_after
from estimators.orientation._strapdown_kernel import begin, mirror
from estimators.orientation._strapdown_steps import prepare, store_flags, tell
from estimators.recording import Float

# Numba freezes globals, not attributes of modules.
_COAST, _BEGIN, _FILTER = steps.COAST, steps.BEGIN, steps.FILTER
_RATE, _FORCE, _FIELD = steps.RATE, steps.FORCE, steps.FIELD
_SAMPLE, _INNOVATION, _GAP_VARIANCE = at.SAMPLE, steps.INNOVATION, steps.GAP_VARIANCE
_STEP_S, _RATE_VARIANCE, _BIAS_VARIANCE = steps.STEP_S, steps.RATE_VARIANCE, steps.BIAS_VARIANCE
_GRAVITY, _FIELD_NORM, _HAS_FIELD = steps.GRAVITY, steps.FIELD_NORM, steps.HAS_FIELD
_HEADING_KNOWN, _DISTURBANCE_GAIN = steps.HEADING_KNOWN, at.DISTURBANCE_GAIN
_USE_GRAVITY, _USE_FIELD, _BLOCKS_ONLY = at.USE_GRAVITY, at.USE_FIELD, at.BLOCKS_ONLY
_HELD_ACCELERATION, _CHANGE_VARIANCE, _FLOOR_VARIANCE = (
    at.HELD_ACCELERATION,
    at.CHANGE_VARIANCE,
    at.FLOOR_VARIANCE,
)
_ACCELERATION, _REFERENCE_NORM, _REFERENCE_FIELD = steps.ACCELERATION, at.REFERENCE_NORM, at.REFERENCE_FIELD
_DISTURBANCE, _SPREAD, _SMOOTH_NORM, _SMOOTH_DIP = at.DISTURBANCE, at.SPREAD, at.SMOOTH_NORM, at.SMOOTH_DIP
_ACTION, _HEADING_VARIANCE, _MEASURED, _HELD = at.ACTION, at.HEADING_VARIANCE, at.MEASURED, at.HELD
_DETAIL_DISTURBANCE, _DETAIL_NORM, _DETAIL_DIP = at.DETAIL_DISTURBANCE, at.DETAIL_NORM, at.DETAIL_DIP

_SETTINGS, _V = types.float64[::1], VECTOR_TYPE


@in_lanes(types.Tuple((QUATERNION_TYPE, ROW))(QUATERNION_TYPE, _V, _V, _SETTINGS))
def turned_by_rate(q: Scalars4, rate: Scalars3, bias: Scalars3, settings: Float) -> tuple[Scalars4, Row]:
    """Turn the estimates by the rates of the samples (A3); also return T R by rows."""
    step = settings[_STEP_S]
    tw, tx, ty, tz = turn_lanes(
        (rate[0] - bias[0]) * step, (rate[1] - bias[1]) * step, (rate[2] - bias[2]) * step
    )
    w, x, y, z = multiply_lanes(q[0], q[1], q[2], q[3], tw, tx, ty, tz)
    # One Newton step keeps the norm: it is off by rounding only.
    norm = 1.5 - 0.5 * (w * w + x * x + y * y + z * z)
    w, x, y, z = w * norm, x * norm, y * norm, z * norm
    a, b, c = 2.0 * step * x, 2.0 * step * y, 2.0 * step * z
    xx, yy, zz, xy, xz, yz = a * x, b * y, c * z, a * y, a * z, b * z
    wx, wy, wz = a * w, b * w, c * w
    return (w, x, y, z), (
        step - yy - zz,
        xy - wz,
        xz + wy,
        xy + wz,
        step - xx - zz,
        yz - wx,
        xz - wy,
        yz + wx,
        step - xx - yy,
    )


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
    samples = np.zeros((LANES, _SAMPLE))
    flat = covariance.reshape(covariance.shape[0], 81)
    use_field, telling = settings[_USE_FIELD] > 0.0, details.shape[0] > 0
    sensors, drift = quality.shape[0], settings[_BIAS_VARIANCE]
    none = spread(0.0)
    for first in range(0, sensors, LANES):
        end = min(first + LANES, sensors)
        last, beside = end - 1, end - 1 - first
        p, d = loaded(flat, first, last), loaded_disturbance(flat, first, last)
        for k in range(quality.shape[1]):
            ordinary, begun, unknown, all_measured, measured_any = True, False, False, True, False
            for s in range(first, end):
                sample = samples[s - first]
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
                sample[_ACTION] = action
                begun |= action == _BEGIN
                ordinary &= action == _FILTER
                measured = use_field and action == _FILTER and sample[_HAS_FIELD] > 0.0
                unknown |= measured and counters[s, _HEADING_KNOWN] == 0
                measured_any |= measured
                all_measured &= measured
                sample[_MEASURED] = 1.0 if measured else 0.0
            if begun:
                keep(flat, first, last, p, d)
                for s in range(first, end):
                    if samples[s - first, _ACTION] == _BEGIN:
                        begin(s, covariance[s], memory, counters, settings)
                        begin_heading(s, q, covariance, memory, counters, settings, use_field)
                        memory[s, _SPREAD] = memory[s, _SPREAD + 2] = settings[_CHANGE_VARIANCE]
                        memory[s, _SPREAD + 1] = 0.0
                p, d = loaded(flat, first, last), loaded_disturbance(flat, first, last)
            before, offset = quaternions(q, first, last), three(bias, first, last, 0)
            old_p, old_d, old_disturbance = p, d, three(memory, first, last, _DISTURBANCE)
            if settings[_BLOCKS_ONLY] > 0.0:
                p, d = block(p), disturbance_block(d)
            moved, turned = turned_by_rate(before, three(samples, 0, beside, _RATE), offset, settings)
            noise = settings[_RATE_VARIANCE] * settings[_STEP_S] * settings[_STEP_S] + column(
                samples, (0, beside, _GAP_VARIANCE)
            )
            p = predicted(p, turned, (noise, none, none, noise, none, noise), (drift, drift, drift))
            fx, fy, fz = none, none, none
            change = spread(settings[_FLOOR_VARIANCE])
            if measured_any:
                mx, my, mz = three(samples, 0, beside, _FIELD)
                fx, fy, fz = rotate_lanes(moved[0], moved[1], moved[2], moved[3], mx, my, mz)
                if unknown:
                    keep(flat, first, last, p, d)
                    put_quaternions(q, first, last, moved)
                    put_three(samples, 0, beside, _FIELD, (fx, fy, fz))
                    for s in range(first, end):
                        sample = samples[s - first]
                        if sample[_MEASURED] > 0.0 and counters[s, _HEADING_KNOWN] == 0:
                            east, north, up = sample[_FIELD], sample[_FIELD + 1], sample[_FIELD + 2]
                            look_for_heading(s, q, covariance, memory, counters, settings, east, north, up)
                            sample[_MEASURED] = 0.0
                            all_measured = False
                    moved = quaternions(q, first, last)
                    p, d = loaded(flat, first, last), loaded_disturbance(flat, first, last)
                reference = 1.0 / column(memory, (first, last, _REFERENCE_NORM))
                fx, fy, fz = fx * reference, fy * reference, fz * reference
                norm = column(samples, (0, beside, _FIELD_NORM)) * reference
                dip = arcsine(at_most(at_least(-fz * (1.0 / norm), -1.0), 1.0))
                change = detect(first, last, memory, counters, samples, settings, norm, dip)
            count_fields(first, last, memory, counters, samples, settings)
            pinned = column(samples, (0, beside, _HELD)) > 0.0
            gain = settings[_DISTURBANCE_GAIN]
            if gain != 1.0:
                d = faded(d, gain)
            d = predicted_disturbance(d, turned, change)
            dx, dy, dz = three(memory, first, last, _DISTURBANCE)
            if anywhere(pinned):
                d = either_disturbance(pinned, no_disturbance(settings[_FLOOR_VARIANCE]), d)
            kept = chosen(pinned, 0.0, gain)
            disturbance = dx * kept, dy * kept, dz * kept
            told = samples, beside, telling
            if telling:
                for s in range(first, end):
                    for i in range(5):
                        samples[s - first, _INNOVATION + 2 * i + 1] = 0.0
            state = p, d, (none, none, none, none, none, none, none, none, none)
            fxs, fys, fzs = three(samples, 0, beside, _FORCE)
            if settings[_USE_GRAVITY] > 0.0:
                force = rotate_lanes(moved[0], moved[1], moved[2], moved[3], fxs, fys, fzs)
                acceleration, about = (
                    three(memory, first, last, _ACCELERATION),
                    three(memory, first, last, _SPREAD),
                )
                state = gravity_taken(state, force, acceleration, about, told, settings, pinned)
            if measured_any:
                hx, hy, hz = three(memory, first, last, _REFERENCE_FIELD)
                expected = hx + disturbance[0], hy + disturbance[1], hz + disturbance[2]
                found = field_taken(state, expected, (fx, fy, fz), told, settings, pinned)
                if all_measured:
                    state = found
                else:
                    state = either_state(column(samples, (0, beside, _MEASURED)) > 0.0, found, state)
            found_p, found_d, e = state
            tw, tx, ty, tz = turn_lanes(-e[0], -e[1], -e[2])
            after = multiply_lanes(tw, tx, ty, tz, moved[0], moved[1], moved[2], moved[3])
            found_offset = offset[0] - e[3], offset[1] - e[4], offset[2] - e[5]
            found_disturbance = disturbance[0] - e[6], disturbance[1] - e[7], disturbance[2] - e[8]
            ax, ay, az = rotate_lanes(after[0], after[1], after[2], after[3], fxs, fys, fzs)
            acceleration = ax, ay, az - settings[_GRAVITY]
            about = spread_after(found_p, settings)
            if not ordinary:
                here = column(samples, (0, beside, _ACTION))
                corrected = (here >= _FILTER) & (here <= _FILTER)
                carried = (here >= _COAST) & (here <= _FILTER)
                found_p = either(carried, either(corrected, found_p, p), old_p)
                found_d = either_disturbance(carried, either_disturbance(corrected, found_d, d), old_d)
                after = either_quaternion(carried, either_quaternion(corrected, after, moved), before)
                found_offset = either_vector(corrected, found_offset, offset)
                found_disturbance = either_vector(
                    carried, either_vector(corrected, found_disturbance, disturbance), old_disturbance
                )
                acceleration = either_vector(
                    corrected, acceleration, three(memory, first, last, _ACCELERATION)
                )
                about = either_vector(corrected, about, three(memory, first, last, _SPREAD))
            p, d = found_p, found_d
            put_quaternions(q, first, last, after)
            put_three(bias, first, last, 0, found_offset)
            put_three(memory, first, last, _DISTURBANCE, found_disturbance)
            put_three(memory, first, last, _ACCELERATION, acceleration)
            if settings[_HELD_ACCELERATION] > 0.0:
                put_three(memory, first, last, _SPREAD, about)
            put_column(samples, (0, beside, _HEADING_VARIANCE), p[5])
            put_results(
                q_earth_sensor, bias_out, sigma_rad, first, last, k, after, found_offset, (p[0], p[3], p[5])
            )
            for s in range(first, end):
                sample = samples[s - first]
                action = int(sample[_ACTION])
                own = field_flags(s, sample[_HEADING_VARIANCE], counters, settings)
                store_flags(s, k, action, own, quality, settings, counters, sample, sigma_rad, flags)
                if telling:
                    if sample[_MEASURED] <= 0.0:
                        for i in range(2, 5):
                            sample[_INNOVATION + 2 * i + 1] = 0.0
                    tell(s, k, 5, action, memory, sample, details)
                    for i in range(3):
                        details[s, k, _DETAIL_DISTURBANCE + i] = memory[s, _DISTURBANCE + i]
                    details[s, k, _DETAIL_NORM] = memory[s, _SMOOTH_NORM]
                    details[s, k, _DETAIL_DIP] = memory[s, _SMOOTH_DIP]
        keep(flat, first, last, p, d)
        for s in range(first, end):
            mirror(covariance[s])


__all__ = ["run"]
