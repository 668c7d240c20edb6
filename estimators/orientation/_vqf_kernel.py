"""VQF over sensors and ticks: heading, gaps and the loop; inclination and bias are in `_vqf_steps`."""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import kernel, multiply, rotate
from estimators.orientation._vqf_steps import (
    BIAS,
    BIAS_COVARIANCE,
    BIAS_START_VARIANCE,
    CANDIDATE_DIP,
    CANDIDATE_NORM,
    CANDIDATE_S,
    DELTA,
    DIP_TOLERANCE,
    FIELD_COEFFICIENTS,
    FIELD_DIP,
    FIELD_FILTER,
    FIELD_NORM,
    FIELD_REJECTED,
    FIRST_FIELD_S,
    HEADING_GAIN,
    HEADING_TIME_S,
    IN_GAP,
    LATENCY_S,
    NEW_FIELD_RATE,
    NEW_FIELD_S,
    NORM_TOLERANCE,
    REFERENCE_GAIN,
    REJECTED_MAXIMUM_S,
    REJECTED_S,
    REJECTION,
    REJECTION_FACTOR,
    REST_RATE,
    START_GAIN,
    STARTED,
    STEP_S,
    UNDISTURBED_MINIMUM_S,
    UNDISTURBED_S,
    correct_inclination,
    low_pass,
    predict,
    restart,
)
from estimators.recording import Float


@kernel("void(float64[::1], float64[::1], float64, float64)")
def judge_field(state: Float, settings: Float, norm: float, dip: float) -> None:
    """Compare the field with the reference, and with a candidate that may become the reference."""
    step, gain = settings[STEP_S], settings[REFERENCE_GAIN]
    norm_off, dip_off = norm - state[FIELD_NORM], dip - state[FIELD_DIP]
    if (
        abs(norm_off) < settings[NORM_TOLERANCE] * state[FIELD_NORM]
        and abs(dip_off) < settings[DIP_TOLERANCE]
    ):
        state[UNDISTURBED_S] += step
        if state[UNDISTURBED_S] >= settings[UNDISTURBED_MINIMUM_S]:
            state[FIELD_REJECTED] = 0.0
            state[FIELD_NORM] += gain * norm_off
            state[FIELD_DIP] += gain * dip_off
    else:
        state[UNDISTURBED_S] = 0.0
        state[FIELD_REJECTED] = 1.0
    norm_off, dip_off = norm - state[CANDIDATE_NORM], dip - state[CANDIDATE_DIP]
    if (
        abs(norm_off) < settings[NORM_TOLERANCE] * state[CANDIDATE_NORM]
        and abs(dip_off) < settings[DIP_TOLERANCE]
    ):
        rate = math.sqrt(state[REST_RATE] ** 2 + state[REST_RATE + 1] ** 2 + state[REST_RATE + 2] ** 2)
        if rate >= settings[NEW_FIELD_RATE]:
            state[CANDIDATE_S] += step
        state[CANDIDATE_NORM] += gain * norm_off
        state[CANDIDATE_DIP] += gain * dip_off
        lasting = state[CANDIDATE_S] >= settings[NEW_FIELD_S]
        first = state[FIELD_NORM] == 0.0 and state[CANDIDATE_S] >= settings[FIRST_FIELD_S]
        if state[FIELD_REJECTED] > 0.0 and (lasting or first):
            state[FIELD_NORM], state[FIELD_DIP] = state[CANDIDATE_NORM], state[CANDIDATE_DIP]
            state[FIELD_REJECTED] = 0.0
            state[UNDISTURBED_S] = settings[UNDISTURBED_MINIMUM_S]
    else:
        state[CANDIDATE_S] = 0.0
        state[CANDIDATE_NORM], state[CANDIDATE_DIP] = norm, dip


@kernel("void(float64[::1], float64[::1], float64, float64, float64, float64[::1])")
def correct_heading(state: Float, settings: Float, mx: float, my: float, mz: float, values: Float) -> None:
    """Follow the field's horizontal direction unless norm and dip say that it is disturbed."""
    step = settings[STEP_S]
    w, x, y, z = multiply(state[4], state[5], state[6], state[7], state[0], state[1], state[2], state[3])
    mx, my, mz = rotate(w, x, y, z, mx, my, mz)
    rejecting = settings[REJECTION] > 0.0
    if rejecting:
        norm = math.sqrt(mx * mx + my * my + mz * mz)
        values[0], values[1] = norm, -math.asin(min(max(mz / norm, -1.0), 1.0))
        if settings[FIELD_COEFFICIENTS + 5] > 0.0:
            low_pass(state, FIELD_FILTER, 2, settings, FIELD_COEFFICIENTS, values)
        judge_field(state, settings, values[0], values[1])
    away = math.atan2(mx, my) - state[DELTA]
    if away > math.pi:
        away -= 2.0 * math.pi
    elif away < -math.pi:
        away += 2.0 * math.pi
    gain = settings[HEADING_GAIN]
    if rejecting:
        if state[FIELD_REJECTED] > 0.0:
            if state[REJECTED_S] <= settings[REJECTED_MAXIMUM_S]:
                state[REJECTED_S] += step
                gain = 0.0
            else:
                gain /= settings[REJECTION_FACTOR]
        else:
            state[REJECTED_S] = max(state[REJECTED_S] - settings[REJECTION_FACTOR] * step, 0.0)
    start = state[START_GAIN]
    if start != 0.0:
        # The mean of the first samples: gain 1/n.
        gain = max(gain, start)
        start = start / (start + 1.0)
        state[START_GAIN] = 0.0 if start * settings[HEADING_TIME_S] < step else start
    delta = state[DELTA] + gain * away
    if delta > math.pi:
        delta -= 2.0 * math.pi
    elif delta < -math.pi:
        delta += 2.0 * math.pi
    state[DELTA] = delta


@kernel("float64(float64[::1], float64[::1])")
def largest_sigma(state: Float, settings: Float) -> float:
    """Return a bound on the bias's sigma in rad/s: the largest row sum bounds the largest eigenvalue."""
    p = BIAS_COVARIANCE
    largest = 0.0
    for i in range(3):
        row = abs(state[p + 3 * i]) + abs(state[p + 3 * i + 1]) + abs(state[p + 3 * i + 2])
        largest = max(largest, row)
    return math.sqrt(min(largest, settings[BIAS_START_VARIANCE])) * (math.pi / 18000.0)


@kernel(
    "void(float64[:, :, ::1], float64[:, :, ::1], float64[:, :, ::1], boolean[:, ::1], float64[::1],"
    "float64[:, ::1], float64[:, ::1], float64[:, :, ::1], float64[:, :, ::1], float64[:, ::1],"
    "boolean[:, ::1], boolean[:, ::1])"
)
def run(
    gyroscope_radps: Float,
    accelerometer_mps2: Float,
    magnetometer_t: Float,
    usable: NDArray[np.bool_],
    settings: Float,
    states: Float,
    q_held: Float,
    q_earth_sensor: Float,
    bias: Float,
    bias_sigma: Float,
    field_measured: NDArray[np.bool_],
    field_rejected: NDArray[np.bool_],
) -> None:
    """Filter K ticks of S sensors; `states` (S, STATE) and `q_held` (S, 4) are carried on."""
    values = np.zeros(9)
    work = np.zeros((4, 9))
    has_field = magnetometer_t.shape[0] > 0
    latency = settings[LATENCY_S]
    for s in range(usable.shape[0]):
        state = states[s]
        for k in range(usable.shape[1]):
            field_measured[s, k] = field_rejected[s, k] = False
            bias_sigma[s, k] = 0.0
            if usable[s, k]:
                if state[IN_GAP] > 0.0:
                    restart(state, settings)
                    state[IN_GAP] = 0.0
                state[STARTED] = 1.0
                wx, wy, wz = gyroscope_radps[s, k, 0], gyroscope_radps[s, k, 1], gyroscope_radps[s, k, 2]
                predict(state, settings, wx, wy, wz, values)
                fx, fy, fz = (
                    accelerometer_mps2[s, k, 0],
                    accelerometer_mps2[s, k, 1],
                    accelerometer_mps2[s, k, 2],
                )
                if fx != 0.0 or fy != 0.0 or fz != 0.0:
                    correct_inclination(state, settings, fx, fy, fz, values, work)
                if has_field:
                    mx = 1e6 * magnetometer_t[s, k, 0]
                    my = 1e6 * magnetometer_t[s, k, 1]
                    mz = 1e6 * magnetometer_t[s, k, 2]
                    if math.isfinite(mx + my + mz) and (mx != 0.0 or my != 0.0 or mz != 0.0):
                        if latency != 0.0:
                            # What it will read when its delay is over, to first order: m - tau w x m.
                            mx, my, mz = (
                                mx - latency * (wy * mz - wz * my),
                                my - latency * (wz * mx - wx * mz),
                                mz - latency * (wx * my - wy * mx),
                            )
                        correct_heading(state, settings, mx, my, mz, values)
                        field_measured[s, k] = True
                        field_rejected[s, k] = state[FIELD_REJECTED] > 0.0
                w, x, y, z = multiply(
                    state[4], state[5], state[6], state[7], state[0], state[1], state[2], state[3]
                )
                half = 0.5 * state[DELTA]
                w, x, y, z = multiply(math.cos(half), 0.0, 0.0, math.sin(half), w, x, y, z)
                q_held[s, 0], q_held[s, 1], q_held[s, 2], q_held[s, 3] = w, x, y, z
                bias_sigma[s, k] = largest_sigma(state, settings)
            elif state[STARTED] > 0.0:
                state[IN_GAP] = 1.0
            for i in range(4):
                q_earth_sensor[s, k, i] = q_held[s, i]
            for axis in range(3):
                bias[s, k, axis] = state[BIAS + axis]
