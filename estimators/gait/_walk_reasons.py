"""What the numbers of a walk leave out and why, in plain sentences."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from estimators.conventions import Side
from estimators.gait._stride_flags import StrideFlag
from estimators.gait._strides import Strides
from estimators.sentences import say

_LONGEST_M, _FASTEST_MPS, _RISE_M, _APART_M = 3.0, 5.0, 2.0, 0.3


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
            reasons.append(say("walk.no_stride", side=side))
            continue
        if turning[side].any() and not counted[side].any():
            length = float(np.mean(strides.length_m[turning[side]]))
            time_s = float(np.nanmean(strides.duration_s[turning[side]]))
            count = int(np.count_nonzero(turning[side]))
            reasons.append(say("walk.only_turns", side=side, count=count, length_m=length, duration_s=time_s))
        elif not counted[side].any():
            reasons.append(say("walk.no_straight_stride", side=side))
        reasons.extend(_missing(side, strides))
        aloft = (strides.flags & StrideFlag.ALOFT) != 0
        if aloft.any():
            away_s = (strides.footholds.start_s[1:] - strides.footholds.stop_s[:-1])[aloft].sum()
            reasons.append(say("walk.aloft", side=side, away_s=away_s))
        is_long = (strides.flags & StrideFlag.LONG) != 0
        if is_long.any():
            count = int(np.count_nonzero(is_long))
            reasons.append(say("walk.long_strides", side=side, count=count))
        aside = int(np.count_nonzero(strides.flags & StrideFlag.SIDEWAYS))
        if aside:
            reasons.append(say("walk.sideways", side=side, count=aside))
        reasons.extend(_unlikely(side, strides, counted[side]))
    reasons.extend(_heights(feet))
    if set(feet) != {"left", "right"}:
        reasons.append(say("walk.one_foot"))
    return reasons


def _missing(side: Side, strides: Strides) -> list[str]:
    lost = (strides.flags & StrideFlag.MISSING) != 0
    if not lost.any():
        return []
    count = int(np.count_nonzero(lost))
    return [say("walk.missing", side=side, count=count, missing_s=strides.missing_s.sum())]


def _unlikely(side: Side, strides: Strides, counted: NDArray[np.bool_]) -> list[str]:
    """Say what no walk can be: then units, axes or the sampling rate are not what they were taken for."""
    if not counted.any():
        return []
    length = float(np.median(strides.length_m[counted]))
    timed = counted & np.isfinite(strides.duration_s)
    speed = float(np.median(strides.length_m[timed] / strides.duration_s[timed])) if timed.any() else 0.0
    if length > _LONGEST_M:
        return [say("walk.too_long", side=side, length_m=length)]
    if speed > _FASTEST_MPS:
        return [say("walk.too_fast", side=side, speed_mps=speed)]
    return []


def _heights(feet: Mapping[Side, Strides]) -> list[str]:
    """Compare where the feet ended with where they began; on stairs both go alike."""
    rises = {
        side: float(strides.footholds.position_m[-1, 2] - strides.footholds.position_m[0, 2])
        for side, strides in feet.items()
        if strides.count and not (strides.flags & (StrideFlag.MISSING | StrideFlag.ALOFT)).any()
    }
    if len(rises) == 2 and abs(rises["left"] - rises["right"]) > _APART_M:
        return [say("walk.rises_apart", left_m=rises["left"], right_m=rises["right"])]
    if len(feet) == 1:
        return [
            say("walk.ended_above", side=side, rise_m=rise)
            if rise > 0.0
            else say("walk.ended_below", side=side, rise_m=-rise)
            for side, rise in rises.items()
            if abs(rise) > _RISE_M
        ]
    return []


__all__ = ["walk_reasons"]
