"""Comparison with a template: repetitions, alignment, timing and shape apart, measures, findings.

::

    moved = trajectory(frames)
    repetitions = find_repetitions(moved, "right")
    template = build_template(moved, repetitions, "right", reach_m=0.55, primary_channel="...")
    result = compare(trajectory(patient_frames), template, "right", reach_m=0.52)
"""

from estimators.comparison._activity import moving_time
from estimators.comparison._bands import FREE, Knot, NamedPhase, ToleranceCurve
from estimators.comparison._codec import (
    comparison_from_bytes,
    comparison_to_bytes,
    template_from_bytes,
    template_to_bytes,
)
from estimators.comparison._compare import compare, difference_score
from estimators.comparison._contract import (
    PHASES,
    ComparisonResult,
    Measure,
    Repetition,
    RepetitionResult,
    Template,
    Trajectory,
)
from estimators.comparison._judgement import judge_repetitions
from estimators.comparison._measures import measure_label, measure_unit, measures_beside
from estimators.comparison._template import build_template, near, phase_curves
from estimators.comparison.channels.feet import Stood, foot_trajectory
from estimators.comparison.channels.mirror import mirror_template, mirror_trajectory, mirrored_name
from estimators.comparison.channels.names import (
    channel_label,
    channel_name,
    channel_unit,
    foot_channels,
    is_of_stride,
)
from estimators.comparison.channels.sided import TRUNK_CHANNELS, SideChannels, side_channels
from estimators.comparison.channels.trajectory import trajectory
from estimators.comparison.measures.of_session import TOGETHER
from estimators.comparison.repetitions import find_repetitions
from estimators.comparison.repetitions.own_band import leaves_band

__all__ = [
    "FREE",
    "PHASES",
    "TOGETHER",
    "TRUNK_CHANNELS",
    "ComparisonResult",
    "Knot",
    "Measure",
    "NamedPhase",
    "Repetition",
    "RepetitionResult",
    "SideChannels",
    "Stood",
    "Template",
    "ToleranceCurve",
    "Trajectory",
    "build_template",
    "channel_label",
    "channel_name",
    "channel_unit",
    "compare",
    "comparison_from_bytes",
    "comparison_to_bytes",
    "difference_score",
    "find_repetitions",
    "foot_channels",
    "foot_trajectory",
    "is_of_stride",
    "judge_repetitions",
    "leaves_band",
    "measure_label",
    "measure_unit",
    "measures_beside",
    "mirror_template",
    "mirror_trajectory",
    "mirrored_name",
    "moving_time",
    "near",
    "phase_curves",
    "side_channels",
    "template_from_bytes",
    "template_to_bytes",
    "trajectory",
]
