"""The measures of one repetition, each with its uncertainty; and their summary over repetitions."""

from dataclasses import dataclass

import numpy as np
import scipy

from estimators.comparison._contract import Measure, Repetition, Template, Trajectory
from estimators.comparison._smoothness import (
    UNIT_RISE_MPS,
    UNIT_RISE_RADPS,
    movement_units,
    noise_level,
    spectral_arc_length,
    spectral_arc_length_uncertainty,
)
from estimators.comparison.channels.names import channel_label, channel_unit, is_of_stride
from estimators.comparison.channels.sided import SideChannels, fill_gaps, is_compensation
from estimators.comparison.measures.of_repetition import (
    coordination_measures,
    stroke_measures,
    units_measure,
)
from estimators.comparison.measures.of_session import TOGETHER
from estimators.comparison.measures.strokes import outward_stroke
from estimators.errors import SetupError
from estimators.measures import MEASURES
from estimators.recording import Float

BOUNDARY_SIGMA_S = 0.08
"""Standard deviation of a found beginning or end, measured on simulated movements with exact truth."""
CONTACT_SIGMA_S = 0.015
"""Of a contact of the foot with the floor, with which strides begin and end (`gait.find_strides`)."""
LEAN_SIGMA_RAD = 0.0087
HIKE_SIGMA_M = 0.006
"""Standard deviation of the range of a lean or turn of the trunk and of a shoulder's rise within one repetition, where
the estimate states none: half a degree, against exact truth in 72 simulated repetitions of five movements (forward
0.27, sideways 0.43, turn 0.17 degrees); 6 mm as live guidance takes it."""
PATH_SMOOTHING_S = 0.02
"""Standard deviation of the smoothing before a path length: sensor noise would lengthen the path without
limit; a tremor of 5 Hz keeps 82 percent of its size."""
SMALLEST_PATH = 0.10
"""Share of the reach below which the hand did not travel: path and speed then describe turning."""

_ABOVE_THE_HAND = ("thorax_humerus", "humerus_forearm")

_LABELS = {one.name: one.label for one in MEASURES if one.part == "repetition"}
_UNITS = {one.name.rstrip(":"): one.unit for one in MEASURES if one.part == "repetition" and one.unit}


def measure_unit(name: str) -> str:
    """Return the unit of a measure of a repetition, which its values carry too; `range:` and the like by their channel.

    Raises
    ------
    SetupError
        If there is no such measure.
    """
    prefix, _, channel = name.partition(":")
    if prefix not in _LABELS and f"{prefix}:" not in _LABELS:
        raise SetupError(f"no measure of a repetition is named {name!r}")
    return _UNITS.get(prefix) or channel_unit(channel)


def measures_beside(template: Template) -> tuple[str, ...]:
    """Return the names of what a repetition is measured by beside this template, in the order of the register.

    What only all repetitions together give is not among them. A patient with fewer sensors has fewer.
    """
    main = template.primary_channel
    own = [name for name in template.measures if not name.startswith(TOGETHER)]
    beside = [
        "duration_ratio",
        "timing_deviation",
        f"range_ratio:{main}",
        "shape_deviation",
        "inside_band",
        f"peak_deviation:{main}",
        "peak_deviation_phase",
        f"shape_rms:{main}",
        *(("path_residual", "path_turn", "path_scale") if "hand_path_ratio" in own else ()),
    ]
    order = [one.name for one in MEASURES if one.part == "repetition"]

    def rank(name: str) -> int:
        prefix, colon, _ = name.partition(":")
        return order.index(prefix + colon)

    return tuple(sorted((*own, *beside), key=rank))


def bound_sigma_s(primary: str) -> float:
    """Return the standard deviation of a beginning or end of the repetitions that a main channel is of."""
    return CONTACT_SIGMA_S if is_of_stride(primary) else BOUNDARY_SIGMA_S


def measure_label(name: str) -> str:
    """Return what a person calls a measure: `Elbow flexion, range of motion`."""
    if name in _LABELS:
        return _LABELS[name]
    prefix, _, channel = name.partition(":")
    return f"{channel_label(channel)}, {_LABELS.get(f'{prefix}:', prefix.replace('_', ' '))}"


@dataclass(frozen=True)
class SpeedProfile:
    """How fast one repetition went: of the hand in m/s, or of the turning in rad/s."""

    values: Float
    rate_hz: float
    is_turning: bool


def hand_travel(arm: SideChannels, side: str) -> Float | None:
    """Wrist relative to the shoulder, shape (N, 3), m; None when it was not measured."""
    axes = [arm.column(f"wrist_{side}.{axis}") for axis in "xyz"]
    if any(axis is None or not np.isfinite(axis).any() for axis in axes):
        return None
    return fill_gaps(np.stack([axis for axis in axes if axis is not None], axis=1))[0]


def hand_travels(arm: SideChannels, side: str, reach_m: float) -> bool:
    """Tell whether the hand moves far enough for its path and speed to mean something."""
    path = hand_travel(arm, side)
    return path is not None and bool(np.ptp(path, axis=0).max() > SMALLEST_PATH * reach_m)


def speed_profile(
    source: Trajectory, arm: SideChannels, side: str, primary: str, turning: bool
) -> SpeedProfile | None:
    """Return the speed during one repetition.

    The hand's speed in the room comes from the pipeline, where it follows from turning rates; without it,
    from the wrist's path. A turning movement uses the rate of its primary angle. None where it was not measured, or a
    sensor that it needs has turned in its strap.
    """
    if len(arm.time_s) < 8:
        return None
    step_s = arm.step_s
    window = max(5, 2 * round(0.05 / step_s) + 1)
    if turning:
        angle = arm.column(primary)
        if angle is None or not np.isfinite(angle).any() or len(angle) <= window:
            return None
        rate = scipy.signal.savgol_filter(
            fill_gaps(angle[:, None])[0][:, 0], window, 3, deriv=1, delta=step_s
        )
        return SpeedProfile(np.abs(rate), 1.0 / step_s, True)
    name = f"hand_speed_{side}_mps"
    if name in source.channels:
        column = source.channels.index(name)
        start = int(np.searchsorted(source.time_s, arm.time_s[0] - 1e-9))
        chosen = slice(start, start + len(arm.time_s))
        if source.unseated is not None and source.unseated[chosen, column].any():
            # Not from the path either: seen from the shoulder it is another speed than the others'.
            return None
        speed = np.where(source.valid[chosen, column], source.values[chosen, column], np.nan)
        if np.isfinite(speed).mean() > 0.5:
            return SpeedProfile(fill_gaps(speed[:, None])[0][:, 0], 1.0 / step_s, False)
    path = hand_travel(arm, side)
    if path is None or len(path) <= window:
        return None
    velocity = scipy.signal.savgol_filter(path, window, 3, deriv=1, delta=step_s, axis=0)
    return SpeedProfile(np.linalg.norm(velocity, axis=1), 1.0 / step_s, False)


def repetition_measures(
    source: Trajectory,
    arm: SideChannels,
    repetition: Repetition,
    side: str,
    reach_m: float,
    primary: str,
    turning: bool,
) -> list[Measure]:
    """Measure one repetition by itself, without a template.

    Parameters
    ----------
    source : Trajectory
        Of the session, for the hand's speed.
    arm : SideChannels
        Cut to the repetition, unscaled (metres of the person measured).
    side : {"left", "right"}
    reach_m : float
        Upper arm plus forearm of the person measured.
    primary : str
        Main channel of the exercise.
    turning : bool
        True when the exercise turns the arm without moving the hand.

    Returns
    -------
    list of Measure
        Uncertainty is one standard deviation from the sensors' own uncertainty, NaN where unknown. A stride has its
        duration and ranges alone: it has no way out that speed and smoothness would be of.
    """
    duration = repetition.end_s - repetition.start_s
    measures = [_single("duration", "timing", duration, "s", np.sqrt(2.0) * bound_sigma_s(primary))]
    measures.extend(_extents(arm))
    if is_of_stride(primary):
        return measures
    path, smoothed, sigma_m = None if turning else hand_travel(arm, side), None, float("nan")
    if path is not None:
        step_s = arm.step_s
        smoothed = scipy.ndimage.gaussian_filter1d(path, PATH_SMOOTHING_S / step_s, axis=0, mode="nearest")
        sigma_m = position_sigma(arm, reach_m)
        measures.append(_path_ratio(smoothed, sigma_m))
    profile = speed_profile(source, arm, side, primary, turning)
    if profile is None:
        return measures
    noise = noise_level(profile.values, profile.rate_hz)
    measures.extend(_speed_measures(profile, noise))
    if smoothed is not None:
        measures.append(units_measure(smoothed, profile.rate_hz, reach_m, measures[-1].uncertainty, sigma_m))
    angle = arm.column(primary)
    if turning and angle is not None:
        path = fill_gaps(angle[:, None])[0]
    if path is not None:
        rise = UNIT_RISE_RADPS if turning else UNIT_RISE_MPS
        stroke = outward_stroke(path, profile.rate_hz)
        measures.extend(stroke_measures(profile.values, path, profile.rate_hz, rise, stroke, noise))
        measures.extend(coordination_measures(arm, side, stroke, profile.rate_hz))
    return measures


def _extents(arm: SideChannels) -> list[Measure]:
    """Return the range of every angle, and of everything that shows compensation."""
    found = []
    columns = [column for column, name in enumerate(arm.channels) if "." not in name]
    for column, extent, sigma in zip(
        columns, *_ranges(arm.values[:, columns], arm.sigma[:, columns]), strict=True
    ):
        channel = arm.channels[column]
        if not is_compensation(channel):
            found.append(_single(f"range:{channel}", "range", extent, channel_unit(channel), sigma))
            continue
        if not np.isfinite(sigma):
            sigma = HIKE_SIGMA_M if channel_unit(channel) == "m" else LEAN_SIGMA_RAD
        name = f"compensation:{channel}"
        found.append(_single(name, "compensation", extent, channel_unit(channel), sigma))
    return found


def _single(name: str, group: str, value: float, unit: str, sigma: float) -> Measure:
    return Measure(name=name, group=group, value=float(value), unit=unit, uncertainty=float(sigma), count=1)


def _ranges(values: Float, sigma: Float) -> tuple[list[float], list[float]]:
    """Largest minus smallest value of each column and its standard deviation, the two ends taken as independent."""
    known, every = ~np.isnan(values), np.arange(values.shape[1])
    high = np.argmax(np.where(known, values, -np.inf), axis=0)
    low = np.argmin(np.where(known, values, np.inf), axis=0)
    is_enough = np.isfinite(values).mean(axis=0) >= 0.5
    extent = np.where(is_enough, values[high, every] - values[low, every], np.nan)
    return extent.tolist(), np.where(
        is_enough, np.hypot(sigma[high, every], sigma[low, every]), np.nan
    ).tolist()


def position_sigma(arm: SideChannels, reach_m: float) -> float:
    """Return the standard deviation of the hand's place along an axis, m; NaN where unknown.

    Where the places carry their own it is the root of their mean square. Otherwise it is estimated as that of a hand at
    full reach: of elevation and flexion, and of the plane of elevation, which turns what the arm reaches outward, each
    tick by the least certain of them.
    """
    wrist = [column for column, name in enumerate(arm.channels) if name.startswith("wrist_") and "." in name]
    own = arm.sigma[:, wrist]
    if np.isfinite(own).any():
        return float(np.sqrt(np.nanmean(own**2)))
    elevation = [name for name in arm.channels if name.endswith("_yxy_elevation")]
    angular = []
    for column, name in enumerate(arm.channels):
        sigma = arm.sigma[:, column]
        if name.endswith("_yxy_plane_of_elevation") and elevation:
            angular.append(sigma * np.abs(np.sin(arm.values[:, arm.channels.index(elevation[0])])))
        elif name.endswith(("_zxy_flexion", "_yxy_elevation")) and name.startswith(_ABOVE_THE_HAND):
            angular.append(sigma)
    if not angular:
        return float("nan")
    worst = np.fmax.reduce(angular)
    known = worst[np.isfinite(worst)]
    return reach_m * float(np.sqrt(np.mean(known**2))) if len(known) else float("nan")


def _path_ratio(path: Float, sigma_m: float) -> Measure:
    """Way of the hand out and back divided by twice the straight line to its farthest point."""
    far = int(np.argmax(np.linalg.norm(path - (path[0] + path[-1]) / 2, axis=1)))
    way_m = float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
    straight_m = float(np.linalg.norm(path[far] - path[0]) + np.linalg.norm(path[far] - path[-1]))
    if straight_m <= 0:
        return _single("hand_path_ratio", "path", np.nan, "1", np.nan)
    ratio = way_m / straight_m
    return _single("hand_path_ratio", "path", ratio, "1", ratio * 2.0 * sigma_m / straight_m)


def _speed_measures(profile: SpeedProfile, noise: float) -> list[Measure]:
    speed, rate_hz = profile.values, profile.rate_hz
    rise = UNIT_RISE_RADPS if profile.is_turning else UNIT_RISE_MPS
    name, unit = ("turning_speed", "rad/s") if profile.is_turning else ("speed", "m/s")
    units = [movement_units(speed, rate_hz, factor * rise) for factor in (0.5, 1.0, 1.5)]
    return [
        _single(f"peak_{name}", "path", speed.max(), unit, noise),
        _single(f"mean_{name}", "path", speed.mean(), unit, noise / np.sqrt(len(speed))),
        _single(
            "spectral_arc_length",
            "smoothness",
            spectral_arc_length(speed, rate_hz),
            "1",
            spectral_arc_length_uncertainty(speed, rate_hz, noise),
        ),
        # What the choice of the smallest push changes is the uncertainty of the count.
        _single("movement_units", "smoothness", units[1], "count", (units[0] - units[2]) / 2),
    ]


def summarise(per_repetition: list[list[Measure]]) -> tuple[Measure, ...]:
    """Average each measure over repetitions.

    Returns
    -------
    tuple of Measure
        Mean over the repetitions that have the measure, standard deviation between them (NaN for one) and
        their count, in the order of first appearance.
    """
    collected: dict[str, list[Measure]] = {}
    for measures in per_repetition:
        for measure in measures:
            collected.setdefault(measure.name, []).append(measure)
    summary = []
    for name, found in collected.items():
        values = np.array([m.value for m in found])
        values = values[np.isfinite(values)]
        summary.append(
            Measure(
                name=name,
                group=found[0].group,
                value=float(values.mean()) if len(values) else float("nan"),
                unit=found[0].unit,
                uncertainty=float(values.std(ddof=1)) if len(values) > 1 else float("nan"),
                count=len(values),
                note="" if len(values) else next((m.note for m in found if m.note), ""),
            )
        )
    return tuple(summary)
