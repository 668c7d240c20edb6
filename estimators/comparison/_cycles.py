"""Which piece of a movement comes again and again, whatever moves.

The movement is walked in steps of one length (`walk`): rest, holds and pace vanish and what is left is a path. Every
closed piece of it is a hypothesis of what one repetition is; `search` finds where it comes again. The hypothesis that
shortens the description of the path most is taken: a piece described once, everywhere else only what is left over
(Rissanen 1978, Automatica 14:465). So two bends that differ as jumping off and landing do are one repetition of two
bends, and two that differ no more than repetitions do are two.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Final

import numpy as np
import scipy
from numpy.typing import NDArray

from estimators.comparison._cycles_kernel import chain, search, walk
from estimators.recording import Float

_FINE, _COARSE = 0.07, 0.15
"""Shares of the movement's size between two points of the path: as fine as the calm parts are calm."""
_CALM_S: Final = 0.3
_NO_CALM: Final = 0.25
"""Share of the size: where nothing is calmer than this, nobody ever rests."""
_DIMENSIONS: Final = 5
_LEFT, _BACK = 0.35, 0.25
"""Shares of the size: a closed piece goes further than the one from where it begins, and ends nearer than the other."""
_ALIKE: Final = 0.22
_STRAY: Final = 0.36
"""Share of the size: no part of a repetition is further from that part of another, or it turned round early."""
_TRIED: Final = 0.25
"""Share of the size beyond which leaving home was a try."""
_OPEN: Final = 0.3
"""Share of the size: no repetition ends further from where it began."""
_FURTHEST: Final = 0.7
_FINEST: Final = 0.045
"""Share of the size below which differences say nothing: those of the steps, and of sizes that vary by a tenth."""
_BEGINNINGS: Final = 24
_CLOSINGS: Final = 3
_CELLS: Final = 15_000_000
"""Work that the search may cost: a long session tries fewer hypotheses."""
_RIVAL: Final = 0.5
_CUTS: Final = 25
_NEAR: Final = 0.12
"""Share of the size within which somebody stays where they are."""
_AROUND: Final = 0.12
"""Share of a repetition by which the stay at home may be away from where the path was cut."""
_STILL, _MUCH_SLOWER = 0.1, 5.0
"""Of the longest stay and of the usual time for a step of the path: what lasts longer is a stay as well."""
_REST_S: Final = 0.4
_REST_WORTH: Final = 0.5
_END_WORTH: Final = 0.3
_LONG_REST_S: Final = 1.5
"""Nobody who exercises pauses inside a repetition for long: rest at either end speaks for home the more the longer."""


@dataclass(frozen=True)
class Path:
    """A movement in steps of one length.

    Attributes
    ----------
    points : ndarray, shape (M, D)
    place : ndarray, shape (M,)
        Sample at which each was reached.
    last : float
        The last sample.
    size : float
        How far the movement goes, in units of the posture.
    """

    points: Float
    place: Float
    last: float
    size: float

    @cached_property
    def stay(self) -> Float:
        """Samples spent at each point, shape (M,)."""
        return np.diff(self.place, append=self.last)

    @cached_property
    def usual_stay(self) -> float:
        """Samples that a step of the path usually takes."""
        return float(np.median(self.stay))


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


def smoothed(values: Float, step_s: float) -> tuple[Float, float]:
    """Smooth a posture no more than its own pace allows.

    Parameters
    ----------
    values : ndarray, shape (N, D)
        Without gaps.
    step_s : float

    Returns
    -------
    values : ndarray, shape (N, D)
    smoothing_s : float
        Standard deviation of the smoothing: of slow movements a tremor vanishes, of fast ones nothing may.
    """
    centred = values - np.median(values, axis=0)
    _, _, axes = np.linalg.svd(centred[:: max(1, len(centred) // 2000)], full_matrices=False)
    main = scipy.ndimage.gaussian_filter1d(centred @ axes[0], 0.03 / step_s)
    smoothing_s = float(np.clip(0.35 * _rise_s(main, step_s), 0.02, 0.10))
    return scipy.ndimage.gaussian_filter1d(values, smoothing_s / step_s, axis=0, mode="nearest"), smoothing_s


def _rise_s(signal: Float, step_s: float) -> float:
    """How long the signal usually takes for the middle three fifths of its way from one turn to the next."""
    low, high = np.percentile(signal, (3, 97))
    reversal = 0.35 * (high - low)
    turns, extreme, direction = [0], 0, 0
    for i in range(1, len(signal)):
        if (signal[i] - signal[extreme]) * direction > 0 or direction == 0:
            if direction == 0 and abs(signal[i] - signal[extreme]) > reversal:
                direction = 1 if signal[i] > signal[extreme] else -1
                extreme = i
            elif direction:
                extreme = i
        elif abs(signal[i] - signal[extreme]) > reversal:
            turns.append(extreme)
            direction, extreme = -direction, i
    turns.append(extreme)
    rises = []
    for a, b in pairwise(turns):
        if b > a:
            share = (signal[a : b + 1] - signal[a]) / (signal[b] - signal[a] or 1.0)
            rises.append(((share > 0.2) & (share < 0.8)).sum() * step_s)
    return float(np.median(rises)) if rises else 0.1


def path_of(values: Float, step_s: float) -> Path | None:
    """Walk a smoothed movement; None where nothing moves.

    Parameters
    ----------
    values : ndarray, shape (N, D)
    step_s : float
    """
    speed = np.linalg.norm(np.diff(values, axis=0), axis=1)
    if speed.sum() <= 0:
        return None
    # Weighted by the way done: how long somebody rests has no say in how far the movement goes.
    centre = (values[1:] * speed[:, None]).sum(axis=0) / speed.sum()
    away = np.linalg.norm(values[1:] - centre, axis=1)
    order = np.argsort(away)
    size = 2.0 * float(away[order][np.searchsorted(np.cumsum(speed[order]), 0.6 * speed.sum())])
    offset = values - centre
    if offset.shape[1] > 1:
        _, spread, axes = np.linalg.svd(offset * np.sqrt(np.append(speed, 0.0))[:, None], full_matrices=False)
        used = np.flatnonzero(np.cumsum(spread**2) <= 0.995 * (spread**2).sum())[: _DIMENSIONS - 1]
        offset = offset @ axes[: len(used) + 1].T
    points, place = walk(np.ascontiguousarray(offset), _step(offset, size, step_s))
    return Path(points, place, len(values) - 1.0, size) if len(points) > 3 else None


def _step(offset: Float, size: float, step_s: float) -> float:
    """Distance of successive points: beyond what a tremor does while somebody rests."""
    window = max(3, round(_CALM_S / step_s))
    reach = scipy.ndimage.maximum_filter1d(offset, window, axis=0) - scipy.ndimage.minimum_filter1d(
        offset, window, axis=0
    )
    calm = float(np.percentile(np.linalg.norm(reach, axis=1), 10)) / size
    return size * (float(np.clip(1.1 * calm, _FINE, _COARSE)) if calm < _NO_CALM else _FINE)


def explain(path: Path) -> list[Explanation]:
    """Try every closed piece; return what each explains, the best first.

    Parameters
    ----------
    path : Path
    """
    pieces = _closed_pieces(path)
    work = len(path.points) * sum(b - a + 1 for a, b in pieces)
    if work > _CELLS:
        pieces = pieces[:: int(np.ceil(work / _CELLS))]
    found = [explanation for piece in pieces if (explanation := _explained(path, piece)) is not None]
    return sorted(found, key=lambda one: -one.gain)


def _closed_pieces(path: Path) -> list[tuple[int, int]]:
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
        gone = np.flatnonzero(away[at:] > _LEFT * size)
        if not len(gone):
            break
        back = np.flatnonzero(away[at + gone[0] :] < _BACK * size)
        if not len(back):
            break
        first = at + int(gone[0]) + int(back[0])
        inside = np.flatnonzero(away[first:] > _BACK * size)
        last = first + int(inside[0]) if len(inside) else len(away)
        found.append(first + int(np.argmin(away[first:last])))
        at = found[-1]
    return found


def _explained(path: Path, piece: tuple[int, int]) -> Explanation | None:
    """Return what a piece explains; None when it does not come again."""
    points = np.ascontiguousarray(path.points[piece[0] : piece[1] + 1])
    size = float(np.linalg.norm(points - points[0], axis=1).max())
    rms, start = search(points, path.points, _FURTHEST * size, _STRAY * size)
    open_by = np.linalg.norm(path.points - path.points[start], axis=1)
    rms[open_by > _OPEN * size] = np.inf
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


def most_likely(found: list[Explanation], path: Path, step_s: float) -> Explanation | None:
    """Return the best explanation, cut where the repetitions begin and end.

    Parameters
    ----------
    found : list of Explanation
        The best first.
    path : Path
    step_s : float
        Between samples.

    Notes
    -----
    What comes again explains as much wherever it is cut. People begin and end at rest, and rest more between
    repetitions than within: the cut is tried all along one repetition.
    """
    if not found:
        return _single(path, step_s)
    best = found[0]
    shifted = [one for piece in _shifted(best, path) if (one := _explained(path, piece)) is not None]
    rivals = [best, *(one for one in shifted if one.gain >= _RIVAL * best.gain)]
    most = max(len(one.matches) for one in rivals)

    def fitness(one: Explanation) -> float:
        # A recording that begins or ends inside a repetition shows a whole one more of those that are cut elsewhere.
        count = min((len(one.matches) + 1) / most, 1.0)
        return count + one.covered / best.covered + one.gain / best.gain + _rest(one, path, step_s)

    return _centred(max(rivals, key=fitness), path)


def _centred(one: Explanation, path: Path) -> Explanation:
    """Cut where the stays at home are, not near them: the cuts that were tried are some way apart."""
    left = at_home(one, path)[:, 0]
    begins = one.matches[:, 0]
    away = np.maximum(left[:, 0] - begins, 0) + np.minimum(left[:, 1] - begins, 0)
    pieces = _cut_at(path, one.piece[0] + round(float(np.median(away))), one.piece[1] - one.piece[0])
    centred = [found for piece in pieces if (found := _explained(path, piece)) is not None]
    return next((new for new in centred if len(new.matches) >= len(one.matches)), one)


def _single(path: Path, step_s: float) -> Explanation | None:
    """Return the movement that was done once, from rest to rest; None where there is none."""
    count = len(path.points) - 1
    once = [Explanation((a, b), np.array([(a, b)]), 0.0, (b - a) / count) for a, b in _closed_pieces(path)]
    found = [one for one in once if min(_rested_at_the_ends(one, path, step_s)) > _REST_S]
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
    return [(first, low + int(np.argmin(away)))] if away.min() < _BACK * path.size else []


def with_tries(one: Explanation, path: Path) -> Explanation:
    """Add what leaves home and comes back between two repetitions without resembling them.

    Parameters
    ----------
    one : Explanation
    path : Path
    """
    piece = path.points[one.piece[0] : one.piece[1] + 1]
    size = float(np.linalg.norm(piece - piece[0], axis=1).max())
    tries = []
    for (_, b), (a, _) in pairwise(one.matches.tolist()):
        away = np.linalg.norm(path.points[b : a + 1] - path.points[b], axis=1)
        if away.max() > _TRIED * size and away[-1] < _OPEN * size:
            tries.append((b, a))
    both = np.concatenate([one.matches, tries]) if tries else one.matches
    return replace(one, matches=both[np.argsort(both[:, 0])])


def at_home(one: Explanation, path: Path) -> NDArray[np.int64]:
    """Return the stays at home between which each repetition lies.

    Parameters
    ----------
    one : Explanation
    path : Path

    Returns
    -------
    ndarray of int, shape (K, 2, 2)
        Of each repetition the first and last point of the stay that it leaves, and of the one at which it arrives.
        Where one repetition follows the other, both share one stay.
    """
    matches = one.matches.tolist()
    stays = []
    for number, (a, b) in enumerate(matches):
        reach = round(_AROUND * (b - a))
        before = matches[number - 1][1] if number else 0
        after = matches[number + 1][0] if number + 1 < len(matches) else len(path.points) - 1
        low = before - reach if number and a - before <= reach else max(a - reach, before)
        high = after + reach if number + 1 < len(matches) and after - b <= reach else min(b + reach, after)
        left = _stay(path, max(low, 0), a + reach)
        stays.append((left, _stay(path, b - reach, min(high, len(path.points) - 1))))
    return np.array(stays, dtype=np.int64).reshape(-1, 2, 2)


def _stay(path: Path, low: int, high: int) -> tuple[int, int]:
    """First and last point of the longest stay among some points of the path."""
    longest = low + int(np.argmax(path.stay[low : high + 1]))
    away = np.linalg.norm(path.points[low : high + 1] - path.points[longest], axis=1)
    is_near = away < _NEAR * path.size
    # Somebody who settles elsewhere, not far, before setting out stays there as well.
    still = max(_STILL * path.stay[longest], _MUCH_SLOWER * path.usual_stay)
    stays = low + np.flatnonzero(
        (path.stay[low : high + 1] >= min(still, path.stay[longest])) & (away < _LEFT * path.size)
    )
    first, last = int(stays[0]), int(stays[-1])
    while first > low and is_near[first - 1 - low]:
        first -= 1
    while last < high and is_near[last + 1 - low]:
        last += 1
    return first, last


def _rest(one: Explanation, path: Path, step_s: float) -> float:
    """Worth of rest: the share of the time that is spent at home between repetitions, and rest at either end."""
    stays = at_home(one, path)
    place = np.append(path.place, path.last)
    stayed = place[stays[:, :, 1] + 1] - place[stays[:, :, 0]]
    length = float(np.median(np.diff(path.place[one.matches], axis=1)))
    follows = stays[:-1, 1, 0] == stays[1:, 0, 0]
    rest = float(np.median(stayed[1:, 0][follows])) / (length + 1.0) if follows.any() else 0.0
    ends = sum(min(rested / _LONG_REST_S, 1.0) for rested in _rested_at_the_ends(one, path, step_s))
    return _REST_WORTH * min(rest, 1.0) + _END_WORTH * ends


def _rested_at_the_ends(one: Explanation, path: Path, step_s: float) -> list[float]:
    """Seconds that somebody rests at home at either end; none where they do something else before, or after.

    A hold inside a repetition has a part of one on either side.
    """
    stays = at_home(one, path)
    place = np.append(path.place, path.last)
    first, last = stays[0, 0], stays[-1, 1]
    rested = []
    for points, (begin, end) in ((path.points[: first[1] + 1], first), (path.points[last[0] :], last)):
        away = np.linalg.norm(points - path.points[end], axis=1).max()
        rested.append(float(place[end + 1] - place[begin]) * step_s if away < _LEFT * path.size else 0.0)
    return rested
