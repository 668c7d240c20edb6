"""Repetitions that were counted while they were made, with the bounds that the recording gives them."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from estimators.comparison._contract import Repetition

_SAME: Final = 0.7
"""Intersection over union from which a found repetition is the counted one."""


def counted_repetitions(counted: Sequence[Repetition], found: Sequence[Repetition]) -> list[Repetition]:
    """Give counted repetitions the bounds of those that were found afterwards, where these are the same.

    Parameters
    ----------
    counted : sequence of Repetition
        As they were counted live: which there are, and which of them count, is theirs to say. Live a movement is known
        to begin and to end only a few tenths of a second later.
    found : sequence of Repetition
        From the whole recording, as of `find_repetitions`.

    Returns
    -------
    list of Repetition
        As many as were counted, in their order.
    """
    bounds = []
    for one in counted:
        best = max(found, key=lambda other: _shared(one, other), default=None)
        is_same = best is not None and _shared(one, best) >= _SAME
        bounds.append(replace(one, start_s=best.start_s, end_s=best.end_s) if best and is_same else one)
    return bounds


def _shared(one: Repetition, other: Repetition) -> float:
    inside = min(one.end_s, other.end_s) - max(one.start_s, other.start_s)
    around = max(one.end_s, other.end_s) - min(one.start_s, other.start_s)
    return max(0.0, inside) / around if around > 0.0 else 0.0
