"""Plain sentences that a patient or a therapist understands, compensation first.

What is drawn red in most repetitions has its sentence, one for each fault: that follows from the drawing and from
nothing else. Beside it at most three other differences are reported, where they exceed what chance and sensors explain.
A fault of some repetitions is lost in the mean of all: it is reported with their numbers.
"""

import statistics
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from estimators.comparison._contract import Measure, RepetitionResult, Template
from estimators.comparison.channels.feet_words import odd_strides, other_pace, strides_left_band
from estimators.comparison.channels.names import channel_name, channel_unit, is_of_stride
from estimators.comparison.channels.sided import is_compensation
from estimators.comparison.findings._band_words import (
    compensation,
    main_left_band,
    others_left_band,
    range_changed,
)
from estimators.comparison.findings._differences import (
    LEAST_RANGE,
    LEAST_SHARE,
    Difference,
    difference_of,
    least_of,
    other_range_of,
)
from estimators.comparison.findings._outside import outside_band
from estimators.sentences import Sentence, say

_MOST = 3
_LEAST_SMOOTHNESS = 0.2
"""Smaller differences of arc length are not worth a word."""
_LEAST_MEASURED = 0.5
"""Share of its way over which the main channel must be known for anything to be said of it."""
_OTHER_PACE = 1.45
"""Times as long or as short as in the template: so much of a single repetition is no chance."""


def write_findings(
    results: Sequence[RepetitionResult], summary: tuple[Measure, ...], template: Template
) -> tuple[str, ...]:
    """Write the findings, the most important first.

    Parameters
    ----------
    summary : tuple of Measure
        Mean, spread and count over the retained repetitions.

    Returns
    -------
    tuple of str
        At least one sentence. What could not be measured of the main channel comes first, then compensation. Every
        channel that is outside its band in most repetitions stands in exactly one of them.
    """
    retained = [result for result in results if result.repetition.is_kept]
    is_walk = is_of_stride(template.primary_channel)
    if not results:
        return (say("findings.no_strides") if is_walk else say("findings.none_found"),)
    if not retained:
        return (say("findings.no_stride_used") if is_walk else say("findings.none_used"),)
    by_name = {measure.name: measure for measure in summary}
    left_band = outside_band(retained, template)
    unmeasured = _main_not_measured(retained, template)
    main: list[str] = []
    if is_walk:
        # The ways in which a stride leaves its band stand last, each by itself.
        first, left = unmeasured, strides_left_band(left_band)
    else:
        outside = {one.channel: one for one in left_band}
        first = [*unmeasured, *compensation(retained, by_name, template, outside)]
        main = main_left_band(retained, by_name, template, outside)
        left = others_left_band(outside.values(), is_also=bool(main))
    reported = {one.channel for one in left_band}
    helps = [f"compensation:{name}" for name in template.channels if is_compensation(name)]
    helped_in_some = _in_some(helps, retained, by_name, template, reported)
    in_some = _in_some(
        [f"range:{template.primary_channel}", "duration"], retained, by_name, template, reported
    )
    found = [
        sentence
        for sentence in (
            _range(retained, by_name, template, reported),
            *(write(retained, by_name, template) for write in (_duration, _smoothness, _path)),
        )
        if sentence is not None
    ]
    if not any((first, helped_in_some, main, in_some, found, left)):
        share = by_name.get("inside_band")
        if share is not None and share.value > 80:
            return (say("findings.matched"),)
        return (say("findings.no_difference"),)
    found.sort(key=lambda item: -item[0])
    most = max(0, _MOST - len(first) - len(main))
    return (*first, *helped_in_some, *main, *in_some, *(sentence for _, sentence in found[:most]), *left)


def _main_not_measured(retained: Sequence[RepetitionResult], template: Template) -> list[str]:
    """Say that the exercise's main channel was not measured, or too badly to be held against its band.

    Without it nothing may be called matched: what the exercise is about was not seen.
    """
    column, name = template.channels.index(template.primary_channel), channel_name(template.primary_channel)
    known = [np.isfinite(one.aligned[:, column]) for one in retained]
    measured = statistics.median(float(one.mean()) for one in known)
    if measured < _LEAST_MEASURED:
        if not any(one.any() for one in known):
            return [say("findings.main_not_measured", channel=name)]
        return [say("findings.main_mostly_not_measured", channel=name, share=measured)]
    sigma = np.stack([one.sigma[:, column] for one in retained])
    if not np.isfinite(sigma).any():
        return []
    unsure, width = 2.0 * float(np.nanmedian(sigma)), np.fmax(template.below, template.above)[:, column]
    # Where it may be off by its band and by half of its way, nothing that it shows differs for sure from the template.
    way = 0.5 * float(np.nanmax(template.mean[:, column]) - np.nanmin(template.mean[:, column]))
    if channel_unit(template.primary_channel) == "rad" and unsure > max(float(np.nanmax(width)), way):
        return [say("findings.main_uncertain", channel=name, unsure_rad=unsure)]
    return []


def _in_some(
    names: Sequence[str],
    retained: Sequence[RepetitionResult],
    summary: dict[str, Measure],
    template: Template,
    reported: set[str],
) -> list[Sentence]:
    """Say which repetitions had one of these faults, where all of them together do not show it for certain.

    `reported` are the channels that have their sentence already, because most repetitions are outside their band.
    """
    found: list[Sentence] = []
    for name in names:
        together = difference_of(name, retained, summary, template)
        if name.partition(":")[2] in {*template.watched, *reported}:
            continue
        if together is not None and together.certainty >= 1:
            continue
        odd = [
            (one.repetition.number, difference)
            for one in retained
            if (difference := _of_one(name, one, template)) is not None
            and _is_fault(name, difference)
            and difference.certainty >= 1
        ]
        # Slower and faster ones are two faults.
        parts = ([one for one in odd if (one[1].excess > 0) == is_more] for is_more in (True, False))
        found.extend(_odd_ones(name, part, template) for part in parts if part)
    return found


def _of_one(name: str, one: RepetitionResult, template: Template) -> Difference | None:
    alone = one.by_name.get(name)
    return difference_of(name, [one], {name: replace(alone, count=1)}, template) if alone else None


def _is_fault(name: str, difference: Difference) -> bool:
    if name == "duration":
        return bool(abs(np.log(difference.value / difference.reference)) >= np.log(_OTHER_PACE))
    if name.startswith("range:"):
        least = LEAST_RANGE[channel_unit(name.partition(":")[2])]
        return -difference.excess >= max(least, LEAST_SHARE * difference.reference)
    return difference.excess >= least_of(name.partition(":")[2])


def _odd_ones(name: str, odd: Sequence[tuple[int, Difference]], template: Template) -> Sentence:
    """Name the repetitions of a fault, with the largest of it."""
    which, count = [str(number) for number, _ in odd], len(odd)
    worst = max((one for _, one in odd), key=lambda one: abs(one.excess))
    channel = name.partition(":")[2]
    if is_of_stride(template.primary_channel):
        return odd_strides(channel, which, worst.value, worst.reference)
    if name == "duration":
        value_s, reference_s = worst.value, worst.reference
        if worst.excess > 0:
            return say(
                "findings.some_slower",
                repetitions=which,
                count=count,
                value_s=value_s,
                reference_s=reference_s,
            )
        return say(
            "findings.some_faster", repetitions=which, count=count, value_s=value_s, reference_s=reference_s
        )
    if name.startswith("range:"):
        return say(
            "findings.some_smaller",
            repetitions=which,
            count=count,
            channel=channel_name(channel),
            value_rad=worst.value,
            reference_rad=worst.reference,
        )
    if channel_unit(channel) == "m":
        return say("findings.some_shoulder_rose", repetitions=which, count=count, more_m=worst.excess)
    return say(
        "findings.some_trunk",
        repetitions=which,
        count=count,
        channel=channel_name(channel),
        more_rad=worst.excess,
    )


def _range(
    retained: Sequence[RepetitionResult], summary: dict[str, Measure], template: Template, reported: set[str]
) -> tuple[float, str] | None:
    """Name the range that differs most, of the channels that have no sentence yet."""
    candidates: list[tuple[float, str]] = []
    for name in (n for n in template.measures if n.startswith("range:")):
        channel = name.removeprefix("range:")
        if channel in template.watched or channel in reported:
            continue
        difference = other_range_of(channel, retained, summary, template)
        if difference is not None:
            weight = abs(difference.excess) / max(difference.reference, LEAST_RANGE[channel_unit(channel)])
            is_primary = channel == template.primary_channel
            candidates.append((weight * (3.0 if is_primary else 1.0), range_changed(channel, difference)))
    return max(candidates) if candidates else None


def _duration(
    retained: Sequence[RepetitionResult], summary: dict[str, Measure], template: Template
) -> tuple[float, str] | None:
    difference = difference_of("duration", retained, summary, template)
    if difference is None or difference.certainty < 1:
        return None
    ratio = difference.value / difference.reference
    if abs(np.log(ratio)) < np.log(1 + LEAST_SHARE):
        return None
    own_s, reference_s = difference.value, difference.reference
    if is_of_stride(template.primary_channel):
        text = other_pace(own_s, reference_s)
    elif ratio > 1:
        text = say("findings.slower", ratio=ratio, value_s=own_s, reference_s=reference_s)
    else:
        text = say("findings.faster", value_s=own_s, reference_s=reference_s)
    return float(abs(np.log2(ratio))), text


def _smoothness(
    retained: Sequence[RepetitionResult], summary: dict[str, Measure], template: Template
) -> tuple[float, str] | None:
    difference = difference_of("spectral_arc_length", retained, summary, template)
    if difference is None or difference.certainty < 1 or abs(difference.excess) < _LEAST_SMOOTHNESS:
        return None
    if difference.excess < 0:
        text = say("findings.less_smooth", value=difference.value, reference=difference.reference)
    else:
        text = say("findings.smoother", value=difference.value, reference=difference.reference)
    return abs(difference.excess) / 2, text


def _path(
    retained: Sequence[RepetitionResult], summary: dict[str, Measure], template: Template
) -> tuple[float, str] | None:
    difference = difference_of("hand_path_ratio", retained, summary, template)
    if (
        difference is None
        or difference.certainty < 1
        or difference.excess < LEAST_SHARE * difference.reference
    ):
        return None
    more = difference.excess / difference.reference
    return difference.excess, say("findings.longer_way", more=more)
