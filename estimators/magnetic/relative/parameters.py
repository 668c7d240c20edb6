"""Parameters of the relative-pose filter, and their form for the compiled loop."""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import partial
from types import MappingProxyType
from typing import Any

import numpy as np

from estimators.conventions import GRAVITY_MPS2
from estimators.errors import SetupError
from estimators.kernels.array_filter import with_overrides
from estimators.magnetic.relative import layout as at
from estimators.recording import Float


@dataclass(frozen=True)
class RelativePoseParameters:
    """Figures of the method page (sections 3.5 to 3.13); noise is per sample.

    `force_bias_sigma_mps2` is the spread of the accelerometers' offsets, which decay with `bias_decay_per_s`; the
    gyroscopes' walk by sqrt(2 * `bias_decay_per_s`) times `rate_bias_sigma_radps` in a second, as the same process
    would without its decay.
    `position_limit_m` and `attitude_limit_deg` are the sigmas above which a coil is fired: as accurate as the
    predecessor's fixed cycle for less than half of its energy, and low enough for iron to be reported before it does
    3 cm of harm. `SPARING_PARAMETERS` are the limits of the method page. `distance_scaling` makes them grow with
    the distance (F-24). Above `uncertain_m` and `uncertain_deg` the pose is reported to be uncertain: a request takes
    its time over a network, so that sigmas above the limits are usual.
    `pulse_s`, `baseline_samples` (quiet ones before it, at most) and `current_a` describe a pulse; `start_pulse_s`
    and `start_baseline_samples` those of the burst that starts the filter.
    `adaptive_current` takes the least current that brings `current_share` of what the full one would take off the
    uncertainty (F-23).
    `fixed_interval_s` above zero fires the coils in turn instead, at that interval, whatever the uncertainty.
    `mounting_direction` is where the sensor is from the source, roughly, in source axes; zero for none.
    `passes` of the iterated update, 1 for the published one. A pulse above `nis_alarm` (99.73 %, three sigmas)
    raises the alarm, one above `nis_soft` weighs less, of one above `nis_streak` nobody knows what is wrong;
    `streak_pulses` of those in a row ask for a new burst; with a source that fires bursts by itself three bursts,
    nine pulses, lest iron that passes be taken for a filter that is lost (C6 2.3).
    `field_norm_limit` and `field_dip_limit_deg` are the changes of the earth's field that mean iron; while they last
    pulses count `1/disturbed_factor`.
    `retry_s` after a burst that fitted no pose, or after three pulses that could not be read; until then the filter
    goes on without the source, each time for twice as long, at most `longest_retry_s`.
    `most_duty` is the share of a minute for which a coil may be on, `most_mean_square_a2` the mean of the squared
    current over a minute (heat of the coils, exposure of the wearer): no request goes beyond them, whatever fails.
    A little above what the predecessor, worn in Roetenberg 2006, does without pause: three pulses of 60 ms at 1.5 A
    every 600 ms.
    `moment_limit` is the share by which the moment of the coils must differ from the stated one to raise the alarm,
    once that is sure; `moment_memory_s` how long what tells it counts.
    `inconsistent_deg`: a burst whose orientation is farther from what gravity and the gyroscopes say is refused.
    `published_mechanisation` integrates as the thesis does (erratum X1), for comparison.
    """

    force_sigma_mps2: float = 0.02
    rate_sigma_radps: float = 0.0123
    magnetometer_sigma_t: float = 3e-8
    force_bias_sigma_mps2: float = 0.02
    rate_bias_sigma_radps: float = 4e-4
    bias_decay_per_s: float = 0.01
    position_limit_m: float = 0.006
    attitude_limit_deg: float = 2.0
    uncertain_m: float = 0.040
    uncertain_deg: float = 5.0
    distance_scaling: bool = False
    pulse_s: float = 0.03
    baseline_samples: int = 5
    current_a: float = 1.3
    start_pulse_s: float = 0.08
    start_baseline_samples: int = 8
    adaptive_current: bool = False
    least_current_a: float = 0.1
    current_share: float = 0.85
    fixed_interval_s: float = 0.0
    mounting_direction: tuple[float, float, float] = (0.0, 0.0, 0.0)
    earth_field_t: float = 4.9e-5
    gain_sigma: float = 0.002
    passes: int = 5
    calibration_s: float = 2.0
    still_rate_radps: float = 0.15
    static_force_mps2: float = 0.3
    static_rate_radps: float = 0.15
    inclination_sigma_mps2: float = 0.25
    inclination_interval_s: float = 0.1
    use_inclination: bool = True
    full_scale_t: float = 8e-4
    nis_alarm: float = 14.16
    nis_soft: float = 16.27
    nis_streak: float = 30.0
    streak_pulses: int = 3
    field_norm_limit: float = 0.05
    field_dip_limit_deg: float = 3.0
    disturbed_factor: float = 100.0
    retry_s: float = 2.0
    longest_retry_s: float = 30.0
    most_duty: float = 0.35
    most_mean_square_a2: float = 0.75
    moment_limit: float = 0.05
    moment_memory_s: float = 60.0
    response_s: float = 0.1
    alarm_hold_s: float = 1.0
    inconsistent_deg: float = 20.0
    published_mechanisation: bool = False


SPARING_PARAMETERS: Mapping[str, Any] = MappingProxyType(
    {"position_limit_m": 0.020, "attitude_limit_deg": 2.5}
)
"""Limits of method page 3.10: a third of the pulses, two to three times the error; at 2 cm a sigma nothing can tell
3 cm by iron from chance."""
_LEAST_BASELINE = 2
_MAY_BE_ZERO = {
    "fixed_interval_s",
    "mounting_direction",
    "gain_sigma",
    "force_bias_sigma_mps2",
    "rate_bias_sigma_radps",
    "bias_decay_per_s",
    "earth_field_t",
}


def read(parameters: Mapping[str, Any] | None) -> RelativePoseParameters:
    """Return parameters with overrides; raises `SetupError` for unknown names and impossible values."""
    result = with_overrides(RelativePoseParameters(), parameters)
    for name, value in asdict(result).items():
        if isinstance(value, bool):
            continue
        numbers = np.atleast_1d(np.asarray(value, dtype=np.float64))
        if not np.isfinite(numbers).all():
            raise SetupError(f"{name} must be finite")
        if name != "mounting_direction" and (
            numbers.min() < 0.0 or (numbers.min() == 0.0 and name not in _MAY_BE_ZERO)
        ):
            raise SetupError(f"{name} must be above zero, not {value}")
    for name in ("passes", "baseline_samples", "start_baseline_samples", "streak_pulses"):
        if int(getattr(result, name)) != getattr(result, name):
            raise SetupError(f"{name} must be a whole number, not {getattr(result, name)}")
    if min(result.baseline_samples, result.start_baseline_samples) < _LEAST_BASELINE:
        raise SetupError(f"a pulse needs {_LEAST_BASELINE} quiet samples before it; see baseline_samples")
    if len(result.mounting_direction) != 3:
        raise SetupError("mounting_direction needs three components")
    return result


def _ticks(time_step_s: float, seconds: float) -> float:
    return float(max(1, round(seconds / time_step_s)))


def to_settings(p: RelativePoseParameters, time_step_s: float, coils: int) -> Float:
    """Return the settings of the compiled loop."""
    ticks = partial(_ticks, time_step_s)
    settings = np.zeros(at.SETTINGS)
    for position, value in (
        (at.TIME_STEP, time_step_s),
        (at.GRAVITY, GRAVITY_MPS2),
        (at.FORCE_SIGMA, p.force_sigma_mps2),
        (at.RATE_SIGMA, p.rate_sigma_radps),
        (at.FIELD_SIGMA, p.magnetometer_sigma_t),
        (at.FORCE_BIAS_SIGMA, p.force_bias_sigma_mps2),
        (at.RATE_BIAS_SIGMA, p.rate_bias_sigma_radps),
        (at.BIAS_DECAY, p.bias_decay_per_s),
        (at.POSITION_LIMIT, p.position_limit_m),
        (at.ATTITUDE_LIMIT, math.radians(p.attitude_limit_deg)),
        (at.ON_TICKS, ticks(p.pulse_s)),
        (at.OFF_TICKS, p.baseline_samples),
        (at.START_ON_TICKS, ticks(p.start_pulse_s)),
        (at.START_OFF_TICKS, p.start_baseline_samples),
        (at.CURRENT_SETTING, p.current_a),
        (at.LEAST_CURRENT, p.least_current_a),
        (at.CURRENT_SHARE, min(p.current_share, 1.0)),
        (at.ADAPTIVE_CURRENT, float(p.adaptive_current)),
        (at.SCALE_BY_DISTANCE, float(p.distance_scaling)),
        (at.EARTH_FIELD, p.earth_field_t),
        (at.GAIN_SIGMA, p.gain_sigma),
        (at.PASSES, p.passes),
        (at.CALIBRATE_TICKS, ticks(p.calibration_s)),
        (at.GATE_FORCE, p.static_force_mps2),
        (at.GATE_RATE, p.static_rate_radps),
        (at.INCLINATION_SIGMA, p.inclination_sigma_mps2),
        (at.INCLINATION_TICKS, ticks(p.inclination_interval_s)),
        (at.FULL_SCALE, p.full_scale_t),
        (at.NIS_SOFT, p.nis_soft),
        (at.NIS_STREAK, p.nis_streak),
        (at.FIELD_NORM_LIMIT, p.field_norm_limit),
        (at.FIELD_DIP_LIMIT, math.radians(p.field_dip_limit_deg)),
        (at.DISTURBED_FACTOR, p.disturbed_factor),
        (at.RETRY_TICKS, ticks(p.retry_s)),
        (at.RESPONSE_TICKS, ticks(p.response_s)),
        (at.ALARM_TICKS, ticks(p.alarm_hold_s)),
        (at.FIXED_TICKS, ticks(p.fixed_interval_s) if p.fixed_interval_s > 0.0 else 0.0),
        (at.PUBLISHED, float(p.published_mechanisation)),
        (at.COILS, coils),
        (at.STILL_RATE, p.still_rate_radps),
        (at.USE_INCLINATION, float(p.use_inclination)),
        (at.UNCERTAIN_POSITION, p.uncertain_m),
        (at.UNCERTAIN_ATTITUDE, math.radians(p.uncertain_deg)),
        (at.NIS_ALARM, p.nis_alarm),
        (at.LONGEST_RETRY_TICKS, ticks(max(p.longest_retry_s, p.retry_s))),
        (at.MOST_ON_TIME, at.BUDGET_S * min(p.most_duty, 1.0)),
        (at.MOST_SQUARED, at.BUDGET_S * p.most_mean_square_a2),
        (at.SECOND_TICKS, ticks(1.0)),
        (at.MOMENT_LIMIT, p.moment_limit),
        (at.MOMENT_KEEP, math.exp(-time_step_s / p.moment_memory_s)),
        (at.STREAK_PULSES, p.streak_pulses),
    ):
        settings[position] = value
    _check_length(settings)
    return settings


def _check_length(settings: Float) -> None:
    """Refuse pulses that do not fit into what is remembered."""
    longest = settings[at.START_ON_TICKS] + settings[at.START_OFF_TICKS] + 60
    if longest >= at.RING or settings[at.ON_TICKS] + settings[at.OFF_TICKS] + 60 >= at.RING:
        raise SetupError("a pulse and its baseline must be shorter than 66 samples")
