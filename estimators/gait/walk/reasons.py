"""Reasons why the numbers of a walk leave strides out, in plain sentences."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from estimators.conventions import Side
from estimators.gait._stride_flags import StrideFlag
from estimators.gait._strides import Strides
from estimators.gait.walk.carried import carried_foot
from estimators.gait.walk.measured import Measure
from estimators.sentences import say

_INWARD_RAD, _INWARD_MEAN_RAD = np.deg2rad(3.0), np.deg2rad(5.0)
_LOST_STRIDES, _LOST_SHARE = 2, 0.03
_LONGEST_M, _FASTEST_MPS, _RISE_M, _APART_M = 3.0, 5.0, 2.0, 0.3


def walk_reasons(
    feet: Mapping[Side, Strides],
    counted: Mapping[Side, NDArray[np.bool_]],
    turning: Mapping[Side, NDArray[np.bool_]],
    toe_out: Mapping[Side, Measure],
) -> list[str]:
    """Return what a reader of the numbers must know.

    Parameters
    ----------
    counted, turning : mapping of Side to ndarray of bool, shape (n,)
        Strides that are averaged, and continuous ones along turns.
    toe_out : mapping of Side to Measure
        How far the feet point outward.
    """
    reasons: list[str] = []
    carried = carried_foot(feet)
    for side, strides in feet.items():
        if side == carried:
            continue
        if not strides.is_inside.any():
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
        aloft = strides.has(StrideFlag.ALOFT)
        if aloft.any():
            away_s = (strides.footholds.start_s[1:] - strides.footholds.stop_s[:-1])[aloft].sum()
            reasons.append(say("walk.aloft", side=side, away_s=away_s))
        is_long = strides.has(StrideFlag.LONG)
        if is_long.any():
            count = int(np.count_nonzero(is_long))
            reasons.append(say("walk.long_strides", side=side, count=count))
        aside = int(np.count_nonzero(strides.has(StrideFlag.SIDEWAYS)))
        if aside:
            reasons.append(say("walk.sideways", side=side, count=aside))
        if strides.is_trembling:
            reasons.append(say("walk.trembling", side=side))
        reasons.extend(_unlikely(side, strides, counted[side]))
    rolled_s = min((strides.rolled_s for strides in feet.values()), default=0.0)
    if rolled_s > 0.0:
        reasons.append(say("walk.rolled", moved_s=rolled_s))
    if any(strides.is_backward for strides in feet.values()):
        reasons.append(say("walk.backward"))
    reasons.extend(_between(feet, carried))
    reasons.extend(_inward(toe_out))
    reasons.extend(_heights(feet))
    if set(feet) != {"left", "right"}:
        reasons.append(say("walk.one_foot"))
    return reasons


def _missing(side: Side, strides: Strides) -> list[str]:
    lost = strides.has(StrideFlag.MISSING)
    if not lost.any():
        return []
    count = int(np.count_nonzero(lost))
    return [say("walk.missing", side=side, count=count, missing_s=strides.missing_s[lost].sum())]


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


def _between(feet: Mapping[Side, Strides], carried: Side | None) -> list[str]:
    """Say what two feet that walk in turn cannot do."""
    if carried is not None:
        return [say("walk.carried", side=carried)]
    if set(feet) != {"left", "right"} or any(
        strides.has(StrideFlag.MISSING).any() for strides in feet.values()
    ):
        return []
    counts = {side: int(np.count_nonzero(strides.is_inside)) for side, strides in feet.items()}
    apart = abs(counts["left"] - counts["right"])
    if apart >= max(_LOST_STRIDES, _LOST_SHARE * max(counts.values())):
        return [say("walk.counts_apart", left=counts["left"], right=counts["right"])]
    return []


def _inward(toe_out: Mapping[Side, Measure]) -> list[str]:
    """Ask whether the shoes are exchanged: hardly anybody turns both feet inward, and exchanged shoes do.

    Own. Healthy adults point their feet 5 to 7 degrees outward, with a standard deviation of 5 to 6 between people
    (Murray, Drought, Kory. Walking patterns of normal men. J Bone Joint Surg 46-A (1964) 335-360).
    """
    if set(toe_out) != {"left", "right"}:
        return []
    left, right = toe_out["left"].value, toe_out["right"].value
    if max(left, right) < -_INWARD_RAD and 0.5 * (left + right) < -_INWARD_MEAN_RAD:
        return [say("walk.exchanged", left_rad=-left, right_rad=-right)]
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
