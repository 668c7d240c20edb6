"""A foot that is carried: that is no walking on two feet."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

import numpy as np

from estimators.conventions import Side
from estimators.gait._stride_flags import StrideFlag
from estimators.gait._strides import Strides

_LEAST_STRIDES, _LEAST_ALOFT, _SHARE, _OVERLAP = 3, 2, 0.6, 0.5
_ABOVE_M, _AT_ONCE = 0.05, 0.7
_PAIRS: Final[tuple[tuple[Side, Side], ...]] = (("left", "right"), ("right", "left"))


def carried_foot(feet: Mapping[Side, Strides]) -> Side | None:
    """Return the foot that did not stand while the other walked; None where both did, or with one foot.

    Notes
    -----
    Own. Between crutches one foot is in the air: it moves for long without standing while the other makes strides,
    or it is still between hops, but then it goes when the other goes, and higher than that.
    """
    if set(feet) != {"left", "right"}:
        return None
    for side, other in _PAIRS:
        if feet[side].is_carried:
            return side
        if _is_aloft(feet[side], feet[other]):
            return side
    if not _go_together(feet):
        return None
    above_m = _height(feet["left"]) - _height(feet["right"])
    if abs(above_m) < _ABOVE_M:
        return None
    return "left" if above_m > 0.0 else "right"


def without_carried(feet: Mapping[Side, Strides]) -> dict[Side, Strides]:
    """Return both feet, the strides of a carried one marked as none."""
    found, side = dict(feet), carried_foot(feet)
    if side is not None:
        foot = found[side]
        found[side] = replace(
            foot, is_carried=True, flags=np.asarray(foot.flags | StrideFlag.ALOFT, np.uint8)
        )
    return found


def _go_together(feet: Mapping[Side, Strides]) -> bool:
    """Say whether both feet swing at the same time."""
    if any(foot.has(StrideFlag.MISSING).any() for foot in feet.values()):
        return False
    left, right = ((foot.toe_off_s[foot.is_inside], foot.contact_s[foot.is_inside]) for foot in feet.values())
    if min(len(left[0]), len(right[0])) < _LEAST_STRIDES:
        return False
    both = np.minimum(left[1][:, None], right[1]) - np.maximum(left[0][:, None], right[0])
    shorter = np.minimum((left[1] - left[0])[:, None], right[1] - right[0])
    shared = (both > _OVERLAP * shorter).any(axis=1)
    return float(np.mean(shared)) >= _SHARE


def _is_aloft(one: Strides, other: Strides) -> bool:
    aloft = one.has(StrideFlag.ALOFT)
    starts, stops = one.footholds.stop_s[:-1][aloft], one.footholds.start_s[1:][aloft]
    within = (other.toe_off_s[:, None] >= starts) & (other.contact_s[:, None] <= stops)
    return int(np.count_nonzero(within.any(axis=1) & other.is_inside)) >= _LEAST_ALOFT


def _height(foot: Strides) -> float:
    """Return how high a foot rested on its way over where it began, m; 0 unless it was lifted at once."""
    height_m = foot.footholds.position_m[:, 2] - foot.footholds.position_m[0, 2]
    if len(height_m) < _LEAST_STRIDES:
        return 0.0
    usual = float(np.median(height_m[1:-1]))
    # What drifts comes little by little.
    return usual if height_m[1] > _AT_ONCE * usual else 0.0
