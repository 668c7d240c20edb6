"""Where a repetition begins and ends: home, and how long somebody stays there.

What comes again explains as much wherever it is cut: the cut is tried all along one repetition, and on the stay next to
it, and `evidence` says what speaks for each. Where nobody stays, home is the posture of the cut, and any is as right as
another.
"""

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from estimators.comparison.repetitions.cycles import BACK, LEFT, OPEN, Explaining, Explanation, closed_pieces
from estimators.comparison.repetitions.cycles_kernel import stays_at_home
from estimators.comparison.repetitions.evidence import Evidence, evidence, rested_at_the_ends
from estimators.comparison.repetitions.pairs import in_pairs
from estimators.comparison.repetitions.path import Path

_TRIED: Final = 0.25
"""Share of the size beyond which leaving home was a try."""
_HALF_WAY: Final = 0.5
"""Share of a try: who stays further from home than that holds, who stays nearer has come home."""
_RIVAL: Final = 0.5
_CUTS: Final = 25
_ELSEWHERE: Final = 0.5
"""Share of the size: a stay further from home than that is not at home."""
_NEAR: Final = 0.12
"""Share of the size within which somebody stays where they are."""
_AROUND: Final = 0.12
"""Share of a repetition by which the stay at home may be away from where the path was cut."""
_FEW: Final = 0.25
"""Share of the repetitions: so many may have taken a try with them; more that stay at home on their way do it so."""
_WITHIN: Final = 0.3
"""Share of a repetition that may be part of a try next to it."""
_STILL, _MUCH_SLOWER = 0.1, 5.0
"""Of the longest stay and of the usual time for a step of the path: what lasts longer is a stay as well."""
_REST_S: Final = 0.4
_LEAST_OF_REST: Final = 0.9


def most_likely(
    found: list[Explanation], path: Path, step_s: float, explaining: Explaining
) -> Explanation | None:
    """Return the best explanation, cut where the repetitions begin and end.

    Parameters
    ----------
    found : list of Explanation
        The best first.
    step_s : float
        Between samples.
    explaining : callable
        From `cycles.explaining_once`, of this path.

    Notes
    -----
    What comes again explains as much wherever it is cut. People begin and end at rest, rest more between repetitions
    than within, and come back to one posture: the cut is tried all along one repetition.
    """
    if not found:
        return _single(path, step_s)
    best = in_pairs(found, path)
    shifted = [one for piece in _shifted(best, path) if (one := explaining(piece)) is not None]
    rivals = [best, *(one for one in shifted if one.gain >= _RIVAL * best.gain)]
    most = max(len(one.matches) for one in rivals)
    known: dict[tuple[int, int], Evidence] = {}

    def speaks_for(one: Explanation) -> Evidence:
        # A piece explains the same whenever it is asked for.
        if one.piece not in known:
            known[one.piece] = evidence(one, at_home(one, path), path, step_s)
        return known[one.piece]

    def fitness(one: Explanation) -> float:
        # A recording that begins or ends inside a repetition shows a whole one more of those that are cut elsewhere.
        count = min((len(one.matches) + 1) / most, 1.0)
        return count + one.covered / best.covered + one.gain / best.gain + speaks_for(one).worth

    return max((_centred(one, path, speaks_for, explaining) for one in rivals), key=fitness)


def _centred(
    one: Explanation, path: Path, speaks_for: Callable[[Explanation], Evidence], explaining: Explaining
) -> Explanation:
    """Cut where the stays at home are, not near them, unless that loses them: the cuts tried are some way apart."""
    left = at_home(one, path)[:, 0]
    begins = one.matches[:, 0]
    away = np.maximum(left[:, 0] - begins, 0) + np.minimum(left[:, 1] - begins, 0)
    pieces = _cut_at(path, one.piece[0] + round(float(np.median(away))), one.piece[1] - one.piece[0])
    centred = [found for piece in pieces if (found := explaining(piece)) is not None]
    least = _LEAST_OF_REST * speaks_for(one).rest
    return next(
        (new for new in centred if len(new.matches) >= len(one.matches) and speaks_for(new).rest >= least),
        one,
    )


def _single(path: Path, step_s: float) -> Explanation | None:
    """Return the movement that was done once, from rest to rest; None where there is none."""
    count = len(path.points) - 1
    once = [Explanation((a, b), np.array([(a, b)]), 0.0, (b - a) / count) for a, b in closed_pieces(path)]
    found = [one for one in once if min(rested_at_the_ends(at_home(one, path), path, step_s)) > _REST_S]
    return max(found, key=lambda one: one.covered, default=None)


def _shifted(best: Explanation, path: Path) -> list[tuple[int, int]]:
    """Cut the same repetition elsewhere, from half a repetition earlier to half a one later."""
    begin, end = best.piece
    length = end - begin
    pieces = []
    for shift in np.linspace(-0.5, 0.5, _CUTS).round(6):
        pieces.extend(_cut_at(path, begin + round(shift * length), length))
    return pieces


def _cut_at(path: Path, first: int, length: int) -> list[tuple[int, int]]:
    """Return the piece of about some length that begins at a point; none where it is not closed."""
    low, high = first + round(0.75 * length), first + round(1.25 * length) + 1
    if first < 0 or low >= len(path.points):
        return []
    away = np.linalg.norm(path.points[low:high] - path.points[first], axis=1)
    return [(first, low + int(np.argmin(away)))] if away.min() < BACK * path.size else []


def with_tries(one: Explanation, path: Path) -> Explanation:
    """Add what leaves home and comes back between two repetitions without resembling them.

    Notes
    -----
    What comes again may take with it the beginning of a try that follows, or the end of one before: the way between two
    repetitions is looked at from the stay at home at which the first arrives to that which the second leaves. Every
    stay at home on that way ends a try, unless a whole repetition stays at home on its way too.
    """
    size = _extent(path, *one.piece)
    are_many = not _comes_home_inside(one, path, size)
    may_take = are_many and not _passes_home(one, path, size)
    matches = one.matches.copy()
    stays = at_home(one, path)
    tries: list[tuple[int, int]] = []
    for k in range(len(matches) - 1):
        ways = [(int(matches[k, 1]), int(matches[k + 1, 0]))]
        if are_many:
            ways.insert(0, (_longest(path, stays[k, 1]), _longest(path, stays[k + 1, 0])))
        if may_take:
            arrived = _back_home(path, int(matches[k, 1]), -_reach(matches[k]), _longest(path, stays[k, 0]))
            left = _back_home(
                path, int(matches[k + 1, 0]), _reach(matches[k + 1]), _longest(path, stays[k + 1, 1])
            )
            ways.insert(0, (arrived, left))
        for arrived, left in ways:
            found = _tries(path, arrived, left, size, are_many)
            if found:
                matches[k, 1], matches[k + 1, 0] = arrived, left
                tries.extend(found)
                break
    both = np.concatenate([matches, tries]) if tries else matches
    return replace(one, matches=both[np.argsort(both[:, 0])])


def _extent(path: Path, first: int, last: int) -> float:
    """How far a piece of the path goes from where it begins."""
    return float(np.linalg.norm(path.points[first : last + 1] - path.points[first], axis=1).max())


def _reach(match: NDArray[np.int64]) -> int:
    return round(_WITHIN * float(match[1] - match[0]))


def _back_home(path: Path, end: int, reach: int, home: int) -> int:
    """Return where somebody stays longest at home within a reach of an end of a repetition; the end, where nobody does.

    Home is where the repetition's other end is.
    """
    first, last = max(min(end, end + reach), 0), max(end, end + reach)
    away = np.linalg.norm(path.points[first : last + 1] - path.points[home], axis=1)
    stay = np.where(away < _NEAR * path.size, path.stay[first : last + 1], 0.0)
    return first + int(np.argmax(stay)) if stay.max() >= path.slow else end


def _longest(path: Path, stay: NDArray[np.int64]) -> int:
    """Return the point of a stay at which somebody is longest."""
    first, last = int(stay[0]), int(stay[1])
    return first + int(np.argmax(path.stay[first : last + 1]))


def _comes_home_inside(one: Explanation, path: Path, size: float) -> bool:
    """Whether repetitions stay at home on their way, more of them than may have taken a try with them."""
    return sum(len(_tries(path, a, b, size, True)) > 1 for a, b in one.matches.tolist()) > _FEW * len(
        one.matches
    )


def _passes_home(one: Explanation, path: Path, size: float) -> bool:
    """Whether a repetition comes by home on its way, and leaves it once more."""
    first, last = one.piece
    away = np.linalg.norm(path.points[first : last + 1] - path.points[first], axis=1)
    out = np.flatnonzero(away > _TRIED * size)
    return bool((np.diff(out) > 1).any())


def _tries(path: Path, first: int, last: int, size: float, are_many: bool) -> list[tuple[int, int]]:
    """Part the way between two points at the stays where it began; empty where it does not leave, or not come back."""
    away = np.linalg.norm(path.points[first : last + 1] - path.points[first], axis=1)
    if last <= first or away.max() <= _TRIED * size or away[-1] >= OPEN * size:
        return []
    bounds = [0]
    stay = path.stay[first : last + 1]
    for out, again in pairwise(np.flatnonzero(away > _TRIED * size).tolist() if are_many else ()):
        if again > out + 1:
            home = out + 1 + int(np.argmax(stay[out + 1 : again]))
            if stay[home] >= path.slow and away[home] < _HALF_WAY * away[bounds[-1] : out + 1].max():
                bounds.append(home)
    bounds.append(last - first)
    return [(first + a, first + b) for a, b in pairwise(bounds)]


def at_home(one: Explanation, path: Path) -> NDArray[np.int64]:
    """Return the stays at home between which each repetition lies.

    Returns
    -------
    ndarray of int, shape (K, 2, 2)
        Of each repetition the first and last point of the stay that it leaves, and of the one at which it arrives: the
        point of the cut twice where there is no stay. Where one repetition follows the other, both share one stay.
    """
    usual = path.usual_stay
    return stays_at_home(
        path.points,
        path.stay,
        np.ascontiguousarray(one.matches),
        _AROUND,
        path.slow,
        _ELSEWHERE * path.size,
        LEFT * path.size,
        _NEAR * path.size,
        _STILL,
        _MUCH_SLOWER * usual,
    )
