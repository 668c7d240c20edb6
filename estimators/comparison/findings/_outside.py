"""Channels that leave the therapist's band in most repetitions: counted from what is drawn red, by no other rule."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from estimators.comparison._contract import PHASES, RepetitionResult, Template
from estimators.comparison.channels.names import is_of_stride
from estimators.recording import Float

_LEAST_OF_PHASE: Final = 0.25

Stretch = tuple[int, int]
"""Half-open, phases of the template."""


@dataclass(frozen=True)
class Outside:
    """A channel that is drawn red in most repetitions.

    Attributes
    ----------
    count, of : int
        Repetitions in which it is red, and all that count.
    start, end : int
        First and last phase of the template, percent, at which most repetitions are outside; where no phase is
        shared by most, those at which any is. Of a stride those of the longest stretch.
    beyond : float
        How far beyond the band it goes, rad, m or m/s: of each repetition that is outside where it is farthest, the
        median of these.
    phases : tuple of str
        The therapist's names of the phases that hold a quarter or more of it.
    is_below : bool
        Of a stride, whose two directions stand apart: below the band, not above it.
    """

    channel: str
    count: int
    of: int
    start: int
    end: int
    beyond: float
    phases: tuple[str, ...] = ()
    is_below: bool = False


def outside_band(retained: Sequence[RepetitionResult], template: Template) -> list[Outside]:
    """Find what is outside its band in more than half of the repetitions.

    Parameters
    ----------
    retained : sequence of RepetitionResult
        Those that count.

    Returns
    -------
    list of Outside
        In the order of the template, every channel of which more than half of the repetitions have a stretch in
        `outside`. A channel of strides stands there for each direction in which it leaves the band so often; where
        neither does alone, for the one in which it does more often.
    """
    found = []
    for column, channel in enumerate(template.channels):
        red = [one.outside.get(channel, []) for one in retained]
        if 2 * sum(bool(own) for own in red) <= len(retained):
            continue
        excess = np.stack([one.aligned[:, column] for one in retained]) - template.mean[:, column]
        if not is_of_stride(channel):
            found.append(_left(template, column, red, excess, is_below=False))
            continue
        # A foot too low in swing and one too high in stance are two things; of an arm the farthest is named.
        sides = [
            _left(template, column, _of_sign(red, excess, sign), excess, is_below=sign < 0)
            for sign in (-1, 1)
            if any(_of_sign(red, excess, sign))
        ]
        often = [one for one in sides if 2 * one.count > one.of]
        found.extend(often or [max(sides, key=lambda one: one.count)])
    return found


def _of_sign(red: Sequence[Sequence[Stretch]], excess: Float, sign: int) -> list[list[Stretch]]:
    """Return the stretches of each repetition in which it is on that side of the template."""
    return [
        [(start, end) for start, end in own if sign * float(np.nanmean(one[start:end])) > 0.0]
        for own, one in zip(red, excess, strict=True)
    ]


def _left(
    template: Template, column: int, red: Sequence[Sequence[Stretch]], excess: Float, *, is_below: bool
) -> Outside:
    """Describe how a channel leaves its band in these stretches; `excess` is its way off the mean, shape (R, 101)."""
    channel = template.channels[column]
    width = np.where(excess < 0.0, template.below[:, column], template.above[:, column])
    beyond = np.abs(excess) - width
    often = np.zeros(PHASES)
    farthest = []
    for own, one in zip(red, beyond, strict=True):
        for start, end in own:
            often[start:end] += 1
        farthest.extend([max(float(np.nanmax(one[start:end])) for start, end in own)] if own else [])
    shared = np.flatnonzero(often > len(red) / 2)
    phases = shared if len(shared) else np.flatnonzero(often)
    # A stride begins where the one before ends, so what is outside about there has two parts: the longer is named.
    stretch = _longest(phases) if is_of_stride(channel) else phases
    return Outside(
        channel=channel,
        count=len(farthest),
        of=len(red),
        start=int(stretch[0]),
        end=int(stretch[-1]),
        beyond=float(np.median(farthest)),
        phases=_names(phases, template),
        is_below=is_below,
    )


def _longest(places: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return the longest run of consecutive places."""
    return max(np.split(places, np.flatnonzero(np.diff(places) > 1) + 1), key=len)


def _names(places: NDArray[np.intp], template: Template) -> tuple[str, ...]:
    """Name the phases that hold a quarter or more of these places, in order."""
    share = places / (PHASES - 1)
    return tuple(
        one.name
        for one in template.phases
        if np.mean((share >= one.start) & (share <= one.end)) >= _LEAST_OF_PHASE
    )
