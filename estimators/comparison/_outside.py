"""What leaves the therapist's band in most repetitions, and by more than can be chance or sensor error."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from estimators.comparison._contract import PHASES, RepetitionResult, Template

_CONFIDENCE = 0.975
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
        How far the mean curve is beyond the band where it is farthest, rad or m.
    phases : tuple of str
        The therapist's names of the phases that hold a quarter or more of it.
    """

    channel: str
    count: int
    of: int
    start: int
    end: int
    beyond: float
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
    Where the mean curve of the repetitions is farthest beyond the band, its distance to the template's mean must
    exceed the 95 percent limit that the sensors (two standard deviations, common to all repetitions) and the
    spread between the repetitions (Student) leave it.
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
        beyond = np.where(known, np.abs(mean) - width, -np.inf)
        phase = int(np.argmax(beyond))
        limit = _limit(retained, channel, difference[:, phase])
        least = _LEAST_M if "." in channel or channel.endswith("_m") else _LEAST_RAD
        if beyond[phase] <= least or abs(mean[phase]) <= limit:
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


def _limit(retained: Sequence[RepetitionResult], channel: str, differences: np.ndarray) -> float:
    # The residual of the path is known as well as any place of the hand.
    names = {"path_residual"} if "." in channel else {f"range:{channel}", f"compensation:{channel}"}
    own = [m.uncertainty for one in retained for m in one.measures if m.name in names]
    known = [value for value in own if np.isfinite(value)]
    sensor = 2.0 * float(np.median(known)) if known else 0.0
    count = len(differences)
    chance = 0.0
    if count > 1:
        spread = float(differences.std(ddof=1)) / np.sqrt(count)
        chance = float(scipy.stats.t.ppf(_CONFIDENCE, count - 1)) * spread
    return float(np.hypot(sensor, chance))


__all__ = ["Outside", "outside_band"]
