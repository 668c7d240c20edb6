"""Finding repetitions in a recording without a threshold per person.

A repetition is an excursion: the arm leaves a posture of rest, goes somewhere and comes back. The posture
is not given; every posture where the arm dwelled is tried, and the one whose excursions resemble each other
most and explain most of the movement wins. All thresholds are shares of the movement's own size and speed.
The only absolute numbers are what body-worn sensors can resolve.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy
from numpy.typing import NDArray

from estimators.comparison._alignment import align, resample
from estimators.comparison._channels import arm_channels, fill_gaps
from estimators.comparison._contract import Repetition, Trajectory
from estimators.errors import ComparisonError
from estimators.recording import Float
from estimators.sentences import say

_RATE_HZ = 50.0
_SMOOTHING_S = 0.08
"""Standard deviation of the smoothing: halves 2.3 Hz, leaves 4 percent of a 5 Hz tremor."""
_ANGLE_WEIGHT = 0.5
"""One radian counts as half a reach: a right angle at the elbow moves the hand about that far."""
_SMALLEST_MOVEMENT = 0.05
"""Share of the reach (about 3 cm or 6 degrees) below which sensors cannot tell movement from drift."""
_SHORTEST_S = 0.4
_SINGLE_REST_S = 0.5
_NEAR, _FAR = 0.28, 0.45
"""Hysteresis, as shares of the usual excursion: left the rest, and really went somewhere."""
_SLOW = 0.3
"""Share of brisk speed (its 90th percentile) below which the arm pauses or turns round."""
_ALIKE = 0.33
"""Two excursions are alike when they differ by less than this share of their size after alignment."""
_CANDIDATES = 8
_SHAPE_POINTS = 33
_EXPLAINED = 0.45
"""Share of all movement that the repetitions must account for; random movement reaches a third."""
_COUNT_POWER = 0.6
"""More repetitions speak for a posture of rest, but less than in proportion: the stops inside a composed
movement, such as a cup on its way to the mouth, are visited more often than rest."""
_RIVAL = 0.85
"""Explanations with this share of the best score are rivals."""
_ONSET_SHARE = 0.05
"""A repetition begins where speed exceeds this share of its own peak."""


@dataclass(frozen=True)
class _Excursions:
    """What one candidate posture of rest explains."""

    bounds: list[tuple[int, int]]
    distance: Float
    score: float


def find_repetitions(
    source: Trajectory, side: str, start_s: float | None = None, end_s: float | None = None
) -> list[Repetition]:
    """Find the repetitions of one movement, whichever it is.

    Parameters
    ----------
    source : Trajectory
    side : {"left", "right"}
        The arm that exercised.
    start_s, end_s : float, optional
        Look only inside this half-open stretch of session time.

    Returns
    -------
    list of Repetition
        In order, not overlapping, numbered from 1; empty when nothing repeats clearly. Half movements
        and movements unlike the others are in the list: `judge_repetitions` says which to drop and why.

    Raises
    ------
    ComparisonError
        If nothing of that side was measured.
    """
    window = _window(source, start_s, end_s)
    if window is None:
        return []
    time_s, features = _features(window, side)
    if len(time_s) < 10:
        return []
    speed = np.linalg.norm(np.gradient(features, time_s, axis=0), axis=1)
    extent = float(np.percentile(np.linalg.norm(features - np.median(features, axis=0), axis=1), 95))
    if extent < _SMALLEST_MOVEMENT / 2:
        return []
    found = [_explain(features, speed, posture) for posture in _rest_postures(features, speed, extent)]
    bounds = _sharpen(_most_likely(found), speed)
    return [
        Repetition(number=number, start_s=float(time_s[start]), end_s=float(time_s[end]))
        for number, (start, end) in enumerate(bounds, start=1)
    ]


def _most_likely(found: list[_Excursions]) -> _Excursions:
    """Return the best explanation; of nearly equal ones the one that begins first.

    Where the arm turns round explains a long session nearly as well as where it rests: the same movements, cut half
    a repetition later. People begin from rest.
    """
    best = max(found, key=lambda one: one.score, default=_Excursions([], np.zeros(0), 0.0))
    count = len(best.bounds)
    rivals = [
        one
        for one in found
        if one.score >= _RIVAL * best.score and one.bounds and abs(len(one.bounds) - count) <= 1 + count // 10
    ]
    return min(rivals, key=lambda one: (one.bounds[0][0], -one.score), default=best)


def _window(source: Trajectory, start_s: float | None, end_s: float | None) -> Trajectory | None:
    inside = np.ones(len(source.time_s), dtype=bool)
    if start_s is not None:
        inside &= source.time_s >= start_s
    if end_s is not None:
        inside &= source.time_s < end_s
    if inside.sum() < 2:
        return None
    return Trajectory(
        time_s=source.time_s[inside],
        channels=source.channels,
        values=source.values[inside],
        sigma=source.sigma[inside],
        valid=source.valid[inside],
    )


def _features(source: Trajectory, side: str) -> tuple[Float, Float]:
    """Return time and the posture of the arm as a point in a space with comparable axes.

    The wrist relative to the shoulder in units of the reach, and the joint angles that have no singularity in
    ordinary movement. Smoothed without delay, at `_RATE_HZ` or the recording's own rate if lower.
    """
    try:
        arm = arm_channels(source, side)
    except ComparisonError:
        if not source.valid.any():
            return np.zeros(0), np.zeros((0, 0))
        raise
    wanted = {
        f"humerus_forearm_{side}_zxy_flexion": _ANGLE_WEIGHT,
        f"humerus_forearm_{side}_zxy_pronation": _ANGLE_WEIGHT,
        f"thorax_humerus_{side}_yxy_elevation": _ANGLE_WEIGHT,
    }
    wrist = [arm.column(f"wrist_{side}.{axis}") for axis in "xyz"]
    columns = [column * weight for name, weight in wanted.items() if (column := arm.column(name)) is not None]
    if all(axis is not None for axis in wrist):
        position = np.stack([axis for axis in wrist if axis is not None], axis=1)
        reach = float(np.nanpercentile(np.linalg.norm(position, axis=1), 99))
        if reach > 0:
            columns.extend(position.T / reach)
    if not columns:
        raise ComparisonError(say("compare.no_signal", side=side))
    filled, _ = fill_gaps(np.stack(columns, axis=1))
    step_s = float(np.median(np.diff(source.time_s)))
    smooth = scipy.ndimage.gaussian_filter1d(filled, _SMOOTHING_S / step_s, axis=0, mode="nearest")
    stride = max(1, int(1.0 / (_RATE_HZ * step_s)))
    return source.time_s[::stride], smooth[::stride]


def _runs(mask: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Half-open runs of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8)))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))


def _rest_postures(features: Float, speed: Float, extent: float) -> list[Float]:
    """Postures where the arm dwelled or turned round, near ones merged; the most visited first.

    Merged at three finenesses, since how far apart two postures are that differ is not known beforehand:
    the extent may be that of getting ready and not that of the exercise.
    """
    brisk = float(np.percentile(speed, 90))
    dwells = [features[start:end].mean(axis=0) for start, end in _runs(speed < _SLOW * brisk)]
    postures: list[Float] = []
    for radius in (0.07, 0.14, 0.28):
        merged: list[tuple[Float, int]] = []
        for posture in dwells:
            for place, (centre, visits) in enumerate(merged):
                if np.linalg.norm(posture - centre) < radius * extent:
                    merged[place] = ((centre * visits + posture) / (visits + 1), visits + 1)
                    break
            else:
                merged.append((posture, 1))
        merged.sort(key=lambda item: -item[1])
        postures.extend(centre for centre, _ in merged[:_CANDIDATES])
    return postures


def _excursions(distance: Float, is_slow: NDArray[np.bool_], size: float) -> list[tuple[int, int]]:
    """Complete excursions: the last sample near before going far, and the first one near again after.

    Near counts only where the arm slows down: swinging through the posture of rest is not resting.
    """
    state = np.zeros(len(distance), dtype=np.int8)
    for start, end in _runs(distance < _NEAR * size):
        if is_slow[start:end].any():
            state[start:end] = -1
    state[distance > _FAR * size] = 1
    told = np.flatnonzero(state)
    turns = np.flatnonzero(np.diff(state[told]))
    found: list[tuple[int, int]] = []
    left = -1
    for before, after in zip(told[turns].tolist(), told[turns + 1].tolist(), strict=True):
        if state[before] == -1:
            left = before
        elif left >= 0:
            found.append((left, after))
            left = -1
    return found


def _explain(features: Float, speed: Float, posture: Float) -> _Excursions:
    """Cut the movement into excursions from one posture and say how well they explain it."""
    distance = np.linalg.norm(features - posture, axis=1)
    best = _Excursions([], distance, 0.0)
    is_slow = speed < _SLOW * np.percentile(speed, 90)
    travelled = np.concatenate([[0.0], np.cumsum((speed[1:] + speed[:-1]) / 2)])
    tried: set[tuple[tuple[int, int], ...]] = set()
    for share in (98, 90, 75, 50):
        size = float(np.percentile(distance, share))
        bounds = _excursions(distance, is_slow, size)
        if bounds:
            size = float(np.median([distance[a : b + 1].max() for a, b in bounds]))
            bounds = _excursions(distance, is_slow, size)
        shortest = _SHORTEST_S * _RATE_HZ / 2
        bounds = [(a, b) for a, b in bounds if b - a >= shortest]
        if not bounds or size < _SMALLEST_MOVEMENT or tuple(bounds) in tried:
            continue
        tried.add(tuple(bounds))
        if len(bounds) == 1 and not _rests_around(speed, *bounds[0]):
            continue
        alike = _alike(features - posture, bounds, size)
        if not alike:
            continue
        covered = sum(travelled[b] - travelled[a] for a, b in (bounds[k] for k in alike))
        covered /= max(travelled[-1], 1e-9)
        score = len(alike) ** _COUNT_POWER * covered
        if covered >= _EXPLAINED and score > best.score:
            best = _Excursions(bounds, distance, float(score))
    return best


def _rests_around(speed: Float, start: int, end: int) -> bool:
    """Whether the arm rested right before and right after: a movement done once, not one of many."""
    slow = speed < 0.15 * speed[start : end + 1].max()
    needed = round(_SINGLE_REST_S * _RATE_HZ)
    before, after = _runs(slow[: start + 1]), _runs(slow[end:])
    return any(b - a >= needed and start + 1 - b <= 2 * needed for a, b in before) and any(
        b - a >= needed and a <= 2 * needed for a, b in after
    )


def _alike(offset: Float, bounds: list[tuple[int, int]], size: float) -> list[int]:
    """Return the largest set of excursions that resemble one of them; empty when nothing repeats.

    A single excursion has nothing to resemble; the caller asks for rest around it instead.
    """
    if len(bounds) == 1:
        return [0]
    shapes = [resample(np.arange(b - a + 1.0), offset[a : b + 1], _SHAPE_POINTS) / size for a, b in bounds]
    # Root of channels: `align` gives the difference per channel, likeness is about the whole distance.
    scale = np.full(offset.shape[1], 1.0 / np.sqrt(offset.shape[1]))
    near = np.eye(len(shapes), dtype=bool)
    for i in range(len(shapes)):
        for j in range(i + 1, min(len(shapes), i + 40)):
            near[i, j] = near[j, i] = align(shapes[i], shapes[j], scale, 0.25).rms < _ALIKE
    counts = near.sum(axis=1)
    medoid = int(np.argmax(counts))
    return [] if counts[medoid] < 2 else np.flatnonzero(near[medoid]).tolist()


def _sharpen(found: _Excursions, speed: Float) -> list[tuple[int, int]]:
    """Move the bounds outward to where the movement begins and ends."""
    bounds, distance = found.bounds, found.distance
    if not bounds:
        return []
    limits = [0]
    for (_, end), (start, _) in pairwise(bounds):
        limits.append(end + int(np.argmin(distance[end : start + 1])))
    limits.append(len(speed) - 1)
    usual = float(np.median([distance[a : b + 1].max() for a, b in bounds]))
    resting = distance < _NEAR * usual
    restless = float(np.median(speed[resting])) if np.any(resting) else 0.0
    sharp: list[tuple[int, int]] = []
    for number, (start, end) in enumerate(bounds):
        peak = float(speed[start : end + 1].max())
        onset = min(max(_ONSET_SHARE * peak, 1.5 * restless), 0.25 * peak)
        while start > limits[number] and speed[start] > onset:
            start -= 1
        while end < limits[number + 1] and speed[end] > onset:
            end += 1
        begins = _extrapolate(speed[start : end + 1], onset, peak)
        ends = _extrapolate(speed[start : end + 1][::-1], onset, peak)
        sharp.append((max(start - begins, limits[number]), min(end + ends, limits[number + 1])))
    return sharp


def _extrapolate(speed: Float, onset: float, peak: float) -> int:
    """How many samples before the onset threshold the movement began.

    Human movements begin with constant jerk, so speed grows with the square of time: its root is extended
    as a straight line, through the onset threshold and a higher one, down to zero. Never further than the
    rise between the two thresholds took.
    """
    high = max(0.3 * peak, 2.0 * onset)
    above = np.flatnonzero(speed > high)
    if not len(above) or onset <= 0:
        return 0
    rise = int(above[0])
    share = np.sqrt(onset) / (np.sqrt(high) - np.sqrt(onset))
    # Smoothing has already brought the crossing forward by about its own width.
    return max(0, int(np.rint(rise * min(1.0, float(share)) - _SMOOTHING_S * _RATE_HZ)))
