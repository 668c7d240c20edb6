"""Compiled parts of the search for what repeats: turns, the path, where a piece comes again, and stays at home."""

import numpy as np
from numpy.typing import NDArray

from estimators.compiling import compiled
from estimators.recording import Float


@compiled("Tuple((float64[:,::1], float64[::1]))(float64[:,::1], float64)", error_model="python")
def walk(values: Float, step: float) -> tuple[Float, Float]:  # pragma: no cover
    """Follow a movement in steps of one length: rest, holds, pace and what is smaller than a step vanish.

    Parameters
    ----------
    values : ndarray, shape (N, D)
        Postures, evenly in time.
    step : float
        Distance of successive points of the path.

    Returns
    -------
    path : ndarray, shape (M, D)
        Each point is one step from the one before it.
    place : ndarray, shape (M,)
        Sample, with fraction, at which the movement came to each point.
    """
    samples, dimensions = values.shape
    total = 0.0
    for i in range(1, samples):
        square = 0.0
        for d in range(dimensions):
            square += (values[i, d] - values[i - 1, d]) ** 2
        total += np.sqrt(square)
    room = int(total / step) + 2
    path = np.empty((room, dimensions))
    place = np.empty(room)
    path[0] = values[0]
    place[0] = 0.0
    count = 1
    for i in range(1, samples):
        while count < room:
            square = 0.0
            for d in range(dimensions):
                square += (values[i, d] - path[count - 1, d]) ** 2
            away = np.sqrt(square)
            if away < step:
                break
            share = step / away
            for d in range(dimensions):
                path[count, d] = path[count - 1, d] + share * (values[i, d] - path[count - 1, d])
            place[count] = max(place[count - 1], i - 1 + share)
            count += 1
    return path[:count].copy(), place[:count].copy()


@compiled("int64[::1](float64[::1], float64)", error_model="python")
def turning_points(signal: Float, reversal: float) -> NDArray[np.int64]:  # pragma: no cover
    """Return the samples at which a signal turns, its beginning before them and its last extreme after them.

    Parameters
    ----------
    signal : ndarray, shape (N,)
    reversal : float
        How far it goes back from an extreme before that was a turn.
    """
    turns = np.zeros(len(signal) + 2, dtype=np.int64)
    count, extreme, direction = 1, 0, 0
    for i in range(1, len(signal)):
        way = signal[i] - signal[extreme]
        if direction == 0:
            if abs(way) > reversal:
                direction = 1 if way > 0 else -1
                extreme = i
        elif way * direction > 0:
            extreme = i
        elif abs(way) > reversal:
            turns[count] = extreme
            count += 1
            direction, extreme = -direction, i
    turns[count] = extreme
    return turns[: count + 1].copy()


@compiled(
    "Tuple((float64[::1], int64[::1]))(float64[:,::1], float64[:,::1], float64, float64)",
    error_model="python",
)
def search(
    piece: Float, path: Float, furthest: float, stray: float
) -> tuple[Float, NDArray[np.int64]]:  # pragma: no cover
    """Find where a piece of a path comes again, wherever it begins: warping with the slope held within 1/2 and 2.

    Parameters
    ----------
    piece : ndarray, shape (K, D)
    path : ndarray, shape (M, D)
    furthest : float
        A match does not begin further from where the piece begins.
    stray : float
        Nor is any part of it further from that part of the piece, counted from where both begin, so that a posture
        that drifts stays alike.

    Returns
    -------
    rms : ndarray, shape (M,)
        Root mean square of that distance for the best match that ends at each point; infinite where nothing ends.
    start : ndarray of int, shape (M,)
        Where that match begins.

    Notes
    -----
    Sakoe and Chiba 1978, slopes of P = 1 in their asymmetric form, with a free beginning: of all matches through a cell
    only the best is followed, and distances are counted from its beginning.
    """
    rows, columns, dimensions = piece.shape[0], path.shape[0], piece.shape[1]
    widest = stray * stray
    shift = path - piece[0]
    now, last, before = np.full(columns, np.inf), np.full(columns, np.inf), np.full(columns, np.inf)
    begun, begun_last, begun_before = np.full(columns, -1), np.full(columns, -1), np.full(columns, -1)
    for j in range(columns):
        square = 0.0
        for d in range(dimensions):
            square += shift[j, d] ** 2
        if square <= furthest * furthest:
            now[j] = 0.0
            begun[j] = j
    for i in range(1, rows):
        now, last, before = before, now, last
        begun, begun_last, begun_before = begun_before, begun, begun_last
        now[0] = np.inf
        begun[0] = -1
        for j in range(1, columns):
            # A cell that nothing leads to costs infinitely much, which nothing is cheaper than: `least` keeps it out.
            least = np.inf
            origin = -1
            # Every point of the piece weighs the same, however many of the path it is matched with: weights that count
            # both would favour short matches.
            if last[j - 1] < least:
                far = begun_last[j - 1]
                here = 0.0
                for d in range(dimensions):
                    here += (path[j, d] - shift[far, d] - piece[i, d]) ** 2
                if here <= widest:
                    least = last[j - 1] + here
                    origin = far
            if i > 1 and before[j - 1] < least:
                far = begun_before[j - 1]
                here, middle = 0.0, 0.0
                for d in range(dimensions):
                    there = path[j, d] - shift[far, d]
                    here += (there - piece[i, d]) ** 2
                    middle += (there - piece[i - 1, d]) ** 2
                total = before[j - 1] + (middle + here)
                if here <= widest and middle <= widest and total < least:
                    least = total
                    origin = far
            if j > 1 and last[j - 2] < least:
                far = begun_last[j - 2]
                here, middle = 0.0, 0.0
                for d in range(dimensions):
                    here += (path[j, d] - shift[far, d] - piece[i, d]) ** 2
                    middle += (path[j - 1, d] - shift[far, d] - piece[i, d]) ** 2
                total = last[j - 2] + 0.5 * (middle + here)
                if here <= widest and middle <= widest and total < least:
                    least = total
                    origin = far
            now[j] = least
            begun[j] = origin
    return np.sqrt(now / (rows - 1)), begun


@compiled("int64[:,::1](float64[::1], int64[::1])", error_model="python")
def chain(worth: Float, start: NDArray[np.int64]) -> NDArray[np.int64]:  # pragma: no cover
    """Choose matches that share no way so that they are worth most together.

    Parameters
    ----------
    worth : ndarray, shape (M,)
        Of the match that ends at each point; negative where none does.
    start : ndarray of int, shape (M,)
        Where that match begins.

    Returns
    -------
    ndarray of int, shape (K, 2)
        First and last point of each, in order.
    """
    count = len(worth)
    best = np.zeros(count + 1)
    is_chosen = np.zeros(count, dtype=np.bool_)
    for end in range(count):
        best[end + 1] = best[end]
        # One match may begin at the point where another ends.
        if worth[end] >= 0 and best[start[end] + 1] + worth[end] > best[end + 1]:
            best[end + 1] = best[start[end] + 1] + worth[end]
            is_chosen[end] = True
    matches = np.empty((count, 2), dtype=np.int64)
    found = 0
    end = count - 1
    while end > 0:
        if is_chosen[end]:
            matches[found, 0] = start[end]
            matches[found, 1] = end
            found += 1
            end = start[end]
        else:
            end -= 1
    return matches[:found][::-1].copy()


@compiled(error_model="python")
def _grown(
    points: Float, stay: Float, low: int, high: int, longest: int, least: float, left: float, near: float
) -> tuple[int, int]:  # pragma: no cover
    """Return first and last point of the stay around its longest point, within the window `low` to `high`."""
    first = end = longest
    for j in range(low, high + 1):
        if stay[j] >= least and np.sqrt(((points[j] - points[longest]) ** 2).sum()) < left:
            first = min(first, j)
            end = max(end, j)
    while first > low and np.sqrt(((points[first - 1] - points[longest]) ** 2).sum()) < near:
        first -= 1
    while end < high and np.sqrt(((points[end + 1] - points[longest]) ** 2).sum()) < near:
        end += 1
    return first, end


@compiled(
    "int64[:,:,::1](float64[:,::1], float64[::1], int64[:,::1],"
    " float64, float64, float64, float64, float64, float64, float64)",
    error_model="python",
)
def stays_at_home(
    points: Float,
    stay: Float,
    matches: NDArray[np.int64],
    around: float,
    slow: float,
    elsewhere: float,
    left: float,
    near: float,
    still: float,
    much_slower: float,
) -> NDArray[np.int64]:  # pragma: no cover
    """Find the stay next to both ends of each repetition.

    Parameters
    ----------
    points : ndarray, shape (M, D)
    stay : ndarray, shape (M,)
        Samples spent at each point.
    matches : ndarray of int, shape (K, 2)
        First and last point of each repetition, in order.
    around : float
        Share of a repetition by which a stay may be away from its end.
    slow, much_slower : float
        Samples from which on a point is a stay, and from which on it is one whatever else is.
    elsewhere, left, near : float
        Distances: a stay is no further than the first from home, another no further than the second from it to belong
        to it, and whatever is nearer than the third belongs to it.
    still : float
        Share of the longest stay from which on another one next to it belongs to it.

    Returns
    -------
    ndarray of int, shape (K, 2, 2)
        First and last point of the stay before and after each repetition; twice its own end where there is none.

    Notes
    -----
    Home is where the stays usually are, seen from the ends of the repetitions: a posture that drifts stays home, and a
    rest somewhere else does not become it.
    """
    count, dimensions = len(matches), points.shape[1]
    last = len(points) - 1
    window = np.empty((count, 2, 2), dtype=np.int64)
    from_cut = np.empty((2 * count, dimensions))
    rested = 0
    for k in range(count):
        a, b = matches[k]
        reach = int(np.rint(around * (b - a)))
        before = matches[k - 1, 1] if k > 0 else 0
        after = matches[k + 1, 0] if k + 1 < count else last
        # What follows at once shares the stay; what does not, stays on its side of the other one.
        window[k, 0, 0] = max(before - reach if k > 0 and a - before <= reach else max(a - reach, before), 0)
        window[k, 0, 1] = a + reach
        window[k, 1, 0] = b - reach
        window[k, 1, 1] = min(
            after + reach if k + 1 < count and after - b <= reach else min(b + reach, after), last
        )
        for side in range(2):
            low, high = window[k, side]
            longest = low + np.argmax(stay[low : high + 1])
            if stay[longest] >= slow:
                from_cut[rested] = points[longest] - points[matches[k, side]]
                rested += 1
    home = np.zeros(dimensions)
    for d in range(dimensions):
        if rested > 0:
            home[d] = np.median(from_cut[:rested, d])
    found = np.empty((count, 2, 2), dtype=np.int64)
    for k in range(count):
        for side in range(2):
            low, high = window[k, side]
            cut = matches[k, side]
            longest = -1
            for j in range(low, high + 1):
                away = np.sqrt(((points[j] - points[cut] - home) ** 2).sum())
                if away < elsewhere and (longest < 0 or stay[j] > stay[longest]):
                    longest = j
            if longest < 0 or stay[longest] < slow:
                found[k, side] = cut
                continue
            # Somebody who settles elsewhere, not far, before setting out stays there as well.
            least = min(max(still * stay[longest], much_slower), stay[longest])
            found[k, side] = _grown(points, stay, low, high, longest, least, left, near)
    return found
