"""Measures of a repetition that need the template: timing and shape apart, the main ratio."""

import numpy as np
from numpy.typing import NDArray

from estimators.comparison._alignment import Alignment
from estimators.comparison._contract import Measure, Repetition, Template
from estimators.comparison._measures import SMALLEST_PATH, bound_sigma_s
from estimators.comparison.channels.names import channel_unit
from estimators.comparison.measures.paths import superimpose
from estimators.recording import Float
from estimators.sentences import say


def beside_template(
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
    bound_s = bound_sigma_s(template.primary_channel)
    ratio = duration / template.duration_s
    relative = np.hypot(
        np.sqrt(2) * bound_s / duration, _finite(template.duration_sd_s) / template.duration_s
    )
    add("duration_ratio", "timing", ratio, "1", ratio * relative)
    # A bound moved by one standard deviation shifts the phases by that share, on average half of it.
    add(
        "timing_deviation",
        "timing",
        100 * alignment.timing_deviation,
        "%",
        100 * 0.5 * bound_s / duration,
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
    found.extend(_path_measures(aligned, sigma, template))
    return found


def _path_measures(aligned: Float, sigma: Float, template: Template) -> list[Measure]:
    """Measure the hand's path laid on the template's: what is left, and the turn and scale that were taken away."""
    names = [f"wrist_{template.side}.{axis}" for axis in "xyz"]
    if any(name not in template.channels for name in names):
        return []
    columns = [template.channels.index(name) for name in names]
    known = np.isfinite(aligned[:, columns]).all(axis=1) & np.isfinite(template.mean[:, columns]).all(axis=1)
    own, reference = aligned[known][:, columns], template.mean[known][:, columns]
    least = SMALLEST_PATH * template.reach_m
    if len(own) < 3 or min(np.ptp(own, axis=0).max(), np.ptp(reference, axis=0).max()) < least:
        return []
    found = superimpose(own, reference)
    # A place that is wrong by sigma at one end turns and scales a path of that size by their ratio.
    sigma_m = float(sigma[columns[0]])
    relative = sigma_m / float(np.sqrt(np.mean(np.sum((own - own.mean(axis=0)) ** 2, axis=1))))
    note = say("measure.straight_path") if found.is_straight else ""
    return [
        Measure("path_residual", "path", found.residual, "m", sigma_m, 1),
        Measure("path_turn", "path", found.angle_rad, "rad", relative, 1, note),
        Measure("path_scale", "path", found.scale, "1", found.scale * relative, 1),
    ]


def _shape_measures(aligned: Float, sigma: Float, template: Template) -> list[Measure]:
    """Measure what differs after alignment; `sigma` is the sensors' own uncertainty per channel."""
    found: list[Measure] = []

    def add(name: str, value: float, unit: str, uncertainty: float) -> None:
        found.append(Measure(name, "shape", float(value), unit, float(uncertainty), 1))

    difference = aligned - template.mean
    width = np.where(difference < 0.0, template.below, template.above)
    relative = np.abs(difference / width)
    # Where the therapist lets a channel do what it likes there is nothing to be inside of.
    judged: NDArray[np.bool_] = np.isfinite(relative) & np.isfinite(width) & template.counts
    if judged.any():
        unsure = (sigma / width)[judged]
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
        unit = channel_unit(primary)
        phase = int(np.nanargmax(error))
        add(f"peak_deviation:{primary}", difference[phase, column], unit, sigma[column])
        # Any phase within one sigma of the largest difference might be the true one.
        rivals = np.flatnonzero(error >= error[phase] - sigma[column])
        spread = float(np.std(rivals)) if np.isfinite(sigma[column]) else np.nan
        add("peak_deviation_phase", phase, "%", spread)
        add(f"shape_rms:{primary}", float(np.sqrt(np.nanmean(error**2))), unit, sigma[column])
    return found


def _finite(value: float | None) -> float:
    return value if value is not None and np.isfinite(value) else 0.0
