"""Finding repetitions in a recording without a threshold per person.

A repetition leaves a posture, goes somewhere and is back in that posture, and resembles the others. Which channels take
part, how far they go, how fast and from where is not given: `_cycles` finds what comes again, `_home` where it begins,
and here its bounds are moved to where the movement begins and ends. All thresholds are shares of the movement's own
size and speed. The only absolute numbers are what body-worn sensors can resolve.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from estimators.comparison._contract import Repetition, Trajectory
from estimators.comparison._posture import posture
from estimators.comparison.channels.sided import fill_gaps
from estimators.comparison.repetitions.cycles import Explanation, explain, explaining_once
from estimators.comparison.repetitions.home import at_home, most_likely, with_tries
from estimators.comparison.repetitions.path import Path, path_of, smoothed
from estimators.recording import Float

_RATE_HZ = 60.0
_SMALLEST_MOVEMENT = 0.05
"""Share of the reach (about 3 cm or 6 degrees) below which sensors cannot tell movement from drift."""
_SHORTEST_S = 0.25
_EXPLAINED = 0.4
"""Share of all movement that the repetitions must account for; random movement reaches a third."""
_ONSET_SHARE = 0.05
"""A repetition begins where speed exceeds this share of its own peak."""
_RESTLESS = 2.0
"""And this many times what it usually is at rest."""
_SETTING_OUT = 2.8


def find_repetitions(
    source: Trajectory, side: str, start_s: float | None = None, end_s: float | None = None
) -> list[Repetition]:
    """Find the repetitions of one movement, whichever it is.

    Parameters
    ----------
    side : {"left", "right"}
        The side that exercised: its arm or leg, with the trunk.
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
    if window is None or not window.valid.any():
        return []
    filled, _ = fill_gaps(posture(window, side))
    stride = max(1, int(1.0 / (_RATE_HZ * float(np.median(np.diff(window.time_s))))))
    time_s, filled = window.time_s[::stride], filled[::stride]
    if len(time_s) < 10:
        return []
    step_s = float(np.median(np.diff(time_s)))
    values, smoothing_s = smoothed(filled, step_s)
    path = path_of(values, step_s)
    if path is None or path.size < _SMALLEST_MOVEMENT:
        return []
    explaining = explaining_once(path)
    found = most_likely(explain(path, explaining), path, step_s, explaining)
    if found is None or found.covered < _EXPLAINED:
        return []
    speed = np.linalg.norm(np.gradient(values, step_s, axis=0), axis=1)
    bounds = _sharpen(_in_time(with_tries(found, path), path), speed, smoothing_s / step_s)
    return [
        Repetition(number=number, start_s=float(time_s[start]), end_s=float(time_s[end]))
        for number, (start, end) in enumerate(bounds, start=1)
        if (end - start) * step_s >= _SHORTEST_S
    ]


@dataclass(frozen=True)
class _Bounds:
    """Samples in which a repetition leaves home by one step of the path and is back to one step; and how far at most
    its true bounds lie outside of them.
    """

    start: int
    end: int
    before: int
    after: int


def _in_time(found: Explanation, path: Path) -> list[_Bounds]:
    place = np.append(path.place, path.last)
    return [
        _Bounds(
            int(place[c + 1]),
            int(np.ceil(place[d])),
            # The stay reaches two steps of the path from home: a movement with least jerk takes 2.8 times as long for
            # its first two steps as for the next three.
            # Who goes through home without a stay does not set out.
            int(
                _SETTING_OUT * (place[c + 4] - place[c + 1])
                if path.is_stay(b, c)
                else place[c + 1] - place[c]
            ),
            int(_SETTING_OUT * (place[d] - place[d - 3]) if path.is_stay(d, e) else place[d + 1] - place[d]),
        )
        for (b, c), (d, e) in at_home(found, path).tolist()
        if d - c > 4
    ]


def _window(source: Trajectory, start_s: float | None, end_s: float | None) -> Trajectory | None:
    if start_s is None and end_s is None:
        return source if len(source.time_s) >= 2 else None
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


def _sharpen(bounds: list[_Bounds], speed: Float, smoothing: float) -> list[tuple[int, int]]:
    """Move the bounds outward to where the movement begins and ends."""
    middles = [(one.end + following.start) // 2 for one, following in pairwise(bounds)]
    limits = [0, *middles, len(speed) - 1]
    resting = np.ones(len(speed), dtype=bool)
    for one in bounds:
        resting[max(one.start - one.before, 0) : one.end + one.after] = False
    if not resting.any():
        # No rest is longer than a movement takes to set out: the calmest tenth is what is left of it.
        for one in bounds:
            resting[one.start : one.end] = True
        resting = ~resting
        restless = _RESTLESS * float(np.percentile(speed[resting], 10)) if resting.any() else 0.0
    else:
        restless = _RESTLESS * float(np.median(speed[resting]))
    sharp: list[tuple[int, int]] = []
    for number, one in enumerate(bounds):
        start, end = one.start, one.end
        first, last = max(limits[number], start - one.before), min(limits[number + 1], end + one.after)
        peak = float(speed[start : end + 1].max())
        onset = min(max(_ONSET_SHARE * peak, restless), 0.25 * peak)
        start -= _way_to_rest(speed[first : start + 1][::-1], onset)
        end += _way_to_rest(speed[end : last + 1], onset)
        begins = _extrapolate(speed[start : end + 1], onset, peak, smoothing)
        ends = _extrapolate(speed[start : end + 1][::-1], onset, peak, smoothing)
        sharp.append((max(start - begins, first), min(end + ends, last)))
    return sharp


def _way_to_rest(speed: Float, onset: float) -> int:
    """How many samples it takes to come to rest; where nobody does, to be slowest."""
    slow = np.flatnonzero(speed <= onset)
    return int(slow[0]) if len(slow) else int(np.argmin(speed)) if len(speed) else 0


def _extrapolate(speed: Float, onset: float, peak: float, smoothing: float) -> int:
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
    return max(0, int(np.rint(rise * min(1.0, float(share)) - smoothing)))
