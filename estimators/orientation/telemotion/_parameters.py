"""The tuning of our own filter: one set for all sensors, places and movements, and why each value is what it is."""

import math
from dataclasses import dataclass

import numpy as np

from estimators.orientation.telemotion import _layout as at
from estimators.recording import Float


@dataclass(frozen=True)
class TelemotionParameters:
    """Parameters of the filter; noise densities are per root second, so that no value depends on the rate.

    Gyroscope: `rate_noise_*` is what integrates without being seen, the second part grows with the rate of turn
    (errors of scale that change); `gain_sigma` is the spread of scale and axis errors of devices.
    Specific force: the integral of what is left beside gravity must stay near one place:
    `position_prior_m_sqrt_s`, with `speed_noise_mps_per_sqrt_s` for all that bends this.
    Rest: its rate is the gyroscope's bias, but people who stand still sway, and who hold an arm up lowers it
    slowly. What the mean rate sways about that of `rest_sure_s` adds to `rest_bias_sigma_degps_sqrt_s`, for
    `rest_sway_s` each; and when the latter is off the bias by more than its uncertainty and
    `rest_surprise_degps`, it is doubted.
    Magnetic field (microtesla): `field_noise_*_ut_sqrt_s` stand for errors that last for seconds, hence their
    size; at rest they last as long as the rest. A block whose residual is `field_scale_ut` or more, alone or on
    average over `field_level_s`, loses weight; of a residual that only turns the heading, `field_turn_free` is
    forgiven, for it may be the heading's own. A rest tells once, not on and on: its weight ends after about
    `field_same_s`. North is where the mean field of the surroundings points, which itself is off by `region_ut`
    and by `region_share` of the mean squared residual, seen over `region_s`: so the first place counts too.
    Where the field fits the model better than `quiet_ut`, as seen over `quiet_s` in what no turn explains, the
    noise falls with the square of the misfit, down to `quiet_least`: in a field that is the same everywhere the
    magnetometer is good to its own noise, elsewhere errors last for minutes.
    A field that changes by `steady_change_ut` at the first rest, before it was steady for `steady_trusted_s`,
    is met anew, and no hypothesis is believed. Hard iron and the field at the first resting place are each
    one of three: small (calibrated device, clean place), middle, or wide (a magnet attached, iron next to it),
    with the odds given; wide has what is left.
    `iron_*`: a residual that stays in the sensor for `iron_window_s` while it turns in the room is a new iron.
    A start at rest levels on `start_s` of force. Where the sensor turns or the force is not gravity's, on
    `start_moving_s`, carried through the turns of the gyroscope; and on `start_falling_s` where it falls. Later the
    mean force of `upright_window_s` must not lie more than `upright_limit_deg`, and more than what is stated, from
    the vertical: else the filter starts over.
    Gaps of up to `coast_s` are filled, with the error `gap_share` times the change of rate.
    `return_*`: how corrections enter the output, as an exponential approach never faster than the rate.
    `output_lead_s`: the output is extrapolated by this much (0: not at all), for devices whose gyroscope is late.
    `*_sigma_scale` and `*_sigma_floor_deg` turn the covariance into the reported sigma: the noise values above
    stand for correlated errors and overstate the white part by the first; the second is what no sensor shows:
    errors of the accelerometer, and how far the field of a room points from that of its surroundings.
    """

    block_s: float = 0.2
    hypothesis_s: float = 0.6
    start_s: float = 0.05
    start_moving_s: float = 1.0
    start_falling_s: float = 3.0
    upright_window_s: float = 3.0
    upright_limit_deg: float = 20.0
    coast_s: float = 0.2
    convergence_s: float = 3.0
    tilt_start_sigma_deg: float = 2.0
    tilt_restart_sigma_deg: float = 3.0
    heading_restart_sigma_deg: float = 10.0
    speed_start_sigma_mps: float = 0.5
    bias_start_sigma_degps: float = 1.0
    bias_drift_degps_per_sqrt_s: float = 0.03
    gain_sigma: float = 0.005
    rate_noise_deg_per_sqrt_s: float = 0.02
    rate_noise_per_rate_sqrt_s: float = 0.002
    speed_noise_mps_per_sqrt_s: float = 0.1
    position_noise_m_per_sqrt_s: float = 0.01
    position_prior_m_sqrt_s: float = 0.6
    rest_gyroscope_threshold_degps: float = 2.0
    rest_accelerometer_threshold_mps2: float = 0.4
    rest_minimum_s: float = 0.75
    rest_time_constant_s: float = 0.5
    rest_speed_sigma_mps_sqrt_s: float = 0.0045
    rest_bias_sigma_degps_sqrt_s: float = 0.1
    rest_sway_s: float = 0.4
    rest_sure_s: float = 5.0
    rest_surprise_degps: float = 0.15
    delay_sigma_s: float = 0.02
    field_start_sigma_ut: float = 60.0
    field_noise_moving_ut_sqrt_s: float = 4.25
    field_noise_rest_ut_sqrt_s: float = 2.0
    field_noise_start_ut_sqrt_s: float = 2.0
    field_scale_ut: float = 1.2
    field_level_s: float = 2.0
    field_same_s: float = 10.0
    field_turn_free: float = 0.5
    quiet_ut: float = 0.5
    quiet_s: float = 10.0
    quiet_least: float = 0.1
    region_ut: float = 0.7
    region_share: float = 0.3
    region_s: float = 30.0
    start_leaving_s: float = 1.0
    iron_window_s: float = 2.0
    iron_ratio: float = 4.0
    iron_narrow_ut: float = 0.3
    iron_middle_ut: float = 3.0
    iron_wide_ut: float = 30.0
    iron_narrow_odds: float = 0.8
    iron_middle_odds: float = 0.15
    start_narrow_ut: float = 1.0
    start_middle_ut: float = 5.0
    start_wide_ut: float = 30.0
    start_narrow_odds: float = 0.8
    start_middle_odds: float = 0.15
    steady_change_ut: float = 3.0
    steady_trusted_s: float = 3.0
    gap_share: float = 0.2
    clip_rate_sigma_degps: float = 57.3
    clip_force_sigma_mps2: float = 5.0
    return_time_constant_s: float = 0.1
    return_rate_degps: float = 30.0
    output_lead_s: float = 0.0
    acceleration_tolerance_mps2: float = 2.0
    tilt_sigma_scale: float = 0.4
    heading_sigma_scale: float = 0.25
    tilt_sigma_floor_deg: float = 0.35
    heading_sigma_floor_deg: float = 1.0
    heading_lost_sigma_deg: float = 15.0


POSITIVE = (
    "block_s",
    "hypothesis_s",
    "rest_time_constant_s",
    "field_scale_ut",
    "field_level_s",
    "start_leaving_s",
    "iron_window_s",
    "iron_narrow_ut",
    "iron_middle_ut",
    "start_narrow_ut",
    "start_middle_ut",
    "return_time_constant_s",
    "return_rate_degps",
    "position_prior_m_sqrt_s",
    "rest_speed_sigma_mps_sqrt_s",
    "rest_bias_sigma_degps_sqrt_s",
    "rest_sure_s",
    "rest_surprise_degps",
    "quiet_ut",
    "quiet_s",
    "field_noise_moving_ut_sqrt_s",
    "field_noise_rest_ut_sqrt_s",
    "field_noise_start_ut_sqrt_s",
)
"""Parameters that must be above zero."""


def ordered(parameters: TelemotionParameters) -> str:
    """Say which of the hypotheses cannot be told apart, or nothing."""
    p = parameters
    for kind in ("iron", "start"):
        narrow, middle, wide = (getattr(p, f"{kind}_{name}_ut") for name in ("narrow", "middle", "wide"))
        if not narrow < middle < wide:
            return f"{kind}_narrow_ut, {kind}_middle_ut and {kind}_wide_ut must increase"
        odds = getattr(p, f"{kind}_narrow_odds"), getattr(p, f"{kind}_middle_odds")
        if min(odds) <= 0.0 or sum(odds) >= 1.0:
            return f"{kind}_narrow_odds and {kind}_middle_odds must be above zero and add up to less than one"
    return ""


def settings_of(parameters: TelemotionParameters, step_s: float) -> Float:
    """Return the constants of the kernels, in the order of `_layout`."""
    p = parameters
    block_ticks = max(1.0, round(p.block_s / step_s))
    block_s = block_ticks * step_s
    values = {
        at.STEP_S: step_s,
        at.BLOCK_TICKS: block_ticks,
        at.HYPOTHESIS_BLOCKS: max(1.0, round(p.hypothesis_s / block_s)),
        at.START_TICKS: max(1.0, round(p.start_s / step_s)),
        at.MOVING_TICKS: max(1.0, round(p.start_moving_s / step_s)),
        at.FALLING_TICKS: max(1.0, round(p.start_falling_s / step_s)),
        at.COAST_TICKS: math.floor(p.coast_s / step_s + 1e-6),
        at.CONVERGENCE_TICKS: p.convergence_s / step_s,
        at.TILT_START: math.radians(p.tilt_start_sigma_deg) ** 2,
        at.TILT_RESTART: math.radians(p.tilt_restart_sigma_deg) ** 2,
        at.HEADING_RESTART: math.radians(p.heading_restart_sigma_deg) ** 2,
        at.SPEED_START: p.speed_start_sigma_mps**2,
        at.FIELD_START: p.field_start_sigma_ut**2,
        at.BIAS_DRIFT: math.radians(p.bias_drift_degps_per_sqrt_s) ** 2,
        at.RATE_NOISE: math.radians(p.rate_noise_deg_per_sqrt_s) ** 2,
        at.RATE_NOISE_PER_RATE: p.rate_noise_per_rate_sqrt_s**2,
        at.SPEED_NOISE: p.speed_noise_mps_per_sqrt_s**2,
        at.POSITION_NOISE: p.position_noise_m_per_sqrt_s**2,
        at.POSITION_PRIOR: p.position_prior_m_sqrt_s**2,
        at.REST_RATE: math.radians(p.rest_gyroscope_threshold_degps) ** 2,
        at.REST_FORCE: p.rest_accelerometer_threshold_mps2**2,
        at.REST_MINIMUM_S: p.rest_minimum_s,
        at.REST_SPEED: p.rest_speed_sigma_mps_sqrt_s**2,
        at.REST_BIAS: math.radians(p.rest_bias_sigma_degps_sqrt_s) ** 2,
        at.REST_GAIN: -math.expm1(-step_s / p.rest_time_constant_s),
        at.FIELD_NOISE_MOVING: p.field_noise_moving_ut_sqrt_s,
        at.FIELD_NOISE_REST: p.field_noise_rest_ut_sqrt_s,
        at.FIELD_NOISE_START: p.field_noise_start_ut_sqrt_s,
        at.FIELD_SCALE: p.field_scale_ut**2,
        at.FIELD_SAME_S: p.field_same_s,
        at.REGION_BASE: p.region_ut**2,
        at.REGION_SHARE: p.region_share,
        at.REGION_S: p.region_s,
        at.TURN_FREE: p.field_turn_free,
        at.QUIET_LEVEL: p.quiet_ut**2,
        at.QUIET_S: p.quiet_s,
        at.QUIET_LEAST: p.quiet_least,
        at.REST_SURPRISE: math.radians(p.rest_surprise_degps) ** 2,
        at.REST_SURE_S: p.rest_sure_s,
        at.REST_SWAY_S: p.rest_sway_s,
        at.BIAS_START: math.radians(p.bias_start_sigma_degps) ** 2,
        at.UP_WINDOW_S: p.upright_window_s,
        at.UP_LIMIT: math.radians(p.upright_limit_deg),
        at.FIELD_LEVEL_S: p.field_level_s,
        at.START_LEAVING_S: p.start_leaving_s,
        at.IRON_WINDOW_S: p.iron_window_s,
        at.IRON_RATIO: p.iron_ratio,
        at.IRON_WIDE: p.iron_wide_ut**2,
        at.IRON_NARROW: p.iron_narrow_ut**2,
        at.IRON_MIDDLE: p.iron_middle_ut**2,
        at.IRON_NARROW_ODDS: math.log(p.iron_narrow_odds),
        at.IRON_MIDDLE_ODDS: math.log(p.iron_middle_odds),
        at.START_WIDE: p.start_wide_ut**2,
        at.START_NARROW: p.start_narrow_ut**2,
        at.START_MIDDLE: p.start_middle_ut**2,
        at.START_NARROW_ODDS: math.log(p.start_narrow_odds),
        at.START_MIDDLE_ODDS: math.log(p.start_middle_odds),
        at.STEADY_CHANGE: p.steady_change_ut**2,
        at.STEADY_TRUSTED_S: p.steady_trusted_s,
        at.GAP_SHARE: p.gap_share**2,
        at.CLIP_RATE: math.radians(p.clip_rate_sigma_degps) ** 2,
        at.CLIP_FORCE: p.clip_force_sigma_mps2**2,
        at.RETURN_GAIN: -math.expm1(-step_s / p.return_time_constant_s),
        at.RETURN_STEP: math.radians(p.return_rate_degps) * step_s,
        at.LEAD_S: p.output_lead_s,
        at.FORCE_TOLERANCE: p.acceleration_tolerance_mps2,
        at.TILT_SCALE: p.tilt_sigma_scale**2,
        at.HEADING_SCALE: p.heading_sigma_scale**2,
        at.TILT_FLOOR: math.radians(p.tilt_sigma_floor_deg) ** 2,
        at.HEADING_FLOOR: math.radians(p.heading_sigma_floor_deg) ** 2,
        at.HEADING_LOST: math.radians(p.heading_lost_sigma_deg),
    }
    settings = np.zeros(at.SETTINGS)
    for position, value in values.items():
        settings[position] = value
    return settings


__all__ = ["POSITIVE", "TelemotionParameters", "ordered", "settings_of"]
