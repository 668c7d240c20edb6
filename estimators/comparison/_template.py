"""A therapist's repetitions averaged into a template with a tolerance band."""

from collections.abc import Mapping

import numpy as np
import scipy

from estimators.comparison._alignment import Alignment, align, apply, resample
from estimators.comparison._contract import PHASES, Repetition, Template, Trajectory
from estimators.comparison._judgement import judge_repetitions
from estimators.comparison._measures import hand_travels, repetition_measures, summarise
from estimators.comparison.channels.names import channel_name, channel_unit, is_of_stride, tells_movement
from estimators.comparison.channels.sided import TRUNK_CHANNELS, SideChannels, side_channels
from estimators.comparison.measures.of_session import likeness_measures
from estimators.errors import ComparisonError, SetupError
from estimators.recording import Float
from estimators.sentences import say

COVERAGE = 0.90
"""Share of the therapist's own further repetitions that the band should hold."""
FLOOR_LIMB_RAD = 0.087
FLOOR_TRUNK_RAD = 0.052
FLOOR_REACH = 0.05
"""Smallest half width of the band: what putting the sensors on again and calibrating changes by itself
(5 degrees in angles of a limb, 3 in trunk lean, 5 percent of the reach in positions)."""
FLOOR_OF_STRIDE = {"rad": 0.052, "m": 0.01, "m/s": 0.07}
"""The same of a foot that walks. A sensor put on a centimetre further back is lifted and carried along by that much
more where the foot is upright or turns by 7 rad/s; its tilt is found again from the walk, within 3 degrees."""
_SPREAD_WINDOW = 11


def build_template(
    source: Trajectory,
    repetitions: list[Repetition],
    side: str,
    reach_m: float,
    primary_channel: str,
    tolerance_scale: Mapping[str, float] | None = None,
    *,
    judge: bool = True,
) -> Template:
    """Average repetitions into a template.

    Parameters
    ----------
    source : Trajectory
        The therapist's recording.
    repetitions : list of Repetition
        Those marked as dropped are left out.
    side : {"left", "right"}
    reach_m : float
        Upper arm plus forearm of the person recorded.
    primary_channel : str
        The channel whose range is the main measure, for instance `humerus_forearm_right_zxy_flexion`.
    tolerance_scale : mapping of channel to float, optional
        Factor on the band; 1 when absent.
    judge : bool
        Leave out what `judge_repetitions` finds odd as well; False when a person has looked and decided.

    Returns
    -------
    Template
        Positions are relative to the shoulder, in metres of the person recorded.

    Raises
    ------
    ComparisonError
        If fewer than two repetitions are left or the primary channel was not measured.
    SetupError
        If the reach or a tolerance factor is not positive.

    Notes
    -----
    Each repetition is warped onto the most typical one and averaged there, so that differing pace does not
    blunt the curve; the average is then put on the mean pace. The band is a prediction interval: Student's
    t for the number of repetitions times their spread after alignment, not narrower than the floor.
    """
    if not reach_m > 0:
        raise SetupError(f"the reach is {reach_m} m; give upper arm plus forearm, for instance 0.55")
    factors = dict(tolerance_scale or {})
    if any(not factor > 0 for factor in factors.values()):
        raise SetupError("every tolerance factor must be positive; 1 leaves the band as recorded")
    judged = judge_repetitions(source, repetitions, side) if judge else repetitions
    retained = [r for r in judged if r.is_kept]
    if len(retained) < 2:
        raise ComparisonError(say("compare.few_repetitions", count=len(retained)))
    arm = side_channels(source, side)
    if primary_channel not in arm.channels:
        raise ComparisonError(
            say(
                "compare.not_measured",
                channel=channel_name(primary_channel),
                channels=list(dict.fromkeys(channel_name(channel) for channel in arm.channels)),
            )
        )
    cuts = [arm.cut(repetition) for repetition in retained]
    curves = [phase_curves(cut) for cut in cuts]
    mean, spread = _average(curves, arm.channels)
    count = len(retained)
    quantile = float(scipy.stats.t.ppf(0.5 + COVERAGE / 2, count - 1)) * np.sqrt(1 + 1 / count)
    floor = np.array([_floor(name, arm, reach_m) for name in arm.channels])
    scale = np.array([factors.get(name, 1.0) for name in arm.channels])
    turning = not hand_travels(cuts[0], side, reach_m)
    measured = summarise(
        [
            repetition_measures(source, c, r, side, reach_m, primary_channel, turning)
            for c, r in zip(cuts, retained, strict=True)
        ]
    )
    alike = likeness_measures(
        [near(one, curves[0], arm.channels) for one in curves], arm.channels, primary_channel
    )
    durations = np.array([r.end_s - r.start_s for r in retained])
    return Template(
        channels=arm.channels,
        mean=mean,
        tolerance=np.where(np.isfinite(mean), np.maximum(quantile * spread, floor) * scale, np.nan),
        duration_s=float(durations.mean()),
        duration_sd_s=float(durations.std(ddof=1)),
        repetition_count=count,
        primary_channel=primary_channel,
        side=side,
        reach_m=float(reach_m),
        measures={m.name: m.value for m in (*measured, *alike)},
        measure_sd={m.name: m.uncertainty for m in measured},
    )


def phase_curves(cut: SideChannels) -> Float:
    """Return one repetition over 101 phases, shape (101, C)."""
    return resample(cut.time_s, cut.values, PHASES)


def is_angle(channel: str) -> bool:
    """Tell whether a channel is an angle, that is, known only up to whole turns."""
    return channel_unit(channel) == "rad"


def near(curves: Float, reference: Float, channels: tuple[str, ...]) -> Float:
    """Shift angles by whole turns so that each curve lies nearest to the reference."""
    angles = [column for column, name in enumerate(channels) if is_angle(name)]
    moved, own = curves.copy(), curves[:, angles]
    turns = known_median(reference[:, angles] - own) / (2 * np.pi)
    # Of what is not known in both nothing is shifted.
    moved[:, angles] = own + 2 * np.pi * np.round(np.where(np.isfinite(turns), turns, 0.0))
    return moved


def known_median(values: Float) -> Float:
    """Return the median of what is known of each column, shape (C,); NaN where nothing is.

    Parameters
    ----------
    values : ndarray, shape (N, C)
    """
    known = np.isfinite(values)
    found = np.full(values.shape[1], np.nan)
    whole = known.all(axis=0)
    if len(values) and whole.any():
        # Median after median costs more in calls than in numbers.
        found[whole] = np.median(values[:, whole], axis=0)
    for column in np.flatnonzero(known.any(axis=0) & ~whole).tolist():
        found[column] = np.median(values[known[:, column], column])
    return found


def alignment_scale(channels: tuple[str, ...], tolerance: Float) -> Float:
    """Choose the unit of difference per channel for the warp; NaN for what should not steer it.

    Angles with a singularity, fine wrist movement and the trunk (compensation is judged, not followed)
    are left out; of the positions only the wrist counts, as elbow and hand follow from it and the angles.
    """
    steers = [tells_movement(name) or name.startswith("wrist_") for name in channels]
    return np.where(steers, known_median(tolerance), np.nan)


def align_timing(curves: Float, reference: Float, scale: Float) -> Alignment:
    """Warp by timing only: offset and size of each channel are matched first.

    Without that, a smaller movement would look like a differently timed one, because warping would hurry
    to where the values agree.
    """
    size, centre = _extent(curves)
    reference_size, reference_centre = _extent(reference)
    # A channel that hardly moves is not blown up: at most three times, so that noise stays noise.
    gain = reference_size / np.maximum(size, np.maximum(reference_size / 3.0, 1e-9))
    return align((curves - centre) * gain, reference - reference_centre, scale)


def _extent(curves: Float) -> tuple[Float, Float]:
    """Range and its middle per channel, shape (C,): unlike mean and deviation, pauses do not change them."""
    known = np.isfinite(curves)
    some = known.any(axis=0)
    high = np.max(np.where(known, curves, np.where(some, -np.inf, 0.0)), axis=0)
    low = np.min(np.where(known, curves, np.where(some, np.inf, 0.0)), axis=0)
    return high - low, (high + low) / 2


def _average(curves: list[Float], channels: tuple[str, ...]) -> tuple[Float, Float]:
    """Mean and spread over repetitions after alignment, on the mean pace, each shape (101, C)."""
    unit = np.tile([_unit_of_difference(name) for name in channels], (PHASES, 1))
    scale = alignment_scale(channels, unit)
    if not np.isfinite(scale).any():
        scale = unit[0]
    curves = [near(curve, curves[0], channels) for curve in curves]
    distance = np.array([[align_timing(a, b, scale).rms for b in curves] for a in curves])
    typical = curves[int(np.argmin(distance.sum(axis=1)))]
    alignments = [align_timing(curve, typical, scale) for curve in curves]
    aligned = np.stack([apply(a, curve, PHASES) for a, curve in zip(alignments, curves, strict=True)])
    known = np.isfinite(aligned)
    count = known.sum(axis=0)
    enough = count >= 2
    filled = np.where(known, aligned, 0.0)
    mean = filled.sum(axis=0) / np.maximum(count, 1)
    variance = (np.where(known, aligned - mean, 0.0) ** 2).sum(axis=0) / np.maximum(count - 1, 1)
    smooth = scipy.ndimage.uniform_filter1d(variance, _SPREAD_WINDOW, axis=0, mode="nearest")
    spread = np.sqrt(np.maximum(smooth, 0.0))  # the running sum may end a rounding error below zero
    mean, spread = np.where(enough, mean, np.nan), np.where(enough, spread, np.nan)
    phase = np.arange(PHASES, dtype=np.float64)
    own_phase = apply_phase(alignments)
    # A strictly rising pace: the slope of 1e-6 only breaks ties of the staircase.
    pace = (own_phase + 1e-6 * phase) / (own_phase[-1] + 1e-6 * phase[-1]) * phase[-1]
    return resample_at(pace, mean, phase), resample_at(pace, spread, phase)


def _unit_of_difference(channel: str) -> float:
    """Return what is one unit of difference where no band is known yet."""
    if is_of_stride(channel):
        return FLOOR_OF_STRIDE[channel_unit(channel)]
    return FLOOR_REACH if "." in channel else FLOOR_LIMB_RAD


def apply_phase(alignments: list[Alignment]) -> Float:
    """Mean own phase of the repetitions at each phase of the reference, shape (101,)."""
    phase = np.arange(PHASES, dtype=np.float64)[:, None]
    return np.asarray(np.mean([apply(a, phase, PHASES)[:, 0] for a in alignments], axis=0))


def resample_at(position: Float, values: Float, target: Float) -> Float:
    """Interpolate columns at `target`; NaN stays where it was."""
    result = np.full((len(target), values.shape[1]), np.nan)
    for column in range(values.shape[1]):
        finite = np.isfinite(values[:, column])
        if finite.sum() > 1:
            filled = np.interp(target, position[finite], values[finite, column])
            present = np.interp(target, position, finite.astype(np.float64)) > 0.5
            result[:, column] = np.where(present, filled, np.nan)
    return result


def _floor(channel: str, arm: SideChannels, reach_m: float) -> float:
    """Smallest half width of the band of a channel."""
    if is_of_stride(channel):
        least = FLOOR_OF_STRIDE[channel_unit(channel)]
    elif "." in channel or channel.endswith("_m"):
        return FLOOR_REACH * reach_m
    else:
        least = FLOOR_TRUNK_RAD if channel in TRUNK_CHANNELS else FLOOR_LIMB_RAD
    sigma = arm.sigma[:, arm.channels.index(channel)]
    sigma = sigma[np.isfinite(sigma)]
    two_sided = float(scipy.stats.t.ppf(0.5 + COVERAGE / 2, 1e6))
    return max(least, two_sided * float(np.median(sigma))) if len(sigma) else least
