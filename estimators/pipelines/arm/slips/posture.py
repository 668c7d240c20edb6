"""A posture found again: how far a segment is off where it was while its neighbours stood as they stand now."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from estimators import rotation
from estimators.pipelines.arm.slips.arm import Chain
from estimators.pipelines.arm.slips.chain import Link
from estimators.recording import Float

BEFORE_S: Final = 30.0
AFTER_S: Final = 20.0
GAP_S: Final = 0.6
"""Around the moment looked at; a slip is over by then."""
_POSTURE_S: Final = 0.2
_ALIKE_RAD: Final = math.radians(8.0)
"""Postures of the neighbours that count as the same: what people find again from one repetition to the next."""
_LEAST_RAD: Final = math.radians(9.0)
_LEAST_S: Final = 2.0
"""So long after the moment must the neighbours stand as they stood before it, and the segment be off."""
_NEAR_S: Final = 8.0
"""Also between postures of these seconds before and after: what came in two steps, a while apart, is no slip."""
_NEAR_PAIRS: Final = 5
_PAIRS: Final = 20
_OVER_SPREAD: Final = 3.0
_STAYS: Final = 0.5
_SHARE: Final = 10.0


@dataclass(frozen=True)
class Shift:
    """A segment that stays off.

    Attributes
    ----------
    turn_rad : ndarray, shape (3,)
        Rotation vector from before to after, in the segment's axes.
    spread_rad : float
        Median distance of single pairs of postures from it.
    """

    turn_rad: Float
    spread_rad: float

    @property
    def size_rad(self) -> float:
        """Its angle."""
        return float(np.linalg.norm(self.turn_rad))


class Postures:
    """One segment and its neighbours over a stretch, a few times a second."""

    def __init__(self, chain: Chain, link: Link) -> None:
        self._stride = max(1, chain.samples(_POSTURE_S))
        self._step_s = self._stride * chain.step_s
        self._others = [one[:: self._stride] for one in chain.neighbours(link)]
        self._own = chain.between(link.proximal, link.name)[:: self._stride]
        self._first_s = float(chain.motion.time_s[0])
        self._known = np.isfinite(np.concatenate([self._own, *self._others], axis=1)).all(axis=1)

    def shift(self, moment_s: float, from_s: float) -> Shift | None:
        """Return by how much the segment is off after a moment.

        Parameters
        ----------
        from_s : float
            What was before is not compared.

        Returns
        -------
        Shift or None
            None where it is not off, does not stay off, or the neighbours' postures are not found again.
        """
        if not self._others:
            return None
        before = self._between(max(from_s, moment_s - BEFORE_S), moment_s - GAP_S)
        after = self._between(moment_s + GAP_S, moment_s + AFTER_S)
        if min(len(before), len(after)) * self._step_s < _LEAST_S - GAP_S:
            return None
        alike = np.ones((len(after), len(before)))
        for one in self._others:
            np.minimum(alike, np.abs(one[after] @ one[before].T), out=alike)
        late, early = np.nonzero(alike > math.cos(0.5 * _ALIKE_RAD))
        if len(late) < _PAIRS:
            return None
        turns = rotation.log(
            rotation.positive(
                rotation.multiply(rotation.conjugate(self._own[before[early]]), self._own[after[late]])
            )
        )
        found = Shift(np.median(turns, axis=0), 0.0)
        if found.size_rad < _LEAST_RAD:
            return None
        found = Shift(found.turn_rad, float(np.median(np.linalg.norm(turns - found.turn_rad, axis=1))))
        along = turns @ found.turn_rad / found.size_rad
        single = np.array([np.median(along[late == one]) for one in np.unique(late)])
        near = (after[late] * self._step_s + self._first_s < moment_s + _NEAR_S) & (
            before[early] * self._step_s + self._first_s > moment_s - _NEAR_S
        )
        if np.count_nonzero(near) < _NEAR_PAIRS or np.median(along[near]) < _STAYS * found.size_rad:
            return None
        is_seen = len(single) * self._step_s >= _LEAST_S
        stays = float(np.percentile(single, _SHARE)) >= _STAYS * found.size_rad
        is_clear = found.size_rad >= _OVER_SPREAD * found.spread_rad
        return found if is_seen and stays and is_clear else None

    def _between(self, first_s: float, stop_s: float) -> "np.ndarray[tuple[int], np.dtype[np.intp]]":
        """Return the numbers of the known postures of a stretch of time."""
        first = max(0, math.ceil((first_s - self._first_s) / self._step_s))
        stop = max(first, math.ceil((stop_s - self._first_s) / self._step_s))
        return first + np.flatnonzero(self._known[first:stop])
