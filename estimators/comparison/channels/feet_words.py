"""Words for strides beside a template, and for the way the foot went out of its band."""

from collections.abc import Sequence
from typing import Final

from estimators.comparison.channels.names import channel_name, channel_unit
from estimators.comparison.findings._outside import Outside
from estimators.sentences import CATALOGUE, Sentence, say

_DIRECTIONS: Final = {
    ("foot_pitch", True): "toes_lower",
    ("foot_pitch", False): "toes_higher",
    ("foot_height", True): "lower",
    ("foot_height", False): "higher",
    ("foot_speed", True): "slower",
    ("foot_speed", False): "faster",
}


def strides_left_band(found: Sequence[Outside]) -> list[str]:
    """Say of each channel and direction how the foot left its band, and in which of the therapist's phases."""
    sentences: list[str] = []
    for one in found:
        stated = say(
            "findings.stride_outside",
            what=_DIRECTIONS[channel_name(one.channel), one.is_below],
            outside=one.count,
            count=one.of,
            start=one.start / 100.0,
            end=one.end / 100.0,
        )
        where = [say("findings.in_phases", phases=list(one.phases))] if one.phases else []
        sentences.append(CATALOGUE.together([stated, *where]))
    return sentences


def other_pace(value_s: float, reference_s: float) -> Sentence:
    """Say that all strides took longer or shorter, s, than those of the template."""
    if value_s < reference_s:
        return say("findings.strides_faster", value_s=value_s, reference_s=reference_s)
    return say(
        "findings.strides_slower", ratio=value_s / reference_s, value_s=value_s, reference_s=reference_s
    )


def other_range(channel: str, value: float, reference: float) -> Sentence:
    """Say that the range of a channel was smaller or larger, in the unit of the channel, than in the template."""
    size, here, there = (
        _size(channel, abs(value - reference)),
        _size(channel, value),
        _size(channel, reference),
    )
    name = channel_name(channel)
    if value < reference:
        return say("findings.range_less", channel=name, difference=size, value=here, reference=there)
    return say("findings.range_more", channel=name, difference=size, value=here, reference=there)


def odd_strides(channel: str, which: Sequence[str], value: float, reference: float) -> Sentence:
    """Say which strides alone were smaller, or without a channel of another pace, with the worst of them."""
    if channel:
        return say(
            "findings.some_strides_less",
            strides=list(which),
            count=len(which),
            channel=channel_name(channel),
            value=_size(channel, value),
            reference=_size(channel, reference),
        )
    strides, count = list(which), len(which)
    if value > reference:
        return say(
            "findings.some_strides_slower", strides=strides, count=count, value_s=value, reference_s=reference
        )
    return say(
        "findings.some_strides_faster", strides=strides, count=count, value_s=value, reference_s=reference
    )


def _size(channel: str, value: float) -> Sentence:
    """Return an angle, a length or a speed with its unit."""
    unit = channel_unit(channel)
    if unit == "m/s":
        return say("size.speed", value_mps=value)
    return say("size.angle", value_rad=value) if unit == "rad" else say("size.length", value_m=value)
