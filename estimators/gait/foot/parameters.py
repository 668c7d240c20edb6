"""Parameters of the foot trajectory: one set for all people, speeds and devices."""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, Final

import numpy as np

from estimators._clipping import ClipWatch
from estimators.errors import SetupError
from estimators.orientation._parameters import read_parameters
from estimators.recording import SensorSignals

LEAST_RANGE: Final = {"gyroscope_clip_radps": 4.3, "accelerometer_clip_mps2": 19.0}
"""Devices of 250 deg/s and 2 g are the least that are made."""


@dataclass(frozen=True)
class FootParameters:
    """What the stance detector and the foot filter go by; only the clip levels are facts about a device.

    Attributes
    ----------
    gyroscope_clip_radps, accelerometer_clip_mps2 : float
        Highest rate and specific force that the device follows, per axis. The only inputs that differ between
        devices; the defaults are those of a 2000 deg/s, 16 g sensor.
    window_s : float
        Length of the centred window of the stance statistic T.
    reference_before_s, reference_after_s : float
        How far the low percentile of T looks back and ahead.
    reference_percentile, reference_floor, stance_ratio : float
        A sample is stance where T is below `stance_ratio` times that percentile, which is never taken
        below `reference_floor`.
    stance_limit : float
        Above this T the foot never rests on anything, however regular its movement.
    restless_statistic, restless_contrast : float
        Above this T a sample is stance only where the highest T of the window is so many times its own: a runner's
        is 5 times at least, that of a foot on a pedal or of a shaken one less than 3.
    moving_gyroscope_radps, moving_accelerometer_mps2 : float
        Scales of turning and of specific force in T.
    velocity_sigma_floor_mps, velocity_sigma_slope_mps, velocity_sigma_exponent : float
        Standard deviation of "the contact point stands": floor + slope * T**exponent, at 200 Hz.
    gate, gate_ratio, gate_time_s : float
        A stance is not believed when the sum of squares of the velocity, in standard deviations, is beyond the gate
        and the foot is so many times less certain to stand than in the stance before, for so long after that one:
        the slow middle of a long swing looks like a runner's stance.
    standstill_limit, standstill_sigma_radps : float
        Below this T the gyroscope shows its bias, to this standard deviation.
    height_sigma_m, height_scale_m, height_gate_m : float
        The floor's height is measured once a stance: sigma * (1 + (d/scale)**2) for a step d off the last
        level, not at all beyond the gate, where a stair begins.
    is_floor_flat : bool
        Whether the person is known to stay on one level: then a stance is on that level, gate or no gate.
    shock_mps2, shock_density : float
        A component of specific force beyond this, or the device's clip level, is an impact: density of the
        velocity's noise there, m/s/sqrt(s).
    accelerometer_density, gyroscope_density : float
        Noise otherwise, m/s/sqrt(s) and rad/sqrt(s).
    clip_density : float
        Noise of an axis whose rate is beyond the clip level, rad/sqrt(s).
    accelerometer_jerk_share, gyroscope_jerk_share : float
        Noise in proportion to half the difference of the neighbouring samples.
    gap_accelerometer_density, gap_gyroscope_density, gap_scale_s : float
        Least noise where samples are missing for too long to be bridged, growing with the root of the gap's length.
    pivot_sigma_m, pivot_density : float
        Start and random walk (m/sqrt(s)) of the vector from the contact point to the sensor.
    gyroscope_bias_sigma_radps, accelerometer_bias_sigma_mps2 : float
        Uncertainty of the biases at the start.
    gyroscope_bias_density, accelerometer_bias_density : float
        Their random walks, per sqrt(s).
    field_sigma_rad, field_tolerance : float
        Standard deviation of a magnetic heading in stance, and how far (as a share) field strength and
        vertical part may differ from the first stance's before it is not used.
    lost_after_s : float
        Live, missing samples for so long lose the place: what follows is a new stretch with a frame of its own.
    lost_speed_mps, lost_climb_mps, lost_turn_radps : float
        Standard deviations of how fast a foot goes, climbs and turns on average while nothing is known of it.
    lag_s, release_s : float
        The live filter smooths this far back, and releases what is old enough this often.
    """

    gyroscope_clip_radps: float = 34.5
    accelerometer_clip_mps2: float = 156.0
    window_s: float = 0.12
    reference_before_s: float = 0.8
    reference_after_s: float = 0.5
    reference_percentile: float = 5.0
    reference_floor: float = 0.3
    stance_ratio: float = 1.5
    stance_limit: float = 20.0
    restless_statistic: float = 1.0
    restless_contrast: float = 3.0
    moving_gyroscope_radps: float = 0.3
    moving_accelerometer_mps2: float = 0.5
    velocity_sigma_floor_mps: float = 0.003
    velocity_sigma_slope_mps: float = 0.015
    velocity_sigma_exponent: float = 1.5
    gate: float = 9.0
    gate_ratio: float = 2.0
    gate_time_s: float = 2.0
    standstill_limit: float = 0.15
    standstill_sigma_radps: float = 0.01
    height_sigma_m: float = 0.01
    height_scale_m: float = 0.06
    height_gate_m: float = 0.10
    is_floor_flat: bool = False
    shock_mps2: float = 58.0
    shock_density: float = 10.0
    accelerometer_density: float = 0.05
    gyroscope_density: float = 0.003
    clip_density: float = 1.0
    accelerometer_jerk_share: float = 0.03
    gyroscope_jerk_share: float = 0.03
    gap_accelerometer_density: float = 5.0
    gap_gyroscope_density: float = 0.3
    gap_scale_s: float = 0.02
    pivot_sigma_m: float = 0.1
    pivot_density: float = 0.2
    gyroscope_bias_sigma_radps: float = 0.01
    accelerometer_bias_sigma_mps2: float = 0.05
    gyroscope_bias_density: float = 1e-5
    accelerometer_bias_density: float = 1e-4
    field_sigma_rad: float = 0.1
    field_tolerance: float = 0.1
    lost_after_s: float = 0.5
    lost_speed_mps: float = 1.5
    lost_climb_mps: float = 0.3
    lost_turn_radps: float = 1.0
    lag_s: float = 0.3
    release_s: float = 0.1


def foot_parameters(values: "Mapping[str, Any] | FootParameters | None" = None) -> FootParameters:
    """Check parameters, given as a mapping of what differs from the defaults.

    Raises
    ------
    SetupError
        For an unknown name, a value of the wrong kind, or one at or below zero.
    """
    parameters = values if isinstance(values, FootParameters) else read_parameters(FootParameters, values)
    for field in fields(parameters):
        value = getattr(parameters, field.name)
        if not isinstance(value, bool) and value <= 0.0:
            raise SetupError(f"{field.name} must be above zero, not {value}")
    if parameters.reference_percentile >= 100.0:
        raise SetupError("reference_percentile must be below 100")
    return parameters


def with_clips(signals: SensorSignals, parameters: FootParameters) -> FootParameters:
    """Return the parameters with clip levels that the samples themselves pile up at, where those are lower."""
    step_s = float(np.median(np.diff(signals.time_s)))
    found: dict[str, Any] = {}
    for name, values, is_rate in (
        ("gyroscope_clip_radps", signals.gyroscope_radps, True),
        ("accelerometer_clip_mps2", signals.accelerometer_mps2, False),
    ):
        given = getattr(parameters, name)
        watch = ClipWatch(LEAST_RANGE[name], is_rate=is_rate)
        watch.add(values, step_s)
        if watch.level is not None and watch.level < given:
            found[name] = watch.level
    return replace(parameters, **found) if found else parameters
