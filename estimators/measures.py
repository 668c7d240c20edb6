"""Every measure of a walk by name: which part of it has it, and what a follow-up over sessions calls it."""

from dataclasses import dataclass
from typing import Final, Literal

WalkPart = Literal["test", "foot", "both", "asymmetry", "balance"]


@dataclass(frozen=True)
class NamedMeasure:
    """One line of the register.

    Attributes
    ----------
    name : str
        As in `GaitSummary`, or as what measures it calls it; units travel with the values.
    part : str
        `foot`: of each foot; `both`: of the two together; `asymmetry`: left less right over their mean, of the measure
        of a foot with this name; `balance`: of instrumented shoes; `test`: of a walking test.
    label : str
        What a person calls it where sessions are followed; empty where it is only compared.
    """

    name: str
    part: WalkPart
    label: str = ""


WALK_MEASURES: Final = (
    NamedMeasure("test_time", "test", "Time of the test, whole walk"),
    NamedMeasure("test_distance", "test", "Distance, whole walk"),
    NamedMeasure("speed", "foot", "Walking speed, steady strides"),
    NamedMeasure("stride_length", "foot", "Stride length, steady strides"),
    NamedMeasure("stride_length", "asymmetry", "Stride length, left compared with right"),
    NamedMeasure("step_time", "asymmetry", "Step time, left compared with right"),
    NamedMeasure("stance_share", "asymmetry", "Stance, left compared with right"),
    NamedMeasure("swing_time", "asymmetry"),
    NamedMeasure("clearance", "asymmetry"),
    NamedMeasure("double_support_share", "both", "Both feet on the ground, part of the stride"),
    NamedMeasure("double_support", "both"),
    NamedMeasure("step_width", "both", "Step width"),
    NamedMeasure("step_length_left", "both"),
    NamedMeasure("step_length_right", "both"),
    NamedMeasure("weight_on_left", "balance", "Weight on the left foot, standing"),
    NamedMeasure("centre_to_left_standing", "balance"),
    NamedMeasure("centre_to_left", "balance", "Centre of mass left of the middle, walking"),
    NamedMeasure("centre_sway", "balance"),
    NamedMeasure("margin", "balance", "Margin of stability, least of each second"),
    NamedMeasure("external_work", "balance"),
    NamedMeasure("pendulum_recovery", "balance"),
    NamedMeasure("cadence", "foot", "Cadence"),
    NamedMeasure("stance_share", "foot", "Stance, part of the stride"),
    NamedMeasure("clearance", "foot", "Lift of the foot in swing"),
    NamedMeasure("toe_out", "foot", "Toes turned outward"),
    NamedMeasure("stride_time", "foot"),
    NamedMeasure("step_time", "foot"),
    NamedMeasure("stance_time", "foot"),
    NamedMeasure("swing_time", "foot"),
    NamedMeasure("circumduction", "foot"),
    NamedMeasure("contact_pitch", "foot"),
    NamedMeasure("toe_off_pitch", "foot"),
    NamedMeasure("lateral_placement", "foot"),
    NamedMeasure("stride_length_variation", "foot"),
    NamedMeasure("stride_time_variation", "foot"),
    NamedMeasure("force_most", "foot"),
    NamedMeasure("force_loading", "foot"),
    NamedMeasure("force_valley", "foot"),
    NamedMeasure("force_push_off", "foot"),
)
"""In the order in which they are shown, the most telling first."""


def measures_of(part: WalkPart) -> tuple[str, ...]:
    """Return the names of the measures of a part of a walk, in the order in which they are shown."""
    return tuple(one.name for one in WALK_MEASURES if one.part == part)


__all__ = ["WALK_MEASURES", "NamedMeasure", "WalkPart", "measures_of"]
