"""The tuning of our own filter: one set for all sensors, places and movements, and why each value is what it is."""

import math
from dataclasses import dataclass

from estimators.errors import SetupError
from estimators.orientation._parameters import parameter


@dataclass(frozen=True)
class TelemotionParameters:
    """Parameters of the filter; noise densities are per root second, so that no value depends on the rate.

    The integral of what is left of specific force beside gravity must stay near one place. A rest's rate is the
    gyroscope's bias, but people who stand still sway, and who hold an arm up lowers it slowly. North is where the mean
    field of the surroundings points: so the first place counts too. In a field that is the same everywhere the
    magnetometer is good to its own noise, elsewhere errors last for minutes. Hard iron and the field at the first
    resting place are each one of three: narrow, middle or wide, with the odds given.
    """

    block_s: float = parameter(0.2, "s", "length of a block, at whose end the filter corrects", above=0.0)
    hypothesis_s: float = parameter(
        0.6, "s", "between two judgements of the hypotheses on hard iron and start place", above=0.0
    )
    start_s: float = parameter(0.05, "s", "of force that a start at rest levels on")
    start_moving_s: float = parameter(
        1.0, "s", "of force, carried through the turns, that a start in movement levels on"
    )
    start_falling_s: float = parameter(3.0, "s", "the same where the sensor falls")
    upright_window_s: float = parameter(
        3.0, "s", "whose mean force must agree with the vertical, else the filter starts over"
    )
    upright_limit_deg: float = parameter(
        20.0, "deg", "that the force may lie off, and what is stated besides"
    )
    coast_s: float = parameter(0.2, "s", "length of a gap that is filled")
    convergence_s: float = parameter(
        3.0, "s", "after a start in which estimates may be flagged as converging"
    )
    tilt_start_sigma_deg: float = parameter(2.0, "deg", "tilt at the first start")
    tilt_restart_sigma_deg: float = parameter(3.0, "deg", "tilt at another start")
    heading_restart_sigma_deg: float = parameter(10.0, "deg", "heading found again by the known field")
    speed_start_sigma_mps: float = parameter(0.5, "m/s", "speed at a start")
    bias_start_sigma_degps: float = parameter(2.0, "deg/s", "gyroscope bias before any calibration")
    bias_drift_degps_per_sqrt_s: float = parameter(0.03, "deg/s/sqrt(s)", "random walk of the gyroscope bias")
    gain_sigma: float = parameter(
        0.01, "", "spread of scale and axis errors of devices as they are delivered"
    )
    gain_narrow: float = parameter(
        0.003, "", "the same of good devices, believed once turning has shown it", above=0.0
    )
    rate_noise_deg_per_sqrt_s: float = parameter(
        0.02, "deg/sqrt(s)", "what integrates of the rate without being seen"
    )
    rate_noise_per_rate_sqrt_s: float = parameter(
        0.002, "sqrt(s)", "the same as a share of the rate: errors of scale that change"
    )
    leaving_speed_sigma_mps: float = parameter(0.3, "m/s", "with which somebody leaves a place of rest")
    speed_noise_mps_per_sqrt_s: float = parameter(
        0.1, "m/s/sqrt(s)", 'all that bends "the sensor stays near one place"'
    )
    position_noise_m_per_sqrt_s: float = parameter(0.01, "m/sqrt(s)", "random walk of the place")
    position_prior_m_sqrt_s: float = parameter(
        0.6, "m sqrt(s)", "how near one place the sensor stays", above=0.0
    )
    force_offset_sigma_mps2: float = parameter(
        0.2, "m/s^2", "offset of the accelerometer of devices as they are delivered", above=0.0
    )
    gravity_sigma_mps2: float = parameter(
        0.2, "m/s^2", "of gravity as the accelerometer shows it: its scale", above=0.0
    )
    rest_gyroscope_threshold_degps: float = parameter(2.0, "deg/s", "deviation of the rate that is no rest")
    rest_accelerometer_threshold_mps2: float = parameter(
        0.4, "m/s^2", "deviation of the force that is no rest"
    )
    rest_minimum_s: float = parameter(0.75, "s", "without movement that is rest")
    rest_time_constant_s: float = parameter(0.5, "s", "of the means that rest is judged by", above=0.0)
    rest_speed_sigma_mps_sqrt_s: float = parameter(0.0045, "m/s sqrt(s)", "speed at rest", above=0.0)
    rest_bias_sigma_degps_sqrt_s: float = parameter(
        0.1, "deg/s sqrt(s)", "mean rate at rest as a measurement of the bias", above=0.0
    )
    rest_sway_s: float = parameter(0.4, "s", "for which a sway of the mean rate counts")
    rest_sure_s: float = parameter(5.0, "s", "whose mean rate the sway is about", above=0.0)
    rest_surprise_degps: float = parameter(
        0.15,
        "deg/s",
        "by which a rest may be off the bias, and its uncertainty besides, before it is doubted",
        above=0.0,
    )
    delay_sigma_s: float = parameter(0.02, "s", "delay of the magnetometer before it is learnt")
    field_start_sigma_ut: float = parameter(60.0, "uT", "first field")
    field_noise_moving_ut_sqrt_s: float = parameter(
        4.25, "uT sqrt(s)", "errors of the field in movement, which last for seconds", above=0.0
    )
    field_noise_rest_ut_sqrt_s: float = parameter(
        2.0, "uT sqrt(s)", "the same at rest, where they last as long as the rest", above=0.0
    )
    field_noise_start_ut_sqrt_s: float = parameter(
        2.0, "uT sqrt(s)", "the same at the place of the first rest", above=0.0
    )
    field_scale_ut: float = parameter(
        1.2, "uT", "residual, alone or on average, from which a block loses weight", above=0.0
    )
    field_level_s: float = parameter(2.0, "s", "of that average", above=0.0)
    field_same_s: float = parameter(
        10.0, "s", "after about which the weight of a rest ends: it says one thing once"
    )
    field_turn_free: float = parameter(
        0.5, "", "share forgiven of a residual that only turns the heading: it may be the heading's own"
    )
    quiet_ut: float = parameter(
        0.5, "uT", "fit of the field, in what no turn explains, from which its noise falls", above=0.0
    )
    quiet_s: float = parameter(10.0, "s", "over which that fit is seen", above=0.0)
    quiet_least: float = parameter(0.1, "", "share of the noise that it falls to")
    region_ut: float = parameter(0.7, "uT", "by which the mean field of the surroundings is off north")
    region_share: float = parameter(
        0.3, "", "the same as a share of the mean square by which the field wanders"
    )
    wander_s: float = parameter(
        5.0, "s", "over which a residual of the field is averaged: what is left wanders", above=0.0
    )
    wander_level_s: float = parameter(30.0, "s", "over which its mean square is seen", above=0.0)
    wander_share: float = parameter(0.7, "", "of its mean square that the field may be off north")
    wander_begin_s: float = parameter(
        4.0, "s", "of movement in which hard iron and start place are found: before, nothing wanders"
    )
    wander_doubt: float = parameter(
        2.0, "", "of its growth that makes the field uncertain again: what was seen before wandered too"
    )
    wander_doubt_s: float = parameter(
        12.0, "s", "of movement after which the field before is taken to have been calm", above=0.0
    )
    start_leaving_s: float = parameter(2.0, "s", "of movement in which the start place is left", above=0.0)
    iron_window_s: float = parameter(
        2.0, "s", "in which a residual that stays in the turning sensor is a new hard iron", above=0.0
    )
    iron_ratio: float = parameter(4.0, "", "of its spreads in the room and in the sensor from which it is")
    iron_narrow_ut: float = parameter(0.3, "uT", "hard iron of a calibrated device", above=0.0)
    iron_middle_ut: float = parameter(3.0, "uT", "hard iron between the two", above=0.0)
    iron_wide_ut: float = parameter(30.0, "uT", "hard iron with a magnet attached")
    iron_narrow_odds: float = parameter(0.8, "", "of the first; wide has what is left", above=0.0)
    iron_middle_odds: float = parameter(0.15, "", "of the second", above=0.0)
    start_narrow_ut: float = parameter(
        1.0, "uT", "field at a clean start place less that of the room", above=0.0
    )
    start_middle_ut: float = parameter(5.0, "uT", "the same between the two", above=0.0)
    start_wide_ut: float = parameter(30.0, "uT", "the same next to iron")
    start_narrow_odds: float = parameter(0.8, "", "of the first; wide has what is left", above=0.0)
    start_middle_odds: float = parameter(0.15, "", "of the second", above=0.0)
    steady_change_ut: float = parameter(
        3.0,
        "uT",
        "change of the field at the first rest after which it is met anew and no hypothesis believed",
    )
    steady_trusted_s: float = parameter(3.0, "s", "steady field after which a change is one no more")
    gap_share: float = parameter(0.2, "", "error of a filled gap as a share of the change of rate")
    clip_rate_sigma_degps: float = parameter(57.3, "deg/s", "what a gyroscope at its limit misses at least")
    clip_force_sigma_mps2: float = parameter(5.0, "m/s^2", "what an accelerometer at its limit misses")
    return_time_constant_s: float = parameter(0.1, "s", "in which corrections enter the output", above=0.0)
    return_rate_degps: float = parameter(30.0, "deg/s", "never faster than which they do", above=0.0)
    output_lead_s: float = parameter(
        0.0, "s", "by which the output is extrapolated, for devices whose gyroscope is late"
    )
    acceleration_tolerance_mps2: float = parameter(2.0, "m/s^2", "force off gravity that is flagged")
    tilt_sigma_scale: float = parameter(
        0.5, "", "from the covariance, whose noises stand for correlated errors, to the stated tilt"
    )
    heading_sigma_scale: float = parameter(0.3, "", "the same of the heading")
    tilt_sigma_floor_deg: float = parameter(
        0.35, "deg", "what no sensor shows of the tilt: errors of the accelerometer"
    )
    tilt_sigma_per_offset: float = parameter(
        0.25, "", "share of the accelerometer's offset by which its other errors are taken to tilt it"
    )
    heading_sigma_floor_deg: float = parameter(
        1.0, "deg", "the same of the heading: how far the field of a room points from that around it"
    )
    heading_lost_sigma_deg: float = parameter(15.0, "deg", "from which a heading is flagged as not trusted")


def check(parameters: TelemotionParameters) -> None:
    """Raise `SetupError` for hypotheses that cannot be distinguished."""
    p = parameters
    for kind in ("iron", "start"):
        narrow, middle, wide = (getattr(p, f"{kind}_{name}_ut") for name in ("narrow", "middle", "wide"))
        if not narrow < middle < wide:
            raise SetupError(f"{kind}_narrow_ut, {kind}_middle_ut and {kind}_wide_ut must increase")
        odds = getattr(p, f"{kind}_narrow_odds"), getattr(p, f"{kind}_middle_odds")
        if sum(odds) >= 1.0:
            raise SetupError(f"{kind}_narrow_odds and {kind}_middle_odds must add up to less than one")


def settings_of(parameters: TelemotionParameters, step_s: float) -> dict[str, float]:
    """Return the constants of the kernels; their record has these fields in this order."""
    p = parameters
    block_ticks = max(1.0, round(p.block_s / step_s))
    block_s = block_ticks * step_s
    return {
        "step_s": step_s,
        "block_ticks": block_ticks,
        "hypothesis_blocks": max(1.0, round(p.hypothesis_s / block_s)),
        "start_ticks": max(1.0, round(p.start_s / step_s)),
        "moving_ticks": max(1.0, round(p.start_moving_s / step_s)),
        "falling_ticks": max(1.0, round(p.start_falling_s / step_s)),
        "coast_ticks": math.floor(p.coast_s / step_s + 1e-6),
        "convergence_ticks": p.convergence_s / step_s,
        "tilt_start": math.radians(p.tilt_start_sigma_deg) ** 2,
        "tilt_restart": math.radians(p.tilt_restart_sigma_deg) ** 2,
        "heading_restart": math.radians(p.heading_restart_sigma_deg) ** 2,
        "speed_start": p.speed_start_sigma_mps**2,
        "field_start": p.field_start_sigma_ut**2,
        "bias_drift": math.radians(p.bias_drift_degps_per_sqrt_s) ** 2,
        "rate_noise": math.radians(p.rate_noise_deg_per_sqrt_s) ** 2,
        "rate_noise_per_rate": p.rate_noise_per_rate_sqrt_s**2,
        "leaving_speed": p.leaving_speed_sigma_mps**2,
        "speed_noise": p.speed_noise_mps_per_sqrt_s**2,
        "position_noise": p.position_noise_m_per_sqrt_s**2,
        "position_prior": p.position_prior_m_sqrt_s**2,
        "rest_rate": math.radians(p.rest_gyroscope_threshold_degps) ** 2,
        "rest_force": p.rest_accelerometer_threshold_mps2**2,
        "rest_minimum_s": p.rest_minimum_s,
        "rest_speed": p.rest_speed_sigma_mps_sqrt_s**2,
        "rest_bias": math.radians(p.rest_bias_sigma_degps_sqrt_s) ** 2,
        "rest_gain": -math.expm1(-step_s / p.rest_time_constant_s),
        "field_noise_moving": p.field_noise_moving_ut_sqrt_s,
        "field_noise_rest": p.field_noise_rest_ut_sqrt_s,
        "field_noise_start": p.field_noise_start_ut_sqrt_s,
        "field_scale": p.field_scale_ut**2,
        "field_level_s": p.field_level_s,
        "start_leaving_s": p.start_leaving_s,
        "iron_window_s": p.iron_window_s,
        "iron_ratio": p.iron_ratio,
        "iron_wide": p.iron_wide_ut**2,
        "iron_narrow": p.iron_narrow_ut**2,
        "iron_middle": p.iron_middle_ut**2,
        "iron_narrow_odds": math.log(p.iron_narrow_odds),
        "iron_middle_odds": math.log(p.iron_middle_odds),
        "start_wide": p.start_wide_ut**2,
        "start_narrow": p.start_narrow_ut**2,
        "start_middle": p.start_middle_ut**2,
        "start_narrow_odds": math.log(p.start_narrow_odds),
        "start_middle_odds": math.log(p.start_middle_odds),
        "gap_share": p.gap_share**2,
        "clip_rate": math.radians(p.clip_rate_sigma_degps) ** 2,
        "clip_force": p.clip_force_sigma_mps2**2,
        "return_gain": -math.expm1(-step_s / p.return_time_constant_s),
        "return_step": math.radians(p.return_rate_degps) * step_s,
        "lead_s": p.output_lead_s,
        "force_tolerance": p.acceleration_tolerance_mps2,
        "tilt_scale": p.tilt_sigma_scale**2,
        "heading_scale": p.heading_sigma_scale**2,
        "tilt_floor": math.radians(p.tilt_sigma_floor_deg) ** 2,
        "uneven": p.tilt_sigma_per_offset**2,
        "heading_floor": math.radians(p.heading_sigma_floor_deg) ** 2,
        "heading_lost": math.radians(p.heading_lost_sigma_deg),
        "steady_change": p.steady_change_ut**2,
        "steady_trusted_s": p.steady_trusted_s,
        "field_same_s": p.field_same_s,
        "region_base": p.region_ut**2,
        "region_share": p.region_share,
        "wander_level_s": p.wander_level_s,
        "wander_s": p.wander_s,
        "wander_share": p.wander_share,
        "wander_doubt": p.wander_doubt,
        "wander_begin_s": p.wander_begin_s,
        "wander_doubt_s": p.wander_doubt_s,
        "turn_free": p.field_turn_free,
        "quiet_level": p.quiet_ut**2,
        "quiet_s": p.quiet_s,
        "quiet_least": p.quiet_least,
        "rest_surprise": math.radians(p.rest_surprise_degps) ** 2,
        "rest_sure_s": p.rest_sure_s,
        "rest_sway_s": p.rest_sway_s,
        "bias_start": math.radians(p.bias_start_sigma_degps) ** 2,
        "up_window_s": p.upright_window_s,
        "up_limit": math.radians(p.upright_limit_deg),
        "gain": p.gain_sigma**2,
        "gain_narrow": p.gain_narrow**2,
    }
