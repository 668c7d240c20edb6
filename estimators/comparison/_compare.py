"""A session's repetitions beside the template."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from estimators.comparison._alignment import align, apply, resample
from estimators.comparison._beside import beside_template
from estimators.comparison._contract import (
    PHASES,
    ComparisonResult,
    Repetition,
    RepetitionResult,
    Template,
    Trajectory,
)
from estimators.comparison._judgement import judge_repetitions, leave_out_gaps
from estimators.comparison._measures import (
    SMALLEST_PATH,
    position_sigma,
    repetition_measures,
    summarise,
)
from estimators.comparison._template import (
    FLOOR_OF_STRIDE,
    align_timing,
    alignment_scale,
    known_median,
    near,
    phase_curves,
)
from estimators.comparison.channels.mirror import mirror_template
from estimators.comparison.channels.names import channel_unit, is_of_stride
from estimators.comparison.channels.sided import SideChannels, side_channels
from estimators.comparison.findings._findings import write_findings
from estimators.comparison.measures.of_session import likeness_measures
from estimators.comparison.repetitions import counted_repetitions, find_repetitions
from estimators.errors import SetupError
from estimators.recording import Float

_SHORTEST_OUTSIDE = 3
"""Phases (percent) that a curve must be outside the band to be called so: less is noise at the edge."""
_SURE_BEYOND = 1.28
_SURE_OF_PLACE = 2.33
"""Standard deviations by which a curve is beyond the band where it is called so: nine in ten of these are, as of a cue,
(10) of the guidance; of places 99 in 100, because an error of theirs is that of all repetitions of a session and of all
points further out."""
_LINE_M, _LINE_OF_STRIDE = 0.01, 0.1
"""So little of a place beyond the band is within the thickness of its line; of a foot that walks the share of its
floor."""
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
    counted: list[Repetition] | None = None,
    *,
    is_judged: bool = False,
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
    counted : list of Repetition, optional
        When they were counted by this template while they were made: these are all that there are, and none is left out
        for being unlike the others.
    is_judged : bool
        The given repetitions are judged already, as the strides of an analysed walk: only what lost track is left out
        as well.

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
    if counted is not None:
        found = counted_repetitions(counted, found)
    is_judged = is_judged or counted is not None
    judged = (leave_out_gaps if is_judged else judge_repetitions)(source, found, side)
    comparison = Comparison(source, template, reach_m)
    results = [comparison.of(repetition) for repetition in judged]
    retained = [one for one in results if one.repetition.is_kept]
    summary = (
        *summarise([list(one.measures) for one in retained]),
        *likeness_measures([one.curves for one in retained], template.channels, template.primary_channel),
    )
    return ComparisonResult(
        channels=template.channels,
        repetitions=tuple(results),
        summary=summary,
        findings=write_findings(results, summary, template),
    )


@dataclass(frozen=True)
class Comparison:
    """One arm's movement beside a template of that arm: what an angle needs on its way to a measure.

    Attributes
    ----------
    reach_m : float
        Upper arm plus forearm of the person measured.
    """

    source: Trajectory
    template: Template
    reach_m: float

    @cached_property
    def own(self) -> SideChannels:
        """The arm in the person's own size."""
        return side_channels(self.source, self.template.side)

    @cached_property
    def scaled(self) -> SideChannels:
        """The arm in the size of the template's person."""
        return self.own.resized(self.template.reach_m / self.reach_m)

    @cached_property
    def turning(self) -> bool:
        """Whether the exercise turns the arm without moving the hand."""
        return is_turning(self.template)

    @cached_property
    def scale(self) -> Float:
        """The unit of difference of each channel of the template for the warp, shape (C,)."""
        return alignment_scale(self.template.channels, self.template.tolerance)

    def of(self, repetition: Repetition) -> RepetitionResult:
        """Return one repetition beside the template."""
        template, own, scaled = self.template, self.own.cut(repetition), self.scaled.cut(repetition)
        if len(own.time_s) < 2:
            empty = np.full((PHASES, len(template.channels)), np.nan)
            return RepetitionResult(
                repetition, (), empty, empty, empty, np.linspace(0.0, PHASES - 1, PHASES), {}
            )
        curves = near(_on_template_channels(scaled, template), template.mean, template.channels)
        alignment = align_timing(curves, template.mean, self.scale)
        both = np.concatenate([curves, _phase_sigma(scaled, template)], axis=1)
        aligned, own_sigma = map(np.ascontiguousarray, np.hsplit(apply(alignment, both, PHASES), 2))
        sigma = _channel_sigma(scaled, template)
        measures = repetition_measures(
            self.source, own, repetition, template.side, self.reach_m, template.primary_channel, self.turning
        )
        measures.extend(beside_template(measures, aligned, sigma, alignment, repetition, template))
        return RepetitionResult(
            repetition=repetition,
            measures=tuple(measures),
            curves=curves,
            aligned=aligned,
            sigma=own_sigma,
            warp_template_phase=alignment.warp,
            outside=_outside(aligned, own_sigma, template),
        )


def is_turning(template: Template) -> bool:
    """Tell whether the exercise turns the arm without moving the hand, as pronation does."""
    columns = [i for i, name in enumerate(template.channels) if name.startswith("wrist_")]
    if not columns:
        return True
    path = template.mean[:, columns]
    path = path[np.isfinite(path).all(axis=1)]
    return len(path) == 0 or bool(np.ptp(path, axis=0).max() <= SMALLEST_PATH * template.reach_m)


def _on_template_channels(arm: SideChannels, template: Template) -> Float:
    """Put the patient's curves in the order of the template, NaN where not measured."""
    return _in_order(phase_curves(arm), arm, template)


def _phase_sigma(arm: SideChannels, template: Template) -> Float:
    """Sensor uncertainty per phase and template channel, shape (101, C); NaN where unknown.

    Near the singularity of its sequence an angle is many times less certain than in the rest of the movement.
    """
    sigma = _in_order(resample(arm.time_s, arm.sigma, PHASES), arm, template)
    unknown = _places(template) & ~np.isfinite(sigma).any(axis=0)
    if unknown.any():
        sigma[:, unknown] = position_sigma(arm, template.reach_m)
    return sigma


def _channel_sigma(arm: SideChannels, template: Template) -> Float:
    """Typical sensor uncertainty per template channel, shape (C,); NaN where unknown."""
    sigma: Float = _in_order(known_median(arm.sigma)[None], arm, template)[0]
    unknown = _places(template) & ~np.isfinite(sigma)
    if unknown.any():
        sigma[unknown] = position_sigma(arm, template.reach_m)
    return sigma


def _in_order(measured: Float, arm: SideChannels, template: Template) -> Float:
    """Put columns of the arm in the order of the template, NaN where not measured."""
    ordered = np.full((len(measured), len(template.channels)), np.nan)
    place = {name: column for column, name in enumerate(arm.channels)}
    shared = [column for column, name in enumerate(template.channels) if name in place]
    ordered[:, shared] = measured[:, [place[template.channels[column]] for column in shared]]
    return ordered


def _places(template: Template) -> NDArray[np.bool_]:
    """Return which channels of the template are places."""
    return np.array(["." in name for name in template.channels], dtype=bool)


def _outside(aligned: Float, sigma: Float, template: Template) -> dict[str, list[tuple[int, int]]]:
    """Half-open phase intervals of the template where the patient is outside the band, of channels that count.

    This is what is drawn red, and what the findings speak of: nothing else decides it. What differs by no more than two
    standard deviations of its own, or is not beyond the edge by so many that it is sure, is not known to be outside.
    """
    difference = aligned - template.mean
    excess = np.maximum(difference - template.above, -difference - template.below)
    unsure = np.nan_to_num(sigma)
    sure, line = np.array([_sure_beyond(name) for name in template.channels]).T
    sure = np.maximum(sure * unsure, line)
    beyond: NDArray[np.bool_] = (excess > sure) & (np.abs(difference) > 2.0 * unsure) & template.counts
    outside: dict[str, list[tuple[int, int]]] = {}
    for column in np.flatnonzero(beyond.any(axis=0)).tolist():
        name = template.channels[column]
        edges = np.flatnonzero(np.diff(np.concatenate([[False], beyond[:, column], [False]]).astype(np.int8)))
        runs = zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)
        long_enough = [(start, end) for start, end in runs if end - start >= _SHORTEST_OUTSIDE]
        if long_enough:
            outside[name] = long_enough
    return outside


def _sure_beyond(channel: str) -> tuple[float, float]:
    """Return how many standard deviations, and how much, a channel is beyond its band where it is called so."""
    if is_of_stride(channel):
        # The band of a foot is wider than its own error by the floor that it has for that.
        return 0.0, _LINE_OF_STRIDE * FLOOR_OF_STRIDE[channel_unit(channel)]
    return (_SURE_OF_PLACE, _LINE_M) if "." in channel else (_SURE_BEYOND, 0.0)


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
    one = side_channels(first, side, 1.0 / first_reach_m).cut(first_repetition)
    two = side_channels(second, side, 1.0 / second_reach_m).cut(second_repetition)
    shared = tuple(name for name in one.channels if name in two.channels)
    first_curves = phase_curves(one)[:, [one.channels.index(name) for name in shared]]
    second_curves = phase_curves(two)[:, [two.channels.index(name) for name in shared]]
    second_curves = near(second_curves, first_curves, shared)
    scale = np.array([_SCORE_POSITION if "." in name else _SCORE_ANGLE_RAD for name in shared])
    return align(first_curves, second_curves, scale).rms
