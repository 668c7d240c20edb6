"""A session's repetitions beside the template."""

import numpy as np
from numpy.typing import NDArray

from estimators.comparison._alignment import Alignment, align, apply
from estimators.comparison._channels import ArmChannels, arm_channels, mirror_template
from estimators.comparison._contract import (
    PHASES,
    ComparisonResult,
    Measure,
    Repetition,
    RepetitionResult,
    Template,
    Trajectory,
)
from estimators.comparison._findings import write_findings
from estimators.comparison._judgement import judge_repetitions
from estimators.comparison._measures import (
    BOUNDARY_SIGMA_S,
    SMALLEST_PATH,
    position_sigma,
    repetition_measures,
    summarise,
)
from estimators.comparison._template import align_timing, alignment_scale, is_angle, near, phase_curves
from estimators.comparison.repetitions import find_repetitions
from estimators.errors import SetupError
from estimators.recording import Float

_SHORTEST_OUTSIDE = 3
"""Phases (percent) that a curve must be outside the band to be called so: less is noise at the edge."""
_SCORE_ANGLE_RAD = 0.175
_SCORE_POSITION = 0.1


def compare(
    source: Trajectory,
    template: Template,
    side: str,
    reach_m: float,
    start_s: float | None = None,
    end_s: float | None = None,
    repetitions: list[Repetition] | None = None,
) -> ComparisonResult:
    """Compare every repetition of a session with a template.

    Parameters
    ----------
    source : Trajectory
        The patient's session.
    template : Template
        A template of the other arm is mirrored.
    side : {"left", "right"}
        The patient's arm.
    reach_m : float
        The patient's upper arm plus forearm; positions are scaled to the template's person.
    start_s, end_s : float, optional
        Half-open stretch of the session to look at.
    repetitions : list of Repetition, optional
        When a person has cut them by hand; found automatically otherwise.

    Returns
    -------
    ComparisonResult
        Channels are those of the template; what the patient did not wear is NaN. Without any clear
        repetition the result is empty and a finding says so.

    Raises
    ------
    ComparisonError
        If nothing of that side was measured.
    """
    if not reach_m > 0:
        raise SetupError(f"the reach is {reach_m} m; give upper arm plus forearm, for instance 0.55")
    if template.side != side:
        template = mirror_template(template)
    found = repetitions if repetitions is not None else find_repetitions(source, side, start_s, end_s)
    judged = judge_repetitions(source, found, side)
    own = arm_channels(source, side)
    scaled = arm_channels(source, side, template.reach_m / reach_m)
    turning = is_turning(template)
    results = [
        _compare_one(source, own.cut(r), scaled.cut(r), r, template, side, reach_m, turning) for r in judged
    ]
    summary = summarise([list(r.measures) for r in results if r.repetition.is_kept])
    return ComparisonResult(
        channels=template.channels,
        repetitions=tuple(results),
        summary=summary,
        findings=write_findings(results, summary, template),
    )


def is_turning(template: Template) -> bool:
    """Tell whether the exercise turns the arm without moving the hand, as pronation does."""
    columns = [i for i, name in enumerate(template.channels) if name.startswith("wrist_")]
    if not columns:
        return True
    path = template.mean[:, columns]
    path = path[np.isfinite(path).all(axis=1)]
    return len(path) == 0 or bool(np.ptp(path, axis=0).max() <= SMALLEST_PATH * template.reach_m)


def _compare_one(
    source: Trajectory,
    own: ArmChannels,
    scaled: ArmChannels,
    repetition: Repetition,
    template: Template,
    side: str,
    reach_m: float,
    turning: bool,
) -> RepetitionResult:
    shape = (PHASES, len(template.channels))
    if len(own.time_s) < 2:
        empty = np.full(shape, np.nan)
        return RepetitionResult(repetition, (), empty, empty, np.linspace(0.0, PHASES - 1, PHASES), {})
    curves = near(_on_template_channels(scaled, template), template.mean, template.channels)
    alignment = align_timing(curves, template.mean, alignment_scale(template.channels, template.tolerance))
    aligned = apply(alignment, curves, PHASES)
    measures = repetition_measures(source, own, repetition, side, reach_m, template.primary_channel, turning)
    sigma = _channel_sigma(scaled, template, template.reach_m)
    measures.extend(_beside_template(measures, aligned, sigma, alignment, repetition, template))
    return RepetitionResult(
        repetition=repetition,
        measures=tuple(measures),
        curves=curves,
        aligned=aligned,
        warp_template_phase=alignment.warp,
        outside=_outside(aligned, template),
    )


def _on_template_channels(arm: ArmChannels, template: Template) -> Float:
    """Put the patient's curves in the order of the template, NaN where not measured."""
    measured = phase_curves(arm)
    curves = np.full((PHASES, len(template.channels)), np.nan)
    for column, name in enumerate(template.channels):
        if name in arm.channels:
            curves[:, column] = measured[:, arm.channels.index(name)]
    return curves


def _beside_template(
    own: list[Measure],
    aligned: Float,
    sigma: Float,
    alignment: Alignment,
    repetition: Repetition,
    template: Template,
) -> list[Measure]:
    """Measures that need the template: timing and shape apart, and the main ratio."""
    found: list[Measure] = []

    def add(name: str, group: str, value: float, unit: str, uncertainty: float) -> None:
        found.append(Measure(name, group, float(value), unit, float(uncertainty), 1))

    duration = repetition.end_s - repetition.start_s
    ratio = duration / template.duration_s
    relative = np.hypot(
        np.sqrt(2) * BOUNDARY_SIGMA_S / duration, _finite(template.duration_sd_s) / template.duration_s
    )
    add("duration_ratio", "timing", ratio, "1", ratio * relative)
    # A bound moved by one standard deviation shifts the phases by that share, on average half of it.
    add(
        "timing_deviation",
        "timing",
        100 * alignment.timing_deviation,
        "%",
        100 * 0.5 * BOUNDARY_SIGMA_S / duration,
    )
    name = f"range:{template.primary_channel}"
    extent = next((m for m in own if m.name == name), None)
    reference = template.measures.get(name, np.nan)
    if extent is not None and reference > 0:
        ratio = extent.value / reference
        spread = np.hypot(
            extent.uncertainty / reference, ratio * _finite(template.measure_sd.get(name)) / reference
        )
        add(f"range_ratio:{template.primary_channel}", "range", ratio, "1", spread)
    found.extend(_shape_measures(aligned, sigma, template))
    return found


def _shape_measures(aligned: Float, sigma: Float, template: Template) -> list[Measure]:
    """Measure what differs after alignment; `sigma` is the sensors' own uncertainty per channel."""
    found: list[Measure] = []

    def add(name: str, value: float, unit: str, uncertainty: float) -> None:
        found.append(Measure(name, "shape", float(value), unit, float(uncertainty), 1))

    difference = aligned - template.mean
    relative = np.abs(difference / template.tolerance)
    judged: NDArray[np.bool_] = np.asarray(np.isfinite(relative))
    if judged.any():
        unsure = np.broadcast_to(sigma / template.tolerance, relative.shape)[judged]
        known = unsure[np.isfinite(unsure)]
        mean_unsure = float(np.sqrt(np.mean(known**2))) if len(known) else np.nan
        deviation = relative[judged]
        add("shape_deviation", float(np.sqrt(np.mean(deviation**2))), "bands", mean_unsure)
        wide, narrow = (float(np.mean(deviation <= 1 + step * mean_unsure)) for step in (1, -1))
        half_width = 50 * (wide - narrow) if np.isfinite(mean_unsure) else np.nan
        add("inside_band", 100 * float(np.mean(deviation <= 1)), "%", half_width)
    primary = template.primary_channel
    column = template.channels.index(primary)
    error = np.abs(difference[:, column])
    if np.isfinite(error).any():
        unit = "rad" if is_angle(primary) else "m"
        phase = int(np.nanargmax(error))
        add(f"peak_deviation:{primary}", difference[phase, column], unit, sigma[column])
        # Any phase within one sigma of the largest difference might be the true one.
        rivals = np.flatnonzero(error >= error[phase] - sigma[column])
        spread = float(np.std(rivals)) if np.isfinite(sigma[column]) else np.nan
        add("peak_deviation_phase", phase, "%", spread)
        add(f"shape_rms:{primary}", float(np.sqrt(np.nanmean(error**2))), unit, sigma[column])
    return found


def _channel_sigma(arm: ArmChannels, template: Template, reach_m: float) -> Float:
    """Typical sensor uncertainty per template channel, shape (C,); NaN where unknown."""
    sigma = np.full(len(template.channels), np.nan)
    for column, name in enumerate(template.channels):
        if "." in name:
            sigma[column] = position_sigma(arm, reach_m)
        elif name in arm.channels:
            own = arm.sigma[:, arm.channels.index(name)]
            sigma[column] = np.median(own[np.isfinite(own)]) if np.isfinite(own).any() else np.nan
    return sigma


def _finite(value: float | None) -> float:
    return value if value is not None and np.isfinite(value) else 0.0


def _outside(aligned: Float, template: Template) -> dict[str, list[tuple[int, int]]]:
    """Half-open phase intervals of the template where the patient is outside the band."""
    outside: dict[str, list[tuple[int, int]]] = {}
    for column, name in enumerate(template.channels):
        distance = np.abs(aligned[:, column] - template.mean[:, column])
        beyond: NDArray[np.bool_] = np.isfinite(distance) & (distance > template.tolerance[:, column])
        edges = np.flatnonzero(np.diff(np.concatenate([[False], beyond, [False]]).astype(np.int8)))
        runs = zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)
        long_enough = [(start, end) for start, end in runs if end - start >= _SHORTEST_OUTSIDE]
        if long_enough:
            outside[name] = long_enough
    return outside


def difference_score(
    first: Trajectory,
    first_repetition: Repetition,
    first_reach_m: float,
    second: Trajectory,
    second_repetition: Repetition,
    second_reach_m: float,
    side: str,
) -> float:
    """Return how much two repetitions differ in shape; zero for the same movement at whatever pace.

    Parameters
    ----------
    first, second : Trajectory
    first_repetition, second_repetition : Repetition
    first_reach_m, second_reach_m : float
        Positions count in units of each person's own reach.
    side : {"left", "right"}
        The arm in both; mirror one with `mirror_trajectory` to compare left with right.

    Returns
    -------
    float
        Root mean square over the warped repetitions and channels; 1 means 10 degrees or 10 percent of the
        reach. Symmetric in the two repetitions.
    """
    one = arm_channels(first, side, 1.0 / first_reach_m).cut(first_repetition)
    two = arm_channels(second, side, 1.0 / second_reach_m).cut(second_repetition)
    shared = tuple(name for name in one.channels if name in two.channels)
    first_curves = phase_curves(one)[:, [one.channels.index(name) for name in shared]]
    second_curves = phase_curves(two)[:, [two.channels.index(name) for name in shared]]
    second_curves = near(second_curves, first_curves, shared)
    scale = np.array([_SCORE_POSITION if "." in name else _SCORE_ANGLE_RAD for name in shared])
    return align(first_curves, second_curves, scale).rms
