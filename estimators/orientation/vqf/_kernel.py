"""VQF over sensors and ticks: heading, gaps and the loop; inclination and bias are in `_steps`."""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import kernel, multiply, rotate
from estimators.kernels import Record, step
from estimators.orientation._strapdown_steps import Estimates, Ticks, run_signature
from estimators.orientation.vqf._quality import annotate, annotate_missing
from estimators.orientation.vqf._steps import (
    SETTINGS,
    SETTLED_S,
    STATE,
    correct_inclination,
    low_pass,
    predict,
    restart,
    sensor_attitude,
)
from estimators.recording import Float, SampleQuality

_SAMPLE_MISSING = int(SampleQuality.MISSING)

NO_FIELD, TRUSTED, REJECTED = range(3)
"""What became of the magnetometer's sample."""


@step()
def judge_field(x: Record, c: Record, norm: float, dip: float) -> None:
    """Compare the field with the reference, and with a candidate that may become the reference."""
    norm_off, dip_off = norm - x.field_norm, dip - x.field_dip
    if abs(norm_off) < c.norm_tolerance * x.field_norm and abs(dip_off) < c.dip_tolerance:
        x.undisturbed_s += c.step_s
        if x.undisturbed_s >= c.undisturbed_minimum_s:
            x.is_field_rejected = 0
            x.field_norm += c.reference_gain * norm_off
            x.field_dip += c.reference_gain * dip_off
    else:
        x.undisturbed_s = 0.0
        x.is_field_rejected = 1
    norm_off, dip_off = norm - x.candidate_norm, dip - x.candidate_dip
    if abs(norm_off) < c.norm_tolerance * x.candidate_norm and abs(dip_off) < c.dip_tolerance:
        rate = math.sqrt(x.rest_rate[0] ** 2 + x.rest_rate[1] ** 2 + x.rest_rate[2] ** 2)
        if rate >= c.new_field_rate:
            x.candidate_s += c.step_s
        x.candidate_norm += c.reference_gain * norm_off
        x.candidate_dip += c.reference_gain * dip_off
        is_first = x.field_norm == 0.0 and x.candidate_s >= c.first_field_s
        if x.is_field_rejected and (x.candidate_s >= c.new_field_s or is_first):
            x.field_norm, x.field_dip = x.candidate_norm, x.candidate_dip
            x.is_field_rejected = 0
            x.undisturbed_s = c.undisturbed_minimum_s
    else:
        x.candidate_s = 0.0
        x.candidate_norm, x.candidate_dip = norm, dip


@step()
def heading_gain(x: Record, c: Record) -> float:
    """Return how much of the way to the measured heading is gone: less or none while the field is rejected."""
    gain = c.heading_gain
    if c.rejects:
        if x.is_field_rejected:
            if x.rejected_s <= c.rejected_maximum_s:
                x.rejected_s += c.step_s
                gain = 0.0
            else:
                gain /= c.rejection_factor
        else:
            x.rejected_s = max(x.rejected_s - c.rejection_factor * c.step_s, 0.0)
    start = x.start_gain
    if start != 0.0:
        # The mean of the first samples: gain 1/n.
        gain = max(gain, start)
        start = start / (start + 1.0)
        x.start_gain = 0.0 if start * c.heading_time_s < c.step_s else start
    return float(gain)


@step()
def correct_heading(x: Record, c: Record, mx: float, my: float, mz: float, values: Float) -> None:
    """Follow the field's horizontal direction unless norm and dip say that it is disturbed."""
    w, qx, y, z = sensor_attitude(x)
    mx, my, mz = rotate(w, qx, y, z, mx, my, mz)
    if c.rejects:
        norm = math.sqrt(mx * mx + my * my + mz * mz)
        values[0], values[1] = norm, -math.asin(min(max(mz / norm, -1.0), 1.0))
        if c.field_low_pass[SETTLED_S] > 0.0:
            low_pass(x.field_filter, c.field_low_pass, c.step_s, 2, values)
        judge_field(x, c, values[0], values[1])
    away = math.atan2(mx, my) - x.delta
    if away > math.pi:
        away -= 2.0 * math.pi
    elif away < -math.pi:
        away += 2.0 * math.pi
    delta = x.delta + heading_gain(x, c) * away
    if delta > math.pi:
        delta -= 2.0 * math.pi
    elif delta < -math.pi:
        delta += 2.0 * math.pi
    x.delta = delta


@step()
def take_field(ticks: Ticks, s: int, k: int, x: Record, c: Record, values: Float) -> int:
    """Correct the heading by the magnetometer, where it is finite; say what became of it."""
    if ticks.magnetometer_t.shape[0] == 0:
        return NO_FIELD
    mx = 1e6 * ticks.magnetometer_t[s, k, 0]
    my = 1e6 * ticks.magnetometer_t[s, k, 1]
    mz = 1e6 * ticks.magnetometer_t[s, k, 2]
    if not math.isfinite(mx + my + mz) or (mx == 0.0 and my == 0.0 and mz == 0.0):
        return NO_FIELD
    if c.latency_s != 0.0:
        rate, latency = ticks.gyroscope_radps, c.latency_s
        wx, wy, wz = rate[s, k, 0], rate[s, k, 1], rate[s, k, 2]
        # What it will read when its delay is over, to first order: m - tau w x m.
        mx, my, mz = (
            mx - latency * (wy * mz - wz * my),
            my - latency * (wz * mx - wx * mz),
            mz - latency * (wx * my - wy * mx),
        )
    correct_heading(x, c, mx, my, mz, values)
    return REJECTED if x.is_field_rejected else TRUSTED


@step()
def largest_sigma(p: Float, c: Record) -> float:
    """Return a bound on the bias's sigma in rad/s: the largest row sum bounds the largest eigenvalue."""
    largest = 0.0
    for i in range(3):
        largest = max(largest, abs(p[i, 0]) + abs(p[i, 1]) + abs(p[i, 2]))
    return math.sqrt(min(largest, c.bias_start_variance)) * (math.pi / 18000.0)


@kernel(run_signature(SETTINGS, STATE))
def run(
    ticks: Ticks, settings: NDArray[np.void], state: NDArray[np.void], covariance: Float, out: Estimates
) -> None:
    """Filter K ticks of S sensors; `state` and the bias's `covariance` (S, 3, 3) are carried on."""
    values, work = np.zeros(9), np.zeros((4, 9))
    c, quality, force, rate = settings[0], ticks.quality, ticks.accelerometer_mps2, ticks.gyroscope_radps
    for s in range(quality.shape[0]):
        x, p = state[s], covariance[s]
        for k in range(quality.shape[1]):
            wx, wy, wz = rate[s, k, 0], rate[s, k, 1], rate[s, k, 2]
            fx, fy, fz = force[s, k, 0], force[s, k, 1], force[s, k, 2]
            # The sum is finite exactly when every part is (unless it overflows, which is as bad).
            if (quality[s, k] & _SAMPLE_MISSING) == 0 and math.isfinite(wx + wy + wz + fx + fy + fz):
                if x.is_in_gap:
                    restart(x, c)
                    x.is_in_gap = 0
                x.is_started = 1
                predict(x, c, wx, wy, wz, values)
                if fx != 0.0 or fy != 0.0 or fz != 0.0:
                    correct_inclination(x, p, c, fx, fy, fz, values, work)
                became = take_field(ticks, s, k, x, c, values)
                w, qx, y, z = sensor_attitude(x)
                half = 0.5 * x.delta
                x.q[0], x.q[1], x.q[2], x.q[3] = multiply(
                    math.cos(half), 0.0, 0.0, math.sin(half), w, qx, y, z
                )
                norm = math.sqrt(fx * fx + fy * fy + fz * fz)
                annotate(
                    out,
                    s,
                    k,
                    x,
                    c,
                    quality[s, k],
                    norm,
                    became != NO_FIELD,
                    became == REJECTED,
                    largest_sigma(p, c),
                )
            else:
                if x.is_started:
                    x.is_in_gap = 1
                annotate_missing(out, s, k, x, quality[s, k])
            for i in range(4):
                out.q[s, k, i] = x.q[i]
            for axis in range(3):
                out.bias[s, k, axis] = x.bias[axis]
