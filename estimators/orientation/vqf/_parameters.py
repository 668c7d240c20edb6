"""Parameters of VQF, and the constants that its kernels make of them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from estimators.orientation._parameters import parameter


@dataclass(frozen=True)
class VqfParameters:
    """The parameters of the authors' package under names with units, at its defaults, and five of ours at the end."""

    accelerometer_time_constant_s: float = parameter(3.0, "s", "in which inclination follows", above=0.0)
    magnetometer_time_constant_s: float = parameter(
        9.0, "s", "in which heading follows; below zero never", above=-math.inf
    )
    motion_bias_estimation: bool = parameter(True, "", "learn the gyroscope bias in motion")
    rest_bias_estimation: bool = parameter(True, "", "learn the gyroscope bias at rest")
    magnetic_disturbance_rejection: bool = parameter(True, "", "ignore a field of another norm or dip")
    bias_sigma_initial_degps: float = parameter(0.5, "deg/s", "of the bias before any calibration")
    bias_forgetting_time_s: float = parameter(
        100.0, "s", "in which sigma of the bias grows by 0.1 deg/s", above=0.0
    )
    bias_clip_degps: float = parameter(2.0, "deg/s", "largest bias")
    bias_sigma_motion_degps: float = parameter(0.1, "deg/s", "of the bias learned in lasting motion")
    bias_vertical_forgetting_factor: float = parameter(0.0001, "", "weight of the vertical part in motion")
    bias_sigma_rest_degps: float = parameter(0.03, "deg/s", "of the bias learned in lasting rest")
    rest_minimum_s: float = parameter(1.5, "s", "without motion that is rest")
    rest_time_constant_s: float = parameter(0.5, "s", "of the low-pass that rest is judged by", above=0.0)
    rest_gyroscope_threshold_degps: float = parameter(2.0, "deg/s", "deviation that is motion")
    rest_accelerometer_threshold_mps2: float = parameter(0.5, "m/s^2", "deviation that is motion")
    magnetic_current_time_constant_s: float = parameter(0.05, "s", "of the low-pass of norm and dip")
    magnetic_reference_time_constant_s: float = parameter(
        20.0, "s", "in which the reference field is learned"
    )
    magnetic_norm_tolerance: float = parameter(0.1, "", "share of the norm that the field may be off")
    magnetic_dip_tolerance_deg: float = parameter(10.0, "deg", "that the field may be off")
    magnetic_new_field_s: float = parameter(20.0, "s", "in motion after which a new field is the reference")
    magnetic_first_field_s: float = parameter(5.0, "s", "the same for the first field")
    magnetic_new_field_minimum_degps: float = parameter(20.0, "deg/s", "rate that is such motion")
    magnetic_minimum_undisturbed_s: float = parameter(0.5, "s", "after which a sound field is trusted again")
    magnetic_maximum_rejection_s: float = parameter(60.0, "s", "that a field is rejected altogether")
    magnetic_rejection_factor: float = parameter(2.0, "", "on the time constant after that", above=0.0)
    magnetometer_latency_s: float = parameter(
        0.0, "s", "delay against the gyroscope, undone to first order by the measured rate", above=-math.inf
    )
    restart_inclination_weight_s: float = parameter(
        0.1, "s", "of new measurements that the inclination held through a gap counts as much as"
    )
    restart_heading_weight_s: float = parameter(
        0.25, "s", "of new measurements that the heading held through a gap counts as much as"
    )
    convergence_s: float = parameter(3.0, "s", "after a start in which estimates are flagged as converging")
    acceleration_tolerance_mps2: float = parameter(2.0, "m/s^2", "force off gravity that is flagged")


def in_bias_units(degps: float) -> float:
    """Convert degrees a second to the 0.01 degrees a second of the bias covariance."""
    return 100.0 * degps


def _butterworth(time_constant_s: float, step_s: float) -> list[float]:
    """Return b0 b1 b2 a1 a2 of the second-order low-pass with this time constant, and the constant.

    The time constant is that of the damped step response. Shorter than half a step, nothing is filtered.
    """
    if time_constant_s < 0.5 * step_s:
        return [1.0, 0.0, 0.0, 0.0, 0.0, time_constant_s]
    c = math.tan(math.sqrt(2.0) / 2.0 / time_constant_s * step_s)
    d = c * c + math.sqrt(2.0) * c + 1.0
    b0 = c * c / d
    return [
        b0,
        2.0 * b0,
        b0,
        2.0 * (c * c - 1.0) / d,
        (1.0 - math.sqrt(2.0) * c + c * c) / d,
        time_constant_s,
    ]


def _gain(time_constant_s: float, step_s: float) -> float:
    """Return the gain of a first-order low-pass: none below zero, all at zero."""
    if time_constant_s < 0.0:
        return 0.0
    return 1.0 if time_constant_s == 0.0 else -math.expm1(-step_s / time_constant_s)


def settings_of(p: VqfParameters, step_s: float) -> dict[str, float | Sequence[float]]:
    """Return the constants of the kernels for one time step; their record has these fields in this order."""
    # The drift brings the bias from known to 0.1 degrees a second of doubt in the forgetting time.
    drift = in_bias_units(0.1) ** 2 * step_s / p.bias_forgetting_time_s

    def weight(sigma_degps: float) -> float:
        """Measurement variance that makes this sigma the steady state."""
        variance = in_bias_units(sigma_degps) ** 2
        return variance**2 / drift + variance

    motion_weight = weight(p.bias_sigma_motion_degps)
    return {
        "step_s": step_s,
        "force_low_pass": _butterworth(p.accelerometer_time_constant_s, step_s),
        "rest_low_pass": _butterworth(p.rest_time_constant_s, step_s),
        "field_low_pass": _butterworth(p.magnetic_current_time_constant_s, step_s),
        "heading_gain": _gain(p.magnetometer_time_constant_s, step_s),
        "reference_gain": _gain(p.magnetic_reference_time_constant_s, step_s),
        "learns_in_motion": p.motion_bias_estimation,
        "learns_at_rest": p.rest_bias_estimation,
        "rejects": p.magnetic_disturbance_rejection,
        # Variances and weights of the bias in squares of 0.01 degrees a second.
        "bias_start_variance": in_bias_units(p.bias_sigma_initial_degps) ** 2,
        "bias_drift": drift,
        "bias_limit": math.radians(p.bias_clip_degps),
        "motion_weight": motion_weight,
        "vertical_weight": motion_weight / max(p.bias_vertical_forgetting_factor, 1e-10),
        "rest_weight": weight(p.bias_sigma_rest_degps),
        "rest_minimum_s": p.rest_minimum_s,
        "rest_rate_limit": math.radians(p.rest_gyroscope_threshold_degps),
        "rest_force_limit": p.rest_accelerometer_threshold_mps2,
        "norm_tolerance": p.magnetic_norm_tolerance,
        "dip_tolerance": math.radians(p.magnetic_dip_tolerance_deg),
        "new_field_s": p.magnetic_new_field_s,
        "first_field_s": p.magnetic_first_field_s,
        "new_field_rate": math.radians(p.magnetic_new_field_minimum_degps),
        "undisturbed_minimum_s": p.magnetic_minimum_undisturbed_s,
        "rejected_maximum_s": p.magnetic_maximum_rejection_s,
        "rejection_factor": p.magnetic_rejection_factor,
        "heading_time_s": p.magnetometer_time_constant_s,
        "latency_s": p.magnetometer_latency_s,
        "restart_tilt_samples": p.restart_inclination_weight_s / step_s,
        "restart_gain": 1.0 / (1.0 + p.restart_heading_weight_s / step_s),
        "convergence_s": p.convergence_s,
        "acceleration_tolerance": p.acceleration_tolerance_mps2,
        "tilt_time_s": p.accelerometer_time_constant_s,
    }
