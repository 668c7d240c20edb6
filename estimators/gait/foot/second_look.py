"""A second look at stances: the slow middle of a long swing is none, off-line known from both sides."""

from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from estimators.gait._stance import runs
from estimators.recording import Float

Bool = NDArray[np.bool_]

_CONTRAST, _LEAST = 3.0, 0.3
_FIRM, _FIRM_FOR_S = 0.3, 0.2
_LONGEST_S: Final = 4.0
_MOVES_MPS: Final = 0.04


def doubtful_stances(statistic: Float, is_stance: Bool, time_s: Float) -> list[tuple[int, int]]:
    """Return stances between two that are far firmer, as half-open stretches of samples.

    Parameters
    ----------
    statistic : ndarray, shape (N,)
        T of the stance detector.
    is_stance : ndarray of bool, shape (N,)
    time_s : ndarray, shape (N,)

    Notes
    -----
    Own. A swing that takes longer than the detector looks around has a lowest T of its own, near 1 where the foot moves
    evenly at its fastest, and the foot stands with T near 0.1 before and after. In walking all stances are alike; a
    runner's have no firm one beside them.
    """
    found = runs(is_stance)
    least = [float(statistic[a:b].min()) for a, b in found]
    firm = [
        k for k, (a, b) in enumerate(found) if least[k] < _FIRM and time_s[b - 1] - time_s[a] > _FIRM_FOR_S
    ]
    doubtful = []
    for one, two in pairwise(firm):
        if time_s[found[two][0]] - time_s[found[one][1] - 1] > _LONGEST_S:
            continue
        beside = max(least[one], least[two])
        doubtful += [found[k] for k in range(one + 1, two) if least[k] > max(_CONTRAST * beside, _LEAST)]
    return doubtful


def stood(doubtful: list[tuple[int, int]], velocity_mps: Float) -> list[tuple[int, int]]:
    """Return those in which the foot stands although nobody said so any more: they are stances after all.

    Parameters
    ----------
    doubtful : list of (int, int)
    velocity_mps : ndarray, shape (N, 3)
        Smoothed without them.
    """
    speed = np.linalg.norm(velocity_mps, axis=1)
    return [(a, b) for a, b in doubtful if float(speed[a:b].min()) < _MOVES_MPS]
