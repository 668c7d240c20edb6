"""The cost of a long gap, added to ticks of which none is missing: `LostPlace.widen`, compiled, the same bits."""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from estimators.gait.foot import layout as at
from estimators.gait.foot import lost_places as lost
from estimators.gait.foot.trajectory import FootFlag
from estimators.kernels import step
from estimators.recording import Float

_RUN, _ALONG2, _UP2, _YAW2 = lost.RUN, lost.ALONG2, lost.UP2, lost.YAW2
_ORIGIN, _LOST, _MEAN, _TURNED = lost.ORIGIN, lost.LOST, lost.MEAN, lost.TURNED
_P, _PLACE, _HEADING = at.P, at.POSITION_SIGMA, at.POSITION_SIGMA + at.SIGMA_HEADING
_PLACE_LOST: Final = int(FootFlag.PLACE_LOST)
_UNKNOWN: Final = lost.YAW_UNKNOWN_RAD


@step()
def can_widen(memory: Float, first: int, count: int) -> bool:
    """Say whether no gap runs at some feet, `LostPlace.memory` of each."""
    runs = 0.0
    for s in range(first, first + count):
        runs += memory[s, _RUN]
    return runs == 0.0


@step()
def widen(memory: Float, first: int, values: Float, flags: NDArray[np.uint8]) -> None:
    """Add to what was released what a long gap before has cost, in place.

    Parameters
    ----------
    memory : ndarray, shape (N, MEMORY)
        Of `LostPlace`.
    first : int
        Row of the first of S feet.
    values : ndarray, shape (S, K, COLUMNS)
    flags : ndarray of uint8, shape (S, K)
    """
    for s in range(flags.shape[0]):
        m = memory[first + s]
        if m[_LOST] == 0.0:
            continue
        share = -2.0 * math.expm1(-0.5 * m[_YAW2])
        tx, ty = m[_TURNED] - m[_MEAN], m[_TURNED + 1] - m[_MEAN + 1]
        for k in range(flags.shape[1]):
            value = values[s, k]
            wx, wy = value[_P] - m[_ORIGIN], value[_P + 1] - m[_ORIGIN + 1]
            bent = 0.5 * (share * (wx * wx + wy * wy) + 2.0 * (wx * tx + wy * ty))
            for i in range(2):
                sigma = value[_PLACE + i]
                value[_PLACE + i] = math.sqrt(sigma * sigma + (m[_ALONG2] + bent))
            up, heading = value[_PLACE + 2], value[_HEADING]
            value[_PLACE + 2] = math.sqrt(up * up + m[_UP2])
            grown = math.sqrt(heading * heading + m[_YAW2])
            value[_HEADING] = _UNKNOWN if grown > _UNKNOWN else grown
            flags[s, k] |= _PLACE_LOST
