"""Evidence for a posture as home: rest there, rest there at either end, and return to just there.

People rest at home more than elsewhere, and how far they go varies more from one repetition to the next than where they
come back to: the spread of where a movement ends grows with how far it went (Harris and Wolpert 1998, Nature 394:780).
A hold inside a repetition may last longer than any rest; its posture is as far spread as repetitions differ in size.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from estimators.comparison.repetitions.cycles import LEFT, Explanation
from estimators.comparison.repetitions.path import Path

_CLOSED: Final = 0.35
"""Share of the size: a rest further from where the repetition next to it began or ended is not at home."""
_LONG_REST_S: Final = 1.5
"""Nobody who exercises pauses inside a repetition for long: rest at either end speaks for home the more the longer."""
_REST_WORTH: Final = 0.5
_END_WORTH: Final = 0.8
_OUTERMOST_WORTH: Final = 0.3
_SPREAD_WORTH: Final = 0.6
_FINEST_SPREAD: Final = 0.01
"""Share of the size: what differs less is the same posture."""


@dataclass(frozen=True)
class Evidence:
    """What speaks for where an explanation is cut.

    Attributes
    ----------
    rest : float
        Worth of rest: the share of the time that is spent at home between repetitions, and rest at either end.
    outermost : float
        Worth of the stays before the first repetition and after the last, whatever came before or after them.
    spread : float
        How far postures at home usually are from each other, as a share of the size, without what drifts evenly.
    """

    rest: float
    outermost: float
    spread: float

    @property
    def worth(self) -> float:
        """All of it, in the units of `rest`."""
        return self.rest + self.outermost - _SPREAD_WORTH * float(np.log(max(self.spread, _FINEST_SPREAD)))


def evidence(one: Explanation, stays: NDArray[np.int64], path: Path, step_s: float) -> Evidence:
    """Return what speaks for where an explanation is cut.

    Parameters
    ----------
    stays : ndarray of int, shape (K, 2, 2)
        From `home.at_home`.
    step_s : float
        Between samples.
    """
    place = np.append(path.place, path.last)
    stayed = place[stays[:, :, 1] + 1] - place[stays[:, :, 0]]
    length = float(np.median(np.diff(path.place[one.matches], axis=1)))
    follows = stays[:-1, 1, 0] == stays[1:, 0, 0]
    rest = float(np.median(stayed[1:, 0][follows])) / (length + 1.0) if follows.any() else 0.0
    ends = sum(min(rested / _LONG_REST_S, 1.0) for rested in rested_at_the_ends(stays, path, step_s))
    is_stay = _are_stays(stays, path)
    outermost = [
        min(float(lasts) * step_s / _LONG_REST_S, 1.0) if is_there else 0.0
        for lasts, is_there in ((stayed[0, 0], is_stay[0, 0]), (stayed[-1, 1], is_stay[-1, 1]))
    ]
    return Evidence(
        rest=_REST_WORTH * min(rest, 1.0) + _END_WORTH * ends,
        outermost=_OUTERMOST_WORTH * sum(outermost),
        spread=_spread(stays, path),
    )


def rested_at_the_ends(stays: NDArray[np.int64], path: Path, step_s: float) -> list[float]:
    """Seconds that somebody rests at home at either end; none where they do something else before, or after.

    Parameters
    ----------
    stays : ndarray of int, shape (K, 2, 2)
        From `home.at_home`. A hold inside a repetition has a part of one on either side.
    """
    place = np.append(path.place, path.last)
    rested = []
    for rest, other, outside in (
        (stays[0, 0], stays[0, 1], slice(0, stays[0, 0, 1] + 1)),
        (stays[-1, 1], stays[-1, 0], slice(stays[-1, 1, 0], None)),
    ):
        here, there = (
            path.points[begin + np.argmax(path.stay[begin : end + 1])] for begin, end in (rest, other)
        )
        away = np.linalg.norm(path.points[outside] - here, axis=1).max()
        # Home is where the repetition next to it begins and ends; a hold near the end of it is not.
        is_home = away < LEFT * path.size and np.linalg.norm(here - there) < _CLOSED * path.size
        rested.append(float(place[rest[1] + 1] - place[rest[0]]) * step_s if is_home else 0.0)
    return rested


def _are_stays(stays: NDArray[np.int64], path: Path) -> NDArray[np.bool_]:
    """Whether each is a stay; the point of a cut twice is none, unless somebody stays at that point."""
    return np.asarray((stays[..., 0] < stays[..., 1]) | (path.stay[stays[..., 0]] >= path.slow))


def _spread(stays: NDArray[np.int64], path: Path) -> float:
    """How far postures at home usually are from a home that drifts evenly, as a share of the size."""
    bounds = stays.reshape(-1, 2)
    # The stay between two repetitions is the end of one and the beginning of the next.
    is_new = np.append(True, (bounds[1:] != bounds[:-1]).any(axis=1))
    bounds = bounds[is_new]
    place = np.append(path.place, path.last)
    first = place[bounds[:, 0]].astype(np.int64)
    last = np.where(_are_stays(bounds, path), np.ceil(place[bounds[:, 1] + 1]).astype(np.int64), first)
    postures = (path.summed[last + 1] - path.summed[first]) / (last + 1 - first)[:, None]
    middle = (first + last) / 2.0
    drift = np.stack([np.ones(len(middle)), (middle - middle.mean()) / (np.ptp(middle) + 1.0)], axis=1)
    even, *_ = np.linalg.lstsq(drift, postures, rcond=None)
    away = np.linalg.norm(postures - drift @ even, axis=1)
    # Two numbers a coordinate are spent on the drift; two repetitions have three bounds at least.
    return float(np.median(away) * np.sqrt(len(away) / (len(away) - 2.0))) / path.size
