"""What the numbers of a walk leave out and why, in plain sentences."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from estimators.conventions import Side
from estimators.gait._stride_flags import StrideFlag
from estimators.gait._strides import Strides


def walk_reasons(feet: Mapping[Side, Strides], counted: Mapping[Side, NDArray[np.bool_]]) -> list[str]:
    """Return what a reader of the numbers must know.

    Parameters
    ----------
    feet : mapping of Side to Strides
    counted : mapping of Side to ndarray of bool, shape (n,)
        Strides that are averaged.
    """
    reasons: list[str] = []
    for side, strides in feet.items():
        if strides.count == 0:
            reasons.append(
                f"{side} foot: no stride found; it never stood between its movements, or never left the ground"
            )
            continue
        if not counted[side].any():
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


def _strides(count: int) -> str:
    return "stride" if count == 1 else f"{count} strides"


__all__ = ["walk_reasons"]
