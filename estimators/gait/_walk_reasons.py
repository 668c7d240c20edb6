"""What the numbers of a walk leave out and why, in plain sentences."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from estimators.conventions import Side
from estimators.gait._stride_flags import StrideFlag
from estimators.gait._strides import Strides

_LONGEST_M, _FASTEST_MPS, _RISE_M, _APART_M = 3.0, 5.0, 2.0, 0.3
_CHECK = "check the units, the axes and the sampling rate of the recording"


def walk_reasons(
    feet: Mapping[Side, Strides],
    counted: Mapping[Side, NDArray[np.bool_]],
    turning: Mapping[Side, NDArray[np.bool_]],
) -> list[str]:
    """Return what a reader of the numbers must know.

    Parameters
    ----------
    feet : mapping of Side to Strides
    counted, turning : mapping of Side to ndarray of bool, shape (n,)
        Strides that are averaged, and continuous ones along turns.
    """
    reasons: list[str] = []
    for side, strides in feet.items():
        if strides.count == 0:
            reasons.append(
                f"{side} foot: no stride found; it never stood between its movements, or never left the ground"
            )
            continue
        if turning[side].any() and not counted[side].any():
            length = float(np.mean(strides.length_m[turning[side]]))
            time_s = float(np.nanmean(strides.duration_s[turning[side]]))
            reasons.append(
                f"{side} foot: every stride turns, none is straight; over {_strides(turning[side].sum(), 'one stride')}"
                f" in turns it goes {length:.2f} m in {time_s:.2f} s. Walk a straight stretch of at least four strides"
            )
        elif not counted[side].any():
            reasons.append(
                f"{side} foot: no stride of continuous straight walking; walk at least four strides"
            )
        reasons.extend(_missing(side, strides))
        aloft = (strides.flags & StrideFlag.ALOFT) != 0
        if aloft.any():
            away_s = (strides.footholds.start_s[1:] - strides.footholds.stop_s[:-1])[aloft].sum()
            reasons.append(
                f"{side} foot: for {away_s:.0f} s it moved without standing as in walking; that is left out"
            )
        is_long = (strides.flags & StrideFlag.LONG) != 0
        if is_long.any():
            count = int(np.count_nonzero(is_long))
            reasons.append(
                f"{side} foot: {_strides(count, 'a stride')} took far longer than those around and"
                f" {'is' if count == 1 else 'are'} left out: a halt, or two strides taken for one"
            )
        aside = int(np.count_nonzero(strides.flags & StrideFlag.SIDEWAYS))
        if aside:
            reasons.append(
                f"{side} foot: {_strides(aside, 'a stride')} went sideways or back and"
                f" {'is' if aside == 1 else 'are'} left out"
            )
        reasons.extend(_unlikely(side, strides, counted[side]))
    reasons.extend(_heights(feet))
    if set(feet) != {"left", "right"}:
        reasons.append("one foot only: no double support and no asymmetry")
    return reasons


def _missing(side: Side, strides: Strides) -> list[str]:
    lost = (strides.flags & StrideFlag.MISSING) != 0
    if not lost.any():
        return []
    count = int(np.count_nonzero(lost))
    return [
        f"{side} foot: {strides.missing_s.sum():.1f} s of samples are missing; the {_strides(count)} there"
        f" {'is' if count == 1 else 'are'} left out of the averages"
    ]


def _unlikely(side: Side, strides: Strides, counted: NDArray[np.bool_]) -> list[str]:
    """Say what no walk can be: then units, axes or the sampling rate are not what they were taken for."""
    if not counted.any():
        return []
    length = float(np.median(strides.length_m[counted]))
    timed = counted & np.isfinite(strides.duration_s)
    speed = float(np.median(strides.length_m[timed] / strides.duration_s[timed])) if timed.any() else 0.0
    if length > _LONGEST_M:
        what = f"strides of {length:.1f} m are longer than anybody's who walks"
    elif speed > _FASTEST_MPS:
        what = f"{speed:.1f} m/s is faster than anybody walks"
    else:
        return []
    return [f"{side} foot: {what}; {_CHECK}"]


def _heights(feet: Mapping[Side, Strides]) -> list[str]:
    """Compare where the feet ended with where they began; on stairs both go alike."""
    rises = {
        side: float(strides.footholds.position_m[-1, 2] - strides.footholds.position_m[0, 2])
        for side, strides in feet.items()
        if strides.count and not (strides.flags & (StrideFlag.MISSING | StrideFlag.ALOFT)).any()
    }
    if len(rises) == 2 and abs(rises["left"] - rises["right"]) > _APART_M:
        return [
            f"from start to end the left foot rose by {rises['left']:.2f} m and the right foot by"
            f" {rises['right']:.2f} m, which one person cannot; do not trust heights, and {_CHECK}"
        ]
    if len(feet) == 1:
        return [
            f"{side} foot: it ended {abs(rise):.1f} m {'above' if rise > 0.0 else 'below'} where it began; unless"
            f" there were stairs, {_CHECK}"
            for side, rise in rises.items()
            if abs(rise) > _RISE_M
        ]
    return []


def _strides(count: int | np.int64, one: str = "stride") -> str:
    return one if count == 1 else f"{count} strides"


__all__ = ["walk_reasons"]
