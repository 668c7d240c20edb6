"""Whether the first field that our own filter met in movement was a magnet's: another one lasts longer."""

import math

from estimators._kernels import wrapped
from estimators.kernels import Record, borrowing
from estimators.orientation.telemotion._start import SAME_FIELD

_ESTABLISHED_S = 20.0
"""A field that has fitted for so long is the room's: what then differs from it is a disturbance."""
_LEAST_S = 3.0


@borrowing()
def outlasted(memory: Record, time_s: float, rest: bool) -> bool:
    """Weigh the block's field for the first one or for another; say whether the other has now lasted longer.

    At rest a field says nothing new. A start at rest is judged by its own hypotheses (`find_north`).
    """
    if memory.start_moving == 0.0 or memory.support_s >= _ESTABLISHED_S or rest:
        return False
    if 2 * memory.field_count < memory.count:
        return False
    known = first = other = 0.0
    for a in range(3):
        seen = memory.sum_field[a] / memory.field_count
        known += memory.field[a] ** 2
        first += (seen - memory.field[a] - memory.start_share * memory.start[a]) ** 2
        other += (seen - memory.other[a]) ** 2
    limit = SAME_FIELD * SAME_FIELD * known
    if first <= limit:
        memory.support_s += time_s
        memory.other_s = max(memory.other_s - time_s, 0.0)
        return False
    if memory.other_s > 0.0 and other > limit:
        memory.other_s = max(memory.other_s - time_s, 0.0)
        return False
    memory.other_s += time_s
    for a in range(3):
        seen = memory.sum_field[a] / memory.field_count
        memory.other[a] += time_s / memory.other_s * (seen - memory.other[a])
    if memory.other_s <= max(memory.support_s, _LEAST_S):
        return False
    memory.support_s, memory.other_s = memory.other_s, 0.0
    return True


@borrowing()
def doubt(memory: Record) -> float:
    """Return what the other field adds to the variance of the heading: its odds are the share of time it had."""
    if memory.other_s == 0.0 or memory.start_moving == 0.0 or memory.support_s >= _ESTABLISHED_S:
        return 0.0
    apart = wrapped(
        math.atan2(memory.other[0], memory.other[1]) - math.atan2(memory.field[0], memory.field[1])
    )
    share = memory.other_s / (memory.other_s + memory.support_s)
    return float(share * apart * apart)
