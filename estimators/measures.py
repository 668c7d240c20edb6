"""Every measure by name: of what it is one, what a person calls it, and which are shown first."""

from dataclasses import dataclass
from typing import Final, Literal

Part = Literal["test", "foot", "both", "asymmetry", "balance", "sway", "repetition"]


@dataclass(frozen=True)
class NamedMeasure:
    """One line of the register.

    Attributes
    ----------
    name : str
        As what computes it calls it.
    part : str
        Of a walk `foot`: of each foot; `both`: of the two together; `asymmetry`: left less right over their mean, of
        the measure of a foot with this name; `balance`: of instrumented shoes; `test`: of a walking test. `sway`: of a
        test of balance. `repetition`: of one repetition; a name with a colon at its end goes on with a channel.
    label : str
        What a person calls it where sessions are followed; empty where it is only compared.
    unit : str
        Of one repetition: of its values; empty where it is that of the channel. Others travel with their values.
    is_main : bool
        Shown at once, the others when asked for. Of a repetition: a column of the table by repetition.
    is_index : bool
        Of a repetition: for who studies movement; the report of a course has it on its last sheet.
    """

    name: str
    part: Part
    label: str = ""
    unit: str = ""
    is_main: bool = False
    is_index: bool = False


MEASURES: Final = (
    NamedMeasure("test_time", "test", "Time of the test, whole walk"),
    NamedMeasure("test_distance", "test", "Distance, whole walk"),
    NamedMeasure("speed", "foot", "Walking speed, steady strides", is_main=True),
    NamedMeasure("stride_length", "foot", "Stride length, steady strides", is_main=True),
    NamedMeasure("stride_length", "asymmetry", "Stride length, left compared with right"),
    NamedMeasure("step_time", "asymmetry", "Step time, left compared with right"),
    NamedMeasure("stance_share", "asymmetry", "Stance, left compared with right"),
    NamedMeasure("swing_time", "asymmetry"),
    NamedMeasure("clearance", "asymmetry"),
    NamedMeasure("double_support_share", "both", "Double support, % of the stride"),
    NamedMeasure("double_support", "both"),
    NamedMeasure("walk_ratio", "both", "Walk ratio: step length divided by steps per second"),
    NamedMeasure("step_width", "both", "Step width"),
    NamedMeasure("step_length_left", "both"),
    NamedMeasure("step_length_right", "both"),
    NamedMeasure("weight_on_left", "balance", "Weight on the left foot, standing"),
    NamedMeasure("centre_to_left_standing", "balance"),
    NamedMeasure("centre_to_left", "balance", "Lateral shift of the centre of mass, walking"),
    NamedMeasure("centre_sway", "balance"),
    NamedMeasure("margin", "balance", "Margin of stability, least of each second"),
    NamedMeasure("external_work", "balance"),
    NamedMeasure("pendulum_recovery", "balance"),
    NamedMeasure("cadence", "foot", "Cadence", is_main=True),
    NamedMeasure("step_time", "foot", is_main=True),
    NamedMeasure("stance_share", "foot", "Stance, part of the stride", is_main=True),
    NamedMeasure("swing_time", "foot", is_main=True),
    NamedMeasure("clearance", "foot", "Foot clearance in swing", is_main=True),
    NamedMeasure("toe_out", "foot", "Toes turned outward", is_main=True),
    NamedMeasure("circumduction", "foot", is_main=True),
    NamedMeasure("stride_time", "foot"),
    NamedMeasure("stance_time", "foot"),
    NamedMeasure("contact_pitch", "foot"),
    NamedMeasure("toe_off_pitch", "foot"),
    NamedMeasure("lateral_placement", "foot"),
    NamedMeasure("stride_length_variation", "foot"),
    NamedMeasure("stride_time_variation", "foot"),
    NamedMeasure("force_most", "foot"),
    NamedMeasure("force_loading", "foot"),
    NamedMeasure("force_valley", "foot"),
    NamedMeasure("force_push_off", "foot"),
    NamedMeasure("ellipse_area", "sway", is_main=True),
    NamedMeasure("sway_speed", "sway", is_main=True),
    NamedMeasure("displacement_rms_forward", "sway", is_main=True),
    NamedMeasure("displacement_rms_sideways", "sway", is_main=True),
    NamedMeasure("path_length", "sway"),
    NamedMeasure("acceleration_rms", "sway"),
    NamedMeasure("acceleration_rms_forward", "sway"),
    NamedMeasure("acceleration_rms_sideways", "sway"),
    NamedMeasure("jerk_rms", "sway"),
    NamedMeasure("median_frequency", "sway"),
    NamedMeasure("frequency_95", "sway"),
    NamedMeasure("range:", "repetition", "range of motion", is_main=True),
    NamedMeasure("duration", "repetition", "Duration", unit="s", is_main=True),
    NamedMeasure("duration_ratio", "repetition", "Duration relative to the template", unit="1"),
    NamedMeasure("timing_deviation", "repetition", "Uneven timing", unit="%", is_main=True),
    NamedMeasure(
        "time_to_peak_speed", "repetition", "Time to peak speed, % of the outward movement", unit="%"
    ),
    NamedMeasure("shape_deviation", "repetition", "Difference in shape", unit="bands", is_main=True),
    NamedMeasure("inside_band", "repetition", "Share inside the band", unit="%", is_main=True),
    NamedMeasure(
        "peak_deviation_phase", "repetition", "Phase of the largest difference", unit="%", is_index=True
    ),
    NamedMeasure("peak_speed", "repetition", "Peak hand speed", unit="m/s", is_main=True),
    NamedMeasure("mean_speed", "repetition", "Mean hand speed", unit="m/s"),
    NamedMeasure("peak_turning_speed", "repetition", "Peak turning speed", unit="rad/s"),
    NamedMeasure("mean_turning_speed", "repetition", "Mean turning speed", unit="rad/s"),
    NamedMeasure("path_residual", "repetition", "Hand path, what differs in shape", unit="m", is_index=True),
    NamedMeasure("path_turn", "repetition", "Hand path, turned from the template", unit="rad", is_index=True),
    NamedMeasure(
        "path_scale", "repetition", "Hand path, factor to the template's size", unit="1", is_index=True
    ),
    NamedMeasure(
        "spectral_arc_length", "repetition", "Smoothness (SPARC)", unit="1", is_main=True, is_index=True
    ),
    NamedMeasure(
        "log_dimensionless_jerk",
        "repetition",
        "Smoothness (log dimensionless jerk)",
        unit="1",
        is_main=True,
        is_index=True,
    ),
    NamedMeasure("movement_units", "repetition", "Movement units", unit="count", is_index=True),
    NamedMeasure("units_per_metre", "repetition", "Movement units per metre", unit="1/m", is_index=True),
    NamedMeasure(
        "joint_correlation",
        "repetition",
        "Shoulder and elbow together (correlation)",
        unit="1",
        is_main=True,
        is_index=True,
    ),
    NamedMeasure("joint_lag", "repetition", "Elbow behind shoulder", unit="s", is_index=True),
    NamedMeasure(
        "joint_common_share", "repetition", "Movement that shoulder and elbow share", unit="%", is_index=True
    ),
    NamedMeasure(
        "hand_path_ratio", "repetition", "Hand path relative to a straight line", unit="1", is_main=True
    ),
    NamedMeasure("range_ratio:", "repetition", "range relative to the template", unit="1"),
    NamedMeasure("peak_deviation:", "repetition", "largest difference"),
    NamedMeasure("shape_rms:", "repetition", "difference in shape", is_index=True),
    NamedMeasure("multiple_correlation:", "repetition", "consistency (CMC)", unit="1", is_index=True),
    NamedMeasure("repetition_rms:", "repetition", "spread of the repetitions", is_index=True),
    NamedMeasure("compensation:", "repetition", "range", is_main=True),
)
"""In the order in which they are shown, the most telling first."""


def measures_of(part: Part, *, is_main: bool | None = None) -> tuple[str, ...]:
    """Return the names of the measures of a part, in the order in which they are shown; all, or only one sort."""
    return tuple(
        one.name for one in MEASURES if one.part == part and (is_main is None or one.is_main == is_main)
    )
