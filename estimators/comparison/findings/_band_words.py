"""Sentences on what leaves the therapist's band: compensation, the main channel, the others. Each channel once."""

from collections.abc import Iterable, Sequence

import numpy as np

from estimators.comparison._contract import Measure, RepetitionResult, Template
from estimators.comparison.channels.feet_words import other_range
from estimators.comparison.channels.names import channel_name, channel_unit, is_of_stride
from estimators.comparison.channels.sided import is_compensation
from estimators.comparison.findings._differences import Difference, difference_of, least_of, other_range_of
from estimators.comparison.findings._outside import Outside
from estimators.sentences import CATALOGUE, Sentence, say


def compensation(
    retained: Sequence[RepetitionResult],
    summary: dict[str, Measure],
    template: Template,
    outside: dict[str, Outside],
) -> list[str]:
    """Say how trunk and shoulder helped the arm, the largest first; what has its sentence here leaves `outside`."""
    found: list[tuple[float, str]] = []
    judged = [name for name in template.channels if name not in template.watched]
    for channel in filter(is_compensation, judged):
        difference = difference_of(f"compensation:{channel}", retained, summary, template)
        left = outside.pop(channel, None)
        if (
            difference is not None
            and difference.certainty >= 1
            and difference.excess > (0.0 if left is not None else least_of(channel))
        ):
            stated: list[str] = [_helped(channel, difference)]
            if left is not None:
                stated.append(say("findings.how_often", outside=left.count, count=left.of))
                stated.extend(_where(left))
            found.append((difference.excess / least_of(channel), CATALOGUE.together(stated)))
        elif left is not None:
            text = _went_out(left)
            found.append((left.beyond / least_of(channel), CATALOGUE.together([text, *_where(left)])))
    return [sentence for _, sentence in sorted(found, key=lambda item: -item[0])]


def _helped(channel: str, difference: Difference) -> Sentence:
    if channel_unit(channel) == "m":
        return say("findings.shoulder_rose", more_m=difference.excess)
    more, own, reference = difference.excess, difference.value, difference.reference
    if channel == "trunk_lean_forward_rad":
        return say("findings.trunk_leaned_forward", more_rad=more, value_rad=own, reference_rad=reference)
    if channel == "trunk_lean_lateral_rad":
        return say("findings.trunk_leaned_sideways", more_rad=more, value_rad=own, reference_rad=reference)
    return say("findings.trunk_turned", more_rad=more, value_rad=own, reference_rad=reference)


def _went_out(one: Outside) -> Sentence:
    name, beyond = channel_name(one.channel), _up_to(one)
    if channel_unit(one.channel) == "m":
        return say("findings.outside_length", channel=name, outside=one.count, count=one.of, beyond_m=beyond)
    return say("findings.outside", channel=name, outside=one.count, count=one.of, beyond_rad=beyond)


def _beyond(one: Outside) -> Sentence:
    name = channel_name(one.channel)
    if channel_unit(one.channel) == "m":
        return say("findings.beyond_length", channel=name, beyond_m=_up_to(one))
    return say("findings.beyond_angle", channel=name, beyond_rad=_up_to(one))


def _up_to(one: Outside) -> float:
    """Return the distance as it is said, in whole degrees or centimetres: "up to 0" would say nothing."""
    return max(one.beyond, 0.01 if channel_unit(one.channel) == "m" else float(np.radians(1.0)))


def _where(one: Outside) -> list[str]:
    """Say in which of the therapist's phases; nothing where none was named."""
    return [say("findings.in_phases", phases=list(one.phases))] if one.phases else []


def main_left_band(
    retained: Sequence[RepetitionResult],
    summary: dict[str, Measure],
    template: Template,
    outside: dict[str, Outside],
) -> list[str]:
    """Say how the main channel left its band, its range in the same sentence; it leaves `outside`."""
    main = outside.pop(template.primary_channel, None)
    if main is None:
        return []
    difference = other_range_of(main.channel, retained, summary, template)
    count, of, start, end = main.count, main.of, main.start / 100.0, main.end / 100.0
    if difference is None:
        name = channel_name(main.channel)
        stated = [say("findings.outside_mostly", channel=name, outside=count, count=of, start=start, end=end)]
    else:
        stated = [
            range_changed(main.channel, difference),
            say("findings.this_outside_mostly", outside=count, count=of, start=start, end=end),
        ]
    return [CATALOGUE.together([*stated, *_where(main)])]


def others_left_band(outside: Iterable[Outside], *, is_also: bool) -> list[str]:
    """Name what else left its band: angles together, then places.

    Places follow from the angles: where an angle is outside they stand in a sentence of their own, which says so.
    """
    found = sorted(outside, key=lambda one: -one.beyond)
    angles, places = (
        [_beyond(one) for one in found if ("." in one.channel) is is_place] for is_place in (False, True)
    )
    sentences: list[str] = []
    named = angles or ([] if is_also else places)
    if named:
        sentences.append(
            say("findings.others_outside", angles=named)
            if not is_also
            else say("findings.also_outside", angles=named)
        )
    if places and (angles or is_also):
        sentences.append(say("findings.places_followed", angles=places))
    return sentences


def range_changed(channel: str, difference: Difference) -> Sentence:
    """Say that a range is smaller or larger than in the template."""
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
