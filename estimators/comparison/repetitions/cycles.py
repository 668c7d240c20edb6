"""Which piece of a movement comes again and again, whatever moves.

The movement is a path without rest, holds and pace (`_path`). Every closed piece of it is a hypothesis of what one
repetition is; `search` finds where it comes again. The hypothesis that shortens the description of the path most is
taken: a piece described once, everywhere else only what is left over (Rissanen 1978, Automatica 14:465). So two bends
that differ as jumping off and landing do are one repetition of two bends, and two that differ no more than repetitions
do are two. Where a repetition begins is not said by what comes again: `_home` chooses.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from typing import Final

import numpy as np
import scipy
from numpy.typing import NDArray

from estimators.comparison.repetitions.cycles_kernel import chain, search
from estimators.comparison.repetitions.path import Path
from estimators.recording import Float

LEFT, BACK = 0.35, 0.25
"""Shares of the size: a closed piece goes further than the one from where it begins, and ends nearer than the other."""
_ALIKE: Final = 0.22
_STRAY: Final = 0.36
"""Share of the size: no part of a repetition is further from that part of another, or it turned round early."""
OPEN: Final = 0.3
"""Share of the size: no repetition ends further from where it began."""
_FURTHEST: Final = 0.7
_FINEST: Final = 0.045
"""Share of the size below which differences say nothing: those of the steps, and of sizes that vary by a tenth."""
_BEGINNINGS: Final = 24
_CLOSINGS: Final = 3
_CELLS: Final = 15_000_000
"""Work that the search may cost: a long session tries fewer hypotheses."""


@dataclass(frozen=True)
class Explanation:
    """One hypothesis and what it explains.

    Attributes
    ----------
    piece : tuple of int
        First and last point of the path that are one repetition.
    matches : ndarray of int, shape (K, 2)
        First and last point of each repetition, in order, sharing ends at most.
    gain : float
        By how much it shortens the description of the path.
    covered : float
        Share of the path that the repetitions are.
    """

    piece: tuple[int, int]
    matches: NDArray[np.int64]
    gain: float
    covered: float


Explaining = Callable[[tuple[int, int]], Explanation | None]
"""What a piece of one path explains; None when it does not come again."""


def explaining_once(path: Path) -> Explaining:
    """Return what says of a piece of this path what it explains, and searches for each only once."""
    return cache(partial(explained, path))


def explain(path: Path, explaining: Explaining) -> list[Explanation]:
    """Try every closed piece; return what each explains, the best first.

    Parameters
    ----------
    explaining : callable
        From `explaining_once`.
    """
    pieces = closed_pieces(path)
    work = len(path.points) * sum(b - a + 1 for a, b in pieces)
    if work > _CELLS:
        pieces = pieces[:: int(np.ceil(work / _CELLS))]
    found = [explanation for piece in pieces if (explanation := explaining(piece)) is not None]
    return sorted(found, key=lambda one: -one.gain)


def closed_pieces(path: Path) -> list[tuple[int, int]]:
    """Pieces that end where they begin, from where the movement slows down and from anywhere."""
    points, count = path.points, len(path.points)
    calm = scipy.ndimage.maximum_filter1d(path.stay, 7) == path.stay
    slow = np.flatnonzero(calm)
    slow = slow[np.argsort(-path.stay[slow])][: _BEGINNINGS // 2]
    even = np.linspace(0, count - 1, _BEGINNINGS - len(slow) + 2).astype(int)[1:-1]
    pieces: list[tuple[int, int]] = []
    for begin in sorted({*slow.tolist(), *even.tolist()}):
        away = np.linalg.norm(points[begin:] - points[begin], axis=1)
        pieces.extend((begin, begin + end) for end in _closings(away, path.size))
    return pieces


def _closings(away: Float, size: float) -> list[int]:
    """Where a path is back where it began, after having gone away: the nearest point of each return."""
    found: list[int] = []
    at = 0
    while len(found) < _CLOSINGS:
        gone = np.flatnonzero(away[at:] > LEFT * size)
        if not len(gone):
            break
        back = np.flatnonzero(away[at + gone[0] :] < BACK * size)
        if not len(back):
            break
        first = at + int(gone[0]) + int(back[0])
        inside = np.flatnonzero(away[first:] > BACK * size)
        last = first + int(inside[0]) if len(inside) else len(away)
        found.append(first + int(np.argmin(away[first:last])))
        at = found[-1]
    return found


def explained(path: Path, piece: tuple[int, int]) -> Explanation | None:
    """Return what a piece explains; None when it does not come again."""
    points = np.ascontiguousarray(path.points[piece[0] : piece[1] + 1])
    size = float(np.linalg.norm(points - points[0], axis=1).max())
    rms, start = search(points, path.points, _FURTHEST * size, _STRAY * size)
    open_by = np.linalg.norm(path.points - path.points[start], axis=1)
    rms[open_by > OPEN * size] = np.inf
    matches, left_over = _chain(rms / size, start, len(points))
    if len(matches) < 2:
        return None
    length = np.minimum(matches[:, 1] - matches[:, 0], len(points) - 1)
    covered = float(length.sum())
    spread = float(np.sqrt(((points - points.mean(axis=0)) ** 2).sum(axis=1).mean())) / size
    rest = max(
        _FINEST,
        float(np.sqrt((left_over**2 * length).sum() / max(covered - length[np.argmin(left_over)], 1))),
    )
    gain = (covered - len(points) + 1) * np.log(max(spread / rest, 1.0))
    return Explanation(piece, matches, float(gain), covered / (len(path.points) - 1))


def _chain(rms: Float, start: NDArray[np.int64], length: int) -> tuple[NDArray[np.int64], Float]:
    """Choose matches that share no way so that as much as possible is covered, the more alike the better.

    Returns
    -------
    matches : ndarray of int, shape (K, 2)
    left_over : ndarray, shape (K,)
        Root mean square difference of each from the piece, as a share of its size.
    """
    usable = rms < _ALIKE
    # What is longer than the piece explains no more for it: a partial try before it does not belong to it.
    way = np.minimum(np.arange(len(rms)) - start, length)
    worth = np.where(usable, way * (1.0 - (rms / _ALIKE) ** 2), -1.0)
    chosen = chain(worth, start)
    return chosen, rms[chosen[:, 1]] if len(chosen) else np.zeros(0)
