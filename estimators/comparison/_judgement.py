"""Which repetitions to leave out, and why, in words a therapist would use."""

from dataclasses import replace

import numpy as np

from estimators.comparison._alignment import align, apply, resample
from estimators.comparison._channels import ArmChannels, arm_channels, fill_gaps
from estimators.comparison._contract import PHASES, Repetition, Trajectory
from estimators.recording import Float
from estimators.sentences import say

_MAXIMUM_GAP_S = 0.3
_MAXIMUM_GAP_SHARE = 0.10
_SHORT, _LONG, _SMALL, _OPPOSITE = 0.5, 2.0, 0.6, -0.2
_UNLIKE_FLOOR = 0.15
"""Share of the movement's size: repetitions of healthy people differ by half of this; less is never odd."""
_UNLIKE_MADS = 5.0
_ANGLE_WEIGHT = 0.5


def judge_repetitions(source: Trajectory, repetitions: list[Repetition], side: str) -> list[Repetition]:
    """Mark the repetitions that should not count, with a plain reason.

    Parameters
    ----------
    source : Trajectory
    repetitions : list of Repetition
        As found; those already dropped (by a person) stay dropped with their reason.
    side : {"left", "right"}

    Returns
    -------
    list of Repetition
        Same order and bounds. Judged against the median of the others, so at least three are needed for
        anything but a tracking gap.

    Raises
    ------
    ComparisonError
        If nothing of that side was measured.
    """
    arm = arm_channels(source, side)
    judged = list(repetitions)
    for place, repetition in enumerate(judged):
        if repetition.is_kept and (reason := _gap_reason(arm.cut(repetition))):
            judged[place] = replace(repetition, is_kept=False, reason=reason)
    for judge in (_judge_duration, _judge_size_and_direction, _judge_likeness):
        kept = [place for place, repetition in enumerate(judged) if repetition.is_kept]
        if len(kept) < 3:
            break
        for place, reason in judge(arm, [judged[k] for k in kept], kept):
            judged[place] = replace(judged[place], is_kept=False, reason=reason)
    return judged


def _posture(arm: ArmChannels) -> Float:
    """Wrist and elbow angles as columns with comparable units; NaN in gaps."""
    columns = []
    for name in arm.channels:
        column = arm.values[:, arm.channels.index(name)]
        if name.startswith("wrist_"):
            columns.append(column / 0.55)
        elif name.endswith(("_zxy_flexion", "_zxy_pronation", "_yxy_elevation")) and "hand" not in name:
            columns.append(column * _ANGLE_WEIGHT)
    return np.stack(columns, axis=1) if columns else arm.values


def _gap_reason(cut: ArmChannels) -> str:
    if len(cut.time_s) < 5:
        return say("repetition.no_measurement")
    step_s = float(np.median(np.diff(cut.time_s)))
    posture = _posture(cut)
    lost = ~np.isfinite(posture[:, np.isfinite(posture).any(axis=0)]).all(axis=1)
    if not np.isfinite(posture).any():
        return say("repetition.no_measurement")
    longest = _longest_run(np.asarray(lost)) * step_s
    if longest > _MAXIMUM_GAP_S or lost.mean() > _MAXIMUM_GAP_SHARE:
        return say("repetition.lost", lost_s=max(longest, float(lost.sum()) * step_s))
    return ""


def _longest_run(mask: np.typing.NDArray[np.bool_]) -> int:
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8)))
    return int((edges[1::2] - edges[::2]).max()) if len(edges) else 0


def _judge_duration(arm: ArmChannels, kept: list[Repetition], places: list[int]) -> list[tuple[int, str]]:
    durations = np.array([r.end_s - r.start_s for r in kept])
    usual = float(np.median(durations))
    odd: list[tuple[int, str]] = []
    for place, duration in zip(places, durations, strict=True):
        if duration < _SHORT * usual:
            odd.append((place, say("repetition.shorter", duration_s=duration, usual_s=usual)))
        elif duration > _LONG * usual:
            odd.append((place, say("repetition.longer", duration_s=duration, usual_s=usual)))
    return odd


def _judge_size_and_direction(
    arm: ArmChannels, kept: list[Repetition], places: list[int]
) -> list[tuple[int, str]]:
    curves = _curves(arm, kept)
    curves = [curve - (curve[0] + curve[-1]) / 2 for curve in curves]
    usual = np.median(np.stack(curves), axis=0)
    if not usual.any():
        return []
    odd: list[tuple[int, str]] = []
    for place, curve in zip(places, curves, strict=True):
        # Laid on each other in time first, or a hesitation would look like a smaller movement.
        laid = apply(align(curve, usual, np.ones(usual.shape[1])), curve, PHASES)
        along = float(np.sum(laid * usual) / np.sum(usual * usual))
        if float(np.sum(curve * usual) / np.sum(usual * usual)) < _OPPOSITE:
            odd.append((place, say("repetition.opposite")))
        elif along < _SMALL:
            odd.append((place, say("repetition.half_way", share=along)))
    return odd


def _curves(arm: ArmChannels, kept: list[Repetition]) -> list[Float]:
    curves = []
    for repetition in kept:
        cut = arm.cut(repetition)
        filled, _ = fill_gaps(_posture(cut))
        curves.append(resample(cut.time_s, filled, PHASES))
    return curves


def _judge_likeness(arm: ArmChannels, kept: list[Repetition], places: list[int]) -> list[tuple[int, str]]:
    curves = _curves(arm, kept)
    middle = np.median(np.stack(curves), axis=0)
    size = float(np.linalg.norm(middle - middle[0], axis=1).max())
    if size == 0:
        return []
    scale = np.full(middle.shape[1], size / np.sqrt(middle.shape[1]))
    distances = np.array([align(curve, middle, scale).rms for curve in curves])
    usual = float(np.median(distances))
    spread = 1.4826 * float(np.median(np.abs(distances - usual)))
    limit = max(usual + _UNLIKE_MADS * spread, usual + _UNLIKE_FLOOR)
    return [
        (place, say("repetition.unlike"))
        for place, distance in zip(places, distances, strict=True)
        if distance > limit
    ]
