"""Whether a template's own repetitions stay inside its band."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from estimators.comparison._alignment import apply
from estimators.comparison._contract import PHASES, Template
from estimators.comparison._template import align_timing, alignment_scale, near
from estimators.recording import Float

_LEAST: Final = 3
"""Phases of 101 outside the band from which on a repetition leaves it."""


def leaves_band(template: Template, repetitions: Sequence[Float]) -> list[tuple[int, float]]:
    """Return for each channel how many repetitions leave the band, and by how much at most, rad or m.

    Parameters
    ----------
    template : Template
        With the band in question.
    repetitions : sequence of ndarray, shape (101, C)
        In the template's channels; aligned in time here, as those of a patient are.
    """
    scale = alignment_scale(template.channels, template.tolerance)
    beyond = []
    for curve in repetitions:
        moved = near(curve, template.mean, template.channels)
        # Without a channel that tells the timing there is nothing to align by.
        aligned = (
            apply(align_timing(moved, template.mean, scale), moved, PHASES)
            if np.isfinite(scale).any()
            else moved
        )
        off = aligned - template.mean
        beyond.append(np.nan_to_num(np.maximum(off - template.above, -off - template.below), nan=-np.inf))
    found = np.array(beyond).reshape(len(repetitions), PHASES, len(template.channels))
    left = (found > 0.0).sum(axis=1) >= _LEAST
    most = found.max(axis=(0, 1), initial=0.0)
    return [(int(left[:, column].sum()), float(most[column])) for column in range(len(template.channels))]
