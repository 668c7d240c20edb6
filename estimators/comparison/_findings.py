"""Plain sentences that a patient or a therapist understands, compensation first.

A sentence is written only where the difference from the template exceeds what chance and sensors explain. What
leaves the therapist's band in most repetitions is always reported; beside it at most three other differences. A fault
of some repetitions is lost in the mean of all: it is reported with their numbers.
"""

import functools
import statistics
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy

from estimators.comparison._contract import Measure, RepetitionResult, Template
from estimators.comparison._outside import Outside, outside_band
from estimators.comparison.channels.feet_words import (
    odd_strides,
    other_pace,
    other_range,
    strides_left_band,
)
from estimators.comparison.channels.names import (
    channel_name,
    channel_unit,
    is_of_stride,
    tells_movement,
)
from estimators.comparison.channels.sided import is_compensation
from estimators.sentences import CATALOGUE, Sentence, say

_MOST = 3
_CONFIDENCE = 0.975
_LEAST_RANGE_RAD = 0.087
_LEAST_RANGE = {"rad": _LEAST_RANGE_RAD, "m": 0.01, "m/s": 0.1}
_LEAST_HIKE_M = 0.025
_LEAST_SHARE = 0.15
_LEAST_SMOOTHNESS = 0.2
_OTHER_PACE = 1.45
"""Times as long or as short as in the template: so much of a single repetition is no chance."""
"""Inside the therapist's band, differences below 5 degrees, 25 mm of a shoulder, 1 cm or 0.1 m/s of a foot, 15 percent
or 0.2 of arc length are not worth a word."""


@dataclass(frozen=True)
class _Difference:
    """A measure beside its template value; `certainty` is the difference over its 95 percent limit."""

    value: float
    reference: float
    certainty: float

    @property
    def excess(self) -> float:
        return self.value - self.reference


def write_findings(
    results: Sequence[RepetitionResult], summary: tuple[Measure, ...], template: Template
) -> tuple[str, ...]:
    """Write the findings, the most important first.

    Parameters
    ----------
    results : sequence of RepetitionResult
    summary : tuple of Measure
        Mean, spread and count over the retained repetitions.
    template : Template

    Returns
    -------
    tuple of str
        At least one sentence.
    """
    retained = [result for result in results if result.repetition.is_kept]
    is_walk = is_of_stride(template.primary_channel)
    if not results:
        return (say("findings.no_strides") if is_walk else say("findings.none_found"),)
    if not retained:
        return (say("findings.no_stride_used") if is_walk else say("findings.none_used"),)
    by_name = {measure.name: measure for measure in summary}
    left_band = outside_band(retained, template)
    outside = {} if is_walk else {one.channel: one for one in left_band}
    in_some = _in_some(retained, by_name, template)
    first = _compensation(retained, by_name, template, outside)
    found: list[tuple[float, str]] = []
    for write in (_range, _duration, _smoothness, _path):
        sentence = write(retained, by_name, template)
        if sentence is not None:
            found.append(sentence)
    left = strides_left_band(left_band) if is_walk else _left_band(outside, template)
    if not first and not found and not left and not in_some:
        share = by_name.get("inside_band")
        if share is not None and share.value > 80:
            return (say("findings.matched"),)
        return (say("findings.no_difference"),)
    found.sort(key=lambda item: -item[0])
    most = max(0, _MOST - len(first))
    return (*first, *in_some, *(sentence for _, sentence in found[:most]), *left)


def _in_some(
    retained: Sequence[RepetitionResult], summary: dict[str, Measure], template: Template
) -> list[Sentence]:
    """Say which repetitions had a fault that all of them together do not show for certain."""
    primary = f"range:{template.primary_channel}"
    names = [f"compensation:{name}" for name in template.channels if is_compensation(name)]
    found: list[Sentence] = []
    for name in (*names, primary, "duration"):
        together = _difference(name, retained, summary, template)
        if name.partition(":")[2] in template.watched or (together is not None and together.certainty >= 1):
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


def _of_one(name: str, one: RepetitionResult, template: Template) -> _Difference | None:
    alone = one.by_name.get(name)
    return _difference(name, [one], {name: replace(alone, count=1)}, template) if alone else None


def _is_fault(name: str, difference: _Difference) -> bool:
    if name == "duration":
        return bool(abs(np.log(difference.value / difference.reference)) >= np.log(_OTHER_PACE))
    if name.startswith("range:"):
        least = _LEAST_RANGE[channel_unit(name.partition(":")[2])]
        return -difference.excess >= max(least, _LEAST_SHARE * difference.reference)
    return difference.excess >= _least(name.partition(":")[2])


def _odd_ones(name: str, odd: Sequence[tuple[int, _Difference]], template: Template) -> Sentence:
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


def _difference(
    name: str, retained: Sequence[RepetitionResult], summary: dict[str, Measure], template: Template
) -> _Difference | None:
    measure, reference = summary.get(name), template.measures.get(name)
    if measure is None or reference is None or not np.isfinite(measure.value) or not np.isfinite(reference):
        return None
    named = (one.by_name.get(name) for one in retained)
    own = [m.uncertainty for m in named if m is not None and np.isfinite(m.uncertainty)]
    # Sensor error is common to the repetitions of a session, so it does not average out; spread does.
    sensor = 2.0 * statistics.median(own) if own else 0.0
    count = measure.count
    chance = _student(count - 1) * measure.uncertainty / np.sqrt(count) if count > 1 else 0.0
    deviation = template.measure_sd.get(name, np.nan)
    others = template.repetition_count
    if others > 1 and np.isfinite(deviation):
        # With one repetition of the patient, the therapist's spread is all that is known about chance.
        shrink = 1 / others + (1 if count < 2 else 0)
        reference_chance = _student(others - 1) * deviation * np.sqrt(shrink)
    else:
        reference_chance = 0.0
    limit = float(np.sqrt(sensor**2 + chance**2 + reference_chance**2))
    return _Difference(measure.value, reference, abs(measure.value - reference) / max(limit, 1e-9))


@functools.lru_cache(maxsize=256)
def _student(freedom: int) -> float:
    """Return the quantile of Student's t that 95 percent of both sides are within."""
    return float(scipy.stats.t.ppf(_CONFIDENCE, freedom))


def _range(
    retained: Sequence[RepetitionResult], summary: dict[str, Measure], template: Template
) -> tuple[float, str] | None:
    candidates: list[tuple[float, str]] = []
    for name in (n for n in template.measures if n.startswith("range:")):
        channel = name.removeprefix("range:")
        if channel in template.watched:
            continue
        difference = _difference(name, retained, summary, template)
        is_primary, least = channel == template.primary_channel, _LEAST_RANGE[channel_unit(channel)]
        if difference is None or difference.certainty < 1 or abs(difference.excess) < least:
            continue
        if not is_primary and not tells_movement(channel):
            continue
        if not is_primary and difference.reference < 2 * least and difference.excess < 0:
            continue
        sentence = _range_changed(channel, difference)
        weight = abs(difference.excess) / max(difference.reference, least)
        candidates.append((weight * (3.0 if is_primary else 1.0), sentence))
    return max(candidates) if candidates else None


def _range_changed(channel: str, difference: _Difference) -> Sentence:
    if is_of_stride(channel):
        return other_range(channel, difference.value, difference.reference)
    if difference.excess < 0:
        return say(
            "findings.range_smaller",
            channel=channel_name(channel),
            difference_rad=-difference.excess,
            value_rad=difference.value,
            reference_rad=difference.reference,
        )
    return say(
        "findings.range_larger",
        channel=channel_name(channel),
        difference_rad=difference.excess,
        value_rad=difference.value,
        reference_rad=difference.reference,
    )


def _compensation(
    retained: Sequence[RepetitionResult],
    summary: dict[str, Measure],
    template: Template,
    outside: dict[str, Outside],
) -> list[str]:
    """Say how trunk and shoulder helped the arm, the largest first; what has its sentence here leaves `outside`."""
    found: list[tuple[float, str]] = []
    judged = [name for name in template.channels if name not in template.watched]
    for channel in filter(is_compensation, judged):
        difference = _difference(f"compensation:{channel}", retained, summary, template)
        left = outside.get(channel)
        if (
            difference is not None
            and difference.certainty >= 1
            and difference.excess > (0.0 if left is not None else _least(channel))
        ):
            stated: list[str] = [_helped(channel, difference.excess)]
            if left is not None:
                stated.append(say("findings.how_often", outside=left.count, count=left.of))
                stated.extend(_where(left))
            found.append((difference.excess / _least(channel), CATALOGUE.together(stated)))
            outside.pop(channel, None)
        elif left is not None and left.is_certain and channel_unit(channel) == "rad":
            text = say(
                "findings.outside",
                channel=channel_name(channel),
                outside=left.count,
                count=left.of,
                beyond_rad=left.beyond,
            )
            found.append((left.beyond / _least(channel), CATALOGUE.together([text, *_where(left)])))
            outside.pop(channel)
    return [sentence for _, sentence in sorted(found, key=lambda item: -item[0])]


def _least(channel: str) -> float:
    return _LEAST_RANGE_RAD if channel_unit(channel) == "rad" else _LEAST_HIKE_M


def _helped(channel: str, more: float) -> Sentence:
    return (
        say("findings.shoulder_rose", more_m=more)
        if channel_unit(channel) == "m"
        else _trunk_moved(channel, more)
    )


def _trunk_moved(channel: str, more_rad: float) -> Sentence:
    if channel == "trunk_lean_forward_rad":
        return say("findings.trunk_leaned_forward", more_rad=more_rad)
    if channel == "trunk_lean_lateral_rad":
        return say("findings.trunk_leaned_sideways", more_rad=more_rad)
    return say("findings.trunk_turned", more_rad=more_rad)


def _beyond(one: Outside) -> Sentence:
    name = channel_name(one.channel)
    if channel_unit(one.channel) == "m":
        return say("findings.beyond_length", channel=name, beyond_m=one.beyond)
    return say("findings.beyond_angle", channel=name, beyond_rad=one.beyond)


def _where(one: Outside) -> list[str]:
    """Say in which of the therapist's phases; nothing where none was named."""
    return [say("findings.in_phases", phases=list(one.phases))] if one.phases else []


def _left_band(outside: dict[str, Outside], template: Template) -> list[str]:
    """Say which angles left the band: the main one with its phases, the others together."""
    sentences: list[str] = []
    main = outside.get(template.primary_channel)
    if main is not None:
        stated = say(
            "findings.outside_mostly",
            channel=channel_name(main.channel),
            outside=main.count,
            count=main.of,
            start=main.start / 100.0,
            end=main.end / 100.0,
        )
        sentences.append(CATALOGUE.together([stated, *_where(main)]))
    # These state by how much: no distance that is smaller than its own uncertainty.
    certain = (one for one in outside.values() if one is not main and one.is_certain)
    others = sorted(certain, key=lambda one: -one.beyond)
    if others:
        angles = [_beyond(one) for one in others]
        sentences.append(
            say("findings.others_outside", angles=angles)
            if main is None
            else say("findings.also_outside", angles=angles)
        )
    return sentences


def _duration(
    retained: Sequence[RepetitionResult], summary: dict[str, Measure], template: Template
) -> tuple[float, str] | None:
    difference = _difference("duration", retained, summary, template)
    if difference is None or difference.certainty < 1:
        return None
    ratio = difference.value / difference.reference
    if abs(np.log(ratio)) < np.log(1 + _LEAST_SHARE):
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
    difference = _difference("spectral_arc_length", retained, summary, template)
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
    difference = _difference("hand_path_ratio", retained, summary, template)
    if (
        difference is None
        or difference.certainty < 1
        or difference.excess < _LEAST_SHARE * difference.reference
    ):
        return None
    more = difference.excess / difference.reference
    return difference.excess, say("findings.longer_way", more=more)
