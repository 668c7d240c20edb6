"""Which repetitions to leave out, and why, in words a therapist would use."""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from estimators.comparison._alignment import align, apply, resample
from estimators.comparison._contract import PHASES, Repetition, Trajectory
from estimators.comparison._posture import posture
from estimators.comparison.channels.sided import fill_gaps
from estimators.comparison.repetitions.cycles_kernel import walk
from estimators.recording import Float
from estimators.sentences import say

_MAXIMUM_GAP_S = 0.3
_MAXIMUM_GAP_SHARE = 0.10
_SHORT, _LONG, _SMALL, _OPPOSITE = 0.5, 3.0, 0.7, -0.2
_UNLIKE_FLOOR = 0.15
"""Share of the movement's size: repetitions of healthy people differ by half of this; less is never odd."""
_UNLIKE_MADS = 5.0
_HELD = 5.0
"""Times the usual: a step of the way that takes longer is a hold."""
_STEP = 0.05
"""Share of a repetition's size below which nothing belongs to its way: tremor, noise."""


@dataclass(frozen=True)
class _Moved:
    """Posture over time, NaN where nothing was measured."""

    time_s: Float
    values: Float
    _ways: dict[tuple[float, float], "_Way"] = field(default_factory=dict)

    def cut(self, repetition: Repetition) -> "_Moved":
        inside = repetition.ticks(self.time_s)
        return _Moved(self.time_s[inside], self.values[inside])

    def way(self, repetition: Repetition) -> "_Way":
        """Return the way of a repetition, walked once for all that judge it."""
        bounds = repetition.start_s, repetition.end_s
        if bounds not in self._ways:
            self._ways[bounds] = _walked(self.cut(repetition))
        return self._ways[bounds]


@dataclass(frozen=True)
class _Way:
    """The way of one repetition, without gaps.

    Attributes
    ----------
    step_s : float
        From tick to tick.
    filled : ndarray, shape (N, D)
        Its postures.
    points : ndarray, shape (M, D)
        The same in steps of one length; as it is where nothing moves.
    place : ndarray, shape (M,), or None
        Tick, with fraction, at which it came to each point; None where nothing moves.
    """

    step_s: float
    filled: Float
    points: Float
    place: Float | None

    @cached_property
    def curve(self) -> Float:
        """The way evenly along it, shape (101, D): pace and holds are no matter of its shape."""
        path = np.concatenate([self.points, self.filled[-1:]])
        return resample(np.arange(len(path), dtype=np.float64), path, PHASES)


def _walked(cut: _Moved) -> _Way:
    filled, _ = fill_gaps(cut.values)
    step_s = float(np.median(np.diff(cut.time_s)))
    size = float(np.linalg.norm(filled - filled[0], axis=1).max())
    if not size > 0:
        return _Way(step_s, filled, filled, None)
    return _Way(step_s, filled, *walk(np.ascontiguousarray(filled), _STEP * size))


def judge_repetitions(source: Trajectory, repetitions: list[Repetition], side: str) -> list[Repetition]:
    """Mark the repetitions that should not count, with a plain reason.

    Parameters
    ----------
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
    moved = _Moved(source.time_s, posture(source, side))
    judged = _without_gaps(moved, repetitions)
    for judge in (_judge_duration, _judge_size_and_direction, _judge_likeness):
        retained = [place for place, repetition in enumerate(judged) if repetition.is_kept]
        if len(retained) < 3:
            break
        for place, reason in judge(moved, [judged[k] for k in retained], retained):
            judged[place] = replace(judged[place], is_kept=False, reason=reason)
    return judged


def leave_out_gaps(source: Trajectory, repetitions: list[Repetition], side: str) -> list[Repetition]:
    """Mark the repetitions in which the sensors lost track; parameters and errors as of `judge_repetitions`."""
    return _without_gaps(_Moved(source.time_s, posture(source, side)), repetitions)


def _without_gaps(moved: _Moved, repetitions: list[Repetition]) -> list[Repetition]:
    judged = list(repetitions)
    for place, repetition in enumerate(judged):
        if repetition.is_kept and (reason := _gap_reason(moved.cut(repetition))):
            judged[place] = replace(repetition, is_kept=False, reason=reason)
    return judged


def _gap_reason(cut: _Moved) -> str:
    if len(cut.time_s) < 5:
        return say("repetition.no_measurement")
    step_s = float(np.median(np.diff(cut.time_s)))
    sound = np.isfinite(cut.values)
    lost = ~sound[:, sound.any(axis=0)].all(axis=1)
    if not sound.any():
        return say("repetition.no_measurement")
    longest = _longest_run(np.asarray(lost)) * step_s
    if longest > _MAXIMUM_GAP_S or lost.mean() > _MAXIMUM_GAP_SHARE:
        return say("repetition.lost", lost_s=max(longest, float(lost.sum()) * step_s))
    return ""


def _longest_run(mask: np.typing.NDArray[np.bool_]) -> int:
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8)))
    return int((edges[1::2] - edges[::2]).max()) if len(edges) else 0


def _judge_duration(moved: _Moved, retained: list[Repetition], places: list[int]) -> list[tuple[int, str]]:
    durations = np.array([r.end_s - r.start_s for r in retained])
    usual = float(np.median(durations))
    # Who leaves out a hold has moved no shorter.
    moving = np.array([_moving_s(moved.way(r)) for r in retained])
    is_short = (durations < _SHORT * usual) & (moving < _SHORT * np.median(moving))
    odd: list[tuple[int, str]] = []
    for place, duration, short in zip(places, durations, is_short, strict=True):
        if short:
            odd.append((place, say("repetition.shorter", duration_s=duration, usual_s=usual)))
        elif duration > _LONG * usual:
            odd.append((place, say("repetition.longer", duration_s=duration, usual_s=usual)))
    return odd


def _moving_s(way: _Way) -> float:
    """How long a repetition takes without what is held in it, and a hold is a step that takes far longer than usual."""
    if way.place is None:
        return 0.0
    took = np.diff(way.place, append=len(way.filled) - 1.0)
    return float(np.minimum(took, _HELD * np.median(took)).sum()) * way.step_s


def _judge_size_and_direction(
    moved: _Moved, retained: list[Repetition], places: list[int]
) -> list[tuple[int, str]]:
    curves = [curve - (curve[0] + curve[-1]) / 2 for curve in (moved.way(r).curve for r in retained)]
    usual = np.median(np.stack(curves), axis=0)
    if not usual.any():
        return []
    odd: list[tuple[int, str]] = []
    for place, curve in zip(places, curves, strict=True):
        # Laid on each other in time first, or a hesitation would look like a smaller movement.
        laid = apply(align(curve, usual, np.ones(usual.shape[1])), curve, PHASES)
        along = float(np.sum(laid * usual) / np.sum(usual * usual))
        if along < _OPPOSITE:
            odd.append((place, say("repetition.opposite")))
        elif along < _SMALL:
            odd.append((place, say("repetition.half_way", share=along)))
    return odd


def _judge_likeness(moved: _Moved, retained: list[Repetition], places: list[int]) -> list[tuple[int, str]]:
    curves = [moved.way(r).curve for r in retained]
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
