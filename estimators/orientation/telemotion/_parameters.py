"""The tuning of our own filter: one set for all sensors, places and movements, and why each value is what it is."""

import math
from dataclasses import asdict, dataclass

from estimators.errors import SetupError


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


def check(parameters: TelemotionParameters) -> None:
    """Refuse parameters that mean nothing.

    Raises
    ------
    SetupError
        If one is negative, or zero where it must not be, or if hypotheses cannot be told apart.
    """
    p = parameters
    for name, value in asdict(p).items():
        if value < 0.0:
            raise SetupError(f"{name} must not be negative, not {value}")
        if name in POSITIVE and value == 0.0:
            raise SetupError(f"{name} must be above zero")
    for kind in ("iron", "start"):
        narrow, middle, wide = (getattr(p, f"{kind}_{name}_ut") for name in ("narrow", "middle", "wide"))
        if not narrow < middle < wide:
            raise SetupError(f"{kind}_narrow_ut, {kind}_middle_ut and {kind}_wide_ut must increase")
        odds = getattr(p, f"{kind}_narrow_odds"), getattr(p, f"{kind}_middle_odds")
        if min(odds) <= 0.0 or sum(odds) >= 1.0:
            raise SetupError(
                f"{kind}_narrow_odds and {kind}_middle_odds must be above zero and add up to less than one"
            )


def settings_of(parameters: TelemotionParameters, step_s: float) -> dict[str, float]:
    """Return the constants of the kernels by the names of their record."""
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
        "field_same_s": p.field_same_s,
        "region_base": p.region_ut**2,
        "region_share": p.region_share,
        "region_s": p.region_s,
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
        "steady_change": p.steady_change_ut**2,
        "steady_trusted_s": p.steady_trusted_s,
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
        "heading_floor": math.radians(p.heading_sigma_floor_deg) ** 2,
        "heading_lost": math.radians(p.heading_lost_sigma_deg),
    }


__all__ = ["TelemotionParameters", "check", "settings_of"]
