"""What leaves the therapist's band in most repetitions, and by more than can be chance or sensor error."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from estimators.comparison._contract import PHASES, RepetitionResult, Template
from estimators.recording import Float

_CONFIDENCE = 0.975
_OF_EXCESS = 1.28 / 2.0
"""Nine in ten of what is stated to lie beyond the band do so; of a limit of two standard deviations."""
_LEAST_OF_PHASE = 0.25
_LEAST_RAD, _LEAST_M = float(np.radians(1.0)), 0.005
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
        shared by most, those of the mean curve.
    beyond : float
        How far the mean curve is beyond the band where it is farthest, rad or m; where that is certain at any phase, of
        those phases.
    is_certain : bool
        Whether it is beyond the band by more than its uncertainty, so that the distance may be stated.
    phases : tuple of str
        The therapist's names of the phases that hold a quarter or more of it.
    """

    channel: str
    count: int
    of: int
    start: int
    end: int
    beyond: float
    is_certain: bool
    phases: tuple[str, ...] = ()


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
        count = sum(bool(one.outside.get(channel)) for one in retained)
        if ("." in channel) is not positions or 2 * count <= len(retained):
            continue
        difference = np.stack([one.aligned[:, column] for one in retained]) - template.mean[:, column]
        known = np.isfinite(difference).all(axis=0)
        mean = np.where(known, difference.mean(axis=0), 0.0)
        width = np.where(mean < 0.0, template.below[:, column], template.above[:, column])
        known &= np.isfinite(width)
        if not known.any():
            continue
        limit = _limit(retained, channel, column, difference)
        known &= np.abs(mean) > limit
        beyond = np.where(known, np.abs(mean) - width, -np.inf)
        least = _LEAST_M if "." in channel or channel.endswith("_m") else _LEAST_RAD
        certain = known & (beyond > np.maximum(least, _OF_EXCESS * limit))
        phase = int(np.argmax(np.where(certain, beyond, -np.inf) if certain.any() else beyond))
        if beyond[phase] <= least:
            continue
        often = np.zeros(len(beyond))
        for one in retained:
            for start, end in one.outside.get(channel, []):
                often[start:end] += 1
        shared = np.flatnonzero(often > len(retained) / 2)
        phases = shared if len(shared) else np.flatnonzero(beyond > 0.0)
        found.append(
            Outside(
                channel,
                count,
                len(retained),
                int(phases[0]),
                int(phases[-1]),
                float(beyond[phase]),
                bool(certain.any()),
                _names(phases, template),
            )
        )
    return found


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
