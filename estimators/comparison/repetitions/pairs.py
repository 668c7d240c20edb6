"""Two bends that take turns are one repetition, however alike their ways are.

The path of a movement knows no pace. Where somebody bends the knee to jump off and again on landing, both bends may go
as far: what comes again is one bend. But who jumps bends slowly and stretches quickly, and lands the other way about:
how the time is shared over the way tells one from the other, and they take turns.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from estimators.comparison.repetitions.cycles import Explanation
from estimators.comparison.repetitions.path import Path
from estimators.recording import Float

_PARTS: Final = 4
_HELD: Final = 5.0
"""Times the usual of a repetition: no step counts longer, or a hold would be all that its part shows."""
_FEWEST: Final = 6
"""Three pairs: of fewer, two kinds take turns by chance."""
_APART: Final = 4.0
"""Times as far as a repetition usually is from its own kind: so far are two kinds apart."""
_TOLD: Final = 0.8
"""And at least so far, in logarithms of time: parts that take one and a half times as long, and two thirds."""
_TURNS: Final = 0.85
"""Share of the neighbours that are of different kinds: a partial try between may break the order."""
_LONGER: Final = (1.5, 3.2)
"""Times as long as one bend: two, with the rest of the way that either may lack."""
_AS_MANY: Final = (0.35, 0.65)
_AS_GOOD: Final = 0.5
"""Share of the gain of one bend that the pair must have."""


def in_pairs(found: list[Explanation], path: Path) -> Explanation:
    """Return the best explanation, or the pair of which it is one half.

    Parameters
    ----------
    found : list of Explanation
        The best first.
    """
    best = found[0]
    if not _take_turns(best, path):
        return best
    length, count = best.piece[1] - best.piece[0], len(best.matches)
    pairs = (
        one
        for one in found[1:]
        if _LONGER[0] < (one.piece[1] - one.piece[0]) / length < _LONGER[1]
        and _AS_MANY[0] <= len(one.matches) / count <= _AS_MANY[1]
        and one.gain > _AS_GOOD * best.gain
    )
    return next(pairs, best)


def _take_turns(one: Explanation, path: Path) -> bool:
    """Whether the repetitions are of two kinds by how their time is shared over the way, one after the other."""
    shares = _shares_of_time(one.matches, path)
    if len(shares) < _FEWEST:
        return False
    off = shares - shares.mean(axis=0)
    _, _, axes = np.linalg.svd(off, full_matrices=False)
    is_first = off @ axes[0] > 0
    if (is_first[1:] != is_first[:-1]).mean() < _TURNS:
        return False
    # Medians: the first or the last may have taken some rest with it.
    kinds = [np.median(shares[kind], axis=0) for kind in (is_first, ~is_first)]
    usual = np.median(np.linalg.norm(shares - np.where(is_first[:, None], *kinds), axis=1))
    return float(np.linalg.norm(kinds[0] - kinds[1])) > max(_TOLD, _APART * float(usual))


def _shares_of_time(matches: NDArray[np.int64], path: Path) -> Float:
    """Logarithm of the time that each part of the way takes, against the mean of its repetition; shape (K, 4)."""
    parts = []
    for first, last in matches.tolist():
        if last - first >= _PARTS:
            stay = path.stay[first:last]
            stay = np.minimum(stay, _HELD * np.median(stay))
            parts.append([np.log(max(float(part.mean()), 0.1)) for part in np.array_split(stay, _PARTS)])
    shares = np.array(parts).reshape(-1, _PARTS)
    return np.asarray(shares - shares.mean(axis=1, keepdims=True))
