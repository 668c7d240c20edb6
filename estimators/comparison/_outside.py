"""What leaves the therapist's band in most repetitions, and by more than can be chance or sensor error."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import scipy
from numpy.typing import NDArray

from estimators.comparison._contract import PHASES, RepetitionResult, Template
from estimators.comparison._template import FLOOR_OF_STRIDE
from estimators.comparison.channels.names import channel_unit, is_of_stride
from estimators.recording import Float

_CONFIDENCE = 0.975
_OF_EXCESS = 1.28 / 2.0
"""Nine in ten of what is stated to lie beyond the band do so; of a limit of two standard deviations."""
_LEAST_OF_PHASE = 0.25
_LEAST_SHARE_OF_STRIDE: Final = 0.1
"""Of the floor of a foot's band, which is narrower than that of an arm: 1 mm, 0.3 degrees, 7 mm/s."""
_LEAST: Final = {"rad": float(np.radians(1.0)), "m": 0.005}
"""So little beyond the band is within the thickness of its line."""


@dataclass(frozen=True)
class Outside:
    """An angle that most repetitions carry out of its band.

    Attributes
    ----------
    channel : str
    count, of : int
        Repetitions outside, and all that count.
    start, end : int
        First and last phase of the template, percent, at which most repetitions are outside; where no phase is
        shared by most, those of the mean curve. Of a stride those of the longest stretch.
    beyond : float
        How far the mean curve is beyond the band where it is farthest, rad, m or m/s; where that is certain at any
        phase, of those phases.
    is_certain : bool
        Whether it is beyond the band by more than its uncertainty, so that the distance may be stated.
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
    is_certain: bool
    phases: tuple[str, ...] = ()
    is_below: bool = False


def outside_band(retained: Sequence[RepetitionResult], template: Template) -> list[Outside]:
    """Find what is outside its band in more than half of the repetitions.

    Parameters
    ----------
    retained : sequence of RepetitionResult
        Those that count.
    template : Template

    Returns
    -------
    list of Outside
        In the order of the template. Positions follow from the angles: only where no angle is outside are they named.
        A channel of strides stands there for each direction in which it leaves the band.

    Notes
    -----
    Only those phases count at which the distance of the mean curve to the template's mean exceeds the 95 percent limit
    that the sensors (two standard deviations of the value there, common to all repetitions) and the spread between the
    repetitions (Student) leave it. The distance to the edge of the band is certain where it exceeds z = 1.28 of that
    uncertainty, as that of a cue does: (10) of the guidance.
    """
    angles = _leave(retained, template, positions=False)
    return angles or _leave(retained, template, positions=True)


def _leave(retained: Sequence[RepetitionResult], template: Template, *, positions: bool) -> list[Outside]:
    found = []
    for column, channel in enumerate(template.channels):
        if ("." in channel) is not positions:
            continue
        # A foot too low in swing and one too high in stance are two things; of an arm the farthest is named.
        for direction in (-1, 1) if is_of_stride(channel) else (0,):
            one = _left(retained, template, column, direction)
            if one is not None:
                found.append(one)
    return found


def _left(
    retained: Sequence[RepetitionResult], template: Template, column: int, direction: int
) -> Outside | None:
    """Return how a channel leaves its band: below it (-1), above it (1) or either way (0)."""
    channel = template.channels[column]
    difference = np.stack([one.aligned[:, column] for one in retained]) - template.mean[:, column]
    runs = [
        [
            (start, end)
            for start, end in one.outside.get(channel, [])
            if direction == 0 or direction * float(np.nanmean(own[start:end])) > 0.0
        ]
        for one, own in zip(retained, difference, strict=True)
    ]
    count = sum(bool(own) for own in runs)
    if 2 * count <= len(retained):
        return None
    known = np.isfinite(difference).all(axis=0)
    mean = np.where(known, difference.mean(axis=0), 0.0)
    width = np.where(mean < 0.0, template.below[:, column], template.above[:, column])
    known &= np.isfinite(width) & (direction * mean >= 0.0)
    if not known.any():
        return None
    limit = _limit(retained, channel, column, difference)
    known &= np.abs(mean) > limit
    beyond = np.where(known, np.abs(mean) - width, -np.inf)
    least = _least(channel)
    certain = known & (beyond > np.maximum(least, _OF_EXCESS * limit))
    phase = int(np.argmax(np.where(certain, beyond, -np.inf) if certain.any() else beyond))
    if beyond[phase] <= least:
        return None
    often = np.zeros(len(beyond))
    for own in runs:
        for start, end in own:
            often[start:end] += 1
    shared = np.flatnonzero(often > len(retained) / 2)
    phases = shared if len(shared) else np.flatnonzero(beyond > 0.0)
    # A stride begins where the one before ends, so what is outside about there has two parts: the longer is named.
    stretch = _longest(phases) if direction else phases
    return Outside(
        channel,
        count,
        len(retained),
        int(stretch[0]),
        int(stretch[-1]),
        float(beyond[phase]),
        bool(certain.any()),
        _names(phases, template),
        direction < 0,
    )


def _longest(places: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return the longest run of consecutive places."""
    return max(np.split(places, np.flatnonzero(np.diff(places) > 1) + 1), key=len)


def _least(channel: str) -> float:
    if is_of_stride(channel):
        return _LEAST_SHARE_OF_STRIDE * FLOOR_OF_STRIDE[channel_unit(channel)]
    return _LEAST[channel_unit(channel)]


def _names(places: NDArray[np.intp], template: Template) -> tuple[str, ...]:
    """Name the phases that hold a quarter or more of these places, in order."""
    share = places / (PHASES - 1)
    return tuple(
        one.name
        for one in template.phases
        if np.mean((share >= one.start) & (share <= one.end)) >= _LEAST_OF_PHASE
    )


def _limit(retained: Sequence[RepetitionResult], channel: str, column: int, difference: Float) -> Float:
    """Return the 95 percent limit of the mean curve at each phase, shape (101,), of differences of shape (R, 101)."""
    # The residual of the path is known as well as any place of the hand.
    names = {"path_residual"} if "." in channel else {f"range:{channel}", f"compensation:{channel}"}
    own = [m.uncertainty for one in retained for m in one.measures if m.name in names]
    known = [value for value in own if np.isfinite(value)]
    there = np.max([np.nan_to_num(one.sigma[:, column]) for one in retained], axis=0)
    sensor = 2.0 * np.maximum(float(np.median(known)) if known else 0.0, there)
    count = len(difference)
    if count < 2:
        return np.asarray(sensor)
    quantile = float(scipy.stats.t.ppf(_CONFIDENCE, count - 1))
    return np.asarray(np.hypot(sensor, quantile * difference.std(axis=0, ddof=1) / np.sqrt(count)))


__all__ = ["Outside", "outside_band"]
