"""Whether the first field that our own filter met in movement was a magnet's: another one lasts longer."""

import math

import numpy as np
from numpy.typing import NDArray

from estimators._kernels import kernel, wrapped
from estimators.orientation.telemotion._layout import (
    COUNT,
    FIELD,
    FIELD_COUNT,
    OTHER,
    OTHER_S,
    START,
    START_MOVING,
    START_SHARE,
    SUM_FIELD,
    SUPPORT_S,
)
from estimators.orientation.telemotion._start import SAME_FIELD
from estimators.recording import Float

_ESTABLISHED_S = 20.0
"""A field that has fitted for so long is the room's: what then differs from it is a disturbance."""
_LEAST_S = 3.0


@kernel("boolean(float64[::1], int64[::1], float64, boolean)")
def outlasted(memory: Float, counts: NDArray[np.int64], time_s: float, rest: bool) -> bool:
    """Weigh the block's field for the first one or for another; say whether the other has now lasted longer.

    At rest a field says nothing new. A start at rest is judged by its own hypotheses (`find_north`).
    """
    if memory[START_MOVING] == 0.0 or memory[SUPPORT_S] >= _ESTABLISHED_S or rest:
        return False
    if 2 * counts[FIELD_COUNT] < counts[COUNT]:
        return False
    known = first = other = 0.0
    for a in range(3):
        seen = memory[SUM_FIELD + a] / counts[FIELD_COUNT]
        known += memory[FIELD + a] ** 2
        first += (seen - memory[FIELD + a] - memory[START_SHARE] * memory[START + a]) ** 2
        other += (seen - memory[OTHER + a]) ** 2
    limit = SAME_FIELD * SAME_FIELD * known
    if first <= limit:
        memory[SUPPORT_S] += time_s
        memory[OTHER_S] = max(memory[OTHER_S] - time_s, 0.0)
        return False
    if memory[OTHER_S] > 0.0 and other > limit:
        memory[OTHER_S] = max(memory[OTHER_S] - time_s, 0.0)
        return False
    memory[OTHER_S] += time_s
    for a in range(3):
        seen = memory[SUM_FIELD + a] / counts[FIELD_COUNT]
        memory[OTHER + a] += time_s / memory[OTHER_S] * (seen - memory[OTHER + a])
    if memory[OTHER_S] <= max(memory[SUPPORT_S], _LEAST_S):
        return False
    memory[SUPPORT_S], memory[OTHER_S] = memory[OTHER_S], 0.0
    return True


@kernel("float64(float64[::1])")
def doubt(memory: Float) -> float:
    """Return what the other field adds to the variance of the heading: its odds are the share of time it had."""
    if memory[OTHER_S] == 0.0 or memory[START_MOVING] == 0.0 or memory[SUPPORT_S] >= _ESTABLISHED_S:
        return 0.0
    apart = wrapped(
        math.atan2(memory[OTHER], memory[OTHER + 1]) - math.atan2(memory[FIELD], memory[FIELD + 1])
    )
    share = memory[OTHER_S] / (memory[OTHER_S] + memory[SUPPORT_S])
    return float(share * apart * apart)


__all__ = ["doubt", "outlasted"]
